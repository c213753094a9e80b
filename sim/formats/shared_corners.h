/// Joints as shared vertices: mesh formats use them in place of a list of joints.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::formats {

/// Vertex numbers of each tile's corners, zero-based.
using CornerNumbers = std::vector<std::vector<int>>;

/// Joints on the bottom faces between corners with the same number. The order is by number. Each
/// corner is joined to the next one in tile order.
std::vector<model::Joint> jointsOfSharedNumbers(const CornerNumbers& numbers);

/// Vertex numbers of a mesh. Between tiles that share numbers, directly or through others, the
/// file's own numbers decide. Corners of other tiles get the same number if they coincide in every
/// state, to the precision of the written digits (samePlaceTolerance): programs write the vertices
/// of each object, or of each face, again. All states hold the same tiles. Throws InputError with
/// the file name if corners are that near but are different.
CornerNumbers meshNumbers(const CornerNumbers& numbers,
                          const std::vector<const std::vector<model::Tile>*>& states,
                          const std::filesystem::path& file);

/// Vertex numbers for a mesh of the model. Corners that pivots join share a number if their
/// coordinates are bitwise equal at the start and at all targets. `withTopJoints` includes corners
/// of top joints, whose bottom corners separate when the tiles turn.
CornerNumbers sharedNumbers(const model::Model& model, bool withTopJoints = true);

}  // namespace kirireel::formats
