// Two orders are the same when they make the same bytes. The fingerprint is the SHA-256 (FIPS
// 180-4) of a text:
//
//     versions of the program and its libraries
//     command
//     key = value          every option that has an effect, by table, as it is now
//     [[timeline]] ...     the scene file's lists, in one spelling
//     model NAME
//     SHA-256 ROLE         each input file, in the order in which it was read
//
// Values are taken after parsing, defaults too, so that it does not matter how a setting was given,
// and a default that changes with a version changes the fingerprint. Options without effect in this
// scene are left out, and so are those that decide no byte (--out, --painters). Names of files are
// replaced by their hashes: a copy of a model elsewhere is the same model. Within a folder the
// names count, because the reader looks for vertices.txt by name.
//
// Hashing the typed words would be simpler and wrong: the same order can be typed in many ways.
#include "render/cli/order_fingerprint.h"

#include <algorithm>
#include <map>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "render/cli/contradictions.h"
#include "render/cli/option_group.h"
#include "render/cli/scene_settings.h"
#include "render/record/versions.h"
#include "sim/base/sha256.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

/// Whether an option's values are names of files.
bool namesFiles(const std::string& key) {
  return key == "target" || key == "joints_file" || key == "hinge_file";
}

/// Names of files as so many empty ones: what the files hold is told apart by their hashes.
std::string withoutNames(const CLI::Option& option) {
  return fmt::format("{} files", option.count());
}

/// The tables of a scene file; options that no scene file can set stand under "". A scene file in
/// its form; the order of tables is that of their names.
std::string tablesText(CLI::App& command, const Scene& scene, bool withFileNames) {
  // Sorted by name; within a table options keep the order in which they were added.
  std::map<std::string, std::string> tables;
  for (CLI::Option* option : command.get_options()) {
    const std::string key = settingKey(*option);
    // An empty text says that the option decides nothing.
    std::string value = key.empty() ? "" : saidBy(*option);
    if (value.empty() || !hasEffect(option->get_name(), scene)) continue;
    if (namesFiles(key) && !withFileNames) value = withoutNames(*option);
    tables[settingTable(*option)] += fmt::format("{} = {}\n", key, value);
  }
  std::string text;
  for (const auto& [table, lines] : tables) {
    if (!text.empty()) text += '\n';
    if (!table.empty()) text += fmt::format("[{}]\n", table);
    text += lines;
  }
  return text;
}

/// Files of a folder have fixed names, by which they are told apart; of others the ending counts.
/// For a file in a folder its name, for another its ending.
std::string roleOf(const fs::path& file, const std::vector<fs::path>& folders) {
  const bool isInFolder = std::ranges::any_of(folders, [&](const fs::path& folder) {
    return !folder.empty() && folder / file.filename() == file;
  });
  return (isInFolder ? file.filename() : file.extension()).string();
}

}  // namespace

OrderText orderText(CLI::App& command, const Scene& scene, const SceneFile& sceneFile) {
  return {tablesText(command, scene, true) + entriesText(sceneFile, true),
          fmt::format("{}\n{}{}", command.get_name(), tablesText(command, scene, false),
                      entriesText(sceneFile, false))};
}

std::string parametersText(CLI::App& command) {
  return fmt::format("{}\n{}", command.get_name(), tablesText(command, {}, true));
}

std::string orderFingerprint(const std::string& terms, const OrderInputs& inputs,
                             const std::vector<fs::path>& folders) {
  std::string text = fmt::format("{}\n{}\nmodel {}\n", versionText(), terms, inputs.modelName);
  for (const InputFile& file : inputs.files) {
    text += fmt::format("{} {}\n", file.sha256, roleOf(file.path, folders));
  }
  return sha256(text);
}

}  // namespace kirireel
