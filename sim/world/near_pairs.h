/// Which bricks may come near each other: the broad phase. No Bullet header is needed to use it.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"

namespace kirireel {

/// How far any point within `radius` of the origin is displaced by a change of pose, at most.
/// Metres. Never too small; at most twice too large for small turns.
double motionBound(const Pose& from, const Pose& to, double radius);

/// The distance of a brick's farthest point from its centre of mass, metres.
double outerRadius(const Brick& brick);

/// Bullet's dynamic box tree over boxes that are wider than the bricks in them, so that they need
/// be set anew only when a brick has moved by the margin.
class NearPairs {
 public:
  /// `bricks` must outlive this.
  explicit NearPairs(const std::vector<Brick>& bricks);
  ~NearPairs();

  /// Takes notice of a move. Returns whether the pairs were found anew.
  /// O(bricks) where the boxes still hold, else O(bricks log bricks).
  bool update(const Poses& start, const Poses& end);

  /// The pairs whose boxes overlap, smaller number first, sorted. A box holds its brick at the
  /// start and the end of the last move.
  const std::vector<std::pair<int, int>>& pairs() const;

  /// Where the boxes are, which decides the pairs.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel
