// A key of scene.toml is the long name of an option with underscores, in the table that the
// option's group names. So every option of a run can stand in the file, and the file needs no list
// of its own. Values go through the option's own reader, as text, and are refused in its words,
// with the place in the file in front.
//
// An option that the command line gave keeps its value: what is typed counts more than what is
// stored.
#include "render/cli/scene_settings.h"

#include <algorithm>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/option_group.h"
#include "sim/base/error.h"
#include "sim/base/spelling.h"

namespace kirireel {
namespace {

/// Of one table, for suggestions.
std::vector<std::string> keysOf(CLI::App& command, const std::string& table) {
  std::vector<std::string> keys;
  for (CLI::Option* option : command.get_options()) {
    if (settingTable(*option) == table) keys.push_back(settingKey(*option));
  }
  return keys;
}

/// The first option with this key and table; a key of another table gets a message of its own,
/// since it is the most frequent mistake.
CLI::Option& findOption(CLI::App& command, const SceneSetting& setting) {
  for (CLI::Option* option : command.get_options()) {
    if (settingKey(*option) != setting.key) continue;
    const std::string table = settingTable(*option);
    if (table == setting.table) return *option;
    // No scene file can set it, so it counts as unknown.
    if (table.empty()) break;
    throw inputErrorAt(setting.where, fmt::format("{} belongs in [{}], not in [{}]", setting.key,
                                                  table, setting.table));
  }
  throw inputErrorAt(
      setting.where,
      fmt::format("[{}] has no key {}{}; see {} --help", setting.table, shown(setting.key),
                  suggestion(setting.key, keysOf(command, setting.table)), command.get_name()));
}

/// An option without a value is switched on by true and left alone by false.
void requireKindOfValue(const SceneSetting& setting, bool isSwitch) {
  if (isSwitch == setting.isSwitch) return;
  throw inputErrorAt(setting.where, isSwitch ? fmt::format("{} is true or false", setting.key)
                                             : fmt::format("{} needs a value", setting.key));
}

/// The message of an option without the "error: " that its place in the file brings along.
std::string withoutMark(const std::string& message) {
  constexpr std::string_view kMark = "error: ";
  return message.starts_with(kMark) ? message.substr(kMark.size()) : message;
}

}  // namespace

std::string settingKey(const CLI::Option& option) {
  if (option.get_lnames().empty()) return "";
  std::string key = option.get_lnames().front();
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

void applySetting(CLI::Option& option, const SceneSetting& setting) {
  const bool isSwitch = option.get_items_expected_max() == 0;
  requireKindOfValue(setting, isSwitch);
  const bool isGiven = option.count() > 0;
  if (isGiven || (isSwitch && setting.values.front() == "false")) return;
  // Arrays give one value an element, as if the option were given as often.
  for (const std::string& value : setting.values) option.add_result(value);
  try {
    option.run_callback();
  } catch (const InputError& error) {
    throw inputErrorAt(setting.where, withoutMark(error.what()));
  }
}

SceneFile applySceneFile(CLI::App& command, const std::filesystem::path& file) {
  SceneFile scene = readSceneFile(file);
  for (const SceneSetting& setting : scene.settings)
    applySetting(findOption(command, setting), setting);
  return scene;
}

}  // namespace kirireel
