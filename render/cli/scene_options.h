/// Options that add to the model: targets, pins, other joints, and the scene file.
#pragma once

#include <filesystem>

#include "sim/scene/scene_file.h"
#include "sim/scene/scene_parts.h"

namespace CLI {
class App;
}

namespace kirireel {

/// What the command line adds to a scene before it can run. Parts are kept as they were typed: the
/// model, whose numbers they use, has not been read yet.
struct SceneRequest {
  std::filesystem::path file;  ///< of --scene; empty when not given
  SceneParts parts;
};

/// Adds all settings of a scene, see sceneSettings(). The scene must outlive the parsing. What is
/// typed is written into the scene while the command line is parsed; ranges are checked there.
void addSceneOptions(CLI::App& command, Scene& scene);

/// Adds --scene, --target, --pin, --fix and --link. The request must outlive the parsing. Adds
/// --no-align too, which writes into `alignment`. Both must outlive the parsing.
void addSceneRequestOptions(CLI::App& command, SceneRequest& request, StartAlignment& alignment);

/// The scene file that was named, else scene.toml in the model's folder; it need not be there.
std::filesystem::path sceneFileOf(const std::filesystem::path& modelFolder,
                                  const SceneRequest& request);

/// Reads the scene file that was named, else scene.toml in the model's folder where there is one,
/// into what the command's options point at, the scene's timeline, its obstacles and its grips.
/// Returns it, or an empty one. To be called after parsing. Throws InputError.
SceneFile readSceneFileOf(CLI::App& command, const std::filesystem::path& modelFolder,
                          const SceneRequest& request, Scene& scene);

}  // namespace kirireel
