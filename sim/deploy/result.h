/// What a finished run leaves.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/base/step_report.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/path_evaluation.h"
#include "sim/mechanics/load_path.h"
#include "sim/model/hinge.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

/// How a run ended.
enum class Outcome {
  Settled,      ///< everything came to rest (at the target or where nothing pushes any more)
  Locked,       ///< at rest, yet short of the target (see arrival.h) or of full extension
  OutOfTime,    ///< the duration was used up while something still moved
  Diverged,     ///< a pose or velocity left all bounds
  Interrupted,  ///< the caller asked for an early end
};

/// "settled", "locked", "out_of_time", "diverged", "interrupted".
std::string toString(Outcome outcome);

/// What files call DeploymentResult::assembledError.
inline constexpr const char* kAssembledError = "assembled_error";

/// How accurate a run was. Lengths in metres.
struct Accuracy {
  double jointGapMax = 0;      ///< largest of any pivot in any step or sample
  double jointGapMean = 0;     ///< mean over pivots, of the start and all steps
  double jointGapEnd = 0;      ///< largest at the end
  double jointOpeningMax = 0;  ///< largest while joints were compliant; 0 when always exact
  double assemblyMove = 0;     ///< largest move of a vertex when an open start was closed
  /// The error at the start; see targetError(). 0 without a target, as are the next three.
  double targetErrorStart = 0;
  /// The error after the last step.
  double targetErrorEnd = 0;
  /// The least error in any step or sample.
  double targetErrorMin = 0;
  /// No arrangement of rigid tiles has a smaller error; see rigidBound().
  double rigidBound = 0;
  double springsRestError = 0;  ///< where springs rest near the target, no contacts in their way
  /// Deepest in any sample, and at ten moments between two samples; see
  /// StateInterpolator::momentsBetween().
  double penetrationMax = 0;
  double penetrationOutsidePivotsMax = 0;  ///< the same without the corners that bricks share
  /// Of that, what any pair has beyond its start, at the end of any step and at ten moments within
  /// it. It does not depend on the samples, and decides whether a run counts as done.
  double penetrationGrownMax = 0;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Accuracy>(
        field("joint_gap_max", &Accuracy::jointGapMax, "m"),
        field("joint_gap_mean", &Accuracy::jointGapMean, "m"),
        field("joint_gap_end", &Accuracy::jointGapEnd, "m"),
        field("joint_opening_max", &Accuracy::jointOpeningMax, "m"),
        field("assembly_move", &Accuracy::assemblyMove, "m"),
        field("target_error_start", &Accuracy::targetErrorStart, "m"),
        field("target_error_end", &Accuracy::targetErrorEnd, "m"),
        field("target_error_min", &Accuracy::targetErrorMin, "m"),
        field("rigid_bound", &Accuracy::rigidBound, "m"),
        field("springs_rest_error", &Accuracy::springsRestError, "m"),
        field("penetration_max", &Accuracy::penetrationMax, "m"),
        field("penetration_outside_pivots_max", &Accuracy::penetrationOutsidePivotsMax, "m"),
        field("penetration_grown_max", &Accuracy::penetrationGrownMax, "m"));
  }
};

/// What a run cost.
struct DeployCost {
  StepReport took;              ///< all steps together
  double cpuSeconds = 0;        ///< of the deploying thread, the search for a path apart
  double cpuSecondsSearch = 0;  ///< of finding the assembled error and a path
  double searchWork = 0;        ///< of all candidates, multiplications
  /// Up to which the search could have gone, multiplications; infinite if none was set.
  double searchLimit = std::numeric_limits<double>::infinity();

  /// Records or plays back.
  void transfer(StateTape& tape) { tape.transfer(took); }
};

/// Everything that a finished run leaves.
struct DeploymentResult {
  trajectory::Trajectory trajectory;     ///< what moved, and where to
  Outcome outcome = Outcome::OutOfTime;  ///< how it ended
  std::string reason;                    ///< one line: why it ended so
  /// Whether it ended at the target that it headed for; absent where nothing pulls to a target.
  std::optional<bool> atTarget;
  /// Why the run does not count as done, in one line; empty if it does: the target is missed,
  /// bricks that may touch pass through each other, or the budget ended the search.
  std::string shortfall;
  double forbiddenOverlap = 0;  ///< the one in `shortfall`, metres; 0 if it has none
  Accuracy accuracy;            ///< gaps, errors and overlaps, metres
  /// How far the tolerance's tenth moved a vertex at any sample, tiles; absent where it was not
  /// measured (SolverSettings::measuresTimeError), or where the run kept no tolerance.
  std::optional<double> timeError;
  DeployCost cost;                                ///< counted and in CPU seconds
  std::optional<model::Elasticity> elasticity;    ///< absent where no hinge has a spring
  std::optional<mechanics::LoadCurve> loadCurve;  ///< of a scene with grips
  scene::Needs needs;                             ///< what was modelled, and why
  scene::PathSettings path;                       ///< that was taken, never Auto
  std::string pathReason;                         ///< one short phrase: why
  std::vector<PathEvaluation> candidates;         ///< kinematic paths that were tried, in order
  /// The least target error found with joints closed, metres; negative without a target.
  double assembledError = -1;
  std::vector<BlockingPair> blocking;  ///< bricks in each other's way at the target
  std::vector<std::string> warnings;   ///< about the target, one line each
};

/// Called with each sample, the last included; return false to end the run early. Samples that are
/// due then, and the last one, follow all the same.
using SampleObserver = std::function<bool(const trajectory::Sample&)>;

}  // namespace kirireel::deploy
