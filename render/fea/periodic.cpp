// A node b at XMAX follows its partner a at XMIN and the control node of x, u_b = u_a + u_cx. Nodes
// at a corner of the sheet follow one node and both control nodes, so that no node that follows is
// followed, which programs refuse: u_b = u_a + i u_cx + j u_cy with i and j of 0 or 1. The sheet's
// mean displacement gradient times the period is what a control node is moved by, and the reaction
// there is the force on that side (compare S. Li, A. Wongsto, Unit cells for micromechanical
// analyses of particle-reinforced composites, Mech. Mater. 36, 2004).
#include "render/fea/periodic.h"

#include <algorithm>
#include <map>
#include <optional>

#include "render/fea/boundary_sets.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// Below it corners that a run leaves apart still count as partners.
constexpr double kSamePlace = 1e-5;  ///< of the sheet's size, what a run leaves of symmetry

Eigen::AlignedBox3d boxAround(const ElementMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vector3& node : mesh.nodes) box.extend(node);
  return box;
}

/// For each node at one end the partner at the other; nothing where some have none. Compares each
/// node at one end with those at the other: the product of their numbers, which are small.
std::optional<std::vector<std::pair<int, int>>> partners(const ElementMesh& mesh, int axis,
                                                         const std::vector<int>& low,
                                                         const std::vector<int>& high) {
  const double tolerance = kSamePlace * boxAround(mesh).sizes().norm();
  if (low.empty() || low.size() != high.size()) return std::nullopt;
  std::vector<std::pair<int, int>> pairs;
  std::vector<bool> isTaken(high.size());
  for (const int node : low) {
    std::size_t found = 0;
    for (; found < high.size(); ++found) {
      Vector3 offset = mesh.nodes[high[found]] - mesh.nodes[node];
      // Only across the axis: along it the nodes lie a period apart.
      offset[axis] = 0;
      if (!isTaken[found] && offset.norm() <= tolerance) break;
    }
    if (found == high.size()) return std::nullopt;
    isTaken[found] = true;
    pairs.emplace_back(node, high[found]);
  }
  return pairs;
}

/// The mesh's own nodes of a set: reference nodes of patches are no part of its ends.
std::vector<int> ownNodes(const ElementMesh& mesh, const NamedNodes& set) {
  std::vector<int> nodes;
  std::ranges::copy_if(set.nodes, std::back_inserter(nodes),
                       [&](int node) { return node < static_cast<int>(mesh.nodes.size()); });
  return nodes;
}

}  // namespace

Periodicity periodicity(const ElementMesh& mesh) {
  if (mesh.rule.family == ElementFamily::Shell) {
    throw InputError(
        "error: --periodic ties the displacements of solids and plane elements; leave out "
        "--shells");
  }
  const std::vector<NamedNodes> ends = boundarySets(mesh);
  const Eigen::AlignedBox3d box = boxAround(mesh);
  Periodicity periodic;
  std::map<int, PeriodicTie> ties;
  for (const int axis : {0, 1}) {
    const auto pairs =
        partners(mesh, axis, ownNodes(mesh, ends[2 * axis]), ownNodes(mesh, ends[2 * axis + 1]));
    if (!pairs) continue;
    periodic.axes[axis] = true;
    periodic.period[axis] = box.sizes()[axis];
    for (const auto& [low, high] : *pairs) {
      // A node that follows along x already will follow its leader's leader, see below.
      if (ties.contains(high)) continue;
      PeriodicTie tie{high, low, {}};
      tie.times[axis] = 1;
      ties[high] = tie;
    }
  }
  for (auto& [node, tie] : ties) {
    // A leader must not follow: chains are walked to their end and the control nodes added up. They
    // end, since each tie leads to a smaller x or y.
    while (ties.contains(tie.leader)) {
      const PeriodicTie& next = ties.at(tie.leader);
      for (const int axis : {0, 1}) tie.times[axis] += next.times[axis];
      tie.leader = next.leader;
    }
  }
  for (const auto& [node, tie] : ties) periodic.ties.push_back(tie);
  if (!periodic.ties.empty()) return periodic;
  throw InputError(
      "error: --periodic ties opposite ends of a sheet, but in this state XMIN has other nodes "
      "than "
      "XMAX, and YMIN than YMAX; choose a state or a number of tiles in which the sheet repeats");
}

void appendTies(std::string& text, const Periodicity& periodic, const ElementMesh& mesh,
                int firstControl) {
  const std::array<int, 2> controls = {firstControl, firstControl + (periodic.axes[0] ? 1 : 0)};
  const int directions = mesh.rule.family == ElementFamily::Plane ? 2 : 3;
  for (const PeriodicTie& tie : periodic.ties) {
    for (int direction = 1; direction <= directions; ++direction) {
      // u_node - u_leader - i u_cx - j u_cy = 0, the dependent node first.
      append(text, "*EQUATION\n{}\n{}, {}, 1., {}, {}, -1.", 2 + tie.times[0] + tie.times[1],
             tie.node + 1, direction, tie.leader + 1, direction);
      for (const int axis : {0, 1}) {
        if (tie.times[axis] == 0) continue;
        append(text, ", {}, {}, -1.", controls[axis] + 1, direction);
      }
      text += '\n';
    }
  }
}

std::vector<Vector3> controlPositions(const Periodicity& periodic, const ElementMesh& mesh) {
  const Eigen::AlignedBox3d box = boxAround(mesh);
  std::vector<Vector3> positions;
  for (const int axis : {0, 1}) {
    if (!periodic.axes[axis]) continue;
    Vector3 position = box.center();
    // A tenth of the period outside, so that viewers show it apart from the sheet. Its place enters
    // no equation.
    position[axis] = box.max()[axis] + 0.1 * periodic.period[axis];
    if (mesh.rule.family == ElementFamily::Plane) position.z() = 0;
    positions.push_back(position);
  }
  return positions;
}

}  // namespace kirireel
