// A planar start is rotated to face +z: q n = z with the normal n of the sheet, on the side of tile
// 0. Then z is dropped.
//
// The gap angle at a corner is measured anticlockwise from the reversed edge that arrives there
// (first tile) to the edge that leaves (second tile), 0 to 2 pi. Exchanging the tiles gives the
// other gap of the joint.
#include "render/writers/flat_sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/brick/stiffness.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::writers {
namespace {

[[noreturn]] void refuseFolded(const model::Model& model) {
  const Vector3& origin = model.tiles[0].vertices[0];
  const Vector3 normal = model::tileNormal(model.tiles[0]);
  std::size_t farthest = 0;
  double height = 0;
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    for (const Vector3& vertex : model.tiles[t].vertices) {
      const double reached = std::abs((vertex - origin).dot(normal));
      if (reached <= height) continue;
      height = reached;
      farthest = t;
    }
  }
  const auto first = static_cast<std::size_t>(model.fileOrder.countsFrom);
  throw InputError(
      fmt::format("error: the start is not flat: tile {} reaches {} out of "
                  "the plane of tile {}; only planar models have a cut pattern",
                  first + farthest, lengthText(height, model.unit), first));
}

/// The normal of a flat start on the side of tile 0, where all tiles must face.
Vector3 commonNormal(const model::Model& model) {
  if (!model::sheetFrame(model)) refuseFolded(model);
  Vector3 normal = model::meanNormal(model.tiles, model::tileNormal(model.tiles[0]));
  if (model::tileNormal(model.tiles[0]).dot(normal) < 0) normal = -normal;
  const auto first = static_cast<std::size_t>(model.fileOrder.countsFrom);
  for (std::size_t t = 0; t < model.tiles.size(); ++t) {
    if (model::tileNormal(model.tiles[t]).dot(normal) > 0) continue;
    throw InputError(
        fmt::format("error: tile {} faces the other way than tile {}; a cut pattern "
                    "needs all tiles on one side: reverse its vertices",
                    first + t, first));
  }
  return normal;
}

/// Rounding can make the angle of a closed gap slightly negative. It counts as 0 and not as a full
/// turn.
CornerGap gapBetween(const std::vector<FlatTile>& tiles, const model::Corner& a,
                     const model::Corner& b) {
  const int sides = static_cast<int>(tiles[a.tile].size());
  CornerGap gap;
  gap.first = {a.tile, (a.vertex + sides - 1) % sides, false};
  gap.second = {b.tile, b.vertex, true};
  const Vector2 from = directionFrom(tiles, gap.first);
  const Vector2 to = directionFrom(tiles, gap.second);
  gap.angle = std::atan2(crossZ(from, to), from.dot(to));
  if (gap.angle < -kClosedAngle) gap.angle += 2 * std::numbers::pi;
  gap.angle = std::max(gap.angle, 0.0);
  return gap;
}

/// The shortest rotation of a unit normal to z. A sheet that faces down is turned over about x.
Quaternion rotateUp(const Vector3& normal) {
  const Vector3 axis = normal.cross(Vector3::UnitZ());
  const double sine = axis.norm();
  const double angle = std::atan2(sine, normal.z());
  return rotationFromVector(sine > 0 ? Vector3(angle / sine * axis)
                                     : Vector3(angle * Vector3::UnitX()));
}

}  // namespace

FlatSheet flatSheet(const model::Model& model) {
  FlatSheet sheet;
  sheet.turn = rotateUp(commonNormal(model));
  sheet.height = (sheet.turn * model.tiles[0].vertices[0]).z();
  for (const model::Tile& tile : model.tiles) {
    FlatTile& flat = sheet.tiles.emplace_back();
    for (const Vector3& vertex : tile.vertices) flat.push_back((sheet.turn * vertex).head<2>());
  }
  return sheet;
}

void requirePivot(const model::Joint& joint, std::size_t number) {
  if (joint.kind == model::JointKind::Pivot) return;
  throw InputError(fmt::format(
      "error: joint {} does not join two corners; a cut pattern has hinges only at corners",
      number));
}

CornerGap narrowGap(const std::vector<FlatTile>& tiles, const model::Joint& joint) {
  const CornerGap ahead = gapBetween(tiles, joint.a, joint.b);
  const CornerGap behind = gapBetween(tiles, joint.b, joint.a);
  return ahead.angle <= behind.angle ? ahead : behind;
}

Vector2 directionFrom(const std::vector<FlatTile>& tiles, const EdgeEnd& end) {
  const FlatTile& tile = tiles[end.tile];
  const Vector2 along = (tile[(end.edge + 1) % tile.size()] - tile[end.edge]).normalized();
  return end.atStart ? along : Vector2(-along);
}

// ------------------------------------------------------------------------------------------------
// Converts a planar start to lines for a cutter:
//
// - 1. At each joint a hinge of material remains. The narrower gap between the two tiles has the
//   angle g. The cut along its edges ends at t = w / cos(g / 2) before the joint. The neck across
//   the gap's bisector then has the width w (hinge width, metres). An open gap gets a cut across
//   its end.
// - 2. Each edge is shortened by the largest t of the joints at its ends.
// - 3. Coinciding edges of two tiles are one slit, drawn once. They are found by their middles in a
//   grid whose cells are as wide as the tolerance (1e-4 of the tile size), with a search of 3 x 3
//   cells.
//
// SVG is in millimetres with y down. DXF is ASCII R12 (AC1009; Autodesk, DXF Reference), pairs of
// lines with a group code and a value: 0 begins an entity, 8 is its layer, 10/20 and 11/21 are its
// ends, 62 a colour, $INSUNITS the unit. R12 needs no tables of handles.

namespace {

constexpr double kSameRounded = 4;     ///< last decimal places within which they do, too
constexpr double kHingeOfTile = 0.05;  ///< default width of a hinge

/// Shortening of edges at their ends relative to the model, metres.
using Trims = std::map<EdgeEnd, double>;

/// 0 at ends without a joint.
double trimAt(const Trims& trims, const EdgeEnd& end) {
  const auto found = trims.find(end);
  return found == trims.end() ? 0 : found->second;
}

/// Works in the sheet's plane; all lengths in metres.
class PatternMaker {
 public:
  PatternMaker(const model::Model& model, std::optional<double> hingeWidth)
      : tiles_(flatSheet(model).tiles),
        first_(model.fileOrder.countsFrom),
        unit_(model.unit),
        width_(hingeWidth),
        defaultWidth_(kHingeOfTile * model::tileSize(model)),
        rounded_(kSameRounded * model.rounding),
        same_(std::max(kClosedAngle * model::tileSize(model), rounded_)) {
    for (std::size_t j = 0; j < model.joints.size(); ++j) addHinge(model.joints[j], j);
    addEdges();
  }

  std::vector<PatternLine> take() { return std::move(lines_); }

 private:
  int sides(int tile) const { return static_cast<int>(tiles_[tile].size()); }
  int after(int tile, int k) const { return (k + 1) % sides(tile); }

  const Vector2& corner(const model::Corner& c) const { return tiles_[c.tile][c.vertex]; }

  void addHinge(const model::Joint& joint, std::size_t number) {
    requirePivot(joint, static_cast<std::size_t>(first_) + number);
    const CornerGap gap = narrowGap(tiles_, joint);
    const double width = width_.value_or(joint.neck ? joint.neck.width : defaultWidth_);
    const double trim = width / std::cos(gap.angle / 2);
    const Vector2 middle = 0.5 * (corner(joint.a) + corner(joint.b));
    const Vector2 ends[] = {middle + trim * directionFrom(tiles_, gap.first),
                            middle + trim * directionFrom(tiles_, gap.second)};
    for (const EdgeEnd& end : {gap.first, gap.second}) {
      double& kept = trims_[end];
      kept = std::max(kept, trim);
    }
    widest_ = std::max(widest_, width);
    lines_.push_back({PatternLayer::Hinges, middle, 0.5 * (ends[0] + ends[1])});
    if (gap.angle > kClosedAngle) lines_.push_back({PatternLayer::Cuts, ends[0], ends[1]});
  }

  /// The coinciding edge of another tile, with opposite direction; found by its middle. Edges that
  /// have opened by more than kClosedAngle are two lines, however short they are.
  std::optional<std::pair<int, int>> twinOf(int tile, int edge) const {
    const Vector2 from = tiles_[tile][edge];
    const Vector2 to = tiles_[tile][after(tile, edge)];
    const double same = std::clamp(kClosedAngle * (to - from).norm(), rounded_, same_);
    const auto [column, row] = cellOf(0.5 * (from + to));
    for (long x = column - 1; x <= column + 1; ++x) {
      for (long y = row - 1; y <= row + 1; ++y) {
        const auto [first, last] = edges_.equal_range({x, y});
        for (auto found = first; found != last; ++found) {
          const auto [t, e] = found->second;
          if (t == tile) continue;
          const bool isSame =
              (tiles_[t][e] - to).norm() <= same && (tiles_[t][after(t, e)] - from).norm() <= same;
          if (isSame) return found->second;
        }
      }
    }
    return std::nullopt;
  }

  std::pair<long, long> cellOf(const Vector2& point) const {
    return {std::lround(point.x() / same_), std::lround(point.y() / same_)};
  }

  void addEdges() {
    const int count = static_cast<int>(tiles_.size());
    for (int t = 0; t < count; ++t) {
      for (int e = 0; e < sides(t); ++e) {
        const Vector2 middle = 0.5 * (tiles_[t][e] + tiles_[t][after(t, e)]);
        edges_.emplace(cellOf(middle), std::pair{t, e});
      }
    }
    for (int t = 0; t < count; ++t) {
      for (int e = 0; e < sides(t); ++e) addEdge(t, e);
    }
  }

  void addEdge(int tile, int edge) {
    const auto twin = twinOf(tile, edge);
    if (twin && twin->first < tile) return;  // drawn with its twin
    double atStart = trimAt(trims_, {tile, edge, true});
    double atEnd = trimAt(trims_, {tile, edge, false});
    if (twin) {
      atStart = std::max(atStart, trimAt(trims_, {twin->first, twin->second, false}));
      atEnd = std::max(atEnd, trimAt(trims_, {twin->first, twin->second, true}));
    }
    const Vector2 from = tiles_[tile][edge];
    const Vector2 to = tiles_[tile][after(tile, edge)];
    const double length = (to - from).norm();
    if (atStart + atEnd >= length) {
      throw InputError(fmt::format(
          "error: hinges {} wide leave nothing to cut of edge {} of tile "
          "{}, {} long; choose a smaller --hinge-width",
          lengthText(widest_, unit_, 6), first_ + edge, first_ + tile, lengthText(length, unit_)));
    }
    const Vector2 along = (to - from) / length;
    lines_.push_back({twin ? PatternLayer::Slits : PatternLayer::Cuts, from + atStart * along,
                      to - atEnd * along});
  }

  std::vector<FlatTile> tiles_;
  int first_;                    ///< number of tiles, edges and joints in messages
  LengthUnit unit_;              ///< of lengths in messages
  std::optional<double> width_;  ///< of all hinges
  double defaultWidth_;          ///< of joints without a neck
  double widest_ = 0;            ///< of all hinges so far
  double rounded_;               ///< metres within which rounded points coincide
  double same_;                  ///< metres within which ends of the longest edges coincide
  Trims trims_;
  std::multimap<std::pair<long, long>, std::pair<int, int>> edges_;  ///< by their middles
  std::vector<PatternLine> lines_;
};

/// The style of a layer.
struct LayerStyle {
  PatternLayer layer;
  const char* name;
  const char* svgStyle;
  int dxfColour;
};

constexpr LayerStyle kLayerStyles[] = {
    {PatternLayer::Cuts, "cuts", "stroke=\"#d00000\"", 1},
    {PatternLayer::Slits, "slits", "stroke=\"#0000d0\"", 5},
    {PatternLayer::Hinges, "hinges", "stroke=\"#008000\"", 3},
};

}  // namespace

std::vector<PatternLine> cutPattern(const model::Model& model, std::optional<double> hingeWidth) {
  if (hingeWidth && !(*hingeWidth > 0)) {
    throw InputError(
        fmt::format("error: hinges cannot be {} wide; give a positive --hinge-width, "
                    "or the sheet falls apart",
                    lengthText(*hingeWidth, model.unit, 6)));
  }
  return PatternMaker(model, hingeWidth).take();
}

std::string patternSvg(const std::vector<PatternLine>& lines) {
  constexpr double kMillimetres = 1000;
  constexpr double kMargin = 5;
  constexpr double kStrokesAcross = 2000;
  Eigen::AlignedBox2d box;
  for (const PatternLine& line : lines) box.extend(line.from).extend(line.to);
  const Vector2 size = kMillimetres * box.sizes() + Vector2::Constant(2 * kMargin);
  // Hairlines when scaled to fit a cutter, still visible before.
  const double stroke = size.maxCoeff() / kStrokesAcross;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" "
      "viewBox=\"0 0 {0} {1}\">\n",
      size.x(), size.y());
  // SVG's y runs down.
  const auto x = [&](const Vector2& p) { return kMargin + kMillimetres * (p.x() - box.min().x()); };
  const auto y = [&](const Vector2& p) { return kMargin + kMillimetres * (box.max().y() - p.y()); };
  for (const LayerStyle& style : kLayerStyles) {
    text += fmt::format("<g id=\"{}\" fill=\"none\" stroke-width=\"{}\" {}>\n", style.name, stroke,
                        style.svgStyle);
    for (const PatternLine& line : lines) {
      if (line.layer != style.layer) continue;
      text += fmt::format("<path d=\"M {} {} L {} {}\"/>\n", x(line.from), y(line.from), x(line.to),
                          y(line.to));
    }
    text += "</g>\n";
  }
  return text + "</svg>\n";
}

std::string patternDxf(const std::vector<PatternLine>& lines, const LengthUnit& unit) {
  std::string text = fmt::format(
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n"
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n3\n",
      unit.dxfNumber);
  for (const LayerStyle& style : kLayerStyles) {
    text +=
        fmt::format("0\nLAYER\n2\n{}\n70\n0\n62\n{}\n6\nCONTINUOUS\n", style.name, style.dxfColour);
  }
  text += "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
  for (const PatternLine& line : lines) {
    const LayerStyle& style = kLayerStyles[static_cast<int>(line.layer)];
    text += fmt::format("0\nLINE\n8\n{}\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", style.name,
                        inUnit(line.from.x(), unit), inUnit(line.from.y(), unit),
                        inUnit(line.to.x(), unit), inUnit(line.to.y(), unit));
  }
  return text + "0\nENDSEC\n0\nEOF\n";
}

// ------------------------------------------------------------------------------------------------
// OBJ in PyKirigami's format: "v x y z" for every corner of every tile, an empty line, "f 1 2 3 4"
// for every tile, one-based.

std::string planarObjText(const std::vector<model::Tile>& tiles) {
  std::size_t vertices = 0;
  for (const model::Tile& tile : tiles) vertices += tile.vertices.size();
  std::string text = fmt::format("# {} vertices {} faces\n", vertices, tiles.size());
  for (const model::Tile& tile : tiles) {
    for (const Vector3& v : tile.vertices) appendText(text, "v {} {} {}\n", v.x(), v.y(), v.z());
  }
  text += "\n";
  std::size_t next = 1;
  for (const model::Tile& tile : tiles) {
    text += "f";
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) appendText(text, " {}", next++);
    text += "\n";
  }
  return text;
}

// ------------------------------------------------------------------------------------------------
// Each joint has its own axes: the joint at the origin, the bisector of the narrower gap up (y),
// one tile on the right (x > 0) and the other mirrored on the left. With half the gap's angle h,
// the angle b of the tile's lower edge from the bisector and half the kerf i, the tile's edges are
// the lines
//
//     upper: x cos h - y sin h = i,    lower: y sin b - x cos b = i  (angles from the bisector).
//
// A neck of length l and width w is the strip |x| <= l / 2, y0 <= y <= y0 + w. y0 is -w / 2, lower
// if the tiles end too soon above, and never below the height at which both have begun. If a tile
// extends into |x| < l / 2 above or below the strip, a slot is cut out of it. Its depth is the
// maximum of width, radius and kerf. Fillets are quarter circles of six lines each.
//
// A chain of points replaces a corner of a tile in its outline. The remaining parts of edges
// connect the chains of neighbouring corners. A common point of tile and neck is one point, so Gmsh
// makes one mesh.
//
// A shape that does not fit throws Misfit with the length that is too large. The message then
// suggests a value that fits, found by bisection in twelve steps. Each step makes the whole
// outline.

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kShortestLine = 1e-9;  ///< of the tile size: shorter lines are left out
constexpr int kArcLines = 6;            ///< per quarter circle

/// Fault of a shape, with its location. Caught only within this file.
struct Misfit {
  enum Kind { TooWide, TooShort, TooRound } kind = TooWide;
  std::string where;
  NeckShape shape;  ///< of the neck, or of the widest of several possible ones
};

/// Position of a tile at a joint: the gap's bisector is up (y), the tile on the right (x > 0). Its
/// two edges are straight lines, moved inwards by half the kerf.
struct Wedge {
  double half = 0;    ///< of the gap, radians: from the bisector to the upper edge
  double lowest = 0;  ///< from the bisector to the lower edge
  double inset = 0;   ///< half the kerf

  /// Range of heights of the tile at this x.
  double top(double x) const {
    const double sine = std::sin(half);
    return sine < kClosedAngle ? kInfinite : (x * std::cos(half) - inset) / sine;
  }
  double bottom(double x) const {
    const double sine = std::sin(lowest);
    return sine < kClosedAngle || lowest > std::numbers::pi ? -kInfinite
                                                            : (inset + x * std::cos(lowest)) / sine;
  }

  /// Positions of its edges at this height.
  double upperEdge(double y) const { return (inset + y * std::sin(half)) / std::cos(half); }
  double lowerEdge(double y) const { return (y * std::sin(lowest) - inset) / std::cos(lowest); }
};

/// The lines of a tile near one neck, in the joint's axes, from the upper edge to the lower.
struct NeckEnd {
  std::vector<Vector2> above;  ///< the slot above
  Vector2 high;                ///< common line of tile and neck
  Vector2 low;
  std::vector<Vector2> below;
  bool roundAbove = false;  ///< whether there is a fillet
  bool roundBelow = false;
};

/// The replacement for a corner of a tile: points from the arriving edge to the leaving edge. Empty
/// without a joint; then the corner itself is used.
struct CornerPoints {
  std::vector<int> arriving;
  int middle = -1;  ///< of necks of length 0: the joint
  std::vector<int> leaving;
  bool isCut = false;  ///< `arriving` has all points
};

/// Use for one outline only.
class OutlineMaker {
 public:
  OutlineMaker(const model::Model& model, const FlatSheet& sheet, const NeckShape& shape)
      : model_(model), tiny_(kShortestLine * model::tileSize(model)) {
    outline_.sheet = sheet;
    outline_.neckWidth = kInfinite;
    kerf_ = std::max(shape.kerf, 0.0);
    for (const model::Joint& joint : model.joints) {
      shapes_.push_back(shapeAt(joint, shape));
      outline_.neckWidth = std::min(outline_.neckWidth, shapes_.back().width);
      kerf_ = std::max(kerf_, shapes_.back().kerf);
    }
    if (shapes_.empty()) outline_.neckWidth = shape.width;
  }

  /// Throws Misfit.
  NeckOutline make() {
    for (const FlatTile& tile : tiles()) corners_.emplace_back(tile.size());
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const CornerGap gap = narrowGap(tiles(), model_.joints[j]);
      shape_ = shapes_[j];
      shape_.length > 0 ? addBeam(gap, j) : addWeb(gap);
      if (outline_.necks.size() > outline_.neckJoints.size()) {
        outline_.neckJoints.push_back(static_cast<int>(j));
      }
    }
    for (std::size_t t = 0; t < tiles().size(); ++t) addTile(static_cast<int>(t));
    return std::move(outline_);
  }

 private:
  const std::vector<FlatTile>& tiles() const { return outline_.sheet.tiles; }

  /// Number of a tile, edge or joint in messages.
  int numberOf(std::size_t index) const {
    return model_.fileOrder.countsFrom + static_cast<int>(index);
  }

  int addPoint(const Vector2& at, bool isAtNeck) {
    outline_.points.push_back(at);
    outline_.isAtNeck.push_back(isAtNeck);
    return static_cast<int>(outline_.points.size()) - 1;
  }

  int vertexOf(const EdgeEnd& end) const {
    const int sides = static_cast<int>(tiles()[end.tile].size());
    return end.atStart ? end.edge : (end.edge + 1) % sides;
  }
  CornerPoints& cornerAt(const EdgeEnd& end) { return corners_[end.tile][vertexOf(end)]; }

  Vector2 jointPoint(const CornerGap& gap) const {
    return 0.5 * (tiles()[gap.first.tile][vertexOf(gap.first)] +
                  tiles()[gap.second.tile][vertexOf(gap.second)]);
  }

  /// A neck of length 0: a line across a closed slit, a triangle across an open gap. The cut ends
  /// at w / cos(g / 2) from the joint, see above.
  void addWeb(const CornerGap& gap) {
    CornerPoints& first = cornerAt(gap.first);
    CornerPoints& second = cornerAt(gap.second);
    const Vector2 joint = jointPoint(gap);
    const double reach = shape_.width / std::cos(gap.angle / 2);
    const Vector2 firstEnd = joint + reach * directionFrom(tiles(), gap.first);
    const Vector2 secondEnd = joint + reach * directionFrom(tiles(), gap.second);
    const bool isClosed = gap.angle <= kClosedAngle;
    const int a = addPoint(firstEnd, true);
    const int b = isClosed ? a : addPoint(secondEnd, true);
    const int middle = joinMiddles(first, second, joint);
    first.arriving = {a};
    second.leaving = {b};
    if (!isClosed) outline_.necks.push_back({middle, a, b});
  }

  /// One point for the corners of both tiles, and of all tiles already joined to them.
  int joinMiddles(CornerPoints& first, CornerPoints& second, const Vector2& joint) {
    if (first.middle < 0 && second.middle < 0) first.middle = addPoint(joint, true);
    if (first.middle < 0) first.middle = second.middle;
    const int old = second.middle;
    second.middle = first.middle;
    if (old < 0 || old == first.middle) return first.middle;
    for (std::vector<CornerPoints>& tile : corners_) {
      for (CornerPoints& corner : tile) {
        if (corner.middle == old) corner.middle = first.middle;
      }
    }
    for (std::vector<int>& neck : outline_.necks) std::ranges::replace(neck, old, first.middle);
    return first.middle;
  }

  /// The tile's own angle at the corner follows from its two edges, 0 to 2 pi.
  Wedge wedgeOf(const EdgeEnd& end, double half) const {
    const FlatTile& tile = tiles()[end.tile];
    const int sides = static_cast<int>(tile.size());
    const int vertex = vertexOf(end);
    const Vector2 after = tile[(vertex + 1) % sides] - tile[vertex];
    const Vector2 before = tile[(vertex + sides - 1) % sides] - tile[vertex];
    double angle = std::atan2(crossZ(after, before), after.dot(before));
    if (angle < 0) angle += 2 * std::numbers::pi;
    return {half, half + angle, kerf_ / 2};
  }

  /// A neck with a length: a strip between two ports cut into the tiles. The second tile is
  /// mirrored, x and -x, so both use the same code.
  void addBeam(const CornerGap& gap, std::size_t joint) {
    CornerPoints& first = cornerAt(gap.first);
    CornerPoints& second = cornerAt(gap.second);
    if (first.isCut || second.isCut) {
      throw InputError(
          fmt::format("error: joint {} shares a corner with another one, so necks with a length or "
                      "a kerf would cross; give --neck-length 0 and --kerf 0",
                      numberOf(joint)));
    }
    const double half = gap.angle / 2;
    const Wedge wedges[] = {wedgeOf(gap.first, half), wedgeOf(gap.second, half)};
    const double x = shape_.length / 2;
    const double bottom = std::max(wedges[0].bottom(x), wedges[1].bottom(x));
    const double top = std::min(wedges[0].top(x), wedges[1].top(x));
    if (top - bottom < shape_.width - tiny_) {
      throw Misfit{Misfit::TooShort, fmt::format("joint {}", numberOf(joint)), shape_};
    }
    const double low = std::max(std::min(-shape_.width / 2, top - shape_.width), bottom);
    const NeckEnd ends[] = {endOf(wedges[0], low, joint), endOf(wedges[1], low, joint)};

    const Vector2 along = directionFrom(tiles(), gap.first);
    const Vector2 up = Eigen::Rotation2Dd(half) * along;
    const Vector2 right(up.y(), -up.x());
    const Vector2 origin = jointPoint(gap);
    const auto place = [&](const Vector2& p, double side) {
      return addPoint(origin + side * p.x() * right + p.y() * up, true);
    };
    std::vector<int> ports;
    for (const auto& [corner, end, side] :
         {std::tuple{&first, &ends[0], 1.0}, {&second, &ends[1], -1.0}}) {
      std::vector<int> chain;
      for (const Vector2& p : end->above) chain.push_back(place(p, side));
      ports.push_back(place(end->high, side));
      ports.push_back(place(end->low, side));
      chain.insert(chain.end(), ports.end() - 2, ports.end());
      for (const Vector2& p : end->below) chain.push_back(place(p, side));
      if (side < 0) std::ranges::reverse(chain);
      corner->arriving = chain;
      corner->isCut = true;
    }
    addStrip(ports, ends, low, place);
  }

  /// The end of a neck at a tile on the right of the joint. The strip begins at the height `low`.
  NeckEnd endOf(const Wedge& wedge, double low, std::size_t joint) const {
    const double x = shape_.length / 2;
    const double high = low + shape_.width;
    const double depth = std::max({shape_.width, shape_.radius, kerf_});
    const double radius = shape_.radius;
    const double roomAbove = wedge.top(x) - high;
    const double roomBelow = low - wedge.bottom(x);
    NeckEnd end;
    end.roundAbove = radius > 0 && roomAbove > tiny_;
    end.roundBelow = radius > 0 && roomBelow > tiny_;
    if ((end.roundAbove && roomAbove < radius) || (end.roundBelow && roomBelow < radius)) {
      throw Misfit{Misfit::TooRound, fmt::format("joint {}", numberOf(joint)), shape_};
    }
    end.high = {x, end.roundAbove ? high + radius : high};
    end.low = {x, end.roundBelow ? low - radius : low};
    if (roomAbove <= depth) {
      if (wedge.top(x) > end.high.y() + tiny_) end.above = {{x, wedge.top(x)}};
    } else if (const double edge = wedge.upperEdge(high + depth); edge < x - tiny_) {
      end.above = {{edge, high + depth}, {x, high + depth}};
    }
    if (roomBelow <= depth) {
      if (wedge.bottom(x) < end.low.y() - tiny_) end.below = {{x, wedge.bottom(x)}};
    } else if (const double edge = wedge.lowerEdge(low - depth); edge < x - tiny_) {
      end.below = {{x, low - depth}, {edge, low - depth}};
    }
    return end;
  }

  /// The neck itself: up its right end, back along its upper side, down its left end.
  template <typename Place>
  void addStrip(const std::vector<int>& ports, const NeckEnd (&ends)[2], double low,
                const Place& place) {
    const double x = shape_.length / 2;
    const double high = low + shape_.width;
    const double r = shape_.radius;
    std::vector<int> loop = {ports[1], ports[0]};
    // Fillets are quarter circles inside the corners, given by their centres and first angles.
    const auto appendArc = [&](const Vector2& centre, double from) {
      for (int k = 0; k <= kArcLines; ++k) {
        const double angle = from - k * std::numbers::pi / (2 * kArcLines);
        const Vector2 at = centre + r * Vector2(std::cos(angle), std::sin(angle));
        const bool isPort = std::abs(std::abs(at.x()) - x) <= tiny_;
        const bool isMiddle = std::abs(at.x()) <= tiny_ && centre.x() < 0 && from < 0;
        const bool isMiddleBelow = std::abs(at.x()) <= tiny_ && centre.x() > 0 && from > 1;
        const bool isTwice = 2 * r >= shape_.length - tiny_ && (isMiddle || isMiddleBelow);
        if (!isPort && !isTwice) loop.push_back(place(at, 1));
      }
    };
    const double quarter = std::numbers::pi / 2;
    if (ends[0].roundAbove) appendArc({x - r, high + r}, 0);
    if (ends[1].roundAbove) appendArc({r - x, high + r}, -quarter);
    loop.push_back(ports[2]);
    loop.push_back(ports[3]);
    if (ends[1].roundBelow) appendArc({r - x, low - r}, 2 * quarter);
    if (ends[0].roundBelow) appendArc({x - r, low - r}, quarter);
    outline_.necks.push_back(loop);
  }

  /// A corner without a joint: the tile's corner, moved inwards by half the kerf.
  int insetCorner(int tile, int vertex) {
    const FlatTile& points = tiles()[tile];
    const int sides = static_cast<int>(points.size());
    const auto inward = [&](int edge) {
      const Vector2 along = (points[(edge + 1) % sides] - points[edge]).normalized();
      return Vector2(-along.y(), along.x());
    };
    const Vector2 a = inward((vertex + sides - 1) % sides);
    const Vector2 b = inward(vertex);
    return addPoint(points[vertex] + kerf_ / 2 * (a + b) / (1 + a.dot(b)), false);
  }

  /// Joins the chains in the order of corners to the tile's loop.
  void addTile(int tile) {
    const int sides = static_cast<int>(tiles()[tile].size());
    std::vector<std::vector<int>> chains;
    for (int k = 0; k < sides; ++k) {
      const CornerPoints& corner = corners_[tile][k];
      std::vector<int> chain = corner.arriving;
      if (corner.middle >= 0) chain.push_back(corner.middle);
      chain.insert(chain.end(), corner.leaving.begin(), corner.leaving.end());
      if (chain.empty()) chain = {insetCorner(tile, k)};
      chains.push_back(chain);
    }
    std::vector<int> loop;
    std::vector<int>& edges = outline_.edges.emplace_back();
    for (int k = 0; k < sides; ++k) {
      requireRest(tile, k, chains[k].back(), chains[(k + 1) % sides].front());
      loop.insert(loop.end(), chains[k].begin(), chains[k].end());
      edges.push_back(static_cast<int>(loop.size()) - 1);
    }
    requireSimple(tile, loop);
    outline_.tiles.push_back(loop);
  }

  /// A part of each edge must remain to be cut.
  void requireRest(int tile, int edge, int from, int to) const {
    const FlatTile& points = tiles()[tile];
    const Vector2 along = points[(edge + 1) % points.size()] - points[edge];
    const Vector2 rest = outline_.points[to] - outline_.points[from];
    if (rest.dot(along.normalized()) > tiny_) return;
    throw Misfit{Misfit::TooWide, fmt::format("edge {} of tile {}", numberOf(edge), numberOf(tile)),
                 widest()};
  }

  NeckShape widest() const {
    const auto found = std::ranges::max_element(shapes_, {}, &NeckShape::width);
    return found == shapes_.end() ? NeckShape{.kerf = kerf_} : *found;
  }

  /// No two lines of a tile's outline may cross.
  void requireSimple(int tile, const std::vector<int>& loop) const {
    const std::size_t count = loop.size();
    const auto at = [&](std::size_t k) { return outline_.points[loop[k % count]]; };
    const auto side = [&](std::size_t line, std::size_t point) {
      return crossZ(at(line + 1) - at(line), at(point) - at(line));
    };
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = a + 2; b < count; ++b) {
        if (b + 1 == count && a == 0) continue;
        const bool crosses = side(a, b) * side(a, b + 1) < 0 && side(b, a) * side(b, a + 1) < 0;
        if (crosses) {
          throw Misfit{Misfit::TooWide, fmt::format("tile {}", numberOf(tile)), widest()};
        }
      }
    }
  }

  const model::Model& model_;
  std::vector<NeckShape> shapes_;  ///< of each joint
  NeckShape shape_;                ///< of the current joint
  double kerf_;                    ///< the maximum, metres
  double tiny_;                    ///< metres
  NeckOutline outline_;
  std::vector<std::vector<CornerPoints>> corners_;
};

void requirePossible(const NeckShape& shape, const LengthUnit& unit) {
  if (!(shape.width > 0)) {
    throw InputError(
        fmt::format("error: necks cannot be {} wide; give a positive --neck-width, or the sheet "
                    "falls apart",
                    lengthText(shape.width, unit, 6)));
  }
  const double length = std::max(shape.length, shape.kerf);
  if (shape.length >= 0 && shape.kerf >= 0 && shape.radius >= 0 && 2 * shape.radius <= length) {
    return;
  }
  throw InputError(
      fmt::format("error: fillets of radius {} do not fit necks {} long; choose a --neck-radius "
                  "of at most {}, or a --neck-length of at least {}",
                  lengthText(shape.radius, unit, 6), lengthText(length, unit, 6),
                  lengthText(length / 2, unit, 6), lengthText(2 * shape.radius, unit, 6)));
}

/// Makes a whole outline.
bool fits(const model::Model& model, const FlatSheet& sheet, const NeckShape& shape) {
  try {
    OutlineMaker(model, sheet, shape).make();
    return true;
  } catch (const Misfit&) {
    return false;
  }
}

/// The limit of a length that fits, to three digits, between one that fits and one that does not.
std::optional<double> boundOf(const model::Model& model, const FlatSheet& sheet, NeckShape shape,
                              double NeckShape::*length, double good) {
  double bad = shape.*length;
  for (const model::Joint& joint : model.joints) {
    bad = std::max(bad, shapeAt(joint, shape).*length);
  }
  shape.*length = good;
  if (!fits(model, sheet, shape)) return std::nullopt;
  for (int k = 0; k < 12; ++k) {
    shape.*length = 0.5 * (good + bad);
    (fits(model, sheet, shape) ? good : bad) = shape.*length;
  }
  // A margin, since rounding could exceed the limit itself.
  return good < bad ? 0.99 * good : 1.01 * good;
}

[[noreturn]] void refuse(const model::Model& model, const FlatSheet& sheet, const NeckShape& shape,
                         const Misfit& misfit) {
  const auto length = [&](double metres) { return lengthText(metres, model.unit, 6); };
  std::string remedy = "; no neck of this length and kerf fits";
  const auto suggest = [&](double NeckShape::*length, double good, const char* words) {
    const std::optional<double> bound = boundOf(model, sheet, shape, length, good);
    if (bound) remedy = fmt::format("; {} {} does", words, lengthText(*bound, model.unit));
    return bound.has_value();
  };
  const double size = model::tileSize(model);
  if (misfit.kind == Misfit::TooRound) {
    suggest(&NeckShape::radius, 0, "a --neck-radius of");
  } else if (misfit.kind == Misfit::TooShort) {
    // The smallest length that fits, of doublings from width / 64; or else one that does not fit.
    NeckShape longer = shape;
    longer.length = misfit.shape.width / 64;
    while (longer.length < size && !fits(model, sheet, longer)) longer.length *= 2;
    suggest(&NeckShape::length, longer.length, "a --neck-length of") ||
        suggest(&NeckShape::width, 1e-6 * size, "a --neck-width of");
  } else {
    suggest(&NeckShape::width, 1e-6 * size, "a --neck-width of") ||
        suggest(&NeckShape::length, misfit.shape.kerf, "a --neck-length of");
  }
  throw InputError(fmt::format(
      "error: {}: a neck {} wide and {} long with fillets of {} and a kerf of {} does not "
      "fit{}",
      misfit.where, length(misfit.shape.width), length(misfit.shape.length),
      length(misfit.shape.radius), length(misfit.shape.kerf), remedy));
}

}  // namespace

NeckShape shapeAt(const model::Joint& joint, const NeckShape& shape) {
  NeckShape own = shape;
  if (own.width == 0) own.width = joint.neck ? brick::materialWidth(joint.neck) : 0;
  const bool isSlotWide = joint.neck.length <= joint.neck.kerf;
  if (own.length < 0) own.length = isSlotWide ? 0 : joint.neck.length;
  if (own.kerf < 0) own.kerf = joint.neck.kerf;
  own.length = std::max(own.length, own.kerf);
  return own;
}

NeckOutline neckOutline(const model::Model& model, const NeckShape& shape) {
  if (model.joints.empty()) requirePossible(shapeAt({}, shape), model.unit);
  for (const model::Joint& joint : model.joints) requirePossible(shapeAt(joint, shape), model.unit);
  const auto first = static_cast<std::size_t>(model.fileOrder.countsFrom);
  for (std::size_t j = 0; j < model.joints.size(); ++j) requirePivot(model.joints[j], first + j);
  const FlatSheet sheet = flatSheet(model);
  try {
    return OutlineMaker(model, sheet, shape).make();
  } catch (const Misfit& misfit) {
    refuse(model, sheet, shape, misfit);
  }
}

}  // namespace kirireel::writers
