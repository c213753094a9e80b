// Reads descriptions off CLI11's objects, after all commands have been added and before anything is
// parsed. Manual pages, shell completions, the Python stubs and the tests of documentation are made
// from these values, so that none of them can say something else than --help does.
#include "render/cli/command_tree.h"

#include <algorithm>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "render/cli/option_group.h"
#include "render/cli/scene_settings.h"

namespace kirireel {
namespace {

/// Short names first, as the help has them.
std::vector<std::string> hyphenedNames(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

/// `key` and `table` are those of a scene file; "" where none can set it.
OptionDescription describeOption(CLI::Option& option) {
  // CLI11 tells an option without a value by the number of words that it may take.
  const bool isSwitch = option.get_items_expected_max() == 0;
  OptionDescription described;
  described.names = hyphenedNames(option);
  described.key = settingKey(option);
  described.table = settingTable(option);
  described.group = option.get_group();
  described.unit = isSwitch ? "" : option.get_type_name();
  described.help = option.get_description();
  described.words = allowedWords(option);
  described.isSwitch = isSwitch;
  // Options that may be given several times take all of their values; others the last one.
  described.repeats = option.get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
  return described;
}

}  // namespace

CommandDescription describeCommand(CLI::App& command) {
  CommandDescription described;
  described.name = command.get_name();
  described.help = command.get_description();
  described.footer = command.get_footer();
  // Positional arguments are options without hyphens in CLI11.
  for (CLI::Option* option : command.get_options()) {
    if (option->get_positional()) {
      described.places.push_back({option->get_name(true), option->get_description()});
    } else {
      described.options.push_back(describeOption(*option));
    }
  }
  for (CLI::App* below : command.get_subcommands({})) {
    described.commands.push_back(describeCommand(*below));
  }
  return described;
}

const CommandDescription& commandNamed(const CommandDescription& program, const std::string& name) {
  const auto found = std::ranges::find(program.commands, name, &CommandDescription::name);
  if (found == program.commands.end()) throw std::out_of_range("no command " + name);
  return *found;
}

}  // namespace kirireel
