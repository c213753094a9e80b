/// What a model is, before it runs: the page that `kirireel inspect` prints.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sim/measure/mobility.h"
#include "sim/measure/sheet.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// One state of the sheet.
struct StateInspection {
  double jointGap = 0;         ///< largest, metres
  double unevenness = 0;       ///< largest distance of a vertex from its tile's plane, metres
  double leastCornerSine = 1;  ///< above 0 when all tiles are convex
  std::vector<TileOverlap> overlaps;  ///< deeper than a millionth of a tile, deepest first
  bool seesAllPairs = true;           ///< false: there are too many pairs, see mostPairs()
  std::optional<Mobility> inPlane;    ///< of flat states
  Mobility inSpace;
};

/// Everything that is told of a model. Tiles in it count from 0; `countsFrom` is what the text
/// adds.
struct Inspection {
  std::string name;
  std::map<int, int> tilesByVertices;       ///< how many tiles have so many vertices
  std::map<std::string, int> jointsByKind;  ///< "bottom", "top", "both", "link", "fixed"
  double size = 0;                          ///< diagonal of the start, metres
  double tileSize = 0;                      ///< mean edge, metres
  double suggestedThickness = 0;            ///< of bricks, metres: a fiftieth of a tile
  double rounding = 0;             ///< the last digit of its coordinates, metres; 0 for all digits
  double zeroSingularValue = 0;    ///< what counts as zero because of that
  int countsFrom = 0;              ///< the first number of tiles and vertices in its file
  std::vector<std::string> mends;  ///< what was put right in its files, one line each
  StateInspection start;
  std::optional<StateInspection> target;
  std::optional<double> shapeChange;     ///< largest change of a length in a tile, metres
  std::optional<double> rigidBound;      ///< no rigid tiles come nearer to the target, metres
  std::optional<double> assembledError;  ///< the least found with joints closed, metres
  Needs needs;                           ///< what a run would switch on
};

/// Looks at the scene's model, with its bricks' thickness. `tell`, which may be empty, is called
/// with what is being looked at. `tell` gets a few words, such as "looking at the start". Mobility
/// costs most; beyond a number of unknowns it is not counted.
Inspection inspect(const Scene& scene, const std::function<void(const char*)>& tell = {});

/// The inspection for a person, a line a subject. Several lines.
std::string inspectionText(const Inspection& inspection);

/// The inspection as JSON: {"name", "tiles", "joints", "size", "start": {...}, "target": {...},
/// ...}. With an indent of two spaces, and a line feed at the end. Values that do not exist are
/// null.
std::string inspectionJson(const Inspection& inspection);

}  // namespace kirireel
