// Quasiperiodic tilings as duals of superposed grids.
//
// *Line grids* (N. G. de Bruijn, Algebraic theory of Penrose's non-periodic tilings of the plane,
// Indagationes Mathematicae 43, 1981). Grid i of N consists of the lines d_i . y + o = k for all
// whole numbers k: d_i a unit vector, o the offset. The plane of y falls into cells, each with one
// whole number K_i = ceil(d_i . y + o) for every grid. A cell becomes the vertex
//   x = sum over i of (K_i - o - 1/2) d_i
// and the crossing of line a of grid i with line b of grid j, where four cells meet, becomes the
// rhombus of the four vertices whose numbers differ there by one in K_i, K_j or both. Its sides are
// d_i and d_j. Five grids at 72 degrees with offsets that add up to a whole number give Penrose's
// tiling, four at 45 degrees Ammann and Beenker's. On average x = (N/2) y, which is `spread`.
//
// *Honeycombs* (P. Stampfli, A dodecagonal quasiperiodic lattice in two dimensions, Helvetica
// Physica Acta 59, 1986): two honeycombs, one turned by 30 degrees. A pair of overlapping cells is
// a vertex, at the sum of their centres; a corner of one honeycomb within a cell of the other is a
// triangle; two sides that cross are a rhombus, a square where they cross at right angles.
//
// Vertices are told apart by whole numbers and never by their places, so that rounding cannot split
// or merge any. A patch is the tiles nearest to the centre, in whole rings of equal distance, which
// keeps the symmetry.
#include "sim/generate/tiling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>

namespace kirireel {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

double dot(Complex a, Complex b) {
  return (std::conj(a) * b).real();
}

double cross(Complex a, Complex b) {
  return (std::conj(a) * b).imag();
}

/// A vertex by its whole coordinates.
using VertexKey = std::vector<int>;

/// A tile before its vertices are numbered.
struct LooseTile {
  std::vector<VertexKey> keys;  ///< in order round the tile
  std::vector<Complex> corners;
  Complex dual;
  bool isThin = false;

  Complex centre() const {
    return std::accumulate(corners.begin(), corners.end(), Complex()) / double(corners.size());
  }
};

/// The nearest whole rings with at least so many tiles, the vertices numbered.
Tiling assemble(std::vector<LooseTile> loose, int wanted, double spread) {
  // The angle decides among equals, and rounding decides nothing.
  const auto rank = [](const LooseTile& tile) {
    const Complex centre = tile.centre();
    // The small turn moves the cut of the argument at 180 degrees off the tiles that stand there
    // exactly.
    const double angle = std::arg(centre * std::polar(1.0, 1e-7));
    return std::pair(std::lround(1e6 * std::abs(centre)), std::lround(1e6 * angle));
  };
  std::stable_sort(loose.begin(), loose.end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  std::size_t count = std::min(loose.size(), std::size_t(wanted));
  // A ring is taken whole.
  while (count < loose.size() && rank(loose[count]).first == rank(loose[count - 1]).first) ++count;
  Tiling tiling;
  tiling.spread = spread;
  std::map<VertexKey, int> numbers;
  for (std::size_t t = 0; t < count; ++t) {
    LooseTile& tile = loose[t];
    std::vector<int>& vertices = tiling.tiles.emplace_back();
    for (std::size_t k = 0; k < tile.keys.size(); ++k) {
      const auto [entry, isNew] =
          numbers.try_emplace(tile.keys[k], static_cast<int>(numbers.size()));
      if (isNew) tiling.vertices.push_back(tile.corners[k]);
      vertices.push_back(entry->second);
    }
    const Complex first = tile.corners[1] - tile.corners[0];
    if (cross(first, tile.corners[2] - tile.corners[1]) < 0) {
      std::reverse(vertices.begin(), vertices.end());
    }
    tiling.duals.push_back(tile.dual);
    tiling.isThin.push_back(tile.isThin);
  }
  return tiling;
}

/// Superposed grids of parallel lines: grid i has the lines direction_i . y + offset = whole
/// number.
class LineGrids {
 public:
  LineGrids(int count, double firstAngleStep, double offset) : offset_(offset) {
    for (int i = 0; i < count; ++i) directions_.push_back(std::polar(1.0, i * firstAngleStep));
  }

  /// The rhombus dual to the crossing of two lines.
  LooseTile rhombus(int gridA, int lineA, int gridB, int lineB) const {
    const Complex a = directions_[std::size_t(gridA)], b = directions_[std::size_t(gridB)];
    const double sine = cross(a, b);
    LooseTile tile;
    // The y that solves d_a . y + o = line a and d_b . y + o = line b, by Cramer's rule.
    tile.dual = Complex(0, 1) * ((lineB - offset_) * a - (lineA - offset_) * b) / sine;
    VertexKey key;
    for (const Complex& direction : directions_) {
      key.push_back(static_cast<int>(std::ceil(dot(direction, tile.dual) + offset_)));
    }
    // The four cells round the crossing, in order round the rhombus.
    for (const auto& [stepA, stepB] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      key[std::size_t(gridA)] = lineA + stepA;
      key[std::size_t(gridB)] = lineB + stepB;
      tile.keys.push_back(key);
      tile.corners.push_back(position(key));
    }
    tile.isThin = std::abs(sine) < narrowestSine() + 1e-9;
    return tile;
  }

  /// The rhombi of all crossings of the lines with numbers up to `reach`.
  std::vector<LooseTile> rhombi(int reach) const {
    std::vector<LooseTile> tiles;
    const int count = static_cast<int>(directions_.size());
    for (int gridA = 0; gridA < count; ++gridA) {
      for (int gridB = gridA + 1; gridB < count; ++gridB) {
        for (int lineA = -reach; lineA <= reach; ++lineA) {
          for (int lineB = -reach; lineB <= reach; ++lineB) {
            LooseTile tile = rhombus(gridA, lineA, gridB, lineB);
            // Further out, crossings with other grids' further lines are missing.
            if (std::abs(tile.dual) < reach - 1) tiles.push_back(std::move(tile));
          }
        }
      }
    }
    return tiles;
  }

  double spread() const { return 0.5 * static_cast<double>(directions_.size()); }

 private:
  /// Counted so that the middle of the grids is the middle of the tiling.
  Complex position(const VertexKey& key) const {
    Complex sum;
    for (std::size_t i = 0; i < key.size(); ++i) sum += (key[i] - offset_ - 0.5) * directions_[i];
    return sum;
  }

  // Of the angles between two grids.
  double narrowestSine() const {
    double least = 1;
    for (const Complex& direction : directions_) {
      const double sine = std::abs(cross(directions_[0], direction));
      if (sine > 1e-9) least = std::min(least, sine);
    }
    return least;
  }

  std::vector<Complex> directions_;
  double offset_;
};

/// How many lines each grid needs so that so many tiles are whole.
int reachFor(int tiles, double spread) {
  // A unit of the tiling's area holds at least one tile; the rest is for the rim.
  return static_cast<int>(std::ceil(std::sqrt(tiles / pi) / spread)) + 4;
}

/// The hexagonal cells about the points of a triangular lattice.
class Honeycomb {
 public:
  explicit Honeycomb(double angle)
      : first_(std::polar(1.0, angle)), second_(std::polar(1.0, angle + pi / 3)) {}

  struct HexCell {
    int column = 0;
    int row = 0;
  };
  /// A side between two cells, or a corner between three.
  struct HexSide {
    std::array<HexCell, 2> cells;
    std::array<Complex, 2> ends;
  };
  struct HexCorner {
    std::array<HexCell, 3> cells;
    Complex place;
  };

  Complex centre(const HexCell& cell) const {
    return double(cell.column) * first_ + double(cell.row) * second_;
  }

  HexCell cellAt(Complex point) const {
    // The cell of the lattice's parallelogram that holds the point; one of its four corners is
    // nearest.
    const double area = cross(first_, second_);
    const int column = static_cast<int>(std::floor(cross(point, second_) / area));
    const int row = static_cast<int>(std::floor(cross(first_, point) / area));
    HexCell nearest{column, row};
    for (const HexCell& cell :
         {HexCell{column + 1, row}, {column, row + 1}, {column + 1, row + 1}}) {
      if (std::abs(point - centre(cell)) < std::abs(point - centre(nearest))) nearest = cell;
    }
    return nearest;
  }

  // Two for each lattice point: one for each triangle of the lattice.
  std::vector<HexCorner> corners(int reach) const {
    std::vector<HexCorner> found;
    forCells(reach, [&](int i, int j) {
      for (const std::array<HexCell, 3>& cells :
           {std::array<HexCell, 3>{{{i, j}, {i + 1, j}, {i, j + 1}}},
            std::array<HexCell, 3>{{{i + 1, j}, {i + 1, j + 1}, {i, j + 1}}}}) {
        found.push_back({cells, middle(cells)});
      }
    });
    return found;
  }

  // Three for each lattice point: every side of the honeycomb once.
  std::vector<HexSide> sides(int reach) const {
    std::vector<HexSide> found;
    forCells(reach, [&](int i, int j) {
      const auto append = [&](const HexCell& other, const HexCell& left, const HexCell& right) {
        const HexCell self{i, j};
        found.push_back({{self, other},
                         {middle(std::array<HexCell, 3>{self, other, left}),
                          middle(std::array<HexCell, 3>{self, other, right})}});
      };
      append({i + 1, j}, {i, j + 1}, {i + 1, j - 1});
      append({i, j + 1}, {i - 1, j + 1}, {i + 1, j});
      append({i - 1, j + 1}, {i - 1, j}, {i, j + 1});
    });
    return found;
  }

 private:
  template <typename Action>
  static void forCells(int reach, const Action& action) {
    for (int i = -reach; i <= reach; ++i) {
      for (int j = -reach; j <= reach; ++j) action(i, j);
    }
  }

  Complex middle(const std::array<HexCell, 3>& cells) const {
    return (centre(cells[0]) + centre(cells[1]) + centre(cells[2])) / 3.0;
  }

  Complex first_;
  Complex second_;
};

/// Where two segments cross.
std::optional<Complex> crossing(const Honeycomb::HexSide& a, const Honeycomb::HexSide& b) {
  const Complex alongA = a.ends[1] - a.ends[0];
  const Complex alongB = b.ends[1] - b.ends[0];
  const double sine = cross(alongA, alongB);
  if (std::abs(sine) < 1e-9) return std::nullopt;
  const double shareA = cross(b.ends[0] - a.ends[0], alongB) / sine;
  const double shareB = cross(b.ends[0] - a.ends[0], alongA) / sine;
  if (shareA < 0 || shareA > 1 || shareB < 0 || shareB > 1) return std::nullopt;
  return a.ends[0] + shareA * alongA;
}

/// The two honeycombs behind the twelvefold tiling.
class HoneycombPair {
 public:
  std::vector<LooseTile> tiles(int reach) const {
    std::vector<LooseTile> found;
    appendTriangles(honeycombs_[0], honeycombs_[1], false, reach, found);
    appendTriangles(honeycombs_[1], honeycombs_[0], true, reach, found);
    const std::vector<Honeycomb::HexSide> sides = honeycombs_[1].sides(reach);
    for (const Honeycomb::HexSide& a : honeycombs_[0].sides(reach)) {
      for (const Honeycomb::HexSide& b : sides) {
        // Sides are 1/sqrt(3) long, so that ends farther apart than that cannot belong to sides
        // that cross.
        if (std::abs(a.ends[0] - b.ends[0]) > 2) continue;
        if (const auto place = crossing(a, b)) appendRhombus(a, b, *place, found);
      }
    }
    return found;
  }

 private:
  void appendCorner(LooseTile& tile, const Honeycomb::HexCell& a,
                    const Honeycomb::HexCell& b) const {
    tile.keys.push_back({a.column, a.row, b.column, b.row});
    tile.corners.push_back(honeycombs_[0].centre(a) + honeycombs_[1].centre(b));
  }

  // `swapped` keeps the first honeycomb's cell first in the vertex.
  void appendTriangles(const Honeycomb& own, const Honeycomb& other, bool swapped, int reach,
                       std::vector<LooseTile>& found) const {
    for (const Honeycomb::HexCorner& corner : own.corners(reach)) {
      const Honeycomb::HexCell within = other.cellAt(corner.place);
      LooseTile& tile = found.emplace_back();
      tile.dual = corner.place;
      for (const Honeycomb::HexCell& cell : corner.cells) {
        appendCorner(tile, swapped ? within : cell, swapped ? cell : within);
      }
    }
  }

  void appendRhombus(const Honeycomb::HexSide& a, const Honeycomb::HexSide& b, Complex place,
                     std::vector<LooseTile>& found) const {
    LooseTile& tile = found.emplace_back();
    tile.dual = place;
    appendCorner(tile, a.cells[0], b.cells[0]);
    appendCorner(tile, a.cells[1], b.cells[0]);
    appendCorner(tile, a.cells[1], b.cells[1]);
    appendCorner(tile, a.cells[0], b.cells[1]);
    const Complex edge = tile.corners[1] - tile.corners[0];
    // The sine of the rhombus's angle is 0.5 for 30 degrees and 1 for a square.
    tile.isThin = std::abs(cross(edge, tile.corners[2] - tile.corners[1])) < 0.6;
  }

  std::array<Honeycomb, 2> honeycombs_{Honeycomb(0), Honeycomb(pi / 6)};
};

}  // namespace

Tiling penroseTiling(int tiles) {
  // Offsets that add up to a whole number make Penrose's tiling; these keep the symmetry.
  const LineGrids grids(5, 2 * pi / 5, 0.4);
  return assemble(grids.rhombi(reachFor(tiles, grids.spread())), tiles, grids.spread());
}

Tiling ammannBeenkerTiling(int tiles) {
  const LineGrids grids(4, pi / 4, 0.5);
  return assemble(grids.rhombi(reachFor(tiles, grids.spread())), tiles, grids.spread());
}

Tiling stampfliTiling(int tiles) {
  constexpr double kSpread = 2;
  return assemble(HoneycombPair().tiles(reachFor(tiles, kSpread)), tiles, kSpread);
}

}  // namespace kirireel
