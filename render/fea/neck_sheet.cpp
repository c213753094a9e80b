// The outline's regions become surfaces that share lines where tiles and necks meet: Gmsh
// makes one mesh of them; the sides of a slit are lines of their own. It stays open. All
// cells are quadrilaterals: Gmsh pairs triangles to quadrilaterals and then divides each cell into
// quadrilaterals of half its size. At a distance d from the necks their size is
//
//     h(d) = clamp(h_neck + 0.25 (d - w / 2), h_neck, h_tile),   h_neck = w / 6, h_tile = size / 8,
//
// and at a distance d from their corners, where stresses are singular, at most h_neck / 8 + 0.25 d;
// all in proportion to the number of elements per edge, for linear elements half as much.
//
// Shells are finer along the straight ends of the sheet too, h_tile / 4 + 0.25 d, where they are
// clamped: CalculiX expands a shell to solids, whose thickness cannot change with bending where all
// of an edge is held, and it recovers over one element. A strip as wide as that element is too
// stiff, by which a clamped square plate of 8 elements per edge sinks 5% too little.
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/format.h>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "render/fea/outside_program.h"
#include "sim/base/error.h"

namespace kirireel::fea {
namespace {

constexpr double kAcrossNeck = 6;  ///< elements, at the usual number per edge
constexpr double kFinerAtCorners = 8;
constexpr double kFinerAtEnds = 4;  ///< of shells
/// Metres of element size a metre of distance.
constexpr double kMeshGrowth = 0.25;

/// Quadrilaterals by region: tiles first, then necks.
struct RegionMesh {
  std::vector<writers::Vector2> points;
  std::vector<std::array<int, 4>> cells;
  std::vector<std::size_t> firstCell;  ///< of each region, and the number of cells at the end
};

/// Lines between points, each once, and how often regions use them. A line that a tile and a neck
/// share has one number, with a sign for its direction, as Gmsh's curve loops want it. That makes
/// the mesh one piece there.
class OutlineLines {
 public:
  /// The signed number of a line, from 1. Negative where the line was first named, or is kept, the
  /// other way round.
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

/// Points along the lines of necks, close enough for distances to the necks. Distance fields are
/// given points, so lines are sampled every quarter of the neck's width.
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

/// Points along those lines of the outline that lie on a side of the box round it, so far apart.
std::vector<writers::Vector2> pointsOnEnds(const writers::NeckOutline& outline, double spacing) {
  constexpr double kSamePlane = 1e-6;  // of the sheet's size
  Eigen::AlignedBox2d box;
  for (const writers::Vector2& point : outline.points) box.extend(point);
  const double tolerance = kSamePlane * box.sizes().norm();
  const auto isOnSide = [&](const writers::Vector2& a, const writers::Vector2& b) {
    for (int axis = 0; axis < 2; ++axis) {
      for (const double side : {box.min()[axis], box.max()[axis]}) {
        const double farthest = std::max(std::abs(a[axis] - side), std::abs(b[axis] - side));
        if (farthest <= tolerance) return true;
      }
    }
    return false;
  };
  std::vector<writers::Vector2> points;
  for (const std::vector<int>& tile : outline.tiles) {
    for (std::size_t k = 0; k < tile.size(); ++k) {
      const writers::Vector2& from = outline.points[tile[k]];
      const writers::Vector2& to = outline.points[tile[(k + 1) % tile.size()]];
      if (!isOnSide(from, to)) continue;
      const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / spacing)));
      for (int j = 0; j <= count; ++j) points.emplace_back(from + (to - from) * j / count);
    }
  }
  return points;
}

/// Points near which elements are smaller than elsewhere.
struct FineZone {
  std::vector<writers::Vector2> points;
  double size = 0;  ///< of elements at the points, metres
  double from = 0;  ///< the distance from which on elements grow, metres
};

/// How large elements are, in metres.
struct CellSizes {
  double most = 0;  ///< far from all zones
  std::vector<FineZone> zones;
};

CellSizes cellSizes(const writers::NeckOutline& outline, const ElementRule& rule, double tileSize) {
  const double perEdge = rule.perEdge > 0 ? rule.perEdge
                         : rule.size > 0  ? tileSize / rule.size
                                          : kUsualPerEdge;
  const double linear = rule.quadratic ? 1 : 0.5;
  const double atNecks = linear * outline.neckWidth / kAcrossNeck * kUsualPerEdge / perEdge;
  CellSizes sizes;
  // Far from necks elements are never smaller than at necks.
  sizes.most = std::max(linear * tileSize / perEdge, atNecks);
  // Corners where a neck begins and ends of slits are singular: much finer there.
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
    sizes.zones.push_back({pointsOnEnds(outline, atEnds), atEnds, 0});
  }
  return sizes;
}

/// Gmsh's fields: for each zone the distance to its points, which count from `firstPoint`, and
/// sizes that grow with it; the least of them holds. Gmsh halves sizes when it divides the cells.
void appendSizes(std::string& text, const CellSizes& sizes, std::size_t firstPoint) {
  int field = 0;
  std::string thresholds;
  for (const FineZone& zone : sizes.zones) {
    // Two fields a zone: a distance, and a threshold that maps it to a size, SizeMin up to DistMin,
    // rising linearly to SizeMax at DistMax.
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

/// Reads what Gmsh wrote: nodes, and quadrilaterals whose first tag is their region. MSH 2.2 in
/// ASCII: after $Nodes a count and rows "number x y z"; after $Elements a count and rows "number
/// kind tags tag... node...". The first tag is the physical group, which neckGeometry numbers as
/// the region, from 1. Kind 3 is a quadrilateral of four nodes.
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
        // Any other kind would be a triangle that Gmsh left over, or a region that it did not name.
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

/// All cells anticlockwise, for any orientation in Gmsh, and no points that no cell uses. The
/// cross product of the diagonals is twice the signed area.
void tidy(RegionMesh& mesh) {
  std::vector<int> numbers(mesh.points.size(), -1);
  std::vector<writers::Vector2> used;
  for (std::array<int, 4>& cell : mesh.cells) {
    const auto at = [&](int k) { return mesh.points[cell[k]]; };
    const writers::Vector2 a = at(2) - at(0);
    const writers::Vector2 b = at(3) - at(1);
    if (a.x() * b.y() - a.y() * b.x() < 0) std::swap(cell[1], cell[3]);
    for (const int point : cell) {
      if (numbers[point] >= 0) continue;
      // Points are numbered in the order in which cells name them: samples of fields, which Gmsh
      // keeps as nodes, belong to no cell and vanish.
      numbers[point] = static_cast<int>(used.size());
      used.push_back(mesh.points[point]);
    }
  }
  for (std::array<int, 4>& cell : mesh.cells) {
    for (int& point : cell) point = numbers[point];
  }
  mesh.points = std::move(used);
}

/// The sides of cells that no other cell has, by region; their cells count from the region's first.
/// These are the outside of the sheet and both banks of each slit; tileEdge is -1, since outlines
/// have fillets and no edges of tiles.
std::vector<std::vector<FootprintSide>> freeSides(const RegionMesh& mesh) {
  std::map<std::pair<int, int>, int> uses;
  const auto sideOf = [](const std::array<int, 4>& cell, int k) {
    return std::pair<int, int>(std::minmax(cell[k], cell[(k + 1) % 4]));
  };
  for (const auto& cell : mesh.cells) {
    for (int k = 0; k < 4; ++k) ++uses[sideOf(cell, k)];
  }
  std::vector<std::vector<FootprintSide>> sides(mesh.firstCell.size() - 1);
  for (std::size_t region = 0; region < sides.size(); ++region) {
    for (std::size_t c = mesh.firstCell[region]; c < mesh.firstCell[region + 1]; ++c) {
      for (int k = 0; k < 4; ++k) {
        if (uses[sideOf(mesh.cells[c], k)] > 1) continue;
        sides[region].push_back({static_cast<int>(c - mesh.firstCell[region]), k, -1});
      }
    }
  }
  return sides;
}

/// The points at each level, in the world; plane elements in the plane z = 0. The outline was laid
/// flat by `sheet.turn`; its conjugate takes points back to the model's axes.
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
                         double tileSize) {
  std::string text = "// A sheet with necks, by Kirireel. Metres.\n";
  const auto appendPoint = [&](std::size_t number, const writers::Vector2& at) {
    appendText(text, "Point({}) = {{{}, {}, 0, 1}};\n", number, at.x(), at.y());
  };
  for (std::size_t k = 0; k < outline.points.size(); ++k) appendPoint(k + 1, outline.points[k]);
  const CellSizes sizes = cellSizes(outline, rule, tileSize);
  // Points of the outline are 1 to n; samples of the size fields follow.
  const std::size_t firstSample = outline.points.size() + 1;
  std::size_t sample = firstSample;
  for (const FineZone& zone : sizes.zones) {
    for (const writers::Vector2& point : zone.points) appendPoint(sample++, point);
  }
  OutlineLines lines;
  std::string surfaces;
  int region = 0;
  // Regions count through tiles, then necks, and so do surfaces and physical groups.
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
    appendText(text, "Line({}) = {{{}, {}}};\n", k + 1, lines.ends()[k].first + 1,
               lines.ends()[k].second + 1);
  }
  text += surfaces;
  appendSizes(text, sizes, firstSample);
  return text;
}

namespace {

std::vector<MeshNeck> necksOf(const model::Model& model, double thickness,
                              const writers::NeckShape& shape) {
  const std::vector<model::Brick> bricks = model::makeBricks(model.tiles, {.thickness = thickness});
  const auto at = [&](const model::Corner& corner) {
    return model::neckCorner(bricks[static_cast<std::size_t>(corner.tile)], corner.vertex);
  };
  std::vector<MeshNeck> necks;
  for (const model::Joint& joint : model.joints) {
    necks.push_back({{at(joint.a), at(joint.b)}, writers::shapeAt(joint, shape)});
  }
  return necks;
}

}  // namespace

ElementMesh makeNeckMesh(const model::Model& model, double thickness, const ElementRule& rule) {
  requireValidRule(rule);
  const writers::NeckOutline outline = writers::neckOutline(model, rule.neck);
  const std::size_t regions = outline.tiles.size() + outline.necks.size();
  RegionMesh region =
      readMesh(meshedByGmsh(neckGeometry(outline, rule, model::tileSize(model))), regions);
  tidy(region);
  ElementMesh mesh;
  mesh.rule = rule;
  mesh.neckShapes = necksOf(model, thickness, rule.neck);
  PrismLayers layers(mesh, region.cells, levelsOf(region, outline.sheet, thickness, rule));
  const std::vector<std::vector<FootprintSide>> sides = freeSides(region);
  for (std::size_t k = 0; k < regions; ++k) {
    const std::size_t first = region.firstCell[k];
    TileElements part = layers.append(first, region.firstCell[k + 1] - first, sides[k]);
    // The same order as in neckGeometry.
    (k < outline.tiles.size() ? mesh.tiles : mesh.necks).push_back(std::move(part));
  }
  return mesh;
}

}  // namespace kirireel::fea
