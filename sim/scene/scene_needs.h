/// What a scene needs, with reasons.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Whether a scene's deployment is geometry: it goes to its target, or to full extension without
/// one, and nothing asked for needs mass, damping or time (speeds at the start, gravity, ground,
/// obstacles, friction, a timeline, other springs or damping than the default, another solver).
/// Else `reason` names it.
bool isQuasiStatic(const Scene& scene, std::string& reason);

/// Decides what the scene needs. A scene is planar when start and target lie in horizontal planes
/// at one height, no tile faces the other way at the target, and nothing pushes out of the plane
/// (see the reasons returned). O(n) in the vertices.
Needs sceneNeeds(const Scene& scene);

}  // namespace kirireel::scene
