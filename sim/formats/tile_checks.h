/// Tiles as read from a file: checks that they can become bricks, and repairs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// Position of one tile in its file.
struct TileSource {
  int line = 0;              ///< line number, >= 1
  std::vector<int> columns;  ///< columns of each vertex's x, >= 1
};

/// The tiles of one file with their positions in it.
struct TileTable {
  std::filesystem::path file;       ///< path as given by the user
  std::vector<model::Tile> tiles;   ///< in the file's order
  std::vector<TileSource> sources;  ///< one per tile
  int countsFrom = 0;               ///< the file's first tile and vertex, for messages
  std::vector<int> padded;          ///< tiles whose repeated or missing vertices were removed

  /// File position of a tile.
  FileLocation at(int tile) const { return {file, sources[tile].line}; }
  /// File position of a vertex of a tile.
  FileLocation at(int tile, int vertex) const {
    return {file, sources[tile].line, sources[tile].columns[vertex]};
  }
  /// "vertices.txt:13", or only the file name if tiles have no lines. For messages about another
  /// file in the same folder.
  std::string shortName(int tile) const;
};

/// Error for a tile whose sides cross or touch. The caller can draw the tile.
class CrossedTile : public InputError {
 public:
  /// `place` is a point where two sides of the tile meet, metres.
  CrossedTile(const InputError& error, model::Tile tile, const Vector3& place)
      : InputError(error), tile_(std::move(tile)), place_(place) {}

  /// The tile as read.
  const model::Tile& tile() const { return tile_; }
  /// A point where two sides of the tile meet, metres.
  const Vector3& place() const { return place_; }

 private:
  model::Tile tile_;
  Vector3 place_;
};

/// The first two vertices of a tile at the same position, to 1e-9 of its diameter. Absent if all
/// are distinct.
std::optional<std::pair<int, int>> repeatedVertices(const model::Tile& tile);

/// Whether a tile's area is more than 1e-6 of its squared diameter.
bool hasArea(const model::Tile& tile);

/// Two sides of a tile that cross or touch, by the numbers of their first corners. Absent if the
/// tile is simple. The tile needs an area.
std::optional<std::pair<int, int>> crossingSides(const model::Tile& tile);

/// Throws InputError for the first tile that has too many vertices, repeated vertices or no area,
/// or that is not flat. Throws CrossedTile for the first tile whose sides cross or touch. Costs
/// O(n^2) for a tile of n vertices.
void checkTiles(const TileTable& table);

/// Throws InputError if a target has other tiles than the start, or clearly different shapes. Adds
/// one warning for slight changes of shape, which rigid tiles cannot follow. `start` holds the
/// model's tiles and `table` their file positions.
void checkTargets(const std::vector<TileTable>& targets, const model::Model& start,
                  const TileTable& table, std::vector<std::string>& warnings);

/// Reports the padded tiles of a table, if there are any.
void notePadding(const TileTable& table, model::Model& model, std::vector<std::string>& warnings);

/// Makes all tiles of a flat start anticlockwise seen from above. Reverses the vertices of
/// clockwise tiles in every state, and updates corners of joints, hull and repairs. model.fileOrder
/// records which tiles were reversed. An all-clockwise start with a spatial target stays as it is,
/// with a warning, because its joints' faces depend on the orientation. The model must be complete.
/// `table` holds the positions of tiles in the file.
void turnClockwiseTiles(const TileTable& table, model::Model& model,
                        std::vector<std::string>& warnings);

}  // namespace kirireel::formats
