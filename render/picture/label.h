/// Text and scales in pictures: labels, fonts, ticks, scales, and their drawing surfaces.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"
#include "render/picture/style.h"
#include "sim/base/length_unit.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Text in pictures.

/// Weight of letters.
enum class Weight { Regular, Bold };

/// Sets the family of all text from now on, for example "Liberation Sans"; empty: the default.
/// Throws InputError if the machine has no such family. Call it before other threads start.
void setFont(const std::string& family);

/// The font file for labels: that of setFont(), else $KIRIREEL_FONT if set, else DejaVu Sans at its
/// path in Debian, Fedora or Arch. Throws OutputError with the name of Debian's package if there is
/// none.
std::filesystem::path findFont();

/// The same in a weight: the bold font of the family if it exists, else the regular one.
std::filesystem::path findFont(Weight weight);

/// The name of that font's family, for example "DejaVu Sans".
std::string fontFamily();

/// A face in a font file.
struct FontFile {
  std::filesystem::path path;
  int number = 0;  ///< of the face in the file; collections have several

  bool operator==(const FontFile&) const = default;
  auto operator<=>(const FontFile&) const = default;
};

/// fontconfig's pattern of a face, an FcPattern, which Cairo opens.
std::shared_ptr<void> fontPattern(const FontFile& font);

/// A glyph of a shaped line. Lengths are pixels.
struct PlacedGlyph {
  unsigned number = 0;  ///< in its font; 0: the box for missing characters
  double x = 0;         ///< from the left end of the line
  double y = 0;         ///< below the baseline
};

/// Characters that are shaped together.
struct GlyphCluster {
  std::string text;  ///< UTF-8
  int glyphs = 0;    ///< of the run's glyphs
};

/// A part of a line in one font and one direction.
struct TextRun {
  FontFile font;
  std::string family;                  ///< name of the font's family
  std::vector<PlacedGlyph> glyphs;     ///< from left to right
  std::vector<GlyphCluster> clusters;  ///< from left to right
};

/// A line with its letters joined and in their order on the page.
struct ShapedLine {
  std::vector<TextRun> runs;   ///< from left to right
  double width = 0;            ///< pixels
  bool isPlain = true;         ///< one glyph per character, from left to right, in the main font
  bool isRightToLeft = false;  ///< the first letter with a direction is of such a script
};

/// Draws lines of text in one size. A character that the font lacks is drawn in a fallback font,
/// which fontconfig finds.
class LabelWriter {
 public:
  /// pixelsPerEm: size of the text, >= 1. Throws OutputError if the font cannot be read.
  explicit LabelWriter(int pixelsPerEm, const std::filesystem::path& font = findFont());
  ~LabelWriter();
  LabelWriter(const LabelWriter&) = delete;
  LabelWriter& operator=(const LabelWriter&) = delete;

  /// The name of the font's family.
  std::string family() const;

  /// Shapes one line of UTF-8 text. The font's box replaces each missing character and invalid
  /// UTF-8.
  ShapedLine shape(const std::string& text) const;

  /// Width of the shaped line, pixels, rounded up.
  int width(const std::string& text) const;
  /// Width of the widest of these lines, pixels; 0 without lines.
  int widest(const std::vector<std::string>& lines) const;

  /// The first character missing in the font and in all fallback fonts; absent if none is missing.
  std::optional<char32_t> missingGlyph(const std::u32string& text) const;

  /// Draws one line of UTF-8 text: the pen starts at x, the letters' baseline is row `baseline`.
  /// Parts outside the frame are clipped.
  void draw(Frame& frame, const std::string& text, int x, int baseline, Colour colour) const;

 private:
  struct Fonts;
  std::unique_ptr<Fonts> fonts_;
};

/// Throws InputError with the option's name if a text is not UTF-8 or has a character that no font
/// has, with Debian's package for its script. Throws OutputError if the main font is missing. Line
/// feeds are allowed.
void requireDrawable(const char* option, const std::string& text);

// ------------------------------------------------------------------------------------------------
// Fonts by family name.

/// The file of a family's upright regular font, from fontconfig. Throws InputError with the most
/// similar family if there is none with this name, ignoring case. Style and weight are fontconfig's
/// defaults.
std::filesystem::path fontFile(const std::string& family);

// ------------------------------------------------------------------------------------------------
// Text on several lines.
//
// The caller provides the widths, so the same code breaks lines for pixels and for pages of vector
// graphics, with any font.

/// Width of one line of text, in any unit.
using LineWidth = std::function<double(const std::string&)>;

/// Breaks a text into lines: at each line feed, and at spaces if a line would be wider than `most`.
/// A single wider word stays whole. Runs of spaces become one. At least one line, which may be
/// empty.
std::vector<std::string> wrapText(const std::string& text, const LineWidth& width, double most);

// ------------------------------------------------------------------------------------------------
// Surfaces for captions and scales: pixels, or a page of vector graphics.

/// Lengths are pixels from the upper left corner. Text has the font of setFont().
class Surface {
 public:
  virtual ~Surface() = default;

  /// A filled rectangle.
  virtual void box(double left, double upper, double width, double height, Colour colour) = 0;

  /// One line of UTF-8 text from its left end, with its letters on `baseline`. em: its size.
  virtual void text(const std::string& line, double left, double baseline, int em, Colour colour,
                    Weight weight = Weight::Regular) = 0;
};

/// Draws on a picture, which must outlive it. Parts outside are clipped.
class FrameSurface : public Surface {
 public:
  /// Draws on this frame, which must outlive it.
  explicit FrameSurface(Frame& frame) : frame_(frame) {}

  void box(double left, double upper, double width, double height, Colour colour) override;
  /// Throws OutputError if the font is missing.
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override;

 private:
  Frame& frame_;
};

/// Draws on another surface, which must outlive it, from a corner of that one on.
class ShiftedSurface : public Surface {
 public:
  /// `left` and `upper`: of the corner, pixels.
  ShiftedSurface(Surface& surface, double left, double upper)
      : surface_(surface), left_(left), upper_(upper) {}

  void box(double left, double upper, double width, double height, Colour colour) override {
    surface_.box(left_ + left, upper_ + upper, width, height, colour);
  }
  void text(const std::string& line, double left, double baseline, int em, Colour colour,
            Weight weight) override {
    surface_.text(line, left_ + left, upper_ + baseline, em, colour, weight);
  }

 private:
  Surface& surface_;
  double left_;
  double upper_;
};

// ------------------------------------------------------------------------------------------------
// Round numbers along an axis.

/// A range of values with ascending ticks in it.
struct Axis {
  double low = 0;                  ///< lowest value
  double high = 1;                 ///< > low
  bool isLogarithmic = false;      ///< equal steps on the page are equal ratios; low > 0
  std::vector<double> ticks;       ///< values with numbers
  std::vector<std::string> texts;  ///< the numbers, one per tick

  /// Position of a value: 0 at low, 1 at high, outside [0, 1] for values off the axis. On a
  /// logarithmic axis the value must be > 0.
  double shareOf(double value) const;
};

/// An axis for one or more finite values, with at most `maxTicks` ticks at multiples of 1, 2 or 5
/// times a power of ten. A constant (to 1e-5 of itself) is in its middle.
Axis makeAxis(const std::vector<double>& values, int maxTicks);

/// An axis with this range, high >= low, with such ticks in it. Without ticks if low and high are
/// equal.
Axis makeAxisWithin(double low, double high, int maxTicks);

/// The same with ticks at powers of ten, for values > 0. Without values > 0, an axis from 0.1 to
/// 10.
Axis makeLogarithmicAxis(const std::vector<double>& values, int maxTicks);

// ------------------------------------------------------------------------------------------------
// Scales in pictures: the meaning of colours, and lengths.

/// Meaning of the colours in a picture.
struct ColourScale {
  ColourMap map = ColourMap::Viridis;  ///< map from values to colours
  double least = 0;                    ///< the value of the scale's dark end
  double most = 1;                     ///< the value of its bright end
  std::string title;                   ///< quantity and unit, for example "target error, m"
  /// Background for contrast; absent: the map's own colours.
  std::optional<Colour> background = {};
};

/// The colour at a fraction of the scale.
Colour colourAt(const ColourScale& scale, double share);

/// Meaning of one of several colours.
struct LegendEntry {
  Colour colour;     ///< of the bricks
  std::string text;  ///< UTF-8, a few words
};

/// Position of a value on the scale, [0, 1] within it. 0 if the scale has no range.
double shareOf(const ColourScale& scale, double value);

/// A unit in the text of figures: "µm" for um, else its name.
std::string unitSymbol(const LengthUnit& unit);

/// Scale of a picture with a bar of length.
struct PictureScale {
  double metresPerPixel = 1;  ///< > 0
  LengthUnit unit;            ///< of the bar's text
};

/// Length of a scale bar: 1, 2 or 5 times a power of ten units, and its text, for example "0.5 m"
/// or "20 mm".
struct ScaleLength {
  double metres = 1;  ///< > 0
  std::string text;   ///< with its unit
};

/// The longest such length that is at most `longest` metres, > 0.
ScaleLength roundLength(double longest, const LengthUnit& unit);

/// Height of a bar of colours with its ticks and their values, ems of the text.
inline constexpr double kColourBarHeight = 2.4;

/// Draws scales in one size of text.
class ScaleDrawer {
 public:
  /// em: of the text, pixels. Throws OutputError if the font is missing.
  ScaleDrawer(int em, Colour text) : writer_(em), em_(em), text_(text) {}

  /// Draws a horizontal colour bar with its title on the left and ticks with round values below.
  /// Its height is kColourBarHeight. Its middle line is row y. It is centred on column x, as wide
  /// as fits in `width` pixels.
  void drawColourBar(Surface& surface, const ColourScale& scale, int x, int y, int width) const;

  /// Draws a square of each colour with its text on the right, side by side, centred on column x,
  /// middle line on row y; smaller if they need more than `width` pixels.
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
