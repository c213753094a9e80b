/// Results of a finished run.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/base/step_report.h"
#include "sim/brick/hinge.h"
#include "sim/mechanics/load_path.h"
#include "sim/run/assembled_state.h"
#include "sim/run/path_evaluation.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

/// How a run ended.
enum class Outcome {
  Settled,      ///< everything came to rest (at the target, or without further forces)
  Locked,       ///< at rest before the target (see arrival.h) or before full extension
  OutOfTime,    ///< the duration ended while something still moved
  Diverged,     ///< a pose or velocity exceeded all bounds
  Interrupted,  ///< the caller stopped the run
};

/// "settled", "locked", "out_of_time", "diverged", "interrupted".
std::string toString(Outcome outcome);

/// The text of the last event of a run: its outcome and the reason. Summaries repeat both.
std::string endText(Outcome outcome, const std::string& reason);

/// Name of DeploymentResult::assembledError in files.
inline constexpr const char* kAssembledError = "assembled_error";

/// How accurate a run was. Lengths in metres.
struct Accuracy {
  double jointGapMax = 0;      ///< largest of any pivot in any step or sample
  double jointGapMean = 0;     ///< mean over pivots, of the start and all steps
  double jointGapEnd = 0;      ///< largest at the end
  double jointOpeningMax = 0;  ///< largest while joints were compliant; 0 if always exact
  double assemblyMove = 0;     ///< largest move of a vertex when an open start was closed
  /// Target error at the start; see targetError(). 0 without a target, as are the next three.
  double targetErrorStart = 0;
  /// Target error after the last step.
  double targetErrorEnd = 0;
  /// The smallest target error in any step or sample.
  double targetErrorMin = 0;
  /// No arrangement of rigid tiles has a smaller error; see rigidBound().
  double rigidBound = 0;
  double springsRestError = 0;  ///< at the springs' equilibrium near the target, without contacts
  /// Deepest overlap in any sample, and at ten times between two samples; see
  /// StateInterpolator::momentsBetween().
  double penetrationMax = 0;
  double penetrationOutsidePivotsMax = 0;  ///< the same without the corners that bricks share
  /// The same, minus the pair's overlap at the start, at the end of any step and at ten times
  /// within it. It does not depend on the samples, and decides whether a run counts as successful.
  double penetrationGrownMax = 0;

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

/// The cost of a run.
struct DeployCost {
  StepReport took;              ///< all steps
  double cpuSeconds = 0;        ///< of the deploying thread, without the search for a path
  double cpuSecondsSearch = 0;  ///< for the assembled error and the path
  double searchWork = 0;        ///< work of all candidates, multiplications
  /// Limit of the search work, multiplications. Infinite if none was set.
  double searchLimit = std::numeric_limits<double>::infinity();

  void transfer(StateTape& tape) { tape.transfer(took); }
};

/// All results of a finished run.
struct DeploymentResult {
  trajectory::Trajectory trajectory;     ///< the recorded motion
  Outcome outcome = Outcome::OutOfTime;  ///< how it ended
  std::string reason;                    ///< one line: why it ended
  /// Whether the run ended at its target. Absent if there is no pull to a target.
  std::optional<bool> atTarget;
  /// Why the run is not successful, in one line; empty if it is. Reasons: the target is missed,
  /// bricks with contacts overlap, or the budget ended the search.
  std::string shortfall;
  Accuracy accuracy;  ///< gaps, errors and overlaps, metres
  /// Largest move of a vertex at any sample if the tolerance is divided by a hundred, tiles. Absent
  /// if not measured (SolverSettings::measuresTimeError), or if the run kept no tolerance.
  std::optional<double> timeError;
  DeployCost cost;                                ///< counted and in CPU seconds
  std::optional<brick::Elasticity> elasticity;    ///< absent if no hinge has a spring
  std::optional<mechanics::LoadCurve> loadCurve;  ///< only for scenes with grips
  scene::Needs needs;                             ///< modelled features, with reasons
  scene::PathSettings path;                       ///< the path taken, never Auto
  std::string pathReason;                         ///< one short phrase: why this path
  std::vector<PathEvaluation> candidates;         ///< kinematic paths that were tried, in order
  /// The smallest target error with closed joints, metres. < 0 without a target.
  double assembledError = -1;
  std::vector<BlockingPair> blocking;  ///< pairs of bricks that overlap at the target
  std::vector<std::string> warnings;   ///< about the target, one line each
};

/// Receives each sample, including the last. Return false to stop the run. Pending samples and the
/// last one are still delivered.
using SampleObserver = std::function<bool(const trajectory::Sample&)>;

}  // namespace kirireel::run
