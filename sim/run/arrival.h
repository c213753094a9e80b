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

/// Whether a target error, metres, equals the smallest known error with closed joints within the
/// tolerance; see AssembledState.
inline bool isNearest(const model::Model& model, double error, double smallestError) {
  return error <= kArrivalFactor * smallestError + kArrivalTolerance * model::tileSize(model);
}

/// The same within the rounding of the model's coordinates.
inline bool isNearestRounded(const model::Model& model, double error, double smallestError) {
  return isNearest(model, error - roundedReach(model), smallestError);
}

/// Whether a run with this target error, metres, has arrived: no nearer state is known, and the
/// target is within reach.
inline bool hasArrived(const model::Model& model, double error, double smallestError) {
  return isNearestRounded(model, error, smallestError) &&
         error <= kFarError * model::tileSize(model);
}

}  // namespace kirireel::run
