#include "render/fea/footprint.h"

#include <algorithm>
#include <map>

namespace kirireel {
namespace {

/// Below this sine of its angle, a corner of a quadrilateral counts as straight.
constexpr double kStraightSine = 0.05;

/// Grid points that triangles share, found by their whole-numbered weights on the bases.
class SharedPoints {
 public:
  SharedPoints(Footprint& footprint, int perEdge) : footprint_(footprint), perEdge_(perEdge) {}

  /// The point with these shares (of perEdge, in sum) of three bases.
  int find(const std::array<int, 3>& bases, const std::array<int, 3>& shares) {
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
      point.weights[k] = static_cast<double>(key[k].second) / perEdge_;
    }
    return point;
  }

  Footprint& footprint_;
  int perEdge_;
  std::map<std::vector<std::pair<int, int>>, int> numbers_;
};

/// Divides one triangle: row i counts from the first base, place j along the row.
void appendTriangles(const std::array<int, 3>& bases, int perEdge, SharedPoints& points,
                     Footprint& footprint) {
  const auto point = [&](int i, int j) { return points.find(bases, {perEdge - i, i - j, j}); };
  for (int i = 0; i < perEdge; ++i) {
    for (int j = 0; j <= i; ++j) {
      footprint.cells.push_back({point(i, j), point(i + 1, j), point(i + 1, j + 1), -1});
      if (j == i) continue;
      footprint.cells.push_back({point(i, j), point(i + 1, j + 1), point(i, j + 1), -1});
    }
  }
}

int cornersOf(const std::array<int, 4>& cell) {
  return cell[3] < 0 ? 3 : 4;
}

void collectEdges(Footprint& footprint) {
  for (const std::array<int, 4>& cell : footprint.cells) {
    const int count = cornersOf(cell);
    for (int k = 0; k < count; ++k) {
      const auto [low, high] = std::minmax(cell[k], cell[(k + 1) % count]);
      footprint.edges.push_back({low, high});
    }
  }
  std::ranges::sort(footprint.edges);
  const auto repeated = std::ranges::unique(footprint.edges);
  footprint.edges.erase(repeated.begin(), repeated.end());
}

}  // namespace

Vector3 FootprintPoint::at(const std::vector<Vector3>& verticesAndCentre) const {
  Vector3 sum = weights[0] * verticesAndCentre[bases[0]];
  for (std::size_t k = 1; k < weights.size(); ++k) {
    if (weights[k] != 0) sum += weights[k] * verticesAndCentre[bases[k]];
  }
  return sum;
}

Footprint gridFootprint(int perEdge) {
  Footprint footprint;
  const auto share = [&](int k) { return static_cast<double>(k) / perEdge; };
  const auto point = [&](int i, int j) { return j * (perEdge + 1) + i; };
  for (int j = 0; j <= perEdge; ++j) {
    for (int i = 0; i <= perEdge; ++i) {
      const double u = share(i);
      const double v = share(j);
      footprint.points.push_back(
          {{0, 1, 2, 3}, {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v}});
      if (i == perEdge || j == perEdge) continue;
      footprint.cells.push_back(
          {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
    }
  }
  footprint.corners = {point(0, 0), point(perEdge, 0), point(perEdge, perEdge), point(0, perEdge)};
  collectEdges(footprint);
  return footprint;
}

Footprint fanFootprint(int sides, int perEdge) {
  Footprint footprint;
  SharedPoints points(footprint, perEdge);
  if (sides == 3) {
    appendTriangles({0, 1, 2}, perEdge, points, footprint);
  } else {
    for (int k = 0; k < sides; ++k) {
      appendTriangles({sides, k, (k + 1) % sides}, perEdge, points, footprint);
    }
  }
  for (int k = 0; k < sides; ++k) {
    footprint.corners.push_back(points.find({k, k, k}, {perEdge, 0, 0}));
  }
  collectEdges(footprint);
  return footprint;
}

Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int perEdge) {
  Footprint footprint;
  SharedPoints points(footprint, perEdge);
  for (const std::array<int, 3>& triangle : triangles) {
    appendTriangles(triangle, perEdge, points, footprint);
  }
  for (int k = 0; k < sides; ++k) {
    footprint.corners.push_back(points.find({k, k, k}, {perEdge, 0, 0}));
  }
  collectEdges(footprint);
  return footprint;
}

bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal) {
  if (vertices.size() != 4) return false;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3 before = (vertices[k] - vertices[(k + 3) % 4]).normalized();
    const Vector3 after = (vertices[(k + 1) % 4] - vertices[k]).normalized();
    if (before.cross(after).dot(normal) < kStraightSine) return false;
  }
  return true;
}

}  // namespace kirireel
