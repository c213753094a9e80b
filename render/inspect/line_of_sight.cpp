// A ray from the point p towards the eye, in the direction e (a unit vector; the eye is infinitely
// far), meets the plane of a tile with normal n and middle m at
//
//     p + t e,    t = n . (m - p) / (n . e).
//
// The tile hides p when t > 0 and that place lies within one of the tile's convex parts. Tiles
// farther from the ray than their radius are left out first: |(m - p) x e| is the distance of m
// from the ray.
//
// Each question looks at all tiles, so that a picture of n tiles costs n^2 of them.
#include "render/inspect/line_of_sight.h"

#include <algorithm>
#include <cmath>

#include "sim/model/convex_parts.h"

namespace kirireel {

namespace {

// Tiles nearer than this, of their own radius, touch the point rather than hide it.
constexpr double kTouch = 1e-3;

/// Whether a point of the plane is left of every edge.
bool isWithin(const std::vector<Vector3>& corners, const Vector3& normal, const Vector3& point) {
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vector3& from = corners[k];
    const Vector3& to = corners[(k + 1) % corners.size()];
    if ((to - from).cross(point - from).dot(normal) < 0) return false;
  }
  return true;
}

}  // namespace

LineOfSight::LineOfSight(const std::vector<Tile>& tiles, const Vector3& towardsEye)
    : towardsEye_(towardsEye) {
  for (const Tile& tile : tiles) {
    Screen& screen = screens_.emplace_back();
    screen.normal = tileNormal(tile);
    for (const PolygonPart& part : convexParts(tile.vertices, screen.normal)) {
      std::vector<Vector3>& corners = screen.parts.emplace_back();
      for (const int corner : part) corners.push_back(tile.vertices[corner]);
    }
    screen.middle = tileCentroid(tile);
    for (const Vector3& vertex : tile.vertices) {
      screen.radius = std::max(screen.radius, (vertex - screen.middle).norm());
    }
  }
}

bool LineOfSight::isClear(const Vector3& point, std::size_t tile) const {
  for (std::size_t k = 0; k < screens_.size(); ++k) {
    if (k != tile && hides(screens_[k], point)) return false;
  }
  return true;
}

bool LineOfSight::hides(const Screen& screen, const Vector3& point) const {
  const Vector3 offset = screen.middle - point;
  if (offset.cross(towardsEye_).squaredNorm() > screen.radius * screen.radius) return false;
  const double slope = screen.normal.dot(towardsEye_);
  // Seen edge-on a tile hides nothing.
  if (slope == 0) return false;
  const double distance = screen.normal.dot(offset) / slope;
  // Behind the point, or so near that it touches it, as joined tiles do.
  if (distance < kTouch * screen.radius) return false;
  const Vector3 meeting = point + distance * towardsEye_;
  return std::any_of(screen.parts.begin(), screen.parts.end(),
                     [&](const auto& part) { return isWithin(part, screen.normal, meeting); });
}

}  // namespace kirireel
