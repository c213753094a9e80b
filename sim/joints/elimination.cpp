// The plan in four steps: an order of columns by approximate minimum degree; the elimination tree,
// in which the parent of column j is the first row below it that fills in,
//   rows(j) = neighbours after j, and rows(children) without j;   parent(j) = min rows(j);
// its postorder, in which each subtree stands together; and supernodes, which take in the column
// before them while the zeros that this puts into the panel stay few.
// Amestoy, Davis and Duff, "An approximate minimum degree ordering algorithm", 1996; Liu, "The role
// of elimination trees in sparse factorization", 1990; Ashcraft and Grimes, "The influence of
// relaxed supernode partitions on the multifrontal method", 1989.
#include "sim/joints/elimination.h"

#include <algorithm>
#include <numeric>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

#include "sim/base/interruption.h"

namespace kirireel {
namespace {

using Graph = std::vector<std::vector<int>>;

// A merge may leave this many zero blocks for each block of the merged panel, zeros counted over
// the whole chain of merges; small fronts may be fuller of zeros, since their overhead dominates.
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

/// For each column the later columns that it is joined to, in permuted numbers.
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

/// Renumbers columns so that each subtree of the elimination tree is consecutive.
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
      stack.insert(stack.end(), children[j].begin(), children[j].end());
      children[j].clear();
    }
  }
  return newNumber;
}

/// A supernode while it grows.
struct Front {
  int first = 0;
  int columns = 0;
  std::vector<int> rows;
  double zeros = 0;  // blocks of the panel that are zero in the exact fill

  double panelBlocks() const { return columns * (0.5 * (columns + 1) + rows.size()); }
};

/// The front of `child` and `parent` together, child's columns directly before parent's.
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

/// Hangs each front below the one that holds its first row.
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
  // Updates lie on a stack: the last child's is on top.
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

}  // namespace kirireel
