/// [[grip]] in a scene file: what holds, moves or pushes parts of a sheet while it is loaded.
#pragma once

#include <optional>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"
#include "sim/scene/toml_file.h"

namespace kirireel {

/// One grip. What it says is reached at the load 1, and in proportion before; what it does not say
/// is free.
struct GripSetting {
  std::vector<int> tiles;       ///< that it holds, one or more
  std::vector<int> vertices;    ///< of each of them: none, where the tile as a whole is held (its
                                ///< middle), one, or the two of an edge
  std::vector<Corner> corners;  ///< these vertices in the model's numbers, see numberAsModel()
  bool isForce = false;         ///< newtons and N m that push, else metres and radians of moves
  std::optional<double> x;      ///< 0 holds, where it moves
  std::optional<double> y;      ///< likewise
  std::optional<double> z;      ///< likewise, of sheets in space
  std::optional<double> turn;   ///< anticlockwise; of whole tiles alone
  FileLocation where;           ///< in the scene file, for messages
};

/// Reads the [[grip]] entries of a scene file:
///
///     tile = NUMBER or tiles = [NUMBERS], and where not all of it: vertex = NUMBER or
///     edge = [NUMBER, NUMBER]; then one of move = {x = METRES, y = METRES, turn = DEGREES} and
///     force = {x = NEWTONS, y = NEWTONS, turn = N_M}, of which any may be left out; z likewise.
///
/// Throws InputError with file:line:column for what is none of this.
std::vector<GripSetting> readGrips(const TomlValue& value);

/// Turns numbers of tiles, as the model's file has them, into the model's own, and sets the corners
/// that the vertices are. Throws InputError where a grip names no tile or vertex of the model.
void numberAsModel(std::vector<GripSetting>& grips, const Model& model);

}  // namespace kirireel
