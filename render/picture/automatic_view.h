/// The view that shows most of a motion, for pictures whose camera nobody has placed.
#pragma once

#include <span>
#include <vector>

#include "render/picture/camera.h"
#include "sim/model/model.h"

namespace kirireel::picture {

/// A direction of the camera, chosen for a motion.
struct AutomaticView {
  ViewAngles angles;
  bool isFlat = false;  ///< whether all states lie in one layer, seen along its normal

  bool operator==(const AutomaticView&) const = default;
};

/// The view that shows most of the tiles in all states together, fronts before backs. The first
/// state is upright in it. The same for tiles at other positions, units, orders and numbers.
/// states: one list of tiles each, at least one state and one tile; corners are anticlockwise seen
/// from the front. zIsUp: a ground makes z the upward direction of the picture, and hides what is
/// seen from below; else a flat first state is laid down first. Takes about 0.1 s. Throws
/// Interrupted when the user ends the program.
AutomaticView chooseView(std::span<const std::vector<model::Tile>> states, bool zIsUp);

}  // namespace kirireel::picture
