#include "render/fea/patch_deck.h"

namespace kirireel {

PatchDeck::PatchDeck(const ElementMesh& mesh, Solver solver) : mesh_(mesh), solver_(solver) {
  if (mesh.rule.joints != JointStyle::Patch) return;
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) addNode(c);
  for (std::size_t c = 0; c < mesh.clusters.size(); ++c) {
    own_.emplace_back(mesh.clusters[c].patches.size(), -1);
    if (solver == Solver::Calculix) continue;
    own_[c][0] = referenceNode(mesh, c);
    for (std::size_t k = 1; k < own_[c].size(); ++k) own_[c][k] = addNode(c);
  }
  placed_ = nodes_.size();
  if (solver == Solver::Abaqus) return;
  for (const PatchSpring& spring : mesh.springs) {
    for (const int patch : {spring.patchA, spring.patchB}) {
      int& own = own_[spring.cluster][patch];
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
  const double moment = scale.stress * scale.length * scale.length * scale.length;
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
    if (spring.moment == 0) continue;
    for (const auto& [patch, moment] :
         {std::pair{spring.patchA, -spring.moment}, {spring.patchB, spring.moment}}) {
      append(text, "{}, {}, {}\n", turningNode(spring.cluster, patch) + 1, axis(),
             deckNumber(unitMoment * moment));
    }
  }
}

}  // namespace kirireel
