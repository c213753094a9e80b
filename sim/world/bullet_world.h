/// Bullet's rigid-body world with point joints: the baseline solver. No Bullet header is needed to
/// use it.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/scene/scene.h"
#include "sim/world/brick_world.h"

namespace kirireel {

/// Which of Bullet's solvers holds joints and contacts.
enum class BulletMethod {
  SequentialImpulse,  ///< projected Gauss-Seidel, Bullet's usual one
  Nncg,               ///< nonsmooth nonlinear conjugate gradients over the same sweeps
  Dantzig,            ///< Dantzig's pivoting on the dense matrix of all joints and contacts
};

/// How Bullet solves a step.
struct BulletSettings {
  BulletMethod method = BulletMethod::SequentialImpulse;
  int iterations = 50;           ///< sweeps in each step; of Dantzig where its pivoting fails
  double jointCorrection = 0.2;  ///< part of a joint's gap taken back in a step, 0 to 1 (its ERP)
};

/// A btDiscreteDynamicsWorld in double precision that holds one convex hull a brick, one point
/// joint a pivot, and the ground if there is one.
class BulletWorld : public BrickWorld {
 public:
  /// The environment gives gravity, damping, contacts and ground.
  /// Poses are those of the centres of mass. All lists are in the order of the bricks.
  BulletWorld(const std::vector<Brick>& bricks, const Poses& start, std::span<const Pivot> pivots,
              const Environment& environment, const BulletSettings& settings);
  ~BulletWorld() override;
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  void applyLoad(int brick, const Vector3& force, const Vector3& torque) override;
  void advance(double step) override;
  void readMotion(Motion& motion) const override;
  void writeMotion(const Motion& motion) override;

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The version of Bullet in use, e.g. "3.24".
std::string bulletVersion();

}  // namespace kirireel
