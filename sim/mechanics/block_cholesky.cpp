// The plan has four steps: an order of columns by approximate minimum degree; the elimination tree,
// in which the parent of column j is the first row below it that fills in,
//   rows(j) = neighbours after j, and rows(children) without j;   parent(j) = min rows(j);
// its postorder, in which each subtree is consecutive; and supernodes, which absorb the column
// before them while this adds few zeros to the panel. Amestoy, Davis and Duff, "An approximate
// minimum degree ordering algorithm", 1996; Liu, "The role of elimination trees in sparse
// factorization", 1990; Ashcraft and Grimes, "The influence of relaxed supernode partitions on the
// multifrontal method", 1989.
#include "sim/mechanics/block_cholesky.h"

#include <algorithm>
#include <array>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "sim/base/interruption.h"
#include "sim/mechanics/dense_kernels.h"

namespace kirireel::mechanics {
namespace {

using Graph = std::vector<std::vector<int>>;

// A merge may leave this fraction of zero blocks in the merged panel, counted over the whole chain
// of merges. Small fronts may have more zeros, because their overhead dominates.
constexpr double kZeroShare = 0.08;
constexpr int kSmallFront = 4;
constexpr double kSmallZeroShare = 0.35;

/// Node -> column by approximate minimum degree.
std::vector<int> minimumDegreeOrder(int nodeCount, const std::vector<std::pair<int, int>>& edges) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < nodeCount; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [a, b] : edges) {
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  }
  Eigen::SparseMatrix<double> matrix(nodeCount, nodeCount);
  matrix.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
  Eigen::AMDOrdering<int>()(matrix, permutation);
  std::vector<int> place(nodeCount);
  for (int column = 0; column < nodeCount; ++column) place[permutation.indices()[column]] = column;
  return place;
}

/// For each column the later columns that it is joined to, in permuted indices.
Graph laterNeighbours(const std::vector<int>& place,
                      const std::vector<std::pair<int, int>>& edges) {
  Graph later(place.size());
  for (const auto& [a, b] : edges) {
    const auto [low, high] = std::minmax(place[a], place[b]);
    if (low != high) later[low].push_back(high);
  }
  for (auto& list : later) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return later;
}

/// The filled rows below each column: its own neighbours and those of its children in the
/// elimination tree. parent[j] is the first of them, or -1.
Graph fillRows(const Graph& later, std::vector<int>& parent) {
  const int count = static_cast<int>(later.size());
  Graph rows = later;
  parent.assign(count, -1);
  for (int j = 0; j < count; ++j) {
    checkInterruption();
    if (rows[j].empty()) continue;
    parent[j] = rows[j].front();
    std::vector<int> merged;
    std::set_union(rows[j].begin() + 1, rows[j].end(), rows[parent[j]].begin(),
                   rows[parent[j]].end(), std::back_inserter(merged));
    rows[parent[j]] = std::move(merged);
  }
  return rows;
}

/// Renumbers columns to make each subtree of the elimination tree consecutive.
std::vector<int> postorder(const std::vector<int>& parent) {
  const int count = static_cast<int>(parent.size());
  Graph children(count + 1);
  for (int j = count - 1; j >= 0; --j) children[parent[j] < 0 ? count : parent[j]].push_back(j);
  std::vector<int> newNumber(count);
  std::vector<int> stack(children[count]);
  int next = 0;
  while (!stack.empty()) {
    const int j = stack.back();
    if (children[j].empty()) {
      newNumber[j] = next++;
      stack.pop_back();
    } else {
      for (const int child : children[j]) stack.push_back(child);
      children[j].clear();
    }
  }
  return newNumber;
}

/// A supernode during its growth.
struct Front {
  int first = 0;
  int columns = 0;
  std::vector<int> rows;
  double zeros = 0;  // blocks of the panel that are zero in the exact fill

  double panelBlocks() const { return columns * (0.5 * (columns + 1) + rows.size()); }
};

/// The merged front of `child` and `parent`, with child's columns directly before parent's.
Front mergedFront(const Front& child, const Front& parent) {
  Front merged{child.first, child.columns + parent.columns, {}, 0};
  const int end = merged.first + merged.columns;
  std::set_union(child.rows.begin(), child.rows.end(), parent.rows.begin(), parent.rows.end(),
                 std::back_inserter(merged.rows));
  merged.rows.erase(merged.rows.begin(),
                    std::lower_bound(merged.rows.begin(), merged.rows.end(), end));
  const double filled = child.panelBlocks() - child.zeros + parent.panelBlocks() - parent.zeros;
  merged.zeros = merged.panelBlocks() - filled;
  return merged;
}

bool worthMerging(const Front& merged) {
  const double share = merged.columns <= kSmallFront ? kSmallZeroShare : kZeroShare;
  return merged.zeros <= share * merged.panelBlocks();
}

/// Grows supernodes by merging each with the one just before it while that adds few zeros.
std::vector<Front> growFronts(const Graph& rows, const std::vector<int>& parent) {
  std::vector<Front> fronts;
  for (int j = 0; j < static_cast<int>(rows.size()); ++j) {
    checkInterruption();
    Front front{j, 1, rows[j], 0};
    while (!fronts.empty()) {
      const Front& last = fronts.back();
      const int lastColumn = last.first + last.columns - 1;
      if (parent[lastColumn] < front.first) break;
      if (parent[lastColumn] >= front.first + front.columns) break;
      Front merged = mergedFront(last, front);
      if (!worthMerging(merged)) break;
      front = std::move(merged);
      fronts.pop_back();
    }
    fronts.push_back(std::move(front));
  }
  return fronts;
}

std::vector<int> placesInFront(const std::vector<int>& rows, const Supernode& front) {
  std::vector<int> places;
  const int end = front.firstColumn + front.columnCount;
  for (int row : rows) {
    if (row < end) {
      places.push_back(row - front.firstColumn);
    } else {
      const auto found = std::lower_bound(front.rows.begin(), front.rows.end(), row);
      places.push_back(front.columnCount + static_cast<int>(found - front.rows.begin()));
    }
  }
  return places;
}

/// Links each front to the one that holds its first row.
std::vector<Supernode> linkFronts(std::vector<Front> fronts, int columnCount) {
  std::vector<int> frontOfColumn(columnCount);
  std::vector<Supernode> supernodes(fronts.size());
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    supernodes[s] = {fronts[s].first, fronts[s].columns, std::move(fronts[s].rows), {}, {}};
    for (int c = 0; c < fronts[s].columns; ++c)
      frontOfColumn[fronts[s].first + c] = static_cast<int>(s);
  }
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    checkInterruption();
    if (supernodes[s].rows.empty()) continue;
    Supernode& parent = supernodes[frontOfColumn[supernodes[s].rows.front()]];
    parent.children.push_back(static_cast<int>(s));
    parent.childPlaces.push_back(placesInFront(supernodes[s].rows, parent));
  }
  // Updates are on a stack: the last child's is on top.
  for (Supernode& node : supernodes) {
    std::reverse(node.children.begin(), node.children.end());
    std::reverse(node.childPlaces.begin(), node.childPlaces.end());
  }
  return supernodes;
}

}  // namespace

Elimination planElimination(int nodeCount, const std::vector<std::pair<int, int>>& edges) {
  std::vector<int> place = minimumDegreeOrder(nodeCount, edges);
  std::vector<int> parent;
  fillRows(laterNeighbours(place, edges), parent);
  const std::vector<int> renumbered = postorder(parent);
  for (int& column : place) column = renumbered[column];
  const Graph rows = fillRows(laterNeighbours(place, edges), parent);
  return {place, linkFronts(growFronts(rows, parent), nodeCount)};
}

// ------------------------------------------------------------------------------------------------
// H = L L^T, front by front. A supernode with the columns C and the rows R below them has the dense
// front
//   F = [F_CC .; F_RC F_RR] = its own blocks of H + the updates of its children.
// Its panel of |C| columns is kept: F_CC = L_CC L_CC^T, L_RC = F_RC L_CC^-T. The remainder,
// F_RR - L_RC L_RC^T, is the update of its parent. It waits on a stack, because children come
// directly before their parent. A solve passes up through the fronts with L^-1 and down again with
// L^-T. Liu, "The multifrontal method for sparse matrix solution: theory and practice", 1992.

namespace {

// Typical number of solves per factor: some rounds of multipliers, two passes each.
constexpr double kSolves = 20;

/// Work of a dense front with `columns` columns to eliminate and `rows` rows below.
double workOf(double columns, double rows) {
  const double factor = columns * columns * columns / 6 + columns * columns * rows / 2;
  return factor + columns * rows * rows / 2 + kSolves * columns * (columns + rows);
}

/// Adds `rows` rows of kColumns columns.
template <int kColumns>
void addRun(const double* __restrict from, int fromStride, int rows, double* __restrict to,
            int toStride) {
  for (int column = 0; column < kColumns; ++column, from += fromStride, to += toStride) {
    for (int row = 0; row < rows; ++row) to[row] += from[row];
  }
}

/// For each position in a list, the end of its run of consecutive numbers.
std::vector<int> endsOfRuns(const std::vector<int>& numbers) {
  std::vector<int> ends(numbers.size(), static_cast<int>(numbers.size()));
  for (std::size_t k = numbers.size(); k-- > 1;) {
    ends[k - 1] = numbers[k] == numbers[k - 1] + 1 ? ends[k] : static_cast<int>(k);
  }
  return ends;
}

}  // namespace

// Makes the plan and all memory positions, for any number of later factorisations. It costs as much
// as the ordering, a hundred times and more the cost of summing H.
template <int D>
void BlockCholesky<D>::analyze(int nodeCount, const std::vector<std::pair<int, int>>& edges) {
  plan_ = planElimination(nodeCount, edges);
  std::size_t size = 0;
  int largestFront = 0;
  work_ = 0;
  panelStart_.clear();
  for (int s = 0; s < static_cast<int>(plan_.supernodes.size()); ++s) {
    const Supernode& node = plan_.supernodes[s];
    const int rows = paddedRows(frontRows(s));
    panelStart_.push_back(size);
    largestFront = std::max(largestFront, rows);
    work_ += workOf(D * node.columnCount, static_cast<double>(D * node.rows.size()));
    size += static_cast<std::size_t>(rows) * (D * node.columnCount);
  }
  panels_.assign(size + kRowsTogether, 0.0);
  front_.resize(largestFront);
  permuted_.resize(D * nodeCount);
  placeBlocks(edges);
  placeUpdates();
  runEnds_.assign(plan_.supernodes.size(), {});
  for (const Supernode& node : plan_.supernodes) {
    for (std::size_t c = 0; c < node.children.size(); ++c) {
      runEnds_[node.children[c]] = endsOfRuns(node.childPlaces[c]);
    }
  }
}

template <int D>
void BlockCholesky<D>::placeBlocks(const std::vector<std::pair<int, int>>& edges) {
  const std::size_t count = plan_.place.size();
  std::vector<int> supernodeAt(count);
  for (std::size_t s = 0; s < plan_.supernodes.size(); ++s) {
    const Supernode& node = plan_.supernodes[s];
    std::fill_n(supernodeAt.begin() + node.firstColumn, node.columnCount, static_cast<int>(s));
  }
  // A block row of the panel of `column`. Both are permuted indices.
  const auto placeOf = [&](int column, int row) {
    const int s = supernodeAt[column];
    const Supernode& node = plan_.supernodes[s];
    int inPanel = row - node.firstColumn;
    if (inPanel >= node.columnCount) {
      const auto found = std::lower_bound(node.rows.begin(), node.rows.end(), row);
      inPanel = node.columnCount + static_cast<int>(found - node.rows.begin());
    }
    const int stride = paddedRows(frontRows(s));
    const std::size_t start = static_cast<std::size_t>(D * (column - node.firstColumn)) * stride;
    return Place{panelStart_[s] + start + D * inPanel, stride};
  };
  diagonalPlaces_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    diagonalPlaces_[i] = placeOf(plan_.place[i], plan_.place[i]);
  }
  edgePlaces_.clear();
  for (const auto& [first, second] : edges) {
    checkInterruption();
    const auto [column, row] = std::minmax(plan_.place[first], plan_.place[second]);
    // The panel holds H(row, column); the edge is H(first, second).
    edgePlaces_.push_back(placeOf(column, row));
    edgePlaces_.back().isTransposed = plan_.place[first] == column;
  }
}

/// An update waits on one of two stacks while its parent's grows on the other: fronts of even depth
/// use the first, of odd depth the second. Memory therefore stays small, and in the cache.
template <int D>
void BlockCholesky<D>::placeUpdates() {
  const std::vector<Supernode>& nodes = plan_.supernodes;
  std::vector<int> stackOf(nodes.size(), 0);
  for (std::size_t s = nodes.size(); s-- > 0;) {
    for (const int child : nodes[s].children) stackOf[child] = 1 - stackOf[s];
  }
  const auto size = [&](int s) {
    return static_cast<std::size_t>(updateRows(s)) * paddedRows(updateRows(s));
  };
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
  updates_.assign(highest[0] + highest[1] + kRowsTogether, 0.0);
}

template <int D>
void BlockCholesky<D>::setZero() {
  Eigen::Map<Eigen::VectorXd>(panels_.data(), static_cast<Eigen::Index>(panels_.size())).setZero();
}

template <int D>
int BlockCholesky<D>::frontRows(int supernode) const {
  const Supernode& node = plan_.supernodes[supernode];
  return D * (node.columnCount + static_cast<int>(node.rows.size()));
}

template <int D>
int BlockCholesky<D>::updateRows(int supernode) const {
  return D * static_cast<int>(plan_.supernodes[supernode].rows.size());
}

template <int D>
bool BlockCholesky<D>::factor() {
  for (int s = 0; s < static_cast<int>(plan_.supernodes.size()); ++s) {
    checkInterruption();
    addChildren(s);
    if (!eliminate(s)) return false;
  }
  return true;
}

/// Adds the updates of the children to the front's own blocks. Columns of a child that the front
/// eliminates go into its panel, the others into its own update.
template <int D>
void BlockCholesky<D>::addChildren(int supernode) {
  const Supernode& node = plan_.supernodes[supernode];
  double* const panel = panels_.data() + panelStart_[supernode];
  double* const own = updates_.data() + updateStart_[supernode];
  const int panelStride = paddedRows(frontRows(supernode));
  const int ownStride = paddedRows(updateRows(supernode));
  Eigen::Map<Eigen::MatrixXd>(own, ownStride, updateRows(supernode)).setZero();
  for (std::size_t c = 0; c < node.children.size(); ++c) {
    const std::vector<int>& places = node.childPlaces[c];
    const std::vector<int>& ends = runEnds_[node.children[c]];
    const int size = static_cast<int>(places.size());
    const double* const child = updates_.data() + updateStart_[node.children[c]];
    const int childStride = paddedRows(updateRows(node.children[c]));
    for (int j = 0; j < size; ++j) {
      const bool isOwn = places[j] >= node.columnCount;
      const int first = isOwn ? node.columnCount : 0;
      const int stride = isOwn ? ownStride : panelStride;
      double* const to =
          (isOwn ? own : panel) + static_cast<std::ptrdiff_t>(D * (places[j] - first)) * stride;
      const double* const from = child + static_cast<std::ptrdiff_t>(D * j) * childStride;
      for (int i = j; i < size; i = ends[i]) {
        addRun<D>(from + D * i, childStride, D * (ends[i] - i), to + D * (places[i] - first),
                  stride);
      }
    }
  }
}

template <int D>
bool BlockCholesky<D>::eliminate(int supernode) {
  return denseKernels().eliminate(panels_.data() + panelStart_[supernode], frontRows(supernode),
                                  D * plan_.supernodes[supernode].columnCount,
                                  updates_.data() + updateStart_[supernode]);
}

/// Sets front_ to the values of a front's rows. In the upward pass, those below its columns are
/// zero.
template <int D>
void BlockCholesky<D>::gather(const Supernode& node, bool withBelow) const {
  const int columns = D * node.columnCount;
  const int rows = columns + D * static_cast<int>(node.rows.size());
  front_.head(columns) = permuted_.segment(D * node.firstColumn, columns);
  front_.segment(columns, paddedRows(rows) - columns).setZero();
  if (!withBelow) return;
  for (std::size_t r = 0; r < node.rows.size(); ++r) {
    front_.segment<D>(columns + D * r) = permuted_.segment<D>(D * node.rows[r]);
  }
}

template <int D>
void BlockCholesky<D>::solveInPlace(Eigen::VectorXd& right) const {
  checkInterruption();
  const int count = static_cast<int>(plan_.place.size());
  for (int node = 0; node < count; ++node) {
    permuted_.segment<D>(D * plan_.place[node]) = right.segment<D>(D * node);
  }
  const DenseKernels& kernels = denseKernels();
  for (int s = 0; s < static_cast<int>(plan_.supernodes.size()); ++s) {
    const Supernode& node = plan_.supernodes[s];
    const int columns = D * node.columnCount;
    gather(node, false);
    kernels.solveForward(panels_.data() + panelStart_[s], frontRows(s), columns, front_.data());
    permuted_.segment(D * node.firstColumn, columns) = front_.head(columns);
    for (std::size_t r = 0; r < node.rows.size(); ++r) {
      permuted_.segment<D>(D * node.rows[r]) += front_.segment<D>(columns + D * r);
    }
  }
  for (int s = static_cast<int>(plan_.supernodes.size()) - 1; s >= 0; --s) {
    const Supernode& node = plan_.supernodes[s];
    const int columns = D * node.columnCount;
    gather(node, true);
    kernels.solveBackward(panels_.data() + panelStart_[s], frontRows(s), columns, front_.data());
    permuted_.segment(D * node.firstColumn, columns) = front_.head(columns);
  }
  for (int node = 0; node < count; ++node) {
    right.segment<D>(D * node) = permuted_.segment<D>(D * plan_.place[node]);
  }
}

template class BlockCholesky<3>;
template class BlockCholesky<6>;

// ------------------------------------------------------------------------------------------------
// Selects the dense kernels for the present processor, once for the whole program. A test at run
// time lets one binary serve old and new machines.

const DenseKernels& denseKernels() {
#ifdef KIRIREEL_HAS_AVX2_KERNELS
  static const bool newer = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (newer) return avx2::kKernels;
#endif
  return baseline::kKernels;
}

}  // namespace kirireel::mechanics
