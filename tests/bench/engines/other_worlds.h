/// Worlds of bricks in physics engines that the program does not use. Nothing collides in them. In
/// the plane they leave out a pivot on a brick's upper face: it has the same place as the one
/// below.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/engines/brick_world.h"
#include "sim/scene/scene.h"

namespace kirireel::bench {

/// Bricks that slide in a horizontal plane in Chipmunk's space, each hinge one pivot joint; heights
/// and tilts stay as they start. `iterations` of the solver in each step; the environment gives
/// gravity along x and y and the damping of all velocities (its linear one). `start` holds one pose
/// a brick. Steps may have any length.
std::unique_ptr<engines::BrickWorld> makeChipmunkWorld(const std::vector<brick::Brick>& bricks,
                                                       const Poses& start,
                                                       std::span<const brick::Pivot> pivots,
                                                       const scene::Environment& environment,
                                                       int iterations);

/// The same in Box2D's world of single precision, with revolute joints. `iterations` of its solver
/// for velocities, and `corrections` of that for positions, in each step.
std::unique_ptr<engines::BrickWorld> makeBox2dWorld(const std::vector<brick::Brick>& bricks,
                                                    const Poses& start,
                                                    std::span<const brick::Pivot> pivots,
                                                    const scene::Environment& environment,
                                                    int iterations, int corrections);

/// Bricks in MuJoCo's joint coordinates: hinges that span all bricks as a tree are its joints, the
/// others are constraints that its Newton solver keeps. In the plane bricks have three degrees of
/// freedom, else hinges of two pivots turn about one axis and single pivots are balls. Motions that
/// are written must be the start's poses with any velocities, or the motion read last. Throws
/// std::runtime_error for bricks that MuJoCo cannot have. Costs MuJoCo's compilation of a model
/// with all bricks, and steps with a dense Newton solve over all joint coordinates that loops
/// touch.
std::unique_ptr<engines::BrickWorld> makeMujocoWorld(const std::vector<brick::Brick>& bricks,
                                                     const Poses& start,
                                                     std::span<const brick::Pivot> pivots,
                                                     const scene::Environment& environment,
                                                     bool planar);

/// The version of Chipmunk, as "7.0.3".
std::string chipmunkVersion();
/// The version of Box2D, as "2.4.1".
std::string box2dVersion();
/// The version of MuJoCo, as "2.2.2".
std::string mujocoVersion();

}  // namespace kirireel::bench
