// How a mesh of hinged tiles comes about:
//
// - 1. How many elements lie along the edges is chosen (usualPerEdge, divisionOf).
// - 2. Each tile is divided into quadrilaterals once for all tiles of its kind (footprint.h), in
//   shares of its vertices, so that the positions follow from the brick and its pose.
// - 3. Prisms are laid on these, layer by layer (prism_layers.h).
// - 4. The corners that joints hold together are found; they are merged, left for equations, or
//   given patches (node_clusters.h).
// - 5. Solids are checked: no prism may fold over, none may be 500 times as long as high.
//
// Tiles are meshed one by one and never match along their edges, because only corners are joined; a
// mesher of general domains would glue what merely touches. Quadrilaterals, not triangles, since
// wedges (C3D15, C3D6) bend far more stiffly at the same number of nodes.
//
// Check of a corner: with a its position, n and p the next and previous corner of its face and u
// the corner above (or below, with the sign turned),
//
//     V = (n - a) x (p - a) . (u - a) > 0,
//
// six times the volume of the corner's tetrahedron, m^3. A hexahedron whose eight corners have V >
// 0 is not turned inside out there. It is the Jacobian determinant at the corners of the linear
// element; midside nodes lie halfway, so that quadratic elements have the same.
#include "render/fea/element_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "render/fea/footprint.h"
#include "render/fea/node_clusters.h"
#include "render/fea/prism_layers.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

/// A single quadratic element cannot show a moment that varies along a tile.
constexpr int kLeastUsualPerEdge = 2;
/// Also the range in the command line's help. It bounds an edge and the thickness.
constexpr int kMostElements = 64;
/// More would fill memory, and no program reads them.
constexpr std::size_t kMostElementsInAll = 4'000'000;

/// What nobody chose stays below this: half a million nodes at most, which a direct solver can
/// still factorise on a workstation.
constexpr std::size_t kUsualElementsInAll = 60'000;
/// Elements this many times longer than thick are useless in any program.
constexpr double kMostAspect = 500;

/// The lengths of a tile's edges, metres.
std::vector<double> edgeLengths(const Brick& brick) {
  std::vector<double> lengths;
  for (std::size_t k = 0; k < brick.bottom.size(); ++k) {
    lengths.push_back((brick.bottom[(k + 1) % brick.bottom.size()] - brick.bottom[k]).norm());
  }
  return lengths;
}

/// A quarter of the least distance between two corners of a tile: patches at both stay apart. Half
/// the least distance would be the limit at which patches touch.
double usualPatchRadius(const std::vector<Brick>& bricks) {
  double least = std::numeric_limits<double>::infinity();
  for (const Brick& brick : bricks) least = std::min(least, leastDistance(brick.bottom));
  return 0.25 * least;
}

/// How many elements along an edge of this length put its first node into the patch at its end.
/// Nodes lie l / (m n) apart on an edge of length l, with n elements and m = 2 intervals an element
/// when quadratic, else 1. The first is within the radius r when n >= l / (m r). The 1e-9 keeps an
/// exact quotient from being rounded up.
int perEdgeForPatch(double length, const ElementRule& rule) {
  const int nodesAnElement = rule.quadratic ? 2 : 1;
  return static_cast<int>(std::ceil(length / (nodesAnElement * rule.patchRadius) - 1e-9));
}

/// How many elements lie along an edge; `usual` where the rule does not say. A length in metres
/// decides first, then the count per edge.
int elementsAlong(double length, const ElementRule& rule, int usual) {
  if (rule.size > 0) return std::max(1, static_cast<int>(std::ceil(length / rule.size - 1e-9)));
  if (rule.perEdge > 0) return rule.perEdge;
  return rule.joints == JointStyle::Patch ? std::max(usual, perEdgeForPatch(length, rule)) : usual;
}

/// How a tile is divided, so that tiles divided alike share one footprint. It is the key of a map.
struct Division {
  int sides = 0;
  int first = 0;   ///< cells along edge 0 of a grid; half the cells along an edge of a fan
  int second = 0;  ///< cells along edge 1 of a grid; 0 of a fan
  std::vector<std::array<int, 3>> triangles = {};  ///< of a concave tile, in place of a fan

  auto operator<=>(const Division&) const = default;

  std::size_t cells() const {
    // Three quadrilaterals a triangle, each of first x first cells.
    if (!triangles.empty()) return 3 * triangles.size() * first * first;
    // A triangle alone: 3 grids of first^2 cells. A fan: as many for each side.
    const auto square = static_cast<std::size_t>(first) * (second > 0 ? second : 3 * first);
    return second > 0 || sides == 3 ? square : sides * square;
  }
};

/// Concave tiles follow their triangulation, four-sided ones become a grid, all others a fan.
/// Opposite edges of a grid have the same count, that of the longer; a fan has one count, even and
/// by the longest edge.
Division divisionOf(const Brick& brick, const ElementRule& rule, int usual) {
  const std::vector<double> lengths = edgeLengths(brick);
  const int sides = static_cast<int>(lengths.size());
  const int half = (elementsAlong(std::ranges::max(lengths), rule, usual) + 1) / 2;
  // `parts` are the convex pieces of a concave brick; a fan round its centre could fold over.
  if (!brick.parts.empty()) return {sides, half, 0, trianglesOf(brick.bottom, brick.normal)};
  if (takesGrid(brick.bottom, brick.normal)) {
    return {sides, elementsAlong(std::max(lengths[0], lengths[2]), rule, usual),
            elementsAlong(std::max(lengths[1], lengths[3]), rule, usual)};
  }
  return {sides, half, 0};
}

std::vector<Division> divisionsOf(const std::vector<Brick>& bricks, const ElementRule& rule,
                                  int usual) {
  std::vector<Division> divisions;
  for (const Brick& brick : bricks) divisions.push_back(divisionOf(brick, rule, usual));
  return divisions;
}

/// Counted without making any, which decides how fine the mesh may be.
std::size_t elementsIn(const std::vector<Division>& divisions, const ElementRule& rule) {
  std::size_t count = 0;
  for (const Division& division : divisions) count += rule.through * division.cells();
  return count;
}

void requireReasonableCount(const std::vector<Division>& divisions, const ElementRule& rule) {
  const std::size_t count = elementsIn(divisions, rule);
  if (count <= kMostElementsInAll) return;
  throw InputError(
      fmt::format("error: {} elements would be made, at most {} are allowed; use fewer "
                  "per edge or through the thickness",
                  count, kMostElementsInAll));
}

Footprint footprintOf(const Division& division, const ElementRule& rule) {
  if (!division.triangles.empty()) {
    return triangleFootprint(division.triangles, division.sides, division.first);
  }
  const bool isGraded = rule.family == ElementFamily::Shell;
  return division.second > 0 ? gridFootprint(division.first, division.second, isGraded)
                             : fanFootprint(division.sides, division.first);
}

/// The points of a brick's footprint at each level, in world axes; a single level lies at this
/// share of the thickness.
std::vector<std::vector<Vector3>> levelsOf(const Brick& brick, const Pose& pose,
                                           const Footprint& footprint, int count, double single) {
  std::vector<Vector3> bases = brick.bottom;
  // The centre of mass is the origin of brick axes, the bottom's half a thickness below it.
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

/// `level` is the share of the thickness at which shells lie; solids take no note of it.
void appendBrick(ElementMesh& mesh, const Brick& brick, const Pose& pose,
                 const Footprint& footprint, double level) {
  const int count = PrismLayers::levelCount(mesh.rule);
  PrismLayers layers(mesh, footprint.cells, levelsOf(brick, pose, footprint, count, level));
  TileElements tile = layers.append(0, footprint.cells.size(), footprint.sides);
  tile.isRow = footprint.isRow;
  tile.level = level;
  for (const int corner : footprint.corners) tile.edges.push_back(layers.nodesAt(corner));
  mesh.tiles.push_back(std::move(tile));
}

/// Six times the volume of the tetrahedron that a corner and its three neighbours span. `corner` is
/// 0 to 7; base is the first corner of its face, 0 of the bottom or 4 of the top.
double cornerVolume(const ElementMesh& mesh, const Element& element, int corner) {
  const int base = corner < 4 ? 0 : 4;
  const auto at = [&](int k) { return mesh.nodes[element.nodes[k]]; };
  const Vector3 origin = at(corner);
  const Vector3 next = at(base + (corner - base + 1) % 4) - origin;
  const Vector3 previous = at(base + (corner - base + 3) % 4) - origin;
  const Vector3 up = base == 0 ? at(corner + 4) - origin : origin - at(corner - 4);
  return next.cross(previous).dot(up);
}

/// Of the bottom face; the top is its copy, a thickness higher.
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
  if (length <= kMostAspect * height) return;
  throw InputError(fmt::format(
      "error: tile {} is too thin for its elements, {:.3g} m long and {:.3g} m high; at most {} "
      "times as long as high are allowed: use more elements per edge, fewer through the thickness, "
      "or thicker bricks",
      tile, length, height, kMostAspect));
}

/// Merged corners have moved to their mean, so a joint with a large gap can fold an element too.
void checkCorners(const ElementMesh& mesh, const Element& element, int tile) {
  for (int k = 0; k < 8; ++k) {
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
    const int number = static_cast<int>(t) + mesh.rule.countsFrom;
    for (int k = 0; k < tile.elementCount; ++k) {
      const Element& element = mesh.elements[tile.firstElement + k];
      checkAspect(mesh, element, number, bricks[t].thickness);
      checkCorners(mesh, element, number);
    }
  }
}

/// Where in the thickness the shells of each tile lie: where its joints do. 0 bottom, 0.5 middle, 1
/// top; 0.5 also for tiles without joints. An offset shell carries its nodes where the hinge is,
/// which keeps the lever of half a thickness between them.
std::vector<double> shellLevels(std::size_t tiles, const std::vector<Joint>& joints,
                                const ElementRule& rule) {
  std::vector<std::optional<JointFace>> faces(tiles);
  for (const Joint& joint : joints) {
    for (const int tile : {joint.a.tile, joint.b.tile}) {
      if (faces[tile].value_or(joint.face) != joint.face) {
        throw InputError(
            fmt::format("error: tile {} has joints on different faces, and a shell has nodes on "
                        "one; leave --shells out",
                        tile + rule.countsFrom));
      }
      faces[tile] = joint.face;
    }
  }
  std::vector<double> levels;
  for (const auto& face : faces) {
    const JointFace own = face.value_or(JointFace::Both);
    levels.push_back(own == JointFace::Both ? 0.5 : own == JointFace::Top ? 1 : 0);
  }
  return levels;
}

/// Divides every brick by itself; the rule's patch radius is known.
void divideBricks(const std::vector<Brick>& bricks, const std::vector<Joint>& joints,
                  const Poses& poses, ElementMesh& mesh) {
  std::vector<double> levels(bricks.size(), 0.5);
  if (mesh.rule.family == ElementFamily::Shell) {
    levels = shellLevels(bricks.size(), joints, mesh.rule);
  }
  const std::vector<Division> divisions =
      divisionsOf(bricks, mesh.rule, usualPerEdge(bricks, mesh.rule));
  requireReasonableCount(divisions, mesh.rule);
  // Sheets have thousands of tiles and few divisions: a footprint is made once for each.
  std::map<Division, Footprint> footprints;
  for (std::size_t t = 0; t < bricks.size(); ++t) {
    const auto [place, isNew] = footprints.try_emplace(divisions[t]);
    if (isNew) place->second = footprintOf(divisions[t], mesh.rule);
    appendBrick(mesh, bricks[t], poses[t], place->second, levels[t]);
  }
}

/// Throws InputError for elements that hinged tiles cannot have.
void requireBuildable(const ElementRule& rule) {
  if (rule.family == ElementFamily::Plane || rule.joints == JointStyle::Neck) {
    throw InputError(
        "error: plane elements are made of one sheet with necks alone; give --joints neck with a "
        "--neck-width, or leave --plane-stress out");
  }
  if (rule.family == ElementFamily::Shell && rule.joints != JointStyle::Shared) {
    throw InputError(
        "error: shells of hinged tiles share nodes or have equations as their joints ask for; "
        "leave "
        "--joints out, or choose neck");
  }
}

/// The least number of elements per edge whose nodes fill every patch. For a message that says how
/// to mend too coarse a mesh.
int leastPerEdge(const std::vector<Brick>& bricks, const ElementRule& rule) {
  int least = 1;
  for (const Brick& brick : bricks) {
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

int nodeCount(const ElementRule& rule) {
  if (rule.family != ElementFamily::Solid) return rule.quadratic ? 8 : 4;
  return rule.quadratic ? 20 : 8;
}

void requireValidRule(const ElementRule& rule) {
  const auto require = [](int found, int least, const char* what) {
    if (found >= least && found <= kMostElements) return;
    throw InputError(fmt::format("error: {} elements {} are not possible; choose 1 to {}", found,
                                 what, kMostElements));
  };
  require(rule.perEdge, 0, "per edge");
  require(rule.through, 1, "through the thickness");
  if (rule.perEdge > 0 && rule.size > 0) {
    throw InputError(
        fmt::format("error: {} elements per edge and elements of {} m contradict each "
                    "other; give one of the two",
                    rule.perEdge, rule.size));
  }
  if (!(rule.size >= 0) || !(rule.patchRadius >= 0)) {
    throw InputError(
        fmt::format("error: elements of {} m and patches of radius {} m are not "
                    "possible; give positive lengths",
                    rule.size, rule.patchRadius));
  }
}

int usualPerEdge(const std::vector<Brick>& bricks, const ElementRule& rule) {
  int usual = kUsualPerEdge;
  // The count falls with the square of `usual`, so a few rounds do.
  while (usual > kLeastUsualPerEdge &&
         elementsIn(divisionsOf(bricks, rule, usual), rule) > kUsualElementsInAll) {
    --usual;
  }
  return usual;
}

bool isCoarsened(const std::vector<Brick>& bricks, const ElementRule& rule) {
  return rule.perEdge == 0 && rule.size == 0 && usualPerEdge(bricks, rule) < kUsualPerEdge;
}

ElementMesh makeElementMesh(const std::vector<Brick>& bricks, const std::vector<Joint>& joints,
                            const Poses& poses, const ElementRule& rule) {
  requireValidRule(rule);
  requireBuildable(rule);
  ElementMesh mesh;
  mesh.rule = rule;
  if (rule.patchRadius == 0) mesh.rule.patchRadius = usualPatchRadius(bricks);
  divideBricks(bricks, joints, poses, mesh);
  mesh.joints = jointNodes(joints, mesh.tiles);
  mesh.clusters = findClusters(mesh);
  for (const NodeCluster& cluster : mesh.clusters) {
    mesh.largestGap = std::max(mesh.largestGap, cluster.gap);
  }
  // Gaps are measured before corners are merged, since the mean closes them.
  if (rule.joints == JointStyle::Shared) mergeClusters(mesh);
  if (rule.joints == JointStyle::Patch) spreadPatches(mesh, leastPerEdge(bricks, mesh.rule));
  if (rule.family == ElementFamily::Solid) checkElements(mesh, bricks);
  return mesh;
}

bool hasEquations(const ElementMesh& mesh) {
  return mesh.rule.joints != JointStyle::Patch && !mesh.clusters.empty();
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

}  // namespace kirireel
