#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/mechanics/block_cholesky.h"
#include "tests/sim/mechanics/graphs.h"

namespace kirireel {
namespace {

using test::Graph;

/// All rows of a front: its own columns, then those below.
std::vector<int> frontRows(const mechanics::Supernode& node) {
  std::vector<int> rows;
  for (int c = 0; c < node.columnCount; ++c) rows.push_back(node.firstColumn + c);
  rows.insert(rows.end(), node.rows.begin(), node.rows.end());
  return rows;
}

/// The sample graphs with their plans.
struct Planned {
  Graph graph;
  mechanics::Elimination plan = mechanics::planElimination(graph.nodeCount, graph.edges);
};

std::vector<Planned> samplePlans() {
  std::vector<Planned> plans;
  for (const Graph& graph : test::sampleGraphs()) plans.push_back({graph});
  return plans;
}

TEST(Elimination, PlacesAreAPermutation) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    std::vector<int> places = plan.place;
    std::sort(places.begin(), places.end());
    ASSERT_EQ(static_cast<int>(places.size()), graph.nodeCount);
    for (int i = 0; i < graph.nodeCount; ++i) EXPECT_EQ(places[i], i);
  }
}

TEST(Elimination, SupernodesPartitionTheColumnsInOrder) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    int next = 0;
    for (const mechanics::Supernode& node : plan.supernodes) {
      EXPECT_EQ(node.firstColumn, next);
      EXPECT_GE(node.columnCount, 1);
      next += node.columnCount;
    }
    EXPECT_EQ(next, graph.nodeCount);
  }
}

TEST(Elimination, RowsAscendBelowTheColumns) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    for (const mechanics::Supernode& node : plan.supernodes) {
      const std::vector<int> rows = frontRows(node);
      EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end()));
      EXPECT_TRUE(std::adjacent_find(rows.begin(), rows.end()) == rows.end());
      EXPECT_LT(rows.back(), graph.nodeCount);
    }
  }
}

TEST(Elimination, EveryPairHasAPlaceInItsFront) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    for (const auto& [a, b] : graph.edges) {
      const auto [column, row] = std::minmax(plan.place[a], plan.place[b]);
      const auto after = std::upper_bound(plan.supernodes.begin(), plan.supernodes.end(), column,
                                          [](int expected, const mechanics::Supernode& node) {
                                            return expected < node.firstColumn;
                                          });
      const std::vector<int> rows = frontRows(*std::prev(after));
      EXPECT_TRUE(std::binary_search(rows.begin(), rows.end(), row));
    }
  }
}

TEST(Elimination, ChildrenComeBeforeTheirOnlyParent) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    std::vector<int> parents(plan.supernodes.size(), 0);
    for (std::size_t s = 0; s < plan.supernodes.size(); ++s) {
      for (const int child : plan.supernodes[s].children) {
        EXPECT_LT(child, static_cast<int>(s));
        ++parents[child];
      }
    }
    for (std::size_t s = 0; s < plan.supernodes.size(); ++s) {
      EXPECT_EQ(parents[s], plan.supernodes[s].rows.empty() ? 0 : 1);
    }
  }
}

TEST(Elimination, ChildPlacesPointAtTheChildsRows) {
  for (const auto& [graph, plan] : samplePlans()) {
    SCOPED_TRACE(graph.name);
    for (const mechanics::Supernode& node : plan.supernodes) {
      const std::vector<int> rows = frontRows(node);
      ASSERT_EQ(node.childPlaces.size(), node.children.size());
      for (std::size_t c = 0; c < node.children.size(); ++c) {
        const std::vector<int>& expected = plan.supernodes[node.children[c]].rows;
        ASSERT_EQ(node.childPlaces[c].size(), expected.size());
        for (std::size_t k = 0; k < expected.size(); ++k) {
          const int place = node.childPlaces[c][k];
          ASSERT_TRUE(place >= 0 && place < static_cast<int>(rows.size()));
          EXPECT_EQ(rows[place], expected[k]);
        }
      }
    }
  }
}

/// Blocks in the factor: each supernode's triangle and the rows below it.
double factorBlocks(const mechanics::Elimination& plan) {
  double sum = 0;
  for (const mechanics::Supernode& node : plan.supernodes) {
    sum += node.columnCount * (0.5 * (node.columnCount + 1) + node.rows.size());
  }
  return sum;
}

TEST(Elimination, FillGrowsAsNLogNOnSheets) {
  // Nested dissection of a grid fills less than 31/4 n log2 n (George 1973).
  for (const int side : {10, 20, 40}) {
    const Graph graph = test::gridGraph(side, side);
    const double n = graph.nodeCount;
    const double blocks = factorBlocks(mechanics::planElimination(graph.nodeCount, graph.edges));
    EXPECT_LT(blocks, 2 * n * std::log2(n)) << side;  // measured 1.59 at 40 x 40
  }
}

TEST(Elimination, ATreeFillsNothing) {
  Graph path{"path", 200, {}};
  for (int i = 0; i + 1 < path.nodeCount; ++i) path.edges.emplace_back(i, i + 1);
  // Merging small fronts may store some zeros, at most a third.
  EXPECT_LT(factorBlocks(mechanics::planElimination(path.nodeCount, path.edges)), 1.5 * 399);
}

}  // namespace
}  // namespace kirireel
