#include "sim/formats/middle_lines.h"

#include <algorithm>
#include <cmath>

namespace kirireel::formats {
namespace {

Vector2 nearestOn(const DrawnPath& path, const Vector2& point) {
  Vector2 nearest = path.points.front();
  for (std::size_t k = 0; k + 1 < path.points.size(); ++k) {
    const Vector2 place = nearestOnSegment(point, path.points[k], path.points[k + 1]);
    if ((place - point).norm() < (nearest - point).norm()) nearest = place;
  }
  return nearest;
}

}  // namespace

double distanceTo(const PlaneSegment& line, const Vector2& point) {
  return (nearestOnSegment(point, line.first, line.second) - point).norm();
}

double apartOf(const DrawnPath& a, const DrawnPath& b) {
  const auto ends = [&](const Vector2& first, const Vector2& last) {
    return std::max((a.points.front() - first).norm(), (a.points.back() - last).norm());
  };
  double apart =
      std::min(ends(b.points.front(), b.points.back()), ends(b.points.back(), b.points.front()));
  for (const auto& [one, other] : {std::pair(&a, &b), {&b, &a}}) {
    for (const Vector2& point : one->points) {
      apart = std::max(apart, (nearestOn(*other, point) - point).norm());
    }
  }
  return apart;
}

DrawnPath middleOf(const DrawnPath& a, const DrawnPath& b) {
  DrawnPath middle = a;
  const bool isSame =
      (a.points.front() - b.points.front()).norm() < (a.points.front() - b.points.back()).norm();
  for (Vector2& point : middle.points) point = 0.5 * (point + nearestOn(b, point));
  const auto furtherEnd = [](const Vector2& end, const Vector2& before, const Vector2& other) {
    const Vector2 along = (end - before).normalized();
    return Vector2(0.5 * (end + other) + 0.5 * std::abs((end - other).dot(along)) * along);
  };
  const auto& p = a.points;
  middle.points.front() = furtherEnd(p.front(), p[1], isSame ? b.points.front() : b.points.back());
  middle.points.back() =
      furtherEnd(p.back(), p[p.size() - 2], isSame ? b.points.back() : b.points.front());
  return middle;
}

std::optional<DrawnPath> middleOfThin(const DrawnPath& ring, double most) {
  constexpr double kSlender = 4;  // length / width, at least
  std::vector<Vector2> points = ring.points;
  const auto farthestFrom = [&](const Vector2& from) {
    return std::ranges::max_element(points, {},
                                    [&](const Vector2& p) { return (p - from).norm(); });
  };
  std::rotate(points.begin(), farthestFrom(*farthestFrom(points.front())), points.end());
  const auto half = farthestFrom(points.front());
  const Vector2 first = points.front(), last = *half;
  DrawnPath middle = ring, side = ring;
  middle.isClosed = side.isClosed = false;
  middle.points.assign(points.begin(), half + 1);
  side.points.assign(half, points.end());
  side.points.push_back(first);
  const double apart = apartOf(middle, side);
  if (apart > most || (last - first).norm() <= kSlender * apart) return std::nullopt;
  // Corners and round ends become one point.
  const auto isAt = [&](const Vector2& tip, const Vector2& point) {
    return (point - tip).norm() <= 1.5 * apart;
  };
  const auto end = [&](const Vector2& tip) {
    Vector2 sum(0, 0);
    int count = 0;
    for (const Vector2& point : points) {
      if (!isAt(tip, point)) continue;
      sum += point;
      ++count;
    }
    return Vector2(sum / count);
  };
  std::erase_if(middle.points,
                [&](const Vector2& point) { return isAt(first, point) || isAt(last, point); });
  for (Vector2& point : middle.points) point = 0.5 * (point + nearestOn(side, point));
  middle.points.insert(middle.points.begin(), end(first));
  middle.points.push_back(end(last));
  return middle;
}

}  // namespace kirireel::formats
