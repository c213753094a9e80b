/// How near a jointed model can come to its target at all.
#pragma once

#include "sim/scene/scene.h"

namespace kirireel {

/// The target error of the joint-closed state nearest to the target, metres: every tile is put
/// where it fits its target best, the joints are closed from there, and the scene's springs pull
/// until nothing moves, joints exact. Zero where the target's own data close. Contacts, ground and
/// gravity are left out. Negative without a target.
double assembledFloor(const Scene& scene);

}  // namespace kirireel
