#include "render/inspect/line_of_sight.h"

#include <algorithm>
#include <cmath>

namespace kirireel {

namespace {

// Tiles nearer than this, of their own radius, touch the point rather than hide it.
constexpr double kTouch = 1e-3;

}  // namespace

LineOfSight::LineOfSight(const std::vector<Tile>& tiles, const Vector3& towardsEye)
    : towardsEye_(towardsEye) {
  for (const Tile& tile : tiles) {
    Screen& screen = screens_.emplace_back();
    screen.vertices = tile.vertices;
    screen.normal = tileNormal(tile);
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
  if (slope == 0) return false;
  const double distance = screen.normal.dot(offset) / slope;
  if (distance < kTouch * screen.radius) return false;
  // Where the line of sight meets the tile's plane: inside when it is left of every edge.
  const Vector3 meeting = point + distance * towardsEye_;
  for (std::size_t k = 0; k < screen.vertices.size(); ++k) {
    const Vector3& from = screen.vertices[k];
    const Vector3& to = screen.vertices[(k + 1) % screen.vertices.size()];
    if ((to - from).cross(meeting - from).dot(screen.normal) < 0) return false;
  }
  return true;
}

}  // namespace kirireel
