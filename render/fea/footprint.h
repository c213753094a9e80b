/// How a tile is divided into quadrilaterals or triangles; a brick's elements stand on these.
#pragma once

#include <array>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel {

/// A point of a tile as a mean of its vertices; number n of an n-gon stands for the tile's centre.
struct FootprintPoint {
  std::array<int, 4> bases{};       ///< vertices, or n for the centre
  std::array<double, 4> weights{};  ///< sum 1, unused ones 0

  /// Where the point lies, given the n vertices and, after them, the centre.
  Vector3 at(const std::vector<Vector3>& verticesAndCentre) const;
};

/// Points, and the cells between them. The points of an edge between two tiles lie at equal shares
/// of it, whatever the tiles' numbers of sides.
struct Footprint {
  std::vector<FootprintPoint> points;
  std::vector<int> corners;               ///< the point at each vertex of the tile
  std::vector<std::array<int, 4>> cells;  ///< points, anticlockwise; the last is -1 in triangles
  std::vector<std::array<int, 2>> edges;  ///< of the cells, each once
};

/// A four-sided tile as a grid of perEdge x perEdge quadrilaterals; perEdge at least 1.
Footprint gridFootprint(int perEdge);

/// A tile of any number of sides as triangles: a triangle alone, others fanned round the centre,
/// each divided into perEdge x perEdge triangles.
Footprint fanFootprint(int sides, int perEdge);

/// A concave tile as these triangles of its vertices, each divided into perEdge x perEdge
/// triangles.
Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int perEdge);

/// Whether a convex or star-shaped tile is better divided as a grid: it has four vertices, and none
/// of its corners is so straight or so sharp that a quadrilateral there would have no shape.
bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal);

}  // namespace kirireel
