/// States as flat sheets: tiles without thickness, cut patterns, and the outline of a sheet in
/// one piece with its necks.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/model/model.h"

namespace kirireel::writers {

// ------------------------------------------------------------------------------------------------
// The start of a planar model in its own plane, and the gaps next to its joints.

/// A place in the sheet's plane, metres.
using Vector2 = Eigen::Vector2d;

/// A gap narrower than this counts as closed, radians.
inline constexpr double kClosedAngle = 1e-6;

/// A tile seen from the side that it faces: anticlockwise.
using FlatTile = std::vector<Vector2>;

/// A planar start. A point of the plane is at turn^-1 (x, y, height) in the world.
struct FlatSheet {
  std::vector<FlatTile> tiles;               ///< in the model's order
  Quaternion turn = Quaternion::Identity();  ///< from the world to the plane's axes
  double height = 0;                         ///< of the plane above the turned origin, metres
};

/// Throws InputError for a start that is not flat or has tiles on both faces. Vertices keep their
/// order and number.
FlatSheet flatSheet(const model::Model& model);

/// Throws InputError for a joint, of this number in messages, that does not hold two corners
/// together.
void requirePivot(const model::Joint& joint, std::size_t number);

/// The end of an edge of a tile: edge k runs from vertex k to the next.
struct EdgeEnd {
  int tile = 0;          ///< its number, from 0
  int edge = 0;          ///< its number, from 0
  bool atStart = false;  ///< the end is that at vertex k

  auto operator<=>(const EdgeEnd&) const = default;
};

/// The gap between two tiles at a corner that they share, anticlockwise from the first's edge to
/// the second's.
struct CornerGap {
  EdgeEnd first;     ///< the end of the edge that arrives at the corner
  EdgeEnd second;    ///< the start of the edge that leaves it
  double angle = 0;  ///< radians, 0 when closed
};

/// The narrower of the two gaps between the tiles of a pivot. The first where both are equal.
CornerGap narrowGap(const std::vector<FlatTile>& tiles, const model::Joint& joint);

/// The direction from the given end into its edge. A unit vector.
Vector2 directionFrom(const std::vector<FlatTile>& tiles, const EdgeEnd& end);

// ------------------------------------------------------------------------------------------------
// What to cut out of a flat sheet to make a planar model.

/// Kinds of lines, which cutters tell apart by layer.
enum class PatternLayer {
  Cuts,    ///< edges of one tile: outline and holes
  Slits,   ///< edges that two tiles share, once
  Hinges,  ///< material that stays: from a joint to the end of the cut next to it; not to be cut
};

/// A straight line in the sheet's plane, metres, seen from the side that the tiles face. Straight
/// from end to end; lines of one layer may touch but do not overlap.
struct PatternLine {
  PatternLayer layer = PatternLayer::Cuts;  ///< what is done along it
  Eigen::Vector2d from;                     ///< where it begins
  Eigen::Vector2d to;                       ///< where it ends
};

/// The lines of the model's start. Around each joint a neck of material stays: the narrower gap
/// between its two tiles ends the hinge width (metres, positive) before the joint: the sheet stays
/// in one piece. Without a width it is that of each joint's neck, else a twentieth of the tile
/// size. Edges are shared if they coincide as a whole, within 1e-4 of the tile size.
///
/// Throws InputError for a start that is not flat or has tiles on both faces, joints that are not
/// hinges at a corner, and a width at which an edge would not be cut at all. Hinges first, then
/// edges in the order of tiles. Costs a lookup an edge.
std::vector<PatternLine> cutPattern(const model::Model& model, std::optional<double> hingeWidth);

/// The lines as an SVG in millimetres at true size, a group a layer. A margin of 5 mm stays around
/// the pattern. Digits read back to the same doubles.
std::string patternSvg(const std::vector<PatternLine>& lines);

/// The lines as a DXF (R12) in a unit, a layer a kind. Colours of layers: cuts red (1), slits blue
/// (5), hinges green (3).
std::string patternDxf(const std::vector<PatternLine>& lines,
                       const LengthUnit& unit = millimetre());

// ------------------------------------------------------------------------------------------------
// States as sheets of flat tiles, without thickness.

/// The bottoms of all bricks as an OBJ of polygons, as PyKirigami exports it: "# n vertices m
/// faces", one face a tile in the model's order, no vertex shared, no groups. Coordinates read back
/// to the same doubles.
std::string planarObjText(const std::vector<model::Tile>& tiles);

// ------------------------------------------------------------------------------------------------
// The outline of a sheet as it is cut: tiles in one piece with the necks of material at their
// joints, slits open by the kerf.
//
//       F    |   | S        A neck of width w and length l lies across the narrower gap between
//            |   |          two tiles F and S, as near to their joint as the tiles' corners let a
//       _____|   |_____     strip of that width lie, the gap's bisector being up. Where a tile
//      |               |    reaches into the strip's length, a slot of the neck's length and of a
//      |____ neck _____|    neck's depth is cut from it: the neck is a beam of length l.
//        (joint below)      Without length and kerf the neck is what the slit leaves: the line, or
//                           the triangle across an open gap, between the joint and the slit's end.

/// The material that stays between two tiles. Lengths in metres. A width, length or kerf of 0 is
/// that of each joint's neck in the model (model::Neck), if it has one.
struct NeckShape {
  double width = 0;   ///< of the neck, positive
  double length = 0;  ///< from tile to tile; less than the kerf counts as the kerf
  double radius = 0;  ///< of the fillets where the neck meets its tiles; at most half the length
  double kerf = 0;    ///< what the cutter takes away: tiles lose half of it along each edge
};

/// The shape of the neck at a joint: what the shape leaves open is the model's. The length is at
/// least the kerf.
NeckShape shapeAt(const model::Joint& joint, const NeckShape& shape);

/// The regions of a sheet. Regions that share a line share its two points; a shut slit has points
/// of its own on either side.
struct NeckOutline {
  FlatSheet sheet;                      ///< as it was drawn
  std::vector<Vector2> points;          ///< in the sheet's plane, metres
  std::vector<bool> isAtNeck;           ///< for each point
  std::vector<std::vector<int>> tiles;  ///< each tile's points, anticlockwise
  std::vector<std::vector<int>> necks;  ///< the same for the necks that have an area
  std::vector<int> neckJoints;          ///< the joint of each of these
  double neckWidth = 0;                 ///< of the narrowest neck, metres
};

/// The outline of a model's start with necks of this shape.
///
/// Throws InputError for starts that are not flat, joints that are not pivots, lengths that are not
/// positive or contradict each other, necks that are too wide, too short or too long for their
/// tiles (each with the length that would do), and necks with a length at corners of two joints.
/// Points of tiles come in the order of tiles; necks in that of joints.
NeckOutline neckOutline(const model::Model& model, const NeckShape& shape);

}  // namespace kirireel::writers
