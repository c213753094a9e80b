/// Joints as read from constraints.txt, and the checks that they hold tiles together.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/tile_checks.h"

namespace kirireel {

/// One row of constraints.txt.
struct JointRow {
  int line = 0;                  ///< from 1
  std::array<int, 5> values{};   ///< tile A, vertex A, tile B, vertex B, face
  std::array<int, 5> columns{};  ///< where each stands, from 1; 0 for a face that is not written
};

/// The rows of one file.
struct JointTable {
  std::filesystem::path file;
  std::vector<JointRow> rows;
};

/// The joints of the rows. Throws InputError for tiles, vertices or faces that do not exist, a tile
/// joined to itself, and joints given twice.
std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles);

/// Throws InputError for a joint whose corners are far apart at the start; smaller gaps are
/// appended to warnings. `model` holds the tiles and the joints of `table`.
void checkClosed(const JointTable& table, const Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings);

}  // namespace kirireel
