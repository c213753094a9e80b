// From a planar start to lines for a cutter:
//
// - 1. At each joint a hinge of material stays. The narrower gap between the two tiles has the
//   angle g; the cut along its edges ends at t = w / cos(g / 2) before the joint, so that the neck
//   across the gap's bisector is w long (w: hinge width, metres). An open gap gets a cut across its
//   end.
// - 2. Each edge is shortened by the largest t of the joints at its ends.
// - 3. Edges of two tiles that coincide are one slit, drawn once; they are found by their middles
//   in a grid of cells as wide as the tolerance (1e-4 of the tile size), of which 3 x 3 are looked
//   at.
//
// SVG is in millimetres with y down; DXF is ASCII R12 (AC1009; Autodesk, DXF Reference): pairs of
// lines, a group code and a value: 0 begins an entity, 8 names its layer, 10/20 and 11/21 are its
// ends, 62 a colour, $INSUNITS 6 metres. R12 needs no tables of handles.
#include "render/sheet/cut_pattern.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "render/sheet/flat_sheet.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr double kSameVertex = 1e-4;  ///< of the tile size, within which edges coincide

/// How much shorter edges are at their ends than in the model, metres.
using Trims = std::map<EdgeEnd, double>;

/// 0 at ends without a joint.
double trimAt(const Trims& trims, const EdgeEnd& end) {
  const auto found = trims.find(end);
  return found == trims.end() ? 0 : found->second;
}

/// Works in the sheet's plane; all lengths in metres.
class PatternMaker {
 public:
  PatternMaker(const Model& model, double hingeWidth)
      : tiles_(flatSheet(model).tiles), width_(hingeWidth), same_(kSameVertex * tileSize(model)) {
    for (std::size_t j = 0; j < model.joints.size(); ++j) addHinge(model.joints[j], j);
    addEdges();
  }

  std::vector<PatternLine> take() { return std::move(lines_); }

 private:
  int sides(int tile) const { return static_cast<int>(tiles_[tile].size()); }
  int after(int tile, int k) const { return (k + 1) % sides(tile); }

  const Vector2& corner(const Corner& c) const { return tiles_[c.tile][c.vertex]; }

  void addHinge(const Joint& joint, std::size_t number) {
    requirePivot(joint, number);
    const CornerGap gap = narrowGap(tiles_, joint);
    const double trim = width_ / std::cos(gap.angle / 2);
    const Vector2 middle = 0.5 * (corner(joint.a) + corner(joint.b));
    const Vector2 ends[] = {middle + trim * directionFrom(tiles_, gap.first),
                            middle + trim * directionFrom(tiles_, gap.second)};
    for (const EdgeEnd& end : {gap.first, gap.second}) {
      double& kept = trims_[end];
      kept = std::max(kept, trim);
    }
    lines_.push_back({PatternLayer::Hinges, middle, 0.5 * (ends[0] + ends[1])});
    if (gap.angle > kClosedAngle) lines_.push_back({PatternLayer::Cuts, ends[0], ends[1]});
  }

  /// The same edge of another tile, which runs the other way; found by its middle.
  std::optional<std::pair<int, int>> twinOf(int tile, int edge) const {
    const Vector2 from = tiles_[tile][edge];
    const Vector2 to = tiles_[tile][after(tile, edge)];
    const auto [column, row] = cellOf(0.5 * (from + to));
    for (long x = column - 1; x <= column + 1; ++x) {
      for (long y = row - 1; y <= row + 1; ++y) {
        const auto [first, last] = edges_.equal_range({x, y});
        for (auto found = first; found != last; ++found) {
          const auto [t, e] = found->second;
          if (t == tile) continue;
          const bool isSame =
              (tiles_[t][e] - to).norm() < same_ && (tiles_[t][after(t, e)] - from).norm() < same_;
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
      throw InputError(
          fmt::format("error: hinges {} m wide leave nothing to cut of edge {} of tile "
                      "{}, {:.3g} m long; choose a smaller --hinge-width",
                      width_, edge, tile, length));
    }
    const Vector2 along = (to - from) / length;
    lines_.push_back({twin ? PatternLayer::Slits : PatternLayer::Cuts, from + atStart * along,
                      to - atEnd * along});
  }

  std::vector<FlatTile> tiles_;
  double width_;
  double same_;  ///< metres within which points coincide
  Trims trims_;
  std::multimap<std::pair<long, long>, std::pair<int, int>> edges_;  ///< by their middles
  std::vector<PatternLine> lines_;
};

/// How a layer looks.
struct LayerLook {
  PatternLayer layer;
  const char* name;
  const char* svgStyle;
  int dxfColour;
};

constexpr LayerLook kLooks[] = {
    {PatternLayer::Cuts, "cuts", "stroke=\"#d00000\"", 1},
    {PatternLayer::Slits, "slits", "stroke=\"#0000d0\"", 5},
    {PatternLayer::Hinges, "hinges", "stroke=\"#008000\"", 3},
};

}  // namespace

std::vector<PatternLine> cutPattern(const Model& model, double hingeWidth) {
  if (!(hingeWidth > 0)) {
    throw InputError(
        fmt::format("error: hinges cannot be {} m wide; give a positive --hinge-width, "
                    "or the sheet falls apart",
                    hingeWidth));
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
  // Hairlines once the sheet is scaled to fit a cutter, and still to be seen before.
  const double stroke = size.maxCoeff() / kStrokesAcross;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{1}mm\" "
      "viewBox=\"0 0 {0} {1}\">\n",
      size.x(), size.y());
  // SVG's y runs down.
  const auto x = [&](const Vector2& p) { return kMargin + kMillimetres * (p.x() - box.min().x()); };
  const auto y = [&](const Vector2& p) { return kMargin + kMillimetres * (box.max().y() - p.y()); };
  for (const LayerLook& look : kLooks) {
    text += fmt::format("<g id=\"{}\" fill=\"none\" stroke-width=\"{}\" {}>\n", look.name, stroke,
                        look.svgStyle);
    for (const PatternLine& line : lines) {
      if (line.layer != look.layer) continue;
      text += fmt::format("<path d=\"M {} {} L {} {}\"/>\n", x(line.from), y(line.from), x(line.to),
                          y(line.to));
    }
    text += "</g>\n";
  }
  return text + "</svg>\n";
}

std::string patternDxf(const std::vector<PatternLine>& lines) {
  std::string text =
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n"
      "0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n3\n";
  for (const LayerLook& look : kLooks) {
    text +=
        fmt::format("0\nLAYER\n2\n{}\n70\n0\n62\n{}\n6\nCONTINUOUS\n", look.name, look.dxfColour);
  }
  text += "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
  for (const PatternLine& line : lines) {
    const LayerLook& look = kLooks[static_cast<int>(line.layer)];
    text += fmt::format("0\nLINE\n8\n{}\n10\n{}\n20\n{}\n11\n{}\n21\n{}\n", look.name,
                        line.from.x(), line.from.y(), line.to.x(), line.to.y());
  }
  return text + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace kirireel
