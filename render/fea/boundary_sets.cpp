#include "render/fea/boundary_sets.h"

#include <algorithm>
#include <limits>

namespace kirireel {
namespace {

constexpr double kSamePlane = 1e-6;  ///< of the sheet's size
constexpr double kFlat = 1e-3;       ///< of the size: a sheet whose tiles lie side by side
constexpr const char* kPlanes[] = {"XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"};

Eigen::AlignedBox3d boxOf(const std::vector<Vector3>& nodes) {
  Eigen::AlignedBox3d box;
  for (const Vector3& node : nodes) box.extend(node);
  return box;
}

/// Whether all bottoms lie in one plane across the axis.
bool isFlatAcross(const ElementMesh& mesh, int axis, double size) {
  double least = std::numeric_limits<double>::infinity();
  double most = -least;
  for (const TileElements& tile : mesh.tiles) {
    for (const int node : tile.bottom) {
      least = std::min(least, mesh.nodes[node][axis]);
      most = std::max(most, mesh.nodes[node][axis]);
    }
  }
  return most - least <= kFlat * size;
}

/// The nodes that a boundary condition may hold, with their positions.
std::vector<std::pair<int, Vector3>> freeNodes(const ElementMesh& mesh) {
  const std::vector<bool> follows = followers(mesh);
  std::vector<std::pair<int, Vector3>> nodes;
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    if (!follows[k]) nodes.emplace_back(static_cast<int>(k), mesh.nodes[k]);
  }
  if (mesh.rule.joints == JointStyle::Patch) {
    for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
      nodes.emplace_back(referenceNode(mesh, c), referencePosition(mesh, c));
    }
  }
  return nodes;
}

}  // namespace

std::vector<NamedNodes> boundarySets(const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxOf(mesh.nodes);
  const double size = box.sizes().norm();
  const bool isFlat = isFlatAcross(mesh, 2, size);
  const int axes = isFlat ? 2 : 3;
  std::vector<NamedNodes> sets(2 * axes + 1);
  for (int k = 0; k < 2 * axes; ++k) sets[k].name = kPlanes[k];
  sets.back().name = "BOXCORNERS";
  for (const auto& [node, position] : freeNodes(mesh)) {
    int across = 0;
    for (int axis = 0; axis < axes; ++axis) {
      const bool isLeast = position[axis] - box.min()[axis] <= kSamePlane * size;
      const bool isMost = box.max()[axis] - position[axis] <= kSamePlane * size;
      if (isLeast) sets[2 * axis].nodes.push_back(node);
      if (isMost) sets[2 * axis + 1].nodes.push_back(node);
      across += isLeast || isMost ? 1 : 0;
    }
    if (across == axes) sets.back().nodes.push_back(node);
  }
  return sets;
}

int longestAxis(const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxOf(mesh.nodes);
  const int axes = isFlatAcross(mesh, 2, box.sizes().norm()) ? 2 : 3;
  int axis = 0;
  box.sizes().head(axes).maxCoeff(&axis);
  return axis;
}

}  // namespace kirireel
