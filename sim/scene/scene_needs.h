/// What a scene needs, with reasons.
#pragma once

#include <optional>
#include <string>

#include "sim/model/sheet_frame.h"
#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Whether a scene's deployment is geometry: it goes to its target, or to full extension without
/// one, and nothing asked for needs mass, damping or time (speeds at the start, gravity, ground,
/// obstacles, friction, a timeline, other springs or damping than the default, another solver).
/// Else `reason` names it.
bool isQuasiStatic(const Scene& scene, std::string& reason);

/// Decides what the scene needs. A scene is planar when start and target lie in one plane, no tile
/// faces the other way at the target, and nothing pushes out of the plane (see the reasons
/// returned). O(n) in the vertices.
Needs sceneNeeds(const Scene& scene);

/// The axes in which a planar scene is solved, because they have the sheet in a horizontal plane.
/// nullopt if the world's axes do, or if the scene is not planar. Throws InputError for a ground.
std::optional<model::SheetFrame> ownAxes(const Scene& scene);

/// The scene of a sheet that is not horizontal, in the axes of its frame. Obstacles and the ground
/// stay: no such scene is planar.
Scene inAxes(const model::SheetFrame& frame, Scene scene);

}  // namespace kirireel::scene
