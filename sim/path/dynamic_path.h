/// Selects the path of a run with dynamics.
#pragma once

#include <string>
#include <vector>

#include "sim/path/planner.h"
#include "sim/run/result.h"
#include "sim/run/search.h"

namespace kirireel::path {

/// The selected path and the reason for the selection.
struct DynamicPath {
  scene::PathSettings path;                                    ///< Straight or Guided
  std::string reason;                                          ///< one short phrase for the summary
  scene::ContactFilter contacts = scene::ContactFilter::None;  ///< of the run; never Auto
  PlannedPath guide;  ///< the kinematic path that guides the tiles; empty if none was searched
};

/// Selects a path if the scene leaves the choice to the program. A path that the scene names is
/// kept. A straight pull is tried first, as a complete run without contacts, ground and gravity. It
/// is taken if it reaches the equilibrium of the scene's springs near the target, and bricks that
/// may touch do not overlap. Otherwise springs guide the tiles along the path of planPath(). If
/// there is no pull to a target and the tiles' misfit jams exact joints, joints are compliant.
/// `observer` may be empty. `trials` holds the result of an earlier trial, which is not repeated,
/// or receives it.
DynamicPath chooseDynamicPath(const scene::Scene& scene, const run::AssembledState& nearest,
                              run::SearchBudget& budget, const run::TrialObserver& observer,
                              std::vector<run::TrialEnd>& trials);

/// Measures the growth of overlaps beyond the start, for the contacts that a scene requests.
class OverlapWatch {
 public:
  explicit OverlapWatch(const scene::Scene& scene);

  /// A run's own figures cover all pairs. Here pairs without contacts are excluded.
  void observe(const Poses& poses);
  /// The largest growth so far, metres. 0 if the user switched contacts off.
  double grown(const run::Accuracy& accuracy) const;

 private:
  scene::ContactFilter filter_;
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  trajectory::PenetrationMeter meter_;
  double grown_ = 0;
};

}  // namespace kirireel::path
