#include "render/cli/model_place.h"

#include <optional>

#include "sim/base/spelling.h"
#include "sim/measure/sheet.h"
#include "sim/model/read_model.h"

namespace kirireel {
namespace {

/// Tiles that lie in each other are a mistake, or meant, as where a sheet is folded flat. The depth
/// is how far two tiles would have to move apart, in metres. One line tells the deepest pair and
/// how many there are.
void warnOfOverlaps(const Model& model, std::vector<std::string>& warnings) {
  constexpr double kShareOfTile = 1e-3;  // less cannot be seen
  const std::vector<TileOverlap> overlaps =
      tileOverlaps(model.tiles, kShareOfTile * tileSize(model));
  if (overlaps.empty()) return;
  const TileOverlap& deepest = overlaps.front();
  warnings.push_back(fmt::format(
      "{}: warning: tiles {} and {} overlap by {:.3g} m at the start{}; move them "
      "apart, or let them pass through each other (--contacts none)",
      model.name, model.fileOrder.countsFrom + deepest.tileA,
      model.fileOrder.countsFrom + deepest.tileB, deepest.depth,
      overlaps.size() == 1 ? "" : fmt::format(", the deepest of {} pairs", overlaps.size())));
}

}  // namespace

std::filesystem::path findModel(const std::filesystem::path& named) {
  if (std::filesystem::exists(named) || named.is_absolute()) return named;
  // The current folder's data/ first, then what was installed with the program.
  for (const std::filesystem::path folder : {"data", KIRIREEL_MODELS}) {
    if (std::filesystem::exists(folder / named)) return folder / named;
  }
  return named;
}

void addTargetOption(OptionGroup& group, std::filesystem::path& target) {
  group.value("--target", "MODEL", "the model's own", "another model whose start is the target",
              [&target](const TypedValue& typed) { target = typed.text; });
}

void addReadOptions(OptionGroup& group, ReadSettings& settings) {
  group
      .value("--joints-file", "FILE", "the model's own",
             "list of joints to take in place of constraints.txt: a path, or a name beside it",
             [&settings](const TypedValue& typed) { settings.jointsFile = typed.text; })
      .saidAs([&settings] {
        const std::string name = settings.jointsFile.string();
        return name.empty() ? "" : quotedText(name);
      });
  group
      .flag("--strict", settings.strict,
            "refuse files with slips (joints listed twice, clockwise tiles, rounded corners) "
            "instead of mending them")
      .decidesNothing();
}

Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                  const ReadSettings& settings, std::vector<std::string>& warnings) {
  std::optional<std::filesystem::path> named;
  // A target of another model is looked for in the same places.
  if (!target.empty()) named = findModel(target);
  Model model = readModel(findModel(place), named, warnings, settings);
  warnOfOverlaps(model, warnings);
  return model;
}

Model readModelAt(const std::filesystem::path& place, const std::filesystem::path& target,
                  const ReadSettings& settings) {
  std::vector<std::string> warnings;
  Model model = readModelAt(place, target, settings, warnings);
  printWarnings(warnings);
  return model;
}

void printWarnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) {
    fmt::print(stderr, "kirireel: {}\n", oneLine(warning));
  }
}

}  // namespace kirireel
