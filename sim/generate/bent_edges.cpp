// Bent sides: each side of a tile gets further corners, at p + x s + y (s x n), where p is the
// side's first corner, s the side as a vector (m), n the tile's unit normal, and (x, y) a point of
// the list, in parts of the side's length. s x n points out of an anticlockwise tile and is as long
// as the side.
//
// Two tiles that share a side run along it in opposite directions, so that a point at x of one is
// at 1 - x of the other: lists that are the same from either end fit into each other.
#include "sim/generate/bent_edges.h"

namespace kirireel {
namespace {

// Corners of a tile with the points of its sides between them.
Tile bent(const Tile& tile, bool bulges, const std::vector<SidePoint>& points) {
  const Vector3 normal = tileNormal(tile);
  Tile result;
  const std::size_t count = tile.vertices.size();
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& from = tile.vertices[k];
    const Vector3 side = tile.vertices[(k + 1) % count] - from;
    const Vector3 outwards = side.cross(normal);  // as long as the side
    result.vertices.push_back(from);
    for (const SidePoint& point : points) {
      const double out = bulges ? point.out : -point.out;
      result.vertices.emplace_back(from + point.along * side + out * outwards);
    }
  }
  return result;
}

}  // namespace

Model withBentSides(const Model& model, const std::vector<bool>& bulges,
                    const std::vector<SidePoint>& points) {
  Model result = model;
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    result.tiles[i] = bent(model.tiles[i], bulges[i], points);
    if (model.target) (*result.target)[i] = bent((*model.target)[i], bulges[i], points);
  }
  // Corner k of a tile is corner k (1 + points) of the bent one.
  const int corners = 1 + static_cast<int>(points.size());
  for (Joint& joint : result.joints) {
    joint.a.vertex *= corners;
    joint.b.vertex *= corners;
  }
  return result;
}

}  // namespace kirireel
