/// When a deployment counts as arrived at its target. The search for a path, the run, the report,
/// `at_target` in summary.json and the exit code all use this definition.
#pragma once

#include "sim/model/model.h"

namespace kirireel::deploy {

/// Of the least error that is known, the largest multiple that counts as arrived.
inline constexpr double kArrivalFactor = 1.05;
/// Added to it, in tiles, for targets that can be reached exactly.
inline constexpr double kArrivalShare = 1e-6;
/// Beyond this error, in tiles, a target counts as missed although nothing nearer is known.
inline constexpr double kFarShare = 0.1;

/// The largest target error that counts as arrived, metres. `leastError`: the least one that is
/// known for closed joints, metres; see AssembledState.
inline double arrivalLimit(const model::Model& model, double leastError) {
  return kArrivalFactor * leastError + kArrivalShare * model::tileSize(model);
}

/// Whether a target error, metres, is as small as the least one that is known.
inline bool isNearest(const model::Model& model, double error, double leastError) {
  return error <= arrivalLimit(model, leastError);
}

/// Whether a run with this target error, metres, has arrived: no nearer state is known, and the
/// target is within reach.
inline bool hasArrived(const model::Model& model, double error, double leastError) {
  return isNearest(model, error, leastError) && error <= kFarShare * model::tileSize(model);
}

}  // namespace kirireel::deploy
