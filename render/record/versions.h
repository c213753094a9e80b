/// The versions of the program and of the libraries that shape its results.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace kirireel {

/// The program's own version, e.g. "0.1.0".
std::string programVersion();

/// Names and versions, the program first. They enter the fingerprint of every run: another library
/// may give other bytes.
std::vector<std::pair<std::string, std::string>> allVersions();

/// The same, one "name version" a line.
std::string versionText();

}  // namespace kirireel
