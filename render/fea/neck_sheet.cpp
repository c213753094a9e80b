// The outline's regions become surfaces that share lines between tiles and necks, so Gmsh makes one
// mesh of them. The two sides of a slit are separate lines, so it stays open. All cells are
// quadrilaterals: Gmsh combines triangles to quadrilaterals and then divides each cell into
// quadrilaterals of half its size. At a distance d from the necks their size is
//     h(d) = clamp(h_neck + 0.25 (d - w / 2), h_neck, h_tile),   h_neck = w / 6, h_tile = size / 8,
//
// At a distance d from corners, where stresses are singular, it is at most h_neck / 8 + 0.25 d. All
// sizes are inversely proportional to the number of elements per edge, and half as large for linear
// elements.
//
// Shells are also finer along the ends of the sheet, h_tile / 4 + 0.25 d, where they are clamped.
// CalculiX expands a shell to solids, whose thickness cannot change with bending at a fully clamped
// edge. This effect decays over one element. A strip of that width is too stiff: a clamped square
// plate of 8 elements per edge deflects 5% too little.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "render/fea/outside_program.h"
#include "render/fea/sheet_ends.h"
#include "sim/base/error.h"

namespace kirireel::fea {
namespace {

constexpr double kAcrossNeck = 6;  ///< elements, at the default number per edge
constexpr double kFinerAtCorners = 8;
constexpr double kFinerAtEnds = 4;  ///< only for shells
/// Increase of element size per distance, metres per metre.
constexpr double kMeshGrowth = 0.25;

/// Quadrilaterals by region: tiles first, then necks.
struct RegionMesh {
  std::vector<writers::Vector2> points;
  std::vector<std::array<int, 4>> cells;
  std::vector<std::size_t> firstCell;  ///< of each region, and the number of cells at the end
  std::map<std::pair<int, int>, int> lineOf;  ///< zero-based line that contains a side of a cell
};

/// Unique lines between points, with their number of uses by regions. A line shared by a tile and a
/// neck has one number, signed by its direction, as Gmsh's curve loops require. This makes the mesh
/// one piece there.
class OutlineLines {
 public:
  /// The signed one-based number of a line. Negative if it was first named, or is stored, in the
  /// opposite direction.
  int find(int from, int to) {
    const auto [place, isNew] =
        numbers_.try_emplace(std::minmax(from, to), static_cast<int>(numbers_.size()) + 1);
    if (isNew) ends_.emplace_back(std::min(from, to), std::max(from, to));
    return from < to ? place->second : -place->second;
  }

  const std::vector<std::pair<int, int>>& ends() const { return ends_; }

 private:
  std::map<std::pair<int, int>, int> numbers_;
  std::vector<std::pair<int, int>> ends_;
};

/// The points of a region: tiles come first, then necks.
const std::vector<int>& loopOf(const writers::NeckOutline& outline, int region) {
  const int tiles = static_cast<int>(outline.tiles.size());
  return region < tiles ? outline.tiles[region] : outline.necks[region - tiles];
}

/// The ends of the sheet, in the plane of the outline.
EndEdges endsOf(const writers::NeckOutline& outline, double tileSize) {
  std::vector<std::vector<Vector3>> polygons;
  // Two regions with a common line are connected.
  std::vector<PolygonLink> links;
  std::map<std::pair<int, int>, int> firstWith;
  for (const auto* loops : {&outline.tiles, &outline.necks}) {
    for (const std::vector<int>& loop : *loops) {
      const auto number = static_cast<int>(polygons.size());
      std::vector<Vector3>& polygon = polygons.emplace_back();
      for (const int k : loop)
        polygon.emplace_back(outline.points[k].x(), outline.points[k].y(), 0);
      for (std::size_t k = 0; k < loop.size(); ++k) {
        const std::size_t next = (k + 1) % loop.size();
        const auto [line, isNew] = firstWith.try_emplace(std::minmax(loop[k], loop[next]), number);
        if (isNew) continue;
        links.push_back({line->second, number, 0.5 * (polygon[k] + polygon[next])});
      }
    }
  }
  return findEndEdges(polygons, links, tileSize);
}

/// Points along the lines of necks, for distances to the necks. Distance fields need points, so
/// lines are sampled at every quarter of the neck's width.
std::vector<writers::Vector2> pointsOnNecks(const writers::NeckOutline& outline) {
  std::vector<writers::Vector2> points;
  for (std::size_t k = 0; k < outline.points.size(); ++k) {
    if (outline.isAtNeck[k]) points.push_back(outline.points[k]);
  }
  const auto appendBetween = [&](int from, int to) {
    const writers::Vector2 along = outline.points[to] - outline.points[from];
    const int count = static_cast<int>(along.norm() / (0.25 * outline.neckWidth));
    for (int k = 1; k < count; ++k) {
      points.push_back(outline.points[from] + along * k / count);
    }
  };
  for (const std::vector<int>& neck : outline.necks) {
    for (std::size_t k = 0; k < neck.size(); ++k)
      appendBetween(neck[k], neck[(k + 1) % neck.size()]);
  }
  return points;
}

/// Points along the outline's lines at the ends of the sheet, with this spacing.
std::vector<writers::Vector2> pointsOnEnds(const writers::NeckOutline& outline,
                                           const EndEdges& ends, double spacing) {
  std::vector<writers::Vector2> points;
  for (const std::vector<PolygonEdge>& edges : ends.edges) {
    for (const PolygonEdge& edge : edges) {
      const std::vector<int>& loop = loopOf(outline, edge.polygon);
      const writers::Vector2& from = outline.points[loop[edge.edge]];
      const writers::Vector2& to = outline.points[loop[(edge.edge + 1) % loop.size()]];
      const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / spacing)));
      for (int j = 0; j <= count; ++j) points.emplace_back(from + (to - from) * j / count);
    }
  }
  return points;
}

/// Points with smaller elements around them.
struct FineZone {
  std::vector<writers::Vector2> points;
  double size = 0;  ///< of elements at the points, metres
  double from = 0;  ///< distance at which elements begin to grow, metres
};

/// Element sizes, metres.
struct CellSizes {
  double most = 0;  ///< far from all zones
  std::vector<FineZone> zones;
};

CellSizes cellSizes(const writers::NeckOutline& outline, const ElementRule& rule, double tileSize) {
  const double perEdge = rule.perEdge > 0 ? rule.perEdge
                         : rule.size > 0  ? tileSize / rule.size
                                          : kDefaultPerEdge;
  const double linear = rule.quadratic ? 1 : 0.5;
  const double atNecks = linear * outline.neckWidth / kAcrossNeck * kDefaultPerEdge / perEdge;
  CellSizes sizes;
  // Elements far from necks are never smaller than at necks.
  sizes.most = std::max(linear * tileSize / perEdge, atNecks);
  // Corners at begins of necks and ends of slits are singular and need much finer elements.
  FineZone corners{{}, atNecks / kFinerAtCorners, 0};
  for (std::size_t k = 0; k < outline.points.size(); ++k) {
    if (outline.isAtNeck[k]) corners.points.push_back(outline.points[k]);
  }
  if (!corners.points.empty()) {
    sizes.zones.push_back(corners);
    sizes.zones.push_back({pointsOnNecks(outline), atNecks, 0.5 * outline.neckWidth});
  }
  if (rule.family == ElementFamily::Shell) {
    const double atEnds = sizes.most / kFinerAtEnds;
    sizes.zones.push_back({pointsOnEnds(outline, endsOf(outline, tileSize), atEnds), atEnds, 0});
    if (sizes.zones.back().points.empty()) sizes.zones.pop_back();
  }
  return sizes;
}

/// Gmsh's fields: for each zone the distance to its points, numbered from `firstPoint`, and sizes
/// that grow with it. The minimum applies. Gmsh halves sizes when it divides the cells.
void appendSizes(std::string& text, const CellSizes& sizes, std::size_t firstPoint) {
  int field = 0;
  std::string thresholds;
  for (const FineZone& zone : sizes.zones) {
    // Two fields per zone: a distance, and a threshold that maps it to a size, SizeMin up to
    // DistMin, then linearly to SizeMax at DistMax.
    appendText(text, "Field[{0}] = Distance;\nField[{0}].PointsList = {{", ++field);
    for (std::size_t k = 0; k < zone.points.size(); ++k) {
      appendText(text, "{}{}", k > 0 ? "," : "", firstPoint++);
    }
    appendText(
        text,
        "}};\nField[{0}] = Threshold;\nField[{0}].InField = {1};\nField[{0}].SizeMin = {2};\n"
        "Field[{0}].SizeMax = {3};\nField[{0}].DistMin = {4};\nField[{0}].DistMax = {5};\n",
        field + 1, field, 2 * zone.size, 2 * sizes.most, zone.from,
        zone.from + std::max(sizes.most - zone.size, 1e-9) / kMeshGrowth);
    appendText(thresholds, "{}{}", thresholds.empty() ? "" : ", ", ++field);
  }
  if (!sizes.zones.empty()) {
    appendText(text,
               "Field[{0}] = Min;\nField[{0}].FieldsList = {{{1}}};\nBackground Field = {0};\n",
               field + 1, thresholds);
  }
  appendText(text, "Mesh.MeshSizeMax = {};\n", 2 * sizes.most);
  text +=
      "Mesh.MeshSizeFromPoints = 0;\nMesh.MeshSizeExtendFromBoundary = 0;\n"
      "Mesh.Algorithm = 6;\nMesh.RecombineAll = 1;\nMesh.RecombinationAlgorithm = 1;\n"
      "Mesh.SubdivisionAlgorithm = 1;\n";
}

/// Reads Gmsh's result: nodes, and quadrilaterals with their region as first tag. MSH 2.2 in ASCII:
/// after $Nodes a count and rows "number x y z"; after $Elements a count and rows "number kind tags
/// tag... node...". The first tag is the physical group. neckGeometry uses the one-based number of
/// the region or the line for it. Kind 1 is a line of two nodes, kind 3 a quadrilateral of four.
RegionMesh readMesh(const std::string& text, std::size_t regions) {
  std::istringstream stream(text);
  RegionMesh mesh;
  std::map<long, int> numbers;
  std::vector<std::vector<std::array<int, 4>>> cells(regions);
  std::string word;
  while (stream >> word) {
    std::size_t count = 0;
    if (word == "$Nodes") {
      stream >> count;
      for (std::size_t k = 0; k < count; ++k) {
        long number = 0;
        double x = 0, y = 0, z = 0;
        stream >> number >> x >> y >> z;
        numbers[number] = static_cast<int>(mesh.points.size());
        mesh.points.emplace_back(x, y);
      }
    } else if (word == "$Elements") {
      stream >> count;
      for (std::size_t k = 0; k < count; ++k) {
        long number = 0, tag = 0;
        std::size_t region = 0;
        int kind = 0, tags = 0;
        stream >> number >> kind >> tags >> region;
        for (int t = 1; t < tags; ++t) stream >> tag;
        if (kind == 1) {
          long from = 0, to = 0;
          stream >> from >> to;
          const std::pair<int, int> side = std::minmax(numbers.at(from), numbers.at(to));
          mesh.lineOf[side] = static_cast<int>(region) - 1;
          continue;
        }
        // Any other kind would be a remaining triangle, or a region without a name.
        if (kind != 3 || region < 1 || region > regions) {
          throw RunError("error: gmsh made other cells of this sheet than quadrilaterals");
        }
        std::array<int, 4>& cell = cells[region - 1].emplace_back();
        for (int& point : cell) {
          stream >> number;
          point = numbers.at(number);
        }
      }
    }
  }
  for (const auto& own : cells) {
    mesh.firstCell.push_back(mesh.cells.size());
    mesh.cells.insert(mesh.cells.end(), own.begin(), own.end());
  }
  mesh.firstCell.push_back(mesh.cells.size());
  return mesh;
}

/// Makes all cells anticlockwise, for any orientation in Gmsh, and removes unused points. The cross
/// product of the diagonals is twice the signed area.
void tidy(RegionMesh& mesh) {
  std::vector<int> numbers(mesh.points.size(), -1);
  std::vector<writers::Vector2> used;
  for (std::array<int, 4>& cell : mesh.cells) {
    const auto at = [&](int k) { return mesh.points[cell[k]]; };
    const writers::Vector2 a = at(2) - at(0);
    const writers::Vector2 b = at(3) - at(1);
    if (crossZ(a, b) < 0) std::swap(cell[1], cell[3]);
    for (const int point : cell) {
      if (numbers[point] >= 0) continue;
      // Points are numbered by first use in cells. Samples of fields, which Gmsh keeps as nodes,
      // belong to no cell and vanish.
      numbers[point] = static_cast<int>(used.size());
      used.push_back(mesh.points[point]);
    }
  }
  for (std::array<int, 4>& cell : mesh.cells) {
    for (int& point : cell) point = numbers[point];
  }
  mesh.points = std::move(used);
  std::map<std::pair<int, int>, int> lines;
  for (const auto& [side, line] : mesh.lineOf) {
    lines[std::minmax(numbers[side.first], numbers[side.second])] = line;
  }
  mesh.lineOf = std::move(lines);
}

/// The lines of an outline in the order of their zero-based numbers in neckGeometry, and the number
/// of each region's lines.
std::vector<std::vector<int>> lineNumbers(const writers::NeckOutline& outline) {
  OutlineLines lines;
  std::vector<std::vector<int>> numbers;
  for (const auto* loops : {&outline.tiles, &outline.necks}) {
    for (const std::vector<int>& loop : *loops) {
      std::vector<int>& own = numbers.emplace_back();
      for (std::size_t k = 0; k < loop.size(); ++k) {
        own.push_back(std::abs(lines.find(loop[k], loop[(k + 1) % loop.size()])) - 1);
      }
    }
  }
  return numbers;
}

/// Sides of cells without a neighbour, by region and tile edge; cells are numbered from the
/// region's first. They are the outline of the sheet and both sides of each slit. tileEdge is -1 at
/// necks and where these are cut into tiles. `numbers`: lineNumbers().
std::vector<std::vector<FootprintSide>> freeSides(const RegionMesh& mesh,
                                                  const writers::NeckOutline& outline,
                                                  const std::vector<std::vector<int>>& numbers) {
  std::map<std::pair<int, int>, int> uses;
  const auto sideOf = [](const std::array<int, 4>& cell, int k) {
    return std::pair<int, int>(std::minmax(cell[k], cell[(k + 1) % 4]));
  };
  for (const auto& cell : mesh.cells) {
    for (int k = 0; k < 4; ++k) ++uses[sideOf(cell, k)];
  }
  std::vector<std::vector<FootprintSide>> sides(mesh.firstCell.size() - 1);
  for (std::size_t region = 0; region < sides.size(); ++region) {
    std::map<int, int> edgeOf;  // by the number of its line
    if (region < outline.edges.size()) {
      for (const int first : outline.edges[region]) {
        edgeOf.emplace(numbers[region][first], static_cast<int>(edgeOf.size()));
      }
    }
    for (std::size_t c = mesh.firstCell[region]; c < mesh.firstCell[region + 1]; ++c) {
      for (int k = 0; k < 4; ++k) {
        const auto side = sideOf(mesh.cells[c], k);
        if (uses[side] > 1) continue;
        const auto line = mesh.lineOf.find(side);
        const auto edge = line == mesh.lineOf.end() ? edgeOf.end() : edgeOf.find(line->second);
        sides[region].push_back({static_cast<int>(c - mesh.firstCell[region]), k,
                                 edge == edgeOf.end() ? -1 : edge->second});
      }
    }
    std::ranges::stable_sort(sides[region], {}, &FootprintSide::tileEdge);
  }
  return sides;
}

/// The points at each level, in world axes; plane elements in the plane z = 0. `sheet.turn` has
/// rotated the outline into the plane. Its conjugate rotates points back to the model's axes.
std::vector<std::vector<Vector3>> levelsOf(const RegionMesh& region,
                                           const writers::FlatSheet& sheet, double thickness,
                                           const ElementRule& rule) {
  const int count = PrismLayers::levelCount(rule);
  const Quaternion back = sheet.turn.conjugate();
  std::vector<std::vector<Vector3>> levels(count);
  for (int level = 0; level < count; ++level) {
    const double share = count > 1 ? static_cast<double>(level) / (count - 1) : 0.5;
    for (const writers::Vector2& point : region.points) {
      const bool isPlane = rule.family == ElementFamily::Plane;
      const Vector3 flat(point.x(), point.y(), isPlane ? 0 : sheet.height + share * thickness);
      levels[level].push_back(isPlane ? flat : back * flat);
    }
  }
  return levels;
}

}  // namespace

std::string neckGeometry(const writers::NeckOutline& outline, const ElementRule& rule,
                         double tileSize, const std::vector<TwinLines>& twins) {
  std::string text = "// A sheet with necks, by Kirireel. Metres.\n";
  const auto appendPoint = [&](std::size_t number, const writers::Vector2& at) {
    appendText(text, "Point({}) = {{{}, {}, 0, 1}};\n", number, at.x(), at.y());
  };
  for (std::size_t k = 0; k < outline.points.size(); ++k) appendPoint(k + 1, outline.points[k]);
  const CellSizes sizes = cellSizes(outline, rule, tileSize);
  // Points of the outline are 1 to n, followed by samples of the size fields.
  const std::size_t firstSample = outline.points.size() + 1;
  std::size_t sample = firstSample;
  for (const FineZone& zone : sizes.zones) {
    for (const writers::Vector2& point : zone.points) appendPoint(sample++, point);
  }
  OutlineLines lines;
  std::string surfaces;
  int region = 0;
  // Regions are numbered tiles first, then necks. Surfaces and physical groups have the same
  // numbers.
  for (const auto* loops : {&outline.tiles, &outline.necks}) {
    for (const std::vector<int>& loop : *loops) {
      appendText(surfaces, "Curve Loop({}) = {{", ++region);
      for (std::size_t k = 0; k < loop.size(); ++k) {
        appendText(surfaces, "{}{}", k > 0 ? "," : "",
                   lines.find(loop[k], loop[(k + 1) % loop.size()]));
      }
      appendText(surfaces, "}};\nPlane Surface({0}) = {{{0}}};\nPhysical Surface({0}) = {{{0}}};\n",
                 region);
    }
  }
  for (std::size_t k = 0; k < lines.ends().size(); ++k) {
    appendText(text, "Line({0}) = {{{1}, {2}}};\nPhysical Curve({0}) = {{{0}}};\n", k + 1,
               lines.ends()[k].first + 1, lines.ends()[k].second + 1);
  }
  text += surfaces;
  for (const TwinLines& pair : twins) {
    const writers::Vector2 move = outline.points[pair.line[0]] - outline.points[pair.twin[0]];
    appendText(text, "Periodic Curve {{{}}} = {{{}}} Translate {{{}, {}, 0}};\n",
               std::abs(lines.find(pair.line[0], pair.line[1])),
               std::abs(lines.find(pair.twin[0], pair.twin[1])), move.x(), move.y());
  }
  appendSizes(text, sizes, firstSample);
  return text;
}

namespace {

std::vector<MeshNeck> necksOf(const model::Model& model, double thickness,
                              const writers::NeckShape& shape) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {.thickness = thickness});
  const auto at = [&](const model::Corner& corner) {
    return brick::neckCorner(bricks[static_cast<std::size_t>(corner.tile)], corner.vertex);
  };
  std::vector<MeshNeck> necks;
  for (const model::Joint& joint : model.joints) {
    const auto sidesOf = [&](const model::Corner& corner) {
      return static_cast<int>(model.tiles[corner.tile].vertices.size());
    };
    necks.push_back({edgesBesideJoint(joint.a, sidesOf(joint.a), joint.b, sidesOf(joint.b)),
                     {at(joint.a), at(joint.b)},
                     writers::shapeAt(joint, shape)});
  }
  return necks;
}

/// The element faces at the ends of the outline.
SheetEnds endsOf(const ElementMesh& mesh, const RegionMesh& region,
                 const std::vector<std::vector<FootprintSide>>& sides,
                 const writers::NeckOutline& outline, const std::vector<std::vector<int>>& numbers,
                 double tileSize) {
  const EndEdges found = endsOf(outline, tileSize);
  SheetEnds ends{found.axes, found.isFlat, found.longest, {}};
  if (mesh.rule.family != ElementFamily::Plane) {
    ends.axes = outline.sheet.turn.conjugate().toRotationMatrix() * found.axes;
  }
  for (std::size_t end = 0; end < ends.faces.size(); ++end) {
    for (const PolygonEdge& edge : found.edges[end]) {
      const std::size_t part = edge.polygon;
      const TileElements& elements =
          part < mesh.tiles.size() ? mesh.tiles[part] : mesh.necks[part - mesh.tiles.size()];
      const std::size_t layers =
          elements.sides.size() / std::max<std::size_t>(1, sides[part].size());
      for (std::size_t k = 0; k < elements.sides.size(); ++k) {
        const FootprintSide& side = sides[part][k / layers];
        const std::array<int, 4>& cell = region.cells[region.firstCell[part] + side.cell];
        const auto line =
            region.lineOf.find(std::minmax(cell[side.side], cell[(side.side + 1) % 4]));
        if (line == region.lineOf.end()) continue;
        if (line->second == numbers[part][edge.edge]) ends.faces[end].push_back(elements.sides[k]);
      }
    }
  }
  return ends;
}

/// The mesh points on a line of the outline, in order along the line.
std::vector<int> pointsAlong(const RegionMesh& region, int line, const writers::Vector2& along) {
  std::vector<std::pair<double, int>> places;
  for (const auto& [side, number] : region.lineOf) {
    if (number != line) continue;
    for (const int point : {side.first, side.second}) {
      places.emplace_back(along.dot(region.points[point]), point);
    }
  }
  std::ranges::sort(places);
  std::vector<int> points;
  for (const auto& [place, point] : places) {
    if (points.empty() || points.back() != point) points.push_back(point);
  }
  return points;
}

/// The ties between the nodes of two lines.
void appendTies(std::vector<PeriodicTie>& ties, const RegionMesh& region, const PrismLayers& layers,
                const TwinLines& pair, const std::array<int, 2>& numbers,
                const writers::NeckOutline& outline) {
  const writers::Vector2 along = outline.points[pair.line[1]] - outline.points[pair.line[0]];
  const std::vector<int> points = pointsAlong(region, numbers[0], along);
  const std::vector<int> twins = pointsAlong(region, numbers[1], along);
  if (points.size() != twins.size()) {
    throw RunError("error: gmsh made other nodes on one side of a border than on the other");
  }
  const auto tie = [&](const std::vector<int>& nodes, const std::vector<int>& leaders) {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      ties.push_back({nodes[k], leaders[k], pair.cell});
  };
  for (std::size_t k = 0; k < points.size(); ++k) {
    tie(layers.nodesAt(points[k]), layers.nodesAt(twins[k]));
    if (k == 0) continue;
    tie(layers.nodesBetween(points[k - 1], points[k]), layers.nodesBetween(twins[k - 1], twins[k]));
  }
}

/// Gmsh's mesh of a geometry. An error message about a surface names its tile or neck.
RegionMesh meshedRegions(const std::string& geometry, std::size_t tiles, std::size_t regions,
                         int countsFrom) {
  try {
    return readMesh(meshedByGmsh(geometry), regions);
  } catch (const RunError& error) {
    const std::string words = error.what();
    const std::string_view before = "urface ";
    const std::size_t at = words.find(before);
    if (at == std::string::npos) throw;
    const auto surface = std::strtoul(words.c_str() + at + before.size(), nullptr, 10);
    if (surface < 1 || surface > regions) throw;
    const std::string part = surface > tiles ? fmt::format("neck {}", surface - tiles - 1)
                                             : fmt::format("tile {}", surface - 1 + countsFrom);
    throw RunError(fmt::format("{}; that is {} of the sheet", words, part));
  }
}

/// The mesh of an outline. Nodes of twin lines are tied.
ElementMesh meshOf(const writers::NeckOutline& outline, double thickness, const ElementRule& rule,
                   double tileSize, const std::vector<TwinLines>& twins) {
  const std::size_t regions = outline.tiles.size() + outline.necks.size();
  RegionMesh region = meshedRegions(neckGeometry(outline, rule, tileSize, twins),
                                    outline.tiles.size(), regions, rule.countsFrom);
  tidy(region);
  ElementMesh mesh;
  mesh.rule = rule;
  PrismLayers layers(mesh, region.cells, levelsOf(region, outline.sheet, thickness, rule));
  const std::vector<std::vector<int>> numbers = lineNumbers(outline);
  const std::vector<std::vector<FootprintSide>> sides = freeSides(region, outline, numbers);
  for (std::size_t k = 0; k < regions; ++k) {
    const std::size_t first = region.firstCell[k];
    TileElements part = layers.append(first, region.firstCell[k + 1] - first, sides[k]);
    // The same order as in neckGeometry.
    (k < outline.tiles.size() ? mesh.tiles : mesh.necks).push_back(std::move(part));
  }
  if (rule.family == ElementFamily::Plane) mesh.turn = outline.sheet.turn;
  mesh.ends = endsOf(mesh, region, sides, outline, numbers, tileSize);
  std::map<std::pair<int, int>, int> numberOf;
  for (std::size_t k = 0; k < regions; ++k) {
    const std::vector<int>& loop = loopOf(outline, static_cast<int>(k));
    for (std::size_t j = 0; j < loop.size(); ++j) {
      numberOf[std::minmax(loop[j], loop[(j + 1) % loop.size()])] = numbers[k][j];
    }
  }
  std::vector<PeriodicTie> pairs;
  for (const TwinLines& pair : twins) {
    appendTies(pairs, region, layers, pair,
               {numberOf.at(std::minmax(pair.line[0], pair.line[1])),
                numberOf.at(std::minmax(pair.twin[0], pair.twin[1]))},
               outline);
  }
  mesh.ties = tiesBetween(pairs);
  return mesh;
}

// ------------------------------------------------------------------------------------------------
// One cell of an infinite sheet. The outline contains the cell and copies of its tiles that joints
// connect to it across the border, each joint once on either side. The cell keeps the necks there
// that begin at the joint's first tile. Lines between the cell and removed regions come in pairs at
// a distance of a period.

/// The cell, followed by copies of tiles beyond its border with their joints.
model::Model withNeighbours(const model::Model& model, const SheetLattice& lattice) {
  model::Model extended;
  extended.tiles = model.tiles;
  extended.joints = model.joints;
  extended.fileOrder.countsFrom = model.fileOrder.countsFrom;
  std::map<std::pair<int, std::array<int, 2>>, int> copies;
  const auto copyOf = [&](int tile, const std::array<int, 2>& cell) {
    const auto [place, isNew] = copies.try_emplace({tile, cell}, extended.tiles.size());
    if (isNew) {
      model::Tile copy = model.tiles[tile];
      for (Vector3& vertex : copy.vertices) {
        vertex += cell[0] * lattice.periods[0] + cell[1] * lattice.periods[1];
      }
      extended.tiles.push_back(std::move(copy));
    }
    return place->second;
  };
  for (const BorderJoint& border : lattice.joints) {
    model::Joint joint = border.joint;
    joint.b.tile = copyOf(border.joint.b.tile, border.cell);
    extended.joints.push_back(joint);
  }
  for (const BorderJoint& border : lattice.joints) {
    model::Joint joint = border.joint;
    joint.a.tile = copyOf(border.joint.a.tile, {-border.cell[0], -border.cell[1]});
    extended.joints.push_back(joint);
  }
  return extended;
}

/// The pairs of lines that regions of the cell share with others.
std::vector<TwinLines> twinLines(const writers::NeckOutline& outline,
                                 const std::vector<bool>& isKept,
                                 const std::array<writers::Vector2, 2>& periods, double tolerance) {
  std::map<std::pair<int, int>, std::array<int, 2>> uses;  // by kept regions and by others
  for (std::size_t k = 0; k < isKept.size(); ++k) {
    const std::vector<int>& loop = loopOf(outline, static_cast<int>(k));
    for (std::size_t j = 0; j < loop.size(); ++j) {
      ++uses[std::minmax(loop[j], loop[(j + 1) % loop.size()])][isKept[k] ? 0 : 1];
    }
  }
  std::vector<std::pair<int, int>> cut;
  for (const auto& [line, count] : uses) {
    if (count[0] > 0 && count[1] > 0) cut.push_back(line);
  }
  Eigen::Matrix2d columns;
  columns << periods[0], periods[1];
  std::vector<TwinLines> twins;
  std::vector<bool> isPaired(cut.size());
  for (std::size_t a = 0; a < cut.size(); ++a) {
    for (std::size_t b = a + 1; b < cut.size() && !isPaired[a]; ++b) {
      if (isPaired[b]) continue;
      const auto at = [&](int point) { return outline.points[point]; };
      std::array<int, 2> twin = {cut[b].first, cut[b].second};
      const writers::Vector2 along = at(cut[a].second) - at(cut[a].first);
      if (along.dot(at(twin[1]) - at(twin[0])) < 0) std::swap(twin[0], twin[1]);
      const writers::Vector2 move = at(cut[a].first) - at(twin[0]);
      const Eigen::Vector2d shares = columns.inverse() * move;
      const std::array<int, 2> cell = {static_cast<int>(std::lround(shares[0])),
                                       static_cast<int>(std::lround(shares[1]))};
      const writers::Vector2 whole = cell[0] * periods[0] + cell[1] * periods[1];
      const bool isTwin = (move - whole).norm() <= tolerance &&
                          (at(cut[a].second) - at(twin[1]) - whole).norm() <= tolerance;
      if (!isTwin) continue;
      twins.push_back({{cut[a].first, cut[a].second}, twin, cell});
      isPaired[a] = isPaired[b] = true;
    }
  }
  if (2 * twins.size() != cut.size()) {
    throw InputError(
        "error: --periodic cannot join necks across the border of this sheet: they differ at its "
        "opposite ends; choose other lengths of necks, or a number of tiles in which the sheet "
        "repeats");
  }
  return twins;
}

}  // namespace

writers::NeckOutline meshableOutline(const model::Model& model, const writers::NeckShape& shape) {
  constexpr double kNarrowest = 1e-6;
  writers::NeckOutline outline = writers::neckOutline(model, shape);
  const double size = model::modelSize(model);
  if (model.joints.empty() || outline.neckWidth >= kNarrowest * size) return outline;
  throw InputError(fmt::format(
      "error: necks of {} are too narrow for a sheet of {}; choose a --neck-width of at least {}",
      lengthText(outline.neckWidth, model.unit), lengthText(size, model.unit),
      lengthText(1.1 * kNarrowest * size, model.unit, 2)));
}

ElementMesh makeNeckMesh(const model::Model& model, double thickness, const ElementRule& rule) {
  requireValidRule(rule);
  const writers::NeckOutline outline = meshableOutline(model, rule.neck);
  ElementMesh mesh = meshOf(outline, thickness, rule, model::tileSize(model), {});
  mesh.neckShapes = necksOf(model, thickness, rule.neck);
  return mesh;
}

ElementMesh makePeriodicNeckMesh(const model::Model& model, double thickness,
                                 const ElementRule& rule) {
  if (model.joints.empty()) return makeNeckMesh(model, thickness, rule);
  requireValidRule(rule);
  // Faults of the cell itself are reported for its own tiles.
  meshableOutline(model, rule.neck);
  std::vector<std::vector<Vector3>> tiles;
  for (const model::Tile& tile : model.tiles) tiles.push_back(tile.vertices);
  SheetLattice lattice = findSheetLattice(tiles, model.joints, model.fileOrder.countsFrom);
  const model::Model extended = withNeighbours(model, lattice);
  writers::NeckOutline outline = writers::neckOutline(extended, rule.neck);
  std::vector<bool> isKept(outline.tiles.size() + outline.necks.size());
  const std::size_t joints = model.joints.size() + lattice.joints.size();
  for (std::size_t k = 0; k < isKept.size(); ++k) {
    isKept[k] = k < outline.tiles.size()
                    ? k < model.tiles.size()
                    : outline.neckJoints[k - outline.tiles.size()] < static_cast<int>(joints);
  }
  const auto inPlane = [&](const Vector3& move) {
    return writers::Vector2((outline.sheet.turn * move).head<2>());
  };
  const double tileSize = model::tileSize(model);
  const std::vector<TwinLines> twins = twinLines(
      outline, isKept, {inPlane(lattice.periods[0]), inPlane(lattice.periods[1])}, 1e-4 * tileSize);
  // Only the cell remains.
  std::vector<std::vector<int>> necks;
  for (std::size_t k = 0; k < outline.necks.size(); ++k) {
    if (isKept[outline.tiles.size() + k]) necks.push_back(outline.necks[k]);
  }
  outline.tiles.resize(model.tiles.size());
  outline.edges.resize(model.tiles.size());
  outline.necks = std::move(necks);
  std::vector<bool> isUsed(outline.points.size());
  for (std::size_t k = 0; k < outline.tiles.size() + outline.necks.size(); ++k) {
    for (const int point : loopOf(outline, static_cast<int>(k))) isUsed[point] = true;
  }
  for (std::size_t k = 0; k < isUsed.size(); ++k) {
    outline.isAtNeck[k] = outline.isAtNeck[k] && isUsed[k];
  }
  ElementMesh mesh = meshOf(outline, thickness, rule, tileSize, twins);
  mesh.neckShapes = necksOf(model, thickness, rule.neck);
  if (rule.family == ElementFamily::Plane) {
    for (Vector3& period : lattice.periods) period = outline.sheet.turn * period;
    lattice.axes = outline.sheet.turn.toRotationMatrix() * lattice.axes;
  }
  mesh.lattice = lattice;
  return mesh;
}

}  // namespace kirireel::fea
