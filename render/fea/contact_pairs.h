/// Flanks of tiles that may touch, for analyses with contact.
#pragma once

#include <string>
#include <vector>

#include "render/fea/deck_text.h"
#include "render/fea/element_mesh.h"

namespace kirireel {

/// Two flanks that face each other across the gap beside a joint.
struct ContactPair {
  std::vector<ElementFace> a;
  std::vector<ElementFace> b;
};

/// For each joint the flanks on both sides of its corner, each pair once: what meets when the sheet
/// closes. Faces with nodes of joints are left out, whose displacements joints determine. Throws
/// InputError for meshes that have no such flanks: shells, plane elements, sheets with necks, and
/// elements so long that all faces touch a joint. Faces of a pair are in the order of the tile's
/// sides. The cost is that of a search through the corners of each joint's tiles, and sorting.
std::vector<ContactPair> contactPairs(const ElementMesh& mesh);

/// Appends the surfaces CONTACT_00000_A and _B of each pair. Nothing where there are no pairs.
/// Element numbers in the deck count from 1.
void appendContactSurfaces(std::string& text, const std::vector<ContactPair>& pairs);

/// Appends the interaction FLANKS and the pairs. With CalculiX contact is a penalty, E / t per
/// metre of overclosure and a hundredth of that where flanks stick; friction is Coulomb's
/// coefficient, from 0. Thickness in metres. They belong between the material and the first step.
void appendContactCards(std::string& text, std::size_t pairs, const DeckSettings& settings,
                        double thickness);

}  // namespace kirireel
