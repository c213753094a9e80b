/// Bricks: tiles thickened into rigid prisms.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/convex_parts.h"
#include "sim/model/model.h"

namespace kirireel::model {

/// How a brick gets its mass.
enum class MassRule {
  Unit,   ///< mass 1 whatever the size, as the paper's models have
  Prism,  ///< density times volume
};

/// The thickness that suits a model, as a part of its mean edge: the paper's for tiles of 1 m.
inline constexpr double kDefaultThickness = 0.02;

/// How tiles become bricks.
struct BrickRule {
  double thickness = 0.02;         ///< metres, positive; the paper's default
  MassRule mass = MassRule::Unit;  ///< the inertia is always the true prism's, scaled to the mass
  double density = 1000;           ///< kg/m^3, used by MassRule::Prism

  /// For files; see base/fields.h.
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
  /// The convex parts of a concave brick, as corner numbers of its bottom (see convex_parts.h);
  /// none: the brick is convex.
  std::vector<PolygonPart> parts;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Brick>(
        field("bottom", &Brick::bottom, "m"), field("top", &Brick::top, "m"),
        field("normal", &Brick::normal), field("thickness", &Brick::thickness, "m"),
        field("volume", &Brick::volume, "m^3"), field("mass", &Brick::mass, "kg"),
        field("inertia", &Brick::inertia, "kg m^2"), field("parts", &Brick::parts));
  }
};

/// The convex parts of a bottom for Brick::parts.
std::vector<PolygonPart> partsOfBottom(const std::vector<Vector3>& bottom, const Vector3& normal);

/// A convex piece of a brick as a brick of its own shape: axes, normal and thickness are the whole
/// brick's, mass and inertia too, which no piece has alone.
struct BrickPiece {
  Brick shape;          ///< the piece alone, in the brick's own axes
  int brick = 0;        ///< that it belongs to
  int part = 0;         ///< which of that brick's parts
  PolygonPart corners;  ///< its corners' numbers in the whole brick
};

/// The convex pieces of all bricks, brick by brick: as many as bricks where all are convex.
/// Shapes are copied.
std::vector<BrickPiece> convexPieces(const std::vector<Brick>& bricks);

/// The same of one brick.
std::vector<BrickPiece> convexPieces(const Brick& brick, int number = 0);

/// Thickens a tile: its bottom is the tile, its top lies on the normal's side.
/// The tile has an area and is simple. Costs the search for convex parts where it is concave.
Brick makeBrick(const Tile& tile, const BrickRule& rule);

/// The bricks of all tiles, in order.
std::vector<Brick> makeBricks(const std::vector<Tile>& tiles, const BrickRule& rule);

/// The poses at which the bricks' bottoms are the tiles they were made from: rotations identity.
Poses startPoses(const std::vector<Tile>& tiles, const std::vector<Brick>& bricks);

/// The faces of a brick as outward polygons in brick axes: bottom, top, then side k between
/// vertices k and k + 1.
std::vector<std::vector<Vector3>> brickFaces(const Brick& brick);

/// The bottom tiles of all bricks at the given poses, in world axes.
std::vector<Tile> bottomTiles(const std::vector<Brick>& bricks, const Poses& poses);

/// The corner of a pivot where bricks are linked or fixed, not pivoted at a corner of each.
inline constexpr int kNoCorner = -1;

/// A point that two bricks share. A joint on both faces has two pivots, hence a hinge; a fixed
/// joint has three.
struct Pivot {
  int brickA = 0;        ///< its number, from 0
  int brickB = 0;        ///< its number, from 0, or kFixed
  Vector3 pointA;        ///< in the axes of brick A
  Vector3 pointB;        ///< in the axes of brick B
  int joint = 0;         ///< index into the model's joints
  double distance = 0;   ///< that the two points keep, metres; above 0 for links alone
  bool isUpper = false;  ///< the second pivot of a hinge, which says nothing new in a planar scene
  int cornerA = kNoCorner;    ///< vertex of brick A's tile, where pivoted bricks share a corner
  int cornerB = kNoCorner;    ///< vertex of brick B's tile, likewise
  bool isWithinTile = false;  ///< see Joint
};

/// By how much a pivot's two points miss what it asks of them, metres, from 0.
double pivotGap(const Pivot& pivot, const Poses& poses);

/// The pivots of all joints: in joint order, bottom before top.
/// Corners of the joints have to exist. A pivot joint has one or two, a link one, a fixed joint
/// three.
std::vector<Pivot> makePivots(const std::vector<Joint>& joints, const std::vector<Brick>& bricks);

/// The mean edge of a brick's tile, metres.
double meanEdge(const Brick& brick);

}  // namespace kirireel::model
