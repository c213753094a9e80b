// Sheets made of tilings: a closed chain, a tiling without its narrow tiles, an expanded tiling.
//
// *Chain*: a Hamiltonian cycle of the graph whose nodes are tiles and whose links are shared edges.
// A path is grown to the free neighbour with the fewest free neighbours of its own (Warnsdorff's
// rule for the knight's tour). Where the path is stuck at its end e, one of e's neighbours p in the
// path is taken and the piece after p is turned round, which gives a path of the same tiles with
// another end (L. Posa, Hamiltonian circuits in random graphs, Discrete Mathematics 14, 1976).
// Joints alternate between the two ends of the edges that the cycle crosses.
//
// *Removal*: edges between the tiles that stay get one joint each, at a fixed end, so that the
// sheet can open; parts that meet at a vertex are joined there.
//
// *Expansion*: with V a vertex, D the dual of a tile (complex, m), s the spread and t = theta/2 -
// pi/4, the corner of the tile at the vertex stands at
//   v(theta) = V e^(i t) + s D e^(-i t)
// A tile has one D and turns by t, the cell of a vertex has one V and turns by -t: both stay rigid
// and stay joined at their common corners. At theta = pi/2 (t = 0) it is the sum of tiling and
// grids. L. Liu, G. P. T. Choi, L. Mahadevan, Quasicrystal kirigami, Physical Review Research 4,
// 2022, introduce these constructions.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <utility>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/generate/tiling.h"

namespace kirireel {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// An edge that two tiles share, with the vertices as tile a runs along it.
struct SharedEdge {
  int a = 0;
  int b = 0;
  int from = 0;
  int to = 0;
};

// Among the kept tiles.
std::vector<SharedEdge> sharedEdges(const Tiling& tiling, const std::vector<int>& kept) {
  std::map<std::pair<int, int>, int> runners;
  std::vector<SharedEdge> edges;
  for (const int tile : kept) {
    const std::vector<int>& vertices = tiling.tiles[std::size_t(tile)];
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const int from = vertices[k], to = vertices[(k + 1) % vertices.size()];
      runners[{from, to}] = tile;
      // The neighbour runs along the same edge the other way.
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

Tile placed(const Tiling& tiling, int tile) {
  Tile result;
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

/// The kept tiles, numbered anew, with these joints.
Model jointedModel(const Tiling& tiling, const std::vector<int>& kept,
                   const std::vector<VertexJoint>& joints) {
  Model model;
  std::map<int, int> numbers;
  for (const int tile : kept) {
    numbers.emplace(tile, static_cast<int>(model.tiles.size()));
    model.tiles.push_back(placed(tiling, tile));
  }
  for (const VertexJoint& joint : joints) {
    model.joints.push_back({{numbers.at(joint.a), cornerAt(tiling, joint.a, joint.vertex)},
                            {numbers.at(joint.b), cornerAt(tiling, joint.b, joint.vertex)},
                            JointFace::Both});
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

/// Leaves out tiles with fewer than two neighbours until none is left.
std::vector<int> withTwoNeighbours(const Tiling& tiling) {
  std::vector<int> kept = allTiles(tiling);
  // Leaving out a tile may leave another with one neighbour.
  for (std::size_t before = 0; before != kept.size();) {
    before = kept.size();
    const Neighbours neighbours = neighboursOf(tiling, kept);
    std::erase_if(kept, [&](int tile) { return neighbours[std::size_t(tile)].size() < 2; });
  }
  return kept;
}

/// Looks for a closed path through all tiles by turning pieces of a path round (Posa 1976), from a
/// fixed seed.
class ChainSearch {
 public:
  ChainSearch(const Neighbours& neighbours, const std::vector<int>& tiles)
      : neighbours_(neighbours), tiles_(tiles), place_(neighbours.size(), -1) {}

  /// The path, or an empty one.
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

  // Whether the path's end is a neighbour of its beginning.
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

  /// Goes on to the free neighbour with the fewest ways out, or turns the end of the path round so
  /// that it ends elsewhere.
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
    // The pivot is the end's own predecessor: nothing would be turned round. Another draw may do
    // better.
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

/// Which tiles joints hold together: the same number for all tiles of a part.
class Parts {
 public:
  explicit Parts(std::size_t tiles) : parents_(tiles) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  int partOf(int tile) const {
    while (parents_[std::size_t(tile)] != tile) tile = parents_[std::size_t(tile)];
    return tile;
  }
  void join(const VertexJoint& joint) { parents_[std::size_t(partOf(joint.b))] = partOf(joint.a); }

  /// The largest part's number.
  int largest(const std::vector<int>& tiles) const {
    std::map<int, int> sizes;
    for (const int tile : tiles) ++sizes[partOf(tile)];
    return std::max_element(sizes.begin(), sizes.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }

 private:
  std::vector<int> parents_;
};

/// The tiles round each vertex.
std::vector<std::vector<int>> tilesRound(const Tiling& tiling) {
  std::vector<std::vector<int>> around(tiling.vertices.size());
  for (const int tile : allTiles(tiling)) {
    for (const int vertex : tiling.tiles[std::size_t(tile)]) {
      around[std::size_t(vertex)].push_back(tile);
    }
  }
  return around;
}

/// Whether the tiles round a vertex leave no gap.
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

/// The tiles round an inner vertex in the order of their duals round the cell.
void sortRoundCell(const Tiling& tiling, std::vector<int>& around) {
  Complex middle;
  for (const int tile : around) middle += tiling.duals[std::size_t(tile)] / double(around.size());
  std::sort(around.begin(), around.end(), [&](int a, int b) {
    return std::arg(tiling.duals[std::size_t(a)] - middle) <
           std::arg(tiling.duals[std::size_t(b)] - middle);
  });
}

/// A joint for every two of the tiles that share an edge, at its clockwise end as seen from the
/// centre; at the outer end of an edge that points away from the centre.
std::vector<VertexJoint> clockwiseJoints(const Tiling& tiling, const std::vector<int>& kept) {
  std::vector<VertexJoint> joints;
  for (const SharedEdge& edge : sharedEdges(tiling, kept)) {
    const Complex from = tiling.vertices[std::size_t(edge.from)];
    const Complex to = tiling.vertices[std::size_t(edge.to)];
    const double turn = (std::conj(from) * to).imag();
    // An edge that points away from the centre has no clockwise end.
    const bool atFrom = std::abs(turn) > 1e-9 ? turn > 0 : std::abs(from) > std::abs(to);
    joints.push_back({edge.a, edge.b, atFrom ? edge.from : edge.to});
  }
  return joints;
}

/// The first vertex of a that b has, too.
int sharedVertex(const Tiling& tiling, int a, int b) {
  const std::vector<int>& inA = tiling.tiles[std::size_t(a)];
  const std::vector<int>& inB = tiling.tiles[std::size_t(b)];
  return *std::find_first_of(inA.begin(), inA.end(), inB.begin(), inB.end());
}

/// Where a tile's corner at a vertex stands when tiles and cells have turned.
Vector3 expandedCorner(const Tiling& tiling, int tile, int vertex, double angle) {
  const Complex turn = std::polar(1.0, 0.5 * angle - pi / 4);
  const Complex place = tiling.vertices[std::size_t(vertex)] * turn +
                        tiling.spread * tiling.duals[std::size_t(tile)] * std::conj(turn);
  return {place.real() + 0.0, place.imag() + 0.0, 0};
}

}  // namespace

Model makeChain(const Tiling& tiling) {
  const std::vector<int> kept = withTwoNeighbours(tiling);
  const Neighbours neighbours = neighboursOf(tiling, kept);
  const std::vector<int> path = kept.empty() ? kept : ChainSearch(neighbours, kept).find();
  if (path.empty()) {
    throw InputError(fmt::format(
        "chain: error: none through all of these {} tiles was found; give another number "
        "of tiles",
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

Model makeThinned(const Tiling& tiling) {
  std::vector<int> kept = allTiles(tiling);
  const auto isThin = [&](int tile) { return bool(tiling.isThin[std::size_t(tile)]); };
  std::erase_if(kept, isThin);
  std::vector<VertexJoint> joints = clockwiseJoints(tiling, kept);
  Parts parts(tiling.tiles.size());
  for (const VertexJoint& joint : joints) parts.join(joint);
  // Parts that touch at a vertex alone are linked there.
  // Which parts touch is judged before any of them is linked, so that the order of vertices does
  // not matter.
  const Parts byEdges = parts;
  for (std::vector<int>& around : tilesRound(tiling)) {
    std::erase_if(around, isThin);
    if (around.empty()) continue;
    const auto other = std::find_if(around.begin(), around.end(), [&](int tile) {
      return byEdges.partOf(tile) != byEdges.partOf(around.front());
    });
    if (other == around.end()) continue;
    joints.push_back({around.front(), *other, sharedVertex(tiling, around.front(), *other)});
    parts.join(joints.back());
  }
  const int part = parts.largest(kept);
  std::erase_if(kept, [&](int tile) { return parts.partOf(tile) != part; });
  std::erase_if(joints, [&](const VertexJoint& joint) { return parts.partOf(joint.a) != part; });
  return jointedModel(tiling, kept, joints);
}

Model makeExpanded(const Tiling& tiling, double startAngle, double targetAngle) {
  Model model;
  model.target.emplace();
  const auto append = [&](const std::vector<std::pair<int, int>>& corners) {
    Tile& start = model.tiles.emplace_back();
    Tile& target = model.target->emplace_back();
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
                              JointFace::Both});
      corners.emplace_back(tile, vertex);
    }
    append(corners);
  }
  return model;
}

}  // namespace kirireel
