/// scene.toml as a command's options: every long option is a key of the table that its group names.
#pragma once

#include <filesystem>

#include "sim/scene/scene_file.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace kirireel {

/// Reads a scene file into what a command's options point at: `brick_friction = 0.3` in
/// [environment] is `--brick-friction 0.3`. Options that the command line gave stay as they are.
/// Returns the whole file. To be called after parsing.
/// Throws InputError with file:line:column for unknown keys (suggesting the nearest), keys in the
/// wrong table, and values that the option refuses.
SceneFile applySceneFile(CLI::App& command, const std::filesystem::path& file);

/// The key of an option in a file, "brick_friction" for --brick-friction; empty for a place.
std::string settingKey(const CLI::Option& option);

/// Gives an option the values of a setting, unless the option was given before. To be called after
/// parsing. Throws InputError with file:line:column for values that the option refuses. A switch
/// that is false in the file is left as it is.
void applySetting(CLI::Option& option, const SceneSetting& setting);

}  // namespace kirireel
