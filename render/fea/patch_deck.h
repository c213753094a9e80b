/// Rigid patches at joints, and springs between them, as the decks of CalculiX and Abaqus have
/// them.
#pragma once

#include <string>
#include <vector>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"

namespace kirireel {

/// The rigid patches of a mesh with the nodes that they turn about, numbered after the mesh's own.
/// In CalculiX the patches of a joint share one node, and the rotation of a patch that has a spring
/// is that of a further node (ROT NODE). In Abaqus a node governs one rigid body, so that each
/// patch has its own, and *MPC pins them together; the first of a joint is the one that may be
/// held.
class PatchDeck {
 public:
  /// The mesh must outlive this. Makes no node where the mesh has no patches.
  PatchDeck(const ElementMesh& mesh, Solver solver);

  /// The positions of the further nodes; none where the mesh has no patches.
  const std::vector<Vector3>& nodes() const { return nodes_; }

  /// How many of them have displacements; the rotations of others are displacements of theirs.
  std::size_t placedCount() const { return placed_; }

  /// Appends the patches' sets, the rigid bodies and their pins. Sets are PATCH_00000_0: cluster
  /// and patch, from 0.
  void appendBodies(std::string& text) const;

  /// Appends springs between patches, *ELEMENT and *SPRING, in this unit. Stiffness becomes N
  /// mm/rad in millimetres.
  void appendSprings(std::string& text, DeckUnit unit) const;

  /// Appends the moments by which springs that are not at rest pull in the mesh's state, as rows of
  /// *CLOAD; nothing where all are at rest.
  void appendMoments(std::string& text, DeckUnit unit) const;

 private:
  int addNode(std::size_t cluster);
  /// The node, from 0, whose displacement or rotation `axis()` is the turn of a patch about z.
  int turningNode(int cluster, int patch) const;
  int axis() const { return solver_ == Solver::Calculix ? 3 : 6; }

  const ElementMesh& mesh_;
  Solver solver_;
  std::vector<Vector3> nodes_;
  std::size_t placed_ = 0;
  /// By cluster and patch, from 0: in Abaqus the body's own node, in CalculiX its ROT NODE or -1.
  std::vector<std::vector<int>> own_;
};

}  // namespace kirireel
