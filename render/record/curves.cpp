// Writes curves.csv and the figures of a run.
//
// curves.csv is text in UTF-8 with commas (RFC 4180, but with "\n" at line ends). The first line
// has the names of the columns, which end with their units (time_s, opening_mean_deg). Each further
// line is a sample of the trajectory, by ascending time. A value that does not exist is an empty
// field: spreadsheets and pandas read it as missing, but "nan" would turn the column into text.
//
// Numbers have the shortest digits that read back to the same double.
#include "render/record/curves.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/output/output_folder.h"
#include "render/picture/canvas.h"
#include "render/picture/label.h"
#include "render/record/load_curve_file.h"
#include "render/record/pace.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/files.h"

namespace kirireel::record {
namespace {

constexpr const char* kTable = "curves.csv";
// The column for --against opening.
constexpr const char* kOpening = "opening_mean_deg";
// Selects the curves of loadCurvesOf().
constexpr const char* kLoadCurves = "load_curve";
// Smaller displacements are rounding, as a fraction of the model's size or in radians.
constexpr double kStillGrip = 1e-9;

/// Each format has its own name, so a folder can have all of them.
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

/// All fields are numbers and need no quotation marks.
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

/// The column of the horizontal axis.
const char* columnOf(CurvesAgainst against) {
  if (against == CurvesAgainst::Time) return "time_s";
  return against == CurvesAgainst::Progress ? "progress" : kOpening;
}

const char* abscissaTitle(CurvesAgainst against) {
  if (against == CurvesAgainst::Time) return "simulated time, s";
  return against == CurvesAgainst::Progress ? "share of the motion" : "mean opening, degrees";
}

/// The values of the horizontal axis, one per sample. They may descend: a sheet may close
/// again.
PlotAbscissa abscissaOf(const trajectory::RunCurves& curves, const std::vector<double>& progress,
                        CurvesAgainst against) {
  const char* title = abscissaTitle(against);
  if (against == CurvesAgainst::Time) return {title, curves.times};
  if (against == CurvesAgainst::Progress) return {title, progress};
  for (const trajectory::Curve* curve : allCurves(curves)) {
    if (curve->column == kOpening && curve->hasValues()) return {title, curve->values};
  }
  throw InputError("error: the model has no joints that open; plot --against time or progress");
}

/// "Poisson's ratio" as "poissons_ratio".
std::string slugOf(const std::string& name) {
  std::string slug;
  for (const char letter : name) {
    if (letter == ' ') slug += '_';
    if (std::isalnum(static_cast<unsigned char>(letter)) != 0) {
      slug += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
  }
  return slug;
}

/// "opening_mean_deg" as "opening_mean".
std::string withoutUnit(const std::string& column) {
  for (const char* unit : {"_m", "_m2", "_deg", "_J", "_N"}) {
    if (column.ends_with(unit)) return column.substr(0, column.size() - std::strlen(unit));
  }
  return column;
}

std::vector<std::string> wordsOf(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream list(line);
  for (std::string word; std::getline(list, word, ',');) {
    const std::size_t first = word.find_first_not_of(" \t\r\"");
    const std::size_t last = word.find_last_not_of(" \t\r\"");
    words.push_back(first == std::string::npos ? "" : word.substr(first, last - first + 1));
  }
  return words;
}

/// The column of a table as a separate run, in the group of the curve with that column.
PlottedRun columnRun(const FileColumn& column, CurvesAgainst against,
                     const std::vector<trajectory::CurveGroup>& groups) {
  std::istringstream lines(
      readTextFile(column.file, "give a table with commas between its columns"));
  std::string line;
  std::getline(lines, line);
  const std::vector<std::string> names = wordsOf(line);
  const auto placeOf = [&names](const std::string& name) {
    return static_cast<std::size_t>(std::ranges::find(names, name) - names.begin());
  };
  const std::size_t up = placeOf(column.name);
  if (up == names.size()) {
    throw InputError(fmt::format("{}:1: error: there is no column {}; give one of {}",
                                 column.file.string(), column.name, fmt::join(names, ", ")));
  }
  std::size_t across = placeOf(columnOf(against));
  if (across == names.size()) across = 0;
  PlottedRun run;
  run.name = column.file.stem().string();
  run.abscissa.title = abscissaTitle(against);
  trajectory::Curve curve{column.name, column.name, {}};
  const auto numberOf = [](const std::vector<std::string>& words, std::size_t place) {
    if (place >= words.size() || words[place].empty()) return std::nan("");
    char* end = nullptr;
    const double value = std::strtod(words[place].c_str(), &end);
    return *end == '\0' ? value : std::nan("");
  };
  while (std::getline(lines, line)) {
    const std::vector<std::string> words = wordsOf(line);
    run.abscissa.values.push_back(numberOf(words, across));
    curve.values.push_back(numberOf(words, up));
  }
  run.groups = {{column.name, "", false, {curve}}};
  for (const trajectory::CurveGroup& group : groups) {
    for (const trajectory::Curve& other : group.curves) {
      if (other.column != column.name) continue;
      curve.name = other.name;
      run.groups = {{group.name, group.unit, group.isLogarithmic, {curve}}};
    }
  }
  return run;
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

std::vector<trajectory::CurveGroup> selectCurves(const std::vector<trajectory::CurveGroup>& groups,
                                                 const std::vector<std::string>& names,
                                                 const char* option) {
  if (names.empty()) return groups;
  std::vector<trajectory::CurveGroup> selected;
  std::vector<std::string> known;
  for (const std::string& name : names) {
    const std::string requestedName = name == "theta" ? withoutUnit(kOpening) : name;
    const std::size_t before = selected.size();
    known.clear();
    for (const trajectory::CurveGroup& group : groups) {
      known.push_back(slugOf(group.name));
      if (known.back() == requestedName) selected.push_back(group);
      if (known.back() == requestedName) break;
      for (const trajectory::Curve& curve : group.curves) {
        const std::string column = withoutUnit(curve.column);
        if (column != slugOf(group.name)) known.push_back(column);
        if (column != requestedName && curve.column != requestedName) continue;
        selected.push_back({group.name, group.unit, group.isLogarithmic, {curve}});
      }
    }
    if (selected.size() > before) continue;
    if (std::ranges::find(known, withoutUnit(kOpening)) != known.end()) known.emplace_back("theta");
    throw InputError(fmt::format("error: {}: there is no curve '{}'; give some of {}", option, name,
                                 fmt::join(known, ", ")));
  }
  return selected;
}

// The number of unstable modes is constant between turnings. A turning has the number of the part
// that ends there.
std::vector<PlottedRun> loadCurvesOf(const std::string& name, const mechanics::LoadCurve& curve,
                                     double modelSize) {
  const std::vector<mechanics::Equilibrium>& states = curve.states;
  std::vector<bool> isDashed;
  for (std::size_t k = 0; k + 1 < states.size(); ++k) {
    const mechanics::Equilibrium &a = states[k], &b = states[k + 1];
    // Rounding may give a turning the number of the next part, so ordinary states are preferred.
    const bool isAtEnd =
        b.turning != mechanics::Turning::None && a.turning == mechanics::Turning::None;
    isDashed.push_back((isAtEnd ? a : b).unstableModes > 0);
  }
  // The direction of a load replaces its parts along x, y and z.
  const auto isPart = [&](const mechanics::GripName& grip) {
    const std::string along = grip.name.substr(0, grip.name.rfind(' ')) + " along";
    const auto isAlong = [&](const mechanics::GripName& other) { return other.name == along; };
    return !grip.isTurn && grip.name != along && std::ranges::any_of(curve.grips, isAlong);
  };
  std::vector<PlottedRun> found;
  for (std::size_t g = 0; g < curve.grips.size(); ++g) {
    if (isPart(curve.grips[g])) continue;
    const auto& [grip, isTurn] = curve.grips[g];
    std::vector<double> displacements, forces;
    double largest = 0;
    for (const mechanics::Equilibrium& state : states) {
      displacements.push_back(state.displacements[g]);
      forces.push_back(state.forces[g]);
      largest = std::max(largest, std::abs(state.displacements[g]));
    }
    if (g != curve.leading && largest <= kStillGrip * (isTurn ? 1 : modelSize)) continue;
    const trajectory::Curve line{grip, kLoadCurves, std::move(forces)};
    found.push_back(
        {name,
         {{isTurn ? "Moment" : "Force", isTurn ? "N m" : "N", false, {line}}},
         {isTurn ? "rotation of the grip, rad" : "displacement of the grip, m", displacements},
         isDashed,
         true});
  }
  return found;
}

namespace {

std::vector<PlottedRun> selectedLoadCurves(const NamedRun& run, const CurvesSettings& settings) {
  const bool isSelected =
      settings.selected.empty() ||
      std::ranges::find(settings.selected, kLoadCurves) != settings.selected.end();
  if (!run.loadCurve || !isSelected) return {};
  return loadCurvesOf(run.name, *run.loadCurve, model::modelSize(run.reader->subject().model));
}

/// The selected curves except load curves.
std::vector<trajectory::CurveGroup> selectOthers(const trajectory::RunCurves& curves,
                                                 bool hasLoadCurve,
                                                 const CurvesSettings& settings) {
  std::vector<std::string> names = settings.selected;
  if (hasLoadCurve) std::erase(names, kLoadCurves);
  if (names.empty() && !settings.selected.empty()) return {};
  return selectCurves(curves.groups, names);
}

/// Whether a diagram shows a line for the curve.
bool canBePlotted(const trajectory::Curve& curve, bool isLogarithmic) {
  return std::ranges::any_of(curve.values, [isLogarithmic](double value) {
    return std::isfinite(value) && (!isLogarithmic || value > 0);
  });
}

/// The fraction of the motion at each sample, as in a video at an even pace: 0 at the start, 1 at
/// the end.
std::vector<double> progressOf(const trajectory::TrajectoryReader& run) {
  const MotionCurve motion = motionOf(run);
  std::vector<double> progress;
  for (const double time : run.times()) progress.push_back(motion.shareAt(time));
  return progress;
}

}  // namespace

PlottedRun plottedCurve(const trajectory::TrajectoryReader& run, const std::string& name,
                        CurvesAgainst against, const char* option) {
  trajectory::RunCurves curves = trajectory::curvesOf(run);
  for (trajectory::CurveGroup& group : curves.groups) {
    std::erase_if(group.curves, [&group](const trajectory::Curve& curve) {
      return !canBePlotted(curve, group.isLogarithmic);
    });
  }
  std::erase_if(curves.groups,
                [](const trajectory::CurveGroup& group) { return group.curves.empty(); });
  return {"", selectCurves(curves.groups, {name}, option),
          abscissaOf(curves, progressOf(run), against)};
}

std::vector<PlottedRun> plottedRuns(const std::vector<NamedRun>& runs,
                                    const CurvesSettings& settings,
                                    const CurvesObserver& observer) {
  const bool hasLoadCurve =
      std::ranges::any_of(runs, [](const NamedRun& run) { return run.loadCurve.has_value(); });
  std::vector<PlottedRun> plotted;
  std::vector<trajectory::CurveGroup> first;
  for (std::size_t k = 0; k < runs.size(); ++k) {
    const trajectory::RunCurves curves = trajectory::curvesOf(*runs[k].reader);
    const std::vector<double> progress = progressOf(*runs[k].reader);
    if (observer) observer(k, curves, progress);
    for (PlottedRun& load : selectedLoadCurves(runs[k], settings)) {
      plotted.push_back(std::move(load));
    }
    plotted.push_back({runs[k].name, selectOthers(curves, hasLoadCurve, settings),
                       abscissaOf(curves, progress, settings.against)});
    if (k == 0) first = curves.groups;
  }
  for (const FileColumn& column : settings.columns) {
    if (!runs.empty()) plotted.push_back(columnRun(column, settings.against, first));
  }
  return plotted;
}

NamedRun openRun(const std::filesystem::path& trajectory) {
  auto reader = std::make_unique<trajectory::TrajectoryReader>(trajectory);
  std::string name = std::filesystem::absolute(trajectory).parent_path().filename().string();
  return {std::move(name), std::move(reader), readLoadCurve(trajectory)};
}

std::vector<std::string> writeCurves(const std::vector<NamedRun>& runs,
                                     const CurvesSettings& settings) {
  const auto tableOf = [&runs](std::size_t run) {
    return runs.size() == 1 ? std::string(kTable) : fmt::format("curves_{}.csv", run + 1);
  };
  std::vector<std::string> names;
  for (std::size_t run = 0; run < runs.size(); ++run) names.push_back(tableOf(run));
  for (const picture::PageFormat format : settings.plots) names.emplace_back(fileOf(format));
  output::FileSet files(settings.folder, output::kContents);
  files.requireFree([&names](const std::string& name) {
    return name == output::kContents || std::ranges::find(names, name) != names.end();
  });
  const std::vector<PlottedRun> plotted =
      plottedRuns(runs, settings,
                  [&](std::size_t run, const trajectory::RunCurves& curves,
                      const std::vector<double>& progress) {
                    writeTextFile(files.stage() / tableOf(run), curvesTable(curves, progress));
                  });
  std::vector<std::string> models;
  for (const NamedRun& run : runs) models.push_back(run.reader->subject().model.name);
  PlotSettings plot = settings.plot;
  plot.madeBy = madeBy(models);
  for (const picture::PageFormat format : settings.plots) {
    writeTextFile(files.stage() / fileOf(format), plotCurves(plotted, format, plot));
  }
  files.commit(names);
  return names;
}

// ------------------------------------------------------------------------------------------------
// A figure is a grid of diagrams, two per row, one for each group of curves with the same unit. All
// lengths follow from two numbers: the figure's width W (millimetres) and the size of its text
// (points, 1/72 inch). With d dots per inch the em of the text is round(points / 72 d) pixels and
// the figure is round(W / 25.4 d) pixels wide. All other lengths are in em, so figures of any width
// appear alike in print.
//
//     4.5 em for numbers | diagram, height = 0.5 width | 0.5 em
//     2 em above it for its title, 4 em below for numbers and words
//
// In a panel of a page, the box of the panel gives width and height.
//
// The vertical axis follows from a group's values (makeAxis, makeLogarithmicAxis in label.h). The
// horizontal axis follows from the abscissa; it begins and ends with the curves. A position in a
// diagram is a pair of fractions, [0, 1] from left to right and from bottom to top.
//
// The same code draws SVG, PDF and PNG through Canvas (render/picture/canvas.h).

namespace {

constexpr picture::Colour kText = {30, 30, 30};
constexpr picture::Colour kFrame = {120, 126, 134};
constexpr picture::Colour kGrid = {226, 229, 233};
/// Shares of the text's colour in frames and grids on other backgrounds than white.
constexpr double kFrameShare = 0.6;
constexpr double kGridShare = 0.15;
/// Colours of a diagram's lines in turn, distinguishable in grey and for colour-blind readers.
constexpr picture::Colour kLines[] = {{43, 100, 166}, {194, 87, 26},  {61, 139, 95},
                                      {148, 62, 130}, {120, 100, 20}, {70, 70, 76}};

/// Above and below a diagram, em.
constexpr double kTitleEms = 2;
constexpr double kBelowEms = 4;
/// The least height of a diagram, em.
constexpr double kLeastEms = 8;
// Approximate number of ticks; makeAxis takes round values.
constexpr int kTicksAcross = 5;
constexpr int kTicksUp = 5;
/// Height of a diagram as a fraction of its width.
constexpr double kAspect = 0.5;
/// Lengths of dashes and gaps of dashed lines, em.
constexpr double kDash = 0.5;
constexpr double kGap = 0.3;

}  // namespace

/// A line of a diagram.
struct PlotLine {
  std::string name;
  const std::vector<double>& across;
  const std::vector<double>& values;
  const std::vector<bool>& isDashed;  ///< see PlottedRun

  bool hasDashes() const { return std::ranges::find(isDashed, true) != isDashed.end(); }
  bool isDashedAfter(std::size_t sample) const {
    return sample < isDashed.size() && isDashed[sample];
  }
};

/// The lines of all runs with one name of group and one abscissa.
struct Diagram {
  std::string title;   ///< with the unit
  std::string across;  ///< title of the abscissa
  bool isLogarithmic = false;
  std::vector<PlotLine> lines;
};

namespace {

/// In the order of the groups' first run. Names of runs if there are several, else of curves.
std::vector<Diagram> diagramsOf(const std::vector<PlottedRun>& runs) {
  const bool isOne = std::ranges::count(runs, false, &PlottedRun::isLoadCurve) <= 1;
  std::vector<Diagram> diagrams;
  for (const PlottedRun& run : runs) {
    for (const trajectory::CurveGroup& group : run.groups) {
      if (!group.hasValues()) continue;
      const std::string title = group.unit.empty() ? group.name : group.name + ", " + group.unit;
      auto diagram = std::ranges::find_if(diagrams, [&](const Diagram& other) {
        return other.title == title && other.across == run.abscissa.title;
      });
      if (diagram == diagrams.end()) {
        diagram =
            diagrams.insert(diagrams.end(), {title, run.abscissa.title, group.isLogarithmic, {}});
      }
      for (const trajectory::Curve& curve : group.curves) {
        if (!curve.hasValues()) continue;
        const bool isOnly = group.curves.size() == 1 && !run.isLoadCurve;
        const std::string name = isOne    ? curve.name
                                 : isOnly ? run.name
                                          : run.name + ", " + curve.name;
        diagram->lines.push_back({name, run.abscissa.values, curve.values, run.isDashed});
      }
    }
  }
  return diagrams;
}

/// Cuts a line into dashes; lengths in pixels. Begins and ends with a dash.
std::vector<picture::Canvas::Points> dashesOf(const picture::Canvas::Points& line, double dash,
                                              double gap) {
  double length = 0;
  for (std::size_t k = 1; k < line.size(); ++k) length += (line[k] - line[k - 1]).norm();
  // The largest number of periods that fits, stretched.
  const double periods = std::max(0.0, std::round((length - dash) / (dash + gap)));
  const double stretch = length / (periods * (dash + gap) + dash);
  std::vector<picture::Canvas::Points> dashes = {{line.front()}};
  bool isDash = true;
  double left = stretch * dash;
  for (std::size_t k = 1; k < line.size(); ++k) {
    Eigen::Vector2d at = line[k - 1];
    double rest = (line[k] - at).norm();
    while (rest > left) {
      at += left / rest * (line[k] - at);
      rest -= left;
      if (isDash) {
        dashes.back().push_back(at);
      } else {
        dashes.push_back({at});
      }
      isDash = !isDash;
      left = stretch * (isDash ? dash : gap);
    }
    left -= rest;
    if (isDash) dashes.back().push_back(line[k]);
  }
  std::erase_if(dashes, [](const picture::Canvas::Points& points) { return points.size() < 2; });
  return dashes;
}

/// Colours of diagrams on a background.
struct PlotColours {
  picture::Colour text = kText;
  picture::Colour frame = kFrame;
  picture::Colour grid = kGrid;
  picture::Colour background;

  explicit PlotColours(picture::Colour page) : background(page) {
    background.alpha = 255;
    if (background == picture::PageSettings().background) return;
    text = picture::readableText(kText, background);
    frame = picture::mixed(background, text, kFrameShare);
    grid = picture::mixed(background, text, kGridShare);
  }

  /// Of the line with this number, and of its name.
  picture::Colour line(std::size_t number) const {
    return picture::readableHue(kLines[number % std::size(kLines)], background);
  }
};

/// The axes of a diagram in its box.
struct DiagramAxes {
  picture::Axis across;
  picture::Axis up;
  picture::PageBox box;

  /// Pixels from two fractions of the box.
  Eigen::Vector2d place(double acrossShare, double upShare) const {
    return {box.left + acrossShare * box.width, box.lower() - upShare * box.height};
  }

  /// The place of a sample; absent if it is not drawn.
  std::optional<Eigen::Vector2d> pointOf(const PlotLine& line, std::size_t sample) const {
    const double value = line.values[sample], at = line.across[sample];
    if (!std::isfinite(at) || !std::isfinite(value)) return std::nullopt;
    if (up.isLogarithmic && value <= 0) return std::nullopt;
    return place(across.shareOf(at), up.shareOf(value));
  }
};

/// Curves begin and end at the borders.
picture::Axis makeAcrossAxis(const std::vector<double>& values) {
  picture::Axis axis = picture::makeAxis(values, kTicksAcross);
  const auto [least, largest] = std::ranges::minmax_element(values);
  if (*least < *largest) {
    axis.low = *least;
    axis.high = *largest;
  }
  return axis;
}

/// All curves of a diagram share one axis; missing values are omitted.
picture::Axis makeUpAxis(const Diagram& diagram) {
  std::vector<double> values;
  for (const PlotLine& line : diagram.lines) {
    std::ranges::copy_if(line.values, std::back_inserter(values),
                         [](double value) { return std::isfinite(value); });
  }
  return diagram.isLogarithmic ? picture::makeLogarithmicAxis(values, kTicksUp)
                               : picture::makeAxis(values, kTicksUp);
}

/// Diagrams with the same title of the abscissa share its axis.
DiagramAxes axesOf(const Diagram& diagram, const std::vector<PlottedRun>& runs,
                   const picture::PageBox& box) {
  std::vector<double> values;
  for (const PlottedRun& run : runs) {
    if (run.abscissa.title != diagram.across) continue;
    std::ranges::copy_if(run.abscissa.values, std::back_inserter(values),
                         [](double value) { return std::isfinite(value); });
  }
  return {makeAcrossAxis(values), makeUpAxis(diagram), box};
}

/// Draws diagrams of one figure. Lengths are in em of its text.
class Plotter {
 public:
  Plotter(picture::Canvas& canvas, int em, picture::Colour background)
      : canvas_(canvas), em_(em), colours_(background), writer_(em) {}

  /// Lines are 0.13 em wide, 0.9 points in a figure with text of 7 points.
  void draw(const Diagram& diagram, const DiagramAxes& axes) {
    drawGrid(axes);
    for (std::size_t k = 0; k < diagram.lines.size(); ++k) {
      canvas_.lines(linesOf(diagram.lines[k], axes), 0.13 * em_, colours_.line(k));
    }
    drawTitle(diagram, axes);
    const double middle = axes.box.left + 0.5 * axes.box.width;
    write(diagram.across, middle - 0.5 * width(diagram.across), axes.box.lower() + 2.5 * em_,
          colours_.text);
  }

 private:
  /// Ticks and numbers of both axes, and the two axes themselves.
  void drawGrid(const DiagramAxes& axes) {
    const auto& [across, up, box] = axes;
    std::vector<picture::Canvas::Points> grid;
    for (std::size_t k = 0; k < up.ticks.size(); ++k) {
      const double share = up.shareOf(up.ticks[k]);
      grid.push_back({axes.place(0, share), axes.place(1, share)});
      write(up.texts[k], box.left - 0.5 * em_ - width(up.texts[k]),
            axes.place(0, share).y() + 0.35 * em_, colours_.text);
    }
    for (std::size_t k = 0; k < across.ticks.size(); ++k) {
      const double share = across.shareOf(across.ticks[k]);
      // The axis was cut to the curves' ends, so its first and last ticks may lie beyond it.
      if (share < -1e-9 || share > 1 + 1e-9) continue;
      grid.push_back({axes.place(share, 0), axes.place(share, 1)});
      write(across.texts[k], axes.place(share, 0).x() - 0.5 * width(across.texts[k]),
            box.lower() + 1.25 * em_, colours_.text);
    }
    canvas_.lines(grid, 0.06 * em_, colours_.grid);
    canvas_.lines({{axes.place(0, 1), axes.place(0, 0), axes.place(1, 0)}}, 0.08 * em_,
                  colours_.frame);
  }

  /// A line for each sequence of samples with values, and the dashes of dashed lines.
  std::vector<picture::Canvas::Points> linesOf(const PlotLine& line,
                                               const DiagramAxes& axes) const {
    std::vector<picture::Canvas::Points> lines, dashes;
    picture::Canvas::Points points;
    bool isDashed = false;
    const auto endLine = [&] {
      // A single sample makes no line.
      if (points.size() > 1 && isDashed) {
        for (picture::Canvas::Points& dash : dashesOf(points, kDash * em_, kGap * em_)) {
          dashes.push_back(std::move(dash));
        }
      } else if (points.size() > 1) {
        lines.push_back(points);
      }
      points.clear();
    };
    for (std::size_t k = 0; k < line.values.size(); ++k) {
      const std::optional<Eigen::Vector2d> point = axes.pointOf(line, k);
      if (!point) {
        endLine();
        continue;
      }
      points.push_back(*point);
      if (line.isDashedAfter(k) == isDashed) continue;
      endLine();
      points = {*point};
      isDashed = line.isDashedAfter(k);
    }
    endLine();
    lines.insert(lines.end(), dashes.begin(), dashes.end());
    return lines;
  }

  /// Draws the diagram's name and unit on the left and the curves' names in their colours on the
  /// right. If they do not fit, the names are inside the diagram, one below the other.
  void drawTitle(const Diagram& diagram, const DiagramAxes& axes) {
    const picture::PageBox& box = axes.box;
    const double baseline = box.upper - 0.6 * em_;
    const bool hasDashes = std::ranges::any_of(diagram.lines, &PlotLine::hasDashes);
    const std::string title = diagram.title + (hasDashes ? " (dashed: unstable)" : "");
    write(title, box.left, baseline, colours_.text);
    if (diagram.lines.size() < 2) return;
    double needed = width(title);
    for (const PlotLine& line : diagram.lines) needed += em_ + width(line.name);
    if (needed > box.width) return drawNames(diagram, axes);
    double right = box.right();
    // Names end at the right border in the order of the curves, so they are drawn from the last
    // one.
    for (std::size_t k = diagram.lines.size(); k-- > 0;) {
      const std::string& name = diagram.lines[k].name;
      right -= width(name);
      write(name, right, baseline, colours_.line(k));
      right -= em_;
    }
  }

  /// In the corner of the diagram where the lines are shortest: upper right, upper left, lower
  /// right or lower left.
  void drawNames(const Diagram& diagram, const DiagramAxes& axes) {
    const picture::PageBox& box = axes.box;
    const auto count = static_cast<double>(diagram.lines.size());
    picture::PageBox names{0, 0, 0, (1.25 * count + 0.5) * em_};
    for (const PlotLine& line : diagram.lines)
      names.width = std::max(names.width, width(line.name));
    names.width += em_;
    const double lefts[] = {box.right() - names.width, box.left};
    const double uppers[] = {box.upper, box.lower() - names.height};
    double shortest = std::numeric_limits<double>::infinity();
    bool isRight = true;
    for (const double upper : uppers) {
      for (const double left : lefts) {
        const double length = lengthIn({left, upper, names.width, names.height}, diagram, axes);
        if (length >= shortest) continue;
        shortest = length;
        names.left = left;
        names.upper = upper;
        isRight = left == lefts[0];
      }
    }
    for (std::size_t k = 0; k < diagram.lines.size(); ++k) {
      const std::string& name = diagram.lines[k].name;
      const double inner = isRight ? names.width - 0.5 * em_ - width(name) : 0.5 * em_;
      write(name, names.left + inner, names.upper + (1.2 + 1.25 * static_cast<double>(k)) * em_,
            colours_.line(k));
    }
  }

  /// Length of all lines in a part of a diagram, pixels. Pieces of up to a quarter of an em count
  /// where they begin.
  double lengthIn(const picture::PageBox& part, const Diagram& diagram,
                  const DiagramAxes& axes) const {
    double length = 0;
    for (const PlotLine& line : diagram.lines) {
      for (const picture::Canvas::Points& points : linesOf(line, axes)) {
        for (std::size_t k = 1; k < points.size(); ++k) {
          const Eigen::Vector2d whole = points[k] - points[k - 1];
          const double pieces = std::max(1.0, std::ceil(whole.norm() / (0.25 * em_)));
          for (double j = 0; j < pieces; ++j) {
            const Eigen::Vector2d at = points[k - 1] + j / pieces * whole;
            const bool isIn = at.x() > part.left && at.x() < part.right() && at.y() > part.upper &&
                              at.y() < part.lower();
            if (isIn) length += whole.norm() / pieces;
          }
        }
      }
    }
    return length;
  }

  double width(const std::string& text) const { return writer_.width(text); }

  void write(const std::string& text, double left, double baseline, picture::Colour colour) {
    canvas_.text(text, left, baseline, em_, colour);
  }

  picture::Canvas& canvas_;
  int em_;
  PlotColours colours_;
  picture::LabelWriter writer_;
};

/// The places of the diagrams of a figure.
struct PlotLayout {
  picture::PageBox first;  ///< the diagram at the upper left
  double across = 0;       ///< from one diagram to the next
  double down = 0;         ///< from one row to the next
  int columns = 1;

  picture::PageBox box(int number) const {
    picture::PageBox result = first;
    result.left += number % columns * across;
    result.upper += number / columns * down;
    return result;
  }
};

/// At the upper left of a page, with the height that follows from the width.
PlotLayout layOut(int diagrams, int em, double width, int columns) {
  PlotLayout layout;
  layout.columns = std::min(columns, diagrams);
  layout.across = (width - em) / layout.columns;
  const double wide = layout.across - 5 * em;
  layout.first = {4.5 * em, kTitleEms * em, wide, kAspect * wide / (diagrams == 1 ? 1.2 : 1)};
  layout.down = layout.first.height + (kTitleEms + kBelowEms) * em;
  return layout;
}

}  // namespace

PlotSheet::PlotSheet(const std::vector<PlottedRun>& runs, int em, picture::Colour background)
    : runs_(runs), diagrams_(diagramsOf(runs)), em_(em), background_(background) {
  if (diagrams_.empty()) throw InputError("error: the run has no curve to plot");
}

PlotSheet::~PlotSheet() = default;

int PlotSheet::rows(int columns) const {
  return (static_cast<int>(diagrams_.size()) + columns - 1) / columns;
}

double PlotSheet::height(double width, int columns) const {
  const auto diagrams = static_cast<int>(diagrams_.size());
  return rows(columns) * layOut(diagrams, em_, width, columns).down;
}

double PlotSheet::leastHeight(int columns) const {
  return rows(columns) * (kLeastEms + kTitleEms + kBelowEms) * em_;
}

std::vector<picture::PageBox> PlotSheet::boxes(const picture::PageBox& box, int columns) const {
  const auto count = static_cast<int>(diagrams_.size());
  PlotLayout layout = layOut(count, em_, box.width, columns);
  layout.first.left += box.left;
  layout.first.upper += box.upper;
  if (box.height > 0) {
    layout.down = box.height / rows(columns);
    layout.first.height = layout.down - (kTitleEms + kBelowEms) * em_;
  }
  std::vector<picture::PageBox> boxes;
  for (int k = 0; k < count; ++k) boxes.push_back(layout.box(k));
  return boxes;
}

void PlotSheet::draw(picture::Canvas& page, const picture::PageBox& box, int columns,
                     const std::string& prefix) const {
  const std::vector<picture::PageBox> places = boxes(box, columns);
  Plotter plotter(page, em_, background_);
  for (std::size_t k = 0; k < diagrams_.size(); ++k) {
    page.begin(prefix + "curves_" + std::to_string(k + 1));
    plotter.draw(diagrams_[k], axesOf(diagrams_[k], runs_, places[k]));
    page.end();
  }
}

std::vector<DrawnCurve> PlotSheet::drawnCurves(const picture::PageBox& box, int columns) const {
  const std::vector<picture::PageBox> places = boxes(box, columns);
  const PlotColours colours(background_);
  std::vector<DrawnCurve> curves;
  for (std::size_t k = 0; k < diagrams_.size(); ++k) {
    const DiagramAxes axes = axesOf(diagrams_[k], runs_, places[k]);
    for (std::size_t number = 0; number < diagrams_[k].lines.size(); ++number) {
      const PlotLine& line = diagrams_[k].lines[number];
      curves.push_back({colours.line(number), {}});
      for (std::size_t sample = 0; sample < line.values.size(); ++sample) {
        curves.back().points.push_back(axes.pointOf(line, sample));
      }
    }
  }
  return curves;
}

std::string plotCurves(const std::vector<PlottedRun>& runs, picture::PageFormat format,
                       const PlotSettings& settings) {
  const int em = std::max(4, picture::emOf(settings.fontPoints, settings.dotsPerInch));
  const PlotSheet sheet(runs, em);
  picture::FrameSize size;
  size.width = picture::pixelsOf(settings.width, settings.dotsPerInch);
  size.height = static_cast<int>(std::lround(sheet.height(size.width, PlotSheet::kColumns)));
  picture::requireValidSize(size);
  const std::unique_ptr<picture::Canvas> canvas =
      picture::makeCanvas(format, {.size = size,
                                   .pixelsPerInch = settings.dotsPerInch,
                                   .outlines = {.colour = kFrame},
                                   .fontFamily = picture::fontFamily(),
                                   .description = settings.madeBy});
  sheet.draw(*canvas, {.width = static_cast<double>(size.width)}, PlotSheet::kColumns, "");
  return canvas->finish();
}

}  // namespace kirireel::record
