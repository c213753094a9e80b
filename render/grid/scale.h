/// Scales on pictures: what a colour means, and how long a length is.
#pragma once

#include <string>
#include <vector>

#include "render/grid/label.h"
#include "render/grid/surface.h"
#include "render/grid/ticks.h"
#include "render/picture/frame.h"
#include "render/picture/palette.h"

namespace kirireel {

/// What the colours of a picture mean.
struct ColourScale {
  ColourMap map = ColourMap::Viridis;
  double least = 0;   ///< the value of the scale's dark end
  double most = 1;    ///< the value of its bright end
  std::string title;  ///< quantity and unit, ASCII, for example "target error, m"
};

/// What one of several colours means.
struct LegendEntry {
  Colour colour;
  std::string text;  ///< UTF-8, a few words
};

/// The share of the scale at which a value stands, 0 to 1 within it. 0 where the scale has no
/// range.
double shareOf(const ColourScale& scale, double value);

/// A length that a bar stands for: 1, 2 or 5 times a power of ten, at most `longest`, and how it is
/// written, for example "0.5 m" or "20 mm".
struct ScaleLength {
  double metres = 1;
  std::string text;
};

/// The longest such length. longest: metres, positive. From 1 um on in um, mm, m, km.
ScaleLength roundLength(double longest);

/// Height of a bar of colours with its ticks and their values, ems of the text.
inline constexpr double kColourBarHeight = 2.4;

/// Draws scales in one size of text.
class ScaleDrawer {
 public:
  /// em: of the text, pixels. Throws OutputError when the font is missing.
  ScaleDrawer(int em, Colour text) : writer_(em), em_(em), text_(text) {}

  /// Draws a horizontal bar of colours with its title to the left, and under it ticks with round
  /// values. All of it is as high as kColourBarHeight; its middle line is row y; it is centred on
  /// column x, as wide as fits in `width` pixels.
  void drawColourBar(Surface& surface, const ColourScale& scale, int x, int y, int width) const;

  /// Draws a square of each colour with its text to the right, side by side, centred on column x,
  /// middle line on row y; smaller where they need more than `width` pixels.
  void drawLegend(Surface& surface, const std::vector<LegendEntry>& entries, int x, int y,
                  int width) const;

  /// Draws a bar of `pixels` pixels with its text to the right; both centred on column x, middle
  /// line on row y.
  void drawScaleBar(Surface& surface, const std::string& text, int pixels, int x, int y) const;

 private:
  int baseline(int y) const;
  Axis axisThatFits(const ColourScale& scale, int length) const;
  void drawTicks(Surface& surface, const ColourScale& scale, int left, int upper, int length) const;

  LabelWriter writer_;
  int em_;
  Colour text_;
};

}  // namespace kirireel
