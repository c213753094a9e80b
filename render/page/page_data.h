/// What a page knows of a run, as JSON.
#pragma once

#include <string>

#include "render/page/packed_array.h"
#include "render/studio/look.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// How much of a run a page gets.
struct PageStates {
  int samples = 201;   ///< at equal steps of motion, at least 2; 0 for all that the run has
  bool exact = false;  ///< poses as doubles; else to a fraction of a pixel
};

/// The colours, lights, lines and lengths of our pictures for a theme, from render/picture. For the
/// theme that is given, whatever the look's own.
Json styleJson(Theme theme, const Look& look);

/// The shades [bottom, top, side] of bricks whose colours stand for values, from the least to the
/// largest in equal steps.
Json mapJson(ColourMap map);

/// One run: bricks, poses, joints, measures, target, surroundings and cameras. See stage.js, which
/// reads it. Throws InputError when the look asks for what the run lacks. Reads the trajectory once
/// for the states, once for the curves. `states.samples` of a thousand bricks take 14 kB each
/// before they are compressed.
Json runJson(const TrajectoryReader& run, const Look& look, const PageStates& states);

/// Three pictures of the run side by side, at the start, half way and at the end: a PNG file.
/// Throws OutputError where nothing can be painted.
std::string stillPicture(const TrajectoryReader& run, const Look& look);

}  // namespace kirireel
