/// Springs that pull every brick's bottom towards its target (Jiang and Choi, "PyKirigami",
/// Algorithm 2).
#pragma once

#include <optional>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/load.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// One force at the mean of a brick's bottom vertices and one torque about that mean:
///   F = k_f sum_k (t_k - p_k) - mu_v v,   T = k_tau sum_k p'_k x t'_k - mu_omega omega,
/// with p_k the bottom vertices, t_k their targets, primes relative to the means. Both come from
/// the energy k_f n/2 |mean p - mean t|^2 + k_tau/2 sum |p'_k - t'_k|^2.
class TargetSprings {
 public:
  /// `bricks` must outlive this. `target`: one tile a brick, vertex by vertex. `pulled`: the bricks
  /// that feel springs; all when absent. Bricks that feel none keep their damping.
  TargetSprings(const std::vector<Brick>& bricks, const std::vector<Tile>& target,
                const std::optional<std::vector<int>>& pulled,
                const TargetSpringSettings& settings);

  /// Pulls towards another target from now on; the same tiles as the first.
  void setTarget(const std::vector<Tile>& target);

  /// The load on one brick at a pose; both stiffnesses times `stiffening` (from 1).
  /// About 100 multiplications and, far from the target, a 3 x 3 eigenvalue problem.
  Load load(int brick, const Pose& pose, double stiffening) const;

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
  };

  const std::vector<Brick>& bricks_;
  std::vector<Spring> springs_;
  TargetSpringSettings settings_;
};

/// Doubles the stiffness when the target error stalls: after 60 steps of 1/240 s without
/// improvement by half a percent, up to 16 times (paper, "adaptive stiffness"). When that is does
/// not depend on the steps: see nextMoment().
class AdaptiveStiffness {
 public:
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

}  // namespace kirireel
