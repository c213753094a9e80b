// The sheet from the top: gap, headers of columns, then for each row letters, pictures, captions
// and a gap, and finally one strip per scale. Every height follows from the em of the text, which
// is given or a fraction of a picture's height. So layOutGrid() needs no picture, and the same
// layout is used for pixels (composeGrid) and vector graphics.
//
// If the em is given (for print), captions are broken into lines. Otherwise all text shrinks until
// the widest caption fits.
//
// Trimming: one box contains the pixels of all pictures that differ from the background. All are
// cut to this box and keep one scale.
#include "render/picture/grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {
namespace {

/// Text smaller than this cannot be read in pictures of any size.
constexpr int kSmallestText = 9;

/// Height of the strip below a picture, in ems of its text; the baseline's position in it.
constexpr double kStripEms = 1.6;
constexpr double kBaselineEms = 1.25;
/// Distance of two lines of a caption; the strip above a picture with its letter, and its baseline;
/// ems.
constexpr double kCaptionLineEms = 1.25;
constexpr double kLetterEms = 1.4;
constexpr double kLetterBaselineEms = 1;
/// Em of an arrow between two pictures, in ems of the text; and the gap for it, in heights of a
/// picture.
constexpr double kArrowEms = 1.5;
constexpr double kArrowGap = 0.14;

/// Height of the strip of a scale below the pictures, in ems of its text; and the longest bar of
/// length, in widths of a picture.
constexpr double kScaleEms = 2;
constexpr double kLongestBar = 0.5;

/// Margin around the models in trimmed pictures, in heights of the trimmed picture.
constexpr double kTrimMargin = 0.05;
/// Least width of a trimmed picture, in its heights, for a caption like "t = 12.34 s".
constexpr double kMinAspect = 0.45;

/// Pixels from the top left corner; max is inside the box.
using PixelBox = Eigen::AlignedBox2i;

/// Empty if all pixels are equal.
PixelBox filledBox(const Frame& frame, Colour empty) {
  PixelBox box;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) {
      if (frame.at(x, y) != empty) box.extend(Eigen::Vector2i(x, y));
    }
  }
  return box;
}

/// The box with its margin and at least the width of a caption. It grows equally on both sides and
/// is clipped at the picture's borders.
PixelBox withMargin(const PixelBox& box, FrameSize size) {
  const int height = box.sizes().y() + 1;
  const int margin = wholePixels(kTrimMargin * height);
  const int width = box.sizes().x() + 1;
  const int missing = wholePixels(kMinAspect * height) - width;
  const Eigen::Vector2i growth(std::max(margin, (missing + 1) / 2), margin);
  const PixelBox picture(Eigen::Vector2i(0, 0), Eigen::Vector2i(size.width - 1, size.height - 1));
  return PixelBox(box.min() - growth, box.max() + growth).intersection(picture);
}

/// The size at which the widest caption or header fits, at most the layout's and at least the least
/// legible size.
int captionSize(const std::vector<std::string>& captions, const GridLayout& layout,
                const GridStyle& style) {
  const LabelWriter writer(layout.textSize);
  const int widest = std::max({1, writer.widest(captions), writer.widest(style.heads)});
  const double share = std::min(1.0, static_cast<double>(layout.picture.width) / widest);
  return std::max(kSmallestText, static_cast<int>(share * layout.textSize));
}

/// The lines of a caption under its picture.
std::vector<std::string> captionLines(const std::string& caption, const LabelWriter& writer,
                                      int width) {
  return wrapText(
      caption, [&writer](const std::string& line) { return double(writer.width(line)); }, width);
}

/// "a" to "z", then "aa", "ab" and so on, in the form of the style.
std::string panelLetter(int number, PanelLetters form) {
  const char first = form == PanelLetters::Capital ? 'A' : 'a';
  std::string letters;
  for (int rest = number; rest >= 0; rest = rest / 26 - 1) {
    letters.insert(letters.begin(), static_cast<char>(first + rest % 26));
  }
  const bool isBare = form == PanelLetters::Small || form == PanelLetters::Capital;
  return isBare ? letters : '(' + letters + ')';
}

/// Whether letters name rows, not pictures.
bool nameRows(const GridStyle& style) {
  return !style.rows.empty() && style.letters != PanelLetters::Plain;
}

/// Draws one line centred in `width` pixels.
void drawCentred(Surface& sheet, const std::string& line, int left, int width, double baseline,
                 int em, Colour colour) {
  sheet.text(line, left + (width - LabelWriter(em).width(line)) / 2, baseline, em, colour);
}

void drawHeads(Surface& sheet, const GridLayout& layout, const GridStyle& style, int em) {
  const double baseline = layout.gap + std::round(kHeadBaselineEms * layout.textSize);
  for (int column = 0; column < static_cast<int>(style.heads.size()); ++column) {
    drawCentred(sheet, style.heads[column], layout.left(column), layout.picture.width, baseline, em,
                style.text);
  }
}

/// Draws the letter and the header of each row at its left end, its bar of length at its right end.
void drawRowHeads(Surface& sheet, const GridLayout& layout, const GridStyle& style, int em) {
  const ScaleDrawer drawer(em, style.text);
  const int right = layout.sheet.width - layout.gap;
  for (int row = 0; row < static_cast<int>(style.rows.size()); ++row) {
    const auto& [picture, head, scale] = style.rows[row];
    const double upper = layout.upper(row) - layout.letterHeight - layout.rowHeadHeight;
    const double baseline = upper + std::round(kHeadBaselineEms * layout.textSize);
    drawHead(sheet, nameRows(style) ? style.letters : PanelLetters::None, row, head, layout.gap,
             baseline, em, style.text);
    if (!scale) continue;
    const auto& [metresPerPixel, unit] = *scale;
    const ScaleLength length =
        roundLength(kLongestBar * layout.picture.width * metresPerPixel, unit);
    const int pixels = wholePixels(length.metres / metresPerPixel);
    const int room = pixels + LabelWriter(em).width(length.text) + em;
    drawer.drawScaleBar(sheet, length.text, pixels, right - room / 2,
                        static_cast<int>(baseline - em / 3));
  }
}

/// Draws arrows between pictures at half their height, but none after the last picture of a row.
void drawArrows(Surface& sheet, const GridLayout& layout, const GridStyle& style, int cells,
                int columns) {
  const int em = std::max(1, std::min(layout.columnGap, wholePixels(kArrowEms * layout.textSize)));
  for (int cell = 0; cell + 1 < cells; ++cell) {
    if (cell % columns == columns - 1) continue;
    // The middle of the arrow is about a third of an em above the baseline.
    const int row = cell / columns;
    const double baseline = layout.upper(row) + layout.pictureOf(row).height / 2 + em / 3;
    drawCentred(sheet, kArrow, layout.left(cell % columns) + layout.picture.width, layout.columnGap,
                baseline, em, style.text);
  }
}

/// Draws the common scales of all pictures, one below the other at the lower end of the sheet: bar
/// of length, bar of colours, legend.
void drawScales(Surface& sheet, const GridLayout& layout, const GridStyle& style) {
  if (layout.scales == 0) return;
  const ScaleDrawer drawer(layout.textSize, style.text);
  const int middle = layout.sheet.width / 2;
  int y = layout.sheet.height - layout.gap / 2 - layout.scales * layout.scaleHeight +
          layout.scaleHeight / 2;
  if (style.scale) {
    const auto& [metresPerPixel, unit] = *style.scale;
    const ScaleLength length =
        roundLength(kLongestBar * layout.picture.width * metresPerPixel, unit);
    const int pixels = wholePixels(length.metres / metresPerPixel);
    drawer.drawScaleBar(sheet, length.text, pixels, middle, y);
    y += layout.scaleHeight;
  }
  if (style.colourScale) {
    drawer.drawColourBar(sheet, *style.colourScale, middle, y, layout.sheet.width - 2 * layout.gap);
    y += layout.scaleHeight;
  }
  if (!style.legend.empty()) {
    drawer.drawLegend(sheet, style.legend, middle, y, layout.sheet.width - 2 * layout.gap);
  }
}

void requireFitting(const std::vector<GridPicture>& pictures, GridShape shape,
                    const GridLayout& layout) {
  const int count = static_cast<int>(pictures.size());
  if (count > shape.cells()) {
    throw InputError(
        fmt::format("error: a grid of {} x {} has room for {} pictures, not {}; change --grid",
                    shape.rows, shape.columns, shape.cells(), count));
  }
  for (int cell = 0; cell < count; ++cell) {
    const FrameSize size = pictures[cell].frame.size;
    const FrameSize first = layout.pictureOf(cell / shape.columns);
    if (size == first) continue;
    throw InputError(fmt::format(
        "error: pictures of one grid must have the same size, not {} x {} and {} x {} pixels",
        size.width, size.height, first.width, first.height));
  }
}

/// Throws InputError.
void requireShape(GridShape shape, const GridStyle& style) {
  if (shape.rows < 1 || shape.columns < 1) {
    throw InputError(
        fmt::format("error: a grid cannot have {} x {} cells; give at least one row and one "
                    "column, for example --grid 3x3",
                    shape.rows, shape.columns));
  }
  const std::size_t heads = style.heads.size();
  if (heads == 0 || heads == static_cast<std::size_t>(shape.columns)) return;
  throw InputError(
      fmt::format("error: {} columns have {} heads; give --column-heads one per column, separated "
                  "by commas, or change --grid",
                  shape.columns, heads));
}

}  // namespace

void drawHead(Surface& surface, PanelLetters form, int number, const std::string& text, double left,
              double baseline, int em, Colour colour) {
  if (form != PanelLetters::None) {
    const Weight weight = form == PanelLetters::Plain ? Weight::Regular : Weight::Bold;
    const std::string letter = panelLetter(number, form);
    surface.text(letter, left, baseline, em, colour, weight);
    left += LabelWriter(em, findFont(weight)).width(letter) + 0.6 * em;
  }
  if (!text.empty()) surface.text(text, left, baseline, em, colour);
}

double columnGap(const GridStyle& style) {
  return style.arrows ? kArrowGap : style.gap;
}

GridLayout layOutGrid(FrameSize picture, GridShape shape, const GridStyle& style, int lines) {
  requireShape(shape, style);
  GridLayout layout;
  layout.picture = picture;
  layout.gap = wholePixels(style.gap * picture.height);
  layout.columnGap = wholePixels(columnGap(style) * picture.height);
  layout.textSize = std::max(kSmallestText, wholePixels(style.captionSize * picture.height));
  if (style.textSize) layout.textSize = *style.textSize;
  layout.captionHeight = wholePixels((kStripEms + (lines - 1) * kCaptionLineEms) * layout.textSize);
  if (style.letters != PanelLetters::None && !nameRows(style)) {
    layout.letterHeight = wholePixels(kLetterEms * layout.textSize);
  }
  for (const GridRow& row : style.rows) layout.rows.push_back(row.picture);
  if (!style.rows.empty()) {
    layout.rowHeadHeight = wholePixels(kHeadEms * layout.textSize);
  }
  if (!style.heads.empty()) {
    layout.headHeight = wholePixels(kHeadEms * layout.textSize);
  }
  const double scaleEms = kScaleEms + (style.colourScale ? kColourBarHeight - 1 : 0);
  layout.scaleHeight = wholePixels(scaleEms * layout.textSize);
  layout.scales =
      (style.colourScale ? 1 : 0) + (style.legend.empty() ? 0 : 1) + (style.scale ? 1 : 0);
  // In 64 bits, because the typed numbers of rows and columns may be large.
  const long long width = 2LL * layout.gap + shape.columns * static_cast<long long>(picture.width) +
                          (shape.columns - 1) * static_cast<long long>(layout.columnGap);
  long long height =
      layout.gap + layout.headHeight + static_cast<long long>(layout.scales) * layout.scaleHeight +
      shape.rows * static_cast<long long>(layout.rowHeadHeight + layout.letterHeight +
                                          layout.captionHeight + layout.gap);
  if (style.rows.empty()) height += shape.rows * static_cast<long long>(picture.height);
  for (const GridRow& row : style.rows) height += row.picture.height;
  if (width > kMaxFrameSide || height > kMaxFrameSide) {
    throw InputError(fmt::format(
        "error: a grid of {} x {} pictures of {} x {} pixels needs {} x {} pixels, at most {} per "
        "side are allowed; choose fewer or smaller pictures with --grid or --size",
        shape.rows, shape.columns, picture.width, picture.height, width, height, kMaxFrameSide));
  }
  layout.sheet = {static_cast<int>(width), static_cast<int>(height)};
  return layout;
}

GridLayout layOutGrid(FrameSize picture, GridShape shape, const GridStyle& style,
                      const std::vector<std::string>& captions) {
  if (!style.textSize) return layOutGrid(picture, shape, style);
  const LabelWriter writer(*style.textSize);
  std::size_t most = 1;
  for (const std::string& caption : captions) {
    most = std::max(most, captionLines(caption, writer, picture.width).size());
  }
  return layOutGrid(picture, shape, style, static_cast<int>(most));
}

void drawGridText(Surface& surface, const GridLayout& layout, const GridStyle& style,
                  const std::vector<std::string>& captions, int columns) {
  const int em = style.textSize ? *style.textSize : captionSize(captions, layout, style);
  const LabelWriter writer(em);
  drawHeads(surface, layout, style, em);
  if (!style.rows.empty()) drawRowHeads(surface, layout, style, em);
  if (style.arrows) {
    drawArrows(surface, layout, style, static_cast<int>(captions.size()), columns);
  }
  for (int cell = 0; cell < static_cast<int>(captions.size()); ++cell) {
    const int row = cell / columns;
    const int left = layout.left(cell % columns), upper = layout.upper(row);
    if (layout.letterHeight > 0) {
      const double baseline = upper - (kLetterEms - kLetterBaselineEms) * layout.textSize;
      drawHead(surface, style.letters, cell, "", left, std::round(baseline), em, style.text);
    }
    double baseline =
        upper + layout.pictureOf(row).height + std::lround(kBaselineEms * layout.textSize);
    const int width = style.textSize ? layout.picture.width : std::numeric_limits<int>::max();
    for (const std::string& line : captionLines(captions[cell], writer, width)) {
      drawCentred(surface, line, left, layout.picture.width, baseline, em, style.text);
      baseline += std::round(kCaptionLineEms * layout.textSize);
    }
  }
  drawScales(surface, layout, style);
}

std::vector<std::string> captionsOf(const std::vector<GridPicture>& pictures) {
  std::vector<std::string> captions;
  for (const GridPicture& picture : pictures) captions.push_back(picture.caption);
  return captions;
}

Frame composeGrid(const std::vector<GridPicture>& pictures, GridShape shape,
                  const GridStyle& style) {
  if (pictures.empty()) throw InputError("error: a grid needs at least one picture");
  const std::vector<std::string> captions = captionsOf(pictures);
  FrameSize largest = pictures.front().frame.size;
  for (const GridRow& row : style.rows) {
    largest = {std::max(largest.width, row.picture.width),
               std::max(largest.height, row.picture.height)};
  }
  const GridLayout layout = layOutGrid(largest, shape, style, captions);
  requireFitting(pictures, shape, layout);
  Frame sheet = makeFrame(layout.sheet, style.background);
  for (int cell = 0; cell < static_cast<int>(pictures.size()); ++cell) {
    const int row = cell / shape.columns;
    pasteFrame(sheet, pictures[cell].frame, layout.left(cell % shape.columns, row),
               layout.upper(row));
  }
  FrameSurface surface(sheet);
  drawGridText(surface, layout, style, captions, shape.columns);
  return sheet;
}

PictureBox PictureBox::scaled(double scale) const {
  const auto pixels = [scale](int length) { return wholePixels(scale * length); };
  return {pixels(left),
          pixels(upper),
          {std::max(1, pixels(left + size.width) - pixels(left)),
           std::max(1, pixels(upper + size.height) - pixels(upper))}};
}

PictureBox filledPart(const std::vector<GridPicture>& pictures) {
  const Frame& first = pictures.front().frame;
  PixelBox filled;
  for (const GridPicture& picture : pictures) {
    filled.extend(filledBox(picture.frame, first.at(0, 0)));
  }
  if (filled.isEmpty()) return {0, 0, first.size};
  const PixelBox box = withMargin(filled, first.size);
  return {box.min().x(), box.min().y(), {box.sizes().x() + 1, box.sizes().y() + 1}};
}

Frame cutOut(const Frame& frame, const PictureBox& part) {
  const std::ptrdiff_t first = std::ptrdiff_t{4} * part.left;
  const std::ptrdiff_t end = std::ptrdiff_t{4} * (part.left + part.size.width);
  Frame cut{part.size, {}};
  for (int y = part.upper; y < part.upper + part.size.height; ++y) {
    const auto row = frame.pixels.begin() + static_cast<std::ptrdiff_t>(frame.rowStart(y));
    cut.pixels.insert(cut.pixels.end(), row + first, row + end);
  }
  return cut;
}

namespace {

/// Two significant digits: "2.0", "0.00012", "12".
std::string twoDigits(double value) {
  return value < 10 ? fmt::format("{:#.2g}", value) : fmt::format("{:.2g}", value);
}

}  // namespace

std::string captionText(const CaptionParts& parts, const CaptionValues& values) {
  const auto lengthText = [&](double metres) {
    return fmt::format("{} {}", twoDigits(metres / values.unit.metres), unitSymbol(values.unit));
  };
  std::vector<std::string> texts;
  if (parts.progress) texts.push_back(fmt::format("{}%", std::round(1000 * values.progress) / 10));
  if (parts.time) texts.push_back(fmt::format("t = {:.2f} s", values.time));
  if (parts.angle) texts.push_back(fmt::format("turned {:.1f}°", values.angle / kDegree));
  if (parts.error && values.error) texts.push_back("error " + lengthText(*values.error));
  if (parts.gap) texts.push_back("gap " + lengthText(values.gap));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace kirireel::picture
