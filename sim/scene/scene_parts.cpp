// What the command line adds to a model, in the order in which one depends on the other: targets
// first, as the start is aligned to the last of them; then numbers of tiles in the timeline; then
// the alignment, which looks at the tiles that are pinned; then what is measured in the aligned
// state (links, fixed joints).
//
// Everything that a user types counts tiles and vertices as the model's file does (from 0 or from
// 1, in the file's order). Here these numbers become the model's own.
#include "sim/scene/scene_parts.h"

#include <algorithm>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/alignment.h"
#include "sim/model/read_model.h"
#include "sim/scene/hinge_springs.h"

namespace kirireel {
namespace {

/// The chain of targets becomes the model's target and, before it, entries of the timeline.
void addTargets(const std::vector<std::filesystem::path>& files, Scene& scene,
                std::vector<std::string>& warnings) {
  if (files.empty()) return;
  Timeline chain;
  for (std::size_t k = 0; k + 1 < files.size(); ++k) {
    // The first target is headed for at once, each further one when the one before it is reached.
    const Occasion when = k == 0 ? Occasion{} : Occasion{Occasion::Kind::AtTarget};
    chain.push_back(
        {when, timeline::GoTo{files[k], readTarget(files[k], scene.model, warnings)}, {files[k]}});
  }
  scene.model.target = readTarget(files.back(), scene.model, warnings);
  if (chain.empty()) return;
  chain.push_back({{Occasion::Kind::AtTarget}, timeline::GoTo{}, {files.back()}});
  scene.timeline.insert(scene.timeline.begin(), chain.begin(), chain.end());
}

/// Options number tiles and vertices as the model's file does.
void requireTile(const Model& model, int tile, const char* option) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  if (tile >= first && tile < end) return;
  throw InputError(fmt::format("{}: error: the model has tiles {}-{}, not {}; correct this number",
                               option, first, end - 1, tile));
}

void requireTwoTiles(const Model& model, int tileA, int tileB, const char* option) {
  requireTile(model, tileA, option);
  requireTile(model, tileB, option);
  if (tileA != tileB) return;
  throw InputError(
      fmt::format("{}: error: tile {} cannot be joined to itself; name two tiles", option, tileA));
}

void requireVertex(const Model& model, const Corner& corner, const char* option) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles[corner.tile - first].vertices.size());
  if (corner.vertex >= first && corner.vertex < end) return;
  throw InputError(fmt::format("{}: error: tile {} has vertices {}-{}, not {}; correct this number",
                               option, corner.tile, first, end - 1, corner.vertex));
}

// Pairs of tiles that move as one from where they stand.
void addFixed(const std::vector<std::array<int, 2>>& pairs, Model& model) {
  for (const auto& [tileA, tileB] : pairs) {
    requireTwoTiles(model, tileA, tileB, "--fix");
    const int first = model.fileOrder.countsFrom;
    model.joints.push_back(makeFixedJoint(model.tiles, tileA - first, tileB - first));
  }
}

// Pairs of corners that keep their present distance.
void addLinks(const std::vector<std::array<int, 4>>& links, Model& model) {
  for (const auto& [tileA, vertexA, tileB, vertexB] : links) {
    requireTwoTiles(model, tileA, tileB, "--link");
    requireVertex(model, {tileA, vertexA}, "--link");
    requireVertex(model, {tileB, vertexB}, "--link");
    const Joint link = makeLink(model.tiles, model.fileOrder.toModel({tileA, vertexA}, model.tiles),
                                model.fileOrder.toModel({tileB, vertexB}, model.tiles));
    // kSamePlace of rounding.h: points as near as that are one.
    if (link.apart.norm() <= 1e-6 * modelSize(model)) {
      throw InputError(fmt::format(
          "--link: error: vertex {} of tile {} and vertex {} of tile {} are at one place; join "
          "them in constraints.txt instead",
          vertexA, tileA, vertexB, tileB));
    }
    model.joints.push_back(link);
  }
}

void readTimelineTargets(Scene& scene, std::vector<std::string>& warnings) {
  for (TimelineEntry& entry : scene.timeline) {
    auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
    if (!goTo || goTo->file.empty() || !goTo->tiles.empty()) continue;
    goTo->tiles = readTarget(goTo->file, scene.model, warnings);
  }
}

/// Frees tiles of a list, all of them where `freed` is empty.
void release(const std::vector<int>& freed, std::vector<int>& held) {
  if (freed.empty()) return held.clear();
  std::erase_if(held, [&](int tile) { return std::ranges::find(freed, tile) != freed.end(); });
}

/// The tiles that are pinned before anything moves and stay so to the end: the target can only be
/// reached where they stand. Those that are freed on the way can still go there.
std::vector<int> heldTiles(const Timeline& timeline) {
  std::vector<int> held;
  for (const TimelineEntry& entry : timeline) {
    // Entries happen in their order, so that the first one that waits ends what happens before
    // anything moves.
    const bool isAtOnce = entry.when.value == 0 && (entry.when.kind == Occasion::Kind::After ||
                                                    entry.when.kind == Occasion::Kind::AtTime);
    if (!isAtOnce) break;
    const auto* pin = std::get_if<timeline::Pin>(&entry.action);
    if (pin) held.insert(held.end(), pin->tiles.begin(), pin->tiles.end());
  }
  for (const TimelineEntry& entry : timeline) {
    const auto* unpin = std::get_if<timeline::Unpin>(&entry.action);
    if (unpin) release(unpin->tiles, held);
  }
  return held;
}

// Notes how far the start was moved and turned, for the summary.
void align(Scene& scene, const std::vector<int>& held) {
  const std::vector<Tile> before = scene.model.tiles;
  const RigidMotion motion = alignStartToTarget(scene.model, held);
  scene.alignment.byHeld = scene.model.target.has_value() && !held.empty();
  scene.alignment.turned = Eigen::AngleAxisd(motion.rotation).angle();
  scene.alignment.moved = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t k = 0; k < before[i].vertices.size(); ++k) {
      const double moved = (scene.model.tiles[i].vertices[k] - before[i].vertices[k]).norm();
      scene.alignment.moved = std::max(scene.alignment.moved, moved);
    }
  }
}

}  // namespace

void completeScene(const SceneParts& parts, Scene& scene, std::vector<std::string>& warnings) {
  addTargets(parts.targets, scene, warnings);
  readTimelineTargets(scene, warnings);
  Timeline entries = scene.timeline;
  if (!parts.pinned.empty()) {
    // Tiles of --pin are pinned before all other entries.
    entries.insert(entries.begin(), {Occasion{}, timeline::Pin{parts.pinned}, {"--pin"}});
  }
  checkTimeline(entries, scene.model);
  numberAsModel(entries, scene.model);
  scene.timeline = std::move(entries);
  numberAsModel(scene.velocities, scene.model);
  // Before joints are added: links and fixed joints measure distances, which a rigid motion keeps,
  // and directions, which it turns.
  if (scene.alignment.wanted) align(scene, heldTiles(scene.timeline));
  numberAsModel(scene.grips, scene.model);
  if (!scene.hinges.file.empty()) {
    scene.hinges.own = readHingeSprings(scene.hinges.file, scene.model);
  }
  addFixed(parts.fixed, scene.model);
  addLinks(parts.links, scene.model);
}

}  // namespace kirireel
