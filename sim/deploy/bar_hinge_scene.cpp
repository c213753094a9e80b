// A scene's tiles as bars and hinges (bar_hinge_sheet.h).
//
// Corners that joints hold together, in groups, become nodes: the mean of their places. Each tile
// is divided into triangles; every side of a triangle is a bar, with the areas of the triangles on
// its sides added up (panel_stiffness.h), so that a bar between two tiles carries for both. A side
// between two triangles of one tile is where the tile bends, one between triangles of two tiles a
// fold.
#include "sim/deploy/bar_hinge_scene.h"

#include <algorithm>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/equilibrium/bar_hinge_sheet.h"
#include "sim/model/panel_stiffness.h"
#include "sim/model/split_tiles.h"

namespace kirireel {
namespace {

/// The node of each corner of each tile: corners that joints hold together have one.
std::vector<std::vector<int>> nodesOfTiles(const Model& model, int& count) {
  std::vector<std::vector<int>> corners;
  // Numbers of all corners, tile after tile.
  int next = 0;
  for (const Tile& tile : model.tiles) {
    corners.emplace_back(tile.vertices.size());
    std::iota(corners.back().begin(), corners.back().end(), next);
    next += static_cast<int>(tile.vertices.size());
  }
  std::vector<int> parent(static_cast<std::size_t>(next));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int k) {
    while (parent[static_cast<std::size_t>(k)] != k) k = parent[static_cast<std::size_t>(k)];
    return k;
  };
  const auto cornerAt = [&](const Corner& corner) {
    return corners[static_cast<std::size_t>(corner.tile)][static_cast<std::size_t>(corner.vertex)];
  };
  for (const Joint& joint : model.joints) {
    const int a = root(cornerAt(joint.a)), b = root(cornerAt(joint.b));
    // The lower number leads: groups do not depend on the order of joints.
    parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  std::map<int, int> numbers;
  for (std::vector<int>& tile : corners) {
    for (int& corner : tile) {
      corner = numbers.try_emplace(root(corner), static_cast<int>(numbers.size())).first->second;
    }
  }
  count = static_cast<int>(numbers.size());
  return corners;
}

/// One triangle at an edge.
struct PanelSide {
  int tile = 0;
  int from = 0, to = 0;  // anticlockwise in the triangle
  int wing = 0;          // its third node
  std::array<int, 3> corners{};
};

using Edge = std::pair<int, int>;
using Edges = std::map<Edge, std::vector<PanelSide>>;

// By their two nodes, the lower first, with the triangles on their sides.
Edges edgesOf(const Model& model, const std::vector<std::vector<int>>& nodes) {
  Edges edges;
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    for (const std::array<int, 3>& triangle : tileTriangles(model.tiles[t])) {
      std::array<int, 3> n{};
      for (std::size_t k = 0; k < 3; ++k) {
        n[k] = nodes[t][static_cast<std::size_t>(triangle[k])];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const int from = n[k], to = n[(k + 1) % 3];
        edges[std::minmax(from, to)].push_back({static_cast<int>(t), from, to, n[(k + 2) % 3], n});
      }
    }
  }
  return edges;
}

/// A sheet in the making.
class BarHingeMaker {
 public:
  BarHingeMaker(const Scene& scene, const std::vector<Brick>& bricks)
      : scene_(scene), material_(*scene.hinges.panels), thickness_(scene.brick.thickness) {
    int count = 0;
    made_.tiles = nodesOfTiles(scene.model, count);
    made_.start = startPoses(scene.model.tiles, bricks);
    placeNodes(count);
    edges_ = edgesOf(scene.model, made_.tiles);
    for (const auto& [edge, sides] : edges_) addBar(edge, sides);
    for (const auto& [edge, sides] : edges_) addBends(sides);
  }

  // Springs at hinges of the scene, at every edge that their two tiles share.
  void addFolds(const std::vector<HingeSpring>& springs) {
    for (const HingeSpring& spring : springs) {
      const auto [a, b] = std::pair(spring.hinge.brickA, spring.hinge.brickB);
      bool isFound = false;
      for (const auto& [edge, sides] : edges_) {
        for (const PanelSide& left : sides) {
          for (const PanelSide& right : sides) {
            if (left.tile != a || right.tile != b) continue;
            addFold(left, right, spring.stiffness).rest = spring.rest;
            isFound = true;
          }
        }
      }
      if (!isFound) refuseHinge(a, b);
    }
  }

  /// Folds between all tiles, by the length scale of folds.
  void addUsualFolds() {
    for (const auto& [edge, sides] : edges_) {
      for (std::size_t b = 1; b < sides.size(); ++b) {
        for (std::size_t a = 0; a < b; ++a) {
          if (sides[a].tile == sides[b].tile) continue;
          addFold(sides[a], sides[b],
                  foldStiffness(lengthOf(edge), material_.foldLength, material_.youngs,
                                material_.poisson, thickness_));
        }
      }
    }
  }

  // All nodes of these tiles.
  void fix(const std::vector<int>& tiles) {
    for (const int tile : tiles) {
      const std::vector<int>& nodes = made_.tiles[static_cast<std::size_t>(tile)];
      made_.fixed.insert(made_.fixed.end(), nodes.begin(), nodes.end());
    }
    std::ranges::sort(made_.fixed);
    const auto twice = std::ranges::unique(made_.fixed);
    made_.fixed.erase(twice.begin(), twice.end());
  }

  NodeGrip gripOf(const GripOrder& order) const {
    if (order.name.isTurn) {
      throw inputErrorAt(order.setting->where,
                         "tiles that bend have no turn of their own; hold or move their vertices");
    }
    NodeGrip grip{{}, order.direction, order.amount, order.setting->isForce};
    for (const Corner& corner : order.setting->corners) {
      grip.handles.push_back({made_.tiles[static_cast<std::size_t>(corner.tile)]
                                         [static_cast<std::size_t>(corner.vertex)]});
    }
    if (!grip.handles.empty()) return grip;
    for (const int tile : order.setting->tiles) {
      grip.handles.push_back(made_.tiles[static_cast<std::size_t>(tile)]);
    }
    return grip;
  }

  BarHingeModel take() { return std::move(made_); }

 private:
  /// Each node where its corners are on the average.
  void placeNodes(int count) {
    made_.nodes.assign(static_cast<std::size_t>(count), Vector3::Zero());
    std::vector<double> corners(static_cast<std::size_t>(count), 0);
    for (std::size_t t = 0; t < made_.tiles.size(); ++t) {
      for (std::size_t k = 0; k < made_.tiles[t].size(); ++k) {
        const auto node = static_cast<std::size_t>(made_.tiles[t][k]);
        made_.nodes[node] += scene_.model.tiles[t].vertices[k];
        ++corners[node];
      }
    }
    for (std::size_t n = 0; n < made_.nodes.size(); ++n) made_.nodes[n] /= corners[n];
  }

  const Vector3& at(int node) const { return made_.nodes[static_cast<std::size_t>(node)]; }
  double lengthOf(const Edge& edge) const { return (at(edge.second) - at(edge.first)).norm(); }

  // One bar for all triangles at the edge.
  void addBar(const Edge& edge, const std::vector<PanelSide>& sides) {
    double area = 0;
    for (const PanelSide& side : sides) {
      const auto& [a, b, c] = side.corners;
      area += barArea({at(a), at(b), at(c)}, thickness_, material_.poisson);
    }
    const double length = lengthOf(edge);
    // Stiffness of a bar: E A / l.
    made_.bars.push_back({edge.first, edge.second, length, material_.youngs * area / length});
  }

  /// Where a tile bends: between two of its triangles.
  void addBends(const std::vector<PanelSide>& sides) {
    for (std::size_t b = 1; b < sides.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const PanelSide &left = sides[a], &right = sides[b];
        if (left.tile != right.tile) continue;
        const std::array<Vector3, 4> corners = {at(left.from), at(right.wing), at(left.to),
                                                at(left.wing)};
        addFold(left, right,
                bendStiffness(corners, (corners[2] - corners[0]).norm(), material_.youngs,
                              material_.poisson, thickness_));
      }
    }
  }

  Fold& addFold(const PanelSide& left, const PanelSide& right, double stiffness) {
    Fold fold{{left.from, left.to, left.wing, right.wing}, stiffness, 0};
    // Without a rest angle of its own a fold rests as it stands.
    fold.rest = foldAngle({at(left.from), at(left.to), at(left.wing), at(right.wing)});
    return made_.folds.emplace_back(fold);
  }

  [[noreturn]] void refuseHinge(int a, int b) const {
    const int first = scene_.model.fileOrder.countsFrom;
    throw InputError(fmt::format(
        "error: tiles that bend fold about edges that two of them have in common, but tiles {} and "
        "{} have none; split the tile with the longer edge at the corner of the other",
        first + a, first + b));
  }

  const Scene& scene_;
  const PanelMaterial& material_;
  double thickness_;
  BarHingeModel made_;
  Edges edges_;
};

void requireNodes(const Model& model) {
  for (const Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) {
      throw InputError(
          "error: tiles that bend are joined at corners; leave --fix and --link away, or --panels");
    }
    if (joint.face == JointFace::Both) {
      throw InputError(
          "error: tiles that bend are joined at one face, not at both as hinges through their "
          "thickness are; give --face bottom, or leave --panels away");
    }
  }
}

}  // namespace

std::unique_ptr<LoadedSheet> makeBarHingeSheet(const Scene& scene, const std::vector<Brick>& bricks,
                                               const std::vector<HingeSpring>& springs,
                                               const std::vector<int>& pinned,
                                               const std::vector<GripOrder>& grips) {
  requireNodes(scene.model);
  BarHingeMaker maker(scene, bricks);
  if (scene.hinges.areOn()) {
    maker.addFolds(springs);
  } else if (scene.hinges.panels->foldLength > 0) {
    maker.addUsualFolds();
  }
  maker.fix(pinned);
  std::vector<NodeGrip> held;
  for (const GripOrder& grip : grips) held.push_back(maker.gripOf(grip));
  return std::make_unique<BarHingeSheet>(maker.take(), std::move(held));
}

}  // namespace kirireel
