/// Checks and repairs what a file contains, and finds joints, to make a model of it.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Tiles as read from a file, and the checks that they can become bricks.

/// Position of one tile in its file.
struct TileSource {
  int line = 0;              ///< line number, >= 1
  std::vector<int> columns;  ///< columns of each vertex's x, >= 1
};

/// The tiles of one file with their positions in it.
struct TileTable {
  std::filesystem::path file;       ///< path as given by the user
  std::vector<Tile> tiles;          ///< in the file's order
  std::vector<TileSource> sources;  ///< one per tile
  int countsFrom = 0;               ///< the file's first tile and vertex, for messages
  std::vector<int> padded;          ///< tiles whose repeated or missing vertices were removed

  /// File position of a tile.
  FileLocation at(int tile) const { return {file, sources[tile].line}; }
  /// File position of a vertex of a tile.
  FileLocation at(int tile, int vertex) const {
    return {file, sources[tile].line, sources[tile].columns[vertex]};
  }
  /// "vertices.txt:13", or only the file name if tiles have no lines. For messages about another
  /// file in the same folder.
  std::string shortName(int tile) const;
};

/// Error for a tile whose sides cross or touch. The caller can draw the tile.
class CrossedTile : public InputError {
 public:
  /// `place` is a point where two sides of the tile meet, metres.
  CrossedTile(const InputError& error, Tile tile, const Vector3& place)
      : InputError(error), tile_(std::move(tile)), place_(place) {}

  /// The tile as read.
  const Tile& tile() const { return tile_; }
  /// A point where two sides of the tile meet, metres.
  const Vector3& place() const { return place_; }

 private:
  Tile tile_;
  Vector3 place_;
};

/// Maximum number of vertices of a tile.
inline constexpr std::size_t kMostTileVertices = 300;

/// Throws InputError for the first tile that has too many vertices, repeated vertices or no area,
/// or that is not flat. Throws CrossedTile for the first tile whose sides cross or touch. Costs
/// O(n^2) for a tile of n vertices.
void checkTiles(const TileTable& table);

/// Throws InputError if the target has other tiles than the start, or clearly different shapes.
/// Adds a warning for a slight change of shape, which rigid tiles cannot follow. `start` holds the
/// model's tiles and `table` their file positions.
void checkTarget(const TileTable& target, const Model& start, const TileTable& table,
                 std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// The decimal places of a file's coordinates, found only from its numbers.
//
// A number that was rounded to 3 decimals has at most 3 decimals. The shortest text that reads
// back as the same double has the written digits, except for trailing zeros. The last decimal
// place is therefore the finest place of any number, in every format. With a fixed number of
// significant digits, large numbers have fewer decimals than small ones. The last place of the
// largest numbers counts in that case. Files with 15 or more significant digits were not
// rounded.

/// The last decimal place of the coordinates, metres, such as 0.001. 0 if the coordinates have all
/// their digits.
double lastPlace(const std::vector<Tile>& tiles);

/// Rounding error of the coordinates, metres: the last place, or 0 if the numbers are
/// exact. They are exact if all are multiples of a coarser step such as 0.25 (at least five
/// last places). They are also exact if the last place is too coarse for tiles of that
/// size.
double roundingOf(const std::vector<Tile>& tiles);
/// The same for tiles whose last place is known, metres, such as corners of a drawing's lines.
double roundingOf(const std::vector<Tile>& tiles, double place);

/// Maximum distance of corners that count as one point, metres: one unit of the last place along
/// each axis, since two roundings of one point can differ by that. At most a small fraction of a
/// tile, at least a millionth of the sheet because designs are solved to finite precision.
double samePlaceTolerance(const std::vector<Tile>& tiles);

/// Points nearer than this fraction of the sheet's size are one. Largest in published pairs: 0.
inline constexpr double kSamePlace = 1e-6;

// ------------------------------------------------------------------------------------------------
// Joints as read from constraints.txt, and the checks that they connect tiles.

/// One row of constraints.txt.
struct JointRow {
  int line = 0;                       ///< line number, >= 1; 0 if the file has no lines
  std::array<int, 5> values{};        ///< tile A, vertex A, tile B, vertex B, zero-based; face
  std::array<int, 5> columns{};       ///< column of each, >= 1; 0 for a face that is not written
  JointKind kind = JointKind::Pivot;  ///< what it keeps
  Neck neck;                          ///< in the file's unit; unknown if the file has none
};

/// The rows of one file.
struct JointTable {
  std::filesystem::path file;  ///< path as given by the user
  std::vector<JointRow> rows;  ///< in the file's order
  int countsFrom = 0;          ///< the file's first tile and vertex
};

/// Stores the neck of the file's joint row `joint` (zero-based). Lengths are valid if width > kerf
/// / 2, length >= kerf and kerf >= 0.
/// Throws InputError at this location for other lengths, for a joint that does not exist, and for a
/// second neck of one joint.
void setNeck(int joint, const Neck& neck, const FileLocation& location, JointTable& table);

/// Whether all tiles and vertices of the rows exist after adding `shift` to their numbers.
/// `shift` applies to tile and vertex numbers. Costs O(rows).
bool namesExistingCorners(const JointTable& table, const std::vector<Tile>& tiles, int shift);

/// Makes the joints of the rows. Throws InputError for tiles, vertices or faces that do not exist,
/// and for a tile joined to itself. Messages use the file's own numbers.
std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles);

/// Throws InputError for a pivot whose corners are more than 0.05 of the mean edge apart at
/// the start. Adds warnings for gaps that rounding does not explain. Gaps that rounding
/// explains are noted as repairs, since the corners are one point. `model` holds the tiles
/// and the joints of `table`. Links are not included because their corners are apart by
/// design.
void checkClosed(const JointTable& table, Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings);

/// Distance of a joint's corners at the start, metres.
double startGap(const Model& model, const Joint& joint);

// ------------------------------------------------------------------------------------------------
// Repairs of unusual but unambiguous input, and their messages.

/// Options for reading a model.
struct ReadSettings {
  std::filesystem::path jointsFile;  ///< replaces the model's own list of joints, if not empty
  bool strict = false;               ///< refuse input that needs a repair
  bool joinCoplanar = false;         ///< in meshes: coplanar faces with a common edge form one tile
  std::optional<int> frame;          ///< of a FOLD file: read only this frame, 0 is the key frame
  std::optional<double> fold;  ///< of a FOLD file: fold of letters without an angle, as a fraction
                               ///< of 180 degrees, (0, 1]; absent: 1

  // Options of cut patterns.
  std::vector<std::string> cut;     ///< colours, layers and ids of lines to cut; empty: all
  std::vector<std::string> ignore;  ///< the same of lines to ignore
  double neckWidth = 0;             ///< largest gap at the end of a cut, in `unit`; 0: automatic
  bool areJointsInNecks = false;    ///< joints in the middle of their necks, not at cut ends
  /// Unit of lengths in options and in written files, and of the file's lengths unless the file
  /// declares a unit. Absent: the unit that the file declares, else `undeclaredUnit`.
  std::optional<LengthUnit> unit;
  LengthUnit undeclaredUnit;  ///< of lengths without a declared unit, if `unit` is absent
};

/// "file:line: repaired: what was found; what was done".
std::string toString(const Repair& repair);

/// Adds a repair to the model and its line to the warnings.
void noteRepair(Repair repair, Model& model, std::vector<std::string>& warnings);

/// Throws InputError for the first repair of the model, with advice how to correct the file.
void refuseRepairs(const Model& model);

/// Drops rows that repeat faces of earlier rows at the same corners, in either order of the two
/// ends. Reduces rows with some new faces to these faces. `model` gets the repair. The joints are
/// still rows of `table`. O(rows log rows).
void dropRepeatedJoints(JointTable& table, Model& model, std::vector<std::string>& warnings);

/// Reports that a joints file is empty, without even a comment: its tiles are not connected.
void noteNoJoints(const std::filesystem::path& file, Model& model,
                  std::vector<std::string>& warnings);

/// Reports the padded tiles of a table, if there are any.
void notePadding(const TileTable& table, Model& model, std::vector<std::string>& warnings);

/// Joints whose corners differ only by rounding, collected into one repair.
class RoundedCorners {
 public:
  /// `model`: its corners may be off by the last digits.
  explicit RoundedCorners(const Model& model);

  /// `gap` in metres, at most samePlaceTolerance(). `place`: the joint's position in its file.
  void add(const Joint& joint, double gap, const std::string& place);

  /// Adds one repair for all of them, if there are any.
  void note(Model& model, std::vector<std::string>& warnings);

 private:
  Repair repair_;
  double lastPlace_;
  double least_;  // of reported gaps: smaller gaps come from the design's precision
  double largest_ = 0;
};

/// Shifts the rows' numbers if they fit the tiles only with the other base, of 0 and 1. A table
/// that fits the default base stays unchanged. Updates the model's fileOrder with the base of its
/// file.
void repairBase(JointTable& table, const TileTable& tiles, Model& model,
                std::vector<std::string>& warnings);

/// Makes all tiles of a flat start anticlockwise seen from above. Reverses the vertices of
/// clockwise tiles in every state, and updates corners of joints, hull and repairs. model.fileOrder
/// records which tiles were reversed. An all-clockwise start with a spatial target stays as it is,
/// with a warning, because its joints' faces depend on the orientation. The model must be complete.
/// `table` holds the positions of tiles in the file.
void turnClockwiseTiles(const TileTable& table, Model& model, std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Joints as shared vertices: mesh formats use them in place of a list of joints.

/// Vertex numbers of each tile's corners, zero-based.
using CornerNumbers = std::vector<std::vector<int>>;

/// Joints on the bottom faces between corners with the same number. The order is by number. Each
/// corner is joined to the next one in tile order.
std::vector<Joint> jointsOfSharedNumbers(const CornerNumbers& numbers);

/// Joints between corners of different tiles that coincide in every given state, to the
/// precision of the written digits (samePlaceTolerance). All states hold the same tiles.
/// Requires at least one state. Throws InputError with the file name if corners are that near
/// but are different.
std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states,
                                             const std::filesystem::path& file);

/// Vertex numbers of a mesh. Between tiles that share numbers, directly or through others, the
/// file's own numbers decide. Corners of other tiles get the same number if they coincide in every
/// state: programs write the vertices of each object, or of each face, anew. Throws InputError as
/// jointsOfCoincidingCorners().
CornerNumbers meshNumbers(const CornerNumbers& numbers,
                          const std::vector<const std::vector<Tile>*>& states,
                          const std::filesystem::path& file);

/// Vertex numbers for a mesh of the model. Corners that pivots join share a number if their
/// coordinates are bitwise equal at the start and at all targets. `withTopJoints` includes corners
/// of top joints, whose bottom corners separate when the tiles turn.
CornerNumbers sharedNumbers(const Model& model, bool withTopJoints = true);

// ------------------------------------------------------------------------------------------------
// Selects the face of each joint from the deployed shape of the sheet.

/// Rules for the face of a joint. Both use the target, or the start if there is no target. If two
/// tiles have a common edge there, the signed angle of that fold decides. If they have only a
/// common vertex, it matters whether their normals converge. A sheet that is flat at the start and
/// at the target is joined on both faces.
enum class FaceRule {
  Fold,  ///< a valley (normals converge) is joined at the top, anything else at the bottom; bricks
         ///< then open away from the fold and do not collide
  PyKirigami,  ///< rule of --auto_detect_connections: the common edge points from the lower to the
               ///< higher vertex number of the first tile; the joint is at the top if the fold
               ///< about this direction is positive
};

/// Replaces the faces of all pivots of the model. Links and fixed joints stay unchanged.
/// Costs O(joints). Tiles must have an area.
void chooseJointFaces(Model& model, FaceRule rule);

}  // namespace kirireel::model
