// Unknown nodes of two states of one sheet, and the equations that make the states congruent.
//
// With a = p_1 - p_0, b = p_2 - p_0, c = p_3 - p_0 for the corners p_k of a quad (m), the shape of
// a planar quad is known from five inner products,
//   a . a,   a . c,   c . c,   b . a,   b . c                  m^2
// the first three fix the triangle p_0 p_1 p_3, the other two the components of b in its plane.
// Each is set equal in both states. Edge lengths with one diagonal would be five equations too, but
// they allow the quad to fold over its diagonal, and fits fell into that. A quad in space is planar
// where a . (b x c) = 0 (m^3). The slopes follow by the product rule: d(u . w) = w . du + u . dw.
#include "sim/generate/two_states.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include "sim/model/turning_field.h"

namespace kirireel {
namespace {

/// Groups of corners, merged pair by pair.
class JoinedCorners {
 public:
  explicit JoinedCorners(int tiles) : parents_(std::size_t(4 * tiles)) {
    std::iota(parents_.begin(), parents_.end(), 0);
  }

  void merge(int a, int b) { parents_[std::size_t(find(b))] = find(a); }

  // Numbered by their first corners.
  NodeMap nodes() {
    NodeMap map;
    std::map<int, int> numbers;
    const int tiles = static_cast<int>(parents_.size()) / 4;
    for (int tile = 0; tile < tiles; ++tile) {
      std::vector<int>& nodes = map.nodeOf.emplace_back();
      for (int k = 0; k < 4; ++k) {
        const auto [entry, isNew] = numbers.try_emplace(find(4 * tile + k), map.nodeCount);
        map.nodeCount += isNew ? 1 : 0;
        nodes.push_back(entry->second);
      }
    }
    return map;
  }

 private:
  // Groups have four corners at most, so that their trees stay flat without further care.
  int find(int corner) {
    while (parents_[std::size_t(corner)] != corner) corner = parents_[std::size_t(corner)];
    return corner;
  }

  std::vector<int> parents_;
};

/// A quad's edges and diagonal from its corner 0.
struct QuadVectors {
  std::array<UnknownPoint, 4> corners;

  Vector3 from0(int corner) const { return corners[std::size_t(corner)].value - corners[0].value; }
};

// The four corners of a tile as unknowns.
QuadVectors quadOf(const StateUnknowns& state, const Eigen::VectorXd& unknowns, int tile) {
  QuadVectors quad;
  for (int k = 0; k < 4; ++k) quad.corners[std::size_t(k)] = state.point(unknowns, tile, k);
  return quad;
}

/// Slopes of the inner product of the vectors to two corners, times a sign.
void addProductSlopes(EquationRows& rows, const QuadVectors& quad, int i, int j, double sign) {
  const Vector3 toI = quad.from0(i);
  const Vector3 toJ = quad.from0(j);
  addSlope(rows, quad.corners[std::size_t(i)], sign * toJ);
  addSlope(rows, quad.corners[std::size_t(j)], sign * toI);
  addSlope(rows, quad.corners[0], -sign * (toI + toJ));
}

}  // namespace

NodeMap openNodes(const Lattice& lattice) {
  JoinedCorners groups(lattice.tileCount());
  for (const Joint& joint : latticeJoints(lattice, JointFace::Bottom)) {
    groups.merge(4 * joint.a.tile + joint.a.vertex, 4 * joint.b.tile + joint.b.vertex);
  }
  return groups.nodes();
}

NodeMap nodesClosedAtStart(const Lattice& lattice) {
  NodeMap map;
  map.nodeCount = (lattice.columns + 1) * (lattice.rows + 1);
  for (int tile = 0; tile < lattice.tileCount(); ++tile) {
    const Cell cell = lattice.cellOf(tile);
    const int corner = cell.column * (lattice.rows + 1) + cell.row;
    const int next = corner + lattice.rows + 1;
    map.nodeOf.push_back({corner, next, next + 1, corner + 1});
  }
  return map;
}

NodeMap nodesClosedAtEnd(const Lattice& lattice) {
  const std::vector<Tile> closed = regularField(lattice, 1, Complex(0, 1)).tiles(std::numbers::pi);
  // Corners of unit squares coincide or are 1 apart.
  std::map<std::pair<long, long>, int> numbers;
  NodeMap map;
  for (const Tile& tile : closed) {
    std::vector<int>& nodes = map.nodeOf.emplace_back();
    for (const Vector3& vertex : tile.vertices) {
      // Sheets with an even and an odd number of tiles have corners at whole or at half numbers.
      const std::pair place{std::lround(2 * vertex.x()), std::lround(2 * vertex.y())};
      const auto [entry, isNew] = numbers.try_emplace(place, map.nodeCount);
      map.nodeCount += isNew ? 1 : 0;
      nodes.push_back(entry->second);
    }
  }
  return map;
}

UnknownPoint StateUnknowns::point(const Eigen::VectorXd& unknowns, int node) const {
  UnknownPoint point;
  point.first = first + dimension * node;
  point.dimension = dimension;
  point.value.head(dimension) = unknowns.segment(point.first, dimension);
  return point;
}

void StateUnknowns::pack(const std::vector<Tile>& tiles, Eigen::VectorXd& unknowns) const {
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    for (std::size_t k = 0; k < 4; ++k) {
      unknowns.segment(first + dimension * nodes.nodeOf[tile][k], dimension) =
          tiles[tile].vertices[k].head(dimension);
    }
  }
}

std::vector<Tile> StateUnknowns::tiles(const Eigen::VectorXd& unknowns) const {
  std::vector<Tile> tiles(nodes.nodeOf.size());
  for (std::size_t tile = 0; tile < tiles.size(); ++tile) {
    for (const int node : nodes.nodeOf[tile]) {
      tiles[tile].vertices.push_back(point(unknowns, node).value);
    }
  }
  return tiles;
}

void addSlope(EquationRows& rows, const UnknownPoint& point, const Vector3& slope) {
  for (int axis = 0; axis < point.dimension; ++axis) rows.slope(point.first + axis, slope[axis]);
}

void addPosition(EquationRows& rows, const UnknownPoint& point, const Vector3& direction,
                 double value, double weight) {
  rows.begin(weight * (direction.dot(point.value) - value));
  addSlope(rows, point, weight * direction);
}

void addOnSphere(EquationRows& rows, const UnknownPoint& point, double radius, double weight) {
  const double distance = point.value.norm();
  rows.begin(weight * (distance - radius));
  addSlope(rows, point, weight / distance * point.value);
}

void addNear(EquationRows& rows, const UnknownPoint& point, const Vector3& wanted, double weight) {
  for (int axis = 0; axis < point.dimension; ++axis) {
    addPosition(rows, point, Vector3::Unit(axis), wanted[axis], weight);
  }
}

void addCongruence(EquationRows& rows, const StateUnknowns& a, const StateUnknowns& b,
                   const Eigen::VectorXd& unknowns) {
  constexpr std::pair<int, int> kProducts[] = {{1, 1}, {1, 3}, {3, 3}, {2, 1}, {2, 3}};
  for (int tile = 0; tile < std::ssize(a.nodes.nodeOf); ++tile) {
    const QuadVectors inA = quadOf(a, unknowns, tile);
    const QuadVectors inB = quadOf(b, unknowns, tile);
    for (const auto& [i, j] : kProducts) {
      rows.begin(inA.from0(i).dot(inA.from0(j)) - inB.from0(i).dot(inB.from0(j)));
      addProductSlopes(rows, inA, i, j, 1);
      addProductSlopes(rows, inB, i, j, -1);
    }
  }
}

void addPlanarity(EquationRows& rows, const StateUnknowns& state, const Eigen::VectorXd& unknowns) {
  for (int tile = 0; tile < std::ssize(state.nodes.nodeOf); ++tile) {
    const QuadVectors quad = quadOf(state, unknowns, tile);
    const Vector3 a = quad.from0(1), b = quad.from0(2), c = quad.from0(3);
    rows.begin(a.dot(b.cross(c)));
    addSlope(rows, quad.corners[1], b.cross(c));
    addSlope(rows, quad.corners[2], c.cross(a));
    addSlope(rows, quad.corners[3], a.cross(b));
    addSlope(rows, quad.corners[0], -(b.cross(c) + c.cross(a) + a.cross(b)));
  }
}

}  // namespace kirireel
