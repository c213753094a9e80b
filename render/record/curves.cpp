// Writes curves.csv and the figures of a run.
//
// curves.csv is text in UTF-8 with commas (RFC 4180, but with "\n" at line ends). The first line
// holds the names of the columns, each with its unit at its end (time_s, opening_mean_deg); each
// further line is a sample of the trajectory, by rising time. A value that does not exist is an
// empty field, which spreadsheets and pandas read as missing, where "nan" would make a column text.
//
// Numbers have the shortest digits that read back to the same double.
#include "render/record/curves.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "render/output/output_folder.h"
#include "render/picture/canvas.h"
#include "render/picture/label.h"
#include "render/record/pace.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/files.h"

namespace kirireel::record {
namespace {

constexpr const char* kTable = "curves.csv";
// The column that --against opening takes.
constexpr const char* kOpening = "opening_mean_deg";

/// A name for each format: a folder can have all of them.
const char* fileOf(picture::PageFormat format) {
  switch (format) {
    case picture::PageFormat::Svg:
      return "curves.svg";
    case picture::PageFormat::Pdf:
      return "curves.pdf";
    case picture::PageFormat::Png:
      break;
  }
  return "curves.png";
}

/// No field needs quotation marks: all are numbers.
std::string fieldText(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

/// The curves of all groups, in order.
std::vector<const trajectory::Curve*> allCurves(const trajectory::RunCurves& curves) {
  std::vector<const trajectory::Curve*> all;
  for (const trajectory::CurveGroup& group : curves.groups) {
    for (const trajectory::Curve& curve : group.curves) all.push_back(&curve);
  }
  for (const trajectory::Curve& curve : curves.joints) all.push_back(&curve);
  return all;
}

/// The values that curves are drawn against, one a sample. They need not rise: a sheet may close
/// again.
PlotAbscissa abscissaOf(const trajectory::RunCurves& curves, const std::vector<double>& progress,
                        CurvesAgainst against) {
  if (against == CurvesAgainst::Time) return {"simulated time, s", curves.times};
  if (against == CurvesAgainst::Progress) return {"share of the motion", progress};
  for (const trajectory::Curve* curve : allCurves(curves)) {
    if (curve->column == kOpening && curve->hasValues()) {
      return {"mean opening, degrees", curve->values};
    }
  }
  throw InputError("error: the model has no joints that open; plot --against time or progress");
}

}  // namespace

std::string curvesTable(const trajectory::RunCurves& curves, const std::vector<double>& progress) {
  const std::vector<const trajectory::Curve*> columns = allCurves(curves);
  std::string table = "time_s,progress";
  for (const trajectory::Curve* curve : columns) table += "," + curve->column;
  table += '\n';
  for (std::size_t k = 0; k < curves.times.size(); ++k) {
    table += fmt::format("{},{}", curves.times[k], progress[k]);
    for (const trajectory::Curve* curve : columns) table += "," + fieldText(curve->values[k]);
    table += '\n';
  }
  return table;
}

std::vector<std::string> writeCurves(const trajectory::TrajectoryReader& run,
                                     const CurvesSettings& settings) {
  std::vector<std::string> names = {kTable};
  for (const picture::PageFormat format : settings.plots) names.emplace_back(fileOf(format));
  output::FileSet files(settings.folder, output::kContents);
  files.requireFree([&names](const std::string& name) {
    return name == output::kContents || std::ranges::find(names, name) != names.end();
  });
  const trajectory::RunCurves curves = trajectory::curvesOf(run);
  // The share of the motion at a time, as in a video at an even pace; 0 at the start, 1 at the end.
  const MotionCurve motion = motionOf(run);
  std::vector<double> progress;
  for (const double time : curves.times) progress.push_back(motion.shareAt(time));
  writeTextFile(files.stage() / kTable, curvesTable(curves, progress));
  PlotSettings plot = settings.plot;
  plot.madeBy = fmt::format("Kirireel {}, model {}", programVersion(), run.subject().model.name);
  for (const picture::PageFormat format : settings.plots) {
    writeTextFile(files.stage() / fileOf(format),
                  plotCurves(curves, abscissaOf(curves, progress, settings.against), format, plot));
  }
  files.commit(names);
  return names;
}

// ------------------------------------------------------------------------------------------------
// A figure is a grid of diagrams, two in a row, one for each group of curves with the same unit.
// All lengths follow from two numbers: the figure's width W (millimetres) and the size of its text
// (points, 1/72 inch). With d dots per inch the em of the text is round(points / 72 d) pixels and
// the figure is round(W / 25.4 d) pixels wide. Everything else is in em: figures of any width look
// alike in print.
//
//     4.5 em for numbers | diagram, height = 0.5 width | 0.5 em
//     2 em above it for its title, 4 em below for numbers and words
//
// Axes: a group's values decide the vertical one (makeAxis, makeLogarithmicAxis in label.h), the
// abscissa the horizontal one, which begins and ends with the curves. A place in a diagram is a
// pair of shares, 0 to 1 from left to right and from bottom to top.
//
// The same code draws SVG, PDF and PNG: Canvas (render/picture/canvas.h) hides which.

namespace {

constexpr picture::Colour kText = {30, 30, 30};
constexpr picture::Colour kFrame = {120, 126, 134};
constexpr picture::Colour kGrid = {226, 229, 233};
/// Of a group's lines in turn: they stay apart in grey and for the colour-blind.
constexpr picture::Colour kLines[] = {{43, 100, 166}, {194, 87, 26}, {61, 139, 95}};

constexpr int kColumns = 2;
// About as many; makeAxis takes round numbers.
constexpr int kTicksAcross = 5;
constexpr int kTicksUp = 5;
/// Height of a diagram in parts of its width.
constexpr double kAspect = 0.5;

/// A rectangle of the figure, pixels. y points down, as in pictures.
struct Box {
  double left, upper, width, height;

  double right() const { return left + width; }
  double lower() const { return upper + height; }
};

/// Draws diagrams of one figure. Lengths are in em of its text.
class Plotter {
 public:
  Plotter(picture::Canvas& canvas, int em, const PlotAbscissa& abscissa)
      : canvas_(canvas),
        em_(em),
        writer_(em),
        abscissa_(abscissa),
        across_(picture::makeAxis(abscissa.values, kTicksAcross)) {
    // Curves begin and end at the borders.
    const auto [least, largest] = std::ranges::minmax_element(abscissa.values);
    if (*least < *largest) {
      across_.low = *least;
      across_.high = *largest;
    }
  }

  /// Lines are 0.13 em wide, 0.9 points in a figure with text of 7 points.
  void draw(const trajectory::CurveGroup& group, const Box& box) {
    const picture::Axis up = axisOf(group);
    drawGrid(up, box);
    for (std::size_t k = 0; k < group.curves.size(); ++k) {
      canvas_.lines(linesOf(group.curves[k], up, box), 0.13 * em_, kLines[k % std::size(kLines)]);
    }
    drawTitle(group, box);
    const double middle = box.left + 0.5 * box.width;
    write(abscissa_.title, middle - 0.5 * width(abscissa_.title), box.lower() + 2.5 * em_, kText);
  }

 private:
  /// All curves of a group share one axis; missing values are omitted.
  static picture::Axis axisOf(const trajectory::CurveGroup& group) {
    std::vector<double> values;
    for (const trajectory::Curve& curve : group.curves) {
      std::ranges::copy_if(curve.values, std::back_inserter(values),
                           [](double value) { return std::isfinite(value); });
    }
    return group.isLogarithmic ? picture::makeLogarithmicAxis(values, kTicksUp)
                               : picture::makeAxis(values, kTicksUp);
  }

  /// Pixels from two shares of the box.
  Eigen::Vector2d place(double across, double up, const Box& box) const {
    return {box.left + across * box.width, box.lower() - up * box.height};
  }

  /// Ticks and numbers of both axes, and the two axes themselves.
  void drawGrid(const picture::Axis& up, const Box& box) {
    std::vector<picture::Canvas::Points> grid;
    for (std::size_t k = 0; k < up.ticks.size(); ++k) {
      const double share = up.shareOf(up.ticks[k]);
      grid.push_back({place(0, share, box), place(1, share, box)});
      write(up.texts[k], box.left - 0.5 * em_ - width(up.texts[k]),
            place(0, share, box).y() + 0.35 * em_, kText);
    }
    for (std::size_t k = 0; k < across_.ticks.size(); ++k) {
      const double share = across_.shareOf(across_.ticks[k]);
      // The axis was cut to the curves' ends, beyond which its first and last ticks may lie.
      if (share < -1e-9 || share > 1 + 1e-9) continue;
      grid.push_back({place(share, 0, box), place(share, 1, box)});
      write(across_.texts[k], place(share, 0, box).x() - 0.5 * width(across_.texts[k]),
            box.lower() + 1.25 * em_, kText);
    }
    canvas_.lines(grid, 0.06 * em_, kGrid);
    canvas_.lines({{place(0, 1, box), place(0, 0, box), place(1, 0, box)}}, 0.08 * em_, kFrame);
  }

  /// A line for each stretch of samples that have a place.
  std::vector<picture::Canvas::Points> linesOf(const trajectory::Curve& curve,
                                               const picture::Axis& up, const Box& box) const {
    std::vector<picture::Canvas::Points> lines(1);
    for (std::size_t k = 0; k < curve.values.size(); ++k) {
      const double value = curve.values[k], across = abscissa_.values[k];
      const bool isShown =
          std::isfinite(across) && std::isfinite(value) && (!up.isLogarithmic || value > 0);
      if (isShown) {
        lines.back().push_back(place(across_.shareOf(across), up.shareOf(value), box));
      } else if (!lines.back().empty()) {
        lines.emplace_back();
      }
    }
    // A single sample makes no line.
    std::erase_if(lines, [](const picture::Canvas::Points& line) { return line.size() < 2; });
    return lines;
  }

  /// The name of the group and its unit to the left, the curves' names in their colours to the
  /// right.
  void drawTitle(const trajectory::CurveGroup& group, const Box& box) {
    const double baseline = box.upper - 0.6 * em_;
    write(group.unit.empty() ? group.name : group.name + ", " + group.unit, box.left, baseline,
          kText);
    if (group.curves.size() < 2) return;
    double right = box.right();
    // Names are at the right border in the order of the curves: they are set from the last one on.
    for (std::size_t k = group.curves.size(); k-- > 0;) {
      if (!group.curves[k].hasValues()) continue;
      right -= width(group.curves[k].name);
      write(group.curves[k].name, right, baseline, kLines[k % std::size(kLines)]);
      right -= em_;
    }
  }

  double width(const std::string& text) const { return writer_.width(text); }

  void write(const std::string& text, double left, double baseline, picture::Colour colour) {
    canvas_.text(text, left, baseline, em_, colour);
  }

  picture::Canvas& canvas_;
  int em_;
  picture::LabelWriter writer_;
  const PlotAbscissa& abscissa_;
  picture::Axis across_;
};

/// The places of the diagrams of a figure.
struct PlotLayout {
  int em = 0;
  Box first{};        ///< the diagram at the upper left
  double across = 0;  ///< from one diagram to the next
  double down = 0;    ///< from one row to the next
  picture::FrameSize size;

  Box box(int number) const {
    Box result = first;
    result.left += number % kColumns * across;
    result.upper += number / kColumns * down;
    return result;
  }
};

PlotLayout layOut(int diagrams, const PlotSettings& settings) {
  PlotLayout layout;
  layout.em =
      std::max(4, static_cast<int>(std::lround(settings.fontPoints / picture::kPointsPerInch *
                                               settings.dotsPerInch)));
  const double em = layout.em;
  const int columns = std::min(kColumns, diagrams);
  const int rows = (diagrams + kColumns - 1) / kColumns;
  layout.size.width = static_cast<int>(
      std::lround(settings.width / picture::kMillimetresPerInch * settings.dotsPerInch));
  // From here on in pixels, not rounded.
  layout.across = (layout.size.width - em) / columns;
  const double wide = layout.across - 5 * em;
  layout.first = {4.5 * em, 2 * em, wide, kAspect * wide / (diagrams == 1 ? 1.2 : 1)};
  layout.down = layout.first.height + 6 * em;
  layout.size.height = static_cast<int>(std::lround(rows * layout.down));
  return layout;
}

}  // namespace

std::string plotCurves(const trajectory::RunCurves& curves, const PlotAbscissa& abscissa,
                       picture::PageFormat format, const PlotSettings& settings) {
  std::vector<const trajectory::CurveGroup*> groups;
  for (const trajectory::CurveGroup& group : curves.groups) {
    if (group.hasValues()) groups.push_back(&group);
  }
  if (groups.empty()) throw InputError("error: the run has no curve to plot");
  const PlotLayout layout = layOut(static_cast<int>(groups.size()), settings);
  picture::requireValidSize(layout.size);
  const std::unique_ptr<picture::Canvas> canvas =
      picture::makeCanvas(format, {.size = layout.size,
                                   .pixelsPerInch = settings.dotsPerInch,
                                   .outline = kFrame,
                                   .fontFamily = picture::fontFamily(),
                                   .description = settings.madeBy});
  Plotter plotter(*canvas, layout.em, abscissa);
  for (std::size_t k = 0; k < groups.size(); ++k) {
    canvas->begin("curves_" + std::to_string(k + 1));
    plotter.draw(*groups[k], layout.box(static_cast<int>(k)));
    canvas->end();
  }
  return canvas->finish();
}

}  // namespace kirireel::record
