/// Fonts by the name of their family.
#pragma once

#include <filesystem>
#include <string>

namespace kirireel {

/// The file of a family's upright font of usual weight, as fontconfig knows it. Throws InputError
/// that names the nearest family when there is none of this name; case does not count. Style and
/// weight are fontconfig's defaults.
std::filesystem::path fontFile(const std::string& family);

}  // namespace kirireel
