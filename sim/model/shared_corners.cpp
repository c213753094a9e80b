#include "sim/model/shared_corners.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

namespace kirireel {
namespace {

// Corners nearer than this part of the sheet's size coincide. Largest met in the published pairs:
// 0.
constexpr double kSamePlace = 1e-6;

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

  int root(int index) {
    while (parents_[index] != index) {
      parents_[index] = parents_[parents_[index]];
      index = parents_[index];
    }
    return index;
  }

  std::vector<Corner> corners_;
  std::vector<int> first_;
  std::vector<int> parents_;
};

double extent(const std::vector<Tile>& tiles) {
  Model model;
  model.tiles = tiles;
  return modelSize(model);
}

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

std::vector<Joint> jointsOfCoincidingCorners(const std::vector<const std::vector<Tile>*>& states) {
  const std::vector<Tile>& start = *states.front();
  const double tolerance = kSamePlace * extent(start);
  CornerGroups groups(start);
  // In order of x, a corner can only coincide with those that follow within the tolerance.
  std::vector<Corner> order = groups.corners();
  std::stable_sort(order.begin(), order.end(), [&](const Corner& a, const Corner& b) {
    return placeOf(start, a).x() < placeOf(start, b).x();
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      if (placeOf(start, order[j]).x() - placeOf(start, order[i]).x() > tolerance) break;
      if (order[i].tile == order[j].tile) continue;
      const bool together = std::all_of(states.begin(), states.end(), [&](const auto* tiles) {
        return (placeOf(*tiles, order[i]) - placeOf(*tiles, order[j])).norm() <= tolerance;
      });
      if (together) groups.merge(order[i], order[j]);
    }
  }
  return jointsOfSharedNumbers(groups.numbers());
}

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
