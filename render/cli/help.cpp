// CLI11 writes the page of a command. This file wraps its lines and extracts single groups.
#include "render/cli/help.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <sstream>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/option_group.h"
#include "sim/base/error.h"
#include "sim/scene/settings.h"

namespace kirireel::cli {
namespace {

constexpr std::size_t kPageWidth = 80;
constexpr std::size_t kHelpColumn = 26;  // where the explanation of an option starts
constexpr std::ptrdiff_t kPageLines = 48;
constexpr const char* kAllGroups = "all";

/// Shown first in the list of groups.
const std::set<std::string>& mostUsedOptions() {
  static const std::set<std::string> names = {
      "--out",       "--fps",       "--json",    "--verbose",  "--target",   "--unit",
      "--pin",       "--actuation", "--path",    "--contacts", "--ground",   "--gravity",
      "--thickness", "--duration",  "--export",  "--states",   "--joints",   "--size",
      "--grid",      "--frames-at", "--colour",  "--theme",    "--captions", "--brick-colour",
      "--view",      "--zoom",      "--video",   "--length",   "--title",    "--brick-friction",
      "--scene",     "--drive",     "--no-video"};
  return names;
}

/// Breaks a line at its spaces. Later lines start at `indent`.
std::string wrapped(const std::string& line, std::size_t indent) {
  std::string text;
  std::size_t begin = 0;
  std::string margin;
  while (margin.size() + line.size() - begin > kPageWidth) {
    const std::size_t end = line.rfind(' ', begin + kPageWidth - margin.size());
    // A single word may be longer than the page, or follow only spaces.
    if (end == std::string::npos || line.find_first_not_of(' ', begin) >= end) break;
    text += margin + line.substr(begin, end - begin) + '\n';
    begin = end + 1;
    margin = std::string(indent, ' ');
  }
  return text + margin + line.substr(begin);
}

/// "Solver ([solver] in scene.toml)" in a command that reads scene files.
std::string titleOf(const CLI::App& command, const std::string& heading) {
  if (command.get_option_no_throw("--scene") == nullptr) return heading;
  const auto options = command.get_options(
      [&](const CLI::Option* option) { return option->get_group() == heading; });
  const std::string table = options.empty() ? "" : settingTable(*options.front());
  return table.empty() ? heading : fmt::format("{} ([{}] in scene.toml)", heading, table);
}

/// CLI11's page, wrapped, with one empty line between two sections.
std::string wholePage(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  std::istringstream lines(command.help(parent == nullptr ? "" : fullName(*parent)));
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    if (line.ends_with(':')) line = titleOf(command, line.substr(0, line.size() - 1)) + ':';
    if (line.empty() && (text.empty() || text.ends_with("\n\n"))) continue;
    // Explanations continue in their column, other lines are indented.
    const bool isExplained = line.size() > kHelpColumn && line[kHelpColumn - 1] == ' ' &&
                             line[kHelpColumn] != ' ' && line.starts_with("  ");
    text += wrapped(line, isExplained ? kHelpColumn : line.starts_with(' ') ? 4 : 0) + '\n';
  }
  return text;
}

/// "Springs to the target" is typed as "springs".
std::string groupWord(const std::string& heading) {
  std::string word = heading.substr(0, heading.find(' '));
  std::ranges::transform(word, word.begin(), [](unsigned char c) { return std::tolower(c); });
  return word;
}

/// The headings of all options but --help.
std::vector<std::string> headingsOf(const CLI::App& command) {
  std::vector<std::string> headings = command.get_groups();
  std::erase_if(headings, [](const std::string& heading) {
    return heading.empty() || heading == "Options" || heading == "Positionals";
  });
  return headings;
}

/// The section of a page under a title, up to its empty line.
std::string sectionOf(const std::string& page, const std::string& title) {
  const std::size_t begin = page.find(fmt::format("\n{}:\n", title)) + 1;
  return page.substr(begin, page.find("\n\n", begin) + 1 - begin);
}

/// "  output      --out --fps ...", in one line.
std::string groupLine(const CLI::App& command, const std::string& heading) {
  std::vector<std::string> names;
  for (const CLI::Option* option :
       command.get_options([&](const CLI::Option* one) { return one->get_group() == heading; })) {
    names.push_back("--" + option->get_lnames().front());
  }
  std::stable_partition(names.begin(), names.end(),
                        [](const std::string& name) { return mostUsedOptions().contains(name); });
  std::string line = fmt::format("  {:<13}", groupWord(heading));
  for (const std::string& name : names) {
    if (line.size() + name.size() + 5 > kPageWidth) return line + " ...\n";
    line += " " + name;
  }
  return line + '\n';
}

std::string overview(const CLI::App& command, const std::string& page,
                     const std::vector<std::string>& headings) {
  // Purpose, usage and arguments precede the section of --help. The footer follows the last
  // section.
  const std::string last = sectionOf(page, titleOf(command, headings.back()));
  std::string text = page.substr(0, page.find("\nOptions:\n") + 1);
  text +=
      fmt::format("Options by group; explained by {} --help GROUP (or all):\n", fullName(command));
  for (const std::string& heading : headings) text += groupLine(command, heading);
  return text + page.substr(page.find(last) + last.size());
}

}  // namespace

void setHelpLayout(CLI::App& program) {
  program.get_formatter()->column_width(kHelpColumn);
  program.set_help_flag("-h,--help", "print this page; COMMAND --help GROUP prints one group");
}

std::string takeHelpGroup(std::vector<std::string>& arguments) {
  const auto help = std::ranges::find_if(
      arguments, [](const std::string& word) { return word == "--help" || word == "-h"; });
  // Options before a command have no groups.
  if (help == arguments.begin() || help == arguments.end()) return "";
  if (help + 1 == arguments.end() || (help + 1)->starts_with('-')) return "";
  const std::string group = *(help + 1);
  arguments.erase(help + 1);
  return group;
}

std::string helpText(const CLI::App& command, const std::string& group) {
  const std::string page = wholePage(command);
  const std::vector<std::string> headings = headingsOf(command);
  if (group == kAllGroups) return page;
  if (group.empty()) {
    const bool isLong = std::ranges::count(page, '\n') > kPageLines && !headings.empty();
    return isLong ? overview(command, page, headings) : page;
  }
  std::vector<std::string> words = {kAllGroups};
  for (const std::string& heading : headings) {
    if (groupWord(heading) == groupWord(group)) return sectionOf(page, titleOf(command, heading));
    words.push_back(groupWord(heading));
  }
  throw InputError(fmt::format("error: {} has no group of options '{}'{}; choose {}",
                               fullName(command), shown(group), suggestion(group, words),
                               scene::listWords(words)));
}

}  // namespace kirireel::cli
