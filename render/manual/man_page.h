/// Man pages, from the descriptions of the commands.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/cli/command_tree.h"

namespace kirireel {

/// A file's name and its text.
using NamedText = std::pair<std::string, std::string>;

/// The program's page and one for each of its commands, in the language of man(7): kirireel.1,
/// kirireel-record.1 and so on. Commands below a command are sections of its page. All in section
/// 1, user commands. `version` is of the program, for the foot of the page.
std::vector<NamedText> manPages(const CommandDescription& program, const std::string& version);

}  // namespace kirireel
