// Builds a mesh of hinged tiles:
//
// - 1. Select the number of elements along edges (defaultPerEdge, divisionOf).
// - 2. Divide each kind of tile into quadrilaterals once (element_mesh.h), in weights of its
//   vertices. Positions follow from the brick and its pose.
// - 3. Build prisms on these, layer by layer (element_mesh.h).
// - 4. Find corners with common joints. Merge them, leave them for equations, or give them patches
//   (element_mesh.h).
// - 5. Check solids: no prism may be folded over or 500 times as long as high.
//
// Tiles are meshed one by one and do not match along their edges, because only corners are joined.
// A general mesher would merge edges that only touch. The cells are quadrilaterals, not triangles,
// since triangular prisms (C3D15, C3D6) bend far more stiffly with the same number of nodes.
//
// Check of a corner: with its position a, the next and previous corner n and p of its face and the
// corner u above (or below, with the opposite sign),
//
//     V = (n - a) x (p - a) . (u - a) > 0,
//
// six times the volume of the corner's tetrahedron, m^3. A hexahedron whose eight corners have
// V > 0 is not inverted there. V is the Jacobian determinant at the corners of the linear element.
// Midside nodes lie halfway, so quadratic elements have the same.
#include "render/fea/element_mesh.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>

#include <fmt/format.h>

#include "render/fea/sheet_ends.h"
#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"

namespace kirireel::fea {
namespace {

/// A single quadratic element cannot represent a varying bending moment.
constexpr int kMinDefaultPerEdge = 2;
/// Also the range in the command line's help. Limit for an edge and for the thickness.
constexpr int kMaxElements = 64;
/// A larger mesh would fill memory, and no program reads it.
constexpr std::size_t kMaxElementsInTotal = 4'000'000;

/// Limit of the default: at most half a million nodes, which a direct solver can still factorise on
/// a workstation.
constexpr std::size_t kDefaultElementsInAll = 60'000;
/// Elements with a larger ratio of length to thickness are useless in any program.
constexpr double kMaxAspect = 500;

/// The lengths of a tile's edges, metres.
std::vector<double> edgeLengths(const brick::Brick& brick) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
    lengths.push_back((brick.bottom[(k + 1) % brick.bottom.size()] - brick.bottom[k]).norm());
  }
  return lengths;
}

/// A quarter of the smallest distance between two corners of a tile, which keeps patches apart. At
/// half this distance patches would touch.
double defaultPatchRadius(const std::vector<brick::Brick>& bricks) {
  double least = std::numeric_limits<double>::infinity();
  for (const brick::Brick& brick : bricks) least = std::min(least, smallestDistance(brick.bottom));
  return 0.25 * least;
}

/// Number of elements along an edge for which its first node is in the patch at its end. Nodes are
/// l / (m n) apart on an edge of length l, with n elements and m = 2 intervals per quadratic
/// element, else 1. The first is within the radius r if n >= l / (m r). The 1e-9 prevents rounding
/// up an exact quotient.
int perEdgeForPatch(double length, const ElementRule& rule) {
  const int nodesAnElement = rule.quadratic ? 2 : 1;
  return static_cast<int>(std::ceil(length / (nodesAnElement * rule.patchRadius) - 1e-9));
}

/// Number of elements along an edge; `defaultCount` if the rule has none. A length in metres has
/// priority over the count per edge.
int elementsAlong(double length, const ElementRule& rule, int defaultCount) {
  if (rule.size > 0) return std::max(1, static_cast<int>(std::ceil(length / rule.size - 1e-9)));
  if (rule.perEdge > 0) return rule.perEdge;
  return rule.joints == JointStyle::Patch ? std::max(defaultCount, perEdgeForPatch(length, rule))
                                          : defaultCount;
}

/// Division of a tile. Tiles with the same division share one footprint. Used as a map key.
struct Division {
  int sides = 0;
  int first = 0;   ///< cells along edge 0 of a grid; half the cells along an edge of a fan
  int second = 0;  ///< cells along edge 1 of a grid; 0 for a fan
  std::vector<std::array<int, 3>> triangles = {};  ///< of a concave tile, in place of a fan
  bool isEven = false;  ///< equidistant nodes along edges, also in shells

  auto operator<=>(const Division&) const = default;

  std::size_t cells() const {
    // Three quadrilaterals per triangle, each of first x first cells.
    if (!triangles.empty()) return 3 * triangles.size() * first * first;
    // A triangle: 3 grids of first^2 cells. A fan: this number for each side.
    const auto square = static_cast<std::size_t>(first) * (second > 0 ? second : 3 * first);
    return second > 0 || sides == 3 ? square : sides * square;
  }
};

/// Concave tiles use their triangulation, four-sided tiles a grid, all others a fan. Opposite edges
/// of a grid have the count of the longer edge. A fan has one even count, by the longest edge.
Division divisionOf(const brick::Brick& brick, const ElementRule& rule, int defaultCount) {
  const std::vector<double> lengths = edgeLengths(brick);
  const int sides = static_cast<int>(lengths.size());
  const int half = (elementsAlong(std::ranges::max(lengths), rule, defaultCount) + 1) / 2;
  // `parts` are the convex pieces of a concave brick. A fan around its centre could fold over.
  if (!brick.parts.empty()) return {sides, half, 0, model::trianglesOf(brick.bottom, brick.normal)};
  if (takesGrid(brick.bottom, brick.normal)) {
    return {sides, elementsAlong(std::max(lengths[0], lengths[2]), rule, defaultCount),
            elementsAlong(std::max(lengths[1], lengths[3]), rule, defaultCount)};
  }
  return {sides, half, 0};
}

std::vector<Division> divisionsOf(const std::vector<brick::Brick>& bricks, const ElementRule& rule,
                                  int defaultCount) {
  std::vector<Division> divisions;
  for (const brick::Brick& brick : bricks)
    divisions.push_back(divisionOf(brick, rule, defaultCount));
  return divisions;
}

/// Gives all edges of tiles with fixed joints the same even number of elements, so their nodes
/// match.
void matchDivisions(std::vector<Division>& divisions, const std::vector<model::Joint>& joints) {
  DisjointSets sets(divisions.size());
  std::vector<bool> isJoined(divisions.size());
  for (const model::Joint& joint : joints) {
    if (joint.kind != model::JointKind::Fixed) continue;
    sets.unite(joint.a.tile, joint.b.tile);
    isJoined[joint.a.tile] = isJoined[joint.b.tile] = true;
  }
  std::map<int, int> halves;
  for (int t = 0; t < static_cast<int>(divisions.size()); ++t) {
    const Division& own = divisions[t];
    const int half = own.second > 0 ? (std::max(own.first, own.second) + 1) / 2 : own.first;
    int& most = halves[sets.lowestOf(t)];
    most = std::max(most, half);
  }
  for (int t = 0; t < static_cast<int>(divisions.size()); ++t) {
    if (!isJoined[t]) continue;
    Division& own = divisions[t];
    const int half = halves[sets.lowestOf(t)];
    own.isEven = true;
    own.first = own.second > 0 ? 2 * half : half;
    if (own.second > 0) own.second = 2 * half;
  }
}

/// Counts without making elements, to choose the resolution.
std::size_t elementsIn(const std::vector<Division>& divisions, const ElementRule& rule) {
  std::size_t count = 0;
  for (const Division& division : divisions) count += rule.through * division.cells();
  return count;
}

void requireReasonableCount(const std::vector<Division>& divisions, const ElementRule& rule) {
  const std::size_t count = elementsIn(divisions, rule);
  if (count <= kMaxElementsInTotal) return;
  throw InputError(
      fmt::format("error: {} elements would be made, at most {} are allowed; use fewer "
                  "per edge or through the thickness",
                  count, kMaxElementsInTotal));
}

Footprint footprintOf(const Division& division, const ElementRule& rule) {
  if (!division.triangles.empty()) {
    return triangleFootprint(division.triangles, division.sides, division.first);
  }
  const bool isGraded = rule.family == ElementFamily::Shell && !division.isEven;
  return division.second > 0 ? gridFootprint(division.first, division.second, isGraded)
                             : fanFootprint(division.sides, division.first);
}

/// The points of a brick's footprint at each level, in world axes. A single level lies at this
/// fraction of the thickness.
std::vector<std::vector<Vector3>> levelsOf(const brick::Brick& brick, const Pose& pose,
                                           const Footprint& footprint, int count, double single) {
  std::vector<Vector3> bases = brick.bottom;
  // The origin of brick axes is the centre of mass, the bottom is half a thickness below it.
  bases.emplace_back(-0.5 * brick.thickness * brick.normal);
  std::vector<std::vector<Vector3>> levels(count);
  for (int level = 0; level < count; ++level) {
    const double share = count > 1 ? static_cast<double>(level) / (count - 1) : single;
    const Vector3 up = share * brick.thickness * brick.normal;
    for (const FootprintPoint& point : footprint.points) {
      levels[level].push_back(pose.apply(point.at(bases) + up));
    }
  }
  return levels;
}

/// `level` is the fraction of the thickness at which shells lie; not used for solids.
void appendBrick(ElementMesh& mesh, const brick::Brick& brick, const Pose& pose,
                 const Footprint& footprint, double level) {
  const int count = PrismLayers::levelCount(mesh.rule);
  PrismLayers layers(mesh, footprint.cells, levelsOf(brick, pose, footprint, count, level));
  TileElements tile = layers.append(0, footprint.cells.size(), footprint.sides);
  tile.isRow = footprint.isRow;
  tile.level = level;
  for (const int corner : footprint.corners) tile.edges.push_back(layers.nodesAt(corner));
  mesh.tiles.push_back(std::move(tile));
}

/// Six times the volume of the tetrahedron of a corner and its three neighbours. `corner` is 0 to
/// 7; base is the first corner of its face, 0 at the bottom or 4 at the top.
double cornerVolume(const ElementMesh& mesh, const Element& element, int corner) {
  const int base = corner < 4 ? 0 : 4;
  const auto at = [&](int k) { return mesh.nodes[element.nodes[k]]; };
  const Vector3 origin = at(corner);
  const Vector3 next = at(base + (corner - base + 1) % 4) - origin;
  const Vector3 previous = at(base + (corner - base + 3) % 4) - origin;
  const Vector3 up = base == 0 ? at(corner + 4) - origin : origin - at(corner - 4);
  return next.cross(previous).dot(up);
}

/// The longest edge of the bottom face. The top is a copy at the distance of the thickness.
double longestEdge(const ElementMesh& mesh, const Element& element) {
  double longest = 0;
  for (int k = 0; k < 4; ++k) {
    const Vector3& a = mesh.nodes[element.nodes[k]];
    const Vector3& b = mesh.nodes[element.nodes[(k + 1) % 4]];
    longest = std::max(longest, (b - a).norm());
  }
  return longest;
}

void checkAspect(const ElementMesh& mesh, const Element& element, int tile, double thickness) {
  const double length = longestEdge(mesh, element);
  const double height = thickness / mesh.rule.through;
  if (length <= kMaxAspect * height) return;
  throw InputError(fmt::format(
      "error: tile {} is too thin for its elements, {} long and {} high; at most {} "
      "times as long as high are allowed: use more elements per edge, fewer through the thickness, "
      "or thicker bricks",
      tile, lengthText(length, mesh.rule.unit), lengthText(height, mesh.rule.unit), kMaxAspect));
}

/// Merged corners are at their mean, so a joint with a large gap can also fold an element.
void checkCorners(const ElementMesh& mesh, const Element& element, int tile) {
  for (int k = 0; k < 8; ++k) {
    if (cornerVolume(mesh, element, k) > 0) continue;
    throw InputError(fmt::format(
        "error: tile {} cannot be divided into elements: they would fold over; use corners that "
        "are visible from its centre of area, joints that close, or split it into convex tiles",
        tile));
  }
}

void checkElements(const ElementMesh& mesh, const std::vector<brick::Brick>& bricks) {
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    const TileElements& tile = mesh.tiles[t];
    const int number = static_cast<int>(t) + mesh.rule.countsFrom;
    for (int k = 0; k < tile.elementCount; ++k) {
      const Element& element = mesh.elements[tile.firstElement + k];
      checkAspect(mesh, element, number, bricks[t].thickness);
      checkCorners(mesh, element, number);
    }
  }
}

/// Position of each tile's shells in the thickness, at its joints: 0 bottom, 0.5 middle, 1 top; 0.5
/// also for tiles without joints. An offset shell has its nodes at the hinge, which keeps the lever
/// of half a thickness.
std::vector<double> shellLevels(std::size_t tiles, const std::vector<model::Joint>& joints,
                                const ElementRule& rule) {
  std::vector<std::optional<model::JointFace>> faces(tiles);
  for (const model::Joint& joint : joints) {
    for (const int tile : {joint.a.tile, joint.b.tile}) {
      if (faces[tile].value_or(joint.face) != joint.face) {
        throw InputError(
            fmt::format("error: tile {} has joints on different faces, but a shell has nodes on "
                        "one face; remove --shells",
                        tile + rule.countsFrom));
      }
      faces[tile] = joint.face;
    }
  }
  std::vector<double> levels;
  for (const auto& face : faces) {
    const model::JointFace own = face.value_or(model::JointFace::Both);
    levels.push_back(own == model::JointFace::Both ? 0.5 : own == model::JointFace::Top ? 1 : 0);
  }
  return levels;
}

/// Divides each brick separately; the rule's patch radius is set.
void divideBricks(const std::vector<brick::Brick>& bricks, const std::vector<model::Joint>& joints,
                  const Poses& poses, ElementMesh& mesh) {
  std::vector<double> levels(bricks.size(), 0.5);
  if (mesh.rule.family == ElementFamily::Shell) {
    levels = shellLevels(bricks.size(), joints, mesh.rule);
  }
  std::vector<Division> divisions =
      divisionsOf(bricks, mesh.rule, defaultPerEdge(bricks, mesh.rule));
  matchDivisions(divisions, joints);
  requireReasonableCount(divisions, mesh.rule);
  // Sheets have thousands of tiles and few divisions, so each footprint is made once.
  std::map<Division, Footprint> footprints;
  for (std::size_t t = 0; t < bricks.size(); ++t) {
    const auto [place, isNew] = footprints.try_emplace(divisions[t]);
    if (isNew) place->second = footprintOf(divisions[t], mesh.rule);
    appendBrick(mesh, bricks[t], poses[t], place->second, levels[t]);
  }
}

/// The ends of hinged tiles, before hinged corners are merged: bricks have their own.
SheetEnds endsOf(const ElementMesh& mesh) {
  std::vector<std::vector<Vector3>> polygons;
  double length = 0;
  std::size_t edges = 0;
  for (const TileElements& tile : mesh.tiles) {
    std::vector<Vector3>& polygon = polygons.emplace_back();
    for (const std::vector<int>& edge : tile.edges) polygon.push_back(mesh.nodes[edge.front()]);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      length += (polygon[(k + 1) % polygon.size()] - polygon[k]).norm();
    }
    edges += polygon.size();
  }
  std::vector<PolygonLink> links;
  for (const JointNodes& joint : mesh.joints) {
    links.push_back({joint.tileA, joint.tileB, mesh.nodes[joint.a.front()]});
  }
  const EndEdges found = findEndEdges(polygons, links, length / static_cast<double>(edges));
  SheetEnds ends{found.axes, found.isFlat, found.longest, {}};
  for (std::size_t k = 0; k < ends.faces.size(); ++k) {
    for (const PolygonEdge& edge : found.edges[k]) {
      std::ranges::copy_if(mesh.tiles[edge.polygon].sides, std::back_inserter(ends.faces[k]),
                           [&](const ElementFace& face) { return face.tileEdge == edge.edge; });
    }
  }
  return ends;
}

/// Throws InputError for elements that hinged tiles cannot have.
void requireBuildable(const ElementRule& rule) {
  if (rule.family == ElementFamily::Plane || rule.joints == JointStyle::Neck) {
    throw InputError(
        "error: plane elements need one sheet with necks; add --joints neck and --neck-width, or "
        "remove --plane-stress");
  }
  if (rule.family == ElementFamily::Shell && rule.joints != JointStyle::Shared) {
    throw InputError(
        "error: shells of hinged tiles share nodes or have equations depending on the joint; "
        "remove --joints, or choose neck");
  }
}

/// The smallest number of elements per edge whose nodes fill every patch. A message suggests it if
/// a mesh is too coarse.
int minPerEdge(const std::vector<brick::Brick>& bricks, const ElementRule& rule) {
  int least = 1;
  for (const brick::Brick& brick : bricks) {
    least = std::max(least, perEdgeForPatch(std::ranges::max(edgeLengths(brick)), rule));
  }
  return least;
}

}  // namespace

ElementRule coarsest(ElementRule rule) {
  rule.perEdge = 1;
  rule.through = 1;
  rule.quadratic = false;
  rule.size = 0;
  return rule;
}

std::array<FacingEdges, 2> edgesBesideJoint(const model::Corner& a, int sidesA,
                                            const model::Corner& b, int sidesB) {
  // Anticlockwise around the corner there are A's outgoing edge, A, its incoming edge, a gap, B's
  // outgoing edge, B, its incoming edge, a gap. The incoming edge of corner c is c - 1.
  const auto into = [](const model::Corner& corner, int sides) {
    return TileEdge(corner.tile, (corner.vertex + sides - 1) % sides);
  };
  const auto outOf = [](const model::Corner& corner) {
    return TileEdge(corner.tile, corner.vertex);
  };
  return {std::minmax(into(a, sidesA), outOf(b)), std::minmax(into(b, sidesB), outOf(a))};
}

int nodeCount(const ElementRule& rule) {
  if (rule.family != ElementFamily::Solid) return rule.quadratic ? 8 : 4;
  return rule.quadratic ? 20 : 8;
}

void requireValidRule(const ElementRule& rule) {
  const auto require = [](int found, int least, const char* what) {
    if (found >= least && found <= kMaxElements) return;
    throw InputError(fmt::format("error: {} elements {} are not possible; choose 1 to {}", found,
                                 what, kMaxElements));
  };
  require(rule.perEdge, 0, "per edge");
  require(rule.through, 1, "through the thickness");
  if (rule.perEdge > 0 && rule.size > 0) {
    throw InputError(
        fmt::format("error: {} elements per edge and elements of {} contradict each other; give "
                    "only one of them",
                    rule.perEdge, lengthText(rule.size, rule.unit, 6)));
  }
  if (!(rule.size >= 0) || !(rule.patchRadius >= 0)) {
    throw InputError(fmt::format(
        "error: elements of {} and patches of radius {} are not "
        "possible; give positive lengths",
        lengthText(rule.size, rule.unit, 6), lengthText(rule.patchRadius, rule.unit, 6)));
  }
}

int defaultPerEdge(const std::vector<brick::Brick>& bricks, const ElementRule& rule) {
  int defaultCount = kDefaultPerEdge;
  // The count falls with the square of `defaultCount`, so a few rounds are sufficient.
  while (defaultCount > kMinDefaultPerEdge &&
         elementsIn(divisionsOf(bricks, rule, defaultCount), rule) > kDefaultElementsInAll) {
    --defaultCount;
  }
  return defaultCount;
}

bool isCoarsened(const std::vector<brick::Brick>& bricks, const ElementRule& rule) {
  return rule.perEdge == 0 && rule.size == 0 && defaultPerEdge(bricks, rule) < kDefaultPerEdge;
}

ElementMesh makeElementMesh(const std::vector<brick::Brick>& bricks,
                            const std::vector<model::Joint>& joints, const Poses& poses,
                            const ElementRule& rule) {
  requireValidRule(rule);
  requireBuildable(rule);
  ElementMesh mesh;
  mesh.rule = rule;
  if (rule.patchRadius == 0) mesh.rule.patchRadius = defaultPatchRadius(bricks);
  divideBricks(bricks, joints, poses, mesh);
  joinTiles(mesh, joints);
  mesh.joints = jointNodes(joints, mesh.tiles, mesh.rule.countsFrom);
  mesh.ends = endsOf(mesh);
  mesh.clusters = findClusters(mesh);
  for (const NodeCluster& cluster : mesh.clusters) {
    mesh.largestGap = std::max(mesh.largestGap, cluster.gap);
  }
  // Measure gaps before merging, since the mean closes them.
  if (rule.joints == JointStyle::Shared) mergeClusters(mesh);
  if (rule.joints == JointStyle::Patch) spreadPatches(mesh, minPerEdge(bricks, mesh.rule));
  if (rule.family == ElementFamily::Solid) checkElements(mesh, bricks);
  return mesh;
}

std::vector<int> faceNodes(const ElementMesh& mesh, const ElementFace& face) {
  const std::array<int, 20>& nodes = mesh.elements[face.element].nodes;
  const int from = face.side, to = (face.side + 1) % 4;
  if (mesh.rule.family != ElementFamily::Solid) {
    if (!mesh.rule.quadratic) return {nodes[from], nodes[to]};
    return {nodes[from], nodes[to], nodes[4 + from]};
  }
  if (!mesh.rule.quadratic) return {nodes[from], nodes[to], nodes[to + 4], nodes[from + 4]};
  return {nodes[from],     nodes[to],      nodes[to + 4],    nodes[from + 4],
          nodes[8 + from], nodes[16 + to], nodes[12 + from], nodes[16 + from]};
}

double smallestElementAngle(const ElementMesh& mesh) {
  double least = std::numbers::pi;
  for (const Element& element : mesh.elements) {
    for (int k = 0; k < 4; ++k) {
      const Vector3& at = mesh.nodes[element.nodes[k]];
      const Vector3 next = mesh.nodes[element.nodes[(k + 1) % 4]] - at;
      const Vector3 previous = mesh.nodes[element.nodes[(k + 3) % 4]] - at;
      least = std::min(least, std::atan2(next.cross(previous).norm(), next.dot(previous)));
    }
  }
  return least / kDegree;
}

bool hasEquations(const ElementMesh& mesh) {
  return mesh.rule.joints != JointStyle::Patch && !mesh.clusters.empty();
}

std::vector<bool> jointNodesOf(const ElementMesh& mesh) {
  std::vector<bool> isJoint(mesh.nodes.size());
  std::vector<bool> isUsed(mesh.nodes.size());
  for (const auto* parts : {&mesh.tiles, &mesh.necks}) {
    for (const TileElements& part : *parts) {
      for (const int node : part.nodes) {
        if (isUsed[node]) isJoint[node] = true;
        isUsed[node] = true;
      }
    }
  }
  for (const JointNodes& joint : mesh.joints) {
    for (const int node : joint.a) isJoint[node] = true;
    for (const int node : joint.b) isJoint[node] = true;
  }
  return isJoint;
}

std::vector<bool> followers(const ElementMesh& mesh) {
  std::vector<bool> follows(mesh.nodes.size());
  for (const NodeCluster& cluster : mesh.clusters) {
    if (hasEquations(mesh)) {
      for (std::size_t k = 1; k < cluster.nodes.size(); ++k) follows[cluster.nodes[k]] = true;
    }
    for (const std::vector<int>& patch : cluster.patches) {
      for (const int node : patch) follows[node] = true;
    }
  }
  for (const PeriodicTie& tie : mesh.ties) follows[tie.node] = true;
  return follows;
}

int referenceNode(const ElementMesh& mesh, std::size_t cluster) {
  return static_cast<int>(mesh.nodes.size() + cluster);
}

Vector3 referencePosition(const ElementMesh& mesh, std::size_t cluster) {
  Vector3 sum = Vector3::Zero();
  for (const int node : mesh.clusters[cluster].nodes) sum += mesh.nodes[node];
  return sum / static_cast<double>(mesh.clusters[cluster].nodes.size());
}

// ------------------------------------------------------------------------------------------------
// Levels are numbered from the bottom. A linear mesh has one level per layer and one more: 0, 1, 2.
// A quadratic mesh has two per layer. Even levels have corners and the middles of edges. Odd
// levels, halfway up, have only the middles of upright edges:
//
//     level 2   o---x---o     o corner, x middle of an edge
//               |       |
//     level 1   x       x     nothing in the middle of a face or of the element: 20 nodes
//               |       |
//     level 0   o---x---o
//
// Nodes are made once per point and level, so adjacent elements share them without a search by
// position.

namespace {

std::vector<int> sortedOnce(std::vector<int> nodes) {
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

}  // namespace

int PrismLayers::levelCount(const ElementRule& rule) {
  if (rule.family != ElementFamily::Solid) return 1;
  return rule.through * (rule.quadratic ? 2 : 1) + 1;
}

PrismLayers::PrismLayers(ElementMesh& mesh, std::vector<std::array<int, 4>> cells,
                         const std::vector<std::vector<Vector3>>& levels)
    : mesh_(mesh), cells_(std::move(cells)), edges_(edgesOf(cells_)) {
  const auto addNode = [this](const Vector3& position) {
    mesh_.nodes.push_back(position);
    return static_cast<int>(mesh_.nodes.size()) - 1;
  };
  for (std::size_t level = 0; level < levels.size(); ++level) {
    std::vector<int>& atPoints = pointNode_.emplace_back();
    std::vector<int>& atEdges = edgeNode_.emplace_back();
    for (const Vector3& point : levels[level]) atPoints.push_back(addNode(point));
    if (!mesh_.rule.quadratic || level % 2 == 1) continue;
    // In the middle of a straight edge, even if a merged corner moves later.
    for (const auto& [a, b] : edges_) {
      atEdges.push_back(addNode(0.5 * (levels[level][a] + levels[level][b])));
    }
  }
}

TileElements PrismLayers::append(std::size_t firstCell, std::size_t cellCount,
                                 const std::vector<FootprintSide>& sides) {
  const bool isSolid = mesh_.rule.family == ElementFamily::Solid;
  const int layers = isSolid ? mesh_.rule.through : 1;
  TileElements tile;
  tile.firstElement = static_cast<int>(mesh_.elements.size());
  tile.layerCount = static_cast<int>(cellCount);
  tile.elementCount = layers * tile.layerCount;
  const int last = static_cast<int>(pointNode_.size()) - 1;
  // Elements of a layer are consecutive, as the surfaces of top and bottom require.
  for (int layer = 0; layer < layers; ++layer) {
    for (std::size_t k = firstCell; k < firstCell + cellCount; ++k) {
      mesh_.elements.push_back(elementOn(cells_[k], layer * step()));
      const Element& element = mesh_.elements.back();
      tile.nodes.insert(tile.nodes.end(), element.nodes.begin(),
                        element.nodes.begin() + nodeCount(mesh_.rule));
    }
  }
  const auto onFace = [&](int level) {
    std::vector<int> nodes;
    for (std::size_t k = firstCell; k < firstCell + cellCount; ++k) {
      for (int c = 0; c < 4; ++c) {
        nodes.push_back(pointNode_[level][cells_[k][c]]);
        if (!mesh_.rule.quadratic) continue;
        nodes.push_back(edgeNode_[level][edgeNumber(cells_[k][c], cells_[k][(c + 1) % 4])]);
      }
    }
    return sortedOnce(std::move(nodes));
  };
  tile.nodes = sortedOnce(std::move(tile.nodes));
  tile.bottom = onFace(0);
  tile.top = onFace(last);
  for (const FootprintSide& side : sides) {
    for (int layer = 0; layer < layers; ++layer) {
      const int element = tile.firstElement + layer * tile.layerCount + side.cell;
      tile.sides.push_back({element, side.side, side.tileEdge});
    }
  }
  return tile;
}

std::vector<int> PrismLayers::nodesAt(int point) const {
  std::vector<int> nodes;
  for (const std::vector<int>& level : pointNode_) nodes.push_back(level[point]);
  return nodes;
}

std::vector<int> PrismLayers::nodesBetween(int a, int b) const {
  std::vector<int> nodes;
  for (const std::vector<int>& level : edgeNode_) {
    if (!level.empty()) nodes.push_back(level[edgeNumber(a, b)]);
  }
  return nodes;
}

/// `edges_` is sorted and must contain the edge.
std::size_t PrismLayers::edgeNumber(int a, int b) const {
  const std::array<int, 2> edge = {std::min(a, b), std::max(a, b)};
  return std::ranges::lower_bound(edges_, edge) - edges_.begin();
}

/// Node order of Abaqus, see Element.
Element PrismLayers::elementOn(const std::array<int, 4>& cell, int level) const {
  Element element;
  int count = 0;
  const auto appendCorners = [&](int at) {
    for (const int point : cell) element.nodes[count++] = pointNode_[at][point];
  };
  const auto appendMiddles = [&](int at) {
    for (int k = 0; k < 4; ++k) {
      element.nodes[count++] = edgeNode_[at][edgeNumber(cell[k], cell[(k + 1) % 4])];
    }
  };
  const bool isSolid = mesh_.rule.family == ElementFamily::Solid;
  appendCorners(level);
  if (isSolid) appendCorners(level + step());
  if (!mesh_.rule.quadratic) return element;
  appendMiddles(level);
  if (!isSolid) return element;
  appendMiddles(level + 2);
  appendCorners(level + 1);
  return element;
}

// ------------------------------------------------------------------------------------------------
// Divides a polygon with n vertices into quadrilaterals, in weights of its vertices and its centre.
// Positions are not needed here: one footprint serves all tiles with n vertices and the same
// counts, at the bottom and at the top.
//
// A grid has bilinear points (u, v in [0, 1] along edges 0 and 1):
//
//     p = (1-u)(1-v) v0 + u (1-v) v1 + u v v2 + (1-u) v v3.
//
// Graded grids have u = (1 - cos(pi k / n)) / 2: shells bend most near clamped and hinged edges,
// where these Chebyshev points are dense.
//
// Any other polygon is a fan of triangles around its centre. Each triangle is cut into three
// quadrilaterals at its centroid and the middles of its sides. They match at every side of every
// triangle, because both halves of a side have equal cells. A paving mesher would give better
// shapes but a different mesh for each tile. This one is exact, symmetric, and the same for equal
// tiles.
//
// Points are identified by integers (weights of 6 m^2 with m cells along half an edge), never by
// distance: equal points have equal keys for any tile size.

namespace {

/// Corners of quadrilaterals with a smaller sine of their angle count as straight, about 3 degrees.
/// Beyond this limit a quadrilateral has nearly lost a corner, and its map is singular there.
constexpr double kStraightSine = 0.05;

/// Grid points that quadrilaterals share, identified by their integer weights of the bases.
class SharedPoints {
 public:
  /// The weights of each point add up to `whole`.
  SharedPoints(Footprint& footprint, int whole) : footprint_(footprint), whole_(whole) {}

  /// The point with these shares of three bases.
  int find(const std::array<int, 3>& bases, const std::array<int, 3>& shares) {
    // Omits a base with weight 0: a point on a side then has the same key in both triangles.
    std::vector<std::pair<int, int>> key;
    for (int k = 0; k < 3; ++k) {
      if (shares[k] > 0) key.emplace_back(bases[k], shares[k]);
    }
    std::ranges::sort(key);
    const auto [place, isNew] = numbers_.try_emplace(key, footprint_.points.size());
    if (isNew) footprint_.points.push_back(pointOf(key));
    return place->second;
  }

 private:
  FootprintPoint pointOf(const std::vector<std::pair<int, int>>& key) const {
    FootprintPoint point;
    for (std::size_t k = 0; k < key.size(); ++k) {
      point.bases[k] = key[k].first;
      point.weights[k] = static_cast<double>(key[k].second) / whole_;
    }
    return point;
  }

  Footprint& footprint_;
  int whole_;
  std::map<std::vector<std::pair<int, int>>, int> numbers_;
};

/// Cuts a triangle into three quadrilaterals of n x n cells each. The one at corner c extends to
/// the middles of the two sides and to the centre. Its point (i, j) is at i / n along the side to
/// the next corner and j / n along the other. With weights of 6 n^2 all points are integers: a
/// corner has 6, a middle 3 + 3, the centre 2 + 2 + 2. `onEdge`: the tile's edge on the side from
/// corner c to the next, or -1.
void appendTriangle(const std::array<int, 3>& bases, const std::array<int, 3>& onEdge, int n,
                    SharedPoints& points, Footprint& footprint) {
  for (int c = 0; c < 3; ++c) {
    const int next = (c + 1) % 3;
    const int previous = (c + 2) % 3;
    const auto point = [&](int i, int j) {
      std::array<int, 3> shares{};
      shares[c] = 6 * (n - i) * (n - j) + 3 * i * (n - j) + 3 * (n - i) * j + 2 * i * j;
      shares[next] = 3 * i * (n - j) + 2 * i * j;
      shares[previous] = 3 * (n - i) * j + 2 * i * j;
      return points.find(bases, shares);
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const int cell = static_cast<int>(footprint.cells.size());
        footprint.cells.push_back(
            {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
        if (j == 0 && onEdge[c] >= 0) footprint.sides.push_back({cell, 0, onEdge[c]});
        if (i == 0 && onEdge[previous] >= 0) footprint.sides.push_back({cell, 3, onEdge[previous]});
      }
    }
  }
}

/// Sides are sorted by edge (stable), so along an edge they keep the order of cells.
void finish(Footprint& footprint) {
  footprint.edges = edgesOf(footprint.cells);
  std::ranges::stable_sort(footprint.sides, {}, &FootprintSide::tileEdge);
}

}  // namespace

Vector3 FootprintPoint::at(const std::vector<Vector3>& verticesAndCentre) const {
  // A corner has one weight of 1 and no other term, so it is bitwise equal to the vertex.
  Vector3 sum = weights[0] * verticesAndCentre[bases[0]];
  for (std::size_t k = 1; k < weights.size(); ++k) {
    if (weights[k] != 0) sum += weights[k] * verticesAndCentre[bases[k]];
  }
  return sum;
}

Footprint gridFootprint(int first, int second, bool isGraded) {
  Footprint footprint;
  const auto share = [isGraded](int k, int count) {
    const double even = static_cast<double>(k) / count;
    return isGraded ? 0.5 * (1 - std::cos(std::numbers::pi * even)) : even;
  };
  const auto point = [&](int i, int j) { return j * (first + 1) + i; };
  for (int j = 0; j <= second; ++j) {
    for (int i = 0; i <= first; ++i) {
      const double u = share(i, first);
      const double v = share(j, second);
      footprint.points.push_back(
          {{0, 1, 2, 3}, {(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v}});
      if (i == first || j == second) continue;
      const int cell = static_cast<int>(footprint.cells.size());
      footprint.cells.push_back(
          {point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
      if (j == 0) footprint.sides.push_back({cell, 0, 0});
      if (i + 1 == first) footprint.sides.push_back({cell, 1, 1});
      if (j + 1 == second) footprint.sides.push_back({cell, 2, 2});
      if (i == 0) footprint.sides.push_back({cell, 3, 3});
    }
  }
  footprint.corners = {point(0, 0), point(first, 0), point(first, second), point(0, second)};
  footprint.isRow = std::min(first, second) == 1;
  finish(footprint);
  return footprint;
}

Footprint fanFootprint(int sides, int halfPerEdge) {
  if (sides == 3) return triangleFootprint({{0, 1, 2}}, sides, halfPerEdge);
  std::vector<std::array<int, 3>> triangles;  // base `sides` is the centre
  for (int k = 0; k < sides; ++k) triangles.push_back({sides, k, (k + 1) % sides});
  return triangleFootprint(triangles, sides, halfPerEdge);
}

Footprint triangleFootprint(const std::vector<std::array<int, 3>>& triangles, int sides,
                            int halfPerEdge) {
  const int whole = 6 * halfPerEdge * halfPerEdge;
  Footprint footprint;
  SharedPoints points(footprint, whole);
  for (const std::array<int, 3>& triangle : triangles) {
    std::array<int, 3> onEdge{};
    for (int k = 0; k < 3; ++k) {
      // A side from a vertex to the next one is an edge, any other lies within the tile.
      const bool isEdge = triangle[k] < sides && triangle[(k + 1) % 3] == (triangle[k] + 1) % sides;
      onEdge[k] = isEdge ? triangle[k] : -1;
    }
    appendTriangle(triangle, onEdge, halfPerEdge, points, footprint);
  }
  for (int k = 0; k < sides; ++k) {
    footprint.corners.push_back(points.find({k, k, k}, {whole, 0, 0}));
  }
  finish(footprint);
  return footprint;
}

std::vector<int> heldNodes(const std::vector<int>& edge, model::JointFace face) {
  if (face == model::JointFace::Bottom) return {edge.front()};
  if (face == model::JointFace::Top) return {edge.back()};
  return edge;
}

std::vector<std::array<int, 2>> edgesOf(const std::vector<std::array<int, 4>>& cells) {
  std::vector<std::array<int, 2>> edges;
  for (const std::array<int, 4>& cell : cells) {
    for (int k = 0; k < 4; ++k) {
      const auto [low, high] = std::minmax(cell[k], cell[(k + 1) % 4]);
      edges.push_back({low, high});
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

bool takesGrid(const std::vector<Vector3>& vertices, const Vector3& normal) {
  if (vertices.size() != 4) return false;
  for (std::size_t k = 0; k < 4; ++k) {
    // The sine of the turn at vertex k; negative at a concave corner.
    const Vector3 before = (vertices[k] - vertices[(k + 3) % 4]).normalized();
    const Vector3 after = (vertices[(k + 1) % 4] - vertices[k]).normalized();
    if (before.cross(after).dot(normal) < kStraightSine) return false;
  }
  return true;
}

// ------------------------------------------------------------------------------------------------
// Corners are matched by joint, never by position. Corners of tiles that only touch stay separate.
// Corners with a gap from the simulation are still joined.
//
// 1. Each joint gives pairs of nodes (jointNodes): one on the bottom, one on the top, or all
// through the thickness. 2. Pairs with common nodes form clusters (union-find with path halving, R.
// E. Tarjan, J. van Leeuwen, Worst-case analysis of set union algorithms, J. ACM 31, 1984). Three
// tiles around one corner form a cluster of three. 3. A cluster is merged (shared nodes), left
// unchanged (equations) or given patches.
//
// A merged corner lies at the mean of its corners, m = sum x_i / n, which prefers no tile. The gap,
// the largest |x_i - x_j|, is reported.
//
// A patch has the nodes on the corner's face of the tile within the radius r of the corner. With
// three or more nodes it is a rigid body that can rotate. The effect of forces on a single node
// would diverge with smaller elements. With a patch of fixed radius it converges.

namespace {

void joinAll(const JointNodes& joint, JointStyle style, DisjointSets& sets) {
  for (std::size_t k = 0; k < joint.a.size(); ++k) {
    // Patches lie only on the two faces.
    const bool isInside = k > 0 && k + 1 < joint.a.size();
    if (style == JointStyle::Patch && isInside) continue;
    sets.unite(joint.a[k], joint.b[k]);
  }
}

/// The tile of each node, before merging.
std::vector<int> tilesOfNodes(const ElementMesh& mesh) {
  std::vector<int> owner(mesh.nodes.size());
  for (std::size_t t = 0; t < mesh.tiles.size(); ++t) {
    for (const int node : mesh.tiles[t].nodes) owner[node] = static_cast<int>(t);
  }
  return owner;
}

/// Compares all pairs, since clusters have few nodes.
double largestDistance(const std::vector<int>& nodes, const std::vector<Vector3>& positions) {
  double largest = 0;
  for (const int a : nodes) {
    for (const int b : nodes) largest = std::max(largest, (positions[a] - positions[b]).norm());
  }
  return largest;
}

/// Merging two corners of one tile would fold it.
void requireDifferentTiles(const NodeCluster& cluster, const std::vector<int>& owner,
                           const ElementRule& rule) {
  std::vector<int> tiles;
  for (const int node : cluster.nodes) tiles.push_back(owner[node]);
  std::ranges::sort(tiles);
  const auto twice = std::ranges::adjacent_find(tiles);
  if (twice == tiles.end()) return;
  throw InputError(
      fmt::format("error: the joints tie two corners of tile {} together, {} apart; a mesh "
                  "can join only different tiles: remove one of these joints",
                  *twice + rule.countsFrom, lengthText(cluster.gap, rule.unit)));
}

void renumber(std::vector<int>& nodes, const std::vector<int>& numbers) {
  for (int& node : nodes) node = numbers[node];
}

/// Only data that exist when clusters are merged: patches and springs come later.
void renumberAll(ElementMesh& mesh, const std::vector<int>& numbers) {
  for (Element& element : mesh.elements) {
    const int count = nodeCount(mesh.rule);
    for (int k = 0; k < count; ++k) element.nodes[k] = numbers[element.nodes[k]];
  }
  for (TileElements& tile : mesh.tiles) {
    for (std::vector<int>* nodes : {&tile.nodes, &tile.bottom, &tile.top}) {
      renumber(*nodes, numbers);
      std::ranges::sort(*nodes);
    }
    for (std::vector<int>& edge : tile.edges) renumber(edge, numbers);
  }
  for (JointNodes& joint : mesh.joints) {
    renumber(joint.a, numbers);
    renumber(joint.b, numbers);
  }
  for (NodeCluster& cluster : mesh.clusters) renumber(cluster.nodes, numbers);
}

/// Merges all nodes with the same lowest node. The lowest is already at its final position.
void mergeNodes(ElementMesh& mesh, const std::vector<int>& lowest) {
  // A dependent node follows its lowest node, whose new number is already known.
  std::vector<int> numbers(mesh.nodes.size());
  std::vector<Vector3> positions;
  for (std::size_t node = 0; node < lowest.size(); ++node) {
    const bool isLowest = lowest[node] == static_cast<int>(node);
    numbers[node] = isLowest ? static_cast<int>(positions.size()) : numbers[lowest[node]];
    if (isLowest) positions.push_back(mesh.nodes[node]);
  }
  mesh.nodes = std::move(positions);
  renumberAll(mesh, numbers);
}

/// The common edges of two tiles, with opposite directions, on the bottom or the top: bricks that
/// are joined at an angle meet on one face.
std::vector<std::pair<int, int>> sharedEdges(const ElementMesh& mesh, const TileElements& a,
                                             const TileElements& b, double tolerance) {
  std::vector<std::pair<int, int>> shared;
  const auto areSame = [&](int p, int q) {
    return (mesh.nodes[p] - mesh.nodes[q]).norm() <= tolerance;
  };
  for (std::size_t e = 0; e < a.edges.size(); ++e) {
    for (std::size_t f = 0; f < b.edges.size(); ++f) {
      const std::vector<int>&from = a.edges[e], &to = a.edges[(e + 1) % a.edges.size()];
      const std::vector<int>&end = b.edges[f], &start = b.edges[(f + 1) % b.edges.size()];
      const bool isShared =
          (areSame(from.front(), start.front()) && areSame(to.front(), end.front())) ||
          (areSame(from.back(), start.back()) && areSame(to.back(), end.back()));
      if (isShared) shared.emplace_back(static_cast<int>(e), static_cast<int>(f));
    }
  }
  return shared;
}

std::vector<int> nodesOnEdge(const ElementMesh& mesh, const TileElements& tile, int edge) {
  std::vector<int> nodes;
  for (const ElementFace& face : tile.sides) {
    if (face.tileEdge != edge) continue;
    const std::vector<int> own = faceNodes(mesh, face);
    nodes.insert(nodes.end(), own.begin(), own.end());
  }
  return sortedOnce(std::move(nodes));
}

/// Positions on a side face: along the edge between two corners, and from the bottom up.
std::vector<std::array<double, 2>> placesOnSide(const ElementMesh& mesh,
                                                const std::vector<int>& nodes,
                                                const std::vector<int>& from,
                                                const std::vector<int>& to) {
  const Vector3& origin = mesh.nodes[from.front()];
  const Vector3 along = (mesh.nodes[to.front()] - origin).normalized();
  // A shell's side has no height.
  const Vector3 up = (mesh.nodes[from.back()] - origin).normalized();
  std::vector<std::array<double, 2>> places;
  for (const int node : nodes) {
    const Vector3 offset = mesh.nodes[node] - origin;
    places.push_back({offset.dot(along), offset.dot(up)});
  }
  return places;
}

/// A node exactly at the radius belongs to the patch despite rounding.
constexpr double kRoundedUp = 1 + 1e-9;

/// A corner node on the bottom uses only bottom nodes. A patch through the thickness would stiffen
/// the tile.
std::vector<int> patchAround(const ElementMesh& mesh, const TileElements& tile, int corner) {
  const bool isBottom = std::ranges::binary_search(tile.bottom, corner);
  std::vector<int> patch;
  for (const int node : isBottom ? tile.bottom : tile.top) {
    const double distance = (mesh.nodes[node] - mesh.nodes[corner]).norm();
    if (distance <= kRoundedUp * mesh.rule.patchRadius) patch.push_back(node);
  }
  return patch;
}

void requireEnough(const std::vector<int>& patch, int tile, const ElementMesh& mesh,
                   int minPerEdge) {
  if (patch.size() >= 3) return;
  throw InputError(
      fmt::format("error: a joint patch of radius {} has {} nodes of tile {}, at least 3 are "
                  "needed; use {} elements per edge or a larger radius",
                  lengthText(mesh.rule.patchRadius, mesh.rule.unit, 4), patch.size(),
                  tile + mesh.rule.countsFrom, minPerEdge));
}

/// A node can belong to only one rigid body. `isTaken` has the nodes of all previous tiles.
void requireApart(const std::vector<int>& patch, int tile, const ElementMesh& mesh,
                  std::vector<bool>& isTaken) {
  for (const int node : patch) {
    if (isTaken[node]) {
      std::vector<Vector3> corners;
      for (const auto& edge : mesh.tiles[tile].edges) corners.push_back(mesh.nodes[edge.front()]);
      throw InputError(fmt::format(
          "error: joint patches of radius {} overlap on tile {}; choose one "
          "below {}, half the distance of its nearest corners",
          lengthText(mesh.rule.patchRadius, mesh.rule.unit, 4), tile + mesh.rule.countsFrom,
          lengthText(0.5 * smallestDistance(corners), mesh.rule.unit, 4)));
    }
    isTaken[node] = true;
  }
}

}  // namespace

double smallestDistance(const std::vector<Vector3>& points) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) least = std::min(least, (points[a] - points[b]).norm());
  }
  return least;
}

std::vector<JointNodes> jointNodes(const std::vector<model::Joint>& joints,
                                   const std::vector<TileElements>& tiles, int countsFrom) {
  std::vector<JointNodes> nodes;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const model::Joint& joint = joints[j];
    if (joint.kind == model::JointKind::Fixed) continue;
    if (joint.kind != model::JointKind::Pivot) {
      throw InputError(
          fmt::format("error: joint {} does not join two corners; a mesh can join only pivots",
                      j + static_cast<std::size_t>(countsFrom)));
    }
    nodes.push_back({joint.a.tile, joint.b.tile, joint.face == model::JointFace::Both,
                     heldNodes(tiles[joint.a.tile].edges[joint.a.vertex], joint.face),
                     heldNodes(tiles[joint.b.tile].edges[joint.b.vertex], joint.face)});
  }
  return nodes;
}

void joinTiles(ElementMesh& mesh, const std::vector<model::Joint>& joints) {
  // Gap after a run, as a fraction of an edge.
  constexpr double kSameEdge = 1e-3;
  DisjointSets sets(mesh.nodes.size());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].kind != model::JointKind::Fixed) continue;
    TileElements &a = mesh.tiles[joints[j].a.tile], &b = mesh.tiles[joints[j].b.tile];
    std::vector<Vector3> corners;
    for (const TileElements* tile : {&a, &b}) {
      for (const std::vector<int>& edge : tile->edges) corners.push_back(mesh.nodes[edge.front()]);
    }
    const double length = (corners[1] - corners[0]).norm();
    const auto shared = sharedEdges(mesh, a, b, kSameEdge * length);
    if (shared.empty()) {
      throw InputError(fmt::format(
          "error: joint {} fixes tiles {} and {} to each other, which share no edge; a mesh can "
          "join only tiles side by side",
          j + static_cast<std::size_t>(mesh.rule.countsFrom),
          joints[j].a.tile + mesh.rule.countsFrom, joints[j].b.tile + mesh.rule.countsFrom));
    }
    for (const auto& [edgeA, edgeB] : shared) {
      const auto cornersOf = [](const TileElements& tile, int edge) {
        return std::pair{tile.edges[edge], tile.edges[(edge + 1) % tile.edges.size()]};
      };
      const std::vector<int> own = nodesOnEdge(mesh, a, edgeA),
                             others = nodesOnEdge(mesh, b, edgeB);
      const auto [fromA, toA] = cornersOf(a, edgeA);
      const auto [toB, fromB] = cornersOf(b, edgeB);
      // At an angle the nodes of one face are apart, so their positions on the sides are compared.
      const auto placesA = placesOnSide(mesh, own, fromA, toA);
      const auto placesB = placesOnSide(mesh, others, fromB, toB);
      for (std::size_t k = 0; k < own.size(); ++k) {
        const auto nearest = std::ranges::min_element(placesB, {}, [&](const auto& place) {
          return std::hypot(place[0] - placesA[k][0], place[1] - placesA[k][1]);
        });
        sets.unite(own[k], others[nearest - placesB.begin()]);
      }
      std::erase_if(a.sides,
                    [edge = edgeA](const ElementFace& face) { return face.tileEdge == edge; });
      std::erase_if(b.sides,
                    [edge = edgeB](const ElementFace& face) { return face.tileEdge == edge; });
    }
    mesh.joined.push_back({joints[j].a.tile, joints[j].b.tile});
  }
  if (mesh.joined.empty()) return;
  std::vector<int> lowest(mesh.nodes.size());
  std::vector<Vector3> sums(mesh.nodes.size(), Vector3::Zero());
  std::vector<int> counts(mesh.nodes.size());
  for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node) {
    lowest[node] = sets.lowestOf(node);
    sums[lowest[node]] += mesh.nodes[node];
    ++counts[lowest[node]];
  }
  for (std::size_t node = 0; node < lowest.size(); ++node) {
    if (counts[node] > 1) mesh.nodes[node] = sums[node] / counts[node];
  }
  mergeNodes(mesh, lowest);
}

std::vector<NodeCluster> findClusters(const ElementMesh& mesh) {
  DisjointSets sets(mesh.nodes.size());
  for (const JointNodes& joint : mesh.joints) joinAll(joint, mesh.rule.joints, sets);
  std::vector<int> place(mesh.nodes.size(), -1);
  std::vector<NodeCluster> clusters;
  for (int node = 0; node < static_cast<int>(mesh.nodes.size()); ++node) {
    const int lowest = sets.lowestOf(node);
    // The lowest node itself enters with the first node joined to it. Single nodes are not
    // clusters.
    if (lowest == node) continue;
    if (place[lowest] < 0) {
      place[lowest] = static_cast<int>(clusters.size());
      clusters.push_back({{lowest}, {}, 0});
    }
    clusters[place[lowest]].nodes.push_back(node);
  }
  std::ranges::sort(clusters, {}, [](const NodeCluster& cluster) { return cluster.nodes[0]; });
  const std::vector<int> owner = tilesOfNodes(mesh);
  for (NodeCluster& cluster : clusters) {
    cluster.gap = largestDistance(cluster.nodes, mesh.nodes);
    requireDifferentTiles(cluster, owner, mesh.rule);
  }
  return clusters;
}

void mergeClusters(ElementMesh& mesh) {
  std::vector<int> lowest(mesh.nodes.size());
  std::iota(lowest.begin(), lowest.end(), 0);
  const std::vector<int> owner = tilesOfNodes(mesh);
  // Clusters of shells in the middle come first and are merged. Those of shells on a face stay.
  const auto kept = std::stable_partition(
      mesh.clusters.begin(), mesh.clusters.end(),
      [&](const NodeCluster& cluster) { return mesh.tiles[owner[cluster.nodes[0]]].level == 0.5; });
  for (auto cluster = mesh.clusters.begin(); cluster != kept; ++cluster) {
    for (const int node : cluster->nodes) lowest[node] = cluster->nodes[0];
    mesh.nodes[cluster->nodes[0]] =
        referencePosition(mesh, static_cast<std::size_t>(cluster - mesh.clusters.begin()));
  }
  mesh.clusters.erase(mesh.clusters.begin(), kept);
  mergeNodes(mesh, lowest);
}

void spreadPatches(ElementMesh& mesh, int minPerEdge) {
  const std::vector<int> owner = tilesOfNodes(mesh);
  std::vector<bool> isTaken(mesh.nodes.size());
  for (NodeCluster& cluster : mesh.clusters) {
    for (const int corner : cluster.nodes) {
      const int tile = owner[corner];
      cluster.patches.push_back(patchAround(mesh, mesh.tiles[tile], corner));
      requireEnough(cluster.patches.back(), tile, mesh, minPerEdge);
      requireApart(cluster.patches.back(), tile, mesh, isTaken);
    }
  }
}

}  // namespace kirireel::fea
