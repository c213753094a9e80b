// Quasiperiodic tilings as duals of superposed grids.
//
// *Line grids* (N. G. de Bruijn, Algebraic theory of Penrose's non-periodic tilings of the plane,
// Indagationes Mathematicae 43, 1981). Grid i of N consists of the lines d_i . y + o = k for all
// integers k, with a unit vector d_i and the offset o. They divide the plane of y into cells, each
// with one integer K_i = ceil(d_i . y + o) per grid. A cell becomes the vertex
//   x = sum over i of (K_i - o - 1/2) d_i
// Four cells meet at the crossing of line a of grid i with line b of grid j. They become the
// vertices of a rhombus, whose numbers differ by one in K_i, K_j or both. Its sides are d_i and
// d_j. Five grids at 72 degrees whose offsets have an integer sum give Penrose's tiling, four at 45
// degrees that of Ammann and Beenker. On average x = (N/2) y; this factor is `spread`.
//
// *Honeycombs* (P. Stampfli, A dodecagonal quasiperiodic lattice in two dimensions, Helvetica
// Physica Acta 59, 1986): two honeycombs, one rotated by 30 degrees. A pair of overlapping cells is
// a vertex at the sum of their centres. A corner of one honeycomb in a cell of the other is a
// triangle. Two crossing sides are a rhombus, or a square if they are perpendicular.
//
// Vertices are identified by integers, never by positions, so rounding cannot split or merge any. A
// patch has the tiles nearest to the centre, in complete rings of equal distance. This preserves
// the symmetry.
#include "sim/generate/tiling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <utility>

#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"

namespace kirireel::generate {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

double dot(Complex a, Complex b) {
  return (std::conj(a) * b).real();
}

double cross(Complex a, Complex b) {
  return (std::conj(a) * b).imag();
}

/// A vertex by its integer coordinates.
using VertexKey = std::vector<int>;

/// A tile before its vertices are numbered.
struct LooseTile {
  std::vector<VertexKey> keys;  ///< in order around the tile
  std::vector<Complex> corners;
  Complex dual;
  bool isThin = false;

  Complex centre() const {
    return std::accumulate(corners.begin(), corners.end(), Complex()) / double(corners.size());
  }
};

/// The nearest complete rings with at least this many tiles, with numbered vertices.
Tiling assemble(std::vector<LooseTile> loose, int desired, double spread) {
  // The angle orders equal distances, so rounding has no effect.
  const auto rank = [](const LooseTile& tile) {
    const Complex centre = tile.centre();
    // The small rotation moves the branch cut of the argument at 180 degrees away from tiles
    // exactly there.
    const double angle = std::arg(centre * std::polar(1.0, 1e-7));
    return std::pair(std::lround(1e6 * std::abs(centre)), std::lround(1e6 * angle));
  };
  std::stable_sort(loose.begin(), loose.end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  std::size_t count = std::min(loose.size(), std::size_t(desired));
  // A ring is added completely.
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

/// Superposed grids of parallel lines: grid i has the lines direction_i . y + offset = integer.
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
    // The four cells around the crossing, in order around the rhombus.
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
            // Farther out, crossings with missing lines of other grids would be incomplete.
            if (std::abs(tile.dual) < reach - 1) tiles.push_back(std::move(tile));
          }
        }
      }
    }
    return tiles;
  }

  double spread() const { return 0.5 * static_cast<double>(directions_.size()); }

 private:
  /// Relative to the middle of the grids, which is the middle of the tiling.
  Complex position(const VertexKey& key) const {
    Complex sum;
    for (std::size_t i = 0; i < key.size(); ++i) sum += (key[i] - offset_ - 0.5) * directions_[i];
    return sum;
  }

  // The smallest sine of the angles between two grids.
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

/// Number of lines per grid for this number of complete tiles.
int reachFor(int tiles, double spread) {
  // A unit of the tiling's area has at least one tile. The addition is for the rim.
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
    // The cell of the lattice's parallelogram that contains the point. One of its four corners is
    // the nearest.
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

  // Two for each lattice point, one per triangle of the lattice.
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

/// Crossing of two segments.
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

/// The two honeycombs of the twelvefold tiling.
class HoneycombPair {
 public:
  std::vector<LooseTile> tiles(int reach) const {
    std::vector<LooseTile> found;
    appendTriangles(honeycombs_[0], honeycombs_[1], false, reach, found);
    appendTriangles(honeycombs_[1], honeycombs_[0], true, reach, found);
    const std::vector<Honeycomb::HexSide> sides = honeycombs_[1].sides(reach);
    for (const Honeycomb::HexSide& a : honeycombs_[0].sides(reach)) {
      for (const Honeycomb::HexSide& b : sides) {
        // Sides are 1/sqrt(3) long, so sides with more distant ends cannot cross.
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

  // `swapped` puts the first honeycomb's cell first in the vertex.
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
  // Offsets with an integer sum give Penrose's tiling. These preserve the symmetry.
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

// ------------------------------------------------------------------------------------------------
// Sheets from tilings: a closed chain, a tiling without its narrow tiles, an expanded tiling.
//
// *Chain*: a Hamiltonian cycle of the graph with tiles as nodes and shared edges as links. A path
// grows to the free neighbour with the fewest free neighbours (Warnsdorff's rule for the knight's
// tour). If the path is stuck at its end e, one of e's neighbours p in the path is chosen.
// Reversing the part after p gives a path of the same tiles with another end (L. Posa, Hamiltonian
// circuits in random graphs, Discrete Mathematics 14, 1976). Joints alternate between the two ends
// of the edges that the cycle crosses.
//
// *Removal*: each edge between remaining tiles gets one joint at a fixed end. The sheet can open.
// Parts with a common vertex are joined there.
//
// *Expansion*: with a vertex V, the dual D of a tile (complex, m) and the spread s, the corner of
// the tile at the vertex is at
//   v(theta) = V e^(i t) + s D e^(-i t),    t = theta/2 - pi/4
// A tile has one D and turns by t, the cell of a vertex has one V and turns by -t. Both stay rigid
// and joined at their common corners. At theta = pi/2 (t = 0) the result is the sum of tiling and
// grids. L. Liu, G. P. T. Choi, L. Mahadevan, Quasicrystal kirigami, Physical Review Research 4,
// 2022, introduce these constructions.

namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// An edge shared by two tiles, with the vertices in the direction of tile a.
struct SharedEdge {
  int a = 0;
  int b = 0;
  int from = 0;
  int to = 0;
};

// The edges between kept tiles.
std::vector<SharedEdge> sharedEdges(const Tiling& tiling, const std::vector<int>& kept) {
  std::map<std::pair<int, int>, int> runners;
  std::vector<SharedEdge> edges;
  for (const int tile : kept) {
    const std::vector<int>& vertices = tiling.tiles[std::size_t(tile)];
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const int from = vertices[k], to = vertices[(k + 1) % vertices.size()];
      runners[{from, to}] = tile;
      // The neighbour has the same edge in the opposite direction.
      const auto other = runners.find({to, from});
      if (other != runners.end()) edges.push_back({tile, other->second, from, to});
    }
  }
  return edges;
}

int cornerAt(const Tiling& tiling, int tile, int vertex) {
  const std::vector<int>& vertices = tiling.tiles[std::size_t(tile)];
  return static_cast<int>(std::find(vertices.begin(), vertices.end(), vertex) - vertices.begin());
}

model::Tile placed(const Tiling& tiling, int tile) {
  model::Tile result;
  for (const int vertex : tiling.tiles[std::size_t(tile)]) {
    const Complex place = tiling.vertices[std::size_t(vertex)];
    result.vertices.emplace_back(place.real() + 0.0, place.imag() + 0.0, 0);
  }
  return result;
}

/// A joint between tiles of the tiling at one of its vertices.
struct VertexJoint {
  int a = 0;
  int b = 0;
  int vertex = 0;
};

/// The kept tiles, renumbered, with these joints.
model::Model jointedModel(const Tiling& tiling, const std::vector<int>& kept,
                          const std::vector<VertexJoint>& joints) {
  model::Model model;
  std::map<int, int> numbers;
  for (const int tile : kept) {
    numbers.emplace(tile, static_cast<int>(model.tiles.size()));
    model.tiles.push_back(placed(tiling, tile));
  }
  for (const VertexJoint& joint : joints) {
    model.joints.push_back({{numbers.at(joint.a), cornerAt(tiling, joint.a, joint.vertex)},
                            {numbers.at(joint.b), cornerAt(tiling, joint.b, joint.vertex)},
                            model::JointFace::Both});
  }
  return model;
}

std::vector<int> allTiles(const Tiling& tiling) {
  std::vector<int> tiles(tiling.tiles.size());
  std::iota(tiles.begin(), tiles.end(), 0);
  return tiles;
}

/// Neighbours of each tile, in a fixed order.
using Neighbours = std::vector<std::vector<int>>;

Neighbours neighboursOf(const Tiling& tiling, const std::vector<int>& kept) {
  Neighbours neighbours(tiling.tiles.size());
  for (const SharedEdge& edge : sharedEdges(tiling, kept)) {
    neighbours[std::size_t(edge.a)].push_back(edge.b);
    neighbours[std::size_t(edge.b)].push_back(edge.a);
  }
  return neighbours;
}

/// Removes tiles with fewer than two neighbours until there are none.
std::vector<int> withTwoNeighbours(const Tiling& tiling) {
  std::vector<int> kept = allTiles(tiling);
  // Removing a tile may leave another with one neighbour.
  for (std::size_t before = 0; before != kept.size();) {
    before = kept.size();
    const Neighbours neighbours = neighboursOf(tiling, kept);
    std::erase_if(kept, [&](int tile) { return neighbours[std::size_t(tile)].size() < 2; });
  }
  return kept;
}

/// Searches a closed path through all tiles by reversing parts of a path (Posa 1976), with a fixed
/// seed.
class ChainSearch {
 public:
  ChainSearch(const Neighbours& neighbours, const std::vector<int>& tiles)
      : neighbours_(neighbours), tiles_(tiles), place_(neighbours.size(), -1) {}

  /// The path; empty if none was found.
  std::vector<int> find() {
    constexpr int kTries = 40;
    for (int attempt = 0; attempt < kTries; ++attempt) {
      start(tiles_[generator_() % tiles_.size()]);
      for (std::size_t round = 0; round < 2000 * tiles_.size(); ++round) {
        if (path_.size() == tiles_.size() && closes()) return path_;
        if (!step()) break;
      }
    }
    return {};
  }

 private:
  void start(int tile) {
    std::fill(place_.begin(), place_.end(), -1);
    path_.clear();
    append(tile);
  }

  void append(int tile) {
    place_[std::size_t(tile)] = static_cast<int>(path_.size());
    path_.push_back(tile);
  }

  // Whether the path's end is a neighbour of its start.
  bool closes() const {
    const std::vector<int>& around = neighbours_[std::size_t(path_.back())];
    return path_.size() > 2 &&
           std::find(around.begin(), around.end(), path_.front()) != around.end();
  }

  // Neighbours that the path has not visited.
  int freeNeighbours(int tile) const {
    const std::vector<int>& around = neighbours_[std::size_t(tile)];
    return static_cast<int>(std::count_if(
        around.begin(), around.end(), [&](int other) { return place_[std::size_t(other)] < 0; }));
  }

  /// Extends the path to the free neighbour with the fewest exits, or reverses a part at the end,
  /// which gives another end.
  bool step() {
    const std::vector<int>& around = neighbours_[std::size_t(path_.back())];
    int next = -1;
    for (const int tile : around) {
      if (place_[std::size_t(tile)] >= 0) continue;
      if (next < 0 || freeNeighbours(tile) < freeNeighbours(next)) next = tile;
    }
    if (next >= 0) {
      append(next);
      return true;
    }
    const int pivot = around[generator_() % around.size()];
    const auto first = path_.begin() + place_[std::size_t(pivot)] + 1;
    // The pivot is the end's own predecessor, so the reversal would have no effect. Another random
    // draw may succeed.
    if (first == path_.end() || std::next(first) == path_.end()) return around.size() > 1;
    std::reverse(first, path_.end());
    for (auto tile = first; tile != path_.end(); ++tile) {
      place_[std::size_t(*tile)] = static_cast<int>(tile - path_.begin());
    }
    return true;
  }

  const Neighbours& neighbours_;
  const std::vector<int>& tiles_;
  std::vector<int> place_;  ///< of each tile in the path, or -1
  std::vector<int> path_;
  std::mt19937 generator_{1};
};

/// The number of the part with most of the tiles. There must be at least one tile.
int largestPart(DisjointSets& parts, const std::vector<int>& tiles) {
  std::map<int, int> sizes;
  for (const int tile : tiles) ++sizes[parts.lowestOf(tile)];
  return std::ranges::max_element(sizes, {}, [](const auto& part) { return part.second; })->first;
}

/// The tiles around each vertex.
std::vector<std::vector<int>> tilesRound(const Tiling& tiling) {
  std::vector<std::vector<int>> around(tiling.vertices.size());
  for (const int tile : allTiles(tiling)) {
    for (const int vertex : tiling.tiles[std::size_t(tile)]) {
      around[std::size_t(vertex)].push_back(tile);
    }
  }
  return around;
}

/// Whether the tiles around a vertex leave no gap.
bool isInner(const Tiling& tiling, int vertex, const std::vector<int>& around) {
  double sum = 0;
  for (const int tile : around) {
    const std::vector<int>& vertices = tiling.tiles[std::size_t(tile)];
    const std::size_t k = std::size_t(cornerAt(tiling, tile, vertex));
    const std::size_t count = vertices.size();
    const auto place = [&](std::size_t n) {
      return tiling.vertices[std::size_t(vertices[n % count])];
    };
    // The tile's angle at the vertex.
    sum += std::arg((place(k + count - 1) - place(k)) / (place(k + 1) - place(k)));
  }
  return sum > 2 * pi - 1e-6;
}

/// Sorts the tiles around an inner vertex by the order of their duals around the cell.
void sortRoundCell(const Tiling& tiling, std::vector<int>& around) {
  Complex middle;
  for (const int tile : around) middle += tiling.duals[std::size_t(tile)] / double(around.size());
  std::sort(around.begin(), around.end(), [&](int a, int b) {
    return std::arg(tiling.duals[std::size_t(a)] - middle) <
           std::arg(tiling.duals[std::size_t(b)] - middle);
  });
}

/// One joint per pair of tiles with a common edge, at its clockwise end seen from the centre, or at
/// the outer end of a radial edge.
std::vector<VertexJoint> clockwiseJoints(const Tiling& tiling, const std::vector<int>& kept) {
  std::vector<VertexJoint> joints;
  for (const SharedEdge& edge : sharedEdges(tiling, kept)) {
    const Complex from = tiling.vertices[std::size_t(edge.from)];
    const Complex to = tiling.vertices[std::size_t(edge.to)];
    const double turn = (std::conj(from) * to).imag();
    // A radial edge has no clockwise end.
    const bool atFrom = std::abs(turn) > 1e-9 ? turn > 0 : std::abs(from) > std::abs(to);
    joints.push_back({edge.a, edge.b, atFrom ? edge.from : edge.to});
  }
  return joints;
}

/// The first vertex of a that is also in b.
int sharedVertex(const Tiling& tiling, int a, int b) {
  const std::vector<int>& inA = tiling.tiles[std::size_t(a)];
  const std::vector<int>& inB = tiling.tiles[std::size_t(b)];
  return *std::find_first_of(inA.begin(), inA.end(), inB.begin(), inB.end());
}

/// The position of a tile's corner at a vertex after the rotation of tiles and cells.
Vector3 expandedCorner(const Tiling& tiling, int tile, int vertex, double angle) {
  const Complex turn = std::polar(1.0, 0.5 * angle - pi / 4);
  const Complex place = tiling.vertices[std::size_t(vertex)] * turn +
                        tiling.spread * tiling.duals[std::size_t(tile)] * std::conj(turn);
  return {place.real() + 0.0, place.imag() + 0.0, 0};
}

}  // namespace

model::Model makeChain(const Tiling& tiling) {
  const std::vector<int> kept = withTwoNeighbours(tiling);
  const Neighbours neighbours = neighboursOf(tiling, kept);
  const std::vector<int> path = kept.empty() ? kept : ChainSearch(neighbours, kept).find();
  if (path.empty()) {
    throw InputError(fmt::format(
        "chain: error: no closed chain through all {} tiles was found. Use another number of tiles",
        kept.size()));
  }
  std::map<std::pair<int, int>, SharedEdge> edges;
  for (const SharedEdge& edge : sharedEdges(tiling, kept)) {
    edges[{edge.a, edge.b}] = edge;
    edges[{edge.b, edge.a}] = {edge.b, edge.a, edge.to, edge.from};
  }
  std::vector<VertexJoint> joints;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const SharedEdge& edge = edges.at({path[k], path[(k + 1) % path.size()]});
    joints.push_back({edge.a, edge.b, k % 2 == 0 ? edge.from : edge.to});
  }
  return jointedModel(tiling, path, joints);
}

model::Model makeThinned(const Tiling& tiling) {
  std::vector<int> kept = allTiles(tiling);
  const auto isThin = [&](int tile) { return bool(tiling.isThin[std::size_t(tile)]); };
  std::erase_if(kept, isThin);
  if (kept.empty()) {
    throw InputError(
        fmt::format("removal: error: all {} tiles are narrow. Use a larger number of tiles",
                    tiling.tiles.size()));
  }
  std::vector<VertexJoint> joints = clockwiseJoints(tiling, kept);
  DisjointSets parts(tiling.tiles.size());
  for (const VertexJoint& joint : joints) parts.unite(joint.a, joint.b);
  // Parts with only a common vertex are linked there. They are found before any linking, so the
  // order of vertices does not matter.
  DisjointSets byEdges = parts;
  for (std::vector<int>& around : tilesRound(tiling)) {
    std::erase_if(around, isThin);
    if (around.empty()) continue;
    const auto other = std::find_if(around.begin(), around.end(), [&](int tile) {
      return byEdges.lowestOf(tile) != byEdges.lowestOf(around.front());
    });
    if (other == around.end()) continue;
    joints.push_back({around.front(), *other, sharedVertex(tiling, around.front(), *other)});
    parts.unite(joints.back().a, joints.back().b);
  }
  const int part = largestPart(parts, kept);
  std::erase_if(kept, [&](int tile) { return parts.lowestOf(tile) != part; });
  std::erase_if(joints, [&](const VertexJoint& joint) { return parts.lowestOf(joint.a) != part; });
  return jointedModel(tiling, kept, joints);
}

model::Model makeExpanded(const Tiling& tiling, double startAngle, double targetAngle) {
  model::Model model;
  model.target.emplace();
  const auto append = [&](const std::vector<std::pair<int, int>>& corners) {
    model::Tile& start = model.tiles.emplace_back();
    model::Tile& target = model.target->emplace_back();
    for (const auto& [tile, vertex] : corners) {
      start.vertices.push_back(expandedCorner(tiling, tile, vertex, startAngle));
      target.vertices.push_back(expandedCorner(tiling, tile, vertex, targetAngle));
    }
  };
  std::vector<std::vector<int>> round = tilesRound(tiling);
  std::map<int, int> numbers;
  for (const int tile : allTiles(tiling)) {
    const std::vector<int>& vertices = tiling.tiles[std::size_t(tile)];
    const bool isJoined = std::any_of(vertices.begin(), vertices.end(), [&](int vertex) {
      return isInner(tiling, vertex, round[std::size_t(vertex)]);
    });
    if (!isJoined) continue;
    numbers.emplace(tile, static_cast<int>(model.tiles.size()));
    std::vector<std::pair<int, int>> corners;
    for (const int vertex : vertices) corners.emplace_back(tile, vertex);
    append(corners);
  }
  for (int vertex = 0; vertex < std::ssize(round); ++vertex) {
    std::vector<int>& around = round[std::size_t(vertex)];
    // The cell of a vertex at the rim would be open.
    if (!isInner(tiling, vertex, around)) continue;
    sortRoundCell(tiling, around);
    const int cell = static_cast<int>(model.tiles.size());
    std::vector<std::pair<int, int>> corners;
    for (const int tile : around) {
      model.joints.push_back({{numbers.at(tile), cornerAt(tiling, tile, vertex)},
                              {cell, static_cast<int>(corners.size())},
                              model::JointFace::Both});
      corners.emplace_back(tile, vertex);
    }
    append(corners);
  }
  return model;
}

}  // namespace kirireel::generate
