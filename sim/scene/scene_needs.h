/// Needs of a scene, with reasons.
#pragma once

#include <optional>
#include <string>

#include "sim/model/sheet_frame.h"
#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Whether a scene is kinematic: it goes to its target, or to full extension without one, and no
/// setting needs mass, damping or time (speeds at the start, gravity, ground, obstacles, friction,
/// a timeline, other springs or damping than the default, another solver). Otherwise `reason` is
/// that setting.
bool isQuasiStatic(const Scene& scene, std::string& reason);

/// Determines the needs of the scene. It is planar if start and target lie in one plane, no tile is
/// turned over at the target, and nothing pushes out of the plane (see the reasons returned). O(n)
/// in the vertices.
Needs sceneNeeds(const Scene& scene);

/// The scene without gravity, ground, contacts, obstacles and friction.
Scene withoutEnvironment(Scene scene);

/// The axes in which a planar scene is solved, because they have the sheet in a horizontal plane.
/// nullopt if the world's axes do, or if the scene is not planar. Throws InputError for a ground.
std::optional<model::SheetFrame> ownAxes(const Scene& scene);

/// The scene of a sheet that is not horizontal, in the axes of its frame. Obstacles and the ground
/// are not transformed: no scene with them is planar in such a frame.
Scene inAxes(const model::SheetFrame& frame, Scene scene);

}  // namespace kirireel::scene
