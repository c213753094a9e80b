// A sheet is made in this order: all pictures are painted at the size that was asked for; margins
// that all of them leave empty are found (filledPart). Where the sheet has a width in print, the
// enlargement that gives it is computed and all pictures are painted again, larger: enlarging
// pixels would blur them. Then they are cut alike, laid out, and written as PNG; SVG and PDF draw
// the same layout from the sketches, without pixels.
//
// With W millimetres and d dots an inch the sheet is W d / 25.4 pixels wide; text of p points is p
// / 72 inches high, whatever the width came to be.
#include "render/record/panels.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "render/folder/output_folder.h"
#include "render/grid/label.h"
#include "render/png/png.h"
#include "render/record/frame_sink.h"
#include "render/record/stopwatch.h"
#include "render/vector/cairo_canvas.h"
#include "render/vector/drawing.h"
#include "render/vector/svg.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

constexpr double kMillimetresPerInch = 25.4;
constexpr double kPointsPerInch = 72;

/// Scales are those of the first row, which all rows share.
GridStyle gridStyle(const Stage& stage, const PictureSettings& settings) {
  GridStyle style;
  style.background = stage.style().background;
  style.text = stage.style().text;
  style.colourScale = stage.colourScale();
  style.legend = stage.legend();
  if (settings.scaleBar) style.metresPerPixel = stage.metresPerPixel();
  style.letters = settings.letters;
  style.arrows = settings.arrows;
  style.heads = settings.columnHeads;
  return style;
}

/// Outlines are as wide as in the pictures, in pixels of their height.
PageSettings pageSettings(const Stage& stage, FrameSize size, const std::string& description) {
  const Style& style = stage.style();
  return {.size = size,
          .background = style.background,
          .outline = style.edge,
          .paleOutline = style.paleEdge,
          .outlineWidth = style.edgeWidth * stage.pictureSize().height,
          .fontFamily = fontFamily(),
          .description = description};
}

}  // namespace

const char* pageFile(PageFormat format) {
  return format == PageFormat::Svg ? output::kSnapshotsSvg : output::kSnapshotsPdf;
}

Moment stillOf(const FrameState& state) {
  return {state.moment.time, state.sample.poses, state.sample.pinned, state.moment.turn};
}

/// All pictures anew, of this size.
void PanelSheet::takeAll(FrameSize size) {
  const CpuTimer timer(report_.recordCost.cpuSecondsRender);
  studios_.clear();
  pictures_.clear();
  for (const PanelRow& row : rows_) {
    studios_.push_back(std::make_unique<Studio>(size, row.look, row.motif));
    for (std::size_t k = 0; k < row.states.size(); ++k) {
      pictures_.push_back({studios_.back()->take(stillOf(row.states[k])), row.captions[k]});
    }
  }
}

/// Each picture as vector graphics.
void PanelSheet::writeDrawings() {
  int number = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const Stage& stage = studios_[row]->stage();
    for (const FrameState& state : rows_[row].states) {
      const Moment moment = stillOf(state);
      report_.files.push_back(snapshotDrawing(++number).string());
      const std::unique_ptr<Canvas> page =
          makeSvgCanvas(pageSettings(stage, stage.pictureSize(), settings_.madeBy));
      drawSketch(stage.sketch(moment), stage.camera(moment), stage.pictureSize(), {0, 0}, "",
                 *page);
      writeTextFile(settings_.folder / report_.files.back(), page->finish());
    }
  }
}

/// How much larger pictures must be painted, of which this part is shown, for the sheet to be as
/// wide as it is to be in print; less where pictures would be too large.
double PanelSheet::enlargement(const PictureBox& part, const GridStyle& style) const {
  if (!settings_.gridWidth) return 1;
  const double wanted = *settings_.gridWidth / kMillimetresPerInch * settings_.gridDotsPerInch();
  const int columns = shape_.columns;
  const double most = kMaxFrameSide / std::max(settings_.size.width, settings_.size.height);
  const double gaps = (2 * style.gap + (columns - 1) * columnGap(style)) * part.size.height;
  return std::min(most, wanted / (columns * part.size.width + gaps));
}

/// Em of the text that is to have a size in print, pixels.
int PanelSheet::textSize(const PictureBox& part, const GridStyle& style) const {
  const double inches = *settings_.gridWidth / kMillimetresPerInch;
  const double dots = layOutGrid(part.size, shape_, style).sheet.width / inches;
  return std::max(1, static_cast<int>(std::lround(*settings_.fontPoints / kPointsPerInch * dots)));
}

/// Each picture is cut off at its part, as cutAlike() does with pixels.
void PanelSheet::writePage(PageFormat format, const PictureBox& part, const GridLayout& layout,
                           const GridStyle& style) {
  PageSettings page = pageSettings(studios_.front()->stage(), layout.sheet, settings_.madeBy);
  if (settings_.gridWidth) {
    page.pixelsPerInch = layout.sheet.width / *settings_.gridWidth * kMillimetresPerInch;
  }
  const std::unique_ptr<Canvas> canvas = makeCanvas(format, page);
  canvas->begin("pictures");
  int cell = 0;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const Stage& stage = studios_[row]->stage();
    for (const FrameState& state : rows_[row].states) {
      const Eigen::Vector2d corner(layout.left(cell % shape_.columns),
                                   layout.upper(cell / shape_.columns));
      const std::string name = fmt::format("picture_{:02}", ++cell);
      const Moment moment = stillOf(state);
      canvas->beginWithin(name, corner.x(), corner.y(), part.size.width, part.size.height);
      drawSketch(stage.sketch(moment), stage.camera(moment), stage.pictureSize(),
                 corner - Eigen::Vector2d(part.left, part.upper), name, *canvas);
      canvas->end();
    }
  }
  canvas->end();
  canvas->begin("text");
  drawGridText(*canvas, layout, style, captionsOf(pictures_), shape_.columns);
  canvas->end();
  report_.files.emplace_back(pageFile(format));
  writeTextFile(settings_.folder / report_.files.back(), canvas->finish());
}

void PanelSheet::write() {
  takeAll(settings_.size);
  if (settings_.svg) writeDrawings();
  PictureBox part = filledPart(pictures_);
  const double scale = enlargement(part, gridStyle(studios_.front()->stage(), settings_));
  if (scale != 1) {
    part = part.scaled(scale);
    takeAll(PictureBox{0, 0, settings_.size}.scaled(scale).size);
  }
  cutAlike(pictures_, part);
  GridStyle style = gridStyle(studios_.front()->stage(), settings_);
  if (settings_.fontPoints) style.textSize = textSize(part, style);
  const GridLayout layout = layOutGrid(part.size, shape_, style, captionsOf(pictures_));
  PngSettings png = pngSettings(settings_);
  if (settings_.gridWidth) {
    png.dotsPerInch = layout.sheet.width / *settings_.gridWidth * kMillimetresPerInch;
  }
  writePng(composeGrid(pictures_, shape_, style), settings_.folder / output::kSnapshots, png);
  report_.files.emplace_back(output::kSnapshots);
  for (const PageFormat format : settings_.pages) writePage(format, part, layout, style);
}

}  // namespace kirireel
