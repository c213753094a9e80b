/// The forces that drive bricks: springs to targets, curves and points, expansion, gravity and
/// damping.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// How strong springs are.

/// What pulls and damps one brick.
struct BrickSpring {
  double springStiffness = 0;               ///< k_f, N/m for each vertex
  double torqueStiffness = 0;               ///< k_tau, N/m for each vertex
  double forceDamping = 0;                  ///< mu_v, N s/m
  Matrix3 torqueDamping = Matrix3::Zero();  ///< mu_omega in brick axes, N m s
};

/// The brick's spring by the settings. See the equations in forces.cpp.
BrickSpring springOf(const model::Brick& brick, const scene::TargetSpringSettings& settings);

/// By how much springs of the settings' frequency hold one tile at its place, at the mean mass of
/// these bricks, N/m: m (2 pi f)^2. Compliant joints have a multiple of it
/// (PathSettings::jointRatio).
double placeStiffness(const scene::TargetSpringSettings& settings,
                      const std::vector<model::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// The force of a drive, for all drives but the springs to a target, which a run moves on and
// stiffens on its way (see TargetSprings).

/// What drives the bricks of a scene.
class DriveForce {
 public:
  virtual ~DriveForce() = default;

  /// Adds the drive's load on every brick at these poses, its damping included.
  /// One pose and one load a brick. The loads are added to what is there.
  virtual void addLoads(const Poses& poses, std::vector<model::Load>& loads) const = 0;

  /// Energy that it stores in these poses, joules; 0 where it stores none.
  virtual double energy(const Poses& poses) const = 0;

  /// Adds to every brick's force, newtons, what of the drive stores no energy.
  virtual void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const = 0;

  /// Whether it drives bricks on however far they have come, so that nothing but joints ends it.
  virtual bool isEndless() const = 0;
};

// ------------------------------------------------------------------------------------------------
// Expansion: every brick is pushed away from the centre of its piece (PyKirigami's --cm_expansion).

/// F = k (x - centre) - c v on a brick's centre of mass, with the centre of mass of the bricks that
/// joints connect it to, and the torque damping of its spring. The push grows outwards, so it is
/// taken at the start of a step: its stiffness is zero, only the damping is implicit.
class Expansion : public DriveForce {
 public:
  /// k is the spring stiffness of the settings, N/m, or what their frequency gives a vertex of a
  /// square of the brick's mass; c is the brick's force damping, N s/m. `bricks` must outlive this.
  /// `pieces` has the number of each brick's piece, see model::piecesOf().
  Expansion(const std::vector<model::Brick>& bricks, std::vector<int> pieces,
            const scene::TargetSpringSettings& settings);

  void addLoads(const Poses& poses, std::vector<model::Load>& loads) const override;
  double energy(const Poses&) const override { return 0; }
  void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const override;
  bool isEndless() const override { return true; }

 private:
  std::vector<Vector3> centresOf(const Poses& poses) const;

  const std::vector<model::Brick>& bricks_;
  std::vector<int> pieces_;             // one a brick
  std::vector<BrickSpring> strengths_;  // one a brick
};

// ------------------------------------------------------------------------------------------------
// A damped spring between a point of a brick and a point of the world.

/// What the spring pulls at, and how.
struct PointSpring {
  Vector3 point = Vector3::Zero();   ///< of the brick, in its axes
  Vector3 anchor = Vector3::Zero();  ///< in the world, metres
  double stiffness = 0;              ///< N/m, from 0
  double damping = 0;                ///< N s/m of the point's velocity, from 0
};

/// Adds the spring's force and its torque about the centre of mass to the brick's load.
/// Forces of the damper are in the load's damping, not in its force, which is that at zero
/// velocity.
void addPointSpring(const PointSpring& spring, const Pose& pose, model::Load& load);

/// Energy that the spring stores, joules.
double pointSpringEnergy(const PointSpring& spring, const Pose& pose);

// ------------------------------------------------------------------------------------------------
// Springs that pull the corners of the hull towards a circle or an oblong round it (Liu, Choi and
// Mahadevan, "Quasicrystal kirigami", 2022).

/// One damped spring for each place of the hull, which the corners there share, from the corner
/// straight out to the curve: an ellipse round the hull's middle in the plane of x and y.
class BoundarySprings : public DriveForce {
 public:
  /// The curve is laid round the start; the corners are the model's hull, or those on the convex
  /// outline of its start where the model has none. Throws InputError for a hull that the model
  /// names and that cannot be.
  /// The middle of the hull must not be one of its corners. `bricks` are those of the model's
  /// tiles.
  BoundarySprings(const model::Model& model, const std::vector<model::Brick>& bricks,
                  const scene::TargetSpringSettings& settings, const scene::BoundaryCurve& curve);

  void addLoads(const Poses& poses, std::vector<model::Load>& loads) const override;
  double energy(const Poses& poses) const override;
  void addFreeForces(const Poses&, std::vector<Vector3>&) const override {}
  bool isEndless() const override { return false; }

  /// The point of the curve that corner k of the hull is pulled to.
  const Vector3& anchor(int k) const { return anchors_[k]; }

 private:
  std::vector<BrickSpring> strengths_;             // one a brick
  std::vector<Vector3> anchors_;                   // one a hull corner
  std::vector<std::vector<PointSpring>> springs_;  // of each brick
};

// ------------------------------------------------------------------------------------------------
// Gravity and the damping of free flight.

/// Adds gravity and the environment's damping to the load of each of these bricks, which are the
/// first of those that have poses and loads. Damping takes the given part of the velocity away each
/// second, as a viscous force in proportion to mass and inertia.
void addEnvironmentLoads(const scene::Environment& environment,
                         std::span<const model::Brick> bricks, const Poses& poses,
                         std::vector<model::Load>& loads);

// ------------------------------------------------------------------------------------------------
// Springs that pull every brick's bottom towards its target (Jiang and Choi, "PyKirigami",
// Algorithm 2).

/// One force at the mean of a brick's bottom vertices and one torque about that mean:
///   F = k_f sum_k (t_k - p_k) - mu_v v,   T = k_tau sum_k p'_k x t'_k - mu_omega omega,
/// with p_k the bottom vertices, t_k their targets, primes relative to the means. Both come from
/// the energy k_f n/2 |mean p - mean t|^2 + k_tau/2 sum |p'_k - t'_k|^2.
class TargetSprings {
 public:
  /// `bricks` must outlive this. `target`: one tile a brick, vertex by vertex. `pulled`: the bricks
  /// that feel springs; all when absent. Bricks that feel none keep their damping.
  TargetSprings(const std::vector<model::Brick>& bricks, const std::vector<model::Tile>& target,
                const std::optional<std::vector<int>>& pulled,
                const scene::TargetSpringSettings& settings);

  /// Pulls towards another target from now on; the same tiles as the first.
  void setTarget(const std::vector<model::Tile>& target);

  /// The load on one brick at a pose; both stiffnesses times `stiffening` (from 1).
  /// About 100 multiplications and, far from the target, a 3 x 3 eigenvalue problem.
  model::Load load(int brick, const Pose& pose, double stiffening) const;

  /// Adds the loads on all bricks at these poses, one a brick, to what is there.
  void addLoads(const Poses& poses, double stiffening, std::vector<model::Load>& loads) const;

  /// Energy stored in all springs, joules.
  double energy(const Poses& poses, double stiffening) const;

 private:
  /// The springs of one brick, reduced to what its load needs.
  struct Spring {
    int vertexCount = 0;
    Vector3 bottomMean;  ///< of the bottom vertices, brick axes
    Vector3 targetMean;  ///< of the targets, world axes
    Matrix3 moment;      ///< sum over vertices of p'_k t'_k^T, p' in brick axes
    double spread = 0;   ///< sum over vertices of |p'_k|^2 + |t'_k|^2
    bool pulled = true;
    BrickSpring strength;
  };

  void addLoad(const Spring& spring, const Pose& pose, double stiffening, model::Load& load) const;

  const std::vector<model::Brick>& bricks_;
  std::vector<Spring> springs_;
};

/// Doubles the stiffness when the target error stalls: after 60 steps of 1/240 s without
/// improvement by half a percent, up to 16 times (paper, "adaptive stiffness"). When that is does
/// not depend on the steps: see nextMoment().
class AdaptiveStiffness {
 public:
  /// `enabled`: whether it ever stiffens.
  explicit AdaptiveStiffness(bool enabled) : enabled_(enabled) {}

  /// Tells the error at `time`, the end of a step of `step` seconds; doubles where it is time, and
  /// returns whether. What passes between two steps that are told does not count.
  bool observe(double targetError, double time, double step);

  /// When it will double unless the error improves before, seconds: a step should end there.
  /// Infinity: it will not, or nothing was told yet.
  double nextMoment() const;

  /// The factor on both stiffnesses, 1 to 16.
  double factor() const { return factor_; }

  /// Whether no further doubling can come.
  bool exhausted() const;

  /// Doubles at once (a deployment that came to rest need not wait).
  void stiffen();

  /// Records or plays back.
  void transfer(StateTape& tape) {
    tape.transfer(enabled_, factor_, bestError_, lastError_, lastTime_, improvedAt_);
  }

 private:
  bool enabled_;
  double factor_ = 1;
  double bestError_ = -1;  ///< the last error that was an improvement; negative: nothing was told
  double lastError_ = 0;
  double lastTime_ = 0;    ///< seconds
  double improvedAt_ = 0;  ///< when the best error was passed, or the stiffness doubled, seconds
};

// ------------------------------------------------------------------------------------------------
// A way for every tile from its start to its target.

/// Leads every tile along its own rigid motion: its middle goes straight, the tile turns evenly
/// about one axis, and what its target differs from it in shape is faded in. Neighbours part on
/// the way, as far as their motions differ; the joints make them find a way together.
class TargetGuide {
 public:
  /// The same tiles, vertex by vertex, in both states.
  TargetGuide(const std::vector<model::Tile>& start, const std::vector<model::Tile>& target);

  /// Where the tiles are guided at a progress from 0 (the start) to 1 (the target).
  /// Costs O(vertices).
  std::vector<model::Tile> at(double progress) const;

 private:
  /// The motion of one tile.
  struct Way {
    Vector3 startMean;
    Vector3 targetMean;
    Vector3 turn;                   ///< rotation vector of the best fit
    std::vector<Vector3> vertices;  ///< of the start, relative to its mean
    std::vector<Vector3> misfit;    ///< what the best fit leaves over, in the start's axes
  };

  std::vector<Way> ways_;
};

/// The bricks' poses that fit the target best, each brick by itself.
/// `target` has one tile a brick. The fit is that of the bottoms, in the sum of squares.
Poses bestFitPoses(const std::vector<model::Brick>& bricks, const std::vector<model::Tile>& target);

}  // namespace kirireel::deploy
