/// A sheet whose motion is known in closed form: squares that open from 0 to 90 degrees.
#pragma once

#include <vector>

#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/exact_motion.h"

namespace kirireel::study {

/// A square sheet of side x side tiles, without contacts. `startAngle`: opening at the start,
/// radians. Joints on both faces are hinges, i.e. two point joints each for engines. On the bottom
/// only they are one. Tiles are 1 m wide; the target is the sheet opened to 90 degrees.
scene::Scene sheetScene(int side, bool planar, model::JointFace face = model::JointFace::Both,
                        double startAngle = 0);

/// The angle between the first two tiles of a sheet, radians, >= 0.
double openingAngle(const Poses& poses);

/// The states of a sheet over time, at equal intervals.
using SheetPath = std::vector<std::vector<model::Tile>>;

/// The limit of first-order steps for a step length of 0. Their error is a power series in the
/// step. Results for steps of h, h / 2 and h / 4 give the limit up to the third order. All three
/// have states at the same times.
SheetPath limitOfSteps(const SheetPath& coarse, const SheetPath& middle, const SheetPath& fine);

/// The largest distance of a vertex between two motions at the same time, metres.
double pathError(const SheetPath& found, const SheetPath& desired);

/// The distance from the exact sheet at the same opening angle, after the best rigid motion.
trajectory::VertexDistance sheetError(int side, double angle,
                                      const std::vector<model::Tile>& found);

}  // namespace kirireel::study
