/// The forces that drive bricks: springs to targets, curves and points, expansion, gravity and
/// damping.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// Stiffness and damping of springs.

/// Spring and damping constants of one brick.
struct BrickSpring {
  double springStiffness = 0;               ///< k_f, N/m per vertex
  double torqueStiffness = 0;               ///< k_tau, N/m per vertex
  double forceDamping = 0;                  ///< mu_v, N s/m
  Matrix3 torqueDamping = Matrix3::Zero();  ///< mu_omega in brick axes, N m s
};

/// The brick's constants for these settings. See the equations in forces.cpp.
BrickSpring springOf(const brick::Brick& brick, const scene::TargetSpringSettings& settings);

/// The stiffness m (2 pi f)^2 of springs that hold one tile at its place, N/m. m is the mean mass
/// of these bricks, f the frequency of the settings. Compliant joints have a multiple of this
/// stiffness (PathSettings::jointRatio).
double placeStiffness(const scene::TargetSpringSettings& settings,
                      const std::vector<brick::Brick>& bricks);

/// The springs that guide the scene's tiles, with sqrt(2) times the frequency of its own springs.
scene::TargetSpringSettings guideSprings(const scene::Scene& scene);

/// The stiffness of joints that the scene's path makes compliant, N/m. Infinite for exact joints.
double jointStiffnessOf(const scene::Scene& scene, const std::vector<brick::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// Force of a drive. This covers all drives except the springs to a target: a run moves these and
// stiffens them during the path (see TargetSprings).

/// Base class of the forces that drive a scene's bricks.
class DriveForce {
 public:
  virtual ~DriveForce() = default;

  /// Adds the drive's load on every brick at these poses, including damping. `loads` has one entry
  /// per brick. Existing loads are kept.
  virtual void addLoads(const Poses& poses, std::vector<brick::Load>& loads) const = 0;

  /// Energy stored in these poses, joules. 0 for drives that store no energy.
  virtual double energy(const Poses& poses) const = 0;

  /// Adds the part of the drive without stored energy to every brick's force, newtons.
  virtual void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const = 0;

  /// Whether the drive never ends by itself: only joints or contacts can stop the bricks.
  virtual bool isEndless() const = 0;
};

// ------------------------------------------------------------------------------------------------
// Expansion pushes every brick away from the centre of its piece (PyKirigami's --cm_expansion).

/// F = k (x - centre) - c v at a brick's centre of mass, plus the torque damping of its spring.
/// `centre` is the centre of mass of all bricks of its piece. The push grows outwards and is
/// therefore explicit, with zero stiffness. Only the damping is implicit.
class Expansion : public DriveForce {
 public:
  /// k is the settings' spring stiffness, N/m, or follows from their frequency for one vertex of a
  /// square with the brick's mass. c is the brick's force damping, N s/m. The object keeps a
  /// reference to `bricks`. `pieces` has the index of each brick's piece, see model::piecesOf().
  Expansion(const std::vector<brick::Brick>& bricks, std::vector<int> pieces,
            const scene::TargetSpringSettings& settings);

  void addLoads(const Poses& poses, std::vector<brick::Load>& loads) const override;
  double energy(const Poses&) const override { return 0; }
  void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const override;
  bool isEndless() const override { return true; }

 private:
  std::vector<Vector3> centresOf(const Poses& poses) const;

  const std::vector<brick::Brick>& bricks_;
  std::vector<int> pieces_;             // one per brick
  std::vector<BrickSpring> strengths_;  // one per brick
};

// ------------------------------------------------------------------------------------------------
// A damped spring between a point of a brick and a fixed point.

/// The two ends and the constants of a point spring.
struct PointSpring {
  Vector3 point = Vector3::Zero();   ///< on the brick, in its axes, metres
  Vector3 anchor = Vector3::Zero();  ///< in the world, metres
  double stiffness = 0;              ///< N/m, >= 0
  double damping = 0;                ///< N s/m of the point's velocity, >= 0
};

/// Adds the spring's force and its torque about the centre of mass to the brick's load. The damper
/// is part of the load's damping matrix. The load's force is the force at zero velocity.
void addPointSpring(const PointSpring& spring, const Pose& pose, brick::Load& load);

/// Energy stored in the spring, joules.
double pointSpringEnergy(const PointSpring& spring, const Pose& pose);

// ------------------------------------------------------------------------------------------------
// Springs that pull the corners of the hull to a surrounding circle or ellipse (Liu, Choi and
// Mahadevan, "Quasicrystal kirigami", 2022).

/// One damped spring for each position of the hull. Corners at the same position share it. It pulls
/// radially to an ellipse about the hull's centre, in the x-y plane.
class BoundarySprings : public DriveForce {
 public:
  /// The ellipse surrounds the start. The corners are those of the model's hull. If the model has
  /// none, they are the corners on the convex outline of its start. Throws InputError if the model
  /// names an invalid hull. The centre of the hull must not be one of its corners. `bricks` belong
  /// to the model's tiles.
  BoundarySprings(const model::Model& model, const std::vector<brick::Brick>& bricks,
                  const scene::TargetSpringSettings& settings, const scene::BoundaryCurve& curve);

  void addLoads(const Poses& poses, std::vector<brick::Load>& loads) const override;
  double energy(const Poses& poses) const override;
  void addFreeForces(const Poses&, std::vector<Vector3>&) const override {}
  bool isEndless() const override { return false; }

  /// The point of the ellipse that attracts corner k of the hull, metres.
  const Vector3& anchor(int k) const { return anchors_[k]; }

 private:
  std::vector<BrickSpring> strengths_;             // one per brick
  std::vector<Vector3> anchors_;                   // one per hull corner
  std::vector<std::vector<PointSpring>> springs_;  // of each brick; empty for inner bricks
};

// ------------------------------------------------------------------------------------------------
// Gravity and environment damping.

/// Adds gravity and the environment's damping to the loads of these bricks. They are the first of
/// those that have poses and loads. Damping removes the given fraction of the velocity per second.
/// It is a viscous force, proportional to mass and inertia.
void addEnvironmentLoads(const scene::Environment& environment,
                         std::span<const brick::Brick> bricks, const Poses& poses,
                         std::vector<brick::Load>& loads);

// ------------------------------------------------------------------------------------------------
// Springs that pull every brick's bottom face towards its target (Jiang and Choi, "PyKirigami",
// Algorithm 2).

/// One force at the mean of a brick's bottom vertices and one torque about this mean:
///   F = k_f sum_k (t_k - p_k) - mu_v v,   T = k_tau sum_k p'_k x t'_k - mu_omega omega,
/// with p_k the bottom vertices, t_k their targets, primes relative to the means. Both come from
/// the energy k_f n/2 |mean p - mean t|^2 + k_tau/2 sum |p'_k - t'_k|^2.
class TargetSprings {
 public:
  /// Keeps a reference to `bricks`. `target`: one tile per brick, vertex by vertex. `pulled`: the
  /// bricks with springs; all if absent. Bricks without springs keep their damping.
  TargetSprings(const std::vector<brick::Brick>& bricks, const std::vector<model::Tile>& target,
                const std::optional<std::vector<int>>& pulled,
                const scene::TargetSpringSettings& settings);

  /// Sets another target. It needs the same tiles as the first.
  void setTarget(const std::vector<model::Tile>& target);

  /// The load on one brick at a pose. `stiffening` (>= 1) scales both stiffnesses. About 100
  /// multiplications and, far from the target, a 3 x 3 eigenvalue problem.
  brick::Load load(int brick, const Pose& pose, double stiffening) const;

  /// Adds the loads on all bricks at these poses, one per brick. Existing loads are kept.
  void addLoads(const Poses& poses, double stiffening, std::vector<brick::Load>& loads) const;

  /// Energy stored in all springs, joules.
  double energy(const Poses& poses, double stiffening) const;

 private:
  /// The springs of one brick, reduced to the terms of its load.
  struct Spring {
    int vertexCount = 0;
    Vector3 bottomMean;  ///< mean of the bottom vertices, brick axes
    Vector3 targetMean;  ///< mean of the target vertices, world axes
    Matrix3 moment;      ///< sum over vertices of p'_k t'_k^T, p' in brick axes
    double spread = 0;   ///< sum over vertices of |p'_k|^2 + |t'_k|^2
    bool pulled = true;
    BrickSpring strength;
  };

  void addLoad(const Spring& spring, const Pose& pose, double stiffening, brick::Load& load) const;

  const std::vector<brick::Brick>& bricks_;
  std::vector<Spring> springs_;
};

/// Doubles the stiffness when the target error stalls, up to a factor of 16. A stall is 60 steps of
/// 1/240 s without 0.5 % of improvement (paper, "adaptive stiffness"). The time of doubling does
/// not depend on the step length; see nextMoment().
class AdaptiveStiffness {
 public:
  /// `enabled`: false keeps the factor at 1.
  explicit AdaptiveStiffness(bool enabled) : enabled_(enabled) {}

  /// Records the error at `time`, the end of a step of `step` seconds. Doubles the factor if the
  /// error has stalled, and returns whether it did. Time between observed steps does not count.
  bool observe(double targetError, double time, double step);

  /// Time of the next doubling if the error does not improve before, seconds. A step should end
  /// there. Infinity if none is due or nothing was observed yet.
  double nextMoment() const;

  /// The factor on both stiffnesses, [1, 16].
  double factor() const { return factor_; }

  /// Whether no further doubling can occur.
  bool exhausted() const;

  /// Doubles immediately, for a deployment that has come to rest.
  void stiffen();

  void transfer(StateTape& tape) {
    tape.transfer(enabled_, factor_, bestError_, lastError_, lastTime_, improvedAt_);
  }

 private:
  bool enabled_;
  double factor_ = 1;
  double bestError_ = -1;  ///< the last error that was an improvement; < 0: none was observed
  double lastError_ = 0;
  double lastTime_ = 0;    ///< seconds
  double improvedAt_ = 0;  ///< time of that error, or of the last doubling, seconds
};

// ------------------------------------------------------------------------------------------------
// Rigid motion of every tile from its start to its target.

/// Moves every tile along its own rigid motion. Its mean moves straight, and the tile rotates
/// uniformly about one axis. The difference in shape to the target grows linearly. Neighbours
/// separate if their motions differ; the joints force a common motion.
class TargetGuide {
 public:
  /// `start` and `target` have the same tiles with the same vertices.
  TargetGuide(const std::vector<model::Tile>& start, const std::vector<model::Tile>& target);

  /// The tiles at a progress from 0 (the start) to 1 (the target). Costs O(vertices).
  std::vector<model::Tile> at(double progress) const;

 private:
  /// The motion of one tile.
  struct GuideMotion {
    Vector3 startMean;
    Vector3 targetMean;
    Vector3 turn;                   ///< rotation vector of the best fit
    std::vector<Vector3> vertices;  ///< of the start, relative to its mean
    std::vector<Vector3> misfit;    ///< residual of the best fit, in the start's axes
  };

  std::vector<GuideMotion> motions_;
};

/// The bricks' poses that fit the target best, each brick independently. `target` has one tile per
/// brick. The fit minimises the sum of squared distances of the bottom vertices.
Poses bestFitPoses(const std::vector<brick::Brick>& bricks, const std::vector<model::Tile>& target);

}  // namespace kirireel::run
