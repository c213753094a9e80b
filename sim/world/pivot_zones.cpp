// Zones round shared pivots in which Bullet's contact points are dropped: balls round single
// pivots, cylinders with round ends round hinge lines. They are kept in the axes of the pair's
// first brick, with which the pivot moves.
#include "sim/world/pivot_zones.h"

#include <algorithm>

#include "sim/world/inset_hull.h"

namespace kirireel {
namespace {

// Rounded hulls touch beside a common corner within a few margins of it.
constexpr double kMargins = 4;
// A twentieth of an edge is small against a tile.
constexpr double kEdges = 0.05;

// Metres; the larger of the two rules.
double zoneRadius(const Brick& a, const Brick& b) {
  const double margin = std::max(contactMargin(a), contactMargin(b));
  return std::max(kMargins * margin, kEdges * 0.5 * (meanEdge(a) + meanEdge(b)));
}

// A segment without length is a point.
double distanceToSegment(const Vector3& point, const Vector3& from, const Vector3& to) {
  const Vector3 along = to - from;
  const double squaredLength = along.squaredNorm();
  if (squaredLength == 0) return (point - from).norm();
  const double part = std::clamp((point - from).dot(along) / squaredLength, 0.0, 1.0);
  return (point - from - part * along).norm();
}

}  // namespace

PivotZones::PivotZones(const std::vector<Brick>& bricks, std::span<const Pivot> pivots) {
  for (const Pivot& pivot : pivots) {
    if (pivot.distance == 0) add(bricks, pivot);
  }
}

void PivotZones::add(const std::vector<Brick>& bricks, const Pivot& pivot) {
  const bool swapped = pivot.brickB < pivot.brickA;
  const std::pair<int, int> pair = std::minmax(pivot.brickA, pivot.brickB);
  const Vector3& point = swapped ? pivot.pointB : pivot.pointA;
  std::vector<Zone>& zones = zones_[pair];
  // Both pivots of a hinge follow each other: the second extends the first to a line.
  if (!zones.empty() && zones.back().joint == pivot.joint) {
    zones.back().to = point;
    return;
  }
  zones.push_back({point, point, zoneRadius(bricks[pair.first], bricks[pair.second]), pivot.joint});
}

bool PivotZones::contains(int brickA, int brickB, const Poses& poses, const Vector3& point) const {
  const std::pair<int, int> pair = std::minmax(brickA, brickB);
  const auto found = zones_.find(pair);
  if (found == zones_.end()) return false;
  const Pose& pose = poses[pair.first];
  const Vector3 local = pose.rotation.conjugate() * (point - pose.position);
  return std::ranges::any_of(found->second, [&](const Zone& zone) {
    return distanceToSegment(local, zone.from, zone.to) <= zone.radius;
  });
}

}  // namespace kirireel
