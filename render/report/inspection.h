/// Inspection of a model before a run: the report of `kirireel inspect`.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "sim/formats/drawing.h"
#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::report {

/// One state of the sheet.
struct StateInspection {
  double jointGap = 0;            ///< largest gap, metres
  double unevenness = 0;          ///< largest distance of a vertex from its tile's plane, metres
  double smallestCornerSine = 1;  ///< > 0 if all tiles are convex
  std::vector<trajectory::TileOverlap>
      overlaps;              ///< deeper than a millionth of a tile, deepest first
  bool seesAllPairs = true;  ///< false: too many pairs, see maxPairs()
  std::optional<trajectory::Mobility> inPlane;  ///< of flat states
  trajectory::Mobility inSpace;                 ///< of the mechanism in space
};

/// The necks of a model's joints, metres.
struct NeckInspection {
  int count = 0;      ///< joints with a neck
  model::Neck least;  ///< the smallest of each length
  model::Neck most;   ///< the largest of each
};

/// All results for a model. Tiles in it are zero-based; the text adds `countsFrom` to their
/// numbers.
struct Inspection {
  std::string name;                         ///< of the model
  LengthUnit unit;                          ///< of its file; used in the text, JSON is in metres
  std::map<int, int> tilesByVertices;       ///< number of tiles by their number of vertices
  std::map<std::string, int> jointsByKind;  ///< "bottom", "top", "both", "link", "fixed"
  std::vector<int> pieces;                  ///< number of tiles of each piece, see piecesOf()
  NeckInspection necks;                     ///< of joints with a neck
  std::map<std::string, std::vector<int>> tilesByName;  ///< of groups and materials in its file
  double size = 0;                                      ///< diagonal of the start, metres
  double tileSize = 0;                                  ///< mean edge, metres
  double suggestedThickness = 0;                        ///< of bricks, metres: a fiftieth of a tile
  double rounding = 0;                    ///< last digit of its coordinates, metres; 0: all digits
  double zeroSingularValue = 0;           ///< threshold for zero because of that
  int countsFrom = 0;                     ///< number of the first tile and vertex in its file
  std::vector<std::string> repairs;       ///< repairs of its files, one line each
  StateInspection start;                  ///< at the start
  std::optional<StateInspection> target;  ///< at the target, if any
  std::optional<double> shapeChange;      ///< largest change of a length in a tile, metres
  std::optional<double> rigidBound;       ///< lower bound of the error of rigid tiles, metres
  std::optional<double> assembledError;   ///< smallest error found with closed joints, metres
  scene::Needs needs;                     ///< features that a run would use
};

/// Inspects the scene's model with its bricks' thickness. `progress`, which may be empty, is called
/// with a short text about the current step, such as "checking the start". Mobility is the most
/// expensive step. It is skipped for too many unknowns.
Inspection inspect(const scene::Scene& scene,
                   const std::function<void(const char*)>& progress = {});

/// "planar on (the sheet stays flat)".
std::string needText(const char* name, const scene::Need& need);

/// The inspection as text of several lines, one per subject.
std::string inspectionText(const Inspection& inspection);

/// The inspection as JSON: {"name", "tiles", "joints", "size", "start": {...}, "target": {...},
/// ...}. It is indented by two spaces and ends in a line feed. Missing values are null.
std::string inspectionJson(const Inspection& inspection);

// ------------------------------------------------------------------------------------------------
// Pictures of a model with the numbers of its tiles and vertices.

/// The model at the start and, if it has one, at the target, side by side. Each tile's number is in
/// its middle, each vertex's number inside its corner. Corners that a reader repaired are marked.
/// Throws OutputError if there is no graphics context or font. `stateSize`: pixels of one state's
/// picture. `ignored`: lines of a drawing that are not cut. They are drawn over the start, and its
/// hinges have dots.
picture::Frame numberedPicture(const scene::Scene& scene, picture::FrameSize stateSize,
                               const std::optional<std::vector<formats::DrawnPath>>& ignored = {});

/// A drawing that is not a sheet: its lines, and a dot at each fault. Throws OutputError if there
/// is no graphics context.
picture::Frame faultPicture(const formats::DrawingFault& fault, picture::FrameSize size);

/// A polygon that cannot be a tile: its sides as lines, and a dot at `place`, metres, where two of
/// them cross. Throws OutputError if there is no graphics context.
picture::Frame crossingPicture(const model::Tile& tile, const Vector3& place,
                               picture::FrameSize size);

// ------------------------------------------------------------------------------------------------
// Visibility of points of a model: numbers are not drawn on hidden positions.

/// Tiles seen from an infinitely distant eye. Tiles have no thickness here.
class LineOfSight {
 public:
  /// towardsEye: unit vector, world axes. The tiles are copied.
  LineOfSight(const std::vector<model::Tile>& tiles, const Vector3& towardsEye);

  /// Whether no other tile is between the eye and this point of a tile; metres, world axes. `tile`
  /// is the number of the point's own tile, which never hides it.
  bool isVisible(const Vector3& point, std::size_t tile) const;

 private:
  struct Screen {
    std::vector<std::vector<Vector3>> parts;  ///< convex
    Vector3 normal;
    Vector3 middle;
    double radius = 0;  ///< of a ball around the middle that contains the tile, metres
  };

  bool hides(const Screen& screen, const Vector3& point) const;

  std::vector<Screen> screens_;
  Vector3 towardsEye_;
};

}  // namespace kirireel::report
