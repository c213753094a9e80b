// Hinges are found from the points that two bricks share. Their angle is that of the start and the
// twist since then: of the rotation q from brick A to brick B, identity at the start, the part
//   turn = 2 atan2(axis . Im q, Re q)
// about the axis. It is defined up to 2 pi; the one is taken that is nearest to the middle of the
// angles that bricks can reach, from which the others are as far away as bricks can be within each
// other.
#include "sim/brick/hinge.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace kirireel {
namespace {

constexpr double kPi = std::numbers::pi;
// Points closer than this part of a brick's edge are one.
constexpr double kSamePoint = 1e-6;
// Angles closer than this are equal, radians.
constexpr double kSameAngle = 1e-6;

/// What two bricks share: points in the axes of the first.
struct PivotPoints {
  const Pivot* first = nullptr;
  std::vector<Vector3> points;
  bool isTied = false;  // fixed, or held by a link too
};

/// The shared points of all pairs of bricks, in the order of their first pivots.
std::vector<PivotPoints> sharedPoints(std::span<const Pivot> pivots, bool planar) {
  std::vector<PivotPoints> pairs;
  std::map<std::pair<int, int>, std::size_t> known;
  for (const Pivot& pivot : pivots) {
    if (planar && pivot.isUpper) continue;
    const std::pair<int, int> key = std::minmax(pivot.brickA, pivot.brickB);
    const auto [place, isNew] = known.try_emplace(key, pairs.size());
    if (isNew) pairs.push_back({&pivot, {}, false});
    PivotPoints& shared = pairs[place->second];
    // All points of a pair are kept in the axes of one of the two bricks.
    const bool isSwapped = pivot.brickA != shared.first->brickA;
    shared.points.push_back(isSwapped ? pivot.pointB : pivot.pointA);
    shared.isTied = shared.isTied || pivot.cornerA == kNoCorner;
  }
  return pairs;
}

/// The direction of the line through all points, unit; zero where they are one, or on no line.
struct CommonLine {
  Vector3 direction = Vector3::Zero();
  bool isPoint = false;
};

CommonLine commonLine(const std::vector<Vector3>& points, double same) {
  const auto fromFirst = [&](const Vector3& point) { return (point - points[0]).norm(); };
  const Vector3 farthest = *std::ranges::max_element(points, {}, fromFirst);
  // All points are one: a corner.
  if (fromFirst(farthest) <= same) return {Vector3::Zero(), true};
  const Vector3 along = (farthest - points[0]).normalized();
  const bool isLine = std::ranges::all_of(
      points, [&](const Vector3& point) { return along.cross(point - points[0]).norm() <= same; });
  return {isLine ? along : Vector3::Zero(), false};
}

/// What a brick takes of the turn about an axis through one of its corners.
struct Sector {
  double begin = 0;  // radians from a common direction
  double width = 0;
};

Sector sectorAt(const Brick& brick, int corner, const Vector3& axis, const Vector3& zero) {
  const std::size_t count = brick.bottom.size();
  const auto k = static_cast<std::size_t>(corner);
  const auto angleOf = [&](const Vector3& edge) {
    return std::atan2(axis.dot(zero.cross(edge)), zero.dot(edge));
  };
  double begin = angleOf(brick.bottom[(k + 1) % count] - brick.bottom[k]);
  double end = angleOf(brick.bottom[(k + count - 1) % count] - brick.bottom[k]);
  // Seen against the normal a tile runs clockwise.
  if (brick.normal.dot(axis) < 0) std::swap(begin, end);
  return {begin, end > begin ? end - begin : end - begin + 2 * kPi};
}

/// Of the angles that differ by turns, the one nearest to the middle.
double nearest(double angle, double middle) {
  return middle + std::remainder(angle - middle, 2 * kPi);
}

Hinge cornerHinge(const std::vector<Brick>& bricks, const Pivot& pivot) {
  const Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const Vector3 axis = brickA.normal;
  const Vector3 zero = axis.unitOrthogonal();
  const Sector a = sectorAt(brickA, pivot.cornerA, axis, zero);
  const Sector b = sectorAt(brickB, pivot.cornerB, axis, zero);
  // What both tiles leave of the full turn about the corner is shared by the gaps on their two
  // sides.
  const double free = std::max(0.0, 2 * kPi - a.width - b.width);
  const double left = nearest(b.begin - a.begin - a.width, 0.5 * free);
  // The gap on the other side is the smaller one: the hinge is counted there, with its axis
  // reversed.
  if (free - left < left - kSameAngle) {
    return {pivot.brickA, pivot.brickB, -axis, free - left, 0, free};
  }
  return {pivot.brickA, pivot.brickB, axis, left, 0, free};
}

/// The direction from an axis through a point into the brick, along its tile.
Vector3 inward(const Brick& brick, const Vector3& point, const Vector3& axis) {
  Vector3 direction = meanPoint(brick.bottom) - point;
  // Only the part across the axis and in the tile says on which side of the axis the tile lies.
  direction -= brick.normal.dot(direction) * brick.normal;
  direction -= axis.dot(direction) * axis;
  return direction.normalized();
}

Hinge foldHinge(const std::vector<Brick>& bricks, const Pivot& pivot, const Vector3& line) {
  const Brick& brickA = bricks[static_cast<std::size_t>(pivot.brickA)];
  const Brick& brickB = bricks[static_cast<std::size_t>(pivot.brickB)];
  const Vector3 a = inward(brickA, pivot.pointA, line);
  const Vector3 b = inward(brickB, pivot.pointB, line);
  // The axis has the first tile on its right, so that a positive turn of B lifts it to A's upper
  // side.
  const Vector3 axis = line.dot(brickA.normal.cross(a)) < 0 ? Vector3(-line) : line;
  const double start = std::atan2(axis.dot(b.cross(a)), -a.dot(b));
  return {pivot.brickA, pivot.brickB, axis, start, -kPi, kPi};
}

}  // namespace

FoundHinges findHinges(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                       bool planar) {
  FoundHinges found;
  for (PivotPoints& shared : sharedPoints(pivots, planar)) {
    if (shared.isTied) continue;
    const Pivot& pivot = *shared.first;
    const Brick& brick = bricks[static_cast<std::size_t>(pivot.brickA)];
    const CommonLine line = commonLine(shared.points, kSamePoint * meanEdge(brick));
    if (planar) {
      if (line.isPoint) found.hinges.push_back(cornerHinge(bricks, pivot));
    } else if (line.isPoint) {
      found.ballJoints.emplace_back(pivot.brickA, pivot.brickB);
    } else if (!line.direction.isZero()) {
      // A line along the thickness is a corner with both faces joined, one in the tile an edge.
      const bool isAcross = std::abs(line.direction.dot(brick.normal)) > std::sqrt(0.5);
      found.hinges.push_back(isAcross ? cornerHinge(bricks, pivot)
                                      : foldHinge(bricks, pivot, line.direction));
    }
  }
  return found;
}

double hingeAngle(const Hinge& hinge, const Poses& poses) {
  const Quaternion& a = poses[static_cast<std::size_t>(hinge.brickA)].rotation;
  const Quaternion& b = poses[static_cast<std::size_t>(hinge.brickB)].rotation;
  // The twist about the axis, as the header of this file says; Re and Im of the quaternion are w
  // and vec().
  const Quaternion between = a.conjugate() * b;
  const double turn = 2 * std::atan2(hinge.axis.dot(between.vec()), between.w());
  return nearest(hinge.start + turn, 0.5 * (hinge.least + hinge.most));
}

double hingeRate(const Hinge& hinge, const Motion& motion) {
  const auto a = static_cast<std::size_t>(hinge.brickA), b = static_cast<std::size_t>(hinge.brickB);
  const Vector3 axis = motion.poses[a].rotation * hinge.axis;
  return axis.dot(motion.velocities[b].angular - motion.velocities[a].angular);
}

std::vector<double> hingeMoments(std::span<const HingeSpring> springs, const Poses& poses) {
  std::vector<double> moments;
  for (const HingeSpring& spring : springs) {
    moments.push_back(spring.stiffness * (spring.rest - hingeAngle(spring.hinge, poses)));
  }
  return moments;
}

double elasticEnergy(std::span<const HingeSpring> springs, const Poses& poses) {
  double sum = 0;
  for (const HingeSpring& spring : springs) {
    const double turn = hingeAngle(spring.hinge, poses) - spring.rest;
    sum += 0.5 * spring.stiffness * turn * turn;
  }
  return sum;
}

Elasticity elasticityOf(std::span<const HingeSpring> springs, const Poses& start,
                        const Poses& end) {
  Elasticity found{static_cast<int>(springs.size()), elasticEnergy(springs, start),
                   elasticEnergy(springs, end)};
  for (const double moment : hingeMoments(springs, end)) {
    found.momentEnd = std::max(found.momentEnd, std::abs(moment));
  }
  return found;
}

}  // namespace kirireel
