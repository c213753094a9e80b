// [[grip]] entries of a scene file: which parts of a sheet are held, moved or pushed while the load
// grows from 0 to 1.
//
// An entry is read key by key, and what the keys mean together is checked afterwards: tiles are
// given in one of two ways, a point of them in one of two ways or not at all, and the grip either
// moves (metres, degrees) or pushes (newtons, N m). A coordinate that is not named stays free,
// while one that is named as 0 holds still: x, y, z and turn are therefore optional values and not
// zeros. Numbers of tiles and vertices stay those of the model's file until numberAsModel() has the
// model to compare them with.
#include "sim/scene/grip.h"

#include <string>

#include <fmt/format.h>

#include "sim/base/geometry.h"
#include "sim/scene/tile_numbers.h"

namespace kirireel {
namespace {

// A bound against slips of the pen, and against products that overflow; no real load comes near it.
constexpr double kMost = 1e12;  // of any amount
const std::vector<std::string> kGripKeys = {"tile", "tiles", "vertex", "edge", "move", "force"};
const std::vector<std::string> kAmountKeys = {"x", "y", "z", "turn"};

// Metres and degrees, or newtons and N m.
void readAmounts(const TomlEntry& entry, GripSetting& grip) {
  const TomlTable* table = entry.value.table();
  grip.isForce = entry.key == "force";
  if (!table || table->empty()) {
    refuseValue(entry.value, grip.isForce ? "newtons and N m, {x = 1.5, y = 0, turn = 0.1}"
                                          : "metres and degrees, {x = 0.1, y = 0, turn = 5}");
  }
  for (const TomlEntry& amount : *table) {
    const auto read = [&] {
      return requireNumber(amount.value, -kMost, kMost, "a number, at most 1e12 in size");
    };
    if (amount.key == "x") {
      grip.x = read();
    } else if (amount.key == "y") {
      grip.y = read();
    } else if (amount.key == "z") {
      grip.z = read();
    } else if (amount.key == "turn") {
      // A moment is in N m as it stands, a turn is typed in degrees.
      grip.turn = read() * (grip.isForce ? 1 : kDegree);
    } else {
      refuseKey(amount, "key of a grip's " + entry.key, kAmountKeys);
    }
  }
}

// One key; what the keys mean together is checked by readGrip().
void readGripKey(const TomlEntry& entry, GripSetting& grip) {
  if (entry.key == "tile") {
    grip.tiles = {readIndex(entry.value, "a tile number")};
  } else if (entry.key == "tiles") {
    grip.tiles = readIndices(entry.value, "a list of tile numbers, [0, 1]",
                             "a list of tile numbers, [0, 1]");
  } else if (entry.key == "vertex") {
    grip.vertices = {readIndex(entry.value, "a vertex number")};
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

GripSetting readGrip(const TomlValue& value) {
  const TomlTable* table = value.table();
  if (!table) refuseValue(value, "tables, each under [[grip]]");
  GripSetting grip;
  grip.where = value.where;
  for (const TomlEntry& entry : *table) readGripKey(entry, grip);
  // Keys are counted and not only looked for: one of two has to be there, and not both.
  const auto has = [&](const char* key) { return find(*table, key) ? 1 : 0; };
  if (has("tile") + has("tiles") != 1) {
    throw inputErrorAt(value.where, "a grip holds tiles; give one of tile = 3 and tiles = [3, 4]");
  }
  if (has("vertex") + has("edge") > 1) {
    throw inputErrorAt(value.where,
                       "a grip holds a vertex, an edge or the whole tile; leave vertex "
                       "or edge away");
  }
  if (has("move") + has("force") != 1) {
    throw inputErrorAt(value.where,
                       "a grip moves or pushes; give one of move = {x = 0.1} and force "
                       "= {x = 1.5}");
  }
  // A point has no direction that could turn.
  if (grip.turn && !grip.vertices.empty()) {
    throw inputErrorAt(value.where, "points do not turn; leave turn away, or vertex and edge");
  }
  return grip;
}

[[noreturn]] void refuseNumber(const GripSetting& grip, const std::string& whose, int first,
                               int count, int found) {
  throw inputErrorAt(grip.where, fmt::format("{} {}-{}, not {}; correct this grip", whose, first,
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

void numberAsModel(std::vector<GripSetting>& grips, const Model& model) {
  const int first = model.fileOrder.countsFrom;
  const int tiles = static_cast<int>(model.tiles.size());
  for (GripSetting& grip : grips) {
    // Called again, the list would grow.
    grip.corners.clear();
    for (int& tile : grip.tiles) {
      if (tile < first || tile >= first + tiles) {
        refuseNumber(grip, "the model has tiles", first, tiles, tile);
      }
      const Tile& held = model.tiles[static_cast<std::size_t>(tile - first)];
      const int vertices = static_cast<int>(held.vertices.size());
      for (const int vertex : grip.vertices) {
        if (vertex < first || vertex >= first + vertices) {
          refuseNumber(grip, fmt::format("tile {} has vertices", tile), first, vertices, vertex);
        }
        grip.corners.push_back(model.fileOrder.toModel({tile, vertex}, model.tiles));
      }
      // The vertices needed the file's number of the tile; from here on the model's own counts.
      tile -= first;
    }
  }
}

}  // namespace kirireel
