/// Periods of a sheet in its plane, and the corners that joints connect across its border.
#pragma once

#include <array>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"

namespace kirireel::fea {

/// A joint across the border of a cell: corner a coincides with corner b in another cell.
struct BorderJoint {
  model::Joint joint;  ///< corners a and b, both of tiles of the cell; face: that of the same joint
                       ///< inside the cell
  std::array<int, 2> cell{};  ///< of b's tile: displacement in periods; not both 0
};

/// A sheet as one cell of an infinite sheet.
struct SheetLattice {
  std::array<Vector3, 2> periods;      ///< from a cell to its neighbours, metres
  Matrix3 axes = Matrix3::Identity();  ///< columns: x, y and z of the sheet in the world
  std::array<double, 2> lengths{};     ///< a rectangle of the cell's area, along x and y
  std::vector<BorderJoint> joints;     ///< each once
};

/// Finds the infinite sheet that has these tiles and joints as a cell: the translations that map
/// the sheet to itself, and the joints that the border cuts. If the pattern does not repeat inside
/// the cell, its straight ends must match edge by edge, and pairs of coinciding corners are joined.
/// The x axis is parallel or perpendicular to a translation, and the same for all cells of an
/// infinite sheet. Tiles and corners are zero-based, in messages they count from `countsFrom`.
///
/// Throws InputError if the border is not periodic, with the edge at which it fails, or if the
/// corners to join are ambiguous. Lengths agree to 1e-5 of the sheet's size. Cost: the number of
/// translations between tiles times the number of tiles.
SheetLattice findSheetLattice(const std::vector<std::vector<Vector3>>& tiles,
                              const std::vector<model::Joint>& joints, int countsFrom);

}  // namespace kirireel::fea
