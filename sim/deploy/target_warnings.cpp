// Warnings about a target that rigid, jointed tiles cannot reach, said before the run. They look at
// the data alone: how far joints are open at the target, whether the sheet is turned over, how near
// tiles can come to it one by one (rigid_bound.cpp), and whether the alignment has moved the start
// although ground or obstacles make its place count.
#include "sim/deploy/target_warnings.h"

#include <fmt/format.h>

#include "sim/deploy/path_choice.h"
#include "sim/measure/measures.h"
#include "sim/measure/sheet.h"

namespace kirireel {
namespace {

// Data that are rounded to three digits leave gaps of this part of a tile.
constexpr double kTorn = 1e-3;
// A start that was moved less, in tiles, stayed where it was.
constexpr double kMovedShare = 1e-6;
// Bounds that differ less are one.
constexpr double kAboveBound = 1.1;

bool isWanted(const Scene& scene) {
  return scene.model.target && scene.actuation.drive == Drive::Target;
}

// Joints that are open in the target's own data.
std::string tornWarning(const Scene& scene) {
  const double tile = tileSize(scene.model);
  const double gap = largestJointGap(scene.model.joints, *scene.model.target);
  if (gap <= kTorn * tile) return "";
  return fmt::format(
      "the target is torn: its own joints are open by {:.3g} m there ({:.2g} tiles), so that "
      "closed joints cannot reach it",
      gap, gap / tile);
}

/// Tiles of a folded target face many ways; a sheet of which all do the other way is turned over.
std::string turnedWarning(const Scene& scene) {
  const Model& model = scene.model;
  const auto count = static_cast<int>(model.tiles.size());
  const int turned = countTurnedOver(model.tiles, *model.target);
  const double flat = 1e-9 * modelSize(model);
  const bool areFlat = liesFlat(model.tiles, flat) && liesFlat(*model.target, flat);
  if (turned == 0 || (!areFlat && turned < count)) return "";
  return fmt::format(
      "the target is turned over: {} of {} tiles face the other way there than at the start",
      turned, count);
}

// Tiles of other shapes than the target's.
std::string rigidWarning(const Scene& scene) {
  const double tile = tileSize(scene.model);
  const double bound = rigidBound(scene.model.tiles, *scene.model.target);
  if (bound <= kFarShare * tile) return "";
  return fmt::format(
      "the target is out of reach: its tiles have other shapes, and rigid ones cannot come nearer "
      "than {:.3g} m ({:.2g} tiles)",
      bound, bound / tile);
}

// Where the place matters, a start that was moved onto its target is told.
std::string movedWarning(const Scene& scene) {
  const StartAlignment& alignment = scene.alignment;
  const Environment& environment = scene.environment;
  const bool placeCounts = environment.ground || !environment.obstacles.empty();
  const bool isMoved = alignment.moved > kMovedShare * tileSize(scene.model);
  return placeCounts && isMoved ? describe(alignment) : "";
}

}  // namespace

std::vector<std::string> targetWarnings(const Scene& scene) {
  std::vector<std::string> warnings;
  if (!isWanted(scene)) return warnings;
  for (const auto& warn : {tornWarning, turnedWarning, rigidWarning, movedWarning}) {
    std::string warning = warn(scene);
    if (!warning.empty()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::string reachWarning(const Scene& scene, const AssembledState& nearest) {
  const double tile = tileSize(scene.model);
  if (!isWanted(scene) || nearest.error <= kFarShare * tile) return "";
  const double bound = rigidBound(scene.model.tiles, *scene.model.target);
  if (nearest.error <= kAboveBound * bound) return "";
  return fmt::format(
      "the target is out of reach: the search for the nearest state with closed joints ended "
      "{:.3g} "
      "m ({:.2g} tiles) from it",
      nearest.error, nearest.error / tile);
}

}  // namespace kirireel
