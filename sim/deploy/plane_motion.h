/// Flat sheets whose joints leave them no motion in their plane.
#pragma once

#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// The motions out of its plane of a planar scene that has none in it. 0 if the scene is in space,
/// `--planar on` keeps it in its plane, it has a motion there, or the motions cannot be counted.
/// Costs up to two singular value decompositions of the joints' Jacobian.
int motionsOutOfPlane(const scene::Scene& scene);

/// Throws InputError if nothing moves a sheet without target that can only leave its plane, see
/// motionsOutOfPlane().
void requireDriveOutOfPlane(const scene::Scene& scene);

/// Moves a planar scene without target to space if it has no motion in its plane: sets
/// Scene::spaceReason. Throws InputError if nothing moves it. Scenes with a geometric path are not
/// changed.
void leaveLockedPlane(scene::Scene& scene);

}  // namespace kirireel::deploy
