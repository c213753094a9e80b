/// Options that make no sense together.
#pragma once

namespace CLI {
class App;
}

namespace kirireel {

struct Scene;

/// Throws InputError for an option that was given, on the command line or in a scene file, although
/// another choice leaves it without effect: what it needs, and that it can be left away. To be
/// called once all settings are read.
void requireConsistent(const CLI::App& command, const Scene& scene);

}  // namespace kirireel
