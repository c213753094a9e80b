/// What tells one order to record from another.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// SHA-256 of all that decides a run's bytes: the program's version, the arguments but for those
/// that say where files go and what is printed, the scene file, and the model and targets that were
/// read.
std::string orderFingerprint(const std::vector<std::string>& arguments,
                             const std::filesystem::path& sceneFile, const Scene& scene);

}  // namespace kirireel
