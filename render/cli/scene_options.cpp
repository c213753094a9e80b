// Options of a scene: all settings of sim/scene/settings.h, which are added without listing them
// here, and additions to a model (targets, pins, fixed pairs, links), whose values are lists. The
// scene file comes last: it sets options that the command line did not give.
#include "render/cli/scene_options.h"

#include <algorithm>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"
#include "sim/formats/read_model.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::cli {
namespace {

/// Splits "red,rgb(0,0,255),cuts" at commas outside parentheses.
std::vector<std::string> splitNames(const scene::TypedValue& typed) {
  std::vector<std::string> names(1);
  int depth = 0;
  for (const char letter : typed.text) {
    depth += letter == '(' ? 1 : letter == ')' ? -1 : 0;
    if (letter == ',' && depth == 0) {
      names.emplace_back();
    } else {
      names.back() += letter;
    }
  }
  if (has(names, "")) throw scene::valueError(typed, "colours, layers or ids, as in red,slits");
  return names;
}

std::string pathText(const std::filesystem::path& path) {
  return scene::quotedText(path.string());
}

/// A reader of this many indices. `requested` describes them in the error.
template <std::size_t count>
auto indicesIn(const char* requested) {
  return [requested](const scene::TypedValue& typed) {
    const std::vector<int> numbers = parseIndices(typed, count, requested);
    std::array<int, count> indices{};
    std::ranges::copy(numbers, indices.begin());
    return indices;
  };
}

}  // namespace

void addSceneOptions(CLI::App& command, scene::Scene& scene) {
  // A group of settings is a heading of the help and a table of a scene file.
  for (const scene::SettingGroup& group : scene::sceneSettings()) {
    OptionGroup options(command, group.heading, group.table);
    for (const scene::Setting& setting : group.settings) options.setting(setting, scene);
  }
}

void addSceneRequestOptions(CLI::App& command, SceneRequest& request,
                            scene::StartAlignment& alignment) {
  OptionGroup(command, "Scene")
      .stored("--scene", request.file, "FILE", "scene.toml in MODEL, if it exists",
              "settings and timeline; options override them", asTyped, pathText)
      .excludeFromFingerprint();  // its content is in the fingerprint
  OptionGroup group(command, "Model", "model");
  // Numbers stay as typed; completeScene() knows the base of the model's file.
  scene::SceneParts& parts = request.parts;
  group.appended(
      "--target", parts.targets, "MODEL",
      "a file like target.txt, or a model whose start is the target, instead of the model's "
      "own; may be repeated, each is reached before the next",
      asTyped, [](const std::vector<std::filesystem::path>& targets) {
        std::vector<std::string> names;
        for (const auto& target : targets) names.push_back(pathText(target));
        return scene::quotedList(names);
      });
  group
      .values("--pin", "TILES",
              "tiles fixed to the world from the start, as in 3,0,7, with the numbers of the "
              "model's file",
              [&parts](const scene::TypedValue& typed) {
                const auto tiles = parseIndices(typed, 0, "tile numbers, as in 3,0,7");
                parts.pinned.insert(parts.pinned.end(), tiles.begin(), tiles.end());
              })
      .serializedAs(
          [&parts] { return scene::quotedText(fmt::format("{}", fmt::join(parts.pinned, ","))); });
  group.flag("--no-align", alignment.requested,
             "keep the positions of targets, instead of moving each onto the start", false);
  group.appended("--fix", parts.fixed, "TILE,TILE", "two tiles that move as one",
                 indicesIn<2>("two tile numbers, as in 3,4"), listsText<std::array<int, 2>>);
  group.appended("--link", parts.links, "TILE,VERTEX,TILE,VERTEX",
                 "two corners that keep their initial distance",
                 indicesIn<4>("tile, vertex, tile, vertex, as in 3,0,4,2"),
                 listsText<std::array<int, 4>>);
}

scene::SceneFile readSceneFileOf(CLI::App& command, CLI::App& all,
                                 const std::filesystem::path& modelFolder,
                                 const SceneRequest& request, scene::Scene& scene) {
  const std::filesystem::path file =
      request.file.empty() ? modelFolder / "scene.toml" : request.file;
  // A named file must exist; scene.toml in the model's folder is optional.
  if (request.file.empty() && !isPresent(file)) return {};
  // Settings were written to the options. Lists have no options and are used here.
  scene::SceneFile read = applySceneFile(command, all, file);
  scene.timeline = read.timeline;
  scene.environment.obstacles = read.obstacles;
  scene.velocities = read.velocities;
  scene.grips = read.grips;
  return read;
}

// ------------------------------------------------------------------------------------------------
// A key of scene.toml is the long name of an option with underscores, in the table of the option's
// group. Every option of a run can be in the file without another list of keys. Values are passed
// as text to the option's own reader. Its error message gets the file position as prefix.
//
// An option on the command line has priority over the file.

namespace {

/// Keys of all tables, for suggestions.
std::vector<std::string> keysOf(CLI::App& command) {
  std::vector<std::string> keys;
  for (CLI::Option* option : command.get_options()) {
    if (!settingTable(*option).empty()) keys.push_back(settingKey(*option));
  }
  return keys;
}

/// The first option with this key and table. A key of another table gets its own message, since it
/// is the most frequent mistake.
CLI::Option& findOption(CLI::App& command, const scene::SceneSetting& setting) {
  for (CLI::Option* option : command.get_options()) {
    if (settingKey(*option) != setting.key) continue;
    const std::string table = settingTable(*option);
    if (table == setting.table) return *option;
    // A scene file cannot set it, so it counts as unknown.
    if (table.empty()) break;
    throw inputErrorAt(setting.where, fmt::format("{} belongs in [{}], not in [{}]", setting.key,
                                                  table, setting.table));
  }
  const std::string replacement = replacementOf("--" + setting.key);
  throw inputErrorAt(
      setting.where,
      fmt::format("[{}] has no key {}{}; see {} --help", setting.table, shown(setting.key),
                  replacement.empty() ? suggestion(setting.key, keysOf(command)) : replacement,
                  fullName(command)));
}

/// An option without a value is set by true; false has no effect.
void requireKindOfValue(const scene::SceneSetting& setting, const CLI::Option& option) {
  const bool isSwitch = option.get_items_expected_max() == 0;
  // An option with an optional value, such as --letters [WORD], is either.
  const bool isEither = option.get_type_name().starts_with('[');
  const bool isSeveral = setting.values.size() > 1;
  if (isSeveral && option.get_multi_option_policy() != CLI::MultiOptionPolicy::TakeAll) {
    throw inputErrorAt(setting.where, fmt::format("{} has one value", setting.key));
  }
  if (isEither || isSwitch == setting.isSwitch) return;
  if (!isSwitch) throw inputErrorAt(setting.where, fmt::format("{} needs a value", setting.key));
  throw scene::locatedAt(setting.where,
                         scene::valueError({setting.key, setting.values.front()}, "true or false"));
}

}  // namespace

std::string settingKey(const CLI::Option& option) {
  if (option.get_lnames().empty()) return "";
  std::string key = option.get_lnames().front();
  std::replace(key.begin(), key.end(), '-', '_');
  return key;
}

void applySetting(CLI::Option& option, const scene::SceneSetting& setting) {
  const bool isSwitch = option.get_items_expected_max() == 0;
  requireKindOfValue(setting, option);
  const bool isGiven = option.count() > 0;
  if (isGiven || (isSwitch && setting.values.front() == "false")) return;
  // An array gives one value per element, like a repeated option.
  for (const std::string& value : setting.values) option.add_result(value);
  try {
    option.run_callback();
  } catch (const InputError& error) {
    throw scene::locatedAt(setting.where, error);
  }
}

scene::SceneFile applySceneFile(CLI::App& command, CLI::App& all,
                                const std::filesystem::path& file) {
  scene::SceneFile scene = scene::readSceneFile(file);
  for (const scene::SceneSetting& setting : scene.settings) {
    CLI::Option& known = findOption(all, setting);
    CLI::Option* own = command.get_option_no_throw("--" + known.get_lnames().front());
    applySetting(own ? *own : known, setting);
  }
  return scene;
}

// ------------------------------------------------------------------------------------------------
// Models on the command line.

namespace {

/// Overlap of tiles is an error, or intended in a sheet that is folded flat. The depth is the
/// distance by which two tiles would have to be separated, metres. One line reports the deepest
/// pair and the number of pairs.
void warnOfOverlaps(const model::Model& model, std::vector<std::string>& warnings) {
  constexpr double kShareOfTile = 1e-3;  // smaller overlaps are not visible
  const std::vector<trajectory::TileOverlap> overlaps =
      trajectory::tileOverlaps(model.tiles, kShareOfTile * model::tileSize(model));
  if (overlaps.empty()) return;
  const trajectory::TileOverlap& deepest = overlaps.front();
  warnings.push_back(fmt::format(
      "{}: warning: tiles {} and {} overlap by {} at the start{}; move them apart, or allow "
      "overlaps with --contacts none",
      model.name, model.fileOrder.countsFrom + deepest.tileA,
      model.fileOrder.countsFrom + deepest.tileB, lengthText(deepest.depth, model.unit),
      overlaps.size() == 1 ? "" : fmt::format(", the deepest of {} pairs", overlaps.size())));
}

/// Search path of findModel(): first in the current folder, then the installed models.
constexpr const char* kModelFolders[] = {"data", KIRIREEL_MODELS};

/// Rejects a name that is neither a folder nor a known model; the reader rejects other paths.
void requireKnownName(const std::filesystem::path& named) {
  if (isPresent(findModel(named))) return;
  // A folder name may end in a slash.
  const std::filesystem::path name = named.has_filename() ? named : named.parent_path();
  std::vector<std::string> names;
  for (const auto& [known, place] : knownModels()) names.push_back(known);
  const std::string meant = suggestion(name.filename().string(), names);
  if (!meant.empty()) {
    throw inputErrorAt({named},
                       fmt::format("there is no such model{}; see kirireel models", meant));
  }
  if (named.has_parent_path() || named.has_extension()) return;
  throw inputErrorAt({named},
                     "there is no such folder; give a folder with vertices.txt and "
                     "constraints.txt, or a name that kirireel models lists");
}

}  // namespace

std::filesystem::path findModel(const std::filesystem::path& named) {
  if (isPresent(named) || named.is_absolute()) return named;
  for (const std::filesystem::path folder : kModelFolders) {
    if (isPresent(folder / named)) return folder / named;
  }
  return named;
}

std::map<std::string, std::filesystem::path> knownModels() {
  std::map<std::string, std::filesystem::path> models;
  std::error_code ignored;
  for (const std::filesystem::path folder : kModelFolders) {
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
      if (isPresent(entry.path() / "vertices.txt")) {
        models.emplace(entry.path().filename().string(), entry.path());
      }
    }
  }
  return models;
}

void addTargetOption(OptionGroup& group, std::filesystem::path& target) {
  group.value("--target", "MODEL", "the model's own", "another model whose start is the target",
              [&target](const scene::TypedValue& typed) { target = typed.text; });
}

namespace {

/// Options of SVG and DXF files.
void addDrawingOptions(OptionGroup& group, formats::ReadSettings& settings, bool hasNecks) {
  group.stored("--cut", settings.cut, "NAMES", "automatic",
               "lines of a drawing to cut: colours, layers or ids, as in red,slits", splitNames,
               wordsText);
  group.stored("--ignore", settings.ignore, "NAMES", "automatic",
               "lines of a drawing to ignore, named in the same way", splitNames, wordsText);
  group.stored(hasNecks ? "--widest-neck" : "--widest-neck,--neck-width", settings.neckWidth,
               "LENGTH", "automatic",
               "largest distance by which cuts of a drawing may stop short of the next line; no "
               "neck changes its width",
               numberIn({1e-9, 1e6}), positiveText);
  group
      .choice<bool>(
          "--joint-at", settings.areJointsInNecks, {{"vertex", false}, {"middle", true}},
          "joints of a drawing: where the cut would meet the line, or in the middle of the neck")
      .serializedAs(
          [&settings] { return settings.areJointsInNecks ? scene::quotedText("middle") : ""; });
}

}  // namespace

scene::Choices<std::optional<LengthUnit>> unitChoices() {
  scene::Choices<std::optional<LengthUnit>> units = {{"auto", std::nullopt}};
  for (const LengthUnit& unit : lengthUnits()) units.emplace_back(unit.name, unit);
  return units;
}

void addReadOptions(OptionGroup& group, formats::ReadSettings& settings, bool hasNecks) {
  group.stored("--joints-file", settings.jointsFile, "FILE", "the model's own",
               "list of joints instead of constraints.txt: a path, or a name in the same folder",
               asTyped, pathText);
  group.choice<std::optional<LengthUnit>>(
      "--unit", settings.unit, unitChoices(),
      "unit of lengths in options, scene files and exported files, and of a model that declares "
      "none; auto: the declared one, else m");
  group.stored("--frame", settings.frame, "N", "all that are states of one sheet",
               "frame of a FOLD file that is the model, 0 for the file's own keys",
               integerIn({0, 1e6}), scene::numberText);
  group.number(
      "--fold", settings.fold, {1e-3, 1}, "FRACTION", "1",
      "fold of M and V edges without an angle in a FOLD file, as a fraction of 180 degrees");
  group.flag("--join-coplanar", settings.joinCoplanar,
             "join faces of an OBJ or PLY mesh that share an edge and lie in one plane");
  group
      .flag("--strict", settings.strict,
            "reject files with errors (joints listed twice, clockwise tiles, rounded corners) "
            "instead of repairing them")
      .excludeFromFingerprint();
  addDrawingOptions(group, settings, hasNecks);
}

model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const formats::ReadSettings& settings,
                         std::vector<std::string>& warnings) {
  if (place.empty()) throw InputError("error: the model's name is empty; give a folder or a file");
  requireKnownName(place);
  std::optional<std::filesystem::path> named;
  // The target's model is searched in the same folders.
  if (!target.empty()) named = findModel(target);
  model::Model model = formats::readModel(findModel(place), named, warnings, settings);
  warnOfOverlaps(model, warnings);
  return model;
}

model::Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                         const formats::ReadSettings& settings) {
  std::vector<std::string> warnings;
  model::Model model = readModelAt(place, target, settings, warnings);
  printWarnings(warnings);
  return model;
}

void checkThickness(const scene::Scene& scene, std::vector<std::string>& warnings) {
  constexpr double kMax = 0.1;  // of a tile's mean edge
  constexpr double kMin = 1e-3;
  const double edge = model::tileSize(scene.model);
  const double thickness = scene.brick.thickness;
  const LengthUnit& unit = scene.model.unit;
  if (thickness >= kMin * edge && thickness <= kMax * edge) return;
  warnings.push_back(fmt::format(
      "{}: warning: bricks are {} thick, but a tile's mean edge is {}; lengths are in "
      "{}; try --thickness {:.2g}",
      scene.model.name, lengthText(thickness, unit), lengthText(edge, unit),
      unit.name == "m" ? "metres" : unit.name, brick::kDefaultThickness * edge / unit.metres));
}

void printWarnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    fmt::print(stderr, "kirireel: {}\n", oneLine(spellOptions(warning)));
  }
}

}  // namespace kirireel::cli
