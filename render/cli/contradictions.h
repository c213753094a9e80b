/// Options that make no sense together.
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

/// The same for how a video's time follows the run.
void requireConsistentPace(const CLI::App& command);

/// Whether an option means anything, its name with hyphens, beside the scene's other choices.
bool hasEffect(const std::string& option, const Scene& scene);

}  // namespace kirireel
