/// A scene whose tiles stretch and bend, as a sheet of bars and hinges that grips load.
#pragma once

#include <memory>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/equilibrium/equilibrium.h"
#include "sim/equilibrium/loaded_sheet.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// One direction of a grip of the scene.
struct GripOrder {
  const GripSetting* setting = nullptr;
  Vector3 direction = Vector3::UnitX();  ///< unit; zero for a turn
  double amount = 0;                     ///< at the load 1, see Grip
  GripName name;
};

/// The sheet of a scene with panels. Corners that joints hold together are one node, whichever face
/// they lie on; tiles with more than three corners bend about the diagonals of tileTriangles().
/// Folds have the stiffness and rest angle of their springs, or where no hinge has one that of
/// foldStiffness(), at rest at the start. Throws InputError for joints on both faces, fixed tiles,
/// springs at hinges that are no common edge of two tiles, and grips that turn.
std::unique_ptr<LoadedSheet> makeBarHingeSheet(const Scene& scene, const std::vector<Brick>& bricks,
                                               const std::vector<HingeSpring>& springs,
                                               const std::vector<int>& pinned,
                                               const std::vector<GripOrder>& grips);

}  // namespace kirireel
