/// What a run adds to the model that was read: other targets, pins, links, fixed joints.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// Additions as they were asked for; the numbers are not checked yet.
struct SceneParts {
  std::vector<std::filesystem::path> targets;  ///< a chain: each is reached before the next; the
                                               ///< last takes the place of the model's target
  std::vector<int> pinned;                     ///< tiles fixed to the world from the start
  std::vector<std::array<int, 2>> fixed;       ///< pairs of tiles that move as one
  std::vector<std::array<int, 4>> links;       ///< tile, vertex, tile, vertex
};

/// Completes a scene whose model was just read: reads targets, moves the start onto the target
/// unless scene.alignment says otherwise (by the tiles that are pinned from the start on, where
/// some are, else by all) and notes by how much, adds joints and pins, reads the targets that the
/// timeline names and the file of hinges, checks the grips, and checks the timeline against the
/// model. Warnings about targets that are not quite congruent are appended. Throws InputError for
/// files that hold no target of this model and for numbers that name no tile or vertex.
void completeScene(const SceneParts& parts, Scene& scene, std::vector<std::string>& warnings);

}  // namespace kirireel
