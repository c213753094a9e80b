// Finds the nodes that a user is likely to hold or to load: those in the six planes of the box
// round the sheet.
//
// The box is that of all nodes, followers too. With lo and hi its corners, s its diagonal (all
// metres) and x a node's coordinate along an axis, the node lies
//
//     in MIN where x - lo <= 1e-6 s,    in MAX where hi - x <= 1e-6 s.
//
// A node that follows others (by *EQUATION, a rigid patch or a tie) is left out: CalculiX and
// Abaqus refuse a displacement that is prescribed at a dependent node. Reference nodes of patches
// stand in for the nodes that they lead.
//
// Planes of the box, and not the outline of the sheet, are what is named, since a load on a plane
// can be described to a reader in one word; a round sheet has few nodes there, which jobs allow
// for.
#include "render/fea/boundary_sets.h"

#include <algorithm>
#include <limits>

namespace kirireel {
namespace {

/// It lies between the rounding of poses and the length of the shortest elements.
constexpr double kSamePlane = 1e-6;  ///< of the sheet's size
constexpr double kFlat = 1e-3;       ///< of the size: a sheet whose tiles lie side by side
/// By axis, then MIN before MAX: plane k is across axis k / 2.
constexpr const char* kPlanes[] = {"XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"};

/// Empty (its minimum above its maximum) where there are no nodes.
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
  // Numbers of reference nodes are beyond mesh.nodes, so their positions come along here.
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
  // In a flat sheet ZMIN and ZMAX would hold every node of the two faces. They name nothing there.
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
    // A corner of the box lies in a plane across each axis.
    if (across == axes) sets.back().nodes.push_back(node);
  }
  return sets;
}

int longestAxis(const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxOf(mesh.nodes);
  const int axes = isFlatAcross(mesh, 2, box.sizes().norm()) ? 2 : 3;
  int axis = 0;
  // Of equal extents the first counts, so that squares are pulled along x.
  box.sizes().head(axes).maxCoeff(&axis);
  return axis;
}

}  // namespace kirireel
