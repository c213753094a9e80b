// Warnings before the run about a target that rigid, jointed tiles cannot reach. They use only the
// data: joint gaps at the target, a sheet that is turned over, the distance at which single tiles
// fit their targets (measures.cpp), and a start that was moved by alignment although ground or
// obstacles fix its position.
#include "sim/path/target_warnings.h"

#include <optional>
#include <utility>

#include <fmt/format.h>

#include "sim/base/words.h"
#include "sim/model/sheet_frame.h"
#include "sim/run/arrival.h"
#include "sim/trajectory/measures.h"

namespace kirireel::path {
namespace {

// Smaller moves of the start, in tiles, do not count.
constexpr double kMovedShare = 1e-6;
// Bounds count as equal below this ratio.
constexpr double kAboveBound = 1.1;

bool pullsToTarget(const scene::Scene& scene) {
  return scene.model.target && scene.actuation.drive == scene::Drive::Target;
}

// Warns if joints are open in the target's own data.
std::string openTargetWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double gap = model::largestJointGap(scene.model.joints, *scene.model.target);
  if (gap <= run::kAllowedOpening * tile) return "";
  return fmt::format(
      "the target opens its joints by {} ({:.2g} tiles); closed joints cannot reach it",
      lengthText(gap, scene.model.unit), gap / tile);
}

/// A folded target is turned over only if all its tiles are reversed: they face many
/// directions.
std::string turnedWarning(const scene::Scene& scene) {
  const model::Model& model = scene.model;
  const auto count = static_cast<int>(model.tiles.size());
  const int turned = model::countTurnedOver(model.tiles, *model.target);
  const double flat = model::flatTolerance(model);
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model.tiles, flat);
  const bool areFlat = frame && model::isParallel(*frame, *model.target, flat);
  if (turned == 0 || (!areFlat && turned < count)) return "";
  return fmt::format("the target is turned over: {} of {} tiles face the opposite side there",
                     turned, count);
}

// Warns if the tiles' shapes differ from those of the target.
std::string rigidWarning(const scene::Scene& scene) {
  const double tile = model::tileSize(scene.model);
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (bound <= run::kFarError * tile) return "";
  return fmt::format(
      "the target is out of reach: its tiles have other shapes. Rigid tiles cannot come nearer "
      "than {}",
      model::lengthInTiles(bound, scene.model, 3));
}

// Reports a target that was moved onto the start, if its position matters.
std::string movedWarning(const scene::Scene& scene) {
  const scene::StartAlignment& alignment = scene.alignment;
  const scene::Environment& environment = scene.environment;
  const bool positionMatters = environment.ground || !environment.obstacles.empty();
  const bool isMoved = alignment.moved > kMovedShare * model::tileSize(scene.model);
  return positionMatters && isMoved ? scene::describe(alignment, scene.model.unit) : "";
}

}  // namespace

std::vector<std::string> targetWarnings(const scene::Scene& scene) {
  std::vector<std::string> warnings;
  if (!pullsToTarget(scene)) return warnings;
  for (const auto& warn : {openTargetWarning, turnedWarning, rigidWarning, movedWarning}) {
    std::string warning = warn(scene);
    if (!warning.empty()) warnings.push_back(std::move(warning));
  }
  return warnings;
}

std::string reachWarning(const scene::Scene& scene, const run::AssembledState& nearest) {
  const double tile = model::tileSize(scene.model);
  if (!pullsToTarget(scene) || nearest.error <= run::kFarError * tile) return "";
  const double bound = trajectory::rigidBound(scene.model.tiles, *scene.model.target);
  if (nearest.error <= kAboveBound * bound) return "";
  return fmt::format(
      "the target is out of reach: the nearest state found with closed joints is {} from it",
      model::lengthInTiles(nearest.error, scene.model, 3));
}

}  // namespace kirireel::path
