/// The drive of a run with dynamics: its current target and the phases of the path to it.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"
#include "sim/run/assembled_state.h"
#include "sim/run/dynamics.h"
#include "sim/run/forces.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/run_motion.h"
#include "sim/scene/scene.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// The current target.

/// The current target of a run and its tolerance. A timeline may set another target. Errors are in
/// metres, see targetError().
class CurrentTarget {
 public:
  /// No target before set(). Keeps a reference to `bricks`. `nearest`: for the model's own target.
  CurrentTarget(const SceneBricks& bricks, const AssembledState& nearest)
      : bricks_(bricks), own_{nearest.error, nearest.restError}, ownPoses_(nearest.poses) {}

  /// Sets these tiles as target, one per brick, and keeps a pointer to them. Null selects the
  /// model's own target, or no target if the model has none. `from`: the current poses.
  void set(const std::vector<model::Tile>* tiles, const Poses& from);

  /// One tile per brick. Null if there is no target.
  const std::vector<model::Tile>* tiles() const { return tiles_; }
  /// Target error of these poses. 0 if there is no target.
  double error(const Poses& poses) const;
  /// Target error when the target was set.
  double startError() const { return startError_; }
  /// Whether an error is that of the equilibrium of the scene's springs near the target.
  bool isAtSpringEquilibrium(double error) const;
  /// Whether no known state with closed joints has a smaller error.
  bool isNearest(double error) const;
  /// The smallest known error of a state with closed joints.
  double nearestError() const { return least().nearest; }
  /// The state with this error. Null if it is unknown.
  const Poses* nearestPoses() const { return isOwn() && !ownPoses_.empty() ? &ownPoses_ : nullptr; }
  /// Records an error of the model's own target that a state with closed joints has reached.
  void noteOwnError(double error) { own_.nearest = std::min(own_.nearest, error); }

  /// Whether the scene has springs to a target. Springs without stiffness only damp.
  bool hasSprings() const {
    return bricks_.scene.actuation.drive == scene::Drive::Target && tiles_;
  }
  /// Whether a force pulls to the target: springs with stiffness, or the guide's springs.
  bool isPulledTo() const;
  /// Whether it is the model's own target.
  bool isOwn() const;
  /// Whether there is a pull to the target and the bricks have arrived; see arrival.h.
  bool hasArrived(const Poses& poses) const;

  /// Records or plays back which of the scene's targets is current.
  void transfer(StateTape& tape);

 private:
  /// Errors of states with closed joints, metres.
  struct LeastErrors {
    double nearest = 0;  ///< the smallest known error
    double rest = 0;     ///< at the equilibrium of the scene's springs
  };

  const LeastErrors& least() const { return isOwn() ? own_ : other_; }

  const SceneBricks& bricks_;
  LeastErrors own_;
  Poses ownPoses_;     // the nearest state to the model's own target
  LeastErrors other_;  // for a target that a timeline has set
  const std::vector<model::Tile>* tiles_ = nullptr;
  double startError_ = 0;
};

// ------------------------------------------------------------------------------------------------
// The scene's own drive.

/// Creates the drive that a scene requests. Null for springs to a target and for no drive. Keeps
/// references to both. Throws InputError if the model lacks the data that the drive needs.
std::unique_ptr<DriveForce> makeDriveForce(const scene::Scene& scene,
                                           const std::vector<brick::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// Phases of the path to a target.

/// The current drive of the bricks. A guided path goes through these phases from one target to the
/// next. All other runs are always in the last phase.
enum class Phase {
  Open,    ///< bricks are pushed apart to make room
  Guide,   ///< springs guide every tile along its path, joints exact or compliant
  Close,   ///< compliant joints stiffen until they are closed and held exactly
  Settle,  ///< the scene's own drive acts until the bricks are at rest
};

/// The moving target of a guide: one tile per brick at a progress from 0 to 1.
using MovingTarget = std::function<std::vector<model::Tile>(double progress)>;

/// Guides the tiles of a run to their target. Springs pull every tile to a target that moves.
/// Rotations have more weight than positions: a mechanism that rotates has to leave the straight
/// lines. Joints may be compliant meanwhile. At the end they stiffen until almost closed.
class PathFollower {
 public:
  /// Keeps a reference to `bricks`. `beginTime`: seconds. The scene has PathKind::Guided.
  PathFollower(const scene::Scene& scene, const std::vector<brick::Brick>& bricks,
               MovingTarget target, double beginTime);

  /// Sets the moving target and the joint stiffness for the step that ends at `time` (seconds of
  /// the run). Returns the phase of this step. Settle: the path has ended, and the joints have
  /// their final stiffness, ready to be closed and held exactly.
  Phase prepareStep(double time, Dynamics& dynamics);

  /// The springs of the guide.
  const TargetSprings& springs() const { return springs_; }

 private:
  scene::PathSettings path_;
  double beginTime_;
  double placeStiffness_;  // of the guide's springs, N/m
  MovingTarget target_;
  TargetSprings springs_;
};

/// The drive of a run, phase by phase: expansion, guide springs, and the scene's own drive. Springs
/// to a target are stiffened when they stall.
class RunDrive {
 public:
  /// Keeps references to all. `guide`: the path along which tiles are guided to the model's own
  /// target; null for each tile's own rigid motion. Throws InputError if the model lacks the data
  /// that the scene's drive needs.
  RunDrive(const SceneBricks& bricks, const StepClock& clock, const MechanismPath* guide = nullptr);

  /// The phase of the current step, or of the last one.
  Phase phase() const { return phase_; }
  /// Whether a phase before the scene's own drive is active.
  bool isOnPath() const { return phase_ != Phase::Settle; }
  /// Whether joints are compliant by request.
  bool jointsAreCompliant() const;

  /// Starts the phases of the path from these poses to a target.
  void startTowards(const CurrentTarget& target, const Poses& from);
  /// Enters the phase of the next step, whose length is known to the clock, and prepares it.
  /// Returns whether the path has ended and its joints should be closed.
  bool beginStep(const CurrentTarget& target, const Poses& poses, Dynamics& dynamics);
  /// Time at which the phase ends by itself, seconds. Infinity if it does not.
  double nextMoment() const;

  /// Adds the drive's load on every brick at these poses.
  void addLoads(const Poses& poses, std::vector<brick::Load>& loads) const;
  /// Energy stored in these poses, joules.
  double energy(const Poses& poses) const;
  /// Adds the part of the drive without stored energy to every brick's force, newtons.
  void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const;
  /// Whether the scene's own drive never ends by itself.
  bool isEndless() const { return drive_ && drive_->isEndless(); }

  /// Adaptive stiffness of the springs to the target.
  AdaptiveStiffness& stiffness() { return stiffness_; }
  /// The same, read only.
  const AdaptiveStiffness& stiffness() const { return stiffness_; }

  /// `target` must be as recorded, or already played back.
  void transfer(StateTape& tape, const CurrentTarget& target);

 private:
  void pullTo(const std::vector<model::Tile>& target);
  void guideTo(const CurrentTarget& target);
  const DriveForce* activeDrive() const;
  const TargetSprings* activeSprings() const;

  const SceneBricks& bricks_;
  const StepClock& clock_;
  const MechanismPath* guide_;
  std::unique_ptr<DriveForce> drive_;  // null for springs to the target, or no drive
  Expansion opening_;
  Phase phase_ = Phase::Settle;
  double openedAt_ = 0;                   // time when opening ends, seconds
  Poses departure_;                       // poses when the target was set or opening ended
  double departedAt_ = 0;                 // time of these poses, seconds
  std::optional<PathFollower> follower_;  // only while tiles are guided
  std::optional<TargetSprings> springs_;  // to the target
  AdaptiveStiffness stiffness_{false};
};

}  // namespace kirireel::run
