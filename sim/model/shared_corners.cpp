// Corners that are one, found by their numbers or by their places.
//
// By place: corners coincide where they are within the tolerance of each other in every state. A
// grid of cubic cells, as wide as the tolerance, holds one corner for each distinct place; a new
// corner is compared with those in its own cell and the 26 around it, which hold everything within
// the tolerance. So n corners cost O(n), not O(n^2). Corners that coincide are merged in a forest
// of disjoint sets. Coincidence within a tolerance is not transitive: a chain of close places
// merges into one vertex. Where that would make two corners of one tile the same, the file is
// refused.
#include "sim/model/shared_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/model/rounding.h"

namespace kirireel {
namespace {

// Corners at so many places within one tolerance cannot be told apart.
constexpr std::size_t kMostInACell = 100;

const Vector3& placeOf(const std::vector<Tile>& tiles, const Corner& corner) {
  return tiles[corner.tile].vertices[corner.vertex];
}

std::vector<Corner> allCorners(const std::vector<Tile>& tiles) {
  std::vector<Corner> corners;
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
  // Every corner is a group of its own at first.
  explicit CornerGroups(const std::vector<Tile>& tiles) : corners_(allCorners(tiles)) {
    first_.push_back(0);
    for (const Tile& tile : tiles) {
      first_.push_back(first_.back() + static_cast<int>(tile.vertices.size()));
    }
    parents_.resize(corners_.size());
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  const std::vector<Corner>& corners() const { return corners_; }

  void merge(const Corner& a, const Corner& b) {
    const int rootA = root(indexOf(a)), rootB = root(indexOf(b));
    // The lower number leads, so that groups do not depend on the order of merging.
    parents_[std::max(rootA, rootB)] = std::min(rootA, rootB);
  }

  /// Numbers of the groups, from 0 in the order of their first corners.
  CornerNumbers numbers() {
    CornerNumbers result(first_.size() - 1);
    std::map<int, int> known;
    for (int k = 0; k < std::ssize(corners_); ++k) {
      const int number = known.try_emplace(root(k), static_cast<int>(known.size())).first->second;
      result[corners_[k].tile].push_back(number);
    }
    return result;
  }

 private:
  int indexOf(const Corner& corner) const { return first_[corner.tile] + corner.vertex; }

  // The lowest corner of a group.
  int root(int index) {
    while (parents_[index] != index) {
      // Path halving keeps the trees flat.
      parents_[index] = parents_[parents_[index]];
      index = parents_[index];
    }
    return index;
  }

  std::vector<Corner> corners_;
  std::vector<int> first_;
  std::vector<int> parents_;
};

/// Finds corners that coincide in every state, in time that does not grow with the square of their
/// number: a grid of cells as wide as the tolerance, in the first state.
class NearCorners {
 public:
  NearCorners(const std::vector<const std::vector<Tile>*>& states, std::filesystem::path file)
      : states_(states), file_(std::move(file)) {
    for (const std::vector<Tile>* tiles : states) {
      tolerance_ = std::max(tolerance_, samePlaceTolerance(*tiles));
    }
  }

  /// Takes a corner up. Gives one corner taken up before for each place that coincides with it.
  std::vector<Corner> add(const Corner& corner) {
    const Cell home = cellOf(corner);
    std::vector<Corner> found;
    bool isNewPlace = true;
    for (const Cell& cell : cellsAround(home)) {
      const auto residents = cells_.find(cell);
      if (residents == cells_.end()) continue;
      for (const Corner& other : residents->second) {
        const double apart = largestDistance(corner, other);
        if (apart <= tolerance_) found.push_back(other);
        // Most corners that are one agree to the last bit. They need no entry of their own, so that
        // a cell stays small.
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
  // Cell numbers are whole numbers held as doubles: a coordinate over a tolerance may be larger
  // than an int.
  using Cell = std::array<double, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const {
      std::size_t hash = 0;
      for (const double number : cell) hash = 1000003 * hash + std::hash<double>()(number);
      return hash;
    }
  };

  Cell cellOf(const Corner& corner) const {
    const Vector3& place = placeOf(*states_.front(), corner);
    return {std::floor(place.x() / tolerance_), std::floor(place.y() / tolerance_),
            std::floor(place.z() / tolerance_)};
  }

  /// A cell and the 26 that touch it.
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
  double largestDistance(const Corner& a, const Corner& b) const {
    double largest = 0;
    for (const std::vector<Tile>* tiles : states_) {
      largest = std::max(largest, (placeOf(*tiles, a) - placeOf(*tiles, b)).norm());
    }
    return largest;
  }

  // Too many places within one tolerance cannot be told apart, and would take long.
  void settle(const Corner& corner, std::vector<Corner>& residents) const {
    residents.push_back(corner);
    if (residents.size() > kMostInACell) refuse(static_cast<std::size_t>(corner.tile));
  }

  [[noreturn]] void refuse(std::size_t tile) const {
    throw inputErrorAt(
        {file_}, fmt::format("corners at tile {} are within {:.2g} m, less than their digits can "
                             "tell, without being one; give joined corners one vertex number",
                             tile, tolerance_));
  }

  const std::vector<const std::vector<Tile>*>& states_;
  std::filesystem::path file_;
  double tolerance_ = 0;                                           ///< metres
  std::unordered_map<Cell, std::vector<Corner>, CellHash> cells_;  ///< one corner a place
};

}  // namespace

std::vector<Joint> jointsOfSharedNumbers(const CornerNumbers& numbers) {
  std::map<int, std::vector<Corner>> holders;
  for (int tile = 0; tile < std::ssize(numbers); ++tile) {
    for (int vertex = 0; vertex < std::ssize(numbers[tile]); ++vertex) {
      holders[numbers[tile][vertex]].push_back({tile, vertex});
    }
  }
  std::vector<Joint> joints;
  for (const auto& [number, corners] : holders) {
    for (std::size_t k = 1; k < corners.size(); ++k) {
      joints.push_back({corners[k - 1], corners[k], JointFace::Bottom});
    }
  }
  return joints;
}

std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states,
                                             const std::filesystem::path& file) {
  CornerGroups groups(*states.front());
  NearCorners near(states, file);
  for (const Corner& corner : groups.corners()) {
    for (const Corner& other : near.add(corner)) groups.merge(corner, other);
  }
  const CornerNumbers numbers = groups.numbers();
  near.requireDistinctCorners(numbers);
  return jointsOfSharedNumbers(numbers);
}

bool sharesNumbers(const CornerNumbers& numbers) {
  std::set<int> seen;
  for (const std::vector<int>& tile : numbers) {
    for (const int number : tile) {
      if (!seen.insert(number).second) return true;
    }
  }
  return false;
}

std::vector<Joint> jointsOfMesh(const CornerNumbers& numbers,
                                const std::vector<const std::vector<Tile>*>& states,
                                const std::filesystem::path& file) {
  return sharesNumbers(numbers) ? jointsOfSharedNumbers(numbers)
                                : jointsOfCoincidingCorners(states, file);
}

// Exact equality, so that nothing is lost when a mesh is written and read.
CornerNumbers sharedNumbers(const Model& model) {
  CornerGroups groups(model.tiles);
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) continue;
    const bool atStart = placeOf(model.tiles, joint.a) == placeOf(model.tiles, joint.b);
    const bool atTarget =
        !model.target || placeOf(*model.target, joint.a) == placeOf(*model.target, joint.b);
    if (atStart && atTarget) groups.merge(joint.a, joint.b);
  }
  return groups.numbers();
}

}  // namespace kirireel
