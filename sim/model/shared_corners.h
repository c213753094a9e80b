/// Joints as shared vertices: what mesh formats have in place of a list of joints.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/model/model.h"

namespace kirireel {

/// Vertex numbers of each tile's corners, from 0.
using CornerNumbers = std::vector<std::vector<int>>;

/// Joints on the bottom faces between corners with one number, in the order of these numbers: each
/// corner with the next, by tiles.
std::vector<Joint> jointsOfSharedNumbers(const CornerNumbers& numbers);

/// The same between corners of different tiles that coincide in every given state, as far as the
/// digits that they are written with can tell (samePlaceTolerance). All states hold the same tiles;
/// at least one state. Throws InputError that names the file when corners lie that near without
/// being one.
std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states,
                                             const std::filesystem::path& file);

/// Whether any two corners have one number.
bool sharesNumbers(const CornerNumbers& numbers);

/// The joints of a mesh: of shared numbers where faces share any, else of coinciding corners.
std::vector<Joint> jointsOfMesh(const CornerNumbers& numbers,
                                const std::vector<const std::vector<Tile>*>& states,
                                const std::filesystem::path& file);

/// Vertex numbers for a mesh of the model: corners that pivots join have one number where their
/// coordinates are equal to the last bit at the start and at the target.
CornerNumbers sharedNumbers(const Model& model);

}  // namespace kirireel
