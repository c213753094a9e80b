/// What a path of the mechanism follows.
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/deploy/continuation.h"

namespace kirireel {

/// What a path follows: straight from each of its states to the next, at an even pace.
/// Distances between its states are pathDistance(), so that its pace is even in moves and turns
/// together.
class PathGuide {
 public:
  /// Two states at least, one pose a brick in each.
  PathGuide(const std::vector<Brick>& bricks, std::vector<Poses> states)
      : states_(std::move(states)) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
      lengths_.push_back(lengths_.back() + pathDistance(bricks, states_[k - 1], states_[k]));
    }
  }

  /// Of the whole guide, metres.
  double length() const { return lengths_.back(); }
  const Poses& end() const { return states_.back(); }

  /// The place at a progress from 0 to 1.
  Poses at(double progress) const {
    const double length = progress * lengths_.back();
    const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, length);
    const auto k = static_cast<std::size_t>(next - lengths_.begin());
    const double part = lengths_[k] - lengths_[k - 1];
    const double share = part > 0 ? (length - lengths_[k - 1]) / part : 1;
    return interpolate(states_[k - 1], states_[k], share);
  }

 private:
  std::vector<Poses> states_;
  std::vector<double> lengths_ = {0};  // up to each state, metres
};

}  // namespace kirireel
