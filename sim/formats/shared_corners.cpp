// Corners at the same point, by vertex number or by position.
//
// By position: corners coincide if their distance is within the tolerance in every state. A grid of
// cubic cells has the tolerance as cell width and stores one corner for each distinct position. A
// new corner is compared with the corners in its own cell and the 26 cells around it, which contain
// all corners within the tolerance. n corners therefore cost O(n), not O(n^2). Coinciding corners
// are merged in a disjoint-set forest. Coincidence within a tolerance is not transitive: a chain of
// close positions becomes one vertex. The file is refused if this merges two corners of one tile.
#include "sim/formats/shared_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/formats/written_digits.h"

namespace kirireel::formats {
namespace {

// Corners at more positions within one tolerance are refused as ambiguous.
constexpr std::size_t kMaxPerCell = 100;

const Vector3& placeOf(const std::vector<model::Tile>& tiles, const model::Corner& corner) {
  return tiles[corner.tile].vertices[corner.vertex];
}

std::vector<model::Corner> allCorners(const std::vector<model::Tile>& tiles) {
  std::vector<model::Corner> corners;
  for (int tile = 0; tile < std::ssize(tiles); ++tile) {
    for (int vertex = 0; vertex < std::ssize(tiles[tile].vertices); ++vertex) {
      corners.push_back({tile, vertex});
    }
  }
  return corners;
}

/// Corners merged pair by pair into groups.
class CornerGroups {
 public:
  // Initially each corner is its own group.
  explicit CornerGroups(const std::vector<model::Tile>& tiles)
      : corners_(allCorners(tiles)), groups_(corners_.size()) {
    first_.push_back(0);
    for (const model::Tile& tile : tiles) {
      first_.push_back(first_.back() + static_cast<int>(tile.vertices.size()));
    }
  }

  const std::vector<model::Corner>& corners() const { return corners_; }

  void merge(const model::Corner& a, const model::Corner& b) {
    groups_.unite(indexOf(a), indexOf(b));
  }

  /// Zero-based numbers of the groups, in the order of their first corners.
  CornerNumbers numbers() {
    CornerNumbers result(first_.size() - 1);
    const std::vector<int> numbers = groups_.numbers();
    for (std::size_t k = 0; k < corners_.size(); ++k) {
      result[corners_[k].tile].push_back(numbers[k]);
    }
    return result;
  }

 private:
  int indexOf(const model::Corner& corner) const { return first_[corner.tile] + corner.vertex; }

  std::vector<model::Corner> corners_;
  std::vector<int> first_;
  DisjointSets groups_;
};

/// Finds corners that coincide in every state in less than quadratic time, by a grid in the first
/// state. The cell width is the tolerance.
class NearCorners {
 public:
  NearCorners(const std::vector<const std::vector<model::Tile>*>& states,
              std::filesystem::path file)
      : states_(states), file_(std::move(file)) {
    for (const std::vector<model::Tile>* tiles : states) {
      tolerance_ = std::max(tolerance_, samePlaceTolerance(*tiles));
    }
  }

  /// Adds a corner. Returns one earlier corner for each position that coincides with it.
  std::vector<model::Corner> add(const model::Corner& corner) {
    const Cell home = cellOf(corner);
    std::vector<model::Corner> found;
    bool isNewPlace = true;
    for (const Cell& cell : cellsAround(home)) {
      const auto residents = cells_.find(cell);
      if (residents == cells_.end()) continue;
      for (const model::Corner& other : residents->second) {
        const double apart = largestDistance(corner, other);
        if (apart <= tolerance_) found.push_back(other);
        // Most coinciding corners are bitwise equal. They need no entry of their own, which keeps
        // cells small.
        if (apart == 0) isNewPlace = false;
      }
    }
    if (isNewPlace) settle(corner, cells_[home]);
    return found;
  }

  /// Throws InputError when two corners of one tile have the same number.
  void requireDistinctCorners(const CornerNumbers& numbers) const {
    for (std::size_t tile = 0; tile < numbers.size(); ++tile) {
      std::vector<int> sorted = numbers[tile];
      std::sort(sorted.begin(), sorted.end());
      if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end()) refuse(tile);
    }
  }

 private:
  // Cell numbers are whole numbers stored as doubles: coordinate / tolerance can exceed the range
  // of int.
  using Cell = std::array<double, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const {
      std::size_t hash = 0;
      for (const double number : cell) hash = 1000003 * hash + std::hash<double>()(number);
      return hash;
    }
  };

  Cell cellOf(const model::Corner& corner) const {
    const Vector3& place = placeOf(*states_.front(), corner);
    return {std::floor(place.x() / tolerance_), std::floor(place.y() / tolerance_),
            std::floor(place.z() / tolerance_)};
  }

  /// A cell and its 26 neighbours.
  static std::vector<Cell> cellsAround(const Cell& home) {
    std::vector<Cell> cells;
    for (const int x : {-1, 0, 1}) {
      for (const int y : {-1, 0, 1}) {
        for (const int z : {-1, 0, 1}) cells.push_back({home[0] + x, home[1] + y, home[2] + z});
      }
    }
    return cells;
  }

  // Over all states, metres.
  double largestDistance(const model::Corner& a, const model::Corner& b) const {
    double largest = 0;
    for (const std::vector<model::Tile>* tiles : states_) {
      largest = std::max(largest, (placeOf(*tiles, a) - placeOf(*tiles, b)).norm());
    }
    return largest;
  }

  // Too many positions within one tolerance are ambiguous and slow.
  void settle(const model::Corner& corner, std::vector<model::Corner>& residents) const {
    residents.push_back(corner);
    if (residents.size() > kMaxPerCell) refuse(static_cast<std::size_t>(corner.tile));
  }

  [[noreturn]] void refuse(std::size_t tile) const {
    throw inputErrorAt(
        {file_},
        fmt::format("corners at tile {} are within {:.2g}, below the precision of their digits, "
                    "but are different vertices. Give joined corners the same vertex number",
                    tile, tolerance_));
  }

  const std::vector<const std::vector<model::Tile>*>& states_;
  std::filesystem::path file_;
  double tolerance_ = 0;  ///< metres
  std::unordered_map<Cell, std::vector<model::Corner>, CellHash>
      cells_;  ///< one corner per position
};

}  // namespace

std::vector<model::Joint> jointsOfSharedNumbers(const CornerNumbers& numbers) {
  std::map<int, std::vector<model::Corner>> holders;
  for (int tile = 0; tile < std::ssize(numbers); ++tile) {
    for (int vertex = 0; vertex < std::ssize(numbers[tile]); ++vertex) {
      holders[numbers[tile][vertex]].push_back({tile, vertex});
    }
  }
  std::vector<model::Joint> joints;
  for (const auto& [number, corners] : holders) {
    for (std::size_t k = 1; k < corners.size(); ++k) {
      joints.push_back({corners[k - 1], corners[k], model::JointFace::Bottom});
    }
  }
  return joints;
}

namespace {

CornerNumbers coincidingNumbers(const std::vector<const std::vector<model::Tile>*>& states,
                                const std::filesystem::path& file) {
  CornerGroups groups(*states.front());
  NearCorners near(states, file);
  for (const model::Corner& corner : groups.corners()) {
    for (const model::Corner& other : near.add(corner)) groups.merge(corner, other);
  }
  CornerNumbers numbers = groups.numbers();
  near.requireDistinctCorners(numbers);
  return numbers;
}

/// Tiles that share numbers, directly or through others, are one part.
DisjointSets partsByNumbers(const CornerNumbers& numbers) {
  DisjointSets parts(numbers.size());
  std::map<int, int> holder;
  for (int tile = 0; tile < std::ssize(numbers); ++tile) {
    for (const int number : numbers[tile]) {
      parts.unite(holder.emplace(number, tile).first->second, tile);
    }
  }
  return parts;
}

}  // namespace

CornerNumbers meshNumbers(const CornerNumbers& numbers,
                          const std::vector<const std::vector<model::Tile>*>& states,
                          const std::filesystem::path& file) {
  DisjointSets parts = partsByNumbers(numbers);
  const auto isWhole = [&](int tile) { return parts.lowestOf(tile) == parts.lowestOf(0); };
  if (std::ranges::all_of(numbersBelow(numbers.size()), isWhole)) return numbers;
  // At each position, the numbers of each part. Two numbers of one part are the sides of a slit.
  const CornerNumbers places = coincidingNumbers(states, file);
  std::map<int, std::map<int, std::set<int>>> numbersAt;
  for (std::size_t tile = 0; tile < numbers.size(); ++tile) {
    const int part = parts.lowestOf(static_cast<int>(tile));
    for (std::size_t k = 0; k < numbers[tile].size(); ++k) {
      numbersAt[places[tile][k]][part].insert(numbers[tile][k]);
    }
  }
  std::map<int, int> merged;
  for (const auto& [place, byPart] : numbersAt) {
    int lowest = -1;
    for (const auto& [part, own] : byPart) {
      if (own.size() > 1) continue;
      if (lowest < 0 || *own.begin() < lowest) lowest = *own.begin();
    }
    for (const auto& [part, own] : byPart) {
      if (own.size() == 1) merged[*own.begin()] = lowest;
    }
  }
  CornerNumbers result = numbers;
  for (std::vector<int>& tile : result) {
    for (int& number : tile) {
      if (const auto found = merged.find(number); found != merged.end()) number = found->second;
    }
  }
  return result;
}

// Requires exact equality. Writing and reading a mesh then loses nothing.
CornerNumbers sharedNumbers(const model::Model& model, bool withTopJoints) {
  CornerGroups groups(model.tiles);
  for (const model::Joint& joint : model.joints) {
    if (joint.kind != model::JointKind::Pivot) continue;
    if (!withTopJoints && joint.face == model::JointFace::Top) continue;
    const auto coincide = [&](const std::vector<model::Tile>& tiles) {
      return placeOf(tiles, joint.a) == placeOf(tiles, joint.b);
    };
    if (coincide(model.tiles) && (!model.target || coincide(*model.target)) &&
        std::ranges::all_of(model.waypoints, coincide)) {
      groups.merge(joint.a, joint.b);
    }
  }
  return groups.numbers();
}

}  // namespace kirireel::formats
