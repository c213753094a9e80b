// The same mechanics in two dialects. Let a cluster have the patches 0 to m - 1, each a set of
// nodes that moves as a rigid body, u = u_ref + R (x - x_ref) - (x - x_ref).
//
// CalculiX: *RIGID BODY, NSET=, REF NODE=, ROT NODE=. Patches that name the same REF NODE share its
// displacement, and have rotations of their own. Where something acts on a rotation (springs,
// moments), a ROT NODE is named, whose displacements 1 to 3 are the rotation about x, y and z in
// radians.
//
// Abaqus: *RIGID BODY, PIN NSET=, REF NODE=. A reference node has the displacements 1 to 3 and the
// rotations 4 to 6 of its one body. *MPC PIN makes the displacements of the first and the second
// node equal, so that bodies share a point and turn freely.
//
// A spring is SPRING2 between two nodes and one degree of freedom each: 3 of ROT NODEs in CalculiX,
// 6 of reference nodes in Abaqus, both the turn about z. The deck's moment is force times length: N
// m is 1e3 N mm.
#include "render/fea/patch_deck.h"

namespace kirireel {

PatchDeck::PatchDeck(const ElementMesh& mesh, Solver solver) : mesh_(mesh), solver_(solver) {
  if (mesh.rule.joints != JointStyle::Patch) return;
  // The shared nodes come first, one a cluster, which is what referenceNode() counts on.
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) addNode(c);
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    own_.emplace_back(mesh.clusters[c].patches.size(), -1);
    if (solver == Solver::Calculix) continue;
    // In Abaqus the shared node is the first patch's own.
    own_[c][0] = referenceNode(mesh, c);
    for (std::size_t k = 1; k < own_[c].size(); ++k) own_[c][k] = addNode(c);
  }
  // ROT NODEs come after all that have a place: users may hold those before.
  placed_ = nodes_.size();
  if (solver == Solver::Abaqus) return;
  for (const PatchSpring& spring : mesh.springs) {
    for (const int patch : {spring.patchA, spring.patchB}) {
      int& own = own_[spring.cluster][patch];
      // Only patches with springs need one.
      if (own < 0) own = addNode(spring.cluster);
    }
  }
}

int PatchDeck::addNode(std::size_t cluster) {
  nodes_.push_back(referencePosition(mesh_, cluster));
  return static_cast<int>(mesh_.nodes.size() + nodes_.size()) - 1;
}

int PatchDeck::turningNode(int cluster, int patch) const {
  return own_[cluster][patch];
}

void PatchDeck::appendBodies(std::string& text) const {
  std::string pins;
  for (std::size_t c = 0; c < own_.size(); ++c) {
    const int shared = referenceNode(mesh_, c) + 1;
    for (std::size_t k = 0; k < own_[c].size(); ++k) {
      const std::string name = fmt::format("PATCH_{:05}_{}", c, k);
      appendNodeSet(text, name, mesh_.clusters[c].patches[k]);
      const int own = own_[c][k] + 1;
      if (solver_ == Solver::Abaqus) {
        append(text, "*RIGID BODY, PIN NSET={}, REF NODE={}\n", name, own);
        // The first node of PIN is the dependent one, so what is held is the shared node.
        if (own != shared) append(pins, "PIN, {}, {}\n", own, shared);
      } else {
        append(text, "*RIGID BODY, NSET={}, REF NODE={}", name, shared);
        own > 0 ? append(text, ", ROT NODE={}\n", own) : append(text, "\n");
      }
    }
  }
  if (!pins.empty()) text += "*MPC\n" + pins;
}

void PatchDeck::appendSprings(std::string& text, DeckUnit unit) const {
  const UnitScale scale = unitScale(unit);
  // Stress times volume is a moment: 1e-6 * 1e9 = 1e3 N mm by N m.
  const double moment = scale.stress * scale.length * scale.length * scale.length;
  // Springs are elements too and count on after those of the mesh.
  std::size_t number = mesh_.elements.size();
  for (std::size_t k = 0; k < mesh_.springs.size(); ++k) {
    const PatchSpring& spring = mesh_.springs[k];
    append(text,
           "*ELEMENT, TYPE=SPRING2, ELSET=SPRING_{0:05}\n{1}, {2}, {3}\n"
           "*SPRING, ELSET=SPRING_{0:05}\n{4}, {4}\n{5}\n",
           k, ++number, turningNode(spring.cluster, spring.patchA) + 1,
           turningNode(spring.cluster, spring.patchB) + 1, axis(),
           deckNumber(moment * spring.stiffness));
  }
}

void PatchDeck::appendMoments(std::string& text, DeckUnit unit) const {
  const UnitScale scale = unitScale(unit);
  const double unitMoment = scale.stress * scale.length * scale.length * scale.length;
  for (const PatchSpring& spring : mesh_.springs) {
    // Equal and opposite on the two patches.
    if (spring.moment == 0) continue;
    for (const auto& [patch, moment] :
         {std::pair{spring.patchA, -spring.moment}, {spring.patchB, spring.moment}}) {
      append(text, "{}, {}, {}\n", turningNode(spring.cluster, patch) + 1, axis(),
             deckNumber(unitMoment * moment));
    }
  }
}

}  // namespace kirireel
