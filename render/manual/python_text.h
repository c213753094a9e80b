/// What the Python module says of itself: docstrings and type stubs, from the descriptions of the
/// commands whose options it takes.
#pragma once

#include <string>
#include <vector>

#include "render/cli/command_tree.h"

namespace kirireel {

/// Options of `record` that a run in Python has not: where files go and how it reports, which its
/// functions say, and how the model is read. Keys, with underscores.
const std::vector<std::string>& optionsNotForRuns();

/// Options of `render` that a single picture has not: all but its size and library, its style and
/// its camera. Keys, with underscores.
std::vector<std::string> optionsNotForPictures(const CommandDescription& program);

/// Docstrings, with each option's unit and default. Groups and options come in the order of the
/// help.
std::string deployDoc(const CommandDescription& program);
std::string generateDoc(const CommandDescription& program);
std::string renderDoc(const CommandDescription& program);

/// The text of __init__.pyi. Types for editors and checkers such as mypy; Python itself never reads
/// it.
std::string pythonStub(const CommandDescription& program);

}  // namespace kirireel
