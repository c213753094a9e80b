/// Scripts by which shells complete the command line, from the descriptions of the commands.
#pragma once

#include <string>

#include "render/cli/command_tree.h"

namespace kirireel {

/// For bash (with or without the package bash-completion), zsh and fish. Commands, options, the
/// values of options that have a list of them, and names of files elsewhere are completed. Each is
/// the text of a file, to be sourced (bash) or put into the shell's folder of completions (zsh,
/// fish).
std::string bashCompletion(const CommandDescription& program);
std::string zshCompletion(const CommandDescription& program);
std::string fishCompletion(const CommandDescription& program);

}  // namespace kirireel
