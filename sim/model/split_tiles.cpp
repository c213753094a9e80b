// Tiles as triangles that are hinged to each other, so that rigid parts can bend.
//
// A convex polygon with n corners is cut by the n - 3 diagonals from one corner, the apex: that
// with the least sum of diagonals, since short diagonals bend more easily in sheets and give
// triangles that are less thin. Concave tiles are cut into ears (convex_parts.h). Two parts that
// share a diagonal are joined at both its ends on the bottom face: two point joints on one line are
// a hinge about it. Joints of the tile move to the first part that has their corner. One part is
// enough, as the other parts at this corner are joined to it there.
#include "sim/model/split_tiles.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

/// Corner numbers of one part within the tile that it was cut from.
using Part = std::vector<int>;

double diagonalsFrom(const Tile& tile, std::size_t corner) {
  double sum = 0;
  // Sides count in this sum too, which hardly moves the choice.
  for (const Vector3& vertex : tile.vertices) sum += (vertex - tile.vertices[corner]).norm();
  return sum;
}

std::vector<Part> partsOf(const Tile& tile) {
  std::vector<Part> parts;
  for (const auto& triangle : tileTriangles(tile))
    parts.emplace_back(triangle.begin(), triangle.end());
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

  // Joints first, then the tiles themselves, in both states, then the hinges between the parts.
  void split(int tile) {
    const std::vector<Part> parts = partsOf(model_.tiles[tile]);
    std::vector<int> numbers = {tile};
    for (std::size_t k = 1; k < parts.size(); ++k) {
      // The numbers that cutTiles() will give to the parts after the first.
      numbers.push_back(static_cast<int>(model_.tiles.size()) + static_cast<int>(k) - 1);
    }
    // Before the tiles are cut, while corner numbers are still those of the whole tile.
    moveJoints(tile, parts, numbers);
    cutTiles(model_.tiles, tile, parts);
    if (model_.target) cutTiles(*model_.target, tile, parts);
    joinParts(parts, numbers);
    if (!model_.pulledTiles) return;
    std::vector<int>& pulled = *model_.pulledTiles;
    if (std::find(pulled.begin(), pulled.end(), tile) == pulled.end()) return;
    pulled.insert(pulled.end(), numbers.begin() + 1, numbers.end());
  }

  Model take() { return std::move(model_); }

 private:
  /// A hinge at both ends of each side that two parts have in common.
  void joinParts(const std::vector<Part>& parts, const std::vector<int>& numbers) {
    for (std::size_t b = 1; b < parts.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        std::vector<Joint> hinge;
        for (int i = 0; i < 3; ++i) {
          const auto found = std::find(parts[b].begin(), parts[b].end(), parts[a][i]);
          if (found == parts[b].end()) continue;
          const int j = static_cast<int>(found - parts[b].begin());
          hinge.push_back({{numbers[a], i}, {numbers[b], j}, JointFace::Bottom});
        }
        // Parts that touch at one corner only are held together through the parts between them.
        if (hinge.size() < 2) continue;
        model_.joints.insert(model_.joints.end(), hinge.begin(), hinge.end());
      }
    }
  }

  // A corner goes to the first part that has it.
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

std::vector<std::array<int, 3>> tileTriangles(const Tile& tile) {
  if (!isConvexPolygon(tile.vertices, tileNormal(tile))) {
    return trianglesOf(tile.vertices, tileNormal(tile));
  }
  const int count = static_cast<int>(tile.vertices.size());
  int apex = 0;
  for (int k = 1; k < count; ++k) {
    // Rounding does not choose between equal corners.
    if (diagonalsFrom(tile, k) < (1 - 1e-9) * diagonalsFrom(tile, apex)) apex = k;
  }
  std::vector<std::array<int, 3>> triangles;
  for (int k = 1; k + 1 < count; ++k) {
    triangles.push_back({apex, (apex + k) % count, (apex + k + 1) % count});
  }
  return triangles;
}

Model splitTiles(const Model& model, const std::vector<int>& tiles) {
  const int first = model.fileOrder.countsFrom;
  const int end = first + static_cast<int>(model.tiles.size());
  std::vector<int> wanted = tiles;
  if (wanted.empty()) {
    wanted.resize(model.tiles.size());
    std::iota(wanted.begin(), wanted.end(), first);
  }
  Splitter splitter(model);
  for (int& tile : wanted) {
    if (tile < first || tile >= end) {
      throw InputError(
          fmt::format("error: there are tiles {}-{} to split, not {}; correct the number", first,
                      end - 1, tile));
    }
    tile -= first;
    if (model.tiles[tile].vertices.size() > 3) splitter.split(tile);
  }
  Model result = splitter.take();
  // Parts have an order of their own.
  if (!result.fileOrder.isReversed.empty()) result.fileOrder.isReversed.resize(result.tiles.size());
  for (const int tile : wanted) {
    if (result.fileOrder.isReversed.empty() || model.tiles[tile].vertices.size() == 3) continue;
    result.fileOrder.isReversed[tile] = false;
  }
  return result;
}

}  // namespace kirireel
