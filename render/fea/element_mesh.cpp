#include "render/fea/element_mesh.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "render/fea/footprint.h"
#include "render/fea/node_clusters.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr int kMostElements = 64;
/// More would fill memory, and no program reads them.
constexpr std::size_t kMostElementsInAll = 4'000'000;
/// Elements this many times longer than thick are useless in any program.
constexpr double kMostAspect = 500;

void requireValidRule(const ElementRule& rule) {
  const auto require = [](int found, const char* what) {
    if (found >= 1 && found <= kMostElements) return;
    throw InputError(fmt::format("error: {} elements {} are not possible; choose 1 to {}", found,
                                 what, kMostElements));
  };
  require(rule.perEdge, "per edge");
  require(rule.through, "through the thickness");
  if (rule.joints == JointStyle::Patch && !(rule.patchRadius > 0)) {
    throw InputError(
        fmt::format("error: a joint patch cannot have the radius {} m; give a positive "
                    "one, at least the length of an element's edge",
                    rule.patchRadius));
  }
}

void requireReasonableCount(const std::vector<Brick>& bricks, const ElementRule& rule) {
  std::size_t cells = 0;
  for (const Brick& brick : bricks) {
    const std::size_t sides = brick.bottom.size();
    cells += (sides > 4 ? sides : 1) * rule.perEdge * rule.perEdge;
  }
  const std::size_t count = cells * rule.through;
  if (count <= kMostElementsInAll) return;
  throw InputError(
      fmt::format("error: {} elements would be made, at most {} are allowed; use fewer "
                  "per edge or through the thickness",
                  count, kMostElementsInAll));
}

/// Cells, points and edges of each shape of tile, made once.
class Footprints {
 public:
  explicit Footprints(int perEdge) : perEdge_(perEdge) {}

  const Footprint& of(const Brick& brick) {
    if (!brick.parts.empty()) return ofConcave(brick);
    const bool isGrid = takesGrid(brick.bottom, brick.normal);
    const int sides = static_cast<int>(brick.bottom.size());
    const auto [place, isNew] = made_.try_emplace({sides, isGrid});
    if (isNew) place->second = isGrid ? gridFootprint(perEdge_) : fanFootprint(sides, perEdge_);
    return place->second;
  }

 private:
  const Footprint& ofConcave(const Brick& brick) {
    const std::vector<std::array<int, 3>> triangles = trianglesOf(brick.bottom, brick.normal);
    const auto [place, isNew] = concave_.try_emplace(triangles);
    const int sides = static_cast<int>(brick.bottom.size());
    if (isNew) place->second = triangleFootprint(triangles, sides, perEdge_);
    return place->second;
  }

  int perEdge_;
  std::map<std::pair<int, bool>, Footprint> made_;
  std::map<std::vector<std::array<int, 3>>, Footprint> concave_;  ///< by their triangles
};

/// Appends one brick after the other to a mesh.
class MeshBuilder {
 public:
  MeshBuilder(ElementMesh& mesh) : mesh_(mesh), levels_(mesh.rule.through * step() + 1) {}

  void append(const Brick& brick, const Pose& pose, const Footprint& footprint) {
    footprint_ = &footprint;
    tile_ = {};
    pointNode_.assign(levels_, std::vector<int>(footprint.points.size(), -1));
    edgeNode_.assign(levels_, {});
    for (int level = 0; level < levels_; ++level) appendLevel(brick, pose, level);
    appendElements();
    for (const int corner : footprint.corners) {
      std::vector<int>& edge = tile_.edges.emplace_back();
      for (int level = 0; level < levels_; ++level) edge.push_back(pointNode_[level][corner]);
    }
    mesh_.tiles.push_back(std::move(tile_));
  }

 private:
  /// Quadratic elements have a level of nodes halfway up.
  int step() const { return mesh_.rule.quadratic ? 2 : 1; }

  void appendLevel(const Brick& brick, const Pose& pose, int level) {
    const double share = static_cast<double>(level) / (levels_ - 1);
    const Vector3 up = share * brick.thickness * brick.normal;
    std::vector<Vector3> bases = brick.bottom;
    // The centre of mass is the origin of brick axes, the bottom's half a thickness below it.
    bases.emplace_back(-0.5 * brick.thickness * brick.normal);
    std::vector<Vector3> points;
    for (const FootprintPoint& point : footprint_->points) points.push_back(point.at(bases) + up);
    for (std::size_t k = 0; k < points.size(); ++k) {
      pointNode_[level][k] = addNode(pose.apply(points[k]), level);
    }
    if (!mesh_.rule.quadratic || level % 2 == 1) return;
    for (const auto& [a, b] : footprint_->edges) {
      edgeNode_[level].push_back(addNode(pose.apply(0.5 * (points[a] + points[b])), level));
    }
  }

  int addNode(const Vector3& position, int level) {
    const int number = static_cast<int>(mesh_.nodes.size());
    mesh_.nodes.push_back(position);
    tile_.nodes.push_back(number);
    if (level == 0) tile_.bottom.push_back(number);
    if (level == levels_ - 1) tile_.top.push_back(number);
    return number;
  }

  void appendElements() {
    tile_.firstElement = static_cast<int>(mesh_.elements.size());
    tile_.layerCount = static_cast<int>(footprint_->cells.size());
    tile_.elementCount = mesh_.rule.through * tile_.layerCount;
    for (int layer = 0; layer < mesh_.rule.through; ++layer) {
      for (const std::array<int, 4>& cell : footprint_->cells) {
        mesh_.elements.push_back(elementOn(cell, layer * step()));
      }
    }
  }

  Element elementOn(const std::array<int, 4>& cell, int level) const {
    Element element;
    element.sides = cell[3] < 0 ? 3 : 4;
    int count = 0;
    const auto appendCorners = [&](int at) {
      for (int k = 0; k < element.sides; ++k) element.nodes[count++] = pointNode_[at][cell[k]];
    };
    const auto appendMiddles = [&](int at) {
      for (int k = 0; k < element.sides; ++k) {
        element.nodes[count++] = edgeNode_[at][edgeNumber(cell[k], cell[(k + 1) % element.sides])];
      }
    };
    appendCorners(level);
    appendCorners(level + step());
    if (!mesh_.rule.quadratic) return element;
    appendMiddles(level);
    appendMiddles(level + 2);
    appendCorners(level + 1);
    return element;
  }

  std::size_t edgeNumber(int a, int b) const {
    const std::array<int, 2> edge = {std::min(a, b), std::max(a, b)};
    return std::ranges::lower_bound(footprint_->edges, edge) - footprint_->edges.begin();
  }

  ElementMesh& mesh_;
  int levels_;
  const Footprint* footprint_ = nullptr;
  TileElements tile_;
  std::vector<std::vector<int>> pointNode_;  ///< by level and point
  std::vector<std::vector<int>> edgeNode_;   ///< by level and edge
};

/// Six times the volume of the tetrahedron that a corner and its three neighbours span.
double cornerVolume(const ElementMesh& mesh, const Element& element, int corner) {
  const int sides = element.sides;
  const int base = corner < sides ? 0 : sides;
  const auto at = [&](int k) { return mesh.nodes[element.nodes[k]]; };
  const Vector3 origin = at(corner);
  const Vector3 next = at(base + (corner - base + 1) % sides) - origin;
  const Vector3 previous = at(base + (corner - base + sides - 1) % sides) - origin;
  const Vector3 up = base == 0 ? at(corner + sides) - origin : origin - at(corner - sides);
  return next.cross(previous).dot(up);
}

double longestEdge(const ElementMesh& mesh, const Element& element) {
  double longest = 0;
  for (int k = 0; k < element.sides; ++k) {
    const Vector3& a = mesh.nodes[element.nodes[k]];
    const Vector3& b = mesh.nodes[element.nodes[(k + 1) % element.sides]];
    longest = std::max(longest, (b - a).norm());
  }
  return longest;
}

void checkAspect(const ElementMesh& mesh, const Element& element, int tile, double thickness) {
  const double length = longestEdge(mesh, element);
  const double height = thickness / mesh.rule.through;
  if (length <= kMostAspect * height) return;
  throw InputError(fmt::format(
      "error: tile {} is too thin for its elements, {:.3g} m long and {:.3g} m high; at most {} "
      "times as long as high are allowed: use more elements per edge, fewer through the thickness, "
      "or thicker bricks",
      tile, length, height, kMostAspect));
}

void checkCorners(const ElementMesh& mesh, const Element& element, int tile) {
  for (int k = 0; k < 2 * element.sides; ++k) {
    if (cornerVolume(mesh, element, k) > 0) continue;
    throw InputError(
        fmt::format("error: tile {} cannot be divided into elements: they would fold "
                    "over; give it corners that its centre of area sees, joints that "
                    "close, or split it into convex tiles",
                    tile));
  }
}

void checkElements(const ElementMesh& mesh, const std::vector<Brick>& bricks) {
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    const TileElements& tile = mesh.tiles[t];
    for (int k = 0; k < tile.elementCount; ++k) {
      const Element& element = mesh.elements[tile.firstElement + k];
      checkAspect(mesh, element, static_cast<int>(t), bricks[t].thickness);
      checkCorners(mesh, element, static_cast<int>(t));
    }
  }
}

}  // namespace

int nodeCount(int sides, bool quadratic) {
  return quadratic ? 5 * sides : 2 * sides;
}

ElementMesh makeElementMesh(const std::vector<Brick>& bricks, const std::vector<Joint>& joints,
                            const Poses& poses, const ElementRule& rule) {
  requireValidRule(rule);
  requireReasonableCount(bricks, rule);
  ElementMesh mesh;
  mesh.rule = rule;
  Footprints footprints(rule.perEdge);
  MeshBuilder builder(mesh);
  for (std::size_t t = 0; t < bricks.size(); ++t) {
    builder.append(bricks[t], poses[t], footprints.of(bricks[t]));
  }
  mesh.joints = jointNodes(joints, mesh.tiles);
  mesh.clusters = findClusters(mesh);
  for (const NodeCluster& cluster : mesh.clusters) {
    mesh.largestGap = std::max(mesh.largestGap, cluster.gap);
  }
  if (rule.joints == JointStyle::Shared) mergeClusters(mesh);
  if (rule.joints == JointStyle::Patch) spreadPatches(mesh);
  checkElements(mesh, bricks);
  return mesh;
}

}  // namespace kirireel
