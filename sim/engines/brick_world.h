/// Physics engines as worlds of bricks.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/scene/scene.h"

namespace kirireel::engines {

// ------------------------------------------------------------------------------------------------
// What a physics engine's world does with bricks: the seam between a deployment and the engines
// that hold joints by impulses.

/// Bricks in the hands of a physics engine.
class BrickWorld {
 public:
  virtual ~BrickWorld() = default;

  /// Adds a force at the centre of mass and a torque, world axes, for the next step alone.
  /// Newtons and newton metres. Loads of several calls for one brick add up, but in Chipmunk's
  /// world, which keeps the last one.
  virtual void applyLoad(int brick, const Vector3& force, const Vector3& torque) = 0;

  /// Advances by exactly `step` seconds, one internal step.
  /// `step` is positive.
  virtual void advance(double step) = 0;

  /// Reads the poses and velocities of all bricks.
  /// `motion` has to hold as many poses and velocities as there are bricks.
  virtual void readMotion(Motion& motion) const = 0;

  /// Sets the poses and velocities of all bricks.
  virtual void writeMotion(const Motion& motion) = 0;
};

// ------------------------------------------------------------------------------------------------
// Physics engines that studies compare with and that a build may lack: none of their headers is
// needed to use them. Nothing collides in their worlds. A pivot on a brick's upper face is left
// out in the plane, where both are one.

/// Bricks that slide in a horizontal plane in Chipmunk's space, each hinge one pivot joint; heights
/// and tilts stay as they start. `iterations` of the solver in each step; the environment gives
/// gravity along x and y and the damping of all velocities (its linear one). Null where this
/// program was built without Chipmunk.
/// `start` holds one pose a brick. Steps may have any length.
std::unique_ptr<BrickWorld> makeChipmunkWorld(const std::vector<model::Brick>& bricks,
                                              const Poses& start,
                                              std::span<const model::Pivot> pivots,
                                              const scene::Environment& environment,
                                              int iterations);

/// The same in Box2D's world of single precision, with revolute joints. `iterations` of its solver
/// for velocities, and `corrections` of that for positions, in each step. Null without Box2D.
std::unique_ptr<BrickWorld> makeBox2dWorld(const std::vector<model::Brick>& bricks,
                                           const Poses& start, std::span<const model::Pivot> pivots,
                                           const scene::Environment& environment, int iterations,
                                           int corrections);

/// Bricks in MuJoCo's joint coordinates: hinges that span all bricks as a tree are its joints, the
/// others are constraints that its Newton solver keeps. In the plane bricks have three degrees of
/// freedom, else hinges of two pivots turn about one axis and single pivots are balls. Motions that
/// are written must be the start's poses with any velocities, or the motion read last. Null without
/// MuJoCo. Throws std::runtime_error for bricks that MuJoCo cannot have.
/// Costs MuJoCo's compilation of a model with all bricks, and steps with a dense Newton solve over
/// all joint coordinates that loops touch.
std::unique_ptr<BrickWorld> makeMujocoWorld(const std::vector<model::Brick>& bricks,
                                            const Poses& start,
                                            std::span<const model::Pivot> pivots,
                                            const scene::Environment& environment, bool planar);

/// The versions in use, e.g. "7.0.3"; empty where this program was built without the engine.
std::string chipmunkVersion();
/// The version of Box2D in use, as "2.4.1".
std::string box2dVersion();
/// The version of MuJoCo in use, as "3.1.6".
std::string mujocoVersion();

}  // namespace kirireel::engines
