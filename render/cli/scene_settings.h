/// scene.toml as a command's options: every long option is a key of the table that its group names.
#pragma once

#include <filesystem>

#include "sim/scene/scene_file.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Reads a scene file into what a command's options point at: `brick_friction = 0.3` in
/// [environment] is `--brick-friction 0.3`. Options that the command line gave stay as they are.
/// Returns the whole file. To be called after parsing.
/// Throws InputError with file:line:column for unknown keys (suggesting the nearest), keys in the
/// wrong table, and values that the option refuses.
SceneFile applySceneFile(CLI::App& command, const std::filesystem::path& file);

}  // namespace kirireel
