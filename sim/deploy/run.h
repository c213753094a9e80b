/// A deployment in progress: the run, what leads its tiles, what carries out its timeline, and
/// whether it is at rest.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/deployment.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/forces.h"
#include "sim/deploy/run_figures.h"
#include "sim/measure/measures.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/model/isometry.h"
#include "sim/scene/conditions.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// Whether bricks that hardly move are at rest, or only slow.

/// What was found about a state that hardly moves.
struct RestProbe {
  bool movesOn = false;  ///< given time, a brick would go farther than rounding and noise let it
  double work = 0;       ///< that it cost, see StepReport
};

/// Looks where bricks that hardly move would go, given time: from rest, implicit steps that grow
/// from `step` seconds to months. A step that is long against the bricks' inertia and damping comes
/// near to Newton's method on what pulls them, so that soft springs and heavy bricks take no longer
/// than others. Where no brick goes a thousandth of a tile, the state is at rest.
///
/// `dynamics`: the bricks' solver in its present state, joints, pins and contacts included; it is
/// moved on and not to be used afterwards. `actuation` must pull the bricks to somewhere, else long
/// steps lead nowhere. `tileSize` in metres.
RestProbe probeRest(Dynamics& dynamics, const Motion& motion, double step,
                    const LoadSource& actuation, double tileSize);

/// How far the brick is that moved farthest from one state to another, metres: turns count at a
/// tile's size.
double farthestMove(const Poses& from, const Poses& to, double tileSize);

// ------------------------------------------------------------------------------------------------
// What lets a run leave an unstable equilibrium: small velocities at random. They are an error in
// time for a start that moves by itself, so that only those get them that do not.

/// How much of the nudge a run has been given.
enum class Nudged {
  No,
  InSymmetry,  ///< the part that has the symmetries of the model and the state alone
  Wholly,
};

/// How long bricks have from rest to get faster than a nudge, seconds.
constexpr double kNudgeTime = 1.0 / 240;

/// Small velocities for `count` bricks, turns apart: each component at random within a millionth of
/// the model's size (metres) a second. The same seed gives the same ones everywhere.
std::vector<Velocity> nudge(std::size_t count, double modelSize, unsigned seed);

/// Whether bricks move by what acts on them alone: whether in `after`, which they have come to from
/// rest in kNudgeTime with joints and contacts kept, some brick is faster than a nudge. Joined ones
/// must move against each other: a sheet that is pulled along, yet cannot open, does not move.
/// Sizes in metres.
bool movesByItself(const std::vector<Velocity>& after, bool areJoined, double tileSize,
                   double modelSize);

/// The part of a nudge with the symmetries of `group`, the identity among them, where joints leave
/// some of it, else nothing: a sheet that is closed may open in a way that no symmetry keeps.
/// `dynamics` holds the joints at the state.
std::vector<Velocity> symmetricNudge(const std::vector<Velocity>& whole, const Poses& poses,
                                     std::span<const Symmetry> group, Dynamics& dynamics);

// ------------------------------------------------------------------------------------------------
// Leads the tiles of a deployment to their target.

/// The first part of a led deployment: springs pull every tile after a target that moves along the
/// tile's own rigid motion, by the turn more than by the place (a mechanism that turns has to
/// swing out on its way, which straight lines do not know). Joints may give meanwhile; at the end
/// they stiffen until hardly anything of their openings is left.
class PathFollower {
 public:
  /// `bricks` must outlive this. `start`: where the path begins, joints closed unless they give;
  /// `beginTime`: when, seconds. `target`: where it leads, one tile a brick. The scene has
  /// PathKind::Led.
  PathFollower(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start,
               const std::vector<Tile>& target, double beginTime);

  /// Sets the moving target and the joints' stiffness for the step that ends at `time` (seconds
  /// of the run). Returns false when the path is done: the joints are as stiff as they get, ready
  /// to be closed and held exactly, and the scene's own springs take over.
  bool prepareStep(double time, Dynamics& dynamics);

  /// The springs that lead.
  const TargetSprings& springs() const { return springs_; }

 private:
  PathSettings path_;
  double beginTime_;
  TargetGuide guide_;
  TargetSprings springs_;
};

// ------------------------------------------------------------------------------------------------
// Carries out a scene's timeline while a deployment runs.

/// What the timeline looks at.
struct TimelineView {
  double time = 0;        ///< simulated seconds
  bool atRest = false;    ///< nothing moves any more
  double error = 0;       ///< to the present target, metres
  double startError = 0;  ///< the same when that target was set
  bool atTarget = false;  ///< at rest where rigid tiles come no nearer to the present target
  const Poses* poses = nullptr;
};

/// What the timeline does to a run, beyond pushing its bricks.
class TimelineStage {
 public:
  virtual ~TimelineStage() = default;
  virtual void setPinned(const std::vector<bool>& pinned) = 0;
  /// `target`: one tile a brick; null for the model's own.
  virtual void goTo(const std::vector<Tile>* target) = 0;
  virtual void reset() = 0;
  virtual void quit() = 0;
};

/// A tile that is dragged along, and the spring that it hangs on.
struct DragSpring {
  int tile = 0;
  PointSpring spring;
};

/// Watches a run and does what is due. Drags are loads, asked for in each step.
class TimelineRunner {
 public:
  /// The timeline must outlive the runner. `countsFrom`: the first tile's number in events.
  TimelineRunner(const Timeline& timeline, const std::vector<Brick>& bricks, int countsFrom = 0);

  /// Does everything that is due now and appends it to the events. Returns whether anything was.
  bool carryOut(const TimelineView& view, TimelineStage& stage, std::vector<Event>& events);

  /// Adds what drags pull with at this time.
  void addDrags(double time, const Poses& poses, std::vector<Load>& loads) const;

  /// The drags under way at this time, as the springs that they pull with.
  std::vector<DragSpring> dragSprings(double time) const;

  bool forcesAreOn() const { return forcesOn_; }
  bool isPaused(double time) const { return time < pausedUntil_; }
  /// Whether anything is to come or still under way.
  bool isOver(double time) const;
  /// When, after this time, the next entry comes due by itself, or a drag or a pause ends; infinity
  /// where nothing does.
  double nextMoment(double time) const;
  /// Whether the next entry comes due by itself, even where nothing moves.
  bool waitsForTime() const;
  /// Whether the next entry waits for rest, a target, an error or a progress, and no drag or pause
  /// is under way that could bring it.
  bool waitsForState() const;
  /// The tiles that are pinned, ascending.
  std::vector<int> pinnedTiles() const;
  /// What is waited for: "line 12 of scene.toml waits for ..." ; empty when nothing is to come.
  std::string pending() const;

  /// What has been done and what is under way.
  void transfer(StateTape& tape);

 private:
  /// A drag under way: the path with the point that it started from.
  struct ActiveDrag {
    std::size_t entry = 0;      // of the timeline
    Vector3 point;              // tied to the spring, in the brick's axes
    std::vector<Vector3> path;  // from where the point was
    double from = 0;            // seconds

    void transfer(StateTape& tape) { tape.transfer(entry, point, path, from); }
  };

  const timeline::Drag& dragOf(const ActiveDrag& active) const {
    return std::get<timeline::Drag>(timeline_.at(active.entry).action);
  }

  double dueTime(const Occasion& moment) const;
  bool isDue(const Occasion& moment, const TimelineView& view) const;
  void carryOut(const timeline::Action& action, const TimelineView& view, TimelineStage& stage);
  void pin(const std::vector<int>& tiles, bool pinned, TimelineStage& stage);
  void startDrag(const timeline::Drag& drag, const TimelineView& view);
  void reset(TimelineStage& stage);

  const Timeline& timeline_;
  const std::vector<Brick>& bricks_;
  int countsFrom_;  // the first tile, in events
  std::size_t next_ = 0;
  double lastTime_ = 0;  // of the entry before
  double pausedUntil_ = 0;
  bool forcesOn_ = true;
  std::vector<bool> pinned_;
  std::vector<ActiveDrag> drags_;
};

// ------------------------------------------------------------------------------------------------
// One deployment in progress.

/// What is shown of a run while it goes on. Either function may be empty; one that returns false
/// ends the run.
struct RunObservers {
  /// Seconds between the samples: these do not need to be whole steps. Infinity: the start and the
  /// end alone.
  double sampleInterval = std::numeric_limits<double>::infinity();
  SampleObserver sample;
  std::function<bool(const StepRecord&)> step;  ///< the start counts as one
};

/// Steps a scene from its start until it rests, locks, diverges, or its time is up. All that it
/// does and measures depends on the steps alone, not on who looks at it and how often: a sample
/// between two steps is made from their poses, its joints closed where theirs are.
class Run : private TimelineStage, private ActingForces {
 public:
  /// `nearest`: see assembleAtTarget(). The scene's path must be chosen (not Auto). Scene
  /// and checkpoints must outlive the run; the latter may be null.
  Run(const Scene& scene, const AssembledState& nearest, const RunObservers& observers,
      Checkpoints* checkpoints = nullptr);

  /// To be called before a run that is only tried: the reason for its end is left out.
  void beTrial() { isTrial_ = true; }

  /// To be called before a run of geometry alone: all its states keep the model's symmetries.
  void keepSymmetries() { symmetries_.emplace(scene_); }

  /// Runs to the end, from the checkpoint that was found if there is one. The trajectory holds no
  /// samples: they go to the observer. Interrupted (see sim/base/interruption.h) ends the run after
  /// its last whole step, yet is thrown by a trial.
  DeploymentResult finish();

  /// What it has cost so far.
  const DeployCost& cost() const { return figures_.cost(); }
  /// How well it has gone so far.
  const Accuracy& accuracy() const { return figures_.accuracy(); }
  /// Whether the figures of overlaps are of all pairs that are near at the start; see mostPairs().
  bool seesAllPairs() const { return figures_.seesAllPairs(); }
  /// Whether bricks keep joints that gave from closing.
  bool isHeldOpen() const { return heldOpen_; }

 private:
  /// Times closer than this part of a look are the same.
  static constexpr double kSameTime = 1e-6;

  void start();
  std::unique_ptr<Dynamics> makeSolver() const;
  void pull(const Poses& poses, std::vector<Load>& loads) const;
  /// What drives the bricks at present; null where springs to a target do, or nothing.
  const DriveForce* presentDrive() const { return isOpening() ? &opening_ : drive_.get(); }
  const TargetSprings* targetSprings() const;
  double springEnergy(double time, const Poses& poses) const override;
  double hingeEnergy(const Poses& poses) const override {
    return elasticEnergy(result_.trajectory.hingeSprings, poses) +
           elasticEnergy(result_.trajectory.ligaments, poses);
  }
  void addLigamentForces(const Poses& poses, std::vector<Vector3>& jointForces) const override;
  std::vector<Vector3> freeForces(const Poses& poses) const override;
  std::vector<Vector6> appliedForces(double time, const Motion& motion) const override;
  double jointStiffness() const override { return dynamics_->jointStiffness(); }
  std::vector<bool> pinned() const override;
  std::vector<Hold> holds(double time, const Motion& motion) const override;
  void setPinned(const std::vector<bool>& pinned) override { dynamics_->setPinned(pinned); }
  void goTo(const std::vector<Tile>* target) override;
  void tieSprings();
  void reset() override;
  void quit() override;
  /// A solver of its own, in the state of the run's.
  std::unique_ptr<Dynamics> copyOfSolver();
  void nudgeStart();
  void nudgeAtRest();
  bool followTimeline(bool atRest);
  void restOrGoOn();
  void advanceToEnd();
  void advance();
  void takeStep();
  /// The loads at the present time.
  LoadSource loadsNow() const {
    return [this](const Poses& poses, std::vector<Load>& loads) { actuation_(0, poses, loads); };
  }
  std::vector<Velocity> velocitiesAt(double seconds) const;
  Motion motionAt(double time, const Poses& poses) const;
  StepReport advanceByFixedSteps();
  StepReport advanceStep();
  void followPath();
  bool closeJoints();
  bool isOpening() const { return time() < openedAt_; }
  /// Whether something else drives the tiles than the scene's own actuation.
  bool isOnPath() const { return isOpening() || follower_.has_value(); }
  /// Whether joints are compliant on purpose.
  bool jointsGiveNow() const {
    if (!result_.trajectory.ligaments.empty()) return true;
    return isOnPath() ? scene_.path.jointsGive() : jointsGiveThroughout();
  }
  void showStep();
  void updateRest();
  /// When the run has rested for as long as counts, seconds; infinity while it does not rest.
  double restMoment() const;
  /// Whether a target is pulled to that stiffer springs may bring nearer.
  bool watchesStall() const { return pullsToTarget() && !isOnPath() && timeline_.forcesAreOn(); }
  double fastestSpeed() const { return fastestSpeed(motion_.velocities); }
  double fastestSpeed(const std::vector<Velocity>& velocities) const;
  double restWithinStep(double limit) const;
  bool isOnItsWay();
  void watchJam(const StepReport& report);
  bool isStuck() const;
  bool isLost() const;
  bool jointsGiveThroughout() const;
  void holdJoints(Dynamics& dynamics) const;
  void takeSamples();
  void takeLastSample();
  void takeSample(double time, Poses poses);
  Poses openPosesAt(double time) const;
  Poses posesAt(double time);
  void note(Sample& sample);
  void transfer(StateTape& tape);
  void transferFigures(StateTape& tape);
  void saveState();
  void goOnFrom(const RunState& state);
  void endWith(const Sample& shown);
  bool goesOn();
  void end(Outcome outcome, std::string reason);
  /// What springs and ligaments hold at the start and at the end.
  void noteElasticity() {
    const Subject& shown = result_.trajectory;
    if (shown.hingeSprings.empty()) return;
    result_.elasticity =
        elasticityOf(shown.hingeSprings, shown.ligaments, startPoses_, motion_.poses);
  }
  /// Whether springs at hinges may move bricks; expansion would drive them on for ever.
  bool hingesPull() const { return scene_.hinges.areOn() && !(drive_ && drive_->isEndless()); }
  void interrupt() { end(Outcome::Interrupted, "ended early by the caller"); }
  void endAtRest();
  std::string holdup() const;
  std::string jointTrouble() const;
  /// Whether a moment is past, up to rounding.
  bool isDue(double moment) const { return moment <= time() + kSameTime * look_; }
  double time() const { return static_cast<double>(lookCount_) * look_ + sinceLook_; }
  double nextLength() const;
  void passTime();
  bool hasSprings() const { return scene_.actuation.drive == Drive::Target && target_; }
  /// Springs without stiffness damp alone, but a led tile is pulled all the same.
  bool pullsToTarget() const {
    return hasSprings() && (scene_.springs.pull() || scene_.path.kind == PathKind::Led);
  }
  /// To the target headed for at present.
  double currentTargetError() const {
    return target_ ? targetError(*target_, bricks_, motion_.poses) : 0;
  }
  /// Whether an error is no nearness: the target then counts as missed, whatever keeps it away.
  bool isFar(double error) const { return error > kFarShare * tileSize_; }
  bool isImmobile() const;
  std::string lateness() const;
  /// Whether a target is pulled to and reached as nearly as can be.
  bool hasArrived() const {
    const double error = currentTargetError();
    return pullsToTarget() && error <= reachableError() && !isFar(error);
  }
  /// What counts as having arrived.
  double reachableError() const { return leastError_ + kNearShare * tileSize_; }
  double spentSeconds() const;

  const Scene& scene_;
  RunObservers observers_;
  Checkpoints* checkpoints_;
  std::vector<Brick> bricks_;
  std::vector<Pivot> pivots_;
  std::vector<Pivot> exactPivots_;  // of joints in whose place no ligament stands
  Motion motion_;
  Poses startPoses_;                 // joints closed unless they give
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
  std::unique_ptr<DriveForce> drive_;     // null where springs to the target drive, or nothing
  Expansion opening_;                     // until openedAt_
  TimelineRunner timeline_;
  AdaptiveStiffness stiffness_;
  TimedLoads actuation_;
  bool hasTolerance_;  // in time, where steps are not fixed
  double look_;        // seconds after which steps end at the latest, at multiples of it
  double length_;      // of the last step, or of that in work: what is due ends steps too
  double size_;
  double tileSize_;
  TargetSpringSettings springSettings_;
  AssembledState nearest_;
  RunFigures figures_;
  std::optional<RunMechanics> mechanics_;  // where samples are taken that can have them
  long lookCount_ = 0;                     // pauses included
  double sinceLook_ = 0;                   // seconds
  long sampleCount_ = 0;                   // samples taken
  double lastSampleTime_ = 0;              // seconds
  Motion before_;                          // at the start of the step
  bool wasSmooth_ = false;                 // the last step kept its tolerance throughout
  std::unique_ptr<Dynamics> projection_;   // closes joints of states between steps
  Nudged nudged_ = Nudged::No;
  double restTime_ = 0;  // seconds
  double restNeeded_;    // seconds of rest that count; longer after each that was no rest
  bool isTrial_ = false;
  std::optional<SymmetricStates> symmetries_;  // that states are to keep
  bool misfit_ = false;                        // joints could not be closed
  bool heldOpen_ = false;                      // for bricks that are in the way
  double pushedAtStart_ = 0;   // metres that closing the joints pushed bricks into each other
  Poses jamStart_;             // where steps began to fail however short; empty while they do not
  double earlierSeconds_ = 0;  // of CPU time, in the processes before this one
  double startSeconds_ = 0;    // CPU time of the thread when this one began
  bool isAskedToEnd_ = false;
  bool isReplayed_ = false;  // ended among the samples of the processes before this one
  bool ended_ = false;
  DeploymentResult result_;
};

}  // namespace kirireel
