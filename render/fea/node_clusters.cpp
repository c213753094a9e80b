// Corners that joints hold together are found by joint, never by place: corners of tiles that
// merely touch stay apart, and corners that the simulation left a gap between are joined all the
// same.
//
// 1. Each joint names pairs of nodes (jointNodes): one on the bottom, one on the top, or all
// through the thickness. 2. Pairs that share a node grow together to clusters (union-find with path
// halving, R. E. Tarjan, J. van Leeuwen, Worst-case analysis of set union algorithms, J. ACM 31,
// 1984). Three tiles round one corner make a cluster of three. 3. A cluster is merged (shared
// nodes), left as it is (equations) or given patches.
//
// A merged corner lies at the mean of its corners, m = sum x_i / n, so none of its tiles is
// preferred. The gap, the largest |x_i - x_j|, is reported.
//
// A patch holds the nodes on the corner's face of the tile within the radius r of the corner. Its
// three or more nodes make it a rigid body that can turn. Forces through a single node would depend
// on the size of elements without limit; forces through a patch of fixed radius converge.
#include "render/fea/node_clusters.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// Sets of nodes that grow together; each is known by its lowest node.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  /// The lowest number stays the root, so that clusters and their order depend on the mesh alone
  /// and not on the order of joints.
  int lowest(int node) {
    while (parent_[node] != node) {
      parent_[node] = parent_[parent_[node]];
      node = parent_[node];
    }
    return node;
  }

  void join(int a, int b) {
    const auto [low, high] = std::minmax({lowest(a), lowest(b)});
    parent_[high] = low;
  }

 private:
  std::vector<int> parent_;
};

/// Edges run from the bottom to the top; a shell has one node there.
std::vector<int> nodesAt(const std::vector<int>& edge, JointFace face) {
  if (face == JointFace::Bottom) return {edge.front()};
  if (face == JointFace::Top) return {edge.back()};
  return edge;
}

void joinAll(const JointNodes& joint, JointStyle style, DisjointSets& sets) {
  for (std::size_t k = 0; k < joint.a.size(); ++k) {
    // Patches lie on the two faces; nothing in between is held.
    const bool isInside = k > 0 && k + 1 < joint.a.size();
    if (style == JointStyle::Patch && isInside) continue;
    sets.join(joint.a[k], joint.b[k]);
  }
}

/// The tile of each node; nodes are not merged yet.
std::vector<int> tilesOfNodes(const ElementMesh& mesh) {
  std::vector<int> owner(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    for (const int node : mesh.tiles[t].nodes) owner[node] = static_cast<int>(t);
  }
  return owner;
}

/// Of all pairs: clusters have few nodes.
double largestDistance(const std::vector<int>& nodes, const std::vector<Vector3>& positions) {
  double largest = 0;
  for (const int a : nodes) {
    for (const int b : nodes) largest = std::max(largest, (positions[a] - positions[b]).norm());
  }
  return largest;
}

/// Merging two corners of one tile would fold it.
void requireDifferentTiles(const NodeCluster& cluster, const std::vector<int>& owner,
                           int countsFrom) {
  std::vector<int> tiles;
  for (const int node : cluster.nodes) tiles.push_back(owner[node]);
  std::ranges::sort(tiles);
  const auto twice = std::ranges::adjacent_find(tiles);
  if (twice == tiles.end()) return;
  throw InputError(
      fmt::format("error: the joints tie two corners of tile {} together, {:.3g} m apart; a mesh "
                  "can hold only different tiles together: remove one of these joints",
                  *twice + countsFrom, cluster.gap));
}

void renumber(std::vector<int>& nodes, const std::vector<int>& numbers) {
  for (int& node : nodes) node = numbers[node];
}

/// Only what exists when clusters are merged: patches and springs come later.
void renumberAll(ElementMesh& mesh, const std::vector<int>& numbers) {
  for (Element& element : mesh.elements) {
    const int count = nodeCount(mesh.rule);
    for (int k = 0; k < count; ++k) element.nodes[k] = numbers[element.nodes[k]];
  }
  for (TileElements& tile : mesh.tiles) {
    for (std::vector<int>* nodes : {&tile.nodes, &tile.bottom, &tile.top}) {
      renumber(*nodes, numbers);
      std::ranges::sort(*nodes);
    }
    for (std::vector<int>& edge : tile.edges) renumber(edge, numbers);
  }
  for (JointNodes& joint : mesh.joints) {
    renumber(joint.a, numbers);
    renumber(joint.b, numbers);
  }
  for (NodeCluster& cluster : mesh.clusters) renumber(cluster.nodes, numbers);
}

Vector3 meanOf(const std::vector<int>& nodes, const std::vector<Vector3>& positions) {
  Vector3 sum = Vector3::Zero();
  for (const int node : nodes) sum += positions[node];
  return sum / static_cast<double>(nodes.size());
}

/// A node at the radius itself belongs to the patch, whatever the rounding.
constexpr double kRoundedUp = 1 + 1e-9;

/// A corner node on the bottom takes nodes of the bottom alone; a patch through the thickness would
/// stiffen the tile.
std::vector<int> patchAround(const ElementMesh& mesh, const TileElements& tile, int corner) {
  const bool isBottom = std::ranges::binary_search(tile.bottom, corner);
  std::vector<int> patch;
  for (const int node : isBottom ? tile.bottom : tile.top) {
    const double distance = (mesh.nodes[node] - mesh.nodes[corner]).norm();
    if (distance <= kRoundedUp * mesh.rule.patchRadius) patch.push_back(node);
  }
  return patch;
}

void requireEnough(const std::vector<int>& patch, int tile, const ElementMesh& mesh,
                   int leastPerEdge) {
  if (patch.size() >= 3) return;
  throw InputError(
      fmt::format("error: a joint patch of radius {:.4g} m holds {} nodes of tile {}, at least 3 "
                  "are needed; use {} elements per edge or a larger radius",
                  mesh.rule.patchRadius, patch.size(), tile + mesh.rule.countsFrom, leastPerEdge));
}

/// A node can belong to one rigid body only. `isTaken` collects those of all tiles so far.
void requireApart(const std::vector<int>& patch, int tile, const ElementMesh& mesh,
                  std::vector<bool>& isTaken) {
  for (const int node : patch) {
    if (isTaken[node]) {
      std::vector<Vector3> corners;
      for (const auto& edge : mesh.tiles[tile].edges) corners.push_back(mesh.nodes[edge.front()]);
      throw InputError(fmt::format(
          "error: joint patches of radius {:.4g} m overlap on tile {}; choose one "
          "below {:.4g} m, half the distance of its nearest corners",
          mesh.rule.patchRadius, tile + mesh.rule.countsFrom, 0.5 * leastDistance(corners)));
    }
    isTaken[node] = true;
  }
}

}  // namespace

double leastDistance(const std::vector<Vector3>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) least = std::min(least, (points[a] - points[b]).norm());
  }
  return least;
}

std::vector<JointNodes> jointNodes(const std::vector<Joint>& joints,
                                   const std::vector<TileElements>& tiles) {
  std::vector<JointNodes> nodes;
  for (const Joint& joint : joints) {
    if (joint.kind != JointKind::Pivot) {
      throw InputError(
          fmt::format("error: joint {} does not hold two corners together; a mesh can "
                      "hold pivots alone",
                      nodes.size()));
    }
    nodes.push_back({joint.a.tile, joint.b.tile, joint.face == JointFace::Both,
                     nodesAt(tiles[joint.a.tile].edges[joint.a.vertex], joint.face),
                     nodesAt(tiles[joint.b.tile].edges[joint.b.vertex], joint.face)});
  }
  return nodes;
}

std::vector<NodeCluster> findClusters(const ElementMesh& mesh) {
  DisjointSets sets(mesh.nodes.size());
  for (const JointNodes& joint : mesh.joints) joinAll(joint, mesh.rule.joints, sets);
  std::vector<int> place(mesh.nodes.size(), -1);
  std::vector<NodeCluster> clusters;
  for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node) {
    const int lowest = sets.lowest(node);
    // The lowest itself enters with the first node that is joined to it; single nodes make no
    // cluster.
    if (lowest == node) continue;
    if (place[lowest] < 0) {
      place[lowest] = static_cast<int>(clusters.size());
      clusters.push_back({{lowest}, {}, 0});
    }
    clusters[place[lowest]].nodes.push_back(node);
  }
  std::ranges::sort(clusters, {}, [](const NodeCluster& cluster) { return cluster.nodes[0]; });
  const std::vector<int> owner = tilesOfNodes(mesh);
  for (NodeCluster& cluster : clusters) {
    cluster.gap = largestDistance(cluster.nodes, mesh.nodes);
    requireDifferentTiles(cluster, owner, mesh.rule.countsFrom);
  }
  return clusters;
}

void mergeClusters(ElementMesh& mesh) {
  std::vector<int> lowest(mesh.nodes.size());
  std::iota(lowest.begin(), lowest.end(), 0);
  const std::vector<int> owner = tilesOfNodes(mesh);
  // Clusters of shells in the middle come first and are merged; those of shells on a face stay.
  const auto kept = std::ranges::stable_partition(mesh.clusters, [&](const NodeCluster& cluster) {
    return mesh.tiles[owner[cluster.nodes[0]]].level == 0.5;
  });
  for (auto cluster = mesh.clusters.begin(); cluster != kept.begin(); ++cluster) {
    for (const int node : cluster->nodes) lowest[node] = cluster->nodes[0];
    mesh.nodes[cluster->nodes[0]] = meanOf(cluster->nodes, mesh.nodes);
  }
  mesh.clusters.erase(mesh.clusters.begin(), kept.begin());
  // A follower's lowest node is before it, so its new number is known already.
  std::vector<int> numbers(mesh.nodes.size());
  std::vector<Vector3> positions;
  for (std::size_t node = 0; node < lowest.size(); ++node) {
    const bool isLowest = lowest[node] == static_cast<int>(node);
    numbers[node] = isLowest ? static_cast<int>(positions.size()) : numbers[lowest[node]];
    if (isLowest) positions.push_back(mesh.nodes[node]);
  }
  mesh.nodes = std::move(positions);
  renumberAll(mesh, numbers);
}

void spreadPatches(ElementMesh& mesh, int leastPerEdge) {
  const std::vector<int> owner = tilesOfNodes(mesh);
  std::vector<bool> isTaken(mesh.nodes.size());
  for (NodeCluster& cluster : mesh.clusters) {
    for (const int corner : cluster.nodes) {
      const int tile = owner[corner];
      cluster.patches.push_back(patchAround(mesh, mesh.tiles[tile], corner));
      requireEnough(cluster.patches.back(), tile, mesh, leastPerEdge);
      requireApart(cluster.patches.back(), tile, mesh, isTaken);
    }
  }
}

}  // namespace kirireel
