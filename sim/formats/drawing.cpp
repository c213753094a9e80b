// Functions of both readers of drawings. A file is read twice: first coarsely for its size, then
// with curves flattened to 5e-5 of that size.
#include "sim/formats/drawing.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/files.h"
#include "sim/formats/text_table.h"

namespace kirireel::formats {
namespace {

// Fraction of the drawing's size.
constexpr double kFlattening = 5e-5;
// Fraction of a drawing's numbers that may have more decimals than its last digit.
constexpr double kFew = 0.05;
constexpr const char* kDrawingPurpose = "give an SVG or an ASCII DXF file with lines to cut";

}  // namespace

std::string Drawing::place(const Vector2& point) const {
  const Vector2 own = (point - origin) / unit;
  return fmt::format("({:.6g}, {:.6g}) {}", own.x(), isDownwards ? 0.0 - own.y() : own.y(),
                     unitName);
}

std::string Drawing::length(double metres) const {
  return fmt::format("{:.4g} {}", metres / unit, unitName);
}

double Drawing::size() const {
  Eigen::AlignedBox2d box;
  for (const DrawnPath& path : paths) {
    for (const Vector2& point : path.points) box.extend(point);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

std::string lowerCase(std::string_view text) {
  std::string lower(text);
  for (char& letter : lower) {
    if (letter >= 'A' && letter <= 'Z') letter = static_cast<char>(letter - 'A' + 'a');
  }
  return lower;
}

std::string listed(const std::vector<std::string>& entries, std::size_t most) {
  const std::size_t count = std::min(most, entries.size());
  const auto end = entries.begin() + static_cast<std::ptrdiff_t>(count);
  std::string list = fmt::format("{}", fmt::join(entries.begin(), end, ", "));
  if (count < entries.size()) list += fmt::format(" and {} more", entries.size() - count);
  return list;
}

std::vector<std::string> entriesOf(const std::map<std::string, int>& counts) {
  std::vector<std::string> entries;
  for (const auto& [what, count] : counts) entries.push_back(fmt::format("{} x {}", count, what));
  return entries;
}

double DecimalCounts::lastPlace() const {
  const int all = std::reduce(numbers.begin(), numbers.end());
  int decimals = static_cast<int>(numbers.size()) - 1;
  for (int finer = numbers[decimals]; decimals > 0 && finer <= kFew * all;) {
    finer += numbers[--decimals];
  }
  return decimals < 7 ? std::pow(10.0, -decimals) : 0;
}

double drawnNumber(std::string_view text, const FileLocation& place, DecimalCounts* decimals) {
  std::string typed(text);
  std::ranges::replace(typed, ',', '.');
  double value = 0;
  if (!readNumber(typed, value) || !std::isfinite(value)) {
    throw inputErrorAt(place, fmt::format("'{}' is not a number. Correct it, or save the drawing "
                                          "again",
                                          shown(text, 24)));
  }
  const std::size_t point = typed.find('.');
  const std::size_t exponent = std::min(typed.find_first_of("eE"), typed.size());
  const std::size_t last = typed.find_last_not_of('0');
  const std::size_t count = exponent < typed.size() ? 15 : point < last ? last - point : 0;
  if (decimals) ++decimals->numbers[std::min<std::size_t>(count, 15)];
  return value;
}

void addArc(std::vector<Vector2>& points, const Vector2& centre, const Vector2& first,
            const Vector2& second, double from, double sweep, double flattening) {
  const double radius = std::max(first.norm(), second.norm());
  const double share = radius > 0 ? std::min(flattening / radius, 0.07) : 0.07;
  // At most 45 degrees per piece, which keeps small circles round.
  const double step = std::max(2 * std::acos(1 - share), 2e-3);
  const int pieces = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) / step)));
  for (int k = 1; k <= pieces; ++k) {
    const double angle = from + sweep * k / pieces;
    points.push_back(centre + std::cos(angle) * first + std::sin(angle) * second);
  }
}

void addPath(Drawing& drawing, DrawnPath path, const std::filesystem::path& file) {
  std::vector<Vector2> points;
  for (const Vector2& point : path.points) {
    if (!point.allFinite() || point.cwiseAbs().maxCoeff() > kMaxCoordinate) {
      throw inputErrorAt(
          {file},
          fmt::format(
              "a line has the point ({:.6g}, {:.6g}) m, but coordinates must be within {:g} m",
              point.x(), point.y(), kMaxCoordinate));
    }
    if (points.empty() || points.back() != point) points.push_back(point);
  }
  if (points.size() > 3 && points.front() == points.back()) path.isClosed = true;
  if (path.isClosed && points.size() > 1 && points.front() == points.back()) points.pop_back();
  if (points.size() < 2) {
    ++drawing.ignored["line without length"];
    return;
  }
  path.isClosed = path.isClosed && points.size() > 2;
  path.points = std::move(points);
  std::size_t count = path.points.size();
  drawing.paths.push_back(std::move(path));
  for (std::size_t k = 0; k + 1 < drawing.paths.size() && drawing.paths.size() % 4096 == 0; ++k) {
    count += drawing.paths[k].points.size();
  }
  if (count <= kMaxDrawnPoints && drawing.paths.size() <= kMaxDrawnPoints / 2) return;
  throw inputErrorAt(
      {file}, fmt::format("the drawing has more than {} points. Remove lines that are not cuts",
                          kMaxDrawnPoints));
}

bool isDrawing(const std::filesystem::path& file) {
  const std::string ending = endingOf(file);
  return ending == ".svg" || ending == ".dxf";
}

Drawing readDrawing(const std::filesystem::path& file) {
  const bool isSvg = endingOf(file) == ".svg";
  // The parser of XML knows the encodings of SVG files.
  const std::string text =
      isSvg ? readTextFile(file, kDrawingPurpose) : readPlainText(file, kDrawingPurpose);
  const auto read = [&](double flattening) {
    return isSvg ? readSvgDrawing(file, text, flattening) : readDxfDrawing(file, text, flattening);
  };
  // A drawing without curves is the same at any tolerance.
  Drawing coarse = read(1e3);
  return coarse.flattening > 0 ? read(kFlattening * coarse.size()) : coarse;
}

}  // namespace kirireel::formats
