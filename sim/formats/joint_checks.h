/// Joints as read from a file: checks that they connect tiles, and repairs.
#pragma once

#include <array>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/formats/tile_checks.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// One row of constraints.txt.
struct JointRow {
  int line = 0;                  ///< line number, >= 1; 0 if the file has no lines
  std::array<int, 5> values{};   ///< tile A, vertex A, tile B, vertex B, zero-based; face
  std::array<int, 5> columns{};  ///< column of each, >= 1; 0 for a face that is not written
  model::JointKind kind = model::JointKind::Pivot;  ///< constraint that it applies
  model::Neck neck;  ///< in the file's unit; unknown if the file has none
};

/// The rows of one file.
struct JointTable {
  std::filesystem::path file;  ///< path as given by the user
  std::vector<JointRow> rows;  ///< in the file's order
  int countsFrom = 0;          ///< the file's first tile and vertex
};

/// Stores the neck of the file's joint row `joint` (zero-based). Lengths are valid if
/// width > kerf / 2, length >= kerf and kerf >= 0. Throws InputError at this location for other
/// lengths, for a joint that does not exist, and for a second neck of one joint.
void setNeck(int joint, const model::Neck& neck, const FileLocation& location, JointTable& table);

/// Whether all tiles and vertices of the rows exist after adding `shift` to their numbers. `shift`
/// applies to tile and vertex numbers. Costs O(rows).
bool namesExistingCorners(const JointTable& table, const std::vector<model::Tile>& tiles,
                          int shift);

/// Makes the joints of the rows. Throws InputError for tiles, vertices or faces that do not exist,
/// and for a tile joined to itself. Messages use the file's own numbers.
std::vector<model::Joint> checkedJoints(const JointTable& table, const TileTable& tiles);

/// Largest distance of a pivot's corners in a given state, as a fraction of a tile. Larger ones
/// come from a wrong number. Largest in real designs: 3.5e-4 (cube2sphere_w3_h3).
inline constexpr double kMaxGap = 0.05;

/// Throws InputError for a pivot whose corners are more than kMaxGap of a tile apart at the start.
/// Adds warnings for gaps that rounding does not explain. Gaps that rounding explains are noted as
/// repairs, since the corners are one point. `model` holds the tiles and the joints of `table`.
/// Links are not included because their corners are apart by design.
void checkClosed(const JointTable& table, model::Model& model, const TileTable& tiles,
                 std::vector<std::string>& warnings);

/// Distance of a joint's corners at the start, metres.
double startGap(const model::Model& model, const model::Joint& joint);

/// Throws InputError for a joint of another kind than these, before `model` is written to a file.
/// `rule`: what the format supports, the message's beginning.
void requireKinds(const model::Model& model, const std::set<model::JointKind>& kinds,
                  const char* rule, const std::filesystem::path& file);

/// How closely corners fit in designs with all their digits: the largest gap of a pivot at the
/// start and, if the model has one, at the target, metres. Gaps above model::kMaxMisfit of a tile
/// are not a misfit: a run closes them, and a target that has them is open. 0 if corners fit
/// exactly.
double misfitOf(const model::Model& model);

/// Reports that a joints file is empty, without even a comment: its tiles are not connected.
void noteNoJoints(const std::filesystem::path& file, model::Model& model,
                  std::vector<std::string>& warnings);

/// Drops rows that repeat faces of earlier rows at the same corners, in either order of the two
/// ends. Reduces rows with some new faces to these faces. `model` gets the repair. The joints are
/// still rows of `table`. O(rows log rows).
void dropRepeatedJoints(JointTable& table, model::Model& model, std::vector<std::string>& warnings);

/// Shifts the rows' numbers if they fit the tiles only with the other base, of 0 and 1. A table
/// that fits the default base stays unchanged. Updates the model's fileOrder with the base of its
/// file.
void repairBase(JointTable& table, const TileTable& tiles, model::Model& model,
                std::vector<std::string>& warnings);

}  // namespace kirireel::formats
