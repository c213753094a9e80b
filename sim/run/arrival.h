/// When a deployment counts as arrived at its target. The search for a path, the run, the report,
/// `at_target` in summary.json and the exit code all use this definition.
#pragma once

#include "sim/model/model.h"
#include "sim/run/assembled_state.h"

namespace kirireel::run {

/// Largest multiple of the smallest known error that counts as arrived.
inline constexpr double kArrivalFactor = 1.05;
/// Absolute tolerance in tiles, for targets that can be reached exactly.
inline constexpr double kArrivalTolerance = 1e-6;
/// Above this error, in tiles, a target is missed even if no nearer state is known.
inline constexpr double kFarError = 0.1;

/// The largest target error that counts as arrived, metres. `smallestError`: the smallest known
/// error with closed joints, metres; see AssembledState.
inline double arrivalLimit(const model::Model& model, double smallestError) {
  return kArrivalFactor * smallestError + kArrivalTolerance * model::tileSize(model);
}

/// Whether a target error, metres, equals the smallest known error within the tolerance.
inline bool isNearest(const model::Model& model, double error, double smallestError) {
  return error <= arrivalLimit(model, smallestError);
}

/// Whether a run with this target error, metres, has arrived: no state is known that is nearer by
/// more than the rounding of the model's coordinates, and the target is within reach.
inline bool hasArrived(const model::Model& model, double error, double smallestError) {
  return error <= arrivalLimit(model, smallestError) + roundedReach(model) &&
         error <= kFarError * model::tileSize(model);
}

}  // namespace kirireel::run
