// The outline's regions share lines where material continues. Lines of only one region are the
// sides of the sheet. They form closed loops: the outline, and one around each hole. The side after
// the end of another is found by rotating about their common point through all regions that share
// lines there. Loops therefore do not cross at points where they touch.
//
// STL: each region's triangles on both faces, and two triangles per side. The ear with the largest
// minimum angle is cut off first, so no triangle is degenerate although many points are collinear.
//
// STEP: loops are wires of one plane face, which is extruded.
#include "render/fea/neck_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/fea/element_mesh.h"
#include "render/fea/outside_program.h"
#include "sim/base/files.h"

namespace kirireel::fea {
namespace {

using writers::Vector2;

/// Displacement of each side of a slit without kerf, relative to the sheet's size. Both sides stay
/// separate in single precision.
constexpr double kApart = 1e-7;

double sizeOf(const std::vector<Vector2>& points) {
  Eigen::AlignedBox2d box;
  for (const Vector2& point : points) box.extend(point);
  return box.sizes().norm();
}

/// Tiles first, then necks.
std::vector<std::vector<int>> regionsOf(const writers::NeckOutline& outline) {
  std::vector<std::vector<int>> regions = outline.tiles;
  regions.insert(regions.end(), outline.necks.begin(), outline.necks.end());
  return regions;
}

double turnOf(const Vector2& a, const Vector2& b, const Vector2& c) {
  return crossZ(b - a, c - a);
}

/// The smallest angle of a triangle, radians; negative if it runs clockwise.
double smallestAngle(const Vector2& a, const Vector2& b, const Vector2& c) {
  const auto angle = [](const Vector2& p, const Vector2& q, const Vector2& r) {
    return std::atan2(turnOf(p, q, r), (q - p).dot(r - p));
  };
  return std::min({angle(a, b, c), angle(b, c, a), angle(c, a, b)});
}

/// Whether a point lies in an anticlockwise triangle or on its sides.
bool liesIn(const Vector2& a, const Vector2& b, const Vector2& c, const Vector2& point,
            double tolerance) {
  return turnOf(a, b, point) >= -tolerance && turnOf(b, c, point) >= -tolerance &&
         turnOf(c, a, point) >= -tolerance;
}

/// The triangles of a simple anticlockwise loop.
std::vector<std::array<int, 3>> trianglesOfLoop(std::vector<int> loop,
                                                const std::vector<Vector2>& points) {
  std::vector<std::array<int, 3>> triangles;
  const auto at = [&](std::size_t k) { return points[loop[k % loop.size()]]; };
  while (loop.size() >= 3) {
    std::size_t best = 0;
    double widest = -1;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vector2 a = at(k + loop.size() - 1), b = at(k), c = at(k + 1);
      const double angle = smallestAngle(a, b, c);
      if (angle <= widest) continue;
      const double tolerance = 1e-12 * (c - a).squaredNorm();
      bool isFree = true;
      for (std::size_t j = 0; j < loop.size() && isFree; ++j) {
        const bool isCorner =
            j == k || j == (k + 1) % loop.size() || j == (k + loop.size() - 1) % loop.size();
        isFree = isCorner || !liesIn(a, b, c, at(j), tolerance);
      }
      if (!isFree && loop.size() > 3) continue;
      widest = angle;
      best = k;
    }
    const std::size_t count = loop.size();
    triangles.push_back({loop[(best + count - 1) % count], loop[best], loop[(best + 1) % count]});
    loop.erase(loop.begin() + static_cast<std::ptrdiff_t>(best));
  }
  return triangles;
}

/// A line of a region.
struct OutlineSide {
  int region = 0;  ///< zero-based
  int line = 0;    ///< from point `line` of the region's loop to the next
};

/// The region and the position of each line. The keys are its two points, in the region's order.
std::map<std::pair<int, int>, OutlineSide> linesOf(const std::vector<std::vector<int>>& regions) {
  std::map<std::pair<int, int>, OutlineSide> lines;
  for (int r = 0; r < static_cast<int>(regions.size()); ++r) {
    const std::vector<int>& loop = regions[r];
    for (int k = 0; k < static_cast<int>(loop.size()); ++k) {
      lines[{loop[k], loop[(k + 1) % loop.size()]}] = {r, k};
    }
  }
  return lines;
}

/// The sides of the sheet in closed loops of points; anticlockwise around the outline.
std::vector<std::vector<int>> boundaryLoops(const std::vector<std::vector<int>>& regions) {
  const auto lines = linesOf(regions);
  std::map<std::pair<int, int>, bool> isDone;
  std::vector<std::vector<int>> loops;
  for (const auto& [first, unused] : lines) {
    if (lines.contains({first.second, first.first}) || isDone[first]) continue;
    std::vector<int>& loop = loops.emplace_back();
    for (std::pair<int, int> line = first; !isDone[line];) {
      isDone[line] = true;
      loop.push_back(line.first);
      // The next line of the region. If another region shares it, the line after its twin.
      const auto after = [&](const OutlineSide& side) {
        const std::vector<int>& own = regions[side.region];
        const std::size_t next = (side.line + 1) % own.size();
        return std::pair{own[next], own[(next + 1) % own.size()]};
      };
      line = after(lines.at(line));
      for (auto twin = lines.find({line.second, line.first}); twin != lines.end();
           twin = lines.find({line.second, line.first})) {
        line = after(twin->second);
      }
    }
  }
  return loops;
}

/// An OpenCASCADE geometry: loops of points are wires of plane faces, which are extruded.
class StepGeometry {
 public:
  /// Adds a wire through these points, metres. Returns its number.
  int addLoop(const std::vector<Vector3>& points) {
    const int firstPoint = point_, firstLine = line_, count = static_cast<int>(points.size());
    std::string numbers;
    for (const Vector3& point : points) {
      const Vector3 at = inUnit(point, millimetre());
      appendText(text_, "Point({}) = {{{}, {}, {}}};\n", ++point_, at.x(), at.y(), at.z());
    }
    for (int k = 0; k < count; ++k) {
      appendText(text_, "Line({}) = {{{}, {}}};\n", ++line_, firstPoint + k + 1,
                 firstPoint + (k + 1) % count + 1);
      appendText(numbers, "{}{}", k > 0 ? ", " : "", line_);
    }
    appendText(text_, "Curve Loop({}) = {{{}}};\n", firstLine + 1, numbers);
    return firstLine + 1;
  }

  /// The solid between the face within these loops, the outside first, and the same moved.
  void addSolid(const std::vector<int>& loops, const Vector3& move) {
    const Vector3 up = inUnit(move, millimetre());
    extrusions_ += fmt::format("Extrude {{{}, {}, {}}} {{ Surface{{{}}}; }}\n", up.x(), up.y(),
                               up.z(), ++face_);
    appendText(text_, "Plane Surface({}) = {{{}}};\n", face_, fmt::join(loops, ", "));
  }

  std::string text() const { return "SetFactory(\"OpenCASCADE\");\n" + text_ + extrusions_; }

 private:
  std::string text_;
  std::string extrusions_;  ///< at the end, because they make lines and faces with new numbers
  int point_ = 0;
  int line_ = 0;
  int face_ = 0;
};

/// Points of an outline, with coinciding points separated by this distance into the sheet. `loops`
/// are its sides, with the sheet on their left.
std::vector<Vector2> separatedPoints(const writers::NeckOutline& outline,
                                     const std::vector<std::vector<int>>& loops, double move) {
  std::vector<Vector2> inwards(outline.points.size(), Vector2::Zero());
  std::vector<int> used;
  for (const std::vector<int>& loop : loops) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const auto at = [&](std::size_t other) { return outline.points[loop[other % loop.size()]]; };
      // The tangent of both lines at the point, which also has a left side at reflex corners.
      const Vector2 along =
          (at(k + 1) - at(k)).normalized() + (at(k) - at(k + loop.size() - 1)).normalized();
      used.push_back(loop[k]);
      inwards[loop[k]] += Vector2(-along.y(), along.x());
    }
  }
  const auto key = [&](int point) {
    return std::pair(outline.points[point].x(), outline.points[point].y());
  };
  std::ranges::sort(used, [&](int a, int b) { return key(a) < key(b); });
  std::vector<Vector2> points = outline.points;
  // Coinciding points differ by rounding, so neighbours in sorted order are compared.
  for (std::size_t a = 0; a < used.size(); ++a) {
    for (std::size_t b = a + 1; b < used.size(); ++b) {
      const Vector2 apart = outline.points[used[b]] - outline.points[used[a]];
      if (apart.x() > move) break;
      if (used[a] == used[b] || apart.norm() > move) continue;
      for (const int point : {used[a], used[b]}) {
        points[point] = outline.points[point] + move * inwards[point].normalized();
      }
    }
  }
  return points;
}

}  // namespace

std::string neckSheetStl(const model::Model& model, const writers::NeckShape& neck,
                         double thickness, const LengthUnit& unit) {
  const writers::NeckOutline outline = meshableOutline(model, neck);
  const std::vector<std::vector<int>> regions = regionsOf(outline);
  const auto lines = linesOf(regions);
  const std::vector<Vector2> points =
      separatedPoints(outline, boundaryLoops(regions), kApart * sizeOf(outline.points));
  const Quaternion back = outline.sheet.turn.conjugate();
  const auto place = [&](int point, bool isTop) {
    const Vector2& at = points[point];
    const double height = outline.sheet.height + (isTop ? thickness : 0);
    return inUnit(Vector3(back * Vector3(at.x(), at.y(), height)), unit);
  };
  std::string text = "solid sheet\n";
  const auto append = [&text](const Vector3& a, const Vector3& b, const Vector3& c) {
    const Vector3 normal = (b - a).cross(c - a).normalized();
    appendText(text, "facet normal {} {} {}\nouter loop\n", normal.x(), normal.y(), normal.z());
    for (const Vector3& at : {a, b, c}) {
      appendText(text, "vertex {} {} {}\n", at.x(), at.y(), at.z());
    }
    text += "endloop\nendfacet\n";
  };
  for (const std::vector<int>& loop : regions) {
    for (const auto& [a, b, c] : trianglesOfLoop(loop, points)) {
      append(place(a, false), place(c, false), place(b, false));
      append(place(a, true), place(b, true), place(c, true));
    }
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const int a = loop[k], b = loop[(k + 1) % loop.size()];
      if (lines.contains({b, a})) continue;
      append(place(a, false), place(b, false), place(b, true));
      append(place(a, false), place(b, true), place(a, true));
    }
  }
  return text + "endsolid sheet\n";
}

std::string neckSheetStep(const model::Model& model, const writers::NeckShape& neck,
                          double thickness) {
  const writers::NeckOutline outline = meshableOutline(model, neck);
  const Quaternion back = outline.sheet.turn.conjugate();
  const std::vector<std::vector<int>> sides = boundaryLoops(regionsOf(outline));
  const std::vector<Vector2> points =
      separatedPoints(outline, sides, kApart * sizeOf(outline.points));
  StepGeometry geometry;
  std::vector<int> loops;
  for (const std::vector<int>& loop : sides) {
    std::vector<Vector3> wire;
    double area = 0;
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const Vector2& flat = points[loop[k]];
      wire.emplace_back(back * Vector3(flat.x(), flat.y(), outline.sheet.height));
      area += turnOf(outline.points[loop[0]], flat, points[loop[(k + 1) % loop.size()]]);
    }
    // Holes are clockwise; the outline comes first.
    loops.insert(area > 0 ? loops.begin() : loops.end(), geometry.addLoop(wire));
  }
  geometry.addSolid(loops, back * Vector3(0, 0, thickness));
  return stepByGmsh(geometry.text());
}

std::string brickStep(const std::vector<brick::Brick>& bricks, const Poses& poses) {
  StepGeometry geometry;
  for (std::size_t t = 0; t < bricks.size(); ++t) {
    std::vector<Vector3> wire;
    for (const Vector3& point : bricks[t].bottom) wire.push_back(poses[t].apply(point));
    const int loop = geometry.addLoop(wire);
    geometry.addSolid({loop}, poses[t].rotation * (bricks[t].thickness * bricks[t].normal));
  }
  return stepByGmsh(geometry.text());
}

}  // namespace kirireel::fea
