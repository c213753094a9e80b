// Options that make up a scene: all settings of sim/scene/settings.h, which are added without being
// named here, and what belongs to a model (targets, pins, fixed pairs, links), whose values are
// lists. The scene file comes last: it fills the options that the command line left alone.
#include "render/cli/scene_options.h"

#include <algorithm>
#include <charconv>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "render/cli/option_group.h"
#include "render/cli/scene_settings.h"

namespace kirireel {
namespace {

/// "3,0,7": whole numbers from 0, as many as `count` when it is not 0.
std::vector<int> parseIndices(const TypedValue& value, std::size_t count,
                              const std::string& wanted) {
  std::vector<int> numbers;
  const char* at = value.text.data();
  const char* const end = at + value.text.size();
  while (at != end) {
    int number = 0;
    const auto [next, error] = std::from_chars(at, end, number);
    const bool isLast = next == end;
    // A comma must be followed by a number, so "3," is refused.
    if (error != std::errc() || number < 0 || (!isLast && *next != ',') || next + 1 == end) {
      throw valueError(value, wanted);
    }
    numbers.push_back(number);
    at = isLast ? end : next + 1;
  }
  if (numbers.empty() || (count != 0 && numbers.size() != count)) throw valueError(value, wanted);
  return numbers;
}

template <typename List>
/// Each list as "3,4", all of them as a scene file has them.
std::string listsText(const std::vector<List>& lists) {
  std::vector<std::string> texts;
  for (const List& list : lists)
    texts.push_back(quotedText(fmt::format("{}", fmt::join(list, ","))));
  return quotedList(texts);
}

}  // namespace

void addSceneOptions(CLI::App& command, Scene& scene) {
  // A group of settings is a heading of the help and a table of a scene file.
  for (const SettingGroup& group : sceneSettings()) {
    OptionGroup options(command, group.heading, group.table);
    for (const Setting& setting : group.settings) options.setting(setting, scene);
  }
}

void addSceneRequestOptions(CLI::App& command, SceneRequest& request, StartAlignment& alignment) {
  OptionGroup(command, "Scene")
      .value("--scene", "FILE", "scene.toml in MODEL, where there is one",
             "settings and timeline; options given here count more",
             [&request](const TypedValue& typed) { request.file = typed.text; })
      .decidesNothing();  // what the file says does
  OptionGroup group(command, "Model", "model");
  // Numbers stay as they were typed; completeScene() knows from where the model's file counts.
  SceneParts& parts = request.parts;
  group
      .values("--target", "MODEL",
              "target in place of the model's own: a file like target.txt, or another model whose "
              "start it is; given several times, each is reached before the next",
              [&parts](const TypedValue& typed) { parts.targets.emplace_back(typed.text); })
      .saidAs([&parts] {
        std::vector<std::string> names;
        for (const auto& target : parts.targets) names.push_back(quotedText(target.string()));
        return quotedList(names);
      });
  group
      .values("--pin", "TILES",
              "tiles fixed to the world from the start, as in 3,0,7; tiles and vertices are "
              "numbered as in "
              "the model's file, planar ones from 1",
              [&parts](const TypedValue& typed) {
                const auto tiles = parseIndices(typed, 0, "tile numbers, as in 3,0,7");
                parts.pinned.insert(parts.pinned.end(), tiles.begin(), tiles.end());
              })
      .saidAs([&parts] { return quotedText(fmt::format("{}", fmt::join(parts.pinned, ","))); });
  group.flag("--no-align", alignment.wanted,
             "leave the start where the model has it, instead of moving it onto the target (by its "
             "pinned tiles, where some are)",
             false);
  group
      .values("--fix", "TILE,TILE", "two tiles that move as one",
              [&parts](const TypedValue& typed) {
                const auto pair = parseIndices(typed, 2, "two tile numbers, as in 3,4");
                parts.fixed.push_back({pair[0], pair[1]});
              })
      .saidAs([&parts] { return listsText(parts.fixed); });
  group
      .values("--link", "TILE,VERTEX,TILE,VERTEX",
              "two corners that keep the distance that they start with",
              [&parts](const TypedValue& typed) {
                const auto link =
                    parseIndices(typed, 4, "tile, vertex, tile, vertex, as in 3,0,4,2");
                parts.links.push_back({link[0], link[1], link[2], link[3]});
              })
      .saidAs([&parts] { return listsText(parts.links); });
}

std::filesystem::path sceneFileOf(const std::filesystem::path& modelFolder,
                                  const SceneRequest& request) {
  return request.file.empty() ? modelFolder / "scene.toml" : request.file;
}

SceneFile readSceneFileOf(CLI::App& command, const std::filesystem::path& modelFolder,
                          const SceneRequest& request, Scene& scene) {
  const std::filesystem::path file = sceneFileOf(modelFolder, request);
  std::error_code ignored;
  // A file that was named has to be there; scene.toml beside the model need not.
  if (request.file.empty() && !std::filesystem::exists(file, ignored)) return {};
  // Settings went into the options; lists have no options and are taken here.
  SceneFile read = applySceneFile(command, file);
  scene.timeline = read.timeline;
  scene.environment.obstacles = read.obstacles;
  scene.velocities = read.velocities;
  scene.grips = read.grips;
  return read;
}

}  // namespace kirireel
