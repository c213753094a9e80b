/// What a model is, before it runs: the page that `kirireel inspect` prints.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "sim/model/drawing.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::report {

/// One state of the sheet.
struct StateInspection {
  double jointGap = 0;         ///< largest, metres
  double unevenness = 0;       ///< largest distance of a vertex from its tile's plane, metres
  double leastCornerSine = 1;  ///< above 0 when all tiles are convex
  std::vector<trajectory::TileOverlap>
      overlaps;              ///< deeper than a millionth of a tile, deepest first
  bool seesAllPairs = true;  ///< false: there are too many pairs, see mostPairs()
  std::optional<trajectory::Mobility> inPlane;  ///< of flat states
  trajectory::Mobility inSpace;                 ///< of the mechanism in space
};

/// The necks of a model's joints, metres.
struct NeckInspection {
  int count = 0;      ///< joints with a neck
  model::Neck least;  ///< the least of each length
  model::Neck most;   ///< the largest of each
};

/// Everything that is told of a model. Tiles in it count from 0; `countsFrom` is what the text
/// adds.
struct Inspection {
  std::string name;                         ///< of the model
  LengthUnit unit;                          ///< of its file; the text has it, JSON is in metres
  std::map<int, int> tilesByVertices;       ///< how many tiles have so many vertices
  std::map<std::string, int> jointsByKind;  ///< "bottom", "top", "both", "link", "fixed"
  NeckInspection necks;                     ///< of those with one
  std::map<std::string, std::vector<int>> tilesByName;  ///< of groups and materials in its file
  double size = 0;                                      ///< diagonal of the start, metres
  double tileSize = 0;                                  ///< mean edge, metres
  double suggestedThickness = 0;                        ///< of bricks, metres: a fiftieth of a tile
  double rounding = 0;             ///< the last digit of its coordinates, metres; 0 for all digits
  double zeroSingularValue = 0;    ///< what counts as zero because of that
  int countsFrom = 0;              ///< the first number of tiles and vertices in its file
  std::vector<std::string> mends;  ///< what was put right in its files, one line each
  StateInspection start;           ///< at the start
  std::optional<StateInspection> target;  ///< at the target, where there is one
  std::optional<double> shapeChange;      ///< largest change of a length in a tile, metres
  std::optional<double> rigidBound;       ///< no rigid tiles come nearer to the target, metres
  std::optional<double> assembledError;   ///< the least found with joints closed, metres
  scene::Needs needs;                     ///< what a run would switch on
};

/// Looks at the scene's model, with its bricks' thickness. `tell`, which may be empty, is called
/// with what is being looked at. `tell` gets a few words, such as "looking at the start". Mobility
/// costs most; beyond a number of unknowns it is not counted.
Inspection inspect(const scene::Scene& scene, const std::function<void(const char*)>& tell = {});

/// The inspection for a person, a line a subject. Several lines.
std::string inspectionText(const Inspection& inspection);

/// The inspection as JSON: {"name", "tiles", "joints", "size", "start": {...}, "target": {...},
/// ...}. With an indent of two spaces, and a line feed at the end. Values that do not exist are
/// null.
std::string inspectionJson(const Inspection& inspection);

// ------------------------------------------------------------------------------------------------
// A picture of a model with the numbers of its tiles and vertices.

/// The model at the start and, where there is one, at the target, side by side: each tile's number
/// in its middle, each vertex's number inside its corner. Throws OutputError when no graphics
/// context can be made or the font is missing.
/// Corners that a reader mended are marked. `stateSize`: pixels of one state's picture.
/// `ignored`: of a drawing, the lines that are not cut. They are laid over its start, and its
/// hinges have dots.
picture::Frame numberedPicture(const scene::Scene& scene, picture::FrameSize stateSize,
                               const std::optional<std::vector<model::DrawnPath>>& ignored = {});

/// A drawing that is no sheet: its lines, and a dot at each place of the fault. Throws OutputError
/// when no graphics context can be made.
picture::Frame faultPicture(const model::DrawingFault& fault, picture::FrameSize size);

/// A polygon that makes no tile: its sides as lines, and where two of them meet as a dot. Throws
/// OutputError when no graphics context can be made. `place`: where two sides cross, metres.
picture::Frame crossingPicture(const model::Tile& tile, const Vector3& place,
                               picture::FrameSize size);

// ------------------------------------------------------------------------------------------------
// Which points of a model the eye sees: numbers are not drawn over tiles that hide their places.

/// Tiles seen from far away in one direction. Tiles have no thickness here.
class LineOfSight {
 public:
  /// towardsEye: unit vector, world axes. The tiles are copied.
  LineOfSight(const std::vector<model::Tile>& tiles, const Vector3& towardsEye);

  /// Whether no other tile stands between the eye and this point of a tile; metres, world axes.
  /// `tile` is the number of the tile that the point belongs to, which never hides it.
  bool isClear(const Vector3& point, std::size_t tile) const;

 private:
  struct Screen {
    std::vector<std::vector<Vector3>> parts;  ///< convex
    Vector3 normal;
    Vector3 middle;
    double radius = 0;  ///< of a ball round the middle that holds the tile, metres
  };

  bool hides(const Screen& screen, const Vector3& point) const;

  std::vector<Screen> screens_;
  Vector3 towardsEye_;
};

}  // namespace kirireel::report
