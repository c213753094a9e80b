// Bricks without shared corners. A corner at p becomes two corners on the edges to its neighbours:
// p + min(l / |e|, 0.4) e for each edge e. So a convex outline stays convex. An edge with both ends
// cut keeps at least a fifth of its length.
#include "sim/brick/contact.h"

namespace kirireel::brick {
namespace {

// Fraction of an edge, < 0.5 since both ends may be cut.
constexpr double kLargestCut = 0.4;

bool contains(const std::vector<int>& corners, int corner) {
  return std::find(corners.begin(), corners.end(), corner) != corners.end();
}

void note(std::vector<int>& corners, int corner) {
  if (!contains(corners, corner)) corners.push_back(corner);
}

}  // namespace

Brick withoutCorners(const Brick& brick, const std::vector<int>& corners, double length) {
  Brick cut = brick;
  cut.bottom.clear();
  const std::size_t count = brick.bottom.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& corner = brick.bottom[k];
    if (!contains(corners, static_cast<int>(k))) {
      cut.bottom.push_back(corner);
      continue;
    }
    for (const std::size_t neighbour : {(k + count - 1) % count, (k + 1) % count}) {
      const Vector3 edge = brick.bottom[neighbour] - corner;
      cut.bottom.emplace_back(corner + std::min(length / edge.norm(), kLargestCut) * edge);
    }
  }
  cut.top = cut.bottom;
  for (Vector3& point : cut.top) point += brick.thickness * brick.normal;
  return cut;
}

std::map<std::pair<int, int>, SharedCorners> sharedCorners(std::span<const Pivot> pivots) {
  std::map<std::pair<int, int>, SharedCorners> shared;
  for (const Pivot& pivot : pivots) {
    const bool swapped = pivot.brickB < pivot.brickA;
    SharedCorners& corners = shared[std::minmax(pivot.brickA, pivot.brickB)];
    corners.areOneTile = corners.areOneTile || pivot.isWithinTile;
    // The pair is still stored, since fixed and linked bricks count as joined.
    if (pivot.cornerA == kNoCorner) continue;
    note(corners.ofA, swapped ? pivot.cornerB : pivot.cornerA);
    note(corners.ofB, swapped ? pivot.cornerA : pivot.cornerB);
  }
  return shared;
}

Brick withoutCorners(const BrickPiece& piece, const std::vector<int>& corners, double length) {
  std::vector<int> own;
  for (std::size_t k = 0; k < piece.corners.size(); ++k) {
    if (contains(corners, piece.corners[k])) own.push_back(static_cast<int>(k));
  }
  return withoutCorners(piece.shape, own, length);
}

double cutLength(const Brick& a, const Brick& b, double zone) {
  return zone * 0.5 * (meanEdge(a) + meanEdge(b));
}

}  // namespace kirireel::brick
