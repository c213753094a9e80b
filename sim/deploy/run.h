/// One deployment in progress.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/actuation/target_springs.h"
#include "sim/deploy/deployment.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/path_follower.h"

namespace kirireel {

/// Steps a scene from its start until it rests, locks, diverges, or its time is up.
class Run {
 public:
  /// `assembledFloor`: see assembledFloor(); negative where there is no target. The scene's path
  /// must be chosen (not Auto). Scene and observer must outlive the run.
  Run(const Scene& scene, double sampleInterval, double assembledFloor,
      const SampleObserver& observer);

  /// Runs to the end. The trajectory holds no samples: they go to the observer.
  DeploymentResult finish();

 private:
  void start();
  void advanceSample();
  void advanceStep();
  void followPath();
  void observeStep();
  void updateRest();
  bool isLost() const;
  void takeSample();
  void end(Outcome outcome, std::string reason);
  void endAtRest();
  double currentTargetError() const;

  double time() const { return static_cast<double>(stepCount_) * step_; }

  const Scene& scene_;
  const SampleObserver& observer_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  Motion motion_;
  Poses startPoses_;
  Needs needs_;
  std::unique_ptr<Dynamics> dynamics_;
  std::optional<TargetSprings> springs_;
  std::optional<PathFollower> follower_;  // while the tiles are led
  AdaptiveStiffness stiffness_;
  LoadSource actuation_;
  int stepsPerSample_;
  double step_;
  double size_;
  double tileSize_;
  double assembledFloor_;
  long stepCount_ = 0;
  double gapSum_ = 0;
  double restTime_ = 0;
  bool ended_ = false;
  DeploymentResult result_;
};

}  // namespace kirireel
