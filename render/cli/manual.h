/// Documentation made from the descriptions of the commands: man pages, completions, docstrings and
/// type stubs.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/cli/command_line.h"

namespace kirireel::cli {

// ------------------------------------------------------------------------------------------------
// Man pages, from the descriptions of the commands.

/// A file's name and its text.
using NamedText = std::pair<std::string, std::string>;

/// The program's page and one for each of its commands, in the language of man(7): kirireel.1,
/// kirireel-record.1 and so on. Commands below a command are sections of its page. All in section
/// 1, user commands. `version` is of the program, for the foot of the page.
std::vector<NamedText> manPages(const CommandDescription& program, const std::string& version);

// ------------------------------------------------------------------------------------------------
// Scripts by which shells complete the command line, from the descriptions of the commands.

/// For bash (with or without the package bash-completion), zsh and fish. Commands, options, the
/// values of options that have a list of them, and names of files elsewhere are completed. Each is
/// the text of a file, to be sourced (bash) or put into the shell's folder of completions (zsh,
/// fish).
std::string bashCompletion(const CommandDescription& program);
/// The completion for zsh.
std::string zshCompletion(const CommandDescription& program);
/// The completion for fish.
std::string fishCompletion(const CommandDescription& program);

// ------------------------------------------------------------------------------------------------
// Docstrings and type stubs of the Python module, made from the descriptions of the commands whose
// options it takes.

/// Options of `record` that a run in Python does not have: output folder, reports and the reading
/// of the model, which are arguments of other functions. Keys, with underscores.
const std::vector<std::string>& optionsNotForRuns();

/// Options of `render` that a single picture does not have: all except size, library, style and
/// camera. Keys, with underscores.
std::vector<std::string> optionsNotForPictures(const CommandDescription& program);

/// Docstrings, with each option's unit and default. Groups and options come in the order of the
/// help.
std::string deployDoc(const CommandDescription& program);
/// The docstring of kirireel.generate().
std::string generateDoc(const CommandDescription& program);
/// The docstring of kirireel.render().
std::string renderDoc(const CommandDescription& program);

/// The text of __init__.pyi. Types for editors and checkers such as mypy; Python itself never reads
/// it.
std::string pythonStub(const CommandDescription& program);

}  // namespace kirireel::cli
