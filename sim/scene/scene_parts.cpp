// Adds the parts of a scene that need its model. The order matters: targets first, because the
// start is aligned to the last one; then the timeline, because the alignment depends on pinned
// tiles; then the alignment; last links and fixed joints, which are measured in the aligned state.
//
// Users number tiles and vertices as in the model's file (zero- or one-based, in the file's order).
// This file converts them to the model's own numbers.
#include "sim/scene/scene_parts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/words.h"
#include "sim/brick/stiffness.h"
#include "sim/formats/read_model.h"
#include "sim/formats/text_table.h"
#include "sim/formats/written_digits.h"
#include "sim/model/convex_parts.h"
#include "sim/model/isometry.h"
#include "sim/model/sheet_frame.h"
#include "sim/scene/conditions.h"
#include "sim/scene/scene_needs.h"

namespace kirireel::scene {
namespace {

/// The intermediate states of the model's file become entries of the timeline, unless the tiles are
/// not driven to targets.
void addWaypoints(Scene& scene) {
  const std::vector<std::vector<model::Tile>>& waypoints = scene.model.waypoints;
  const bool goesToTargets =
      scene.actuation.drive == Drive::Auto || scene.actuation.drive == Drive::Target;
  if (waypoints.empty() || !goesToTargets || !scene.grips.empty()) return;
  Timeline chain;
  for (std::size_t k = 0; k < waypoints.size(); ++k) {
    const Trigger when = k == 0 ? Trigger{} : Trigger{Trigger::Kind::AtTarget};
    const std::string name = fmt::format("{}, target {}", scene.model.name, k + 1);
    chain.push_back({when, timeline::GoTo{name, waypoints[k]}, {name}});
  }
  chain.push_back({{Trigger::Kind::AtTarget}, timeline::GoTo{}, {scene.model.name}});
  scene.timeline.insert(scene.timeline.begin(), chain.begin(), chain.end());
}

/// Letters without angles fold by 180 degrees only if no other setting gives the angle. Springs
/// with their own rest angle fold the sheet in place of a target.
void foldBySprings(Scene& scene) {
  const std::optional<model::FoldSheet>& drawing = scene.model.drawing;
  const bool isByLetters = drawing && drawing->givesTarget && !drawing->hasAngles;
  const bool areSprung = scene.hinges.stiffness > 0 && scene.hinges.rest;
  if (!isByLetters || !areSprung || scene.actuation.drive != Drive::Auto) return;
  scene.model.target.reset();
  scene.actuation.drive = Drive::None;
}

/// The last target becomes the model's target, the others entries of the timeline.
void addTargets(const std::vector<std::filesystem::path>& files, Scene& scene,
                std::vector<std::string>& warnings) {
  if (files.empty()) {
    foldBySprings(scene);
    return addWaypoints(scene);
  }
  scene.model.waypoints.clear();
  Timeline chain;
  for (std::size_t k = 0; k + 1 < files.size(); ++k) {
    // The first target applies at once, each further one when the previous one is reached.
    const Trigger when = k == 0 ? Trigger{} : Trigger{Trigger::Kind::AtTarget};
    chain.push_back({when,
                     timeline::GoTo{files[k], formats::readTarget(files[k], scene.model, warnings)},
                     {files[k]}});
  }
  scene.model.target = formats::readTarget(files.back(), scene.model, warnings);
  if (chain.empty()) return;
  chain.push_back({{Trigger::Kind::AtTarget}, timeline::GoTo{}, {files.back()}});
  scene.timeline.insert(scene.timeline.begin(), chain.begin(), chain.end());
}

/// Options use the tile and vertex numbers of the model's file.
void requireTile(const model::Model& model, int tile, const char* option) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  if (tile >= first && tile < end) return;
  throw InputError(fmt::format("{}: error: the model has tiles {}-{}, not {}. Correct this number",
                               option, first, end - 1, tile));
}

void requireTwoTiles(const model::Model& model, int tileA, int tileB, const char* option) {
  requireTile(model, tileA, option);
  requireTile(model, tileB, option);
  if (tileA != tileB) return;
  throw InputError(
      fmt::format("{}: error: tile {} cannot be joined to itself. Name two tiles", option, tileA));
}

void requireVertex(const model::Model& model, const model::Corner& corner, const char* option) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles[corner.tile - first].vertices.size());
  if (corner.vertex >= first && corner.vertex < end) return;
  throw InputError(fmt::format("{}: error: tile {} has vertices {}-{}, not {}. Correct this number",
                               option, corner.tile, first, end - 1, corner.vertex));
}

// Pairs of tiles that move as one, in their current relative position.
void addFixed(const std::vector<std::array<int, 2>>& pairs, model::Model& model) {
  for (const auto& [tileA, tileB] : pairs) {
    requireTwoTiles(model, tileA, tileB, "`fix`");
    const int first = model.fileOrder.countsFrom;
    model.joints.push_back(model::makeFixedJoint(model.tiles, tileA - first, tileB - first));
  }
}

// Pairs of corners that keep their current distance.
void addLinks(const std::vector<std::array<int, 4>>& links, model::Model& model) {
  for (const auto& [tileA, vertexA, tileB, vertexB] : links) {
    requireTwoTiles(model, tileA, tileB, "`link`");
    requireVertex(model, {tileA, vertexA}, "`link`");
    requireVertex(model, {tileB, vertexB}, "`link`");
    const model::Joint link =
        model::makeLink(model.tiles, model.fileOrder.toModel({tileA, vertexA}, model.tiles),
                        model.fileOrder.toModel({tileB, vertexB}, model.tiles));
    if (link.apart.norm() <= formats::kSamePlace * model::modelSize(model)) {
      throw InputError(
          fmt::format("`link`: error: vertex {} of tile {} and vertex {} of tile {} are at the "
                      "same position. Join them in constraints.txt instead",
                      vertexA, tileA, vertexB, tileB));
    }
    model.joints.push_back(link);
  }
}

void readTimelineTargets(Scene& scene, std::vector<std::string>& warnings) {
  for (TimelineEntry& entry : scene.timeline) {
    auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
    if (!goTo || goTo->file.empty() || !goTo->tiles.empty()) continue;
    goTo->tiles = formats::readTarget(goTo->file, scene.model, warnings);
  }
}

/// Frees the listed tiles, or all tiles if `freed` is empty.
void release(const std::vector<int>& freed, std::vector<int>& held) {
  if (freed.empty()) return held.clear();
  std::erase_if(held, [&](int tile) { return std::ranges::find(freed, tile) != freed.end(); });
}

/// The tiles that are pinned before any motion and until the end. The target must have them at
/// their position. Tiles that are freed later can still move there.
std::vector<int> heldTiles(const Timeline& timeline) {
  std::vector<int> held;
  for (const TimelineEntry& entry : timeline) {
    // Entries happen in their order. The first entry that waits ends the part before any motion.
    const bool isAtOnce = entry.when.value == 0 && (entry.when.kind == Trigger::Kind::After ||
                                                    entry.when.kind == Trigger::Kind::AtTime);
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

// Each state of a chain and each target of the timeline is moved onto the start on its own. Records
// displacement and rotation, for the summary.
void align(Scene& scene, const std::vector<int>& held) {
  model::Model& model = scene.model;
  StartAlignment& alignment = scene.alignment;
  alignment.byHeld = model.target.has_value() && !held.empty();
  alignment.turned = alignment.moved = 0;
  if (!alignment.movesStart) {
    for (std::vector<model::Tile>& state : model.waypoints) model::alignToStart(model, state, held);
    for (TimelineEntry& entry : scene.timeline) {
      auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
      if (goTo && !goTo->tiles.empty()) model::alignToStart(model, goTo->tiles, held);
    }
  }
  if (!model.target) return;
  std::vector<model::Tile>& moving = alignment.movesStart ? model.tiles : *model.target;
  const std::vector<model::Tile> before = moving;
  const model::RigidMotion motion = alignment.movesStart
                                        ? model::alignStartToTarget(model, held)
                                        : model::alignToStart(model, *model.target, held);
  alignment.turned = Eigen::AngleAxisd(motion.rotation).angle();
  for (std::size_t i = 0; i < before.size(); ++i) {
    for (std::size_t k = 0; k < before[i].vertices.size(); ++k) {
      const double moved = (moving[i].vertices[k] - before[i].vertices[k]).norm();
      alignment.moved = std::max(alignment.moved, moved);
    }
  }
}

/// If the scene uses the model's own necks, every joint must have one.
void requireNecks(const Scene& scene) {
  if (!scene.hinges.neck || scene.hinges.neck->width > 0) return;
  const model::Model& model = scene.model;
  const auto without = std::ranges::find_if(model.joints, [](const model::Joint& joint) {
    return joint.kind == model::JointKind::Pivot && !joint.neck;
  });
  if (without == model.joints.end()) return;
  const int first = model.fileOrder.countsFrom;
  throw InputError(fmt::format(
      "error: `hinge_neck` has only a material, but the model has no neck at the joint between "
      "tiles {} and {}. Give width, length and Young's modulus, for example 0.1,0.3,2e9",
      first + without->a.tile, first + without->b.tile));
}

/// The middle of tiles that are far from the origin, where doubles lose precision; 0 for other
/// tiles. Metres.
Vector3 farMiddle(const std::vector<model::Tile>& tiles) {
  constexpr double kFar = 1e4;  // multiple of their diagonal at which joints close only to 1e-12
  const Eigen::AlignedBox3d box = model::boxOf(tiles);
  const bool isFar = box.center().norm() > kFar * box.diagonal().norm();
  return isFar ? Vector3(box.center()) : Vector3::Zero();
}

void moveBy(const Vector3& move, std::vector<model::Tile>& tiles) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex += move;
  }
}

/// Moves a distant model to the origin, with everything that has a position. States that will be
/// aligned are moved independently.
void moveToOrigin(Scene& scene, std::vector<std::string>& warnings) {
  model::Model& model = scene.model;
  const StartAlignment& alignment = scene.alignment;
  const bool movesStart = alignment.requested && alignment.movesStart && model.target;
  const bool movesTargets = alignment.requested && !alignment.movesStart;
  const Vector3 move = -farMiddle(movesStart ? *model.target : model.tiles);
  moveBy(movesStart ? Vector3(-farMiddle(model.tiles)) : move, model.tiles);
  const auto moveTarget = [&](std::vector<model::Tile>& state) {
    moveBy(movesTargets ? Vector3(-farMiddle(state)) : move, state);
  };
  if (model.target) moveTarget(*model.target);
  for (std::vector<model::Tile>& state : model.waypoints) moveTarget(state);
  for (TimelineEntry& entry : scene.timeline) {
    if (auto* goTo = std::get_if<timeline::GoTo>(&entry.action)) moveTarget(goTo->tiles);
  }
  if (move.isZero(0)) return;
  if (scene.environment.ground) scene.environment.ground->height += move.z();
  for (Obstacle& obstacle : scene.environment.obstacles) obstacle.pose.position += move;
  for (TimelineEntry& entry : scene.timeline) {
    if (auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
      for (Vector3& point : drag->path) point += move;
    }
  }
  const Vector3 shown = move / model.unit.metres;
  warnings.push_back(fmt::format(
      "{}: warning: the model is {:.2g} times its size away from the origin, which costs "
      "precision. It is moved by ({:.17g}, {:.17g}, {:.17g}) {}, with obstacles and drags",
      model.name, move.norm() / model::modelSize(model), shown.x(), shown.y(), shown.z(),
      model.unit.name));
}

}  // namespace

void completeScene(const SceneParts& parts, Scene& scene, std::vector<std::string>& warnings) {
  requireNecks(scene);
  if (scene.path.to == Destination::Closed) {
    if (!parts.targets.empty()) {
      throw InputError("error: `to = closed` and `target` define different ends. Use only one");
    }
    scene.model.target.reset();
    scene.model.waypoints.clear();
  }
  addTargets(parts.targets, scene, warnings);
  readTimelineTargets(scene, warnings);
  Timeline entries = scene.timeline;
  if (!parts.pinned.empty()) {
    // Tiles of --pin are pinned before all other entries.
    entries.insert(entries.begin(), {Trigger{}, timeline::Pin{parts.pinned}, {"`pin`"}});
  }
  checkTimeline(entries, scene.model);
  numberAsModel(entries, scene.model);
  scene.timeline = std::move(entries);
  numberAsModel(scene.velocities, scene.model);
  // Before joints are added: links and fixed joints measure distances and directions. A rigid
  // motion keeps distances but rotates directions.
  moveToOrigin(scene, warnings);
  if (scene.alignment.requested) align(scene, heldTiles(scene.timeline));
  numberAsModel(scene.grips, scene.model);
  if (!scene.hinges.file.empty()) {
    scene.hinges.own = readHingeSprings(scene.hinges.file, scene.model);
  }
  addFixed(parts.fixed, scene.model);
  addLinks(parts.links, scene.model);
}

namespace {

/// The parts of each tile that existed before splitting, by its old number.
std::vector<std::vector<int>> partsOfTiles(const model::Model& split, std::size_t count) {
  std::vector<int> whole(split.tiles.size());
  std::iota(whole.begin(), whole.end(), 0);
  // The first part keeps the tile's number, which is lower than those of all other parts.
  for (bool isDone = false; !isDone;) {
    isDone = true;
    for (const model::Joint& joint : split.joints) {
      int& a = whole[static_cast<std::size_t>(joint.a.tile)];
      int& b = whole[static_cast<std::size_t>(joint.b.tile)];
      if (!joint.isWithinTile || a == b) continue;
      a = b = std::min(a, b);
      isDone = false;
    }
  }
  std::vector<std::vector<int>> parts(count);
  for (std::size_t k = 0; k < whole.size(); ++k) {
    parts[static_cast<std::size_t>(whole[k])].push_back(static_cast<int>(k));
  }
  return parts;
}

/// Replaces tiles by their parts.
void replaceByParts(const std::vector<std::vector<int>>& parts, std::vector<int>& tiles) {
  std::vector<int> all;
  for (const int tile : tiles) {
    const std::vector<int>& own = parts[static_cast<std::size_t>(tile)];
    all.insert(all.end(), own.begin(), own.end());
  }
  tiles = std::move(all);
}

/// Whether an entry refers to whole tiles and cannot use parts.
bool namesWholeTiles(const TimelineEntry& entry) {
  const auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
  return std::holds_alternative<timeline::Drag>(entry.action) || (goTo && !goTo->tiles.empty());
}

}  // namespace

void splitTiles(const std::vector<int>& tiles, Scene& scene) {
  if (!scene.grips.empty() || !scene.hinges.own.empty() ||
      std::ranges::any_of(scene.timeline, namesWholeTiles)) {
    throw InputError(
        "error: `split_tiles` renumbers tiles, so drags, chains of targets, grips and files of "
        "hinges do not work with it. Remove one of them");
  }
  const std::size_t count = scene.model.tiles.size();
  scene.model = model::splitTiles(scene.model, tiles);
  const std::vector<std::vector<int>> parts = partsOfTiles(scene.model, count);
  for (TimelineEntry& entry : scene.timeline) {
    if (auto* pin = std::get_if<timeline::Pin>(&entry.action)) replaceByParts(parts, pin->tiles);
    if (auto* unpin = std::get_if<timeline::Unpin>(&entry.action)) {
      replaceByParts(parts, unpin->tiles);
    }
  }
  for (InitialVelocity& velocity : scene.velocities) replaceByParts(parts, velocity.tiles);
}

// ------------------------------------------------------------------------------------------------
// Springs at hinges: those of a file, with one hinge per line, and the default of all hinges.
//
// 1. Hinges are found from the common pivots of two bricks (brick/hinge.h). In space, two tiles may
//    have a common edge whose corners are joined only through other tiles. An example is a vertex
//    of four origami panels with a chain of joints. For such folds all corners at one point are
//    first joined pair by pair on each face. The additional folds are hinges too.
// 2. Each hinge gets a stiffness (N m/rad), a rest angle (rad) and a damping (N m s/rad). The
//    values of its line in the file have priority over those of all hinges. By default, a fold
//    rests at the angle of the FOLD file, and another hinge at its angle at the start. If tiles
//    turn about a corner, all hinges may have the stiffness of a neck of material (stiffness.h). A
//    neck of length 0 next to an initially closed slit has the stiffness of a crack tip, from its
//    own table. If tiles have a material (PanelMaterial), the hinges between parts of one tile have
//    its bending stiffness. They rest at their current angle, independent of all hinges. Folds
//    without a stiffness get it from the material's length scale.
// 3. A rest angle at which bricks overlap is refused, since contacts or joints would never let the
//    spring come to rest.

namespace {

constexpr std::size_t kMaxColumns = 5;
constexpr double kMaxStiffness = 1e12;  // N m/rad, and N m s/rad
constexpr double kMaxRest = 360;        // degrees
// Tolerance of rest angles beyond the reachable angles, radians: edges are flush up to rounding.
constexpr double kAngleRounding = 1e-6;

using TilePair = std::pair<int, int>;

int readTile(const formats::TextTable& table, const formats::TextLine& line, std::size_t column,
             const model::Model& model) {
  const FileLocation where = table.at(line, line.fields[column]);
  const int tile = formats::parseWholeNumber(line.fields[column], where, "a tile number");
  return tileOfModel(tile, model, where);
}

/// An optional number of a line.
std::optional<double> readOptional(const formats::TextTable& table, const formats::TextLine& line,
                                   std::size_t column, double least, double most,
                                   const char* meaning) {
  // A hyphen marks a missing column before other columns.
  if (column >= line.fields.size() || line.fields[column].text == "-") return std::nullopt;
  const formats::TextField& field = line.fields[column];
  return formats::parseNumberWithin(field, table.at(line, field), least, most, meaning);
}

OwnHingeSpring readSpring(const formats::TextTable& table, const formats::TextLine& line,
                          const model::Model& model) {
  const FileLocation where = table.at(line, line.fields.front());
  if (line.fields.size() < 2 || line.fields.size() > kMaxColumns) {
    throw inputErrorAt(
        where, fmt::format("this line has {}. A hinge has tile, tile, stiffness, rest angle, "
                           "damping. The last ones are optional",
                           counted(line.fields.size(), "column")));
  }
  OwnHingeSpring spring;
  spring.tileA = readTile(table, line, 0, model);
  spring.tileB = readTile(table, line, 1, model);
  spring.stiffness =
      readOptional(table, line, 2, 0, kMaxStiffness,
                   "a stiffness in [0, 1e12] N m/rad, or - for the value of all hinges");
  spring.rest =
      readOptional(table, line, 3, -kMaxRest, kMaxRest,
                   "a rest angle in [-360, 360] degrees, or - for the value of all hinges");
  if (spring.rest) *spring.rest *= kDegree;
  spring.damping =
      readOptional(table, line, 4, 0, kMaxStiffness,
                   "a damping in [0, 1e12] N m s/rad, or - for the value of all hinges");
  spring.where = where;
  return spring;
}

/// Refuses overlap of bricks at a spring's rest angle. `line` is its source; null: the option.
void requireNoOverlapAtRest(const brick::HingeSpring& spring, const OwnHingeSpring* line,
                            const model::Model& model) {
  const brick::Hinge& hinge = spring.hinge;
  if (spring.rest >= hinge.least - kAngleRounding && spring.rest <= hinge.most + kAngleRounding) {
    return;
  }
  const int first = model.fileOrder.countsFrom;
  const std::string message = fmt::format(
      "with a rest angle of {:.6g} degrees tiles {} and {} overlap. Use [{:.6g}, {:.6g}] degrees",
      spring.rest / kDegree, first + hinge.brickA, first + hinge.brickB, hinge.least / kDegree,
      hinge.most / kDegree);
  throw line ? inputErrorAt(line->where, message) : InputError("`hinge_rest`: error: " + message);
}

/// Joins every two corners that joints connect on a face, directly or through others.
std::vector<model::Joint> joinedCorners(const std::vector<model::Joint>& joints,
                                        model::JointFace face) {
  using CornerKey = std::pair<int, int>;
  std::map<CornerKey, int> groupOf;
  std::vector<std::vector<model::Corner>> groups;
  const auto groupAt = [&](const model::Corner& corner) {
    const auto [place, isNew] =
        groupOf.try_emplace({corner.tile, corner.vertex}, static_cast<int>(groups.size()));
    if (isNew) groups.push_back({corner});
    return place->second;
  };
  for (const model::Joint& joint : joints) {
    if (joint.kind != model::JointKind::Pivot ||
        (joint.face != face && joint.face != model::JointFace::Both)) {
      continue;
    }
    const int kept = groupAt(joint.a), emptied = groupAt(joint.b);
    if (kept == emptied) continue;
    // Corners of the emptied group move to the kept one. Groups have a few corners each.
    for (const model::Corner& corner : groups[static_cast<std::size_t>(emptied)]) {
      groupOf[{corner.tile, corner.vertex}] = kept;
      groups[static_cast<std::size_t>(kept)].push_back(corner);
    }
    groups[static_cast<std::size_t>(emptied)].clear();
  }
  std::vector<model::Joint> all;
  for (const std::vector<model::Corner>& group : groups) {
    for (std::size_t b = 1; b < group.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        if (group[a].tile != group[b].tile) all.push_back({group[a], group[b], face});
      }
    }
  }
  return all;
}

bool isFold(const brick::Hinge& hinge) {
  // Corner angles are >= 0, with 0 for flush edges. Folds go to both sides of flat.
  return hinge.least < 0;
}

/// Adds the folds between tiles whose common corners are joined through other tiles, such as at a
/// vertex of four origami panels.
void addIndirectFolds(const Scene& scene, const std::vector<brick::Brick>& bricks,
                      brick::FoundHinges& found) {
  // A directly joined pair already has its hinge.
  std::set<TilePair> known;
  for (const brick::Hinge& hinge : found.hinges)
    known.insert(std::minmax(hinge.brickA, hinge.brickB));
  for (const model::JointFace face : {model::JointFace::Bottom, model::JointFace::Top}) {
    const brick::FoundHinges joined = brick::findHinges(
        bricks, brick::makePivots(joinedCorners(scene.model.joints, face), bricks), false);
    for (const brick::Hinge& hinge : joined.hinges) {
      const bool isNew = known.insert(std::minmax(hinge.brickA, hinge.brickB)).second;
      if (isFold(hinge) && isNew) found.hinges.push_back(hinge);
    }
  }
}

/// The hinges of a scene. If the user requested springs, at least one is required.
brick::FoundHinges requireHinges(const Scene& scene, const std::vector<brick::Brick>& bricks) {
  // In the plane one common point is a vertical hinge, in space a ball joint.
  const bool isPlanar = sceneNeeds(scene).planar.on;
  brick::FoundHinges found =
      brick::findHinges(bricks, brick::makePivots(scene.model.joints, bricks), isPlanar);
  if (!isPlanar) addIndirectFolds(scene, bricks, found);
  if (!found.hinges.empty() || !scene.hinges.areGiven()) return found;
  if (found.ballJoints.empty()) {
    throw InputError(
        "error: springs need hinges, but no two tiles rotate about a common corner or edge. Remove "
        "`hinge_stiffness`");
  }
  throw InputError(
      fmt::format("error: springs need hinges, but in space {} joints at one corner of one face "
                  "are ball joints without an axis. Join both faces (column 5 of constraints.txt: "
                  "3), or keep the sheet in its plane (`planar = on`)",
                  found.ballJoints.size()));
}

/// A common edge of two tiles: its corner numbers in the first and in the second tile.
struct CommonEdge {
  std::array<int, 2> ofA{};
  std::array<int, 2> ofB{};
};

/// The corners that joints connect, of the first tile and of the second.
std::map<TilePair, std::set<std::pair<int, int>>> commonCorners(
    const std::vector<model::Joint>& joints) {
  std::map<TilePair, std::set<std::pair<int, int>>> common;
  for (const model::JointFace face : {model::JointFace::Bottom, model::JointFace::Top}) {
    for (const model::Joint& joint : joinedCorners(joints, face)) {
      const bool isSwapped = joint.b.tile < joint.a.tile;
      const model::Corner &a = isSwapped ? joint.b : joint.a, &b = isSwapped ? joint.a : joint.b;
      common[{a.tile, b.tile}].emplace(a.vertex, b.vertex);
    }
  }
  return common;
}

/// Whether two corners of a tile are neighbours.
bool areNeighbours(int corner, int other, const model::Tile& tile) {
  const int apart = std::abs(corner - other);
  return apart == 1 || apart + 1 == static_cast<int>(tile.vertices.size());
}

/// The edges between corners that are neighbours in both tiles.
std::vector<CommonEdge> edgesBetween(const std::set<std::pair<int, int>>& corners,
                                     const model::Tile& a, const model::Tile& b) {
  std::vector<CommonEdge> edges;
  for (const auto& [fromA, fromB] : corners) {
    for (const auto& [toA, toB] : corners) {
      if (toA <= fromA || !areNeighbours(fromA, toA, a) || !areNeighbours(fromB, toB, b)) continue;
      edges.push_back({{fromA, toA}, {fromB, toB}});
    }
  }
  return edges;
}

/// The neck at a joint: from the scene if it has a width, else from the model.
HingeNeck neckAt(const Scene& scene, const model::Joint& joint) {
  HingeNeck neck = *scene.hinges.neck;
  if (neck.width > 0) return neck;
  neck.width = brick::materialWidth(joint.neck);
  neck.length = std::max(joint.neck.length, joint.neck.kerf);
  return neck;
}

/// The default spring of the hinges, for hinges without a line in the file.
class DefaultSprings {
 public:
  DefaultSprings(const Scene& scene, const std::vector<brick::Brick>& bricks)
      : scene_(scene), bricks_(bricks) {
    if (scene.hinges.neck) {
      for (const model::Joint& joint : scene.model.joints) {
        if (joint.kind == model::JointKind::Pivot) jointAt_.emplace(cornersOf(joint), &joint);
      }
    }
    if (!scene.hinges.panels) return;
    common_ = commonCorners(scene.model.joints);
    for (const model::Joint& joint : scene.model.joints) {
      if (joint.isWithinTile) bends_.insert(std::minmax(joint.a.tile, joint.b.tile));
    }
  }

  /// Whether the hinge is a bend within a tile, which has no springs of hinges.
  bool isBend(const brick::Hinge& hinge) const { return bends_.contains(tilesOf(hinge)); }

  double stiffness(const brick::Hinge& hinge) const {
    const HingeSettings& all = scene_.hinges;
    if (isBend(hinge)) return bending(hinge);
    // Necks are at corners. A fold has the default stiffness.
    if (all.neck && !isFold(hinge)) return neckStiffnessAt(hinge);
    const bool isByLength = all.stiffness == 0 && all.panels && all.panels->foldLength > 0;
    return isByLength && isFold(hinge) ? folding(hinge) : all.stiffness;
  }

  /// The default rest angle, with opposite sign for a mountain of the model's file.
  double signedRest(const brick::Hinge& hinge, double rest) const {
    const auto found = scene_.model.foldAngles.find({hinge.brickA, hinge.brickB});
    const bool isMountain = found != scene_.model.foldAngles.end() && found->second < 0;
    return isFold(hinge) && isMountain ? -rest : rest;
  }

  double rest(const brick::Hinge& hinge) const {
    const auto found = scene_.model.foldAngles.find({hinge.brickA, hinge.brickB});
    const bool isInFile = isFold(hinge) && found != scene_.model.foldAngles.end();
    return isInFile ? found->second : hinge.start;
  }

 private:
  static TilePair tilesOf(const brick::Hinge& hinge) {
    return std::minmax(hinge.brickA, hinge.brickB);
  }
  const model::Tile& tile(int number) const {
    return scene_.model.tiles[static_cast<std::size_t>(number)];
  }
  const brick::Brick& brick(int number) const { return bricks_[static_cast<std::size_t>(number)]; }

  std::vector<CommonEdge> edgesAt(const brick::Hinge& hinge) const {
    const auto [a, b] = tilesOf(hinge);
    return edgesBetween(common_.at({a, b}), tile(a), tile(b));
  }

  using CornerPair = std::pair<std::pair<int, int>, std::pair<int, int>>;
  static CornerPair cornersOf(const model::Joint& joint) {
    return std::minmax(std::pair(joint.a.tile, joint.a.vertex),
                       std::pair(joint.b.tile, joint.b.vertex));
  }

  double neckStiffnessAt(const brick::Hinge& hinge) const {
    const HingeNeck neck = neckAt(
        scene_,
        *jointAt_.at(cornersOf({{hinge.brickA, hinge.cornerA}, {hinge.brickB, hinge.cornerB}})));
    const double thickness = scene_.brick.thickness;
    const bool isClosed = hinge.start <= kAngleRounding;
    if (!isClosed) return brick::neckStiffness(neck.youngs, thickness, neck.width, neck.length);
    return brick::neckStiffness(neck.youngs, thickness, neck.width, neck.length,
                                {brick::neckCorner(brick(hinge.brickA), hinge.cornerA),
                                 brick::neckCorner(brick(hinge.brickB), hinge.cornerB)});
  }

  /// Bending stiffness of a tile at the diagonal between two of its triangles.
  double bending(const brick::Hinge& hinge) const {
    const PanelMaterial& material = *scene_.hinges.panels;
    const auto [a, b] = tilesOf(hinge);
    const CommonEdge edge = edgesAt(hinge).at(0);
    // The corner numbers of a triangle add up to 3.
    const auto wing = [&](int number, const std::array<int, 2>& corners) {
      return tile(number).vertices[static_cast<std::size_t>(3 - corners[0] - corners[1])];
    };
    const Vector3& from = tile(a).vertices[static_cast<std::size_t>(edge.ofA[0])];
    const Vector3& to = tile(a).vertices[static_cast<std::size_t>(edge.ofA[1])];
    return brick::bendStiffness({from, wing(b, edge.ofB), to, wing(a, edge.ofA)},
                                (to - from).norm(), material.youngs, material.poisson,
                                scene_.brick.thickness);
  }

  /// Stiffness of a fold. Its length is the sum of all common edges of its tiles.
  double folding(const brick::Hinge& hinge) const {
    const PanelMaterial& material = *scene_.hinges.panels;
    const model::Tile& a = tile(tilesOf(hinge).first);
    double length = 0;
    for (const CommonEdge& edge : edgesAt(hinge)) {
      const auto [from, to] = edge.ofA;
      length +=
          (a.vertices[static_cast<std::size_t>(to)] - a.vertices[static_cast<std::size_t>(from)])
              .norm();
    }
    return brick::foldStiffness(length, material.foldLength, material.youngs, material.poisson,
                                scene_.brick.thickness);
  }

  const Scene& scene_;
  const std::vector<brick::Brick>& bricks_;
  std::map<TilePair, std::set<std::pair<int, int>>> common_;
  std::set<TilePair> bends_;
  std::map<CornerPair, const model::Joint*> jointAt_;  // of necks
};

/// The lines of the file by their tiles, the lower number first.
std::map<TilePair, const OwnHingeSpring*> byTiles(const std::vector<OwnHingeSpring>& own) {
  std::map<TilePair, const OwnHingeSpring*> lines;
  for (const OwnHingeSpring& line : own) lines[std::minmax(line.tileA, line.tileB)] = &line;
  return lines;
}

[[noreturn]] void refuseLine(const OwnHingeSpring& line, const brick::FoundHinges& found,
                             int first) {
  const TilePair tiles = std::minmax(line.tileA, line.tileB);
  const bool isBall = std::ranges::any_of(found.ballJoints, [&](const TilePair& ball) {
    return TilePair(std::minmax(ball.first, ball.second)) == tiles;
  });
  throw inputErrorAt(
      line.where,
      fmt::format(
          "tiles {} and {} {}. Remove this line", first + line.tileA, first + line.tileB,
          isBall ? "share one corner of one face, which is a ball joint without an axis in space"
                 : "have no common corner or edge to rotate about"));
}

}  // namespace

std::vector<OwnHingeSpring> readHingeSprings(const std::filesystem::path& file,
                                             const model::Model& model) {
  formats::TextTable table(file, "a list of hinges, tile tile stiffness rest damping");
  std::vector<OwnHingeSpring> springs;
  std::map<TilePair, int> lines;
  for (formats::TextLine line; table.next(line);) {
    springs.push_back(readSpring(table, line, model));
    const OwnHingeSpring& spring = springs.back();
    const auto [known, isNew] =
        lines.try_emplace(std::minmax(spring.tileA, spring.tileB), line.number);
    if (isNew) continue;
    throw inputErrorAt(
        spring.where,
        fmt::format("this hinge is already on line {}. Remove one of them", known->second));
  }
  return springs;
}

std::vector<brick::HingeSpring> hingeSprings(const Scene& scene,
                                             const std::vector<brick::Brick>& bricks) {
  const HingeSettings& all = scene.hinges;
  if (!all.areOn()) return {};
  const brick::FoundHinges found = requireHinges(scene, bricks);
  const DefaultSprings defaults(scene, bricks);
  std::map<TilePair, const OwnHingeSpring*> lines = byTiles(all.own);
  std::vector<brick::HingeSpring> springs;
  for (const brick::Hinge& hinge : found.hinges) {
    OwnHingeSpring own;
    if (const auto line = lines.find(std::minmax(hinge.brickA, hinge.brickB));
        line != lines.end()) {
      own = *line->second;
      // Remaining lines of the file fit no hinge and are refused.
      lines.erase(line);
    }
    const std::optional<double> rest = own.rest || !all.rest || defaults.isBend(hinge)
                                           ? own.rest
                                           : defaults.signedRest(hinge, *all.rest);
    const brick::HingeSpring spring{hinge, own.stiffness.value_or(defaults.stiffness(hinge)),
                                    rest.value_or(defaults.rest(hinge)),
                                    own.damping.value_or(all.damping)};
    if (spring.stiffness == 0 && spring.damping == 0) continue;
    if (rest) requireNoOverlapAtRest(spring, own.rest ? &own : nullptr, scene.model);
    springs.push_back(spring);
  }
  if (!lines.empty()) {
    refuseLine(*lines.begin()->second, found, scene.model.fileOrder.countsFrom);
  }
  return springs;
}

// ------------------------------------------------------------------------------------------------
// Joints of necks: exact joints and ligaments.
//
// A neck at a joint of two tiles has an axis on the slit next to the corner, if the slit is closed
// at the start (neckAxis()). A neck with a length becomes a straight ligament if ligaments are
// requested. Its middle is the joint, and it points from tile A to tile B. A neck of length 0 is
// the end of the slit: a pin that can open across the slit and slide along it. All other joints
// stay exact.

namespace {

/// The unit directions of both edges from a corner, to the next and the previous vertex of the
/// tile.
std::array<Vector3, 2> edgesAt(const brick::Brick& brick, int corner) {
  const std::size_t count = brick.bottom.size();
  const auto k = static_cast<std::size_t>(corner);
  return {(brick.bottom[(k + 1) % count] - brick.bottom[k]).normalized(),
          (brick.bottom[(k + count - 1) % count] - brick.bottom[k]).normalized()};
}

/// The direction from a corner into its tile: the sum of two unit edges bisects the corner's angle.
/// Its length has no meaning.
Vector3 inwardAt(const brick::Brick& brick, int corner) {
  const auto [next, last] = edgesAt(brick, corner);
  return next + last;
}

/// The unit direction of both tiles' edge at their joint if a closed slit lies along it.
std::optional<Vector3> slitAt(const brick::Pivot& pivot, const std::vector<brick::Brick>& bricks) {
  constexpr double kFlush = 1e-6;  // tolerance of the cosine
  const brick::Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const brick::Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  for (const Vector3& a : edgesAt(brickA, pivot.cornerA)) {
    for (const Vector3& b : edgesAt(brickB, pivot.cornerB)) {
      if (a.dot(b) > 1 - kFlush) return a;
    }
  }
  return std::nullopt;
}

/// The corners of both tiles at their joint.
std::array<brick::NeckCorner, 2> neckCorners(const brick::Pivot& pivot,
                                             const std::vector<brick::Brick>& bricks) {
  return {brick::neckCorner(bricks[static_cast<std::size_t>(pivot.brickA)], pivot.cornerA),
          brick::neckCorner(bricks[static_cast<std::size_t>(pivot.brickB)], pivot.cornerB)};
}

/// Normal of the plane of motion of a planar scene.
Vector3 normalOf(const Scene& scene) {
  return model::sheetFrame(scene.model).value_or(model::SheetFrame{}).normal;
}

/// The neck at a joint as a ligament. Its middle is the joint, and it connects the two tiles.
brick::Ligament ligamentAt(const brick::Pivot& pivot, const std::vector<brick::Brick>& bricks,
                           const Scene& scene) {
  const std::optional<LigamentStiffness>& given = scene.hinges.ligament;
  const HingeNeck neck =
      given ? HingeNeck{.length = given->length}
            : neckAt(scene, scene.model.joints[static_cast<std::size_t>(pivot.joint)]);
  const Vector3 across =
      inwardAt(bricks[static_cast<std::size_t>(pivot.brickB)], pivot.cornerB).normalized() -
      inwardAt(bricks[static_cast<std::size_t>(pivot.brickA)], pivot.cornerA).normalized();
  brick::Ligament ligament{pivot.brickA, pivot.brickB, pivot.joint};
  ligament.normal = normalOf(scene);
  // The ligament is parallel to the difference of the two inward directions: from tile A to tile B
  // across the slit.
  ligament.start = neck.length * across.normalized();
  ligament.pointA = pivot.pointA - 0.5 * ligament.start;
  ligament.pointB = pivot.pointB + 0.5 * ligament.start;
  if (given) {
    ligament.stretchStiffness = given->stretch;
    ligament.shearStiffness = given->shear * given->length * given->length;
  } else {
    brick::setNeckStiffness(neck.youngs, neck.poisson, scene.brick.thickness, neck.width,
                            neck.length, ligament);
  }
  return ligament;
}

/// A neck of length 0 at the end of a closed slit, as an elastic pin.
brick::Ligament pinAt(const brick::Pivot& pivot, const std::vector<brick::Brick>& bricks,
                      const Vector3& slit, const Scene& scene) {
  const HingeNeck material =
      neckAt(scene, scene.model.joints[static_cast<std::size_t>(pivot.joint)]);
  const brick::CornerNeck neck = brick::cornerNeck(material.youngs, scene.brick.thickness,
                                                   material.width, neckCorners(pivot, bricks));
  brick::Ligament pin{pivot.brickA, pivot.brickB, pivot.joint,
                      pivot.pointA, pivot.pointB, Vector3::Zero()};
  pin.normal = normalOf(scene);
  pin.across = slit.cross(pin.normal);
  pin.stretchStiffness = neck.stretch;
  pin.shearStiffness = neck.shear;
  // B turns positively about the normal as the slit opens if B lies on that side of the slit.
  const brick::Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const double sign = inwardAt(brickB, pivot.cornerB).dot(pin.across) < 0 ? 1 : -1;
  pin.opening = {sign * neck.bending * neck.opening[0], neck.bending * neck.opening[1]};
  return pin;
}

/// Adds the model of a neck at a hinge. Under grips a neck of length 0 is always compliant like its
/// tiles. Others are compliant if ligaments are requested.
void addNeck(brick::Pivot pivot, const std::vector<brick::Brick>& bricks, const Scene& scene,
             std::vector<brick::Pivot>& pivots, std::vector<brick::Ligament>& ligaments) {
  if (scene.hinges.ligament) {
    ligaments.push_back(ligamentAt(pivot, bricks, scene));
    return;
  }
  const HingeNeck neck = neckAt(scene, scene.model.joints[static_cast<std::size_t>(pivot.joint)]);
  const std::optional<Vector3> slit = slitAt(pivot, bricks);
  if (slit) {
    // The neck's axis is next to the corner.
    const double axis = brick::neckAxis(neck.width, neck.length, neckCorners(pivot, bricks));
    pivot.pointA += axis * *slit;
    pivot.pointB += axis * *slit;
  }
  if (slit && neck.length == 0) {
    ligaments.push_back(pinAt(pivot, bricks, *slit, scene));
  } else if (scene.hinges.areLigaments) {
    if (neck.length == 0) {
      throw InputError(
          "error: `ligaments` needs necks with a length at open slits, because a neck of length 0 "
          "neither stretches nor shears. Give a length in `hinge_neck` or remove `ligaments`");
    }
    ligaments.push_back(ligamentAt(pivot, bricks, scene));
  } else {
    pivots.push_back(pivot);
  }
}

}  // namespace

const std::vector<PairForceKind>& pairForceKinds() {
  static const std::vector<PairForceKind> kinds = {
      {brick::HingeSprings::kName,
       [](const Scene& scene, const std::vector<brick::Brick>& bricks) {
         return std::shared_ptr<const brick::PairForce>(
             std::make_shared<brick::HingeSprings>(hingeSprings(scene, bricks)));
       },
       brick::HingeSprings::read},
      {brick::Ligaments::kName, nullptr, brick::Ligaments::read}};
  return kinds;
}

namespace {

/// Ties without pivots: only forces, except ligaments.
Ties withoutPivots(const Scene& scene, const std::vector<brick::Brick>& bricks) {
  Ties ties;
  for (const PairForceKind& kind : pairForceKinds()) {
    if (kind.make) ties.pairForces.add(kind.make(scene, bricks));
  }
  return ties;
}

/// Adds pivots and ligaments. A joint is a neck if its two bricks share a hinge with a force. Upper
/// pivots are redundant in the plane and are omitted.
void addJoints(const Scene& scene, const std::vector<brick::Brick>& bricks, Ties& ties) {
  std::set<std::pair<int, int>> hinges;
  for (const std::shared_ptr<const brick::PairForce>& force : ties.pairForces) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      const auto [brickA, brickB] = force->bricks(pair);
      hinges.insert(std::minmax(brickA, brickB));
    }
  }
  std::vector<brick::Ligament> ligaments;
  for (const brick::Pivot& pivot : brick::makePivots(scene.model.joints, bricks)) {
    if (pivot.isUpper) continue;
    const bool isNeck = (scene.hinges.neck || scene.hinges.ligament) &&
                        hinges.contains(std::minmax(pivot.brickA, pivot.brickB));
    if (isNeck) {
      addNeck(pivot, bricks, scene, ties.pivots, ligaments);
    } else {
      ties.pivots.push_back(pivot);
    }
  }
  ties.pairForces.add(std::make_shared<brick::Ligaments>(std::move(ligaments)));
}

}  // namespace

Ties loadedTies(const Scene& scene, const std::vector<brick::Brick>& bricks) {
  Ties ties = withoutPivots(scene, bricks);
  if (!scene.hinges.panels) addJoints(scene, bricks, ties);
  return ties;
}

// Without ligaments all pivots are exact. Upper pivots are included because the scene may be
// spatial.
Ties dynamicTies(const Scene& scene, const std::vector<brick::Brick>& bricks) {
  Ties ties = withoutPivots(scene, bricks);
  if (!scene.hinges.hasLigaments()) {
    ties.pivots = brick::makePivots(scene.model.joints, bricks);
    return ties;
  }
  const char* key = scene.hinges.ligament ? "ligament_stiffness" : "ligaments";
  if (const Need planar = sceneNeeds(scene).planar; !planar.on) {
    const bool isOff = scene.solver.planar.has_value();
    const bool mayBeOn = !isOff && model::sheetFrame(scene.model);
    throw InputError(fmt::format(
        "error: `{}` works only in the plane, but {}. {}", key,
        isOff ? "`planar` is off" : planar.reason,
        mayBeOn ? "Remove one of them, or set `planar` to on: the plane then holds the tiles"
                : "Remove one of them"));
  }
  // --planar on keeps bricks in parallel planes, but does not require coplanar tiles.
  if (!model::sheetFrame(scene.model)) {
    throw InputError(fmt::format(
        "error: `{0}` works only in the plane, but the start is not flat. Remove `{0}`", key));
  }
  addJoints(scene, bricks, ties);
  return ties;
}

Ties tiesOf(const Scene& scene, const std::vector<brick::Brick>& bricks) {
  return scene.grips.empty() ? dynamicTies(scene, bricks) : loadedTies(scene, bricks);
}

}  // namespace kirireel::scene
