/// Multifrontal Cholesky factorisation of a sparse symmetric matrix of small square blocks.
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "sim/joints/elimination.h"

namespace kirireel {

/// Factors H = L L^T, H positive definite with D x D blocks on a graph: one block a node, one a
/// joined pair. Written for matrices of 25 to 10,000 blocks whose values change every step and
/// whose graph seldom does. D is 3 or 6.
template <int D>
class BlockCholesky {
 public:
  using Block = Eigen::Matrix<double, D, D>;

  /// Plans for `nodeCount` nodes and these pairs (first != second); see planElimination. All values
  /// start at zero.
  void analyze(int nodeCount, const std::vector<std::pair<int, int>>& edges);

  /// Sets all values to zero.
  void setZero();

  /// H(node, node), to be written before factor().
  Block& diagonal(int node) { return diagonal_[node]; }

  /// H(edges[edge].first, edges[edge].second), to be written before factor(); its transpose is
  /// implied.
  Block& offDiagonal(int edge) { return offDiagonal_[edge]; }

  /// Factors the values at hand. Returns false when H is not positive definite to rounding.
  bool factor();

  /// What a factorisation and the solves with it cost: multiplications with an addition, as the
  /// plan's fronts alone decide. The same on every machine.
  double work() const { return work_; }

  /// Solves H x = right in place; right has D values a node. Needs a successful factor().
  void solveInPlace(Eigen::VectorXd& right) const;

 private:
  using Matrix = Eigen::MatrixXd;
  using MatrixMap = Eigen::Map<Matrix>;
  using ConstMatrixMap = Eigen::Map<const Matrix>;

  /// Where one block of H goes in its front's panel.
  struct Entry {
    int source = 0;  // node or edge
    int row = 0;     // block row in the panel
    int column = 0;  // block column in the panel
    bool transposed = false;
  };

  void placeDiagonals();
  void placeEdges();
  void placeUpdates();
  void assemble(int supernode);
  void addChildren(int supernode);
  bool eliminate(int supernode);
  int frontRows(int supernode) const;
  MatrixMap panel(int supernode);
  MatrixMap update(int supernode);

  Elimination plan_;
  double work_ = 0;
  std::vector<std::pair<int, int>> edges_;
  std::vector<Block, Eigen::aligned_allocator<Block>> diagonal_;
  std::vector<Block, Eigen::aligned_allocator<Block>> offDiagonal_;
  std::vector<std::vector<Entry>> diagonalEntries_;  // one list a supernode
  std::vector<std::vector<Entry>> edgeEntries_;
  int largestBelow_ = 0;  // rows below any panel, in blocks
  std::vector<std::size_t> panelStart_;
  std::vector<double> panels_;  // the factor: one panel a supernode, column-major
  std::vector<std::size_t> updateStart_;
  std::vector<double> updates_;  // Schur complements that wait for their parents, on two stacks
};

extern template class BlockCholesky<3>;
extern template class BlockCholesky<6>;

}  // namespace kirireel
