/// The geometric model of a kirigami sheet, without any physics.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"

namespace kirireel::model {

/// Maximum number of vertices of a tile.
inline constexpr std::size_t kMaxTileVertices = 300;

/// A planar polygon whose sides do not cross, convex or not: one line of vertices.txt.
struct Tile {
  std::vector<Vector3> vertices;  ///< at least 3, metres, anticlockwise seen from the tile's normal

  static constexpr auto fields() {
    return describeFields<Tile>(field("vertices", &Tile::vertices, "m"));
  }
};

/// The face of its two bricks that a joint lies on; values as in column 5 of constraints.txt. Both
/// faces at one corner make a hinge along the corner's edge through the thickness.
enum class JointFace { Bottom = 1, Top = 2, Both = 3 };

/// One corner of one tile.
struct Corner {
  int tile = 0;    ///< zero-based
  int vertex = 0;  ///< zero-based, within the tile

  bool operator==(const Corner&) const = default;

  static constexpr auto fields() {
    return describeFields<Corner>(field("tile", &Corner::tile), field("vertex", &Corner::vertex));
  }
};

/// Kind of a joint. Files have its number, messages its name in kJointKinds.
enum class JointKind {
  Pivot,  ///< the two corners coincide
  Link,   ///< the distance between the two corners stays as at the start, on the bottom faces
  Fixed,  ///< the relative position and rotation of the two tiles stay as at the start
};

/// The names of all kinds, by their numbers.
inline constexpr std::array<const char*, 3> kJointKinds = {"pivot", "link", "fixed"};

/// The material at a joint of a cut sheet: a neck next to the end of a cut.
struct Neck {
  double width = 0;   ///< its material plus half the kerf, metres, > kerf / 2; 0: unknown
  double length = 0;  ///< from tile to tile across the cut, metres, >= kerf
  double kerf = 0;    ///< width of the cuts, metres, >= 0

  bool operator==(const Neck&) const = default;

  /// Whether the neck is known.
  explicit operator bool() const { return width > 0; }

  static constexpr auto fields() {
    return describeFields<Neck>(field("width", &Neck::width, "m"),
                                field("length", &Neck::length, "m"),
                                field("kerf", &Neck::kerf, "m"));
  }
};

/// A connection of two corners or two tiles. A pivot is one row of constraints.txt.
struct Joint {
  Corner a;                            ///< corner of the first tile
  Corner b;                            ///< corner of the second tile
  JointFace face = JointFace::Bottom;  ///< face of a pivot
  JointKind kind = JointKind::Pivot;   ///< which constraint the joint imposes
  Vector3 apart = Vector3::Zero();     ///< from corner b to corner a at the start, metres, only for
                                       ///< links and fixed joints; not zero for links
  /// Whether both are parts of one tile that bends between them. Such parts never collide.
  bool isWithinTile = false;
  Neck neck;  ///< of a pivot; unknown unless a drawing or a file has it

  static constexpr auto fields() {
    return describeFields<Joint>(
        field("a", &Joint::a), field("b", &Joint::b), field("face", &Joint::face),
        field("kind", &Joint::kind), field("apart", &Joint::apart, "m"),
        field("is_within_tile", &Joint::isWithinTile), field("neck", &Joint::neck));
  }
};

/// A repair that a reader made to a file with one obvious meaning.
struct Repair {
  std::string place;            ///< "file:line" of the first case
  std::string found;            ///< what the reader found and how often
  std::string done;             ///< what the reader did with it
  std::string advice;           ///< how the user can correct the file
  std::vector<Corner> corners;  ///< affected corners, with the model's numbers
};

/// How the model's file numbers and orders its tiles and vertices.
struct FileOrder {
  int countsFrom = 0;            ///< the number of its first tile and first vertex
  std::vector<bool> isReversed;  ///< per tile, whether the file lists its vertices in the opposite
                                 ///< order; empty: no tile

  /// Converts a corner of the model to the file's vertex order, or back; zero-based in both. Uses
  /// the vertex count of the corner's tile in `tiles`. The corner must exist.
  Corner across(const Corner& corner, const std::vector<Tile>& tiles) const;
  /// The model's corner for a corner with the file's numbers.
  Corner toModel(const Corner& numbered, const std::vector<Tile>& tiles) const;
};

/// An edge of a sheet, as FOLD describes it.
struct Crease {
  int from = 0;                     ///< vertex number
  int to = 0;                       ///< vertex number
  char assignment = 'U';            ///< one of B M V F U C J
  std::optional<double> foldAngle;  ///< degrees, [-180, 180]; absent if the file has none
  /// The same in each target that the file gives by angles. Absent in those that it gives by
  /// coordinates, and in later ones.
  std::vector<std::optional<double>> targetAngles;
};

/// Whether a character is one of the letters of edges: B M V F U C J.
constexpr bool isFoldLetter(int letter) {
  return std::string_view("BMVFUCJ").find(static_cast<char>(letter)) != std::string_view::npos;
}

/// The vertices, edges and faces of a FOLD file, with the file's numbers. Tiles are its faces
/// without slits. Faces with a common J edge form one tile.
struct FoldSheet {
  std::vector<Vector3> vertices;           ///< at the start, metres
  std::vector<Crease> creases;             ///< empty if the file lists no edges
  bool hasLetters = false;                 ///< the file has edges_assignment
  bool hasAngles = false;                  ///< the file has edges_foldAngle
  bool isFolded = false;                   ///< its frame_classes contain foldedForm
  bool givesTarget = false;                ///< its angles or letters give the first target
  std::vector<std::vector<int>> faces;     ///< vertex numbers around each face
  std::vector<int> tileOf;                 ///< tile of each face
  std::vector<std::vector<int>> outlines;  ///< vertex numbers around each tile, in the file's order
  std::map<std::string, std::string> texts;  ///< titles, author and descriptions, by their key
};

/// A kirigami sheet: its tiles in the compact state, its joints and its target.
struct Model {
  std::string name;                             ///< name of the folder or the generator's family
  std::vector<Tile> tiles;                      ///< at the start
  std::vector<Joint> joints;                    ///< in file order
  std::optional<std::vector<Tile>> target;      ///< target positions, vertex by vertex as in tiles
  std::vector<std::vector<Tile>> waypoints;     ///< states to reach before the target, in order
  std::optional<std::vector<int>> pulledTiles;  ///< tiles with target forces; absent: all tiles
  /// Fold angles in the file, per pair of tiles with a common edge, radians, [-pi, pi], 0 is flat.
  /// A positive angle is a valley: the tiles turn towards the upper side of the first tile. Fold
  /// springs have this rest angle. The map stores each fold for both orders of the pair. Folds
  /// without an angle in the file are absent.
  std::map<std::pair<int, int>, double> foldAngles;
  std::vector<std::string> tileNames;       ///< one per tile; empty if the file has no names
  std::optional<FoldSheet> drawing;         ///< of its FOLD file
  bool areCoplanarJoined = false;           ///< the reader joined coplanar faces
  std::optional<std::vector<Corner>> hull;  ///< corners around the outline, in order
  std::string hullFault;                    ///< why the reader ignored a hull; empty if it did not
  FileOrder fileOrder;                      ///< numbering and order in the file
  /// How closely corners fit, metres: the last decimal place of rounded coordinates, or the misfit
  /// of corners with all their digits. 0: exactly.
  double rounding = 0;
  std::vector<Repair> repairs;  ///< repairs by the reader
  /// Unit of lengths in options and in files for other programs: the user's unit, the file's
  /// declared unit, or metres. All lengths above are in metres.
  LengthUnit unit;
  std::optional<LengthUnit> declaredUnit;  ///< the unit that the file declares, if any
};

/// Joints with gaps below this fraction of a tile are closed. Tiles with such misfits fit exactly.
inline constexpr double kClosedShare = 1e-10;

/// Largest misfit of the corners or joints of tiles that count as fitting, in tiles.
inline constexpr double kMaxMisfit = 1e-4;

/// Multiplies all lengths of the model by a factor > 0.
void scaleLengths(Model& model, double factor);

/// The tiles with lengths in a unit, for files.
std::vector<Tile> inUnit(std::vector<Tile> tiles, const LengthUnit& unit);

/// The model with lengths in a unit, for files. The unit becomes the model's unit.
Model inUnit(Model model, const LengthUnit& unit);

/// The model with the vertices of each tile in its file's order.
Model inFileOrder(Model model);
/// The same for tiles in any state.
std::vector<Tile> inFileOrder(std::vector<Tile> tiles, const FileOrder& order);

/// A rigid connection of two different tiles at their current positions. Its corners are the first
/// corner of each tile. `apart` is the current vector between them.
Joint makeFixedJoint(const std::vector<Tile>& tiles, int tileA, int tileB);

/// A link between two different corners of different tiles. Two corners at the same point would
/// give a link of zero length without a direction. The caller excludes them.
Joint makeLink(const std::vector<Tile>& tiles, const Corner& a, const Corner& b);

/// The pivot as a joint of this kind between the same tiles at their current positions.
Joint toKind(JointKind kind, const Joint& pivot, const std::vector<Tile>& tiles);

/// The name of a joint's kind, one of kJointKinds.
const char* kindName(const Joint& joint);

/// The unit normal of a tile by Newell's method. A brick is its tile thickened along this normal.
/// Undefined for a tile without area. Works for concave tiles and for slightly non-planar tiles.
Vector3 tileNormal(const Tile& tile);

/// Area of a tile, square metres, >= 0. Works for concave tiles.
double tileArea(const Tile& tile);

/// The centroid of a tile's area. It can lie outside a concave tile. Undefined for a tile without
/// area.
Vector3 tileCentroid(const Tile& tile);

/// Diagonal of the bounding box of the start state, metres. Relative tolerances refer to this
/// length. 0 for a model without tiles. The cost is linear in the number of vertices.
double modelSize(const Model& model);

/// The bounding box of all vertices, metres; empty without tiles.
Eigen::AlignedBox3d boxOf(const std::vector<Tile>& tiles);

/// Mean edge length over all tiles, metres. Messages call this length the tile size. 0 for a model
/// without tiles.
double tileSize(const Model& model);

/// The largest distance between the two corners of a pivot, metres; 0 if there are none. Links and
/// fixed joints do not count.
double largestJointGap(const std::vector<Joint>& joints, const std::vector<Tile>& tiles);

/// Text of a length such as "0.0121 mm (0.012 tiles)", for messages. The first number is in the
/// model's unit with `digits` significant digits.
std::string lengthInTiles(double metres, const Model& model, int digits = 2);

/// The zero-based piece number of each tile, in the order of the first tiles. A piece is a set of
/// tiles that joints of any kind connect. Costs about O(tiles + joints).
std::vector<int> piecesOf(const Model& model);

/// Number of tiles that are turned over in a second state: their normals differ by more than 90
/// degrees. Both states have the same tiles.
int countTurnedOver(const std::vector<Tile>& start, const std::vector<Tile>& target);

/// Whether all vertices have the same height, to the tolerance in metres. The height of the first
/// vertex is the reference. Requires at least one tile.
bool liesFlat(const std::vector<Tile>& tiles, double tolerance);

}  // namespace kirireel::model
