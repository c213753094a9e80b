/// The symbolic half of a sparse Cholesky factorisation: in which order to eliminate the tiles, and
/// which blocks fill in. It depends on the graph alone, so it is made once for many factorisations.
#pragma once

#include <utility>
#include <vector>

namespace kirireel {

/// A run of consecutive columns that share the rows below them, eliminated together in one dense
/// front (Liu 1992, "The multifrontal method for sparse matrix solution").
struct Supernode {
  /// Its columns in the permuted matrix are firstColumn to firstColumn + columnCount - 1.
  int firstColumn = 0;
  int columnCount = 0;
  std::vector<int> rows;      ///< of the front below its columns, ascending, permuted numbers
  std::vector<int> children;  ///< supernodes whose updates this front takes in, in stack order
  /// Where the rows of child c stand in this front (0 is firstColumn): one list a child.
  std::vector<std::vector<int>> childPlaces;
};

/// The order of elimination and the fronts, children before parents.
struct Elimination {
  std::vector<int> place;  ///< place[node]: its column in the permuted matrix
  std::vector<Supernode> supernodes;
};

/// Plans the factorisation of a symmetric matrix of `nodeCount` blocks with the given off-diagonal
/// pairs (any order, no duplicates needed to be removed): minimum-degree ordering, postordered
/// elimination tree, supernodes merged where that adds few zeros.
/// Nodes may be unconnected: the plan is then a forest. May throw Interrupted. The same graph gives
/// the same plan on every machine.
Elimination planElimination(int nodeCount, const std::vector<std::pair<int, int>>& edges);

}  // namespace kirireel
