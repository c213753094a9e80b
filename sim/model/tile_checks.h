/// Tiles as read from a file, and the checks that they make bricks.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"

namespace kirireel {

/// Where one tile stands in its file.
struct TileSource {
  int line = 0;              ///< from 1
  std::vector<int> columns;  ///< of each vertex's x, from 1
};

/// The tiles of one file and where they stand.
struct TileTable {
  std::filesystem::path file;
  std::vector<Tile> tiles;
  std::vector<TileSource> sources;  ///< one a tile
  int countsFrom = 0;               ///< the file's first tile and vertex, for messages

  FileLocation at(int tile) const { return {file, sources[tile].line}; }
  FileLocation at(int tile, int vertex) const {
    return {file, sources[tile].line, sources[tile].columns[vertex]};
  }
  /// "vertices.txt:13", or the file alone where tiles have no lines, for messages that stand in
  /// another file of the same folder.
  std::string shortName(int tile) const;
};

/// A tile whose sides cross or touch: what it looks like says more than a message.
class CrossedTile : public InputError {
 public:
  CrossedTile(const InputError& error, Tile tile, const Vector3& place)
      : InputError(error), tile_(std::move(tile)), place_(place) {}

  const Tile& tile() const { return tile_; }
  /// Where two of its sides meet, metres.
  const Vector3& place() const { return place_; }

 private:
  Tile tile_;
  Vector3 place_;
};

/// Most vertices of a tile.
inline constexpr std::size_t kMostTileVertices = 300;

/// Throws InputError for the first tile with too many vertices, repeated vertices, without area,
/// or not flat, and CrossedTile for the first whose sides cross or touch.
/// Costs O(n^2) for a tile of n vertices.
void checkTiles(const TileTable& table);

/// Throws InputError when the target has other tiles than the start, or tiles of clearly other
/// shapes. A slight change of shape, which rigid tiles cannot follow, is appended to warnings.
/// `start` holds the model's tiles and `table` where they stand.
void checkTarget(const TileTable& target, const Model& start, const TileTable& table,
                 std::vector<std::string>& warnings);

}  // namespace kirireel
