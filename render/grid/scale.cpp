// A bar of colours from the left: title, gap, bar; under the bar ticks with round values. The bar
// is at most 14 em long, shorter where the sheet is narrow; as many ticks are taken, six at most,
// as their numbers have room for.
//
// A bar of length stands for 1, 2 or 5 times a power of ten metres: with L the longest that is
// allowed, p = 10^floor(log10 L) and q = L / p, it is 5 p for q >= 5, 2 p for q >= 2, else p.
//
// A legend that needs more room than there is gets smaller letters and squares, all by one factor.
#include "render/grid/scale.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kirireel {
namespace {

/// Height of a bar of colours, and of a bar of length, in ems of the text beside it.
constexpr double kColourBarEms = 0.9;
constexpr double kScaleBarEms = 0.25;
/// Between a bar and its text, ems.
constexpr double kSpaceEms = 0.5;
/// Half the height of a capital letter, ems.
constexpr double kHalfCapital = 0.36;
/// A tick under a bar of colours, and from its end to the baseline of its value, ems.
constexpr double kTickEms = 0.22;
constexpr double kTickWidthEms = 0.07;
constexpr int kMostTicks = 6;
constexpr double kTickValueEms = 0.95;
/// Length of a bar of colours, ems, where there is room.
constexpr double kColourBarLengthEms = 14;

int pixels(double length) {
  return static_cast<int>(std::lround(length));
}

}  // namespace

double shareOf(const ColourScale& scale, double value) {
  const double range = scale.most - scale.least;
  return range > 0 ? (value - scale.least) / range : 0;
}

ScaleLength roundLength(double longest) {
  const double power = std::pow(10.0, std::floor(std::log10(longest) + 1e-9));
  const double ratio = longest / power * (1 + 1e-9);
  const double metres = power * (ratio >= 5 ? 5 : ratio >= 2 ? 2 : 1);
  if (metres >= 0.1 && metres < 1000) return {metres, fmt::format("{:g} m", metres)};
  if (metres >= 1000) return {metres, fmt::format("{:g} km", metres / 1000)};
  if (metres >= 1e-3) return {metres, fmt::format("{:g} mm", metres * 1e3)};
  return {metres, fmt::format("{:g} um", metres * 1e6)};
}

int ScaleDrawer::baseline(int y) const {
  return y + pixels(kHalfCapital * em_);
}

void ScaleDrawer::drawColourBar(Surface& surface, const ColourScale& scale, int x, int y,
                                int width) const {
  const int gap = pixels(2 * kSpaceEms * em_);
  const int title = writer_.width(scale.title);
  // A tick's value may stand out by half its width, and something stays free at each end.
  const int length = std::clamp(width - title - 3 * gap, em_, pixels(kColourBarLengthEms * em_));
  const int left = x - (title + gap + length) / 2;
  const int height = std::max(3, pixels(kColourBarEms * em_));
  const int upper = y - pixels(0.5 * kColourBarHeight * em_) + pixels(0.1 * em_);
  surface.text(scale.title, left, baseline(upper + height / 2), em_, text_);
  const int bar = left + title + gap;
  for (int k = 0; k < length; ++k) {
    const double share = length > 1 ? static_cast<double>(k) / (length - 1) : 0;
    // Each over the rest of the bar, so that no gap shows between two.
    surface.box(bar + k, upper, length - k, height, mapColour(scale.map, share));
  }
  drawTicks(surface, scale, bar, upper + height, length);
}

/// With as many ticks as their values have room for.
Axis ScaleDrawer::axisThatFits(const ColourScale& scale, int length) const {
  Axis axis;
  for (int most = kMostTicks; most >= 2; --most) {
    axis = makeAxisWithin(scale.least, scale.most, most);
    int widest = 0;
    for (const std::string& text : axis.texts) widest = std::max(widest, writer_.width(text));
    if (axis.ticks.size() < 2) break;
    const double step = (axis.ticks[1] - axis.ticks[0]) / (scale.most - scale.least);
    if (widest + kSpaceEms * em_ <= step * length) break;
  }
  return axis;
}

void ScaleDrawer::drawTicks(Surface& surface, const ColourScale& scale, int left, int upper,
                            int length) const {
  const Axis axis = axisThatFits(scale, length);
  const int height = std::max(2, pixels(kTickEms * em_));
  const int width = std::max(1, pixels(kTickWidthEms * em_));
  for (std::size_t k = 0; k < axis.ticks.size(); ++k) {
    const int place = left + pixels(shareOf(scale, axis.ticks[k]) * (length - 1));
    surface.box(place - width / 2, upper, width, height, text_);
    surface.text(axis.texts[k], place - writer_.width(axis.texts[k]) / 2,
                 upper + height + pixels(kTickValueEms * em_), em_, text_);
  }
}

void ScaleDrawer::drawLegend(Surface& surface, const std::vector<LegendEntry>& entries, int x,
                             int y, int width) const {
  // In ems of the text: a square, a space, the text, and two spaces before the next.
  double needed = -2 * kSpaceEms * em_;
  for (const auto& [colour, text] : entries) {
    needed += (kColourBarEms + 3 * kSpaceEms) * em_ + writer_.width(text);
  }
  const double share = std::min(1.0, width / needed);
  const int em = std::max(1, static_cast<int>(share * em_));
  const double square = kColourBarEms * em, space = kSpaceEms * em;
  double pen = x - 0.5 * share * needed;
  for (const auto& [colour, text] : entries) {
    surface.box(std::round(pen), std::round(y - 0.5 * square), std::round(square),
                std::round(square), colour);
    pen += square + space;
    surface.text(text, std::round(pen), std::round(y + kHalfCapital * em), em, text_);
    pen += share * writer_.width(text) + 2 * space;
  }
}

void ScaleDrawer::drawScaleBar(Surface& surface, const std::string& text, int length, int x,
                               int y) const {
  const int space = pixels(kSpaceEms * em_);
  const int left = x - (length + space + writer_.width(text)) / 2;
  const int height = std::max(2, pixels(kScaleBarEms * em_));
  surface.box(left, y - height / 2, length, height, text_);
  surface.text(text, left + length + space, baseline(y), em_, text_);
}

}  // namespace kirireel
