/// How near a jointed model was found to come to its target.
#pragma once

#include <functional>

#include "sim/deploy/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Joint-closed states near the target. Without a target the errors are negative, and there are no
/// poses.
struct AssembledState {
  double error = -1;      ///< the least target error found, metres: an upper bound of the least
  Poses poses;            ///< where it was found, one a tile
  double restError = -1;  ///< where the scene's springs come to rest near the target, metres
  Poses restPoses;        ///< that state
};

/// Joint-closed states near the target. First every tile is put where it fits its target best, the
/// joints are closed from there, and the scene's springs pull until nothing moves, joints exact:
/// the state of rest, which has the least sum of squares nearby. Then bricks that are farther off
/// are pulled more and more, those nearer less (Lawson's weights, as in rigid_bound.cpp): that
/// leads towards the least largest error. Where this leaves something, the springs pull from the
/// start, too. The best of all states is kept, the start among them. Both errors are zero where the
/// target's own data close. In a model whose coordinates were rounded, joints are closed within the
/// rounding only, see rounded_joints.h. Contacts, ground and gravity are left out. Ends early when
/// the budget is spent or `goesOn`, which may be empty, returns false.
AssembledState assembleAtTarget(const Scene& scene, SearchBudget& budget,
                                const std::function<bool()>& goesOn = {});

/// The same within the scene's own budget for a search.
AssembledState assembleAtTarget(const Scene& scene);

}  // namespace kirireel
