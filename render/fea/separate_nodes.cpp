// Nodes are sorted by their places along a direction that no grid has, so that only neighbours in
// that order need to be compared. Where tiles overlap, both nodes may move alike: then one of them
// moves on.
//
// Let s be the diagonal of the box round the nodes. Two nodes are in one place when they are less
// than 4e-8 s apart. Such a node moves by 1e-7 s towards the mean of its elements' middles, within
// the plane of its tile, so that it stays on the tile's face; one bank of a slit moves one way, the
// other bank the other way.
//
// The projections along the direction (1, sqrt 2, sqrt 3) / sqrt 6 of nodes that are d apart differ
// by d at most, so a node is compared with those whose projections are within 4e-8 s. In a grid,
// nodes of one row or column have different projections, and such a list is short: n log n in all.
#include "render/fea/separate_nodes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace kirireel {
namespace {

constexpr double kMove = 1e-7;      ///< of the sheet's size
constexpr double kOnePlace = 4e-8;  ///< of the size; less than two moves, or some would collide

double sizeOf(const std::vector<Vector3>& nodes) {
  Eigen::AlignedBox3d box;
  for (const Vector3& node : nodes) box.extend(node);
  return nodes.empty() ? 0 : box.sizes().norm();
}

/// For each node whether another lies in its place; `laterAlone`: another one before it.
std::vector<bool> isAmongOthers(const std::vector<Vector3>& nodes, double tolerance,
                                bool laterAlone) {
  const Vector3 direction = Vector3(1, std::sqrt(2.0), std::sqrt(3.0)) / std::sqrt(6.0);
  std::vector<double> along(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) along[k] = direction.dot(nodes[k]);
  std::vector<int> order(nodes.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int node) { return std::pair(along[node], node); });
  std::vector<bool> found(nodes.size());
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = a + 1; b < order.size(); ++b) {
      if (along[order[b]] - along[order[a]] > tolerance) break;
      if ((nodes[order[a]] - nodes[order[b]]).norm() > tolerance) continue;
      found[std::max(order[a], order[b])] = true;
      if (!laterAlone) found[std::min(order[a], order[b])] = true;
    }
  }
  return found;
}

/// The middle of four corners of an element.
Vector3 middleOf(const ElementMesh& mesh, const Element& element, int first) {
  Vector3 sum = Vector3::Zero();
  for (int k = first; k < first + 4; ++k) sum += mesh.nodes[element.nodes[k]];
  return sum / 4;
}

/// The direction from a node into an element, in the plane of its tile.
Vector3 inwards(const ElementMesh& mesh, const Element& element, int node) {
  const Vector3 bottom = middleOf(mesh, element, 0);
  Vector3 way = bottom - mesh.nodes[node];
  if (mesh.rule.family == ElementFamily::Solid) {
    // The part of the way along the thickness is taken out.
    const Vector3 up = (middleOf(mesh, element, 4) - bottom).normalized();
    way -= up.dot(way) * up;
  }
  return way.normalized();
}

}  // namespace

std::vector<Vector3> separatedNodes(const ElementMesh& mesh) {
  constexpr int kPasses = 4;
  const double size = sizeOf(mesh.nodes);
  std::vector<Vector3> nodes = mesh.nodes;
  for (int pass = 0; pass < kPasses; ++pass) {
    // From the second pass on only the later of two nodes moves, since both together would meet
    // again.
    const std::vector<bool> moves = isAmongOthers(nodes, kOnePlace * size, pass > 0);
    if (std::ranges::find(moves, true) == moves.end()) break;
    std::vector<Vector3> ways(nodes.size(), Vector3::Zero());
    for (const Element& element : mesh.elements) {
      for (int k = 0; k < nodeCount(mesh.rule); ++k) {
        const int node = element.nodes[k];
        if (moves[node]) ways[node] += inwards(mesh, element, node);
      }
    }
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      if (moves[k]) nodes[k] += kMove * size * ways[k].normalized();
    }
  }
  return nodes;
}

}  // namespace kirireel
