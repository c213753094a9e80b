// Overlaps and shapes of tiles without thickness.
//
// Flat neighbours (planes parallel to 1e-6 and at one height) are compared in their plane by
// separating axes, the directions across the edges of both. Tiles in different planes reach through
// each other where the line in which their planes meet passes through both: their depth is the
// least of five lengths, how far each stands out on either side of the other's plane and how much
// their cuts on that line have in common. Concave tiles are looked at part by part. Pairs come from
// a sweep along x.
#include "sim/measure/sheet.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "sim/measure/measures.h"
#include "sim/model/convex_parts.h"

namespace kirireel {
namespace {

// Planes whose normals differ by less than this sine are compared as one plane.
constexpr double kParallelPlanes = 1e-6;

/// A tile, or a convex part of one, with what the tests of a pair need.
struct PlacedTile {
  int tile = 0;
  std::vector<Vector3> vertices;
  Vector3 normal;
  Eigen::AlignedBox3d box;
};

/// An interval along a line.
struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// How far one interval must move to be clear of the other; negative when it is.
double overlap(const Interval& a, const Interval& b) {
  return std::min(a.high - b.low, b.high - a.low);
}

// Projections of the vertices on an axis from an origin. The origin lies at the tile, so that far
// from the world's origin no digits are lost.
Interval project(const PlacedTile& tile, const Vector3& axis, const Vector3& origin) {
  Interval interval;
  for (const Vector3& vertex : tile.vertices) interval.extend(axis.dot(vertex - origin));
  return interval;
}

/// The least overlap over the directions across the edges of both (separating axes).
double depthInPlane(const PlacedTile& a, const PlacedTile& b) {
  double depth = std::numeric_limits<double>::infinity();
  for (const PlacedTile* tile : {&a, &b}) {
    const std::vector<Vector3>& vertices = tile->vertices;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const Vector3 edge = vertices[(k + 1) % vertices.size()] - vertices[k];
      const Vector3 across = edge.cross(tile->normal).normalized();
      depth = std::min(depth,
                       overlap(project(a, across, vertices[k]), project(b, across, vertices[k])));
    }
  }
  return depth;
}

/// The part of the line origin + t direction that lies in the tile, where the tile's plane holds
/// the line.
Interval cut(const PlacedTile& tile, const Vector3& planeNormal, const Vector3& origin,
             const Vector3& direction) {
  Interval interval;
  const std::vector<Vector3>& vertices = tile.vertices;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const Vector3& from = vertices[k];
    const Vector3& to = vertices[(k + 1) % vertices.size()];
    const double before = planeNormal.dot(from - origin);
    const double after = planeNormal.dot(to - origin);
    // The edge does not cross the plane. A corner exactly on it counts to one side only.
    if ((before < 0) == (after < 0)) continue;
    const Vector3 crossing = from + before / (before - after) * (to - from);
    interval.extend(direction.dot(crossing - origin));
  }
  return interval;
}

/// How far tiles in different planes reach through each other: the least of how far each stands out
/// on either side of the other's plane and of the length that their cuts share.
double depthAcross(const PlacedTile& a, const PlacedTile& b) {
  const Vector3 direction = a.normal.cross(b.normal).normalized();
  const Vector3& pointA = a.vertices.front();
  const Vector3& pointB = b.vertices.front();
  // A point of both planes, nearest to the first tile's.
  // The direction in A's plane that leads straight to the common line.
  const Vector3 inA = direction.cross(a.normal);
  const Vector3 origin = pointA + b.normal.dot(pointB - pointA) / b.normal.dot(inA) * inA;
  const Interval aboutB = project(a, b.normal, pointB);
  const Interval aboutA = project(b, a.normal, pointA);
  const double shared =
      overlap(cut(a, b.normal, origin, direction), cut(b, a.normal, origin, direction));
  return std::min({shared, aboutB.high, -aboutB.low, aboutA.high, -aboutA.low});
}

// The depth of two convex tiles, metres; not above 0 where they are clear of each other.
// `tolerance`: heights that differ by less count as one.
double depthOf(const PlacedTile& a, const PlacedTile& b, double tolerance) {
  if (a.normal.cross(b.normal).norm() > kParallelPlanes) return depthAcross(a, b);
  const Vector3& origin = a.vertices.front();
  const Interval height = project(b, a.normal, origin);
  // Parallel planes at different heights.
  if (height.low > tolerance || height.high < -tolerance) return 0;
  return depthInPlane(a, b);
}

std::vector<PlacedTile> convexPartsOf(const std::vector<Tile>& tiles) {
  std::vector<PlacedTile> placed;
  for (int i = 0; i < std::ssize(tiles); ++i) {
    const std::vector<Vector3>& vertices = tiles[std::size_t(i)].vertices;
    const Vector3 normal = tileNormal(tiles[std::size_t(i)]);
    for (const PolygonPart& part : convexParts(vertices, normal)) {
      PlacedTile& entry = placed.emplace_back(PlacedTile{i, {}, normal, {}});
      for (const int corner : part) {
        entry.vertices.push_back(vertices[std::size_t(corner)]);
        entry.box.extend(entry.vertices.back());
      }
    }
  }
  return placed;
}

}  // namespace

// Sweep along x, then each pair's depth.
std::vector<TileOverlap> tileOverlaps(const std::vector<Tile>& tiles, double tolerance) {
  const std::vector<PlacedTile> placed = convexPartsOf(tiles);
  // In order of their left sides, a tile can only meet those that start before it ends.
  std::vector<int> order(placed.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return placed[std::size_t(a)].box.min().x() < placed[std::size_t(b)].box.min().x();
  });
  std::map<std::pair<int, int>, double> depths;  // the deepest pair of parts
  long left = mostPairs(tiles.size());
  for (std::size_t i = 0; i < order.size() && left > 0; ++i) {
    const PlacedTile& first = placed[std::size_t(order[i])];
    for (std::size_t j = i + 1; j < order.size() && left > 0; ++j) {
      const PlacedTile& second = placed[std::size_t(order[j])];
      if (second.box.min().x() > first.box.max().x() - tolerance) break;
      if (first.tile == second.tile || !first.box.intersects(second.box)) continue;
      --left;
      const double depth = depthOf(first, second, tolerance);
      if (depth <= tolerance) continue;
      double& deepest = depths[std::minmax(first.tile, second.tile)];
      deepest = std::max(deepest, depth);
    }
  }
  std::vector<TileOverlap> found;
  for (const auto& [pair, depth] : depths) found.push_back({pair.first, pair.second, depth});
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.depth > b.depth; });
  return found;
}

double largestJointGap(const std::vector<Joint>& joints, const std::vector<Tile>& tiles) {
  double largest = 0;
  for (const Joint& joint : joints) {
    if (joint.kind != JointKind::Pivot) continue;
    const Vector3& a = tiles[std::size_t(joint.a.tile)].vertices[std::size_t(joint.a.vertex)];
    const Vector3& b = tiles[std::size_t(joint.b.tile)].vertices[std::size_t(joint.b.vertex)];
    largest = std::max(largest, (a - b).norm());
  }
  return largest;
}

double largestShapeChange(const std::vector<Tile>& start, const std::vector<Tile>& target) {
  double largest = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const std::vector<Vector3>& before = start[i].vertices;
    const std::vector<Vector3>& after = target[i].vertices;
    for (std::size_t b = 0; b < before.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const double change = (after[a] - after[b]).norm() - (before[a] - before[b]).norm();
        largest = std::max(largest, std::abs(change));
      }
    }
  }
  return largest;
}

double largestUnevenness(const std::vector<Tile>& tiles) {
  double largest = 0;
  for (const Tile& tile : tiles) {
    const Vector3 normal = tileNormal(tile);
    Vector3 middle = Vector3::Zero();
    for (const Vector3& vertex : tile.vertices) middle += vertex;
    middle /= static_cast<double>(tile.vertices.size());
    for (const Vector3& vertex : tile.vertices) {
      largest = std::max(largest, std::abs(normal.dot(vertex - middle)));
    }
  }
  return largest;
}

double leastCornerSine(const std::vector<Tile>& tiles) {
  double least = 1;
  for (const Tile& tile : tiles) {
    const Vector3 normal = tileNormal(tile);
    const std::size_t count = tile.vertices.size();
    for (std::size_t k = 0; k < count; ++k) {
      const Vector3 before = tile.vertices[k] - tile.vertices[(k + count - 1) % count];
      const Vector3 after = tile.vertices[(k + 1) % count] - tile.vertices[k];
      least = std::min(least, before.normalized().cross(after.normalized()).dot(normal));
    }
  }
  return least;
}

}  // namespace kirireel
