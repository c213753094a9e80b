/// Text and scales in pictures: labels, fonts, ticks, scales, and what they are drawn on.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/style.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Text in pictures.

/// Of letters.
enum class Weight { Regular, Bold };

/// Chooses the family of all text from now on, for example "Liberation Sans"; empty: the program's
/// own. Throws InputError when the machine has none of this name. Call it before other threads
/// start.
void setFont(const std::string& family);

/// The font file for labels: that of setFont(), else $KIRIREEL_FONT if set, else DejaVu Sans where
/// Debian, Fedora or Arch keep it. Throws OutputError that names Debian's package when there is
/// none.
std::filesystem::path findFont();

/// The same in a weight: the bold font of the same family where there is one, else the regular one.
std::filesystem::path findFont(Weight weight);

/// The name of that font's family, for example "DejaVu Sans".
std::string fontFamily();

/// Draws lines of text in one size.
class LabelWriter {
 public:
  /// pixelsPerEm: the size of the text, at least 1. Throws OutputError when the font cannot be
  /// read.
  explicit LabelWriter(int pixelsPerEm, const std::filesystem::path& font = findFont());
  ~LabelWriter();
  LabelWriter(const LabelWriter&) = delete;
  LabelWriter& operator=(const LabelWriter&) = delete;

  /// The name of the font's family.
  std::string family() const;

  /// Width of one line of text in UTF-8, pixels. Each character that the font lacks, and any text
  /// that is not UTF-8, counts and is drawn as the font's box. Rounded up.
  int width(const std::string& text) const;

  /// The first character that the font lacks; absent when it has them all.
  std::optional<char32_t> missingGlyph(const std::u32string& text) const;

  /// Draws one line of text in UTF-8: its pen starts at x, the baseline of its letters is row
  /// `baseline`. What falls outside the frame is left out.
  void draw(Frame& frame, const std::string& text, int x, int baseline, Colour colour) const;

 private:
  struct Face;
  std::unique_ptr<Face> face_;
};

/// Throws InputError that names the option when a text is not UTF-8 or has a character that the
/// font lacks, and OutputError when the font is missing. Line feeds are allowed.
void requireDrawable(const char* option, const std::string& text);

// ------------------------------------------------------------------------------------------------
// Fonts by the name of their family.

/// The file of a family's upright font of regular weight, from fontconfig. Throws InputError that
/// names the nearest family if there is none of this name; case does not count. Style and weight
/// are fontconfig's defaults.
std::filesystem::path fontFile(const std::string& family);

// ------------------------------------------------------------------------------------------------
// Text on several lines.
//
// The caller gives the widths: the same code breaks lines of pixels and of a page of vector
// graphics, with any font.

/// Width of one line of text, in any unit.
using LineWidth = std::function<double(const std::string&)>;

/// Breaks a text into lines: at each line feed, and at spaces where a line would be wider than
/// `most`. A word that is wider by itself stays whole. Runs of spaces become one. At least one
/// line, which may be empty.
std::vector<std::string> wrapText(const std::string& text, const LineWidth& width, double most);

/// The width of the widest line; 0 for none.
double widestLine(const std::vector<std::string>& lines, const LineWidth& width);

// ------------------------------------------------------------------------------------------------
// What captions and scales are drawn on: pixels, or a page of vector graphics.

/// Lengths are pixels from the upper left corner. Text is set in the font of setFont().
class Surface {
 public:
  virtual ~Surface() = default;

  /// A filled rectangle.
  virtual void box(double left, double upper, double width, double height, Colour colour) = 0;

  /// One line of text in UTF-8 from its left end, its letters on `baseline`. em: its size.
  virtual void text(const std::string& line, double left, double baseline, int em, Colour colour,
                    Weight weight = Weight::Regular) = 0;
};

/// Draws on a picture, which must outlive it. What falls outside is left out.
class FrameSurface : public Surface {
 public:
  /// Draws on this frame, which must outlive it.
  explicit FrameSurface(Frame& frame) : frame_(frame) {}

  void box(double left, double upper, double width, double height, Colour colour) override;
  /// Throws OutputError when the font is missing.
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override;

 private:
  Frame& frame_;
};

// ------------------------------------------------------------------------------------------------
// Round numbers along an axis.

/// A range of values and the marks along it, rising, all within it.
struct Axis {
  double low = 0;                  ///< the lowest value shown
  double high = 1;                 ///< above low
  bool isLogarithmic = false;      ///< equal steps of the page are equal ratios; low is above 0
  std::vector<double> ticks;       ///< the values with numbers
  std::vector<std::string> texts;  ///< the numbers, one per tick

  /// The place of a value: 0 at low, 1 at high. Beyond 0 to 1 for values off the axis. On a
  /// logarithmic axis the value must be above 0.
  double shareOf(double value) const;
};

/// An axis that holds finite values, at least one, with at most so many ticks at multiples of 1, 2
/// or 5 times a power of ten; a constant (to 1e-5 of itself) is in its middle.
Axis makeAxis(const std::vector<double>& values, int mostTicks);

/// An axis of this range, high at low or above, with such ticks within it. Without ticks where low
/// and high are equal.
Axis makeAxisWithin(double low, double high, int mostTicks);

/// The same with ticks at powers of ten; values of 0 and below have no place on it. With none above
/// 0, an axis from 0.1 to 10.
Axis makeLogarithmicAxis(const std::vector<double>& values, int mostTicks);

// ------------------------------------------------------------------------------------------------
// Scales on pictures: what a colour means, and how long a length is.

/// What the colours of a picture mean.
struct ColourScale {
  ColourMap map = ColourMap::Viridis;  ///< how values become colours
  double least = 0;                    ///< the value of the scale's dark end
  double most = 1;                     ///< the value of its bright end
  std::string title;                   ///< quantity and unit, ASCII, for example "target error, m"
  /// That colours stand out from; absent: they are those of the map.
  std::optional<Colour> background = {};
};

/// The colour of a share of the scale.
Colour colourAt(const ColourScale& scale, double share);

/// What one of several colours means.
struct LegendEntry {
  Colour colour;     ///< what bricks have
  std::string text;  ///< UTF-8, a few words
};

/// The place of a value on the scale, 0 to 1 within it. 0 if the scale has no
/// range.
double shareOf(const ColourScale& scale, double value);

/// The length that a bar shows: 1, 2 or 5 times a power of ten, at most `longest`, and its text,
/// for example "0.5 m" or "20 mm".
struct ScaleLength {
  double metres = 1;  ///< above 0
  std::string text;   ///< with its unit, ASCII
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

}  // namespace kirireel::picture
