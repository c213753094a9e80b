// Sheets of regular polygons of two kinds, from one formula as for lattices of quads.
//
// Let c be the centre of a tile of kind 0 (complex, m), d that of a neighbour of another kind, and
// r a complex ratio that is the same for all pairs. The corner that both share is c + r (d - c) in
// the closed sheet, and
//   v(theta) = (1 - r) c e^(i theta/2) + r d e^(-i theta/2)
// when neighbours have turned by theta (radians). A tile of kind 0 has one c, so that its corners
// differ by terms in d alone, all turned by -theta/2: it stays rigid, and so do the others, turned
// by +theta/2. Both tiles at a corner use the same sum, so that joints stay closed. r is found from
// one pair: for triangles, e^(i pi/3); for hexagons and triangles, sqrt(3)/2 e^(i pi/6).
//
// J. N. Grima, K. E. Evans, Auxetic behavior from rotating triangles, Journal of Materials Science
// 41, 2006.
#include "sim/generate/rotors.h"

#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace kirireel {
namespace {

using Complex = std::complex<double>;

/// A place on the triangular lattice: cell numbers and the kind of tile in the cell.
struct RotorPlace {
  int column = 0;
  int row = 0;
  int kind = 0;

  auto operator<=>(const RotorPlace&) const = default;
};

/// A pattern of tiles edge to edge, those of kind 0 next to others only: with c the centre of a
/// tile of kind 0 and d that of a neighbour, the corner that they share is c + ratio (d - c). So
///   v(theta) = (1 - ratio) c e^(i theta / 2) + ratio d e^(-i theta / 2)
/// keeps all tiles rigid and all joints closed at every theta.
struct Pattern {
  Complex ratio;
  Complex (*centre)(const RotorPlace&);
  /// Anticlockwise; some may stand outside the sheet.
  std::vector<RotorPlace> (*neighbours)(const RotorPlace&);
};

// All tiles at one angle, in the plane z = 0.
std::vector<Tile> tilesAt(const Pattern& pattern, const std::vector<RotorPlace>& places,
                          double angle) {
  const Complex turn = std::polar(1.0, 0.5 * angle);
  std::vector<Tile> tiles;
  for (const RotorPlace& place : places) {
    Tile& tile = tiles.emplace_back();
    for (const RotorPlace& neighbour : pattern.neighbours(place)) {
      Complex first = pattern.centre(place);
      Complex second = pattern.centre(neighbour);
      // The formula wants the centre of kind 0 first.
      if (place.kind != 0) std::swap(first, second);
      const Complex corner =
          (1.0 - pattern.ratio) * first * turn + pattern.ratio * second * std::conj(turn);
      // Adding 0 makes a negative zero positive.
      tile.vertices.emplace_back(corner.real() + 0.0, corner.imag() + 0.0, 0);
    }
  }
  return tiles;
}

// A corner towards a neighbour has that neighbour's place in the list.
std::vector<Joint> jointsOf(const Pattern& pattern, const std::vector<RotorPlace>& places) {
  std::map<RotorPlace, int> numbers;
  for (const RotorPlace& place : places) numbers.emplace(place, static_cast<int>(numbers.size()));
  const auto cornerTowards = [&](const RotorPlace& from, const RotorPlace& to) {
    const std::vector<RotorPlace> around = pattern.neighbours(from);
    int corner = 0;
    while (around[std::size_t(corner)] != to) ++corner;
    return corner;
  };
  std::vector<Joint> joints;
  for (const RotorPlace& place : places) {
    // Each joint is between kind 0 and another kind, so that it is met once.
    if (place.kind != 0) continue;
    for (const RotorPlace& neighbour : pattern.neighbours(place)) {
      const auto there = numbers.find(neighbour);
      if (there == numbers.end()) continue;
      joints.push_back({{numbers.at(place), cornerTowards(place, neighbour)},
                        {there->second, cornerTowards(neighbour, place)},
                        JointFace::Both});
    }
  }
  return joints;
}

Model makeSheet(const std::string& name, const Pattern& pattern,
                const std::vector<RotorPlace>& places, const RotorShape& shape) {
  Model model;
  model.name = name;
  model.tiles = tilesAt(pattern, places, shape.startAngle);
  model.target = tilesAt(pattern, places, shape.targetAngle);
  model.joints = jointsOf(pattern, places);
  return model;
}

const double kRoot3 = std::sqrt(3.0);

/// Triangular lattice with unit edges.
Complex latticePoint(double column, double row) {
  return {column + 0.5 * row, 0.5 * kRoot3 * row};
}

/// Kind 0 points up from the cell's corner, kind 1 down.
constexpr Complex kTriangleRatio{0.5, 0.8660254037844386};

Complex triangleCentre(const RotorPlace& place) {
  const double third = (place.kind + 1) / 3.0;
  return latticePoint(place.column + third, place.row + third);
}

std::vector<RotorPlace> triangleNeighbours(const RotorPlace& place) {
  const auto [i, j, kind] = place;
  if (kind == 0) return {{i, j, 1}, {i - 1, j, 1}, {i, j - 1, 1}};
  return {{i, j + 1, 0}, {i, j, 0}, {i + 1, j, 0}};
}

/// Kind 0 is a hexagon on the cell's corner, kinds 1 and 2 the triangles in the cell: between the
/// hexagons of its first three and its last three corners.
constexpr Complex kHexagonRatio{0.75, 0.4330127018922193};

Complex hexagonPatternCentre(const RotorPlace& place) {
  const double third = place.kind / 3.0;
  return 2.0 * latticePoint(place.column + third, place.row + third);
}

std::vector<RotorPlace> hexagonPatternNeighbours(const RotorPlace& place) {
  const auto [i, j, kind] = place;
  if (kind == 0) {
    return {{i, j, 1},         {i - 1, j, 2}, {i - 1, j, 1},
            {i - 1, j - 1, 2}, {i, j - 1, 1}, {i, j - 1, 2}};
  }
  if (kind == 1) return {{i, j, 0}, {i + 1, j, 0}, {i, j + 1, 0}};
  return {{i + 1, j, 0}, {i + 1, j + 1, 0}, {i, j + 1, 0}};
}

}  // namespace

Model makeRotatingTriangles(const RotorShape& shape) {
  const Pattern pattern{kTriangleRatio, triangleCentre, triangleNeighbours};
  std::vector<RotorPlace> places;
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      for (const int kind : {0, 1}) places.push_back({i, j, kind});
    }
  }
  return makeSheet("triangles", pattern, places, shape);
}

Model makeHexagonsAndTriangles(const RotorShape& shape) {
  const Pattern pattern{kHexagonRatio, hexagonPatternCentre, hexagonPatternNeighbours};
  std::vector<RotorPlace> places;
  for (int i = 0; i < shape.columns; ++i) {
    for (int j = 0; j < shape.rows; ++j) {
      places.push_back({i, j, 0});
      // These triangles would have corners without a hexagon.
      if (i + 1 == shape.columns || j + 1 == shape.rows) continue;
      for (const int kind : {1, 2}) places.push_back({i, j, kind});
    }
  }
  return makeSheet("hexagons", pattern, places, shape);
}

}  // namespace kirireel
