/// From what a file says to a model: tiles and joints are checked, mended and found.
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
// Tiles as read from a file, and the checks that they make bricks.

/// Where one tile stands in its file.
struct TileSource {
  int line = 0;              ///< from 1
  std::vector<int> columns;  ///< of each vertex's x, from 1
};

/// The tiles of one file and where they stand.
struct TileTable {
  std::filesystem::path file;       ///< as it was given
  std::vector<Tile> tiles;          ///< in the file's order
  std::vector<TileSource> sources;  ///< one a tile
  int countsFrom = 0;               ///< the file's first tile and vertex, for messages
  std::vector<int> padded;          ///< tiles of which repeated or missing vertices were removed

  /// Where a tile stands.
  FileLocation at(int tile) const { return {file, sources[tile].line}; }
  /// Where a vertex of a tile stands.
  FileLocation at(int tile, int vertex) const {
    return {file, sources[tile].line, sources[tile].columns[vertex]};
  }
  /// "vertices.txt:13", or the file alone where tiles have no lines, for messages that stand in
  /// another file of the same folder.
  std::string shortName(int tile) const;
};

/// A tile whose sides cross or touch: what it looks like says more than a message.
class CrossedTile : public InputError {
 public:
  /// With the message, the tile, and where two of its sides meet.
  CrossedTile(const InputError& error, Tile tile, const Vector3& place)
      : InputError(error), tile_(std::move(tile)), place_(place) {}

  /// As it was read.
  const Tile& tile() const { return tile_; }
  /// Where two of its sides meet, metres.
  const Vector3& place() const { return place_; }

 private:
  Tile tile_;
  Vector3 place_;
};

/// Most vertices of a tile.
inline constexpr std::size_t kMostTileVertices = 300;

/// Throws InputError for the first tile with too many vertices, repeated vertices, without area,
/// or not flat, and CrossedTile for the first whose sides cross or touch.
/// Costs O(n^2) for a tile of n vertices.
void checkTiles(const TileTable& table);

/// Throws InputError when the target has other tiles than the start, or tiles of clearly other
/// shapes. A slight change of shape, which rigid tiles cannot follow, is appended to warnings.
/// `start` holds the model's tiles and `table` where they stand.
void checkTarget(const TileTable& target, const Model& start, const TileTable& table,
                 std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// The digits that a file was written with, found from its numbers alone.
//
// A number of a file that was rounded to 3 decimals has at most 3 of them, and the shortest text
// that reads back as the same double has as many as were written, but for zeros at its end. So the
// place of the last digit shows in the numbers themselves, whatever the format: it is the finest
// place that any of them uses. In a file of so many significant digits, large numbers have fewer
// decimals than small ones; there the last place of the largest numbers counts. Files with 15
// significant digits or more were not rounded.

/// The last place that the coordinates were written with, metres, such as 0.001; 0 where they have
/// all their digits.
double lastPlace(const std::vector<Tile>& tiles);

/// What rounding the coordinates may carry, metres: the last place, or 0 where the numbers are
/// exact as written. They are when all are multiples of a coarser step, as 0.25 (five last places
/// at least), or when the last place is too coarse for tiles of that size to be roundings of
/// anything.
double roundingOf(const std::vector<Tile>& tiles);
/// The same of tiles whose last place is known, metres: corners of a drawing's lines.
double roundingOf(const std::vector<Tile>& tiles, double place);

/// How far apart corners may be that are one, metres: one unit of the last place along each axis,
/// by which two roundings of one point can differ, but never a visible part of a tile; and at least
/// a millionth of the sheet, since designs are solved to finite precision.
double samePlaceTolerance(const std::vector<Tile>& tiles);

/// Points nearer than this part of the sheet's size are one. Largest met in the published pairs: 0.
inline constexpr double kSamePlace = 1e-6;

// ------------------------------------------------------------------------------------------------
// Joints as read from constraints.txt, and the checks that they hold tiles together.

/// One row of constraints.txt.
struct JointRow {
  int line = 0;                  ///< from 1; 0 where the file has no lines
  std::array<int, 5> values{};   ///< tile A, vertex A, tile B, vertex B, from 0; face
  std::array<int, 5> columns{};  ///< where each stands, from 1; 0 for a face that is not written
  JointKind kind = JointKind::Pivot;  ///< what it keeps
  Neck neck;                          ///< unknown where the file has none, in the file's unit
};

/// The rows of one file.
struct JointTable {
  std::filesystem::path file;  ///< as it was given
  std::vector<JointRow> rows;  ///< in the file's order
  int countsFrom = 0;          ///< the file's first tile and vertex
};

/// Gives the row of a joint, from 0, the neck that its file has: width > kerf / 2, length >= kerf,
/// kerf >= 0.
/// Throws InputError at this place for other lengths, a joint that does not exist, and a second
/// neck of one joint.
void setNeck(int joint, const Neck& neck, const FileLocation& location, JointTable& table);

/// Whether all tiles and vertices of the rows are there, after adding `shift` to their numbers.
/// `shift` is added to tile and vertex numbers alike. Costs O(rows).
bool namesWhatIsThere(const JointTable& table, const std::vector<Tile>& tiles, int shift);

/// The joints of the rows. Throws InputError for tiles, vertices or faces that do not exist, and
/// for a tile joined to itself. Messages number as the file does.
std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles);

/// Throws InputError for a joint whose corners are far apart at the start. Gaps that the file's
/// digits do not explain are appended to warnings; those that they do are noted as mends, since
/// the corners are one. `model` holds the tiles and the joints of `table`.
/// Joints further apart than 0.05 of the mean edge are refused; joints of links are not given here,
/// since these stand apart by design.
void checkClosed(const JointTable& table, Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings);

/// How far apart a joint's corners are at the start, metres.
double startGap(const Model& model, const Joint& joint);

// ------------------------------------------------------------------------------------------------
// What readers put right in files that say something odd but clear, and how it is told.

/// How a model is to be read.
struct ReadSettings {
  std::filesystem::path jointsFile;  ///< in place of the model's own list of joints; empty for that
  bool strict = false;               ///< refuse what would be mended
  bool joinCoplanar = false;   ///< of a mesh: faces of one plane that share an edge are a tile
  std::optional<int> frame;    ///< of a FOLD file: this frame only, 0 for its key frame
  std::optional<double> fold;  ///< of a FOLD file: angle of letters without one, as a fraction
                               ///< of 180 degrees, (0, 1]; 1 if absent

  // Of cut patterns.
  std::vector<std::string> cut;     ///< colours, layers and ids of the lines to cut; empty: all
  std::vector<std::string> ignore;  ///< of those to leave out
  double neckWidth = 0;             ///< cuts stop short by at most that, in `unit`; 0: found
  bool areJointsInNecks = false;    ///< in the middle of their necks, not where cuts aim at
  /// Unit of the file's lengths; absent: the unit that the file declares, else `undeclaredUnit`.
  std::optional<LengthUnit> unit;
  LengthUnit undeclaredUnit;  ///< of files that declare none
};

/// "file:line: mended: what was found; what was done".
std::string toString(const Mend& mend);

/// Adds a mend to the model and its line to the warnings.
void noteMend(Mend mend, Model& model, std::vector<std::string>& warnings);

/// Throws InputError for the first mend of the model, which says how to put its file right.
void refuseMends(const Model& model);

/// Drops rows that hold corners on no face that earlier rows do not hold already, in either order
/// of the two ends, and cuts others down to the faces that are new.
/// `model` gets the mend; the joints themselves are still rows of `table`. O(rows log rows).
void dropRepeatedJoints(JointTable& table, Model& model, std::vector<std::string>& warnings);

/// Notes that a file of joints holds nothing, not even a comment: its tiles are loose.
void noteNoJoints(const std::filesystem::path& file, Model& model,
                  std::vector<std::string>& warnings);

/// Notes the padded tiles of a table, if there are any.
void notePadding(const TileTable& table, Model& model, std::vector<std::string>& warnings);

/// Joints whose corners stand apart by what rounding explains, collected to be told as one mend.
class RoundedCorners {
 public:
  /// Of this model, whose corners may be off by the last digits.
  explicit RoundedCorners(const Model& model);

  /// `gap` in metres, at most samePlaceTolerance(); `place` says where the joint is written.
  void add(const Joint& joint, double gap, const std::string& place);

  /// Notes them, if there are any.
  void note(Model& model, std::vector<std::string>& warnings);

 private:
  Mend mend_;
  double lastPlace_;
  double least_;  // that is told: below it a gap is the design's own precision
  double largest_ = 0;
};

/// Where a table names what is not there, but all of it is there when counted from the other of 0
/// and 1, shifts the rows' numbers.
/// Nothing happens where the usual base fits. The model's fileOrder learns the base of its file.
void mendBase(JointTable& table, const TileTable& tiles, Model& model,
              std::vector<std::string>& warnings);

/// Gives all tiles of a flat start the same sense, anticlockwise seen from above: of those that run
/// clockwise the vertices are reversed, in every state, and with them the corners of joints, hull
/// and mends; model.fileOrder notes which. A start that is all clockwise stays as it is when its
/// target leaves the plane, since the joints' faces hang on it; a warning tells. To be called once
/// the model is whole. `table` says where tiles stand.
void turnClockwiseTiles(const TileTable& table, Model& model, std::vector<std::string>& warnings);

// ------------------------------------------------------------------------------------------------
// Joints as shared vertices: what mesh formats have in place of a list of joints.

/// Vertex numbers of each tile's corners, from 0.
using CornerNumbers = std::vector<std::vector<int>>;

/// Joints on the bottom faces between corners with one number, in the order of these numbers: each
/// corner with the next, by tiles.
std::vector<Joint> jointsOfSharedNumbers(const CornerNumbers& numbers);

/// The same between corners of different tiles that coincide in every given state, as far as the
/// digits that they are written with can tell (samePlaceTolerance). All states hold the same tiles;
/// at least one state. Throws InputError that names the file when corners lie that near without
/// being one.
std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states,
                                             const std::filesystem::path& file);

/// Whether any two corners have one number.
bool sharesNumbers(const CornerNumbers& numbers);

/// Vertex numbers of a mesh: its own if faces share any, else one for each group of corners that
/// coincide.
CornerNumbers meshNumbers(const CornerNumbers& numbers,
                          const std::vector<const std::vector<Tile>*>& states,
                          const std::filesystem::path& file);

/// The joints of a mesh: of shared numbers where faces share any, else of coinciding corners.
std::vector<Joint> jointsOfMesh(const CornerNumbers& numbers,
                                const std::vector<const std::vector<Tile>*>& states,
                                const std::filesystem::path& file);

/// Vertex numbers for a mesh of the model: corners that pivots join have one number where their
/// coordinates are equal to the last bit at the start and at all targets. `withTopJoints`: also
/// corners that joints of the top faces hold, whose bottoms part when the tiles turn.
CornerNumbers sharedNumbers(const Model& model, bool withTopJoints = true);

// ------------------------------------------------------------------------------------------------
// Which face of its bricks each joint should lie on, from the shape that the sheet deploys to.

/// How faces are chosen. Both rules look at the target (the start, without one): a joint between
/// tiles that share an edge there is judged by the signed angle of that fold, a joint at a single
/// vertex by whether the normals of its tiles converge, and a sheet that is flat at the start and
/// at the target is joined on both faces.
enum class FaceRule {
  Fold,  ///< a valley (normals converge) is joined at the top, anything else at the bottom, so
         ///< that bricks open away from the fold and do not meet
  PyKirigami,  ///< what --auto_detect_connections assigns: the shared edge runs from the lower to
               ///< the higher vertex number of the first tile, and the joint lies at the top where
               ///< the fold about it is positive
};

/// Replaces the faces of all pivots of the model.
/// Costs O(joints). Links and fixed joints keep what they have. Tiles need to have an area.
void chooseJointFaces(Model& model, FaceRule rule);

}  // namespace kirireel::model
