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
  int line = 0;                  ///< from 1; 0 where the file has no lines
  std::array<int, 5> values{};   ///< tile A, vertex A, tile B, vertex B, from 0; face
  std::array<int, 5> columns{};  ///< where each stands, from 1; 0 for a face that is not written
  JointKind kind = JointKind::Pivot;
};

/// The rows of one file.
struct JointTable {
  std::filesystem::path file;
  std::vector<JointRow> rows;
  int countsFrom = 0;  ///< the file's first tile and vertex
};

/// Whether all tiles and vertices of the rows are there, after adding `shift` to their numbers.
/// `shift` is added to tile and vertex numbers alike. Costs O(rows).
bool namesWhatIsThere(const JointTable& table, const std::vector<Tile>& tiles, int shift);

/// The joints of the rows. Throws InputError for tiles, vertices or faces that do not exist, and
/// for a tile joined to itself. Messages number as the file does.
std::vector<Joint> checkedJoints(const JointTable& table, const TileTable& tiles);

/// Throws InputError for a joint whose corners are far apart at the start. Gaps that the file's
/// digits do not explain are appended to warnings; those that they do are noted as mends, since
/// the corners are one. `model` holds the tiles and the joints of `table`.
/// Joints further apart than 0.05 of the mean edge are refused; joints of links are not given here,
/// since these stand apart by design.
void checkClosed(const JointTable& table, Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings);

/// How far apart a joint's corners are at the start, metres.
double startGap(const Model& model, const Joint& joint);

}  // namespace kirireel
