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

/// The tables of a scene file; options that no scene file can set stand under "".
std::string tablesText(CLI::App& command, const Scene& scene, bool withFileNames) {
  std::map<std::string, std::string> tables;
  for (CLI::Option* option : command.get_options()) {
    const std::string key = settingKey(*option);
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
