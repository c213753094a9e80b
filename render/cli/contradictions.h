/// Options that make no sense together.
///
/// What an option needs stands with the settings of a scene (sim/scene/settings.h).
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace kirireel {

struct Scene;

/// Throws InputError for an option that was given, on the command line or in a scene file, although
/// another choice leaves it without effect: what it needs, and that it can be left away. To be
/// called once all settings are read.
void requireConsistent(const CLI::App& command, const Scene& scene);

/// The same for how a video's time follows the run. --speed needs --pace real, --length an even
/// pace.
void requireConsistentPace(const CLI::App& command);

/// Whether an option means anything, its name with hyphens, beside the scene's other choices. True
/// for options that are no settings of a scene. The fingerprint of a run leaves out what has no
/// effect.
bool hasEffect(const std::string& option, const Scene& scene);

}  // namespace kirireel
