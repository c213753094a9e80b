/// What a scene needs and what it can do without, and why.
#pragma once

#include <string>

#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Whether a scene's deployment is geometry: it goes to its target, or to full extension without
/// one, and nothing asked for needs mass, damping or time (speeds at the start, gravity, ground,
/// obstacles, friction, a timeline, other springs or damping than the usual, another solver). Else
/// `reason` says what does.
bool isQuasiStatic(const Scene& scene, std::string& reason);

/// Decides what the scene needs. A scene is planar when start and target lie in horizontal planes
/// at one height, no tile faces the other way at the target, and nothing pushes out of the plane
/// (see the reasons returned). Costs a look at all vertices.
Needs sceneNeeds(const Scene& scene);

}  // namespace kirireel::scene
