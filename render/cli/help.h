/// The pages of --help, at most 80 columns wide.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kirireel::cli {

/// Sets how a program and the commands that are added to it later are described.
void setHelpLayout(CLI::App& program);

/// Takes the word after --help, if there is one after a command, out of the arguments and returns
/// it; empty: none.
std::string takeHelpGroup(std::vector<std::string>& arguments);

/// The page of a command, or of one group of its options. A long page is cut to its groups and
/// their most used options; the group "all" gives the whole. Throws InputError for a group that
/// does not exist.
std::string helpText(const CLI::App& command, const std::string& group);

}  // namespace kirireel::cli
