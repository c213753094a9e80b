/// A scene stepped by hand, so that tests and benchmarks see every step's energy, gap and cost.
#pragma once

#include <ctime>
#include <memory>
#include <optional>
#include <random>

#include "sim/actuation/target_springs.h"
#include "sim/deploy/dynamics.h"
#include "sim/measure/measures.h"

namespace kirireel::test {

/// CPU seconds that this thread has used.
inline double threadSeconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// The scene's bricks under springs of constant stiffness, from an assembled start with a nudge.
class SteppedScene {
 public:
  explicit SteppedScene(const Scene& scene)
      : scene_(scene),
        bricks_(makeBricks(scene_.model.tiles, scene_.brick)),
        pivots_(makePivots(scene_.model.joints, bricks_)),
        motion_{startPoses(scene_.model.tiles, bricks_), std::vector<Velocity>(bricks_.size())},
        dynamics_(makeDynamics(scene_, sceneNeeds(scene_), bricks_, motion_.poses)) {
    if (scene_.model.target) {
      springs_.emplace(bricks_, *scene_.model.target, scene_.model.pulledTiles, scene_.springs);
    }
    dynamics_->assemble(motion_.poses);
    nudge(1e-6 * modelSize(scene_.model));
  }
  SteppedScene(const SteppedScene&) = delete;
  SteppedScene& operator=(const SteppedScene&) = delete;

  /// One step of the scene's timestep; its cost alone is counted.
  void advance() {
    const auto loads = [this](const Poses& poses, std::vector<Load>& out) {
      for (std::size_t i = 0; i < poses.size(); ++i) {
        out[i] = springs_ ? springs_->load(static_cast<int>(i), poses[i], 1) : Load{};
      }
    };
    const double before = threadSeconds();
    report_ += dynamics_->advance(motion_, scene_.solver.timestep, loads);
    seconds_ += threadSeconds() - before;
  }

  const std::vector<Brick>& bricks() const { return bricks_; }
  const std::vector<Pivot>& pivots() const { return pivots_; }
  const Motion& motion() const { return motion_; }
  const StepReport& report() const { return report_; }
  /// CPU seconds spent in advance().
  double seconds() const { return seconds_; }
  double gap() const { return jointGap(pivots_, motion_.poses).max; }

  /// Kinetic energy and that of springs and gravity, joules.
  double energy() const {
    double energy = kineticEnergy(bricks_, motion_);
    if (springs_) energy += springs_->energy(motion_.poses, 1);
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      energy -= bricks_[i].mass * scene_.environment.gravity.dot(motion_.poses[i].position);
    }
    return energy;
  }

 private:
  void nudge(double speed) {
    std::mt19937 generator(scene_.solver.seed);
    for (Velocity& velocity : motion_.velocities) {
      for (int k = 0; k < 3; ++k) velocity.linear[k] = speed * (generator() / 2147483648.0 - 1);
    }
  }

  Scene scene_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  Motion motion_;
  std::optional<TargetSprings> springs_;
  std::unique_ptr<Dynamics> dynamics_;
  StepReport report_;
  double seconds_ = 0;
};

/// What hard settings do to a run.
struct Stability {
  bool finite = true;   ///< every brick stayed within a thousand model sizes
  double growth = -1;   ///< of the energy, the largest in any step, relative to that at the start
  double gap = 0;       ///< largest, relative to the model's size
  int unconverged = 0;  ///< steps
};

/// Steps the scene and watches.
inline Stability watchStability(const Scene& scene, int steps) {
  SteppedScene run(scene);
  const double size = modelSize(scene.model);
  const double start = run.energy();
  double before = start;
  Stability result;
  for (int step = 0; step < steps && result.finite; ++step) {
    run.advance();
    const double after = run.energy();
    result.growth = std::max(result.growth, (after - before) / start);
    result.gap = std::max(result.gap, run.gap() / size);
    result.finite = std::isfinite(after);
    for (const Pose& pose : run.motion().poses) {
      result.finite = result.finite && pose.position.norm() < 1e3 * size;
    }
    before = after;
  }
  result.unconverged = run.report().unconverged;
  return result;
}

}  // namespace kirireel::test
