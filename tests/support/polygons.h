/// Concave polygons for tests, and their properties computed without convex parts.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::test {

/// An L of two arms: `length` long along both axes, `width` wide, its outer corner at (x, y).
inline model::Tile lShape(double length = 3, double width = 1, double x = 0, double y = 0) {
  const auto at = [&](double u, double v) { return Vector3(x + u, y + v, 0); };
  return {{at(0, 0), at(length, 0), at(length, width), at(width, width), at(width, length),
           at(0, length)}};
}

/// A star of so many tips round (x, y), its first tip at `angle`.
inline model::Tile starShape(int tips, double outer, double inner, double x = 0, double y = 0,
                             double angle = 0) {
  model::Tile star;
  for (int k = 0; k < 2 * tips; ++k) {
    const double radius = k % 2 == 0 ? outer : inner;
    const double turn = angle + std::numbers::pi * k / tips;
    star.vertices.emplace_back(x + radius * std::cos(turn), y + radius * std::sin(turn), 0);
  }
  return star;
}

/// A polygon around the origin in steps of random length and radius.
inline model::Tile randomStar(std::mt19937& random, int corners) {
  std::uniform_real_distribution<double> share(0.2, 1);
  std::vector<double> steps;
  double sum = 0;
  for (int k = 0; k < corners; ++k) {
    steps.push_back(share(random));
    sum += steps.back();
  }
  model::Tile tile;
  double turn = 0;
  for (const double step : steps) {
    const double radius = share(random);
    tile.vertices.emplace_back(radius * std::cos(turn), radius * std::sin(turn), 0);
    turn += 2 * std::numbers::pi * step / sum;
  }
  return tile;
}

inline double cross2(const Vector3& a, const Vector3& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Whether a point lies within a polygon in the plane, by the even-odd rule.
inline bool isInside(const model::Tile& tile, const Vector3& p) {
  bool inside = false;
  const std::size_t count = tile.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& a = tile.vertices[k];
    const Vector3& b = tile.vertices[(k + 1) % count];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    if (p.x() < a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x())) inside = !inside;
  }
  return inside;
}

inline double distanceToSegment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 along = b - a;
  const double share = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - a - share * along).norm();
}

/// The distance of two polygons' outlines in the plane, metres; 0 if they cross. Brute force over
/// all sides.
inline double outlineDistance(const model::Tile& s, const model::Tile& t) {
  double least = std::numeric_limits<double>::max();
  const std::size_t m = s.vertices.size(), n = t.vertices.size();
  for (std::size_t i = 0; i < m; ++i) {
    const Vector3 &a = s.vertices[i], &b = s.vertices[(i + 1) % m];
    for (std::size_t j = 0; j < n; ++j) {
      const Vector3 &c = t.vertices[j], &d = t.vertices[(j + 1) % n];
      const bool crosses = cross2(b - a, c - a) * cross2(b - a, d - a) < 0 &&
                           cross2(d - c, a - c) * cross2(d - c, b - c) < 0;
      if (crosses) return 0;
      least = std::min({least, distanceToSegment(a, c, d), distanceToSegment(b, c, d),
                        distanceToSegment(c, a, b), distanceToSegment(d, a, b)});
    }
  }
  return least;
}

/// The depth of corners of either polygon in the other, metres: their distance from its outline.
inline double cornerDepth(const model::Tile& s, const model::Tile& t) {
  double deepest = 0;
  for (const auto& [one, other] : {std::pair{&s, &t}, std::pair{&t, &s}}) {
    for (const Vector3& p : one->vertices) {
      if (!isInside(*other, p)) continue;
      double depth = std::numeric_limits<double>::max();
      const std::size_t count = other->vertices.size();
      for (std::size_t k = 0; k < count; ++k) {
        depth = std::min(
            depth, distanceToSegment(p, other->vertices[k], other->vertices[(k + 1) % count]));
      }
      deepest = std::max(deepest, depth);
    }
  }
  return deepest;
}

/// Whether two polygons in the plane overlap.
inline bool overlap(const model::Tile& s, const model::Tile& t) {
  return outlineDistance(s, t) == 0 || isInside(s, t.vertices[0]) || isInside(t, s.vertices[0]);
}

}  // namespace kirireel::test
