/// Corners of tiles that meet in joints: found, merged, or given rigid patches.
#pragma once

#include <vector>

#include "render/fea/element_mesh.h"

namespace kirireel {

/// The least distance between two of the points, infinite for less than two. Compares all pairs.
double leastDistance(const std::vector<Vector3>& points);

/// The nodes of each joint. Throws InputError for a joint that no deck can hold. That is any joint
/// but a pivot. One entry a joint, in their order.
std::vector<JointNodes> jointNodes(const std::vector<Joint>& joints,
                                   const std::vector<TileElements>& tiles);

/// The nodes that the mesh's joints bring together, before any are merged. Throws InputError when
/// two of them belong to one tile. In order of their lowest node; patches are empty.
std::vector<NodeCluster> findClusters(const ElementMesh& mesh);

/// Makes one node of each cluster, at the mean of its corners, and numbers the nodes anew without
/// gaps. What is left are clusters of shells on one face, which must not share nodes. Positions of
/// all other nodes keep their last bit.
void mergeClusters(ElementMesh& mesh);

/// Gives each node of each cluster its patch. Throws InputError when a patch holds fewer than three
/// nodes (`leastPerEdge` elements along each edge would do, it says) or two of them overlap.
void spreadPatches(ElementMesh& mesh, int leastPerEdge);

}  // namespace kirireel
