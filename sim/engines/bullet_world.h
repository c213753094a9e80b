/// The worlds of Bullet, baseline solvers. No Bullet header is needed to use them.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/engines/brick_world.h"
#include "sim/scene/scene.h"

namespace kirireel::engines {

// ------------------------------------------------------------------------------------------------
// Bullet's rigid-body world with point joints: the baseline solver. No Bullet header is needed to
// use it.

/// Bullet's solvers of joints and contacts.
enum class BulletMethod {
  SequentialImpulse,  ///< projected Gauss-Seidel, Bullet's default
  Nncg,               ///< nonsmooth nonlinear conjugate gradients over the same sweeps
  Dantzig,            ///< Dantzig's pivoting on the dense matrix of all joints and contacts
};

/// How Bullet solves a step.
struct BulletSettings {
  BulletMethod method = BulletMethod::SequentialImpulse;  ///< which of Bullet's solvers
  int iterations = 50;           ///< sweeps per step; for Dantzig only if its pivoting fails
  double jointCorrection = 0.2;  ///< fraction of a joint's gap closed per step, [0, 1] (ERP)
};

/// A btDiscreteDynamicsWorld in double precision with one convex hull per brick, one point joint
/// per pivot, and the ground if there is one.
class BulletWorld : public BrickWorld {
 public:
  /// The environment gives gravity, damping, contacts and ground. Poses are those of the centres of
  /// mass. All lists are in the order of the bricks.
  BulletWorld(const std::vector<brick::Brick>& bricks, const Poses& start,
              std::span<const brick::Pivot> pivots, const scene::Environment& environment,
              const BulletSettings& settings);
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

/// Bullet's world of multibodies, which PyBullet runs: a baseline without contacts. Each brick is a
/// multibody without links, each pivot a point joint. `iterations` of the solver in each step; the
/// environment gives gravity and damping.
std::unique_ptr<BrickWorld> makeMultiBodyWorld(const std::vector<brick::Brick>& bricks,
                                               const Poses& start,
                                               std::span<const brick::Pivot> pivots,
                                               const scene::Environment& environment,
                                               int iterations);

// ------------------------------------------------------------------------------------------------
// Shrunk bricks for collision detection. Their contact margin restores the size.

/// The convex hull of `points` swept by a ball of radius `margin` has the faces of the brick and
/// rounded edges. Collision detection is fast and robust if shapes overlap by less than their
/// margins. A margin outside the brick would make compact tiles overlap at the start.
struct InsetHull {
  std::vector<Vector3> points;  ///< 2n, in brick axes: those of the bottom, then those of the top
  double margin = 0;            ///< metres, positive
};

/// Moves every face of the brick inwards by min(0.02 m, a fifth of the thickness), or by less so no
/// edge loses more than half of its length. The brick is convex. Throws nothing; O(n) in its
/// corners.
InsetHull insetHull(const brick::Brick& brick);

/// The largest margin of a brick's convex pieces, metres.
double contactMargin(const brick::Brick& brick);

// ------------------------------------------------------------------------------------------------
// Zones around joints, in which contacts are ignored.

/// The neighbourhoods of shared pivots and hinge lines. Two bricks that turn about a common corner
/// always touch near it. A contact there would force the joint open.
class PivotZones {
 public:
  /// Links have no zone, since their corners are apart.
  PivotZones(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots);

  /// Whether a contact point of two bricks, in world axes, is within max(4 margins, 0.05 mean
  /// edges) of a pivot that they share, or of the line between both pivots of a hinge.
  bool contains(int brickA, int brickB, const Poses& poses, const Vector3& point) const;

 private:
  struct Zone {
    Vector3 from;  ///< in the axes of the pair's first brick
    Vector3 to;    ///< the hinge's other pivot, or `from` again
    double radius = 0;
    int joint = 0;
  };

  void add(const std::vector<brick::Brick>& bricks, const brick::Pivot& pivot);

  std::map<std::pair<int, int>, std::vector<Zone>> zones_;  // keys: lower brick index first
};

}  // namespace kirireel::engines
