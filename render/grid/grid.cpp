#include "render/grid/grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "render/grid/label.h"
#include "sim/base/error.h"
#include "sim/base/geometry.h"

namespace kirireel {
namespace {

/// Text smaller than this cannot be read, whatever the size of the pictures.
constexpr int kSmallestText = 9;

/// Height of the strip under a picture, in ems of its text; the baseline's place in it.
constexpr double kStripEms = 1.6;
constexpr double kBaselineEms = 1.25;

/// Height of the strip of a scale below the pictures, in ems of its text; and the longest bar of
/// length, in widths of a picture.
constexpr double kScaleEms = 2;
constexpr double kLongestBar = 0.5;

/// What stays around the models when pictures are trimmed, in heights of the trimmed picture.
constexpr double kTrimMargin = 0.05;
/// Least width of a trimmed picture, in its heights: room for a caption like "t = 12.34 s".
constexpr double kLeastAspect = 0.45;

/// Pixels from the top left corner; max is in the box.
using PixelBox = Eigen::AlignedBox2i;

PixelBox filledBox(const Frame& frame, Colour empty) {
  PixelBox box;
  for (int y = 0; y < frame.size.height; ++y) {
    for (int x = 0; x < frame.size.width; ++x) {
      if (frame.at(x, y) != empty) box.extend(Eigen::Vector2i(x, y));
    }
  }
  return box;
}

/// The box with its margin and at least the width of a caption, within the picture.
PixelBox withMargin(const PixelBox& box, FrameSize size) {
  const int height = box.sizes().y() + 1;
  const int margin = static_cast<int>(std::lround(kTrimMargin * height));
  const int width = box.sizes().x() + 1;
  const int missing = static_cast<int>(std::lround(kLeastAspect * height)) - width;
  const Eigen::Vector2i growth(std::max(margin, (missing + 1) / 2), margin);
  const PixelBox picture(Eigen::Vector2i(0, 0), Eigen::Vector2i(size.width - 1, size.height - 1));
  return PixelBox(box.min() - growth, box.max() + growth).intersection(picture);
}

Frame cutOut(const Frame& frame, const PixelBox& box) {
  const std::ptrdiff_t first = std::ptrdiff_t{4} * box.min().x();
  const std::ptrdiff_t end = std::ptrdiff_t{4} * (box.max().x() + 1);
  Frame part{{box.sizes().x() + 1, box.sizes().y() + 1}, {}};
  for (int y = box.min().y(); y <= box.max().y(); ++y) {
    const auto row = frame.pixels.begin() + static_cast<std::ptrdiff_t>(frame.rowStart(y));
    part.pixels.insert(part.pixels.end(), row + first, row + end);
  }
  return part;
}

/// The size at which the widest caption fits under its picture, at most the layout's.
int captionSize(const std::vector<GridPicture>& pictures, const GridLayout& layout) {
  const LabelWriter writer(layout.textSize);
  int widest = 1;
  for (const GridPicture& picture : pictures) {
    widest = std::max(widest, writer.width(picture.caption));
  }
  const double share = std::min(1.0, static_cast<double>(layout.picture.width) / widest);
  return std::max(kSmallestText, static_cast<int>(share * layout.textSize));
}

/// Draws the scales that all pictures share, one below the other at the lower end of the sheet.
void drawScales(Frame& sheet, const GridLayout& layout, const GridStyle& style) {
  if (layout.scales == 0) return;
  const ScaleDrawer drawer(layout.textSize, style.text);
  const int middle = sheet.size.width / 2;
  int y = sheet.size.height - layout.gap / 2 - layout.scales * layout.scaleHeight +
          layout.scaleHeight / 2;
  if (style.metresPerPixel) {
    const ScaleLength length =
        roundLength(kLongestBar * layout.picture.width * *style.metresPerPixel);
    const int pixels = static_cast<int>(std::lround(length.metres / *style.metresPerPixel));
    drawer.drawScaleBar(sheet, length.text, pixels, middle, y);
    y += layout.scaleHeight;
  }
  if (style.colourScale) {
    drawer.drawColourBar(sheet, *style.colourScale, middle, y, sheet.size.width - 2 * layout.gap);
  }
}

void requireFitting(const std::vector<GridPicture>& pictures, GridShape shape) {
  const int count = static_cast<int>(pictures.size());
  if (count > shape.cells()) {
    throw InputError(
        fmt::format("error: a grid of {} x {} has room for {} pictures, not {}; change --grid",
                    shape.rows, shape.columns, shape.cells(), count));
  }
  const FrameSize first = pictures.front().frame.size;
  for (const GridPicture& picture : pictures) {
    const FrameSize size = picture.frame.size;
    if (size == first) continue;
    throw InputError(fmt::format(
        "error: pictures of one grid must have one size, not {} x {} beside {} x {} pixels",
        size.width, size.height, first.width, first.height));
  }
}

}  // namespace

GridLayout layOutGrid(FrameSize picture, GridShape shape, const GridStyle& style) {
  if (shape.rows < 1 || shape.columns < 1) {
    throw InputError(
        fmt::format("error: a grid cannot have {} x {} cells; give at least one row and one "
                    "column, for example --grid 3x3",
                    shape.rows, shape.columns));
  }
  GridLayout layout;
  layout.picture = picture;
  layout.gap = static_cast<int>(std::lround(style.gap * picture.height));
  layout.textSize =
      std::max(kSmallestText, static_cast<int>(std::lround(style.captionSize * picture.height)));
  layout.captionHeight = static_cast<int>(std::lround(kStripEms * layout.textSize));
  layout.scaleHeight = static_cast<int>(std::lround(kScaleEms * layout.textSize));
  layout.scales = (style.colourScale ? 1 : 0) + (style.metresPerPixel ? 1 : 0);
  // In 64 bits: rows and columns may be anything that a person typed.
  const long long width =
      layout.gap + shape.columns * static_cast<long long>(picture.width + layout.gap);
  const long long height =
      layout.gap +
      shape.rows * static_cast<long long>(picture.height + layout.captionHeight + layout.gap) +
      static_cast<long long>(layout.scales) * layout.scaleHeight;
  if (width > kMaxFrameSide || height > kMaxFrameSide) {
    throw InputError(fmt::format(
        "error: a grid of {} x {} pictures of {} x {} pixels needs {} x {} pixels and "
        "may have {} a side; choose fewer or smaller pictures with --grid or --size",
        shape.rows, shape.columns, picture.width, picture.height, width, height, kMaxFrameSide));
  }
  layout.sheet = {static_cast<int>(width), static_cast<int>(height)};
  return layout;
}

Frame composeGrid(const std::vector<GridPicture>& pictures, GridShape shape,
                  const GridStyle& style) {
  if (pictures.empty()) throw InputError("error: a grid needs at least one picture; give it some");
  const GridLayout layout = layOutGrid(pictures.front().frame.size, shape, style);
  requireFitting(pictures, shape);
  const LabelWriter writer(captionSize(pictures, layout));
  Frame sheet = makeFrame(layout.sheet, style.background);
  for (int cell = 0; cell < static_cast<int>(pictures.size()); ++cell) {
    const GridPicture& picture = pictures[cell];
    const int left = layout.left(cell % shape.columns);
    const int upper = layout.upper(cell / shape.columns);
    pasteFrame(sheet, picture.frame, left, upper);
    const int textLeft = left + (layout.picture.width - writer.width(picture.caption)) / 2;
    const int baseline = upper + layout.picture.height +
                         static_cast<int>(std::lround(kBaselineEms * layout.textSize));
    writer.draw(sheet, picture.caption, textLeft, baseline, style.text);
  }
  drawScales(sheet, layout, style);
  return sheet;
}

void trimAlike(std::vector<GridPicture>& pictures) {
  PixelBox filled;
  for (const GridPicture& picture : pictures) {
    filled.extend(filledBox(picture.frame, pictures.front().frame.at(0, 0)));
  }
  if (filled.isEmpty()) return;
  const PixelBox box = withMargin(filled, pictures.front().frame.size);
  for (GridPicture& picture : pictures) picture.frame = cutOut(picture.frame, box);
}

namespace {

/// Two significant digits, so that figures side by side are alike: "2.0", "0.00012", "12".
std::string twoDigits(double value) {
  return value < 10 ? fmt::format("{:#.2g}", value) : fmt::format("{:.2g}", value);
}

/// Per cent to a tenth, without a zero at its end: "12.5%", "25%".
std::string progressText(double progress) {
  return fmt::format("{}%", std::round(1000 * progress) / 10);
}

}  // namespace

std::string captionText(const CaptionParts& parts, const CaptionValues& values) {
  std::vector<std::string> texts;
  if (parts.progress) texts.push_back(progressText(values.progress));
  if (parts.time) texts.push_back(fmt::format("t = {:.2f} s", values.time));
  if (parts.angle) texts.push_back(fmt::format("turned {:.1f}°", values.angle / kDegree));
  if (parts.error && values.error)
    texts.push_back(fmt::format("error {} m", twoDigits(*values.error)));
  if (parts.gap) texts.push_back(fmt::format("gap {} m", twoDigits(values.gap)));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace kirireel
