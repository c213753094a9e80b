/// The model: what a kirigami sheet is, before any physics.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"

namespace kirireel::model {

/// A planar polygon whose sides do not cross, convex or not: one line of vertices.txt.
struct Tile {
  std::vector<Vector3> vertices;  ///< at least 3, metres, anticlockwise seen from the tile's normal

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Tile>(field("vertices", &Tile::vertices, "m"));
  }
};

/// The face of its two bricks that a joint lies on; values as in column 5 of constraints.txt.
/// Both faces at one corner make a hinge along the corner's edge through the thickness.
enum class JointFace { Bottom = 1, Top = 2, Both = 3 };

/// One corner of one tile.
struct Corner {
  int tile = 0;    ///< from 0
  int vertex = 0;  ///< from 0, within the tile

  bool operator==(const Corner&) const = default;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Corner>(field("tile", &Corner::tile), field("vertex", &Corner::vertex));
  }
};

/// What a joint holds.
enum class JointKind {
  Pivot,  ///< the two corners coincide
  Link,   ///< the two corners keep the distance that they start with, on the bottom faces
  Fixed,  ///< the two tiles keep the placement to each other that they start with
};

/// The material that stays at a joint of a sheet that is cut: a neck beside the end of a cut.
struct Neck {
  double width = 0;   ///< from the end of the cut to the joint, metres, > kerf / 2; 0: unknown
  double length = 0;  ///< from tile to tile across the cut, metres, >= kerf
  double kerf = 0;    ///< width of the cuts, metres, >= 0

  bool operator==(const Neck&) const = default;

  /// Whether the neck is known.
  explicit operator bool() const { return width > 0; }

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Neck>(field("width", &Neck::width, "m"),
                                field("length", &Neck::length, "m"),
                                field("kerf", &Neck::kerf, "m"));
  }
};

/// Two corners that stay together: one row of constraints.txt; or two tiles tied in another way.
struct Joint {
  Corner a;                            ///< of the one tile
  Corner b;                            ///< of the other
  JointFace face = JointFace::Bottom;  ///< of a pivot
  JointKind kind = JointKind::Pivot;   ///< what it keeps
  Vector3 apart = Vector3::Zero();  ///< from corner b to corner a at the start, of links and fixed
                                    ///< joints, metres; a link's has a length
  /// Whether the two are parts of one tile that bends between them: they never touch.
  bool isWithinTile = false;
  Neck neck;  ///< of a pivot; unknown unless a drawing or a file has it

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Joint>(
        field("a", &Joint::a), field("b", &Joint::b), field("face", &Joint::face),
        field("kind", &Joint::kind), field("apart", &Joint::apart, "m"),
        field("is_within_tile", &Joint::isWithinTile), field("neck", &Joint::neck));
  }
};

/// Something that a reader put right in a file, so that the model is what was meant.
struct Mend {
  std::string place;            ///< "file:line" of the first case
  std::string found;            ///< what and how many
  std::string done;             ///< what became of them
  std::string advice;           ///< how to put the file right by hand
  std::vector<Corner> corners;  ///< where, in the model's numbers
};

/// How the file that a model comes from counts and orders what the model has in its own order.
struct FileOrder {
  int countsFrom = 0;            ///< its first tile and first vertex
  std::vector<bool> isReversed;  ///< of each tile, whether the file has its vertices the other way
                                 ///< round, last first; none where empty

  /// A corner of the model as the file numbers it but from 0, and back: `tile` has that many
  /// vertices.
  /// Both have to be corners that exist.
  Corner across(const Corner& corner, const std::vector<Tile>& tiles) const;
  /// The corner of the model that the file numbers so.
  Corner toModel(const Corner& numbered, const std::vector<Tile>& tiles) const;
};

/// An edge of a sheet, as FOLD describes it.
struct Crease {
  int from = 0;                     ///< vertex number
  int to = 0;                       ///< vertex number
  char assignment = 'U';            ///< one of B M V F U C J
  std::optional<double> foldAngle;  ///< degrees, -180 to 180; none if the file has none
};

/// The vertices, edges and faces that a FOLD file has, in its own numbers. Tiles are its faces
/// without slits, and faces that J edges join are one tile.
struct FoldSheet {
  std::vector<Vector3> vertices;           ///< at the start, metres
  std::vector<Crease> creases;             ///< none if the file lists no edges
  bool hasLetters = false;                 ///< the file has edges_assignment
  bool hasAngles = false;                  ///< the file has edges_foldAngle
  bool isFolded = false;                   ///< its frame_classes have foldedForm
  bool givesTarget = false;                ///< the target is the sheet folded by letters only
  std::vector<std::vector<int>> faces;     ///< vertex numbers round each face
  std::vector<int> tileOf;                 ///< of each face
  std::vector<std::vector<int>> outlines;  ///< vertex numbers round each tile, in the file's order
};

/// A kirigami sheet: its tiles in the compact state, its joints, and where it should go.
struct Model {
  std::string name;                             ///< of the folder or the generator's family
  std::vector<Tile> tiles;                      ///< at the start
  std::vector<Joint> joints;                    ///< in file order
  std::optional<std::vector<Tile>> target;      ///< wanted positions, vertex by vertex as in tiles
  std::vector<std::vector<Tile>> waypoints;     ///< states to reach before the target, in order
  std::optional<std::vector<int>> pulledTiles;  ///< tiles that feel target forces; all if absent
  /// By how much its file folds the edge that two tiles share, radians from -pi to pi, 0 flat:
  /// above 0 where they turn towards the upper side of the first of the two, a valley. Springs of
  /// folds rest there. Each fold is in it both ways round; those that the file says nothing of are
  /// not.
  std::map<std::pair<int, int>, double> foldAngles;
  std::vector<std::string> tileNames;       ///< of each tile; empty if its file has no names
  std::optional<FoldSheet> drawing;         ///< of its FOLD file
  bool areCoplanarJoined = false;           ///< its reader joined faces of one plane
  std::optional<std::vector<Corner>> hull;  ///< the corners round the outside, in order
  std::string hullFault;                    ///< why a hull that is there was left out, if so
  FileOrder fileOrder;                      ///< how its file counts and orders
  double rounding = 0;      ///< the last digit that coordinates were rounded to, metres; 0 for none
  std::vector<Mend> mends;  ///< what its reader put right
  /// Unit of the lengths in its file: given by the user, declared by the file, or metres. Lengths
  /// above are metres in any case. Files for other programs are written in this unit.
  LengthUnit unit;
  std::optional<LengthUnit> declaredUnit;  ///< the unit that the file declares, if it does
};

/// Multiplies all lengths of the model by a factor > 0.
void scaleLengths(Model& model, double factor);

/// The tiles in a unit, for files.
std::vector<Tile> inUnit(std::vector<Tile> tiles, const LengthUnit& unit);

/// The model with its lengths in a unit, which becomes its unit, for files.
Model inUnit(Model model, const LengthUnit& unit);

/// The model, or tiles of it in any state, with the vertices of each tile in its file's order.
Model inFileOrder(Model model);
/// The same for tiles in any state.
std::vector<Tile> inFileOrder(std::vector<Tile> tiles, const FileOrder& order);

/// A rigid connection of two different tiles as they stand.
/// Its corners are the first of both tiles, and `apart` is the vector between them as they stand.
Joint makeFixedJoint(const std::vector<Tile>& tiles, int tileA, int tileB);

/// A link between two corners of different tiles that stand apart.
/// Corners that coincide would give a link without a length, which holds no direction: the caller
/// excludes them.
Joint makeLink(const std::vector<Tile>& tiles, const Corner& a, const Corner& b);

/// The unit normal of a tile by Newell's method: the direction in which its brick is thickened.
/// Not defined for a tile without area. Works for concave tiles, and for tiles that are not quite
/// flat.
Vector3 tileNormal(const Tile& tile);

/// Area of a tile, square metres.
/// Of concave tiles too; never negative.
double tileArea(const Tile& tile);

/// The centroid of a tile's area.
/// Also of a concave tile, which may not hold it. Not defined for a tile without area.
Vector3 tileCentroid(const Tile& tile);

/// Diagonal of the bounding box of the start state, metres: the length that relative tolerances
/// refer to.
/// 0 for a model without tiles. Costs a look at every vertex.
double modelSize(const Model& model);

/// Mean edge length over all tiles, metres: the length that "tile size" means.
/// 0 for a model without tiles.
double tileSize(const Model& model);

/// "0.0121 mm (0.012 tiles)": a length in metres for messages, in the unit of the model with this
/// many significant digits, and in tiles.
std::string lengthInTiles(double metres, const Model& model, int digits = 2);

/// The number of each tile's piece, from 0 in the order of the first tiles. A piece is a set of
/// tiles that joints connect, of any kind. Costs about O(tiles + joints).
std::vector<int> piecesOf(const Model& model);

/// How many tiles face the other way in a second state: their normals are more than 90 degrees
/// apart. Both states have the same tiles.
int countTurnedOver(const std::vector<Tile>& start, const std::vector<Tile>& target);

/// Whether all vertices lie at one height, to the tolerance in metres.
/// The height of the first vertex is the reference. At least one tile.
bool liesFlat(const std::vector<Tile>& tiles, double tolerance);

// ------------------------------------------------------------------------------------------------
// The outside of a sheet.

/// One corner for each vertex on the convex outline of all vertices, seen along z: anticlockwise
/// from the leftmost (the lowest of these). Of corners at one point the first counts.
/// Heights do not matter. At least one tile; costs O(n log n) for n vertices.
std::vector<Corner> outlineCorners(const std::vector<Tile>& tiles);

}  // namespace kirireel::model
