/// Which unknowns of a sparse system of equations between pairs of tiles can be chosen freely.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace kirireel {

/// Equations between the six unknowns of one tile and those of another, or the same: first u_first
/// + second u_second = 0.
struct PairEquations {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6>;

  int firstTile = 0;
  int secondTile = 0;
  Rows first;   ///< (equations x 6), at most six
  Rows second;  ///< as many
};

/// An unknown: one of the six of a tile.
struct FreeColumn {
  int tile = 0;
  int unknown = 0;  ///< 0 to 5
};

/// The unknowns without which the equations have the solution zero alone, as many as the matrix has
/// nullity. A column counts as free where elimination leaves it shorter than `tolerance`, in the
/// equations' own measure. Tiles that are fixed have no unknowns. Each tile's together, in the
/// order of elimination. `isFixed` has tileCount entries. The tolerance has the unit of the
/// equations' rows. Work is that of a sparse QR factorisation in an order of minimum degree.
std::vector<FreeColumn> freeColumns(int tileCount, const std::vector<PairEquations>& equations,
                                    const std::vector<bool>& isFixed, double tolerance);

}  // namespace kirireel
