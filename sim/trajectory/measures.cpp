// Figures of a state. Kinetic energy of a brick with mass m (kg), inertia I in brick axes (kg m^2),
// velocity v (m/s) and angular velocity w (rad/s, world axes):
//   T = m |v|^2 / 2 + s . I s / 2,     s = R^T w
// with R the brick's rotation. Rotating w into brick axes is cheaper than rotating I into world
// axes.
#include "sim/trajectory/measures.h"

#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <tuple>

#include "sim/base/interruption.h"
#include "sim/brick/contact.h"
#include "sim/model/isometry.h"

namespace kirireel::trajectory {
namespace {

/// The larger of two figures. Keeps NaN, which std::max would drop.
double largerOf(double largest, double figure) {
  return std::isnan(largest) || figure <= largest ? largest : figure;
}

}  // namespace

JointGap jointGap(std::span<const brick::Pivot> pivots, const Poses& poses) {
  JointGap gap;
  if (pivots.empty()) return gap;
  const std::vector<Matrix3> turns = rotationMatrices(poses);
  const auto placed = [&](int brick, const Vector3& point) -> Vector3 {
    const auto i = static_cast<std::size_t>(brick);
    return poses[i].position + turns[i] * point;
  };
  for (const brick::Pivot& pivot : pivots) {
    const Vector3 apart = placed(pivot.brickA, pivot.pointA) - placed(pivot.brickB, pivot.pointB);
    const double distance = brick::pivotGap(pivot, apart);
    gap.max = largerOf(gap.max, distance);
    gap.mean += distance;
  }
  gap.mean /= static_cast<double>(pivots.size());
  return gap;
}

double targetError(const std::vector<model::Tile>& target, const std::vector<brick::Brick>& bricks,
                   const Poses& poses) {
  double largest = 0;  // squared
  for (size_t i = 0; i < bricks.size(); ++i) {
    const Matrix3 turn = poses[i].rotation.toRotationMatrix();
    for (size_t k = 0; k < bricks[i].bottom.size(); ++k) {
      const Vector3 vertex = poses[i].position + turn * bricks[i].bottom[k];
      largest = largerOf(largest, (vertex - target[i].vertices[k]).squaredNorm());
    }
  }
  return std::sqrt(largest);
}

double kineticEnergy(const std::vector<brick::Brick>& bricks, const Motion& motion) {
  double energy = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    const Velocity& velocity = motion.velocities[i];
    const Vector3 spin = motion.poses[i].rotation.conjugate() * velocity.angular;
    energy += 0.5 * bricks[i].mass * velocity.linear.squaredNorm();
    energy += 0.5 * spin.dot(bricks[i].inertia * spin);
  }
  return energy;
}

// ------------------------------------------------------------------------------------------------
// Depth of overlaps.
//
// Two convex bodies A and B overlap by the depth
//
//     depth(A, B) = min over unit axes n of min(high_A(n) - low_B(n), high_B(n) - low_A(n)),
//
// where low and high bound the projections on the axis: the shortest move that separates them. For
// polyhedra the minimum is on one of finitely many axes: the normals of the faces of both, and the
// products of an edge of one with an edge of the other (Gottschalk, Lin and Manocha, OBBTree,
// SIGGRAPH 1996). The faces and edges of a prism follow from its bottom and its normal, and its top
// need not be projected. Any axis gives an upper bound of the depth. The search for a pair stops
// when this bound is not above the known depth.
//
// Two bricks in the same layer, as in a planar sheet, can only be separated within their plane: the
// axis along their thickness does not count.
//
// A concave brick is divided into convex pieces (see convex_parts.h). Two such bricks overlap by as
// much as their deepest pair of pieces, a lower bound of every move that separates them.
//
// Pairs are found by sweep and prune: bricks are sorted by the low sides of their boxes along the
// axis of their largest spread. A brick can only meet those that begin before it ends.
//
// Successive states of one motion are measured together. Between the first and the last of them, a
// point moves almost along the chord: a point at distance r from the brick's origin is at
//     x + R(q) p,    q = (1 - s) q0 + s q1 + e,
// with x0, q0, x1, q1 the first and the last pose. R(q) p is quadratic in q, so the point differs
// from its chord by at most
//     d = |x - (1 - s) x0 - s x1| + r (s (1 - s) |q1 - q0|^2 + 2 |e| + |e|^2).
// On the chords, high_A(n) - low_B(n) along a fixed axis n is convex in s. Its value in any of the
// states is therefore at most the larger one of both ends, plus the d of A and B. A pair with such
// a bound that is not above the known depth is not measured in these states.

namespace {

// Below this sine the product of two directions has no defined direction.
constexpr double kParallelSine = 1e-9;
// Below this sine, rounding, two edges give the same separating axis.
constexpr double kSameAxisSine = 1e-14;
// Bricks are in one layer if their faces differ in height by at most this fraction of their
// thickness.
constexpr double kSameLayer = 1e-6;

// For unit vectors, parallel or antiparallel.
bool isParallel(const Vector3& a, const Vector3& b, double sine = kParallelSine) {
  return a.cross(b).squaredNorm() < sine * sine;
}

/// Geometry of a convex piece of a brick for overlap tests, in brick axes.
struct Prism {
  int brick = 0;  ///< index of its brick
  std::vector<Vector3> bottom;
  std::vector<Vector3> directions;  ///< the normal, then those of the edges, without parallel ones
  double thickness = 0;
};

// A convex piece as a prism. The normals of its sides follow from the edges and the brick's normal
// and are not stored.
Prism prismOf(const brick::Brick& brick, int number) {
  Prism prism{number, brick.bottom, {brick.normal}, brick.thickness};
  for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
    const Vector3& next = brick.bottom[(k + 1) % brick.bottom.size()];
    const Vector3 edge = (next - brick.bottom[k]).normalized();
    // A rectangle has two directions of edges, not four. The number of axes grows with their
    // product.
    const bool known =
        std::any_of(prism.directions.begin() + 1, prism.directions.end(),
                    [&](const Vector3& other) { return isParallel(edge, other, kSameAxisSine); });
    if (!known) prism.directions.push_back(edge);
  }
  return prism;
}

// All pieces of all bricks. Pieces of one brick are consecutive: PlacedPrisms::of() relies on this.
std::vector<Prism> prismsOf(const std::vector<brick::Brick>& bricks) {
  std::vector<Prism> prisms;
  prisms.reserve(bricks.size());
  for (const brick::BrickPiece& piece : brick::convexPieces(bricks)) {
    checkInterruption();
    prisms.push_back(prismOf(piece.shape, piece.brick));
  }
  return prisms;
}

/// The pieces of one brick of a joined pair, without the corners that both share.
std::vector<Prism> cutPrismsOf(const brick::Brick& brick, int number,
                               const std::vector<int>& corners, double length) {
  std::vector<Prism> prisms;
  for (const brick::BrickPiece& piece : brick::convexPieces(brick, number)) {
    prisms.push_back(prismOf(brick::withoutCorners(piece, corners, length), number));
  }
  return prisms;
}

/// A prism at its pose, in world axes.
struct PlacedPrism {
  int brick = 0;
  std::vector<Vector3> bottom;
  std::vector<Vector3> directions;
  Vector3 rise;  ///< from bottom to top, metres
  Eigen::AlignedBox3d box;

  const Vector3& normal() const { return directions.front(); }

  /// Sets everything except the box and the directions.
  void placeCorners(const Prism& prism, const Pose& pose) {
    const Matrix3 turn = pose.rotation.toRotationMatrix();
    brick = prism.brick;
    rise = prism.thickness * (turn * prism.directions.front());
    bottom.resize(prism.bottom.size());
    for (std::size_t k = 0; k < bottom.size(); ++k)
      bottom[k] = pose.position + turn * prism.bottom[k];
  }

  void place(const Prism& prism, const Pose& pose) {
    placeCorners(prism, pose);
    const Matrix3 turn = pose.rotation.toRotationMatrix();
    directions.resize(prism.directions.size());
    for (std::size_t k = 0; k < directions.size(); ++k) directions[k] = turn * prism.directions[k];
    box.setEmpty();
    for (const Vector3& point : bottom) box.extend(point).extend(point + rise);
  }
};

/// An interval of projections on an axis.
struct Projection {
  double low;
  double high;
};

// Needs one product per corner of the bottom.
Projection project(const PlacedPrism& prism, const Vector3& axis) {
  Projection interval{prism.bottom[0].dot(axis), prism.bottom[0].dot(axis)};
  for (const Vector3& point : prism.bottom) {
    const double projection = point.dot(axis);
    interval.low = std::min(interval.low, projection);
    interval.high = std::max(interval.high, projection);
  }
  // The top is the bottom moved by `rise`. Its projections are those of the bottom plus a constant.
  const double rise = prism.rise.dot(axis);
  return {interval.low + std::min(rise, 0.0), interval.high + std::max(rise, 0.0)};
}

/// The smallest distance along a unit axis, in either direction, that separates two prisms.
/// Negative if the axis separates them already. The minimum over all unit axes is the depth.
double overlapAlong(const PlacedPrism& a, const PlacedPrism& b, const Vector3& axis) {
  const Projection intervalA = project(a, axis);
  const Projection intervalB = project(b, axis);
  return std::min(intervalA.high - intervalB.low, intervalB.high - intervalA.low);
}

// Whether they are parallel, with equal heights of tops and bottoms up to rounding.
bool areInOneLayer(const PlacedPrism& a, const PlacedPrism& b) {
  if (!isParallel(a.normal(), b.normal())) return false;
  const double thickness = a.rise.dot(a.normal());
  const double rise = b.rise.dot(a.normal());
  const double bottom = (b.bottom.front() - a.bottom.front()).dot(a.normal());
  const double low = std::min(bottom, bottom + rise), high = std::max(bottom, bottom + rise);
  const double tolerance = kSameLayer * thickness;
  return std::abs(low) <= tolerance && std::abs(high - thickness) <= tolerance;
}

Eigen::AlignedBox3d boxOf(std::span<const PlacedPrism> pieces) {
  Eigen::AlignedBox3d box;
  for (const PlacedPrism& piece : pieces) box.extend(piece.box);
  return box;
}

/// Whether two sets of pieces, each of one brick, may overlap deeper than `known` (>= 0). False is
/// certain: the axes of the boxes are axes too, and the smallest overlap of the boxes bounds the
/// depth from above.
bool mayOverlapBy(double known, std::span<const PlacedPrism> a, std::span<const PlacedPrism> b,
                  const Eigen::AlignedBox3d& boxA, const Eigen::AlignedBox3d& boxB) {
  // The smallest distance along each axis, in either direction, that separates two boxes. Negative
  // if they are separated already. If one box contains the other's interval, the distance exceeds
  // their common part.
  const Vector3 overlaps = (boxA.max() - boxB.min()).cwiseMin(boxB.max() - boxA.min());
  const double least = overlaps.minCoeff();
  if (least > known) return true;
  if (least <= 0 || overlaps.maxCoeff() <= known) return false;
  if (!areInOneLayer(a.front(), b.front())) return false;
  // For bricks in one layer, only box axes within the layer bound the depth.
  const Vector3& normal = a.front().normal();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(normal[axis]) < kParallelSine && overlaps[axis] <= known) return false;
  }
  return true;
}

/// The axes that can separate two prisms, by index: faces of the first, faces of the second,
/// products of a direction of each.
class SeparatingAxes {
 public:
  SeparatingAxes(const PlacedPrism& a, const PlacedPrism& b)
      : a_(a), b_(b), facesA_(a.directions.size()), facesB_(b.directions.size()) {
    // Products of directions of parallel tiles repeat the faces' normals.
    const bool parallel = isParallel(a.normal(), b.normal());
    count_ = facesA_ + facesB_ + (parallel ? 0 : facesA_ * facesB_);
    hasNormals_ = !parallel || !areInOneLayer(a, b);
  }

  std::size_t count() const { return count_; }

  /// The axis with this index, a unit vector. Absent if the index has no axis.
  std::optional<Vector3> axis(std::size_t number) const {
    if (!hasNormals_ && (number == 0 || number == facesA_)) return std::nullopt;
    if (number < facesA_) return face(a_, number);
    if (number < facesA_ + facesB_) return face(b_, number - facesA_);
    const std::size_t product = number - facesA_ - facesB_;
    const Vector3& ofA = a_.directions[product / facesB_];
    const Vector3& ofB = b_.directions[product % facesB_];
    if (isParallel(ofA, ofB)) return std::nullopt;
    return ofA.cross(ofB).normalized();
  }

  /// The overlap along an axis. Infinite if the index has no axis.
  double overlap(std::size_t number) const {
    const std::optional<Vector3> along = axis(number);
    return along ? overlapAlong(a_, b_, *along) : std::numeric_limits<double>::infinity();
  }

 private:
  static Vector3 face(const PlacedPrism& prism, std::size_t number) {
    return number == 0 ? prism.normal() : prism.directions[number].cross(prism.normal());
  }

  const PlacedPrism& a_;
  const PlacedPrism& b_;
  std::size_t facesA_;
  std::size_t facesB_;
  std::size_t count_;
  bool hasNormals_;  // whether the axes along the thickness count
};

/// The depth of a pair, or any value <= `known`. The axis with the index `hint` is tried first.
/// `hint` becomes the deciding axis.
double pairDepth(const PlacedPrism& a, const PlacedPrism& b, double known, std::size_t& hint) {
  const SeparatingAxes axes(a, b);
  if (hint < axes.count()) {
    const double overlap = axes.overlap(hint);
    // One axis with a small overlap is enough to skip the pair.
    if (overlap <= known) return overlap;
  }
  double depth = std::numeric_limits<double>::infinity();
  for (std::size_t number = 0; number < axes.count() && depth > known; ++number) {
    const double overlap = axes.overlap(number);
    if (overlap >= depth) continue;
    depth = overlap;
    hint = number;
  }
  return depth;
}

// The same without a hint.
double pairDepth(const PlacedPrism& a, const PlacedPrism& b, double known) {
  std::size_t hint = std::numeric_limits<std::size_t>::max();
  return pairDepth(a, b, known, hint);
}

/// All bricks of a state, and the pairs that may overlap.
class PlacedPrisms {
 public:
  void place(const std::vector<Prism>& prisms, const Poses& poses) {
    placed_.resize(prisms.size());
    first_.assign(poses.size() + 1, static_cast<int>(prisms.size()));
    for (std::size_t i = prisms.size(); i-- > 0;) {
      placed_[i].place(prisms[i], poses[prisms[i].brick]);
      first_[prisms[i].brick] = static_cast<int>(i);
    }
  }

  /// Places only the pieces of some bricks, after the first place().
  void placeOnly(const std::vector<char>& bricks, const std::vector<Prism>& prisms,
                 const Poses& poses) {
    for (std::size_t i = 0; i < prisms.size(); ++i) {
      const auto brick = static_cast<std::size_t>(prisms[i].brick);
      if (bricks[brick]) placed_[i].place(prisms[i], poses[brick]);
    }
  }

  /// `piece`: index of the piece.
  const PlacedPrism& operator[](int piece) const {
    return placed_[static_cast<std::size_t>(piece)];
  }

  /// All pieces of a brick.
  std::span<const PlacedPrism> of(int brick) const {
    const int first = first_[brick];
    return std::span(placed_).subspan(first, first_[brick + 1] - first);
  }

  /// Visits the pairs of pieces of different bricks whose boxes overlap by more than `least()`, at
  /// most maxPairs() of them. The smaller index comes first, and the order is the same on all
  /// machines. Returns whether these were all.
  template <typename Least, typename Visit>
  bool visitNearPairs(const Least& least, const Visit& visit) {
    sort();
    long left = maxPairs(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) {
      checkInterruption();
      const PlacedPrism& first = (*this)[order_[i]];
      for (std::size_t j = i + 1; j < order_.size(); ++j) {
        const PlacedPrism& second = (*this)[order_[j]];
        // All further boxes begin even farther along this axis.
        if (second.box.min()[axis_] >= first.box.max()[axis_]) break;
        if (first.brick == second.brick) continue;
        if (!mayOverlapBy(least(), {&first, 1}, {&second, 1}, first.box, second.box)) continue;
        if (left-- == 0) return false;
        const auto [a, b] = std::minmax(order_[i], order_[j]);
        visit(a, b);
      }
    }
    return true;
  }

  /// Widens the boxes to those of the same pieces in another state, and further by a distance per
  /// brick, metres.
  void widen(const PlacedPrisms& other, const std::vector<double>& distances) {
    for (std::size_t i = 0; i < placed_.size(); ++i) {
      Eigen::AlignedBox3d& box = placed_[i].box;
      box.extend(other.placed_[i].box);
      const Vector3 wider =
          Vector3::Constant(distances[static_cast<std::size_t>(placed_[i].brick)]);
      box = {box.min() - wider, box.max() + wider};
    }
  }

 private:
  void sort() {
    Eigen::AlignedBox3d all;
    for (const PlacedPrism& prism : placed_) all.extend(prism.box);
    if (placed_.empty()) return;
    // Bricks overlap least along the axis of their largest spread.
    all.diagonal().maxCoeff(&axis_);
    order_.resize(placed_.size());
    std::iota(order_.begin(), order_.end(), 0);
    // The stable sort gives the same result on all machines, and tolerates NaN poses.
    std::ranges::stable_sort(order_, [&](int a, int b) {
      return (*this)[a].box.min()[axis_] < (*this)[b].box.min()[axis_];
    });
  }

  std::vector<PlacedPrism> placed_;
  std::vector<int> first_;  // first piece of each brick, then the count of all
  std::vector<int> order_;  // by the low sides of their boxes
  int axis_ = 0;
};

/// Two joined bricks without the corners that they share, and hints from earlier states.
struct JoinedPair {
  int a = 0;  ///< the smaller index
  int b = 0;
  std::vector<Prism> cutA;
  std::vector<Prism> cutB;
  double atStart = 0;                 ///< depth of the cut pair, metres
  std::vector<std::size_t> hints;     ///< axes of the whole pair, one per pair of pieces
  std::vector<std::size_t> hintsCut;  ///< axes of the cut pair
};

// Pairs that share pivots. Each is cut once: the shared corners are fixed in brick axes.
std::vector<JoinedPair> joinedPairs(const std::vector<brick::Brick>& bricks,
                                    std::span<const brick::Pivot> pivots, double zone) {
  std::vector<JoinedPair> pairs;
  for (const auto& [numbers, corners] : brick::sharedCorners(pivots)) {
    checkInterruption();
    const auto [a, b] = numbers;
    const double length = brick::cutLength(bricks[a], bricks[b], zone);
    JoinedPair& pair =
        pairs.emplace_back(JoinedPair{a, b, cutPrismsOf(bricks[a], a, corners.ofA, length),
                                      cutPrismsOf(bricks[b], b, corners.ofB, length)});
    pair.hints.resize(pair.cutA.size() * pair.cutB.size());
    pair.hintsCut = pair.hints;
    // Parts of a bending tile do not collide with each other.
    if (corners.areOneTile) pair.cutA.clear();
  }
  return pairs;
}

/// Places the corners of pieces at the pose of their brick. Reuses the memory of `placed`.
void placeAllCorners(const std::vector<Prism>& prisms, const Pose& pose,
                     std::vector<PlacedPrism>& placed) {
  placed.resize(prisms.size());
  for (std::size_t k = 0; k < prisms.size(); ++k) placed[k].placeCorners(prisms[k], pose);
}

/// The same of whole pieces.
void placeAll(const std::vector<Prism>& prisms, const Pose& pose,
              std::vector<PlacedPrism>& placed) {
  placed.resize(prisms.size());
  for (std::size_t k = 0; k < prisms.size(); ++k) placed[k].place(prisms[k], pose);
}

/// The deepest overlap of any two pieces of two bricks, or any value <= `known`. `hints`: one per
/// pair of pieces.
double deepestOf(std::span<const PlacedPrism> a, std::span<const PlacedPrism> b, double known,
                 std::vector<std::size_t>& hints) {
  double deepest = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      const double depth = pairDepth(a[i], b[j], std::max(known, deepest), hints[i * b.size() + j]);
      deepest = std::max(deepest, depth);
    }
  }
  return deepest;
}

// Bounds of depths between states leave this margin for rounding and for directions that count as
// parallel, as a fraction of a brick's radius and of its coordinates.
constexpr double kBoundMargin = 1e-8;
constexpr double kCoordinateMargin = 1e-14;
// The bounds of fewer states cost more than they save.
constexpr std::size_t kMinStates = 4;
// A larger change of a quaternion between the states has no bound. It is a rotation by 0.2 rad.
constexpr double kMaxChange = 0.1;
// Bricks whose normals have a larger sine cannot become parallel by two such rotations.
constexpr double kNearlyParallel = 0.4;
// Along an axis within 30 degrees of their layer (a sine of 0.5), bricks in one layer overlap by no
// less than within it, up to the depth of their thickness.
constexpr double kNearlyInLayer = 0.5;

/// The largest distance of a brick's points from their chords, over some states. Includes the
/// margins. `radius`: of the brick, metres. Infinite if there is no bound.
double chordDistance(int brick, double radius, std::span<const Poses* const> states) {
  const Pose& from = (*states.front())[brick];
  const Pose& to = (*states.back())[brick];
  const auto near = [&](const Quaternion& rotation) -> Eigen::Vector4d {
    const double sign = rotation.coeffs().dot(from.rotation.coeffs()) < 0 ? -1 : 1;
    return sign * rotation.coeffs();
  };
  const Eigen::Vector4d first = from.rotation.coeffs(), change = near(to.rotation) - first;
  const double squared = change.squaredNorm();
  double farthest = 0, largestChange = std::sqrt(squared);
  for (std::size_t k = 1; k + 1 < states.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(states.size() - 1);
    const Pose& pose = (*states[k])[brick];
    const double moved =
        (pose.position - from.position - share * (to.position - from.position)).norm();
    const double turned = (near(pose.rotation) - first - share * change).norm();
    const double distance =
        moved + radius * (share * (1 - share) * squared + 2 * turned + turned * turned);
    farthest = largerOf(farthest, distance);
    largestChange = largerOf(largestChange, std::sqrt(squared) + turned);
  }
  if (!(largestChange <= kMaxChange)) return std::numeric_limits<double>::infinity();
  return farthest + kBoundMargin * radius +
         kCoordinateMargin *
             std::max(from.position.cwiseAbs().maxCoeff(), to.position.cwiseAbs().maxCoeff());
}

/// A piece in the first and the last of some states, and a bound of its distance from the chords
/// between them.
struct MovedPrism {
  const PlacedPrism& from;  ///< only its corners are used
  const PlacedPrism& to;
  double distance;  ///< see chordDistance()
};

/// Whether a fixed axis proves that two pieces overlap by at most `known` (>= 0) in all states.
bool isBounded(const MovedPrism& a, const MovedPrism& b, double known) {
  if (known == std::numeric_limits<double>::infinity()) return true;
  const double allowed = known - a.distance - b.distance;
  const bool mayShareLayer = isParallel(a.to.normal(), b.to.normal(), kNearlyParallel);
  if (mayShareLayer && known > a.to.rise.norm()) return false;
  const SeparatingAxes axes(a.to, b.to);
  for (std::size_t number = 0; number < axes.count(); ++number) {
    const std::optional<Vector3> axis = axes.axis(number);
    if (!axis) continue;
    if (mayShareLayer && !(std::abs(axis->dot(a.to.normal())) <= kNearlyInLayer)) continue;
    const Projection toA = project(a.to, *axis), toB = project(b.to, *axis);
    const bool isAbove = toB.high - toA.low <= allowed, isBelow = toA.high - toB.low <= allowed;
    if (!isAbove && !isBelow) continue;
    const Projection fromA = project(a.from, *axis), fromB = project(b.from, *axis);
    if (isAbove && fromB.high - fromA.low <= allowed) return true;
    if (isBelow && fromA.high - fromB.low <= allowed) return true;
  }
  return false;
}

/// The same for all pieces of two bricks.
bool areBounded(std::span<const PlacedPrism> fromA, std::span<const PlacedPrism> toA,
                double distanceA, std::span<const PlacedPrism> fromB,
                std::span<const PlacedPrism> toB, double distanceB, double known) {
  for (std::size_t i = 0; i < toA.size(); ++i) {
    for (std::size_t j = 0; j < toB.size(); ++j) {
      if (!isBounded({fromA[i], toA[i], distanceA}, {fromB[j], toB[j], distanceB}, known))
        return false;
    }
  }
  return true;
}

/// Overlaps in a state, the deepest first, and whether all near pairs were checked.
struct Overlaps {
  std::vector<Penetration> pairs;
  bool areAll = true;
};

Overlaps overlapsOutsidePivots(const std::vector<brick::Brick>& bricks,
                               std::span<const brick::Pivot> pivots, double zone,
                               const Poses& poses, double least) {
  PlacedPrisms placed;
  placed.place(prismsOf(bricks), poses);
  const auto joined = brick::sharedCorners(pivots);
  Overlaps found;
  std::vector<PlacedPrism> cutA;
  std::vector<PlacedPrism> cutB;
  const auto depthOf = [&](int pieceA, int pieceB) {
    const int a = placed[pieceA].brick, b = placed[pieceB].brick;
    const auto corners = joined.find({a, b});
    if (corners == joined.end()) return pairDepth(placed[pieceA], placed[pieceB], least);
    if (corners->second.areOneTile) return least;
    const double length = brick::cutLength(bricks[a], bricks[b], zone);
    std::vector<std::size_t> hints(placed.of(a).size() * placed.of(b).size(),
                                   std::numeric_limits<std::size_t>::max());
    placeAll(cutPrismsOf(bricks[a], a, corners->second.ofA, length), poses[a], cutA);
    placeAll(cutPrismsOf(bricks[b], b, corners->second.ofB, length), poses[b], cutB);
    return deepestOf(cutA, cutB, least, hints);
  };
  // Bricks of several pieces overlap in several pairs: the deepest counts.
  std::map<std::pair<int, int>, double> depths;
  found.areAll = placed.visitNearPairs(
      [least] { return least; },
      [&](int pieceA, int pieceB) {
        const double depth = depthOf(pieceA, pieceB);
        if (depth <= least) return;
        double& deepest = depths[{placed[pieceA].brick, placed[pieceB].brick}];
        deepest = std::max(deepest, depth);
      });
  for (const auto& [pair, depth] : depths) found.pairs.push_back({depth, pair.first, pair.second});
  std::ranges::sort(found.pairs, [](const Penetration& one, const Penetration& other) {
    return std::tuple(-one.depth, one.brickA, one.brickB) <
           std::tuple(-other.depth, other.brickA, other.brickB);
  });
  return found;
}

}  // namespace

Penetration deepestPenetration(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  PlacedPrisms placed;
  placed.place(prismsOf(bricks), poses);
  Penetration deepest;
  placed.visitNearPairs([&] { return deepest.depth; },
                        [&](int a, int b) {
                          const double depth = pairDepth(placed[a], placed[b], deepest.depth);
                          if (depth <= deepest.depth) return;
                          deepest = {depth, placed[a].brick, placed[b].brick};
                        });
  return deepest;
}

Penetration deepestPenetrationOutsidePivots(const std::vector<brick::Brick>& bricks,
                                            std::span<const brick::Pivot> pivots, double zone,
                                            const Poses& poses) {
  const std::vector<Penetration> all = penetrationsOutsidePivots(bricks, pivots, zone, poses, 0);
  return all.empty() ? Penetration{} : all.front();
}

std::vector<Penetration> penetrationsOutsidePivots(const std::vector<brick::Brick>& bricks,
                                                   std::span<const brick::Pivot> pivots,
                                                   double zone, const Poses& poses, double least) {
  return overlapsOutsidePivots(bricks, pivots, zone, poses, least).pairs;
}

struct PenetrationMeter::Internals {
  std::vector<Prism> prisms;
  std::vector<double> radii;                      // of the bricks, metres
  std::vector<JoinedPair> joined;                 // by brick index; empty if they do not count
  std::vector<std::vector<int>> partners;         // for each brick: joined, with a larger index
  std::map<std::pair<int, int>, double> atStart;  // metres, of unjoined pairs
  bool seesAllPairs = true;                       // at the start
  PlacedPrisms placed;
  std::vector<PlacedPrism> cutA;
  std::vector<PlacedPrism> cutB;
  // Of several states of one motion:
  PlacedPrisms first, last;                     // its ends
  std::vector<double> distances;                // see chordDistance(), per brick
  std::vector<JoinedPair*> leftJoined;          // pairs without a bound
  std::vector<std::pair<int, int>> leftPieces;  // pieces of unjoined bricks without a bound
  std::vector<char> isLeft;                     // whether a brick is in one of these pairs
  std::vector<PlacedPrism> firstA, firstB;      // corners of cut pieces in the first state

  bool isJoined(int a, int b) const {
    const std::vector<int>& others = partners[static_cast<std::size_t>(a)];
    return std::ranges::find(others, b) != others.end();
  }

  // Overlap of a pair at the start, metres. 0 if there was none.
  double keptBy(int a, int b) const {
    const auto found = atStart.find({a, b});
    return found == atStart.end() ? 0 : found->second;
  }

  // Raises the figures by one joined pair. The whole bricks count for `whole`, the cut ones for the
  // two others.
  void measureJoined(JoinedPair& pair, const Poses& poses, PenetrationDepths& depths) {
    const std::span<const PlacedPrism> a = placed.of(pair.a), b = placed.of(pair.b);
    const Eigen::AlignedBox3d boxA = boxOf(a), boxB = boxOf(b);
    if (mayOverlapBy(depths.whole, a, b, boxA, boxB)) {
      depths.whole = std::max(depths.whole, deepestOf(a, b, depths.whole, pair.hints));
    }
    // The other two figures can rise only if the cut pair is deeper than this.
    const double known = std::min(depths.outsidePivots, depths.grown + pair.atStart);
    if (!mayOverlapBy(known, a, b, boxA, boxB)) return;
    placeAll(pair.cutA, poses[pair.a], cutA);
    placeAll(pair.cutB, poses[pair.b], cutB);
    const double depth = deepestOf(cutA, cutB, known, pair.hintsCut);
    depths.outsidePivots = std::max(depths.outsidePivots, depth);
    depths.grown = std::max(depths.grown, depth - pair.atStart);
  }

  // An unjoined pair can raise the figures only if it is deeper than this. The start overlap is
  // subtracted, never added.
  static double knownOfUnjoined(const PenetrationDepths& depths) {
    return std::min({depths.whole, depths.outsidePivots, depths.grown});
  }

  // Raises the figures by two pieces of unjoined bricks.
  void measurePieces(int pieceA, int pieceB, PenetrationDepths& depths) const {
    const int a = placed[pieceA].brick, b = placed[pieceB].brick;
    const double depth = pairDepth(placed[pieceA], placed[pieceB], knownOfUnjoined(depths));
    depths.whole = std::max(depths.whole, depth);
    depths.outsidePivots = std::max(depths.outsidePivots, depth);
    // For pairs that were not checked at the start, the start overlap is unknown.
    if (!seesAllPairs && !atStart.contains({a, b})) return;
    if (depth > depths.grown) depths.grown = std::max(depths.grown, depth - keptBy(a, b));
  }

  // Raises the figures by all other pairs whose boxes overlap.
  void measureUnjoined(PenetrationDepths& depths) {
    placed.visitNearPairs([&] { return knownOfUnjoined(depths); },
                          [&](int a, int b) {
                            if (!isJoined(placed[a].brick, placed[b].brick))
                              measurePieces(a, b, depths);
                          });
  }

  // Whether a joined pair cannot raise the figures in any state of a motion.
  bool isJoinedBounded(const JoinedPair& pair, const PenetrationDepths& known, const Poses& from,
                       const Poses& to) {
    const double distanceA = distances[pair.a], distanceB = distances[pair.b];
    if (!areBounded(first.of(pair.a), last.of(pair.a), distanceA, first.of(pair.b), last.of(pair.b),
                    distanceB, known.whole)) {
      return false;
    }
    const double least = std::min(known.outsidePivots, known.grown + pair.atStart);
    placeAllCorners(pair.cutA, from[pair.a], firstA);
    placeAllCorners(pair.cutB, from[pair.b], firstB);
    placeAll(pair.cutA, to[pair.a], cutA);
    placeAll(pair.cutB, to[pair.b], cutB);
    return areBounded(firstA, cutA, distanceA, firstB, cutB, distanceB, least);
  }

  // Lists the pairs that may raise the figures in a state of a motion. Returns false if there are
  // too many near pairs, or if a brick has no bound.
  bool listLeft(const PenetrationDepths& known, std::span<const Poses* const> states) {
    const Poses &from = *states.front(), &to = *states.back();
    first.place(prisms, from);
    last.place(prisms, to);
    distances.clear();
    for (std::size_t i = 0; i < from.size(); ++i) {
      distances.push_back(chordDistance(static_cast<int>(i), radii[i], states));
      // A brick without a bound would be near all others.
      if (!std::isfinite(distances.back())) return false;
    }
    leftJoined.clear();
    leftPieces.clear();
    isLeft.assign(from.size(), 0);
    for (JoinedPair& pair : joined) {
      checkInterruption();
      if (isJoinedBounded(pair, known, from, to)) continue;
      leftJoined.push_back(&pair);
      isLeft[pair.a] = isLeft[pair.b] = 1;
    }
    const double least = knownOfUnjoined(known);
    placed = last;
    placed.widen(first, distances);
    return placed.visitNearPairs(
        [] { return 0.0; },
        [&](int pieceA, int pieceB) {
          const int a = placed[pieceA].brick, b = placed[pieceB].brick;
          if (isJoined(a, b)) return;
          if (isBounded({first[pieceA], last[pieceA], distances[a]},
                        {first[pieceB], last[pieceB], distances[b]}, least)) {
            return;
          }
          leftPieces.emplace_back(pieceA, pieceB);
          isLeft[a] = isLeft[b] = 1;
        });
  }

  // Raises the figures by the listed pairs.
  void measureLeft(const Poses& poses, PenetrationDepths& depths) {
    placed.placeOnly(isLeft, prisms, poses);
    for (JoinedPair* pair : leftJoined) measureJoined(*pair, poses, depths);
    for (const auto& [a, b] : leftPieces) {
      if (mayOverlapBy(knownOfUnjoined(depths), {&placed[a], 1}, {&placed[b], 1}, placed[a].box,
                       placed[b].box)) {
        measurePieces(a, b, depths);
      }
    }
  }
};

// Checks all pairs of the start once: later states are compared pair by pair.
PenetrationMeter::PenetrationMeter(const std::vector<brick::Brick>& bricks,
                                   std::span<const brick::Pivot> pivots, double zone,
                                   const Poses& start, double least, bool countsJoined)
    : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.prisms = prismsOf(bricks);
  for (const brick::Brick& brick : bricks) {
    double squared = 0;
    for (const auto* points : {&brick.bottom, &brick.top}) {
      for (const Vector3& point : *points) squared = std::max(squared, point.squaredNorm());
    }
    in.radii.push_back(std::sqrt(squared));
  }
  in.joined = joinedPairs(bricks, pivots, zone);
  in.partners.resize(bricks.size());
  for (const JoinedPair& pair : in.joined)
    in.partners[static_cast<std::size_t>(pair.a)].push_back(pair.b);
  const Overlaps overlaps = overlapsOutsidePivots(bricks, pivots, zone, start, least);
  in.seesAllPairs = overlaps.areAll;
  for (const Penetration& pair : overlaps.pairs) {
    in.atStart[{pair.brickA, pair.brickB}] = pair.depth;
  }
  for (JoinedPair& pair : in.joined) pair.atStart = in.keptBy(pair.a, pair.b);
  if (!countsJoined) in.joined.clear();
}

PenetrationMeter::~PenetrationMeter() = default;

bool PenetrationMeter::seesAllPairs() const {
  return internals_->seesAllPairs;
}

PenetrationDepths PenetrationMeter::atLeast(const PenetrationDepths& known, const Poses& poses) {
  Internals& in = *internals_;
  PenetrationDepths depths = known;
  in.placed.place(in.prisms, poses);
  for (JoinedPair& pair : in.joined) {
    checkInterruption();
    in.measureJoined(pair, poses, depths);
  }
  in.measureUnjoined(depths);
  return depths;
}

double PenetrationMeter::grownAt(const Poses& poses, double known) {
  return atLeast({kAnyDepth, kAnyDepth, known}, poses).grown;
}

std::vector<PenetrationDepths> PenetrationMeter::atLeastEach(const PenetrationDepths& known,
                                                             std::span<const Poses* const> states) {
  Internals& in = *internals_;
  std::vector<PenetrationDepths> found;
  PenetrationDepths depths = known;
  const bool areListed = states.size() >= kMinStates && in.listLeft(known, states);
  for (const Poses* poses : states) {
    if (areListed) {
      checkInterruption();
      in.measureLeft(*poses, depths);
    } else {
      depths = atLeast(depths, *poses);
    }
    found.push_back(depths);
  }
  return found;
}

// ------------------------------------------------------------------------------------------------
// Lower bound of the distance between a rigid tile and its target: the minimax fit.
//
// For residuals r_k of the vertices after a rigid motion and any weights w_k >= 0 with sum 1,
//     min over motions of max r_k  >=  sqrt(min over motions of sum w_k r_k^2),
// since a weighted mean never exceeds the maximum. The right side is the weighted Kabsch fit, whose
// optimum over proper motions is global. Every weighting therefore gives a valid bound of the left
// side. Lawson's iteration searches the best weighting: w_k is multiplied by r_k, and the weights
// are scaled to sum 1 again. Vertices with large residuals gain weight, the others lose it. Both
// sides become equal at the minimax fit. The bound is valid wherever the iteration ends.
//
// C. L. Lawson, "Contributions to the theory of linear least maximum approximation", 1961; C. L.
// Lawson and R. J. Hanson, "Solving Least Squares Problems", 1974.

namespace {

// The iteration ends when both sides agree to this relative tolerance.
constexpr double kAgreement = 1e-12;
constexpr int kMaxIterations = 1000;
// Maximum number of fits of all tiles together. Later tiles, which fit better, keep their bound.
constexpr long kMaxFits = 200'000;
// Residuals below this fraction of the tile's distance from the origin are rounding.
constexpr double kResidualRounding = 1e-14;
// A vertex keeps at least this fraction of the largest factor: a weight of zero could not grow
// again.
constexpr double kMinVertexWeight = 1e-3;

/// A weighted fit of one tile, and its bound of the largest residual of any fit.
struct TileFit {
  std::vector<double> residuals;  ///< of each vertex, metres
  double largest = 0;             ///< largest residual, metres
  double bound = 0;               ///< lower bound of the largest residual of all fits
};

TileFit fitWith(const std::vector<double>& weights, const model::Tile& tile,
                const model::Tile& target) {
  const model::RigidMotion motion = model::bestRigidMotion(tile.vertices, target.vertices, weights);
  TileFit fit;
  double sum = 0;
  for (std::size_t k = 0; k < weights.size(); ++k) {
    fit.residuals.push_back((motion.apply(tile.vertices[k]) - target.vertices[k]).norm());
    sum += weights[k] * fit.residuals[k] * fit.residuals[k];
  }
  fit.largest = *std::ranges::max_element(fit.residuals);
  fit.bound = std::sqrt(sum);
  return fit;
}

std::vector<double> evenWeights(const model::Tile& tile) {
  return std::vector<double>(tile.vertices.size(), 1.0 / static_cast<double>(tile.vertices.size()));
}

double rounding(const model::Tile& target) {
  double reach = 0;
  for (const Vector3& vertex : target.vertices) reach = std::max(reach, vertex.norm());
  return kResidualRounding * reach;
}

/// The best bound of one tile, or `known` if no bound of this tile exceeds it. `fits` counts the
/// fits.
double boundOf(const model::Tile& tile, const model::Tile& target, double known, long& fits) {
  std::vector<double> weights = evenWeights(tile);
  double bound = known;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations && fits < kMaxFits; ++i) {
    checkInterruption();
    const TileFit fit = fitWith(weights, tile, target);
    ++fits;
    bound = std::max(bound, fit.bound);
    nearest = std::min(nearest, fit.largest);
    // The best motion reaches the bound: no motion can come nearer.
    if (nearest <= (1 + kAgreement) * bound || nearest <= rounding(target)) break;
    double sum = 0;
    for (std::size_t k = 0; k < weights.size(); ++k) {
      // Lawson's step.
      weights[k] *= std::max(fit.residuals[k], kMinVertexWeight * fit.largest);
      sum += weights[k];
    }
    for (double& weight : weights) weight /= sum;
  }
  return bound;
}

}  // namespace

double rigidBound(const std::vector<model::Tile>& tiles, const std::vector<model::Tile>& target) {
  std::vector<TileFit> fits;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    checkInterruption();
    fits.push_back(fitWith(evenWeights(tiles[i]), tiles[i], target[i]));
  }
  // Tiles that fit worst come first: the others rarely need an iteration.
  std::vector<std::size_t> order(tiles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::greater{}, [&](std::size_t i) { return fits[i].largest; });
  double bound = 0;
  long made = 0;
  for (const std::size_t i : order) {
    bound = std::max(bound, fits[i].bound);
    if (fits[i].largest > bound) bound = boundOf(tiles[i], target[i], bound, made);
  }
  return bound;
}

}  // namespace kirireel::trajectory
