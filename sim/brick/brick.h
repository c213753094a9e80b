/// Bricks: tiles thickened into rigid prisms.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/convex_parts.h"
#include "sim/model/model.h"

namespace kirireel::brick {

/// Rule for the mass of a brick.
enum class MassRule {
  Unit,   ///< mass 1 for any size, as in the paper's models
  Prism,  ///< density times volume
};

/// Default thickness as a fraction of a model's mean edge: the paper's value for tiles of 1 m.
inline constexpr double kDefaultThickness = 0.02;

/// Rule for making bricks from tiles.
struct BrickRule {
  double thickness = 0.02;         ///< metres, positive; the paper's default
  MassRule mass = MassRule::Unit;  ///< the inertia is always the true prism's, scaled to the mass
  double density = 1000;           ///< kg/m^3, used by MassRule::Prism

  static constexpr auto fields() {
    return describeFields<BrickRule>(field("thickness", &BrickRule::thickness, "m"),
                                     field("mass", &BrickRule::mass),
                                     field("density", &BrickRule::density, "kg/m^3"));
  }
};

/// A rigid prism, in brick axes: origin at its centre of mass, axes parallel to the world's at the
/// start. bottom[k] and top[k] are the tile's vertex k and that vertex moved along the normal.
struct Brick {
  std::vector<Vector3> bottom;        ///< n points, anticlockwise seen from the normal
  std::vector<Vector3> top;           ///< n points
  Vector3 normal = Vector3::UnitZ();  ///< of the bottom, unit, towards the top
  double thickness = 0;               ///< metres
  double volume = 0;                  ///< cubic metres
  double mass = 0;                    ///< kg
  Matrix3 inertia = Matrix3::Zero();  ///< about the centre of mass, kg m^2
  /// Convex parts of a concave brick, as corner numbers of its bottom (see convex_parts.h). Empty
  /// if the brick is convex.
  std::vector<model::PolygonPart> parts;

  static constexpr auto fields() {
    return describeFields<Brick>(
        field("bottom", &Brick::bottom, "m"), field("top", &Brick::top, "m"),
        field("normal", &Brick::normal), field("thickness", &Brick::thickness, "m"),
        field("volume", &Brick::volume, "m^3"), field("mass", &Brick::mass, "kg"),
        field("inertia", &Brick::inertia, "kg m^2"), field("parts", &Brick::parts));
  }
};

/// The convex parts of a bottom for Brick::parts.
std::vector<model::PolygonPart> partsOfBottom(const std::vector<Vector3>& bottom,
                                              const Vector3& normal);

/// A convex piece of a brick, as a brick of its own shape. Its axes, normal, thickness, mass and
/// inertia are those of the whole brick.
struct BrickPiece {
  Brick shape;                 ///< only the piece, in the brick's own axes
  int brick = 0;               ///< the brick that it belongs to
  int part = 0;                ///< which of that brick's parts
  model::PolygonPart corners;  ///< its corners' numbers in the whole brick
};

/// The convex pieces of all bricks, brick by brick. One piece for each convex brick. Shapes are
/// copied.
std::vector<BrickPiece> convexPieces(const std::vector<Brick>& bricks);

/// The pieces of one brick.
std::vector<BrickPiece> convexPieces(const Brick& brick, int number = 0);

/// Thickens a tile: its bottom is the tile, its top lies on the side of the normal. The tile must
/// be simple and have an area. A concave tile also costs the search for convex parts.
Brick makeBrick(const model::Tile& tile, const BrickRule& rule);

/// The bricks of all tiles, in order.
std::vector<Brick> makeBricks(const std::vector<model::Tile>& tiles, const BrickRule& rule);

/// The poses at which the bricks' bottoms are their original tiles; rotations are identity.
Poses startPoses(const std::vector<model::Tile>& tiles, const std::vector<Brick>& bricks);

/// The faces of a brick as outward polygons in brick axes: bottom, top, then side k between
/// vertices k and k + 1.
std::vector<std::vector<Vector3>> brickFaces(const Brick& brick);

/// The bottom tiles of all bricks at the given poses, in world axes.
std::vector<model::Tile> bottomTiles(const std::vector<Brick>& bricks, const Poses& poses);

/// Corner number of a pivot that does not connect two corners, for links and fixed joints.
inline constexpr int kNoCorner = -1;

/// A common point of two bricks. A joint on both faces has two pivots, which form a hinge. A fixed
/// joint has three pivots.
struct Pivot {
  int brickA = 0;             ///< number, zero-based
  int brickB = 0;             ///< number, zero-based, or kFixed
  Vector3 pointA;             ///< in the axes of brick A
  Vector3 pointB;             ///< in the axes of brick B
  int joint = 0;              ///< index into the model's joints
  double distance = 0;        ///< constraint of the points' distance, metres; > 0 only for links
  bool isUpper = false;       ///< second pivot of a hinge, redundant in a planar scene
  int cornerA = kNoCorner;    ///< vertex of brick A's tile if the bricks share a corner
  int cornerB = kNoCorner;    ///< the same for brick B's tile
  bool isWithinTile = false;  ///< see Joint

  /// Whether the two points coincide. Otherwise pivotRows() has what the pivot keeps.
  bool joinsPoints() const { return distance == 0; }
  /// Number of constraints, [1, 3], in the plane [1, 2].
  int rowCount(bool isPlanar) const { return joinsPoints() ? (isPlanar ? 2 : 3) : 1; }
};

/// The constraints of a pivot, as its first rowCount() rows. A row keeps the positions of the two
/// points along one direction.
struct PivotRows {
  Matrix3 axes = Matrix3::Identity();  ///< the unit direction of each row, world axes
  Vector3 gaps = Vector3::Zero();      ///< violation of each row, metres
};

/// The constraints if the point of brick A is `apart` from the point of brick B, world axes.
PivotRows pivotRows(const Pivot& pivot, const Vector3& apart);
/// Violation of all constraints together, metres, >= 0.
double pivotGap(const Pivot& pivot, const Vector3& apart);
/// The same at these poses.
double pivotGap(const Pivot& pivot, const Poses& poses);

/// The pivots of all joints, in joint order, bottom before top. A pivot joint has one or two
/// pivots, a link one, a fixed joint three. The joints' corners must exist.
std::vector<Pivot> makePivots(const std::vector<model::Joint>& joints,
                              const std::vector<Brick>& bricks);

/// The mean edge of a brick's tile, metres.
double meanEdge(const Brick& brick);

}  // namespace kirireel::brick
