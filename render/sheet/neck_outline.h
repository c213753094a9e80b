/// The outline of a sheet as it is cut: tiles in one piece with the necks of material at their
/// joints, slits open by the kerf.
///
///       F    |   | S        A neck of width w and length l stands across the narrower gap between
///            |   |          two tiles F and S, as near to their joint as the tiles' corners let a
///       _____|   |_____     strip of that width lie, the gap's bisector being up. Where a tile
///      |               |    reaches into the strip's length, a slot of the neck's length and of a
///      |____ neck _____|    neck's depth is cut from it, so that the neck is a beam of length l.
///        (joint below)      Without length and kerf the neck is what the slit leaves: the line, or
///                           the triangle across an open gap, between the joint and the slit's end.
#pragma once

#include <vector>

#include "render/sheet/flat_sheet.h"

namespace kirireel {

/// The material that stays between two tiles. Lengths in metres.
struct NeckShape {
  double width = 0;   ///< of the neck, positive
  double length = 0;  ///< from tile to tile; less than the kerf counts as the kerf
  double radius = 0;  ///< of the fillets where the neck meets its tiles; at most half the length
  double kerf = 0;    ///< what the cutter takes away: tiles lose half of it along each edge
};

/// The regions of a sheet. Regions that share a line share its two points; a shut slit has points
/// of its own on either side.
struct NeckOutline {
  FlatSheet sheet;
  std::vector<Vector2> points;          ///< in the sheet's plane, metres
  std::vector<bool> isAtNeck;           ///< for each point
  std::vector<std::vector<int>> tiles;  ///< each tile's points, anticlockwise
  std::vector<std::vector<int>> necks;  ///< likewise of the necks that have an area
  double neckWidth = 0;                 ///< metres
};

/// The outline of a model's start with necks of this shape.
///
/// Throws InputError for starts that are not flat, joints that are not pivots, lengths that are not
/// positive or contradict each other, necks that are too wide, too short or too long for their
/// tiles (each with the length that would do), and necks with a length at corners of two joints.
/// Points of tiles come in the order of tiles; necks in that of joints.
NeckOutline neckOutline(const Model& model, const NeckShape& shape);

}  // namespace kirireel
