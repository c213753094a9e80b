/// Concave tiles: sheets whose tiles have bent sides that fit into each other.
///
/// A sheet of tiles of two kinds that turn against each other moves by its joints alone: what lies
/// between two joined corners of a tile may have any shape. Bulges on the sides of one kind, and
/// the same outline as bays in the other, keep the closed sheet closed. While two tiles turn about
/// one end of their common side, a point at (x, y) of the bulge (x along the side from the joint, y
/// out of it) leaves the bay at once where the wall there has a normal n with n . (-y, x) >= 0:
/// walls that lean towards the joint by more than y / x. Whether the tiles of a state overlap all
/// the same is for the generator to check.
#pragma once

#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// A corner that is put into each side.
struct SidePoint {
  double along = 0.5;  ///< where, as a part of the side, from 0 to 1, rising
  double out = 0;      ///< how far outwards on tiles that bulge, as a part of the side's length
};

/// The sheet with these points in each side of each tile: outwards where `bulges` says so of the
/// tile, else inwards. The points are the same from either end of a side. Joints stay at their
/// corners.
Model withBentSides(const Model& model, const std::vector<bool>& bulges,
                    const std::vector<SidePoint>& points);

}  // namespace kirireel
