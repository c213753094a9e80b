/// What drives the bricks of a run with dynamics: the target that it heads for, and the phases on
/// the way there.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/forces.h"
#include "sim/deploy/run_motion.h"
#include "sim/model/brick.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// The target headed for.

/// The target that a run heads for at present, and what counts as there. A timeline may set
/// another. Errors are in metres, see targetError().
class CurrentTarget {
 public:
  /// There is none before set(). `bricks` must outlive this. `nearest`: of the model's own target.
  CurrentTarget(const SceneBricks& bricks, const AssembledState& nearest)
      : bricks_(bricks), own_{nearest.error, nearest.restError}, ownPoses_(nearest.poses) {}

  /// Heads for these tiles, one a brick, which must outlive this; null: for the model's own, or
  /// nowhere if it has none. `from`: where the bricks are.
  void set(const std::vector<model::Tile>* tiles, const Poses& from);

  /// One tile a brick; null where there is no target.
  const std::vector<model::Tile>* tiles() const { return tiles_; }
  /// From these poses; 0 where there is no target.
  double error(const Poses& poses) const;
  /// When it was set.
  double startError() const { return startError_; }
  /// Whether an error is that of the state in which the scene's springs rest near the target.
  bool isWhereSpringsRest(double error) const;
  /// Whether no state with closed joints is known to be nearer than an error.
  bool isNearest(double error) const;
  /// The error of the nearest state with closed joints that is known.
  double nearestError() const { return least().nearest; }
  /// That state; null if it is not known.
  const Poses* nearestPoses() const { return isOwn() && !ownPoses_.empty() ? &ownPoses_ : nullptr; }
  /// Notes that the model's own target was found to be reached so nearly with closed joints.
  void noteOwnError(double error) { own_.nearest = std::min(own_.nearest, error); }

  /// Whether the scene's springs to a target have one. Those without stiffness damp alone.
  bool hasSprings() const {
    return bricks_.scene.actuation.drive == scene::Drive::Target && tiles_;
  }
  /// Whether something pulls there: springs with a stiffness, or those that lead tiles.
  bool isPulledTo() const;
  /// Whether it is pulled to, and the bricks have arrived; see arrival.h.
  bool hasArrived(const Poses& poses) const;

  /// Notes which of the scene's targets this is.
  void transfer(StateTape& tape);

 private:
  /// Of states with closed joints, metres.
  struct LeastErrors {
    double nearest = 0;  ///< the least that is known
    double rest = 0;     ///< where the scene's springs rest
  };

  bool isOwn() const;
  const LeastErrors& least() const { return isOwn() ? own_ : other_; }

  const SceneBricks& bricks_;
  LeastErrors own_;
  Poses ownPoses_;     // of the nearest state to the model's own target
  LeastErrors other_;  // of a target that a timeline has set
  const std::vector<model::Tile>* tiles_ = nullptr;
  double startError_ = 0;
};

// ------------------------------------------------------------------------------------------------
// The scene's own drive.

/// The drive that a scene asks for; null where that is the target or nothing. Scene and bricks must
/// outlive it. Throws InputError where the model does not have what the drive needs.
std::unique_ptr<DriveForce> makeDriveForce(const scene::Scene& scene,
                                           const std::vector<model::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// The phases on the way to a target.

/// What moves the bricks of a run at present. A guided path goes through all of these from
/// each target to the next, any other run is in the last from its start.
enum class Phase {
  Open,    ///< bricks are pushed apart, which makes room
  Guide,   ///< springs lead every tile along its own motion, joints exact or compliant
  Close,   ///< joints that were compliant stiffen, until they are closed and held exactly
  Settle,  ///< the scene's own drive acts, until nothing moves
};

/// the springs of the guide the scene's tiles: as its path says, else by its springs' frequency.
scene::TargetSpringSettings leadingSprings(const scene::Scene& scene);

/// The stiffness of joints that the scene's path makes compliant, N/m; infinite if they are exact.
double jointStiffnessOf(const scene::Scene& scene, const std::vector<model::Brick>& bricks);

/// Leads the tiles of a run to their target: springs pull every tile after a target that moves
/// along the tile's own rigid motion, by the turn more than by the place (a mechanism that turns
/// has to swing out on its way, which straight lines do not know). Joints may be compliant
/// meanwhile; at the end they stiffen until hardly anything of their openings is left.
class PathFollower {
 public:
  /// `bricks` must outlive this. `start`: where the path begins, joints closed unless they are
  /// compliant; `beginTime`: when, seconds. `target`: where it leads, one tile a brick. The scene
  /// has PathKind::Guided.
  PathFollower(const scene::Scene& scene, const std::vector<model::Brick>& bricks,
               const Poses& start, const std::vector<model::Tile>& target, double beginTime);

  /// Sets the moving target and the joints' stiffness for the step that ends at `time` (seconds
  /// of the run), and says which phase that step is in. Settle: the path is done, the joints are as
  /// stiff as they get, ready to be closed and held exactly.
  Phase prepareStep(double time, Dynamics& dynamics);

  /// the springs of the guide.
  const TargetSprings& springs() const { return springs_; }

 private:
  scene::PathSettings path_;
  double beginTime_;
  double placeStiffness_;  // of leading springs, N/m
  TargetGuide guide_;
  TargetSprings springs_;
};

/// What drives the bricks of a run, phase by phase: expansion that opens a sheet, springs that lead
/// its tiles, and the scene's own drive, whose springs to a target are stiffened when they stall.
class RunDrive {
 public:
  /// Both must outlive this. Throws InputError where the model does not have what the scene's drive
  /// needs.
  RunDrive(const SceneBricks& bricks, const StepClock& clock);

  /// What moved the bricks in the last step, or moves them in that in work.
  Phase phase() const { return phase_; }
  /// Whether something else drives the tiles than the scene's own drive.
  bool isOnPath() const { return phase_ != Phase::Settle; }
  /// Whether joints are compliant on purpose.
  bool jointsAreCompliant() const;

  /// Begins the phases that lead from these poses to a target.
  void headFor(const CurrentTarget& target, const Poses& from);
  /// Enters the phase of the step to come, whose length the clock knows, and makes ready for it.
  /// Returns whether the path has come to its end, so that its joints are to be closed.
  bool beginStep(const CurrentTarget& target, const Poses& poses, Dynamics& dynamics);
  /// When the phase ends by itself, however steps lie, seconds; infinity where it does not.
  double nextMoment() const;

  /// Adds the drive's load on every brick at these poses.
  void addLoads(const Poses& poses, std::vector<model::Load>& loads) const;
  /// Energy that it stores in these poses, joules.
  double energy(const Poses& poses) const;
  /// Adds to every brick's force, newtons, what of the drive stores no energy.
  void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const;
  /// Whether the scene's own drive drives bricks on however far they have come.
  bool isEndless() const { return drive_ && drive_->isEndless(); }

  /// How much stiffer the springs to the target have become.
  AdaptiveStiffness& stiffness() { return stiffness_; }
  /// The same, to be read.
  const AdaptiveStiffness& stiffness() const { return stiffness_; }

  /// `target` as it was recorded, or is played back already.
  void transfer(StateTape& tape, const CurrentTarget& target);

 private:
  void pullTo(const std::vector<model::Tile>& target);
  void leadTo(const std::vector<model::Tile>& target);
  const DriveForce* presentDrive() const;
  const TargetSprings* presentSprings() const;

  const SceneBricks& bricks_;
  const StepClock& clock_;
  std::unique_ptr<DriveForce> drive_;  // null where springs to the target drive, or nothing
  Expansion opening_;
  Phase phase_ = Phase::Settle;
  double openedAt_ = 0;    // when opening ends, seconds
  Poses departure_;        // where the bricks were when the target was set, or opening ended
  double departedAt_ = 0;  // when that was, seconds
  std::optional<PathFollower> follower_;  // while tiles are guided
  std::optional<TargetSprings> springs_;  // to the target
  AdaptiveStiffness stiffness_{false};
};

}  // namespace kirireel::deploy
