/// Multifrontal Cholesky factorisation of sparse symmetric matrices of small square blocks: the
/// symbolic part, an order of elimination, and the numerical part.
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

namespace kirireel::mechanics {

// ------------------------------------------------------------------------------------------------
// The symbolic part of a sparse Cholesky factorisation: the order of elimination of the tiles and
// the blocks that fill in. It depends only on the graph and serves many factorisations.

/// A run of consecutive columns that share the rows below them, eliminated together in one dense
/// front (Liu 1992, "The multifrontal method for sparse matrix solution").
struct Supernode {
  /// Its columns in the permuted matrix are firstColumn to firstColumn + columnCount - 1.
  int firstColumn = 0;
  int columnCount = 0;        ///< number of columns, >= 1
  std::vector<int> rows;      ///< of the front below its columns, ascending, permuted indices
  std::vector<int> children;  ///< supernodes whose updates this front receives, in stack order
  /// Positions of the rows of child c in this front (0 is firstColumn): one list per child.
  std::vector<std::vector<int>> childPlaces;
};

/// The order of elimination and the fronts, children before parents.
struct Elimination {
  std::vector<int> place;             ///< place[node]: its column in the permuted matrix
  std::vector<Supernode> supernodes;  ///< children before their parents
};

/// Plans the factorisation of a symmetric matrix of `nodeCount` blocks with the given off-diagonal
/// pairs (any order, duplicates allowed): minimum-degree ordering, postordered elimination tree,
/// supernodes merged if that adds few zeros. Nodes may be unconnected: the plan is then a forest.
/// May throw Interrupted. The same graph gives the same plan on every machine.
Elimination planElimination(int nodeCount, const std::vector<std::pair<int, int>>& edges);

// ------------------------------------------------------------------------------------------------
// Multifrontal Cholesky factorisation of a sparse symmetric matrix of small square blocks.

/// Factors H = L L^T, H positive definite with D x D blocks on a graph: one block per node and one
/// per joined pair. Designed for matrices of 25 to 10,000 blocks whose values change every step and
/// whose graph rarely changes. D is 3 or 6.
template <int D>
class BlockCholesky {
 public:
  /// A block of the matrix.
  using Block = Eigen::Matrix<double, D, D>;

  /// Plans for `nodeCount` nodes and these pairs (first != second); see planElimination(). All
  /// values are initially zero. Throws only Interrupted. Costs O(n log n) for the graphs of
  /// sheets.
  void analyze(int nodeCount, const std::vector<std::pair<int, int>>& edges);

  /// Sets all values to zero. Call it before H is summed again: factor() overwrites the values.
  void setZero();

  /// Adds to H(node, node).
  void addToDiagonal(int node, const Block& block) { add(diagonalPlaces_[node], block); }

  /// Adds to H(edges[edge].first, edges[edge].second); its transpose is implied.
  void addToOffDiagonal(int edge, const Block& block) {
    const Place& place = edgePlaces_[edge];
    if (place.isTransposed) {
      add(place, block.transpose());
    } else {
      add(place, block);
    }
  }

  /// Factors the current values. Returns false if H is not positive definite up to rounding. May
  /// throw Interrupted. Values are then undefined until setZero().
  bool factor();

  /// Cost of a factorisation and its solves, in multiplications with an addition. It follows from
  /// the plan's fronts and is the same on every machine.
  double work() const { return work_; }

  /// Solves H x = right in place. `right` has D values per node. Needs a successful factor(). Not
  /// thread-safe.
  void solveInPlace(Eigen::VectorXd& right) const;

 private:
  /// The position of one block of H in the panels.
  struct Place {
    std::size_t start = 0;
    int stride = 0;
    bool isTransposed = false;
  };

  template <typename Summand>
  void add(const Place& place, const Summand& block) {
    for (int column = 0; column < D; ++column) {
      double* const to = panels_.data() + place.start + column * place.stride;
      for (int row = 0; row < D; ++row) to[row] += block.coeff(row, column);
    }
  }

  void placeBlocks(const std::vector<std::pair<int, int>>& edges);
  void placeUpdates();
  void addChildren(int supernode);
  bool eliminate(int supernode);
  int frontRows(int supernode) const;
  int updateRows(int supernode) const;
  void gather(const Supernode& node, bool withBelow) const;

  Elimination plan_;
  double work_ = 0;
  std::vector<Place> diagonalPlaces_, edgePlaces_;
  std::vector<std::size_t> panelStart_;
  std::vector<double> panels_;  // H, then its factor: one panel per supernode, column-major
  std::vector<std::size_t> updateStart_;
  /// For each block row of a supernode's update, the end of its run of rows in the parent.
  std::vector<std::vector<int>> runEnds_;
  std::vector<double> updates_;  // Schur complements that wait for their parents, on two stacks
  mutable Eigen::VectorXd permuted_;  // values of a solve, in the order of elimination
  mutable Eigen::VectorXd front_;     // values of a front in a solve, padded
};

extern template class BlockCholesky<3>;
extern template class BlockCholesky<6>;

}  // namespace kirireel::mechanics
