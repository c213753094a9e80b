// Tile numbers of files. An index is an integer >= 0. Its range depends on the model, whose numbers
// may be zero- or one-based.
#include "sim/scene/conditions.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <fmt/format.h>

namespace kirireel::scene {

int readIndex(const TomlValue& value, const std::string& allowed) {
  const std::int64_t* number = value.whole();
  if (!number || *number < 0 || *number > std::numeric_limits<int>::max()) {
    refuseValue(value, allowed);
  }
  return static_cast<int>(*number);
}

// Refuses an empty list: elsewhere it means all tiles, which would be unexpected here.
std::vector<int> readIndices(const TomlValue& value, const std::string& allowed,
                             const std::string& allowedElement) {
  const std::vector<TomlValue>* array = value.array();
  if (!array || array->empty()) refuseValue(value, allowed);
  std::vector<int> numbers;
  for (const TomlValue& element : *array) numbers.push_back(readIndex(element, allowedElement));
  return numbers;
}

// Throws InputError if the model has no such tile, with the range of its numbers.
int tileOfModel(int number, const model::Model& model, const FileLocation& where) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  if (number >= first && number < end) return number - first;
  throw inputErrorAt(where, fmt::format("the model has tiles {}-{}, not {}. Correct this number",
                                        first, end - 1, number));
}

// ------------------------------------------------------------------------------------------------
// [[grip]] entries of a scene file: parts of a sheet that are held, moved or pushed while the load
// grows from 0 to 1.
//
// An entry is read key by key, and the combination of keys is checked afterwards. There are two
// keys for tiles, and two optional keys for a point of them. The grip either moves (lengths in the
// model's unit, degrees) or pushes (newtons, N m). A missing coordinate is free, while a coordinate
// of 0 is fixed. x, y, z and turn are therefore optional values and not zeros. Numbers of tiles and
// vertices are those of the model's file until numberAsModel() compares them with the model.

namespace {

// A bound against typing errors and overflow of products; real loads are far below it.
constexpr double kMaxAmount = 1e12;  // of any amount
const std::vector<std::string> kGripKeys = {"tile", "tiles", "vertex", "edge", "move", "force"};
const std::vector<std::string> kAmountKeys = {"x", "y", "z", "turn"};

// Lengths in the model's unit and degrees, or newtons and N m.
void readAmounts(const TomlEntry& entry, GripSetting& grip) {
  const TomlTable* table = entry.value.table();
  grip.isForce = entry.key == "force";
  if (!table || table->empty()) {
    refuseValue(entry.value, grip.isForce ? "newtons and N m, {x = 1.5, y = 0, turn = 0.1}"
                                          : "lengths and degrees, {x = 0.1, y = 0, turn = 5}");
  }
  for (const TomlEntry& amount : *table) {
    const auto read = [&] {
      return requireNumber(amount.value, -kMaxAmount, kMaxAmount, "a number, at most 1e12 in size");
    };
    if (amount.key == "x") {
      grip.x = read();
    } else if (amount.key == "y") {
      grip.y = read();
    } else if (amount.key == "z") {
      grip.z = read();
    } else if (amount.key == "turn") {
      // A moment is in N m, a rotation in degrees.
      grip.turn = read() * (grip.isForce ? 1 : kDegree);
    } else {
      refuseKey(amount, "key of a grip's " + entry.key, kAmountKeys);
    }
  }
}

// One key; readGrip() checks the combination of keys.
void readGripKey(const TomlEntry& entry, GripSetting& grip) {
  if (entry.key == "tile") {
    grip.tiles = {readIndex(entry.value, "a tile number")};
  } else if (entry.key == "tiles") {
    grip.tiles = readIndices(entry.value, "a list of tile numbers, [0, 1]",
                             "a list of tile numbers, [0, 1]");
  } else if (entry.key == "vertex") {
    const char* allowed = "a vertex number, or a list with one for each tile, [0, 1]";
    grip.vertices = entry.value.array() ? readIndices(entry.value, allowed, allowed)
                                        : std::vector<int>{readIndex(entry.value, allowed)};
  } else if (entry.key == "edge") {
    grip.vertices =
        readIndices(entry.value, "two vertex numbers, [0, 1]", "two vertex numbers, [0, 1]");
    if (grip.vertices.size() != 2) refuseValue(entry.value, "two vertex numbers, [0, 1]");
  } else if (entry.key == "move" || entry.key == "force") {
    readAmounts(entry, grip);
  } else {
    refuseKey(entry, "key of a grip", kGripKeys);
  }
}

/// Moves vertices that are listed one per tile to the corners, still in the numbers of the file.
void giveEachTileItsVertex(const TomlValue& vertex, GripSetting& grip) {
  if (grip.vertices.size() != grip.tiles.size()) {
    throw inputErrorAt(
        vertex.where,
        fmt::format(
            "a list of vertices needs one entry per tile, {}, not {}. Correct one of the lists",
            grip.tiles.size(), grip.vertices.size()));
  }
  for (std::size_t k = 0; k < grip.tiles.size(); ++k) {
    grip.corners.push_back({grip.tiles[k], grip.vertices[k]});
  }
  grip.vertices.clear();
}

GripSetting readGrip(const TomlValue& value) {
  const TomlTable* table = value.table();
  if (!table) refuseValue(value, "tables, each under [[grip]]");
  GripSetting grip;
  grip.where = value.where;
  for (const TomlEntry& entry : *table) readGripKey(entry, grip);
  // Exactly one of two keys must be given.
  const auto has = [&](const char* key) { return find(*table, key) ? 1 : 0; };
  if (has("tile") + has("tiles") != 1) {
    throw inputErrorAt(value.where, "a grip needs tiles. Set either tile = 3 or tiles = [3, 4]");
  }
  if (has("vertex") + has("edge") > 1) {
    throw inputErrorAt(value.where,
                       "a grip holds a vertex, an edge or the whole tile. Remove vertex or edge");
  }
  if (has("move") + has("force") != 1) {
    throw inputErrorAt(
        value.where,
        "a grip either moves or pushes. Set either move = {x = 0.1} or force = {x = 1.5}");
  }
  // A point has no direction, so it cannot rotate.
  if (grip.turn && !grip.vertices.empty()) {
    throw inputErrorAt(value.where, "points do not rotate. Remove turn, or vertex and edge");
  }
  if (const TomlValue* vertex = find(*table, "vertex"); vertex && vertex->array()) {
    giveEachTileItsVertex(*vertex, grip);
  }
  return grip;
}

[[noreturn]] void refuseNumber(const GripSetting& grip, const std::string& whose, int first,
                               int count, int found) {
  throw inputErrorAt(grip.where, fmt::format("{} {}-{}, not {}. Correct this grip", whose, first,
                                             first + count - 1, found));
}

}  // namespace

std::vector<GripSetting> readGrips(const TomlValue& value) {
  const std::vector<TomlValue>* array = value.array();
  if (!array) refuseValue(value, "tables, each under [[grip]]");
  std::vector<GripSetting> grips;
  for (const TomlValue& element : *array) grips.push_back(readGrip(element));
  return grips;
}

void numberAsModel(std::vector<GripSetting>& grips, const model::Model& model) {
  const int first = model.fileOrder.countsFrom;
  const int tiles = static_cast<int>(model.tiles.size());
  for (GripSetting& grip : grips) {
    const std::vector<model::Corner> listed = std::exchange(grip.corners, {});
    const bool isListed = grip.vertices.empty() && listed.size() == grip.tiles.size();
    for (std::size_t k = 0; k < grip.tiles.size(); ++k) {
      int& tile = grip.tiles[k];
      if (tile < first || tile >= first + tiles) {
        refuseNumber(grip, "the model has tiles", first, tiles, tile);
      }
      const model::Tile& held = model.tiles[static_cast<std::size_t>(tile - first)];
      const int vertices = static_cast<int>(held.vertices.size());
      const std::vector<int> points = isListed ? std::vector<int>{listed[k].vertex} : grip.vertices;
      for (const int vertex : points) {
        if (vertex < first || vertex >= first + vertices) {
          refuseNumber(grip, fmt::format("tile {} has vertices", tile), first, vertices, vertex);
        }
        grip.corners.push_back(model.fileOrder.toModel({tile, vertex}, model.tiles));
      }
      // The vertices needed the file's number of the tile; from here on the model's own number is
      // used.
      tile -= first;
    }
  }
}

// ------------------------------------------------------------------------------------------------
// Surfaces of obstacles as polygons, for pictures, and the floor that is thickened to a box. A
// sphere's polygons have their corners on the sphere and lie within it by up to about 1% of the
// radius. Collisions use the exact sphere (contacts/contact_finder.h).

namespace {

// Bands from pole to pole of the polyhedron for a sphere in pictures; twice as many sectors around
// it.
constexpr int kBands = 16;

// A polygon transformed from an obstacle's axes to world axes.
model::Tile placed(const Pose& pose, model::Tile tile) {
  for (Vector3& vertex : tile.vertices) vertex = pose.apply(vertex);
  return tile;
}

// The corner at the borders of a band (0 is the upper pole, kBands the lower one) and a sector,
// metres.
Vector3 onSphere(const Obstacle& sphere, int band, int sector) {
  const double polar = std::numbers::pi * band / kBands;
  const double around = std::numbers::pi * sector / kBands;
  return sphere.pose.position + sphere.radius * Vector3(std::sin(polar) * std::cos(around),
                                                        std::sin(polar) * std::sin(around),
                                                        std::cos(polar));
}

// Corners are anticlockwise around each face seen from outside: down, along, up, back.
std::vector<model::Tile> sphereFaces(const Obstacle& sphere) {
  std::vector<model::Tile> faces;
  for (int band = 0; band < kBands; ++band) {
    for (int sector = 0; sector < 2 * kBands; ++sector) {
      model::Tile& face = faces.emplace_back();
      face.vertices = {onSphere(sphere, band, sector), onSphere(sphere, band + 1, sector)};
      // At a pole the two corners of a band's border coincide, and one is omitted. Faces at the
      // poles are triangles.
      if (band + 1 < kBands) face.vertices.push_back(onSphere(sphere, band + 1, sector + 1));
      if (band > 0) face.vertices.push_back(onSphere(sphere, band, sector + 1));
    }
  }
  return faces;
}

// Floor and walls of a box in world axes.
std::vector<model::Tile> boxFaces(const Obstacle& box) {
  const model::Tile floor = boxFloor(box, box.size);
  // The brick of the floor is the box, so pictures and contacts have the same faces.
  const brick::Brick brick = brick::makeBrick(floor, {.thickness = box.size.z()});
  std::vector<model::Tile> faces;
  for (std::vector<Vector3>& corners : brick::brickFaces(brick)) {
    faces.push_back(placed({box.pose.position, Quaternion::Identity()}, {std::move(corners)}));
  }
  return faces;
}

}  // namespace

// The lower side of a box of that size, anticlockwise seen from above in the box's own axes. `size`
// may differ from the obstacle's.
model::Tile boxFloor(const Obstacle& obstacle, const Vector3& size) {
  const Vector3 half = 0.5 * size;
  return placed(obstacle.pose, {{{-half.x(), -half.y(), -half.z()},
                                 {half.x(), -half.y(), -half.z()},
                                 {half.x(), half.y(), -half.z()},
                                 {-half.x(), half.y(), -half.z()}}});
}

std::vector<model::Tile> obstacleFaces(const Obstacle& obstacle) {
  switch (obstacle.shape) {
    case Obstacle::Shape::Box:
      return boxFaces(obstacle);
    case Obstacle::Shape::Sphere:
      return sphereFaces(obstacle);
    case Obstacle::Shape::Mesh:
      break;
  }
  std::vector<model::Tile> faces;
  for (const model::Tile& face : obstacle.mesh) faces.push_back(placed(obstacle.pose, face));
  return faces;
}

std::vector<model::Tile> obstacleFaces(const std::vector<Obstacle>& obstacles) {
  std::vector<model::Tile> all;
  for (const Obstacle& obstacle : obstacles) {
    for (model::Tile& face : obstacleFaces(obstacle)) all.push_back(std::move(face));
  }
  return all;
}

// ------------------------------------------------------------------------------------------------
// Initial velocities: a group of tiles starts as one rigid body. With the common centre of mass c
// (m), the velocity v of c (m/s) and the angular velocity w (rad/s), the tile at x has
//   v_x = v + w x (x - c),     w_x = w
// Velocities of several entries for one tile are added. The first projection of the run removes
// components that joints prevent, and conserves momentum.

namespace {

// An empty list means all tiles.
std::vector<int> tilesOf(const InitialVelocity& velocity, std::size_t count) {
  if (!velocity.tiles.empty()) return velocity.tiles;
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace

// Converts the file's numbers to the model's. Throws InputError for a tile that does not exist.
void numberAsModel(std::vector<InitialVelocity>& velocities, const model::Model& model) {
  for (InitialVelocity& velocity : velocities) {
    for (int& tile : velocity.tiles) tile = tileOfModel(tile, model, velocity.where);
  }
}

// Tiles must have the model's numbers. One velocity per brick, zero without an entry.
std::vector<Velocity> initialVelocities(const std::vector<InitialVelocity>& given,
                                        const std::vector<brick::Brick>& bricks,
                                        const Poses& poses) {
  std::vector<Velocity> velocities(bricks.size());
  for (const InitialVelocity& velocity : given) {
    const std::vector<int> tiles = tilesOf(velocity, bricks.size());
    double mass = 0;
    Vector3 centre = Vector3::Zero();
    for (const int tile : tiles) {
      mass += bricks[tile].mass;
      centre += bricks[tile].mass * poses[tile].position;
    }
    // Masses are positive, and a group has at least one tile.
    centre /= mass;
    for (const int tile : tiles) {
      const Vector3 arm = poses[tile].position - centre;
      velocities[tile].linear += velocity.linear + velocity.angular.cross(arm);
      velocities[tile].angular += velocity.angular;
    }
  }
  return velocities;
}

// ------------------------------------------------------------------------------------------------
// Checks a timeline against its model with the numbers of the model's file, then converts these to
// the model's own. The order matters: messages of checks need the file's numbers, all later code
// the model's.

namespace {

void requireTiles(const std::vector<int>& tiles, const model::Model& model,
                  const FileLocation& where) {
  for (const int tile : tiles) tileOfModel(tile, model, where);
}

// The tile must have been checked before, since its vertices are counted here.
void requireVertex(const timeline::Drag& drag, const model::Model& model,
                   const FileLocation& where) {
  // The centre of mass of any brick can be dragged.
  if (!drag.vertex) return;
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles[drag.tile - first].vertices.size());
  if (*drag.vertex >= first && *drag.vertex < end) return;
  throw inputErrorAt(where, fmt::format("tile {} has vertices {}-{}, not {}. Correct this number",
                                        drag.tile, first, end - 1, *drag.vertex));
}

// Only these three actions refer to tiles.
void check(const TimelineEntry& entry, const model::Model& model) {
  if (const auto* pin = std::get_if<timeline::Pin>(&entry.action)) {
    requireTiles(pin->tiles, model, entry.where);
  } else if (const auto* unpin = std::get_if<timeline::Unpin>(&entry.action)) {
    requireTiles(unpin->tiles, model, entry.where);
  } else if (const auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
    tileOfModel(drag->tile, model, entry.where);
    requireVertex(*drag, model, entry.where);
  }
}

// Whether an entry waits for the model's target or selects it.
bool needsTarget(const TimelineEntry& entry) {
  const Trigger::Kind kind = entry.when.kind;
  const auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
  return kind == Trigger::Kind::AtTarget || kind == Trigger::Kind::ErrorBelow ||
         kind == Trigger::Kind::ProgressAbove || (goTo && goTo->file.empty());
}

}  // namespace

std::string actionName(const timeline::Action& action) {
  static const std::array<const char*, std::variant_size_v<timeline::Action>> kNames = {
      "pin", "unpin", "drag", "forces", "pause", "target", "snapshot", "export", "reset", "quit"};
  // In the order of timeline::Action.
  return kNames[action.index()];
}

// Throws InputError for the first invalid entry. Entries are checked in order, because one may set
// the target for a later one.
void checkTimeline(const Timeline& timeline, const model::Model& model) {
  bool hasTarget = model.target.has_value();
  for (const TimelineEntry& entry : timeline) {
    check(entry, model);
    if (needsTarget(entry) && !hasTarget) {
      throw inputErrorAt(entry.where,
                         "this entry needs a target, but there is none. Add target.txt to the "
                         "model or set `target`");
    }
    // After this entry there is a target to wait for.
    hasTarget = hasTarget || std::holds_alternative<timeline::GoTo>(entry.action);
  }
}

// Call it once, after checkTimeline(): a second call would start from the wrong numbers.
void numberAsModel(Timeline& timeline, const model::Model& model) {
  const int first = model.fileOrder.countsFrom;
  for (TimelineEntry& entry : timeline) {
    if (auto* pin = std::get_if<timeline::Pin>(&entry.action)) {
      for (int& tile : pin->tiles) tile -= first;
    } else if (auto* unpin = std::get_if<timeline::Unpin>(&entry.action)) {
      for (int& tile : unpin->tiles) tile -= first;
    } else if (auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
      const model::Corner corner =
          model.fileOrder.toModel({drag->tile, drag->vertex.value_or(first)}, model.tiles);
      drag->tile = corner.tile;
      // In a reversed tile, the file's vertex has another number in the model.
      if (drag->vertex) drag->vertex = corner.vertex;
    }
  }
}

}  // namespace kirireel::scene
