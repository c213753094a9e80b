// A point with normal n receives of a uniformly bright sky the part
//
//   F = (1 / 2 pi) sum_k angle(r_k, r_k+1) n . (r_k x r_k+1) / |r_k x r_k+1|
//
// through a polygon whose corners are seen from it in the directions r_k: Lambert's formula, exact
// for a polygon above the point's horizon, to which polygons are cut first (J. Arvo, "Analytic
// Methods for Simulated Light Transport", 1995, section 4.3). Those faces of a convex brick that
// look at the point tile its outline, so that their parts add up to the brick's. Bricks that may
// hide each other are taken as independent: 1 - prod_b (1 - w_b F_b). The weight w_b falls to 0 at
// a reach of two or three tiles, so that creases, gaps and the insides of tubes are dark.
//
// The result is smooth in the poses, needs no random directions, and is one number a face: faces
// stay flat, in pixels and in vector graphics alike.
#include "render/picture/occlusion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/interruption.h"

namespace kirireel {
namespace {

/// In mean radii of bricks.
constexpr double kReach = 2.5;

/// Points of a face stand half way between its middle and its corners; thin faces have their middle
/// alone.
constexpr double kThinFace = 0.25;

Vector3 meanOf(std::span<const Vector3> points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Its length is the area, its direction the normal of an anticlockwise polygon.
Vector3 vectorArea(std::span<const Vector3> corners) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 2; k < corners.size(); ++k) {
    sum += 0.5 * (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]);
  }
  return sum;
}

double longestSide(std::span<const Vector3> corners) {
  double longest = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    longest = std::max(longest, (corners[(k + 1) % corners.size()] - corners[k]).norm());
  }
  return longest;
}

/// The part of a polygon above a point's horizon, its corners relative to the point. Sutherland and
/// Hodgman's clipping at one plane. `above` is emptied first and keeps its memory.
void cutToHorizon(std::span<const Vector3> corners, const Vector3& point, const Vector3& normal,
                  std::vector<Vector3>& above) {
  above.clear();
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3 here = corners[k] - point, next = corners[(k + 1) % corners.size()] - point;
    const double height = normal.dot(here), nextHeight = normal.dot(next);
    if (height > 0) above.push_back(here);
    if ((height > 0) == (nextHeight > 0)) continue;
    above.push_back(here + height / (height - nextHeight) * (next - here));
  }
}

/// Lambert's formula for corners relative to the point. 0 for fewer than three corners. The angle
/// between two directions is atan2(|r x r'|, r . r'), which is exact for small angles, too.
double skyPart(const std::vector<Vector3>& corners, const Vector3& normal) {
  double sum = 0;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3& from = corners[k];
    const Vector3& to = corners[(k + 1) % corners.size()];
    const Vector3 across = from.cross(to);
    const double size = across.norm();
    if (size > 0) sum += std::atan2(size, from.dot(to)) * normal.dot(across) / size;
  }
  return std::abs(sum) / (2 * std::numbers::pi);
}

/// From 1 at distance 0 to 0 at the reach and beyond, smoothly. 1 - 3 s^2 + 2 s^3, whose slope is
/// zero at both ends.
double weightAt(double distance, double reach) {
  const double share = std::clamp(distance / reach, 0.0, 1.0);
  return 1 - share * share * (3 - 2 * share);
}

}  // namespace

Occluders::Occluders(const std::vector<std::vector<std::vector<Vector3>>>& faces) {
  double radii = 0;
  for (std::size_t brick = 0; brick < faces.size(); ++brick) {
    Occluder& made = occluders_.emplace_back();
    made.brick = static_cast<int>(brick);
    made.centre = 0.5 * (meanOf(faces[brick][0]) + meanOf(faces[brick][1]));
    for (const std::vector<Vector3>& corners : faces[brick]) {
      Wall wall{corners, vectorArea(corners).normalized(), 0};
      wall.offset = wall.normal.dot(corners[0]);
      for (const Vector3& corner : corners) {
        made.radius = std::max(made.radius, (corner - made.centre).norm());
      }
      made.walls.push_back(std::move(wall));
    }
    radii += made.radius;
    mostRadius_ = std::max(mostRadius_, made.radius);
  }
  reach_ = kReach * radii / std::max<double>(1, static_cast<double>(faces.size()));
  std::ranges::stable_sort(occluders_, {}, [](const Occluder& o) { return o.centre.x(); });
}

double Occluders::occlusionAt(int brick, const Vector3& point, const Vector3& normal) const {
  const double farthest = reach_ + mostRadius_;
  std::vector<Vector3> above;
  double open = 1;
  auto at = std::ranges::lower_bound(occluders_, point.x() - farthest, {},
                                     [](const Occluder& o) { return o.centre.x(); });
  for (; at != occluders_.end() && at->centre.x() <= point.x() + farthest; ++at) {
    const Vector3 towards = at->centre - point;
    const double distance = towards.norm() - at->radius;
    const bool isBelow = normal.dot(towards) <= -at->radius;
    if (at->brick == brick || distance >= reach_ || isBelow) continue;
    double part = 0;
    for (const Wall& wall : at->walls) {
      if (wall.normal.dot(point) <= wall.offset) continue;
      cutToHorizon(wall.corners, point, normal, above);
      part += skyPart(above, normal);
    }
    open *= 1 - weightAt(distance, reach_) * std::min(1.0, part);
  }
  return 1 - open;
}

double Occluders::occlusion(int brick, std::span<const Vector3> corners,
                            const Vector3& normal) const {
  const Vector3 middle = meanOf(corners);
  const double side = longestSide(corners);
  if (vectorArea(corners).norm() < kThinFace * side * side) {
    return occlusionAt(brick, middle, normal);
  }
  double sum = 0;
  for (const Vector3& corner : corners) {
    sum += occlusionAt(brick, 0.5 * (middle + corner), normal);
  }
  return sum / static_cast<double>(corners.size());
}

}  // namespace kirireel
