/// How a tile is divided into quadrilaterals; a brick's elements stand on these.
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

/// A side of a cell that lies on an edge of the tile.
struct FootprintSide {
  int cell = 0;
  int side = 0;      ///< of the cell: from its point `side` to the next
  int tileEdge = 0;  ///< from vertex `tileEdge` to the next
};

/// Points, and the quadrilaterals between them.
struct Footprint {
  std::vector<FootprintPoint> points;
  std::vector<int> corners;               ///< the point at each vertex of the tile
  std::vector<std::array<int, 4>> cells;  ///< points, anticlockwise
  std::vector<std::array<int, 2>> edges;  ///< of the cells, each once, the lower point first
  std::vector<FootprintSide> sides;       ///< by tile edge
  bool isRow = false;  ///< one cell wide: nothing but full integration holds its shape
};

/// A four-sided tile as a grid of quadrilaterals: `first` along the edges 0 and 2, `second` along
/// the edges 1 and 3, each at least 1. The points of an edge lie at equal shares of it, or, graded,
/// at (1 - cos(pi k / n)) / 2, closer to its ends. `first` x `second` cells, (first + 1) x (second
/// + 1) points.
Footprint gridFootprint(int first, int second, bool isGraded = false);

/// A tile of any number of sides as triangles (a triangle alone, others fanned round the centre),
/// each cut through the middles of its sides into three quadrilaterals, and these into grids of
/// halfPerEdge x halfPerEdge: 2 halfPerEdge cells along each edge of the tile. `sides` is at least
/// 3, halfPerEdge at least 1. 3 halfPerEdge^2 cells for a triangle, `sides` times as many for
/// others.
Footprint fanFootprint(int sides, int halfPerEdge);

/// A concave tile as these triangles of its vertices, anticlockwise, each divided as those of a
/// fan. The triangles must cover the tile without overlap and share whole sides.
Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int halfPerEdge);

/// Whether a convex or star-shaped tile is better divided as a grid: it has four vertices, and none
/// of its corners is so straight or so sharp that a quadrilateral there would have no shape. Sine
/// of every turn at least 0.05, which is 3 degrees. `normal` is a unit vector to the side from
/// which vertices run anticlockwise.
bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal);

/// The edges of quadrilaterals, each once, the lower point first, sorted.
std::vector<std::array<int, 2>> edgesOf(const std::vector<std::array<int, 4>>& cells);

}  // namespace kirireel
