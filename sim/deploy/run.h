/// One deployment in progress.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/actuation/boundary_springs.h"
#include "sim/actuation/target_springs.h"
#include "sim/deploy/deployment.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/path_follower.h"
#include "sim/deploy/timeline_runner.h"
#include "sim/measure/measures.h"

namespace kirireel {

/// Steps a scene from its start until it rests, locks, diverges, or its time is up.
class Run : private TimelineStage {
 public:
  /// `assembledError`: see assembleAtTarget(); negative where there is no target. The scene's path
  /// must be chosen (not Auto). Scene, observer and checkpoints must outlive the run; the last may
  /// be null.
  Run(const Scene& scene, double sampleInterval, double assembledError,
      const SampleObserver& observer, Checkpoints* checkpoints = nullptr);

  /// Runs to the end, from the checkpoint that was found if there is one. The trajectory holds no
  /// samples: they go to the observer.
  DeploymentResult finish();

  /// What it has cost so far.
  const DeployCost& cost() const { return result_.cost; }
  /// How well it has gone so far; of overlaps, as far as samples have seen them.
  const Accuracy& accuracy() const { return result_.accuracy; }
  /// Whether bricks keep joints that gave from closing.
  bool isHeldOpen() const { return heldOpen_; }

 private:
  void start();
  void pull(const Poses& poses, std::vector<Load>& loads) const;
  void setPinned(const std::vector<bool>& pinned) override { dynamics_->setPinned(pinned); }
  void goTo(const std::vector<Tile>* target) override;
  void tieSprings();
  void reset() override;
  void quit() override;
  bool followTimeline(bool atRest);
  void restOrGoOn();
  void advanceSample();
  void advanceStep();
  void followPath();
  bool closeJoints();
  bool isOpening() const { return time() < openedAt_; }
  /// Whether something else drives the tiles than the scene's own actuation.
  bool isOnPath() const { return isOpening() || follower_.has_value(); }
  void observeStep();
  void updateRest();
  void watchJam(const StepReport& report);
  bool isStuck() const;
  bool isLost() const;
  bool jointsGiveThroughout() const;
  void holdJoints();
  void takeSample();
  void note(Sample& sample);
  void transfer(StateTape& tape);
  void transferFigures(StateTape& tape);
  void saveState();
  void goOnFrom(const RunState& state);
  bool goesOn();
  void end(Outcome outcome, std::string reason);
  void interrupt() { end(Outcome::Interrupted, "ended early by the caller"); }
  void endAtRest();
  std::string holdup() const;
  std::string jointTrouble() const;
  double time() const { return static_cast<double>(stepCount_) * step_; }
  bool pullsToTarget() const { return scene_.actuation.drive == Drive::Target && target_; }
  double finalTargetError() const;
  double currentTargetError() const;
  double reachableError() const;
  double spentSeconds() const;

  const Scene& scene_;
  const SampleObserver& observer_;
  Checkpoints* checkpoints_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  Motion motion_;
  Poses startPoses_;  // joints closed unless they give
  std::optional<PenetrationGrowth> overlaps_;
  const std::vector<Tile>* target_;  // the one headed for at present; null when there is none
  double targetStartError_ = 0;      // when it was set
  double leastError_ = 0;            // how near the tiles can come
  Poses departure_;                  // where the bricks were when it was set
  double departureTime_ = 0;
  Needs needs_;
  std::unique_ptr<Dynamics> dynamics_;
  std::optional<TargetSprings> springs_;
  double openedAt_ = 0;                   // seconds; expansion until then
  std::optional<PathFollower> follower_;  // while the tiles are led
  std::optional<BoundarySprings> boundary_;
  TimelineRunner timeline_;
  AdaptiveStiffness stiffness_;
  LoadSource actuation_;
  int stepsPerSample_;
  double step_;
  double size_;
  double tileSize_;
  double assembledError_;
  long stepCount_ = 0;
  double gapSum_ = 0;
  double restTime_ = 0;
  bool misfit_ = false;        // joints could not be closed
  bool heldOpen_ = false;      // for bricks that are in the way
  double pushedAtStart_ = 0;   // metres that closing the joints pushed bricks into each other
  Poses jamStart_;             // where steps began to fail however short; empty while they do not
  double earlierSeconds_ = 0;  // of CPU time, in the processes before this one
  double startSeconds_ = 0;    // CPU time of the thread when this one began
  bool isAskedToEnd_ = false;
  bool ended_ = false;
  DeploymentResult result_;
};

}  // namespace kirireel
