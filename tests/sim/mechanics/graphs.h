/// Graphs of joined tiles on which the factorisation is tested.
#pragma once

#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace kirireel::test {

struct Graph {
  std::string name;
  int nodeCount = 0;
  std::vector<std::pair<int, int>> edges;
};

inline Graph gridGraph(int columns, int rows) {
  Graph graph{"grid", columns * rows, {}};
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const int node = i * rows + j;
      if (i + 1 < columns) graph.edges.emplace_back(node, node + rows);
      if (j + 1 < rows) graph.edges.emplace_back(node + 1, node);  // either order is allowed
    }
  }
  return graph;
}

/// Distinct edges between random pairs. Nodes may have no edge.
inline Graph randomGraph(int nodeCount, int edgeCount, unsigned seed) {
  std::mt19937 generator(seed);
  std::set<std::pair<int, int>> edges;
  while (static_cast<int>(edges.size()) < edgeCount) {
    const int a = static_cast<int>(generator() % nodeCount);
    const int b = static_cast<int>(generator() % nodeCount);
    if (a != b && !edges.contains({b, a})) edges.insert({a, b});
  }
  return {"random " + std::to_string(seed), nodeCount, {edges.begin(), edges.end()}};
}

inline std::vector<Graph> sampleGraphs() {
  Graph path{"path", 12, {}};
  Graph star{"star", 9, {}};
  Graph complete{"complete", 8, {}};
  for (int i = 0; i + 1 < path.nodeCount; ++i) path.edges.emplace_back(i + 1, i);
  for (int i = 0; i < star.nodeCount; ++i) {
    if (i != 4) star.edges.emplace_back(4, i);
  }
  for (int i = 0; i < complete.nodeCount; ++i) {
    for (int j = 0; j < i; ++j) complete.edges.emplace_back(i, j);
  }
  std::vector<Graph> graphs{{"single node", 1, {}},
                            {"no edges", 5, {}},
                            {"two pieces", 5, {{0, 3}, {4, 1}}},
                            {"same edge twice", 3, {{0, 1}, {1, 2}, {0, 1}}},
                            path,
                            star,
                            complete,
                            gridGraph(7, 6)};
  for (unsigned seed = 1; seed <= 6; ++seed) graphs.push_back(randomGraph(20, 8 * seed, seed));
  return graphs;
}

}  // namespace kirireel::test
