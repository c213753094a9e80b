/// Sheets in their plane: tiles without thickness, cut patterns, and the outline of a sheet in one
/// piece with its necks.
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

/// A position in the sheet's plane, metres.
using Vector2 = Eigen::Vector2d;

/// A gap with a smaller angle counts as closed, radians.
inline constexpr double kClosedAngle = 1e-6;

/// A tile seen from its upper side: anticlockwise.
using FlatTile = std::vector<Vector2>;

/// A planar start. The point (x, y) of the plane is turn^-1 (x, y, height) in the world.
struct FlatSheet {
  std::vector<FlatTile> tiles;               ///< in the model's order
  Quaternion turn = Quaternion::Identity();  ///< from the world to the plane's axes
  double height = 0;                         ///< of the plane above the turned origin, metres
};

/// The sheet of a planar start, with unchanged order and number of vertices. Throws InputError for
/// a start that is not flat or has tiles with opposite orientations.
FlatSheet flatSheet(const model::Model& model);

/// Throws InputError for a joint that does not connect two corners. `number` is its number in
/// messages.
void requirePivot(const model::Joint& joint, std::size_t number);

/// The end of an edge of a tile: edge k goes from vertex k to the next.
struct EdgeEnd {
  int tile = 0;          ///< zero-based
  int edge = 0;          ///< zero-based
  bool atStart = false;  ///< the end at vertex k

  auto operator<=>(const EdgeEnd&) const = default;
};

/// The gap between two tiles at a common corner, anticlockwise from the first tile's edge to the
/// second's.
struct CornerGap {
  EdgeEnd first;     ///< end of the edge that arrives at the corner
  EdgeEnd second;    ///< start of the edge that leaves the corner
  double angle = 0;  ///< radians, 0 if closed
};

/// The narrower of the two gaps between the tiles of a pivot. The first one if both are equal.
CornerGap narrowGap(const std::vector<FlatTile>& tiles, const model::Joint& joint);

/// The direction from the given end into its edge. A unit vector.
Vector2 directionFrom(const std::vector<FlatTile>& tiles, const EdgeEnd& end);

// ------------------------------------------------------------------------------------------------
// Cut lines that make a planar model from a flat sheet.

/// Kinds of lines, on separate layers for cutters.
enum class PatternLayer {
  Cuts,    ///< edges of one tile: outline and holes
  Slits,   ///< edges shared by two tiles, drawn once
  Hinges,  ///< remaining material, from a joint to the end of the cut next to it; not to be cut
};

/// A straight line in the sheet's plane, metres, seen from the upper side of the tiles. Lines of
/// one layer may touch but do not overlap.
struct PatternLine {
  PatternLayer layer = PatternLayer::Cuts;  ///< kind
  Eigen::Vector2d from;                     ///< start
  Eigen::Vector2d to;                       ///< end
};

/// The lines of the model's start. Around each joint a neck of material remains: the edges of the
/// narrower gap between its two tiles end the hinge width (metres, > 0) before the joint, which
/// keeps the sheet in one piece. The default is the width of each joint's neck, else a twentieth
/// of the tile size. Edges are shared if they coincide completely, within 1e-4 of the tile size.
///
/// Throws InputError for a start that is not flat or has tiles with opposite orientations, for
/// joints that are not hinges at a corner, and for a width that leaves nothing of an edge. Hinges
/// come first, then edges in the order of tiles. Costs a lookup per edge.
std::vector<PatternLine> cutPattern(const model::Model& model, std::optional<double> hingeWidth);

/// The lines as an SVG in millimetres at true size, with one group per layer and a margin of 5 mm
/// around the pattern. Digits read back as the same doubles.
std::string patternSvg(const std::vector<PatternLine>& lines);

/// The lines as a DXF (R12) in a unit, with one layer per kind. Colours of layers: cuts red (1),
/// slits blue (5), hinges green (3).
std::string patternDxf(const std::vector<PatternLine>& lines,
                       const LengthUnit& unit = millimetre());

// ------------------------------------------------------------------------------------------------
// States as sheets of flat tiles without thickness.

/// The bottoms of all bricks as an OBJ of polygons, in PyKirigami's format: "# n vertices m faces",
/// one face per tile in the model's order, no shared vertices, no groups. Coordinates read back as
/// the same doubles.
std::string planarObjText(const std::vector<model::Tile>& tiles);

// ------------------------------------------------------------------------------------------------
// The outline of a sheet as it is cut: tiles in one piece with the necks of material at their
// joints, with slits as wide as the kerf.
//
//       F    |   | S        A neck of width w and length l lies across the narrower gap between
//            |   |          two tiles F and S, as near to their joint as the tiles' corners let a
//       _____|   |_____     strip of that width lie, the gap's bisector being up. Where a tile
//      |               |    reaches into the strip's length, a slot of the neck's length and of a
//      |____ neck _____|    neck's depth is cut from it: the neck is a beam of length l.
//        (joint below)      Without length and kerf the neck is what the slit leaves: the line, or
//                           the triangle across an open gap, between the joint and the slit's end.

/// The remaining material between two tiles. Lengths in metres. A width of 0 or a negative length
/// or kerf means the value of each joint's neck in the model (model::Neck).
struct NeckShape {
  double width = 0;    ///< of the neck, > 0
  double length = -1;  ///< from tile to tile, at least the kerf
  double radius = 0;   ///< of the fillets between the neck and its tiles; at most half the length
  double kerf = -1;    ///< width removed by the cutter: tiles lose half of it along each edge
};

/// The shape of the neck at a joint. Missing values are those of the model, or 0 if it has none. A
/// missing length is the kerf if it is the kerf in the model. The length is at least the kerf.
NeckShape shapeAt(const model::Joint& joint, const NeckShape& shape);

/// The regions of a sheet. Regions with a common line share its two points. A closed slit has
/// separate points on both sides.
struct NeckOutline {
  FlatSheet sheet;                      ///< the original sheet
  std::vector<Vector2> points;          ///< in the sheet's plane, metres
  std::vector<bool> isAtNeck;           ///< for each point
  std::vector<std::vector<int>> tiles;  ///< points of each tile, anticlockwise
  std::vector<std::vector<int>> edges;  ///< for each tile the first points of its edges' lines, as
                                        ///< places in `tiles`
  std::vector<std::vector<int>> necks;  ///< the same for necks with a non-zero area
  std::vector<int> neckJoints;          ///< joint of each of these necks
  double neckWidth = 0;                 ///< of the narrowest neck, metres
};

/// The outline of a model's start with necks of this shape.
///
/// Throws InputError for starts that are not flat, joints that are not pivots, lengths that are not
/// positive or contradict each other, and necks with a length at corners of two joints. Also for
/// necks that are too wide, short or long for their tiles, with a length that fits. Points of tiles
/// are in the order of tiles, necks in that of joints.
NeckOutline neckOutline(const model::Model& model, const NeckShape& shape);

}  // namespace kirireel::writers
