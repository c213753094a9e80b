/// Checks of sheets by independent rules, which the generators do not use.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/model/model.h"

namespace kirireel::test {

/// Largest change of any distance between two vertices of a tile.
inline double incongruence(const model::Model& model) {
  double worst = 0;
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    const auto& before = model.tiles[i].vertices;
    const auto& after = model.target->at(i).vertices;
    for (std::size_t a = 0; a < before.size(); ++a) {
      for (std::size_t b = a + 1; b < before.size(); ++b) {
        worst = std::max(worst,
                         std::abs((before[a] - before[b]).norm() - (after[a] - after[b]).norm()));
      }
    }
  }
  return worst;
}

/// Largest distance between the corners of a joint.
inline double opening(const model::Model& model, const std::vector<model::Tile>& tiles) {
  double worst = 0;
  for (const model::Joint& joint : model.joints) {
    worst = std::max(worst, (tiles.at(joint.a.tile).vertices.at(joint.a.vertex) -
                             tiles.at(joint.b.tile).vertices.at(joint.b.vertex))
                                .norm());
  }
  return worst;
}

/// Least signed distance of any vertex of a tile from the line of any other edge of it, over the
/// tile's longest edge: > 0 for convex tiles that are anticlockwise about `up`.
inline double convexity(const model::Tile& tile, const Vector3& up) {
  const std::size_t count = tile.vertices.size();
  double least = std::numeric_limits<double>::infinity(), longest = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3 edge = tile.vertices[(k + 1) % count] - tile.vertices[k];
    longest = std::max(longest, edge.norm());
    for (std::size_t other = 0; other < count; ++other) {
      if (other == k || other == (k + 1) % count) continue;
      const Vector3 inwards = up.cross(edge).normalized();
      least = std::min(least, inwards.dot(tile.vertices[other] - tile.vertices[k]));
    }
  }
  return least / longest;
}

/// The normal from two edges at the first corner.
inline Vector3 cornerNormal(const model::Tile& tile) {
  return (tile.vertices[1] - tile.vertices[0])
      .cross(tile.vertices.back() - tile.vertices[0])
      .normalized();
}

/// Largest distance of a vertex from the plane of its tile's first corner.
inline double warp(const std::vector<model::Tile>& tiles) {
  double worst = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      worst = std::max(worst, std::abs(cornerNormal(tile).dot(vertex - tile.vertices[0])));
    }
  }
  return worst;
}

/// Whether a tile's interior, shrunk to 97 %, holds a point that another one's edge passes through:
/// brute force over edges and triangles, in space.
inline bool pierces(const model::Tile& tile, const model::Tile& edges) {
  const auto shrunk = [](const model::Tile& whole) {
    Vector3 middle = Vector3::Zero();
    for (const Vector3& vertex : whole.vertices) middle += vertex / double(whole.vertices.size());
    model::Tile small = whole;
    for (Vector3& vertex : small.vertices) vertex = middle + 0.97 * (vertex - middle);
    return small;
  };
  const model::Tile face = shrunk(tile), wire = shrunk(edges);
  const Vector3 normal = cornerNormal(face);
  for (std::size_t k = 0; k < wire.vertices.size(); ++k) {
    const Vector3& from = wire.vertices[k];
    const Vector3& to = wire.vertices[(k + 1) % wire.vertices.size()];
    const double before = normal.dot(from - face.vertices[0]);
    const double after = normal.dot(to - face.vertices[0]);
    if (before * after > 0 || std::abs(before - after) < 1e-12) continue;
    const Vector3 point = from + before / (before - after) * (to - from);
    bool inside = true;
    for (std::size_t e = 0; e < face.vertices.size() && inside; ++e) {
      const Vector3& corner = face.vertices[e];
      const Vector3 edge = face.vertices[(e + 1) % face.vertices.size()] - corner;
      inside = normal.dot(edge.cross(point - corner)) > 0;
    }
    if (inside) return true;
  }
  return false;
}

/// Whether two convex tiles in one horizontal plane overlap. If not, the line of an edge of either
/// separates them.
inline bool overlapFlat(const model::Tile& a, const model::Tile& b) {
  for (const model::Tile* tile : {&a, &b}) {
    const model::Tile& other = tile == &a ? b : a;
    for (std::size_t k = 0; k < tile->vertices.size(); ++k) {
      const Vector3& from = tile->vertices[k];
      const Vector3 edge = tile->vertices[(k + 1) % tile->vertices.size()] - from;
      const bool apart =
          std::all_of(other.vertices.begin(), other.vertices.end(), [&](const Vector3& vertex) {
            return edge.cross(vertex - from).z() <= 1e-9 * edge.norm();
          });
      if (apart) return false;
    }
  }
  return true;
}

/// Pairs of tiles that overlap.
inline int overlaps(const std::vector<model::Tile>& tiles, bool flat) {
  int count = 0;
  for (std::size_t a = 0; a < tiles.size(); ++a) {
    Eigen::AlignedBox3d box;
    for (const Vector3& vertex : tiles[a].vertices) box.extend(vertex);
    for (std::size_t b = a + 1; b < tiles.size(); ++b) {
      Eigen::AlignedBox3d other;
      for (const Vector3& vertex : tiles[b].vertices) other.extend(vertex);
      if (!box.intersects(other)) continue;
      const bool meet = flat ? overlapFlat(tiles[a], tiles[b])
                             : pierces(tiles[a], tiles[b]) || pierces(tiles[b], tiles[a]);
      count += meet ? 1 : 0;
    }
  }
  return count;
}

}  // namespace kirireel::test
