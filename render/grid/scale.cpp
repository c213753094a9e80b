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
/// Length of a bar of colours, ems, where there is room.
constexpr double kColourBarLengthEms = 14;

int pixels(double length) {
  return static_cast<int>(std::lround(length));
}

/// A value in few letters: 0, 0.25, 1.2e-05.
std::string shortNumber(double value) {
  return fmt::format("{:.3g}", value);
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
  // Half the height of a capital letter below the middle line.
  return y + pixels(0.36 * em_);
}

void ScaleDrawer::drawColourBar(Surface& surface, const ColourScale& scale, int x, int y,
                                int width) const {
  const int space = pixels(kSpaceEms * em_);
  const std::string least = shortNumber(scale.least), most = shortNumber(scale.most);
  const int texts = writer_.width(scale.title) + writer_.width(least) + writer_.width(most);
  const int room = width - texts - 6 * space;  // four between the parts, one at each end
  const int length = std::clamp(room, em_, pixels(kColourBarLengthEms * em_));
  int pen = x - (texts + 4 * space + length) / 2;
  const auto write = [&](const std::string& text, int gap) {
    surface.text(text, pen, baseline(y), em_, text_);
    pen += writer_.width(text) + gap;
  };
  write(scale.title, 2 * space);
  write(least, space);
  const int height = std::max(3, pixels(kColourBarEms * em_));
  for (int k = 0; k < length; ++k) {
    const double share = length > 1 ? static_cast<double>(k) / (length - 1) : 0;
    // Each over the rest of the bar, so that no gap shows between two.
    surface.box(pen + k, y - height / 2, length - k, height, mapColour(scale.map, share));
  }
  pen += length + space;
  write(most, 0);
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
