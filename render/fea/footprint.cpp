// Divides a polygon with n vertices into quadrilaterals, as shares of its vertices and its centre.
// Nothing here knows positions: the same footprint serves all tiles with n vertices and the same
// counts, at the bottom and at the top.
//
// A grid has bilinear points (u, v in 0 to 1 along edges 0 and 1):
//
//     p = (1-u)(1-v) v0 + u (1-v) v1 + u v v2 + (1-u) v v3.
//
// Graded, u = (1 - cos(pi k / n)) / 2: shells bend most near clamped and hinged edges, where these
// Chebyshev points are dense.
//
// Any other polygon is fanned round its centre into triangles, and each triangle is cut into three
// quadrilaterals at its centroid and the middles of its sides, which fit together at every side of
// every triangle because both halves of a side have equal cells. A paving mesher would give better
// shapes and other meshes for each tile; this one is exact, symmetric, and the same for equal
// tiles.
//
// Points are found by whole numbers (shares of 6 m^2 with m cells along half an edge), never by
// distance: equal points are equal keys, however small a tile is.
#include "render/fea/footprint.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace kirireel {
namespace {

/// Below this sine of its angle, a corner of a quadrilateral counts as straight. About 3 degrees:
/// beyond, a quadrilateral has nearly lost a corner, and its map is singular there.
constexpr double kStraightSine = 0.05;

/// Grid points that quadrilaterals share, found by their whole-numbered shares of the bases.
class SharedPoints {
 public:
  /// All shares of one point add up to `whole`.
  SharedPoints(Footprint& footprint, int whole) : footprint_(footprint), whole_(whole) {}

  /// The point with these shares of three bases.
  int find(const std::array<int, 3>& bases, const std::array<int, 3>& shares) {
    // A base with share 0 is left out, so that a point on a side has one key from both triangles.
    std::vector<std::pair<int, int>> key;
    for (int k = 0; k < 3; ++k) {
      if (shares[k] > 0) key.emplace_back(bases[k], shares[k]);
    }
    std::ranges::sort(key);
    const auto [place, isNew] = numbers_.try_emplace(key, footprint_.points.size());
    if (isNew) footprint_.points.push_back(pointOf(key));
    return place->second;
  }

 private:
  FootprintPoint pointOf(const std::vector<std::pair<int, int>>& key) const {
    FootprintPoint point;
    for (std::size_t k = 0; k < key.size(); ++k) {
      point.bases[k] = key[k].first;
      point.weights[k] = static_cast<double>(key[k].second) / whole_;
    }
    return point;
  }

  Footprint& footprint_;
  int whole_;
  std::map<std::vector<std::pair<int, int>>, int> numbers_;
};

/// Cuts a triangle into three quadrilaterals of n x n cells each. The one at corner c reaches from
/// there to the middles of the two sides and to the centre; its point (i, j) lies i / n of the way
/// along the side to the next corner and j / n along the other. In shares of 6 n^2 all points are
/// whole numbers: a corner counts 6, a middle 3 + 3, the centre 2 + 2 + 2.
/// `onEdge` tells the tile's edge on the side from corner c to the next, or -1.
void appendTriangle(const std::array<int, 3>& bases, const std::array<int, 3>& onEdge, int n,
                    SharedPoints& points, Footprint& footprint) {
  for (int c = 0; c < 3; ++c) {
    const int next = (c + 1) % 3;
    const int previous = (c + 2) % 3;
    const auto point = [&](int i, int j) {
      std::array<int, 3> shares{};
      shares[c] = 6 * (n - i) * (n - j) + 3 * i * (n - j) + 3 * (n - i) * j + 2 * i * j;
      shares[next] = 3 * i * (n - j) + 2 * i * j;
      shares[previous] = 3 * (n - i) * j + 2 * i * j;
      return points.find(bases, shares);
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const int cell = static_cast<int>(footprint.cells.size());
        footprint.cells.push_back(
            {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
        if (j == 0 && onEdge[c] >= 0) footprint.sides.push_back({cell, 0, onEdge[c]});
        if (i == 0 && onEdge[previous] >= 0) footprint.sides.push_back({cell, 3, onEdge[previous]});
      }
    }
  }
}

/// Sides are sorted by edge, stable, so that along an edge they stay in the order of cells.
void finish(Footprint& footprint) {
  footprint.edges = edgesOf(footprint.cells);
  std::ranges::stable_sort(footprint.sides, {}, &FootprintSide::tileEdge);
}

}  // namespace

Vector3 FootprintPoint::at(const std::vector<Vector3>& verticesAndCentre) const {
  // A corner has one weight of 1 and no other term, so it is the vertex to the last bit.
  Vector3 sum = weights[0] * verticesAndCentre[bases[0]];
  for (std::size_t k = 1; k < weights.size(); ++k) {
    if (weights[k] != 0) sum += weights[k] * verticesAndCentre[bases[k]];
  }
  return sum;
}

Footprint gridFootprint(int first, int second, bool isGraded) {
  Footprint footprint;
  const auto share = [isGraded](int k, int count) {
    const double even = static_cast<double>(k) / count;
    return isGraded ? 0.5 * (1 - std::cos(std::numbers::pi * even)) : even;
  };
  const auto point = [&](int i, int j) { return j * (first + 1) + i; };
  for (int j = 0; j <= second; ++j) {
    for (int i = 0; i <= first; ++i) {
      const double u = share(i, first);
      const double v = share(j, second);
      footprint.points.push_back(
          {{0, 1, 2, 3}, {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v}});
      if (i == first || j == second) continue;
      const int cell = static_cast<int>(footprint.cells.size());
      footprint.cells.push_back(
          {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
      if (j == 0) footprint.sides.push_back({cell, 0, 0});
      if (i + 1 == first) footprint.sides.push_back({cell, 1, 1});
      if (j + 1 == second) footprint.sides.push_back({cell, 2, 2});
      if (i == 0) footprint.sides.push_back({cell, 3, 3});
    }
  }
  footprint.corners = {point(0, 0), point(first, 0), point(first, second), point(0, second)};
  footprint.isRow = std::min(first, second) == 1;
  finish(footprint);
  return footprint;
}

Footprint fanFootprint(int sides, int halfPerEdge) {
  const int whole = 6 * halfPerEdge * halfPerEdge;
  Footprint footprint;
  SharedPoints points(footprint, whole);
  // A triangle needs no centre: its own three sides are the tile's edges.
  if (sides == 3) {
    appendTriangle({0, 1, 2}, {0, 1, 2}, halfPerEdge, points, footprint);
  } else {
    for (int k = 0; k < sides; ++k) {
      // Base number `sides` is the centre. Only the side from vertex k to the next is an edge.
      appendTriangle({sides, k, (k + 1) % sides}, {-1, k, -1}, halfPerEdge, points, footprint);
    }
  }
  for (int k = 0; k < sides; ++k) {
    footprint.corners.push_back(points.find({k, k, k}, {whole, 0, 0}));
  }
  finish(footprint);
  return footprint;
}

Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int halfPerEdge) {
  const int whole = 6 * halfPerEdge * halfPerEdge;
  Footprint footprint;
  SharedPoints points(footprint, whole);
  for (const std::array<int, 3>& triangle : triangles) {
    std::array<int, 3> onEdge{};
    for (int k = 0; k < 3; ++k) {
      // Triangles are of vertices alone; a side is an edge where it leads to the next vertex, else
      // a diagonal within the tile.
      const bool isEdge = triangle[(k + 1) % 3] == (triangle[k] + 1) % sides;
      onEdge[k] = isEdge ? triangle[k] : -1;
    }
    appendTriangle(triangle, onEdge, halfPerEdge, points, footprint);
  }
  for (int k = 0; k < sides; ++k) {
    footprint.corners.push_back(points.find({k, k, k}, {whole, 0, 0}));
  }
  finish(footprint);
  return footprint;
}

std::vector<std::array<int, 2>> edgesOf(const std::vector<std::array<int, 4>>& cells) {
  std::vector<std::array<int, 2>> edges;
  for (const std::array<int, 4>& cell : cells) {
    for (int k = 0; k < 4; ++k) {
      const auto [low, high] = std::minmax(cell[k], cell[(k + 1) % 4]);
      edges.push_back({low, high});
    }
  }
  std::ranges::sort(edges);
  const auto repeated = std::ranges::unique(edges);
  edges.erase(repeated.begin(), repeated.end());
  return edges;
}

bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal) {
  if (vertices.size() != 4) return false;
  for (std::size_t k = 0; k < 4; ++k) {
    // The sine of the turn at vertex k; negative where the tile is concave.
    const Vector3 before = (vertices[k] - vertices[(k + 3) % 4]).normalized();
    const Vector3 after = (vertices[(k + 1) % 4] - vertices[k]).normalized();
    if (before.cross(after).dot(normal) < kStraightSine) return false;
  }
  return true;
}

}  // namespace kirireel
