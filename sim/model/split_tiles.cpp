#include "sim/model/split_tiles.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// Corner numbers of one part within the tile that it was cut from.
using Part = std::vector<int>;

double diagonalsFrom(const Tile& tile, std::size_t corner) {
  double sum = 0;
  for (const Vector3& vertex : tile.vertices) sum += (vertex - tile.vertices[corner]).norm();
  return sum;
}

/// The triangles between the diagonals from one corner, in order round it.
std::vector<Part> partsOf(const Tile& tile) {
  const int count = static_cast<int>(tile.vertices.size());
  int apex = 0;
  for (int k = 1; k < count; ++k) {
    // Rounding does not choose between equal corners.
    if (diagonalsFrom(tile, k) < (1 - 1e-9) * diagonalsFrom(tile, apex)) apex = k;
  }
  std::vector<Part> parts;
  for (int k = 1; k + 1 < count; ++k) {
    parts.push_back({apex, (apex + k) % count, (apex + k + 1) % count});
  }
  return parts;
}

Tile cut(const Tile& tile, const Part& part) {
  Tile result;
  for (const int corner : part) result.vertices.push_back(tile.vertices[corner]);
  return result;
}

/// Splits one tile after the other.
class Splitter {
 public:
  explicit Splitter(const Model& model) : model_(model) {}

  void split(int tile) {
    const std::vector<Part> parts = partsOf(model_.tiles[tile]);
    std::vector<int> numbers = {tile};
    for (std::size_t k = 1; k < parts.size(); ++k) {
      numbers.push_back(static_cast<int>(model_.tiles.size()) + static_cast<int>(k) - 1);
    }
    moveJoints(tile, parts, numbers);
    cutTiles(model_.tiles, tile, parts);
    if (model_.target) cutTiles(*model_.target, tile, parts);
    for (std::size_t k = 1; k < parts.size(); ++k) {
      // Corner 0 is the common one; corner 2 of a part is corner 1 of the next.
      model_.joints.push_back({{numbers[k - 1], 0}, {numbers[k], 0}, JointFace::Bottom});
      model_.joints.push_back({{numbers[k - 1], 2}, {numbers[k], 1}, JointFace::Bottom});
    }
    if (!model_.pulledTiles) return;
    std::vector<int>& pulled = *model_.pulledTiles;
    if (std::find(pulled.begin(), pulled.end(), tile) == pulled.end()) return;
    pulled.insert(pulled.end(), numbers.begin() + 1, numbers.end());
  }

  Model take() { return std::move(model_); }

 private:
  void moveJoints(int tile, const std::vector<Part>& parts, const std::vector<int>& numbers) {
    const auto move = [&](Corner& corner) {
      if (corner.tile != tile) return;
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const auto found = std::find(parts[k].begin(), parts[k].end(), corner.vertex);
        if (found == parts[k].end()) continue;
        corner = {numbers[k], static_cast<int>(found - parts[k].begin())};
        return;
      }
    };
    for (Joint& joint : model_.joints) {
      move(joint.a);
      move(joint.b);
    }
  }

  static void cutTiles(std::vector<Tile>& tiles, int tile, const std::vector<Part>& parts) {
    const Tile whole = tiles[tile];
    tiles[tile] = cut(whole, parts[0]);
    for (std::size_t k = 1; k < parts.size(); ++k) tiles.push_back(cut(whole, parts[k]));
  }

  Model model_;
};

}  // namespace

Model splitTiles(const Model& model, const std::vector<int>& tiles) {
  const int count = static_cast<int>(model.tiles.size());
  std::vector<int> wanted = tiles;
  if (wanted.empty()) {
    wanted.resize(model.tiles.size());
    std::iota(wanted.begin(), wanted.end(), 0);
  }
  Splitter splitter(model);
  for (const int tile : wanted) {
    if (tile < 0 || tile >= count) {
      throw InputError(fmt::format(
          "error: there are tiles 0-{} to split, not {}; correct the number", count - 1, tile));
    }
    if (model.tiles[tile].vertices.size() > 3) splitter.split(tile);
  }
  return splitter.take();
}

}  // namespace kirireel
