#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

#include "sim/brick/shared_corners.h"
#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// Below this sine two directions count as parallel: they give the same separating axes.
constexpr double kParallel = 1e-9;

/// A brick at its pose, in world axes: the prism that its bottom sweeps along `rise`.
struct PlacedBrick {
  std::vector<Vector3> bottom;
  std::vector<Vector3> edges;  ///< unit directions of the bottom's edges, parallel ones once
  Vector3 normal;              ///< unit
  Vector3 rise;                ///< from bottom to top
  Eigen::AlignedBox3d box;
};

/// An interval of projections on an axis.
struct Extent {
  double low;
  double high;
};

bool isParallel(const Vector3& a, const Vector3& b) {
  return a.cross(b).squaredNorm() < kParallel * kParallel;
}

PlacedBrick placeBrick(const Brick& brick, const Pose& pose) {
  PlacedBrick placed;
  placed.normal = pose.rotation * brick.normal;
  placed.rise = brick.thickness * placed.normal;
  placed.bottom.reserve(brick.bottom.size());
  for (const Vector3& point : brick.bottom) {
    placed.bottom.push_back(pose.apply(point));
    placed.box.extend(placed.bottom.back());
    placed.box.extend(placed.bottom.back() + placed.rise);
  }
  placed.edges.reserve(brick.bottom.size());
  for (size_t k = 0; k < placed.bottom.size(); ++k) {
    const Vector3& next = placed.bottom[(k + 1) % placed.bottom.size()];
    const Vector3 edge = (next - placed.bottom[k]).normalized();
    const bool known = std::any_of(placed.edges.begin(), placed.edges.end(),
                                   [&](const Vector3& other) { return isParallel(edge, other); });
    if (!known) placed.edges.push_back(edge);
  }
  return placed;
}

/// The top needs no projections of its own: it is the bottom moved by `rise`.
Extent project(const PlacedBrick& brick, const Vector3& axis) {
  Extent extent{brick.bottom[0].dot(axis), brick.bottom[0].dot(axis)};
  for (const Vector3& point : brick.bottom) {
    const double projection = point.dot(axis);
    extent.low = std::min(extent.low, projection);
    extent.high = std::max(extent.high, projection);
  }
  const double rise = brick.rise.dot(axis);
  return {extent.low + std::min(rise, 0.0), extent.high + std::max(rise, 0.0)};
}

/// How far one brick must move along a unit axis, one way or the other, to be clear of the other;
/// negative when it is clear already. The least over all unit axes is the depth.
double overlapAlong(const PlacedBrick& a, const PlacedBrick& b, const Vector3& axis) {
  const Extent extentA = project(a, axis);
  const Extent extentB = project(b, axis);
  return std::min(extentA.high - extentB.low, extentB.high - extentA.low);
}

double overlapOfBoxes(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return (a.max().cwiseMin(b.max()) - a.min().cwiseMax(b.min())).minCoeff();
}

/// The least overlap of a pair of bricks over the axes tried so far. Trying stops as soon as the
/// pair cannot be deeper than what was found before.
class PairDepth {
 public:
  PairDepth(const PlacedBrick& a, const PlacedBrick& b, double deepest)
      : a_(a), b_(b), deepest_(deepest) {}

  /// The depth, or something not above `deepest`.
  double find() {
    if (tryFaces(a_) && tryFaces(b_)) tryEdges();
    return depth_;
  }

 private:
  /// False when no further axis matters.
  bool tryAxis(const Vector3& axis) {
    depth_ = std::min(depth_, overlapAlong(a_, b_, axis));
    return depth_ > deepest_;
  }

  bool tryFaces(const PlacedBrick& brick) {
    if (!tryAxis(brick.normal)) return false;
    for (const Vector3& edge : brick.edges) {
      if (!tryAxis(edge.cross(brick.normal))) return false;
    }
    return true;
  }

  bool tryProduct(const Vector3& edgeA, const Vector3& edgeB) {
    return isParallel(edgeA, edgeB) || tryAxis(edgeA.cross(edgeB).normalized());
  }

  bool tryEdges() {
    // Products of edges of parallel tiles are the faces' normals again.
    if (isParallel(a_.normal, b_.normal)) return true;
    if (!tryProduct(a_.normal, b_.normal)) return false;
    for (const Vector3& edgeA : a_.edges) {
      if (!tryProduct(edgeA, b_.normal)) return false;
    }
    for (const Vector3& edgeB : b_.edges) {
      if (!tryProduct(a_.normal, edgeB)) return false;
      for (const Vector3& edgeA : a_.edges) {
        if (!tryProduct(edgeA, edgeB)) return false;
      }
    }
    return true;
  }

  const PlacedBrick& a_;
  const PlacedBrick& b_;
  const double deepest_;
  double depth_ = std::numeric_limits<double>::infinity();
};

/// The axis along which the bricks are spread most: sorted along it, fewest boxes overlap.
int sweepAxis(const std::vector<PlacedBrick>& bricks) {
  Eigen::AlignedBox3d all;
  for (const PlacedBrick& brick : bricks) all.extend(brick.box);
  int axis = 0;
  all.diagonal().maxCoeff(&axis);
  return axis;
}

/// Two placed bricks and their numbers.
struct PlacedPair {
  int brickA;
  int brickB;
  const PlacedBrick& a;
  const PlacedBrick& b;
};

/// Visits all pairs whose boxes overlap by more than `least()`, in an order that is the same
/// everywhere.
template <typename Least, typename Visit>
void visitNearPairs(const std::vector<Brick>& bricks, const Poses& poses, const Least& least,
                    const Visit& visit) {
  if (bricks.empty()) return;
  std::vector<PlacedBrick> placed;
  placed.reserve(bricks.size());
  for (size_t i = 0; i < bricks.size(); ++i) placed.push_back(placeBrick(bricks[i], poses[i]));

  // Sweep and prune: in order of their low sides, a brick can only meet those that start before it
  // ends.
  const int axis = sweepAxis(placed);
  std::vector<int> order(placed.size());
  std::iota(order.begin(), order.end(), 0);
  // The stable sort keeps the result the same everywhere, and survives poses that are no numbers.
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return placed[a].box.min()[axis] < placed[b].box.min()[axis];
  });
  for (size_t i = 0; i < order.size(); ++i) {
    const PlacedBrick& first = placed[order[i]];
    for (size_t j = i + 1; j < order.size(); ++j) {
      const PlacedBrick& second = placed[order[j]];
      if (second.box.min()[axis] >= first.box.max()[axis]) break;
      if (overlapOfBoxes(first.box, second.box) <= least()) continue;
      visit(PlacedPair{order[i], order[j], first, second});
    }
  }
}

/// The depth of pairs that share corners is that without them.
class DepthOutsidePivots {
 public:
  DepthOutsidePivots(const std::vector<Brick>& bricks, std::span<const Pivot> pivots, double zone,
                     const Poses& poses)
      : bricks_(bricks), joined_(sharedCorners(pivots)), zone_(zone), poses_(poses) {}

  /// The depth, or something not above `deepest`.
  double operator()(const PlacedPair& pair, double deepest) const {
    const auto [a, b] = std::minmax(pair.brickA, pair.brickB);
    const auto corners = joined_.find({a, b});
    if (corners == joined_.end()) return PairDepth(pair.a, pair.b, deepest).find();
    const auto [cutA, cutB] = withoutSharedCorners(bricks_[a], bricks_[b], corners->second, zone_);
    return PairDepth(placeBrick(cutA, poses_[a]), placeBrick(cutB, poses_[b]), deepest).find();
  }

 private:
  const std::vector<Brick>& bricks_;
  std::map<std::pair<int, int>, SharedCorners> joined_;
  double zone_;
  const Poses& poses_;
};

/// `depthOf(pair, deepest)` gives the depth of a pair, or something not above `deepest`.
template <typename DepthOf>
Penetration deepestOverlap(const std::vector<Brick>& bricks, const Poses& poses,
                           const DepthOf& depthOf) {
  Penetration deepest;
  const auto least = [&] { return deepest.depth; };
  visitNearPairs(bricks, poses, least, [&](const PlacedPair& pair) {
    const double depth = depthOf(pair, deepest.depth);
    if (depth > deepest.depth) deepest = {depth, pair.brickA, pair.brickB};
  });
  return deepest;
}

}  // namespace

Penetration deepestPenetration(const std::vector<Brick>& bricks, const Poses& poses) {
  return deepestOverlap(bricks, poses, [](const PlacedPair& pair, double deepest) {
    return PairDepth(pair.a, pair.b, deepest).find();
  });
}

Penetration deepestPenetrationOutsidePivots(const std::vector<Brick>& bricks,
                                            std::span<const Pivot> pivots, double zone,
                                            const Poses& poses) {
  return deepestOverlap(bricks, poses, DepthOutsidePivots(bricks, pivots, zone, poses));
}

std::vector<Penetration> penetrationsOutsidePivots(const std::vector<Brick>& bricks,
                                                   std::span<const Pivot> pivots, double zone,
                                                   const Poses& poses, double least) {
  const DepthOutsidePivots depthOf(bricks, pivots, zone, poses);
  std::vector<Penetration> all;
  visitNearPairs(
      bricks, poses, [least] { return least; },
      [&](const PlacedPair& pair) {
        const double depth = depthOf(pair, least);
        const auto [a, b] = std::minmax(pair.brickA, pair.brickB);
        if (depth > least) all.push_back({depth, a, b});
      });
  std::ranges::sort(all, [](const Penetration& one, const Penetration& other) {
    return std::tuple(-one.depth, one.brickA, one.brickB) <
           std::tuple(-other.depth, other.brickA, other.brickB);
  });
  return all;
}

PenetrationGrowth::PenetrationGrowth(const std::vector<Brick>& bricks,
                                     std::span<const Pivot> pivots, double zone, const Poses& start,
                                     double least)
    : bricks_(bricks), pivots_(pivots), zone_(zone) {
  for (const Penetration& pair : penetrationsOutsidePivots(bricks, pivots, zone, start, least)) {
    atStart_[{pair.brickA, pair.brickB}] = pair.depth;
  }
}

PenetrationGrowth::Depths PenetrationGrowth::at(const Poses& poses) const {
  if (atStart_.empty()) {
    const double depth = deepestPenetrationOutsidePivots(bricks_, pivots_, zone_, poses).depth;
    return {depth, depth};
  }
  Depths depths;
  for (const Penetration& pair : penetrationsOutsidePivots(bricks_, pivots_, zone_, poses, 0)) {
    const auto before = atStart_.find({pair.brickA, pair.brickB});
    const double kept = before == atStart_.end() ? 0 : before->second;
    depths.deepest = std::max(depths.deepest, pair.depth);
    depths.grown = std::max(depths.grown, pair.depth - kept);
  }
  return depths;
}

}  // namespace kirireel
