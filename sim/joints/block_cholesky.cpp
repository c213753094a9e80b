// H = L L^T, front by front. A supernode with the columns C and the rows R below them has the dense
// front
//   F = [F_CC .; F_RC F_RR] = its own blocks of H + the updates of its children,
// of which a panel of |C| columns is kept: F_CC = L_CC L_CC^T, L_RC = F_RC L_CC^-T. What is left,
// F_RR - L_RC L_RC^T, is the update of its parent and waits on a stack, since children come right
// before their parent. A solve runs up the fronts with L^-1 and down again with L^-T.
// Liu, "The multifrontal method for sparse matrix solution: theory and practice", 1992.
#include "sim/joints/block_cholesky.h"

#include <algorithm>
#include <array>

#include "sim/base/interruption.h"
#include "sim/joints/dense_kernels.h"

namespace kirireel {
namespace {

// A factor is solved with about so many times: some rounds of multipliers, two passes each.
constexpr double kSolves = 20;

/// Of the dense front with so many columns to eliminate and so many rows below.
double workOf(double columns, double rows) {
  const double factor = columns * columns * columns / 6 + columns * columns * rows / 2;
  return factor + columns * rows * rows / 2 + kSolves * columns * (columns + rows);
}

}  // namespace

template <int D>
void BlockCholesky<D>::analyze(int nodeCount, const std::vector<std::pair<int, int>>& edges) {
  plan_ = planElimination(nodeCount, edges);
  edges_ = edges;
  diagonal_.assign(nodeCount, Block::Zero());
  offDiagonal_.assign(edges.size(), Block::Zero());
  std::size_t size = 0;
  largestBelow_ = 0;
  work_ = 0;
  panelStart_.clear();
  for (const Supernode& node : plan_.supernodes) {
    panelStart_.push_back(size);
    largestBelow_ = std::max(largestBelow_, static_cast<int>(node.rows.size()));
    work_ += workOf(D * node.columnCount, static_cast<double>(D * node.rows.size()));
    size += D * D * node.columnCount * (node.columnCount + node.rows.size());
  }
  panels_.assign(size, 0.0);
  placeDiagonals();
  placeEdges();
  placeUpdates();
}

template <int D>
void BlockCholesky<D>::placeDiagonals() {
  std::vector<int> nodeAt(diagonal_.size());
  for (std::size_t node = 0; node < diagonal_.size(); ++node)
    nodeAt[plan_.place[node]] = static_cast<int>(node);
  diagonalEntries_.assign(plan_.supernodes.size(), {});
  for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) {
    for (int c = 0; c < plan_.supernodes[s].columnCount; ++c) {
      diagonalEntries_[s].push_back({nodeAt[plan_.supernodes[s].firstColumn + c], c, c, false});
    }
  }
}

template <int D>
void BlockCholesky<D>::placeEdges() {
  std::vector<int> supernodeAt(diagonal_.size());
  for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) {
    const Supernode& node = plan_.supernodes[s];
    std::fill_n(supernodeAt.begin() + node.firstColumn, node.columnCount, static_cast<int>(s));
  }
  edgeEntries_.assign(plan_.supernodes.size(), {});
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    checkInterruption();
    const int first = plan_.place[edges_[e].first];
    const int second = plan_.place[edges_[e].second];
    const auto [column, row] = std::minmax(first, second);
    const int s = supernodeAt[column];
    const Supernode& node = plan_.supernodes[s];
    int place = row - node.firstColumn;
    if (place >= node.columnCount) {
      const auto found = std::lower_bound(node.rows.begin(), node.rows.end(), row);
      place = node.columnCount + static_cast<int>(found - node.rows.begin());
    }
    // The panel holds H(row, column); the edge holds H(first, second).
    edgeEntries_[s].push_back(
        {static_cast<int>(e), place, column - node.firstColumn, first == column});
  }
}

/// An update waits on one of two stacks while its parent's grows on the other: fronts of even depth
/// use the first, of odd depth the second. So the memory stays small, and in the cache.
template <int D>
void BlockCholesky<D>::placeUpdates() {
  const std::vector<Supernode>& nodes = plan_.supernodes;
  std::vector<int> stackOf(nodes.size(), 0);
  for (std::size_t s = nodes.size(); s-- > 0;) {
    for (const int child : nodes[s].children) stackOf[child] = 1 - stackOf[s];
  }
  const auto size = [&](int s) { return D * D * nodes[s].rows.size() * nodes[s].rows.size(); };
  std::array<std::size_t, 2> top = {0, 0};
  std::array<std::size_t, 2> highest = {0, 0};
  updateStart_.resize(nodes.size());
  for (std::size_t s = 0; s < nodes.size(); ++s) {
    const int stack = stackOf[s];
    updateStart_[s] = top[stack];
    top[stack] += size(static_cast<int>(s));
    highest[stack] = std::max(highest[stack], top[stack]);
    for (const int child : nodes[s].children) top[1 - stack] -= size(child);
  }
  for (std::size_t s = 0; s < nodes.size(); ++s) updateStart_[s] += stackOf[s] * highest[0];
  updates_.assign(highest[0] + highest[1], 0.0);
}

template <int D>
void BlockCholesky<D>::setZero() {
  std::fill(diagonal_.begin(), diagonal_.end(), Block::Zero());
  std::fill(offDiagonal_.begin(), offDiagonal_.end(), Block::Zero());
}

template <int D>
int BlockCholesky<D>::frontRows(int supernode) const {
  const Supernode& node = plan_.supernodes[supernode];
  return D * (node.columnCount + static_cast<int>(node.rows.size()));
}

template <int D>
typename BlockCholesky<D>::MatrixMap BlockCholesky<D>::panel(int supernode) {
  return {panels_.data() + panelStart_[supernode], frontRows(supernode),
          D * plan_.supernodes[supernode].columnCount};
}

template <int D>
typename BlockCholesky<D>::MatrixMap BlockCholesky<D>::update(int supernode) {
  const int rows = D * static_cast<int>(plan_.supernodes[supernode].rows.size());
  return {updates_.data() + updateStart_[supernode], rows, rows};
}

template <int D>
bool BlockCholesky<D>::factor() {
  for (int s = 0; s < static_cast<int>(plan_.supernodes.size()); ++s) {
    checkInterruption();
    assemble(s);
    addChildren(s);
    if (!eliminate(s)) return false;
  }
  return true;
}

template <int D>
void BlockCholesky<D>::assemble(int supernode) {
  MatrixMap front = panel(supernode);
  front.setZero();
  for (const Entry& entry : diagonalEntries_[supernode]) {
    front.template block<D, D>(D * entry.row, D * entry.column) = diagonal_[entry.source];
  }
  for (const Entry& entry : edgeEntries_[supernode]) {
    auto place = front.template block<D, D>(D * entry.row, D * entry.column);
    if (entry.transposed) {
      place += offDiagonal_[entry.source].transpose();
    } else {
      place += offDiagonal_[entry.source];
    }
  }
  update(supernode).setZero();
}

template <int D>
void BlockCholesky<D>::addChildren(int supernode) {
  const Supernode& node = plan_.supernodes[supernode];
  MatrixMap front = panel(supernode);
  MatrixMap own = update(supernode);
  for (std::size_t c = 0; c < node.children.size(); ++c) {
    const std::vector<int>& places = node.childPlaces[c];
    const int size = static_cast<int>(places.size());
    const MatrixMap child = update(node.children[c]);
    for (int j = 0; j < size; ++j) {
      const int column = places[j];
      for (int i = j; i < size; ++i) {
        const auto block = child.template block<D, D>(D * i, D * j);
        if (column < node.columnCount) {
          front.template block<D, D>(D * places[i], D * column) += block;
        } else {
          own.template block<D, D>(D * (places[i] - node.columnCount),
                                   D * (column - node.columnCount)) += block;
        }
      }
    }
  }
}

template <int D>
bool BlockCholesky<D>::eliminate(int supernode) {
  return denseKernels().eliminate(panels_.data() + panelStart_[supernode], frontRows(supernode),
                                  D * plan_.supernodes[supernode].columnCount,
                                  update(supernode).data());
}

template <int D>
void BlockCholesky<D>::solveInPlace(Eigen::VectorXd& right) const {
  checkInterruption();
  const int count = static_cast<int>(plan_.place.size());
  Eigen::VectorXd x(right.size());
  for (int node = 0; node < count; ++node) {
    x.segment<D>(D * plan_.place[node]) = right.segment<D>(D * node);
  }
  const DenseKernels& kernels = denseKernels();
  Eigen::VectorXd below(D * largestBelow_);
  for (int s = 0; s < static_cast<int>(plan_.supernodes.size()); ++s) {
    const Supernode& node = plan_.supernodes[s];
    kernels.solveForward(panels_.data() + panelStart_[s], frontRows(s), D * node.columnCount,
                         x.data() + D * node.firstColumn, below.data());
    for (std::size_t r = 0; r < node.rows.size(); ++r) {
      x.segment<D>(D * node.rows[r]) -= below.segment<D>(D * r);
    }
  }
  for (int s = static_cast<int>(plan_.supernodes.size()) - 1; s >= 0; --s) {
    const Supernode& node = plan_.supernodes[s];
    for (std::size_t r = 0; r < node.rows.size(); ++r) {
      below.segment<D>(D * r) = x.segment<D>(D * node.rows[r]);
    }
    kernels.solveBackward(panels_.data() + panelStart_[s], frontRows(s), D * node.columnCount,
                          x.data() + D * node.firstColumn, below.data());
  }
  for (int node = 0; node < count; ++node) {
    right.segment<D>(D * node) = x.segment<D>(D * plan_.place[node]);
  }
}

template class BlockCholesky<3>;
template class BlockCholesky<6>;

}  // namespace kirireel
