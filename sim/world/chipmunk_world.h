/// Chipmunk's planar world with pivot joints: a baseline that a build may lack. No Chipmunk header
/// is needed to use it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/scene/scene.h"
#include "sim/world/brick_world.h"

namespace kirireel {

/// Bricks that slide in a horizontal plane, each hinge one pivot joint; heights and tilts stay as
/// they start. Nothing collides. `iterations` of the solver in each step; the environment gives
/// gravity along x and y and the damping of all velocities (its linear one). Null where this
/// program was built without Chipmunk.
std::unique_ptr<BrickWorld> makeChipmunkWorld(const std::vector<Brick>& bricks, const Poses& start,
                                              std::span<const Pivot> pivots,
                                              const Environment& environment, int iterations);

/// The version of Chipmunk in use, e.g. "7.0.3"; empty where this program was built without it.
std::string chipmunkVersion();

}  // namespace kirireel
