/// How near a jointed model can come to its target at all.
#pragma once

#include "sim/scene/scene.h"

namespace kirireel {

/// A joint-closed state and its distance from the target.
struct AssembledState {
  double error = -1;  ///< target error, metres; negative without a target
  Poses poses;        ///< one a tile; none without a target
};

/// The joint-closed state nearest to the target: every tile is put where it fits its target best,
/// the joints are closed from there, and the scene's springs pull until nothing moves, joints
/// exact. Its error is the assembled error, an upper bound of the least error with closed joints,
/// and zero where the target's own data close. Contacts, ground and gravity are left out.
AssembledState assembleAtTarget(const Scene& scene);

}  // namespace kirireel
