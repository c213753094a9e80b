// Measures of polygons and sheets, and the order of a file's vertices.
//
// A polygon with the vertices p_0 ... p_(n-1), anticlockwise seen from its normal, is a fan of
// triangles (p_0, p_k, p_(k+1)). With u_k = p_k - p_0, in metres:
//   a = sum over k of u_k x u_(k+1)                          twice the vector area, m^2
//   n = a / |a|                                              unit normal (Newell's method)
//   S = |a| / 2                                              area, m^2
//   c = p_0 + sum w_k (u_k + u_(k+1)) / 3 / sum w_k          centroid, w_k = (u_k x u_(k+1)) . n
// Triangles outside a concave polygon have negative weights w_k, which compensate the excess of
// other triangles. The formula therefore holds for convex and concave polygons without
// triangulation. Newell's method is described in I. E. Sutherland, R. F. Sproull, R. A. Schumacker,
// A characterization of ten hidden-surface algorithms, ACM Computing Surveys 6, 1974.
#include "sim/model/model.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "sim/base/disjoint_sets.h"

namespace kirireel::model {
Corner FileOrder::across(const Corner& corner, const std::vector<Tile>& tiles) const {
  if (isReversed.empty() || !isReversed[corner.tile]) return corner;
  // Reversal maps vertex k of n to n - 1 - k, and is its own inverse.
  return {corner.tile, static_cast<int>(tiles[corner.tile].vertices.size()) - 1 - corner.vertex};
}

Corner FileOrder::toModel(const Corner& numbered, const std::vector<Tile>& tiles) const {
  return across({numbered.tile - countsFrom, numbered.vertex - countsFrom}, tiles);
}

std::vector<Tile> inFileOrder(std::vector<Tile> tiles, const FileOrder& order) {
  for (std::size_t i = 0; i < order.isReversed.size(); ++i) {
    if (order.isReversed[i]) std::reverse(tiles[i].vertices.begin(), tiles[i].vertices.end());
  }
  return tiles;
}

Model inFileOrder(Model model) {
  // Corners are renumbered while model.tiles still has the vertex counts that across() needs.
  // Otherwise the order does not matter, since reversal keeps the counts.
  const auto turn = [&](Corner& corner) { corner = model.fileOrder.across(corner, model.tiles); };
  for (Joint& joint : model.joints) {
    turn(joint.a);
    turn(joint.b);
  }
  if (model.hull) std::for_each(model.hull->begin(), model.hull->end(), turn);
  for (Repair& repair : model.repairs)
    std::for_each(repair.corners.begin(), repair.corners.end(), turn);
  model.tiles = inFileOrder(std::move(model.tiles), model.fileOrder);
  if (model.target) model.target = inFileOrder(std::move(*model.target), model.fileOrder);
  for (std::vector<Tile>& state : model.waypoints) {
    state = inFileOrder(std::move(state), model.fileOrder);
  }
  // A second call must not reverse the tiles again.
  model.fileOrder.isReversed.clear();
  return model;
}

Joint makeFixedJoint(const std::vector<Tile>& tiles, int tileA, int tileB) {
  // Any corners suffice for a rigid connection. The first ones give it a position.
  const Vector3 apart = tiles[tileA].vertices.front() - tiles[tileB].vertices.front();
  return {{tileA, 0}, {tileB, 0}, JointFace::Bottom, JointKind::Fixed, apart};
}

Joint makeLink(const std::vector<Tile>& tiles, const Corner& a, const Corner& b) {
  const Vector3 apart = tiles[a.tile].vertices[a.vertex] - tiles[b.tile].vertices[b.vertex];
  return {a, b, JointFace::Bottom, JointKind::Link, apart};
}

Joint toKind(JointKind kind, const Joint& pivot, const std::vector<Tile>& tiles) {
  // The corners of a fixed joint in a file have no meaning.
  if (kind == JointKind::Fixed) return makeFixedJoint(tiles, pivot.a.tile, pivot.b.tile);
  if (kind == JointKind::Link) return makeLink(tiles, pivot.a, pivot.b);
  return pivot;
}

const char* kindName(const Joint& joint) {
  return kJointKinds[static_cast<std::size_t>(joint.kind)];
}

Vector3 tileNormal(const Tile& tile) {
  return doubledVectorArea(tile.vertices).normalized();
}

double tileArea(const Tile& tile) {
  return 0.5 * doubledVectorArea(tile.vertices).norm();
}

Vector3 tileCentroid(const Tile& tile) {
  const Vector3& origin = tile.vertices.front();
  const Vector3 normal = tileNormal(tile);
  Vector3 weighted = Vector3::Zero();
  double doubledArea = 0;
  // Triangles around the first vertex; signed areas are correct for any simple polygon.
  for (size_t k = 1; k + 1 < tile.vertices.size(); ++k) {
    const Vector3 left = tile.vertices[k] - origin;
    const Vector3 right = tile.vertices[k + 1] - origin;
    const double weight = left.cross(right).dot(normal);
    weighted += weight * (left + right) / 3.0;
    doubledArea += weight;
  }
  return origin + weighted / doubledArea;
}

// Ignores the target, which may be far away.
double modelSize(const Model& model) {
  const Eigen::AlignedBox3d box = boxOf(model.tiles);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

Eigen::AlignedBox3d boxOf(const std::vector<Tile>& tiles) {
  Eigen::AlignedBox3d box;
  for (const Tile& tile : tiles) box.extend(boundingBox(tile.vertices));
  return box;
}

// Long and short edges have equal weight, for every tile.
double tileSize(const Model& model) {
  double sum = 0;
  size_t edges = 0;
  for (const Tile& tile : model.tiles) {
    const size_t count = tile.vertices.size();
    for (size_t k = 0; k < count; ++k) {
      sum += (tile.vertices[(k + 1) % count] - tile.vertices[k]).norm();
    }
    edges += count;
  }
  return edges == 0 ? 0.0 : sum / static_cast<double>(edges);
}

double largestJointGap(const std::vector<Joint>& joints, const std::vector<Tile>& tiles) {
  double largest = 0;
  for (const Joint& joint : joints) {
    if (joint.kind != JointKind::Pivot) continue;
    const Vector3& a = tiles[std::size_t(joint.a.tile)].vertices[std::size_t(joint.a.vertex)];
    const Vector3& b = tiles[std::size_t(joint.b.tile)].vertices[std::size_t(joint.b.vertex)];
    largest = std::max(largest, (a - b).norm());
  }
  return largest;
}

int countTurnedOver(const std::vector<Tile>& start, const std::vector<Tile>& target) {
  int count = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    // The sign of the cosine shows whether the normals differ by more than 90 degrees.
    if (tileNormal(start[i]).dot(tileNormal(target[i])) < 0) ++count;
  }
  return count;
}

bool liesFlat(const std::vector<Tile>& tiles, double tolerance) {
  const double level = tiles.front().vertices.front().z();
  return std::all_of(tiles.begin(), tiles.end(), [&](const Tile& tile) {
    return std::all_of(tile.vertices.begin(), tile.vertices.end(), [&](const Vector3& vertex) {
      return std::abs(vertex.z() - level) <= tolerance;
    });
  });
}

std::string lengthInTiles(double metres, const Model& model, int digits) {
  return fmt::format("{} ({:.2g} tiles)", lengthText(metres, model.unit, digits),
                     metres / tileSize(model));
}

std::vector<int> piecesOf(const Model& model) {
  DisjointSets pieces(model.tiles.size());
  for (const Joint& joint : model.joints) pieces.unite(joint.a.tile, joint.b.tile);
  return pieces.numbers();
}

void scaleLengths(Model& model, double factor) {
  if (factor == 1) return;
  const auto scale = [factor](std::vector<Tile>& tiles) {
    for (Tile& tile : tiles) {
      for (Vector3& vertex : tile.vertices) vertex *= factor;
    }
  };
  scale(model.tiles);
  if (model.target) scale(*model.target);
  for (std::vector<Tile>& state : model.waypoints) scale(state);
  if (model.drawing) {
    for (Vector3& vertex : model.drawing->vertices) vertex *= factor;
  }
  for (Joint& joint : model.joints) {
    joint.apart *= factor;
    for (double* length : {&joint.neck.width, &joint.neck.length, &joint.neck.kerf}) {
      *length *= factor;
    }
  }
  model.rounding *= factor;
}

std::vector<Tile> inUnit(std::vector<Tile> tiles, const LengthUnit& unit) {
  for (Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = kirireel::inUnit(vertex, unit);
  }
  return tiles;
}

Model inUnit(Model model, const LengthUnit& unit) {
  model.tiles = inUnit(std::move(model.tiles), unit);
  if (model.target) model.target = inUnit(std::move(*model.target), unit);
  for (std::vector<Tile>& state : model.waypoints) state = inUnit(std::move(state), unit);
  if (model.drawing) {
    for (Vector3& vertex : model.drawing->vertices) vertex = kirireel::inUnit(vertex, unit);
  }
  for (Joint& joint : model.joints) {
    joint.apart = kirireel::inUnit(joint.apart, unit);
    for (double* length : {&joint.neck.width, &joint.neck.length, &joint.neck.kerf}) {
      *length = kirireel::inUnit(*length, unit);
    }
  }
  model.rounding = kirireel::inUnit(model.rounding, unit);
  model.unit = unit;
  return model;
}

}  // namespace kirireel::model
