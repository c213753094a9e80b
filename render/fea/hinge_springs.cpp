// Rigid patches have rotations, elements have none: a spring joins the rotations about z of the
// patches of two tiles. It is linear in the angle from the mesh's state on, whatever the angle, and
// the moment that it has in that state is a load besides:
//
//     moment = k (rest - angle) = k (rest - angle of the state) - k (turn since the state).
//
// k is the stiffness (N m/rad), "rest" the angle at which the spring pulls with nothing and "angle"
// that of the hinge in the run (rad). The first term is a constant moment (*CLOAD), the second is
// the spring element of the deck, which rests in the mesh's state. So both programs need no
// pre-stressed spring.
//
// A hinge through the thickness has a patch on the bottom and one on the top at each of its tiles.
// The stiffness is shared evenly among them.
#include "render/fea/hinge_springs.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

/// The patch of a cluster that lies on a tile, or -1.
int patchOn(const ElementMesh& mesh, const NodeCluster& cluster, int tile) {
  for (std::size_t k = 0; k < cluster.patches.size(); ++k) {
    if (std::ranges::binary_search(mesh.tiles[tile].nodes, cluster.nodes[k])) {
      return static_cast<int>(k);
    }
  }
  return -1;
}

/// The places of a spring between two tiles, without its stiffness. Looks through all clusters for
/// each spring: their number times that of springs.
std::vector<PatchSpring> placesBetween(const ElementMesh& mesh, int tileA, int tileB) {
  std::vector<PatchSpring> places;
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    const int patchA = patchOn(mesh, mesh.clusters[c], tileA);
    const int patchB = patchOn(mesh, mesh.clusters[c], tileB);
    if (patchA >= 0 && patchB >= 0) places.push_back({static_cast<int>(c), patchA, patchB});
  }
  return places;
}

}  // namespace

int addHingeSprings(ElementMesh& mesh, std::span<const HingeSpring> springs, const Poses& poses) {
  // A sine: the deck's springs turn about z alone, and a hinge within a micrometre a metre of
  // upright is meant to be.
  constexpr double kUpright = 1e-6;
  const std::vector<double> moments = hingeMoments(springs, poses);
  int left = 0;
  for (std::size_t k = 0; k < springs.size(); ++k) {
    const HingeSpring& spring = springs[k];
    if (spring.stiffness == 0) continue;
    const Vector3 axis = poses[spring.hinge.brickA].rotation * spring.hinge.axis;
    std::vector<PatchSpring> places;
    if (std::hypot(axis.x(), axis.y()) <= kUpright) {
      places = placesBetween(mesh, spring.hinge.brickA, spring.hinge.brickB);
    }
    // The caller warns of those that are left out.
    if (places.empty()) ++left;
    const double share = 1.0 / static_cast<double>(std::max<std::size_t>(places.size(), 1));
    for (PatchSpring& place : places) {
      place.stiffness = share * spring.stiffness;
      // A hinge whose axis points down counts its angle the other way round.
      place.moment = share * std::copysign(1, axis.z()) * moments[k];
      mesh.springs.push_back(place);
    }
  }
  return left;
}

}  // namespace kirireel
