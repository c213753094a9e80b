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
#include <limits>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/output/output_folder.h"
#include "render/picture/label.h"
#include "render/record/load_curve_file.h"
#include "render/record/pace.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/files.h"

namespace kirireel::record {
namespace {

constexpr const char* kTable = "curves.csv";
constexpr const char* kPages = "curves";  // stem
// The column for --against opening.
constexpr const char* kOpening = "opening_mean_deg";
// Selects the curves of loadCurvesOf().
constexpr const char* kLoadCurves = "load_curve";
// Smaller displacements are rounding, as a fraction of the model's size or in radians.
constexpr double kStillGrip = 1e-9;
// Smaller errors, gaps and overlaps are rounding, as a fraction of the model's size.
constexpr double kRounding = 1e-12;

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

/// The values of the horizontal axis, one per sample. They may descend: a sheet may close again.
PlotAbscissa abscissaOf(const trajectory::RunCurves& curves, const std::vector<double>& progress,
                        CurvesAgainst against) {
  const char* title = abscissaTitle(against);
  if (against == CurvesAgainst::Time) return {title, curves.times};
  if (against == CurvesAgainst::Progress) return {title, progress};
  for (const trajectory::Curve* curve : allCurves(curves)) {
    if (curve->column == kOpening && curve->hasLine()) return {title, curve->values};
  }
  throw InputError("error: the model has no joints that open; plot --against time or progress");
}

/// Converts lengths and areas, for figures.
void convertLengths(PlottedRun& run, const LengthUnit& from, const LengthUnit& to) {
  const double factor = from.metres / to.metres;
  run.rounding *= factor;
  for (trajectory::CurveGroup& group : run.groups) {
    if (group.lengthPower == 0) continue;
    group.unit = picture::unitSymbol(to) + (group.lengthPower == 2 ? "²" : "");
    for (trajectory::Curve& curve : group.curves) {
      for (double& value : curve.values) value *= std::pow(factor, group.lengthPower);
    }
  }
}

const LengthUnit& unitOf(const trajectory::TrajectoryReader& run) {
  return run.subject().model.unit;
}

/// Of a run's lengths, in its unit.
double roundingOf(const trajectory::TrajectoryReader& run) {
  return kRounding * inUnit(model::modelSize(run.subject().model), unitOf(run));
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
  std::vector<std::string> units = {"deg", "J", "N"};
  for (const LengthUnit& unit : lengthUnits()) {
    units.push_back(unit.name);
    units.push_back(unit.name + "2");
  }
  const std::size_t end = column.rfind('_');
  const bool hasUnit =
      end != std::string::npos && std::ranges::find(units, column.substr(end + 1)) != units.end();
  return hasUnit ? column.substr(0, end) : column;
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

/// NaN if it is not a number.
double numberOf(const std::string& word) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  return word.empty() || *end != '\0' ? std::nan("") : value;
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
  std::vector<std::vector<double>> rows;
  while (std::getline(lines, line)) {
    std::vector<double>& row = rows.emplace_back();
    for (const std::string& word : wordsOf(line)) row.push_back(numberOf(word));
    row.resize(names.size(), std::nan(""));
  }
  const auto hasNumbers = [&rows](std::size_t place) {
    return std::ranges::any_of(rows, [place](const auto& row) { return !std::isnan(row[place]); });
  };
  PlottedRun run;
  run.name = column.file.stem().string();
  run.abscissa.title = abscissaTitle(against);
  std::size_t across = placeOf(columnOf(against));
  if (across == names.size()) across = 0;
  for (std::size_t place = 0; !hasNumbers(across) && place < names.size(); ++place) {
    if (!hasNumbers(place)) continue;
    across = place;
    run.abscissa.title = names[place];
  }
  if (!hasNumbers(up) || !hasNumbers(across)) {
    throw InputError(fmt::format("{}: error: the column {} has no numbers; give another",
                                 column.file.string(), column.name));
  }
  trajectory::Curve curve{column.name, column.name, {}};
  for (const std::vector<double>& row : rows) {
    run.abscissa.values.push_back(row[across]);
    curve.values.push_back(row[up]);
  }
  run.groups = {{column.name, "", false, {curve}}};
  for (const trajectory::CurveGroup& group : groups) {
    for (const trajectory::Curve& other : group.curves) {
      if (other.column != column.name) continue;
      curve.name = other.name;
      run.groups = {{group.name, group.unit, group.isLogarithmic, {curve}, group.lengthPower}};
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
    for (const trajectory::Curve* curve : columns)
      table += "," + (std::isnan(curve->values[k]) ? "" : fmt::format("{}", curve->values[k]));
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
    bool found = false;
    known.clear();
    for (const trajectory::CurveGroup& group : groups) {
      known.push_back(slugOf(group.name));
      if (known.back() == requestedName) {
        found = true;
        std::erase_if(selected, [&group](const trajectory::CurveGroup& other) {
          return other.name == group.name;
        });
        selected.push_back(group);
        break;
      }
      for (const trajectory::Curve& curve : group.curves) {
        const std::string column = withoutUnit(curve.column);
        if (column != slugOf(group.name)) known.push_back(column);
        if (column != requestedName && curve.column != requestedName) continue;
        found = true;
        const auto same = std::ranges::find(selected, group.name, &trajectory::CurveGroup::name);
        if (same == selected.end()) {
          selected.push_back(
              {group.name, group.unit, group.isLogarithmic, {curve}, group.lengthPower});
        } else if (std::ranges::find(same->curves, curve.column, &trajectory::Curve::column) ==
                   same->curves.end()) {
          same->curves.push_back(curve);
        }
      }
    }
    if (found) continue;
    if (std::ranges::find(known, withoutUnit(kOpening)) != known.end()) known.emplace_back("theta");
    throw InputError(fmt::format("error: {}: there is no curve '{}'; give some of {}", option, name,
                                 fmt::join(known, ", ")));
  }
  return selected;
}

// The number of unstable modes is constant between turnings. A turning has the number of the part
// that ends there.
std::vector<PlottedRun> loadCurvesOf(const std::string& name, const mechanics::LoadCurve& curve,
                                     double modelSize, const LengthUnit& unit) {
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
      displacements.push_back(isTurn ? state.displacements[g]
                                     : inUnit(state.displacements[g], unit));
      forces.push_back(state.forces[g]);
      largest = std::max(largest, std::abs(state.displacements[g]));
    }
    if (g != curve.leading && largest <= kStillGrip * (isTurn ? 1 : modelSize)) continue;
    const trajectory::Curve line{grip, kLoadCurves, std::move(forces)};
    found.push_back(
        {name,
         {{isTurn ? "Moment" : "Force", isTurn ? "N m" : "N", false, {line}}},
         {isTurn ? "rotation of the grip, rad" : "displacement of the grip, " + unit.name,
          displacements},
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
  const model::Model& model = run.reader->subject().model;
  return loadCurvesOf(run.name, *run.loadCurve, model::modelSize(model), model.unit);
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

/// Removes curves without a line in a diagram. Values of logarithmic groups count above `least`.
void eraseEmpty(std::vector<trajectory::CurveGroup>& groups, double least) {
  for (trajectory::CurveGroup& group : groups) {
    std::erase_if(group.curves, [&](const trajectory::Curve& curve) {
      return std::ranges::none_of(curve.values, [&](double value) {
        return std::isfinite(value) && (!group.isLogarithmic || value > least);
      });
    });
  }
  std::erase_if(groups, [](const trajectory::CurveGroup& group) { return group.curves.empty(); });
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
  eraseEmpty(curves.groups, 0);
  PlottedRun plotted{"", selectCurves(curves.groups, {name}, option),
                     abscissaOf(curves, progressOf(run), against)};
  plotted.rounding = roundingOf(run);
  convertLengths(plotted, unitOf(run), unitOf(run));
  return plotted;
}

namespace {

/// The inputs in which a run of a sweep differs from others, for example "rows 4"; else its name.
std::string nameAmong(const std::vector<NamedRun>& runs, const NamedRun& run) {
  std::vector<std::string> texts;
  for (const auto& input : run.inputs) {
    const bool differs = std::ranges::any_of(runs, [&](const NamedRun& other) {
      const auto found = other.inputs.find(input.first);
      return found == other.inputs.end() || found->second != input.second;
    });
    if (differs) texts.push_back(fmt::format("{} {}", input.first, input.second));
  }
  return texts.empty() ? run.name : fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace

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
    plotted.push_back({nameAmong(runs, runs[k]), selectOthers(curves, hasLoadCurve, settings),
                       abscissaOf(curves, progress, settings.against)});
    plotted.back().rounding = roundingOf(*runs[k].reader);
    if (settings.selected.empty()) eraseEmpty(plotted.back().groups, plotted.back().rounding);
    convertLengths(plotted.back(), unitOf(*runs[k].reader), unitOf(*runs[0].reader));
    if (k == 0) first = curves.groups;
  }
  for (const FileColumn& column : settings.columns) {
    if (runs.empty()) break;
    plotted.push_back(columnRun(column, settings.against, first));
    plotted.back().rounding = roundingOf(*runs[0].reader);
    convertLengths(plotted.back(), unitOf(*runs[0].reader), unitOf(*runs[0].reader));
  }
  return plotted;
}

NamedRun openRun(const std::filesystem::path& trajectory) {
  auto reader = std::make_unique<trajectory::TrajectoryReader>(trajectory);
  const std::filesystem::path folder = std::filesystem::absolute(trajectory).parent_path();
  return {folder.filename().string(), std::move(reader), readLoadCurve(trajectory),
          sweepInputs(folder)};
}

std::vector<std::string> writeCurves(const std::vector<NamedRun>& runs,
                                     const CurvesSettings& settings) {
  const auto tableOf = [&runs](std::size_t run) {
    return runs.size() == 1 ? std::string(kTable) : fmt::format("curves_{}.csv", run + 1);
  };
  std::vector<std::string> names;
  for (std::size_t run = 0; run < runs.size(); ++run) names.push_back(tableOf(run));
  for (const picture::PageFormat format : settings.plots)
    names.push_back(picture::pageFile(kPages, format));
  output::FileSet files(settings.folder, output::kContents);
  files.requireFree(names);
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
    writeTextFile(files.stage() / picture::pageFile(kPages, format),
                  plotCurves(plotted, format, plot));
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
// No text leaves its column or covers other text or a curve:
//
// - Numbers have as much space on the left as they need, and less than 4.5 em in columns narrower
//   than 18 em. Axes have fewer ticks if their numbers would touch.
// - Titles move towards the borders of their column, and have smaller letters if they are too long.
// - Names of curves are next to the title; if they do not fit, in a corner of the diagram without
//   curves; if there is none, in lines between title and diagram.
//
// The vertical axis follows from a group's values (makeAxis, makeLogarithmicAxis in label.h). A
// logarithmic axis begins at the smallest value that is not rounding, and at most six decades below
// the largest value of a curve: with more, a motion over two decades would be a line at the top.
// Lower parts of curves are on the lower border. If all values are rounding, all are shown and the
// title says so. The horizontal axis follows from the abscissa; it begins and ends with the curves.
// A position in a diagram is a pair of fractions, [0, 1] from left to right and from bottom to top.
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
/// The smallest height of a diagram, em.
constexpr double kMinEms = 8;
// Approximate number of ticks; makeAxis takes round values.
constexpr int kTicksAcross = 5;
constexpr int kTicksUp = 5;
/// Left of a diagram for numbers, em; in narrow columns this fraction of the column.
constexpr double kNumbersEms = 4.5;
constexpr double kNumbersShare = 0.25;
/// Least distance of numbers of the vertical axis, and the height of a line of names; em.
constexpr double kTickLineEms = 1.5;
constexpr double kNameLineEms = 1.25;
/// The narrowest figure with two diagrams per row, em.
constexpr double kNarrowFigureEms = 30;
/// Left of a title for the letter of a panel, em.
constexpr double kLetterEms = 2.2;
/// The lowest diagram under lines of names, em. Below it names are in a corner on curves.
constexpr double kLowestEms = 4;
/// Height of a diagram as a fraction of its width.
constexpr double kAspect = 0.5;
/// Largest ratio between the largest value of a curve and the low end of a logarithmic axis.
constexpr double kLargestRatio = 1e6;
/// Lengths of dashes and gaps of dashed lines, em.
constexpr double kDash = 0.5;
constexpr double kGap = 0.3;

}  // namespace

/// A line of a diagram.
struct PlotLine {
  std::string name;  ///< of the run, the curve, or both
  const std::vector<double>& across;
  const std::vector<double>& values;
  const std::vector<bool>& isDashed;  ///< see PlottedRun
  bool isWhollyDashed = false;        ///< a reference, or one of two lines in a colour

  bool hasDashes() const { return std::ranges::find(isDashed, true) != isDashed.end(); }
  bool isDashedAfter(std::size_t sample) const {
    return isWhollyDashed || (sample < isDashed.size() && isDashed[sample]);
  }
};

/// The lines of all runs with one name of group and one abscissa.
struct Diagram {
  std::string title;   ///< with the unit
  std::string across;  ///< title of the abscissa
  bool isLogarithmic = false;
  bool isOfLoads = false;  ///< see PlottedRun::isLoadCurve
  double rounding = 0;     ///< smallest of its runs, see PlottedRun
  std::vector<PlotLine> lines;

  /// Whether all values are rounding.
  bool isRounding() const {
    return isLogarithmic && std::ranges::all_of(lines, [this](const PlotLine& line) {
             return std::ranges::none_of(line.values,
                                         [this](double value) { return value > rounding; });
           });
  }
};

namespace {

/// In the order of the groups' first run. Names of runs if there are several, else of curves.
std::vector<Diagram> diagramsOf(const std::vector<PlottedRun>& runs) {
  const bool isOne = std::ranges::count(runs, false, &PlottedRun::isLoadCurve) <= 1;
  std::vector<Diagram> diagrams;
  std::vector<std::vector<const trajectory::Curve*>> curves;  // of the lines of each diagram
  for (const PlottedRun& run : runs) {
    for (const trajectory::CurveGroup& group : run.groups) {
      if (!group.hasLine()) continue;
      const std::string title = group.unit.empty() ? group.name : group.name + ", " + group.unit;
      auto diagram = std::ranges::find_if(diagrams, [&](const Diagram& other) {
        return other.title == title && other.across == run.abscissa.title;
      });
      if (diagram == diagrams.end()) {
        diagram = diagrams.insert(
            diagrams.end(),
            {title, run.abscissa.title, group.isLogarithmic, run.isLoadCurve, run.rounding, {}});
        curves.emplace_back();
      }
      diagram->rounding = std::min(diagram->rounding, run.rounding);
      for (const trajectory::Curve& curve : group.curves) {
        if (!curve.hasLine()) continue;
        diagram->lines.push_back({run.name, run.abscissa.values, curve.values, run.isDashed});
        curves[diagram - diagrams.begin()].push_back(&curve);
      }
    }
  }
  for (std::size_t k = 0; k < diagrams.size(); ++k) {
    const bool isOnly =
        !diagrams[k].isOfLoads && std::ranges::all_of(curves[k], [&](const auto* curve) {
          return curve->name == curves[k].front()->name;
        });
    for (std::size_t line = 0; line < curves[k].size(); ++line) {
      std::string& name = diagrams[k].lines[line].name;
      if (isOne) name = curves[k][line]->name;
      if (!isOne && !isOnly) name += ", " + curves[k][line]->name;
      const bool repeatsColour = line / std::size(kLines) % 2 == 1;
      diagrams[k].lines[line].isWhollyDashed = repeatsColour || curves[k][line]->isReference;
      if (diagrams[k].lines[line].isWhollyDashed) name += " (dashed)";
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

}  // namespace

/// A text with its place on the page.
struct PlacedText {
  std::string text;
  double left = 0;      ///< pixels
  double baseline = 0;  ///< pixels
  int em = 1;           ///< pixels
};

/// The axes of a diagram in its box, and its texts.
struct DiagramAxes {
  picture::Axis across;
  picture::Axis up;
  picture::PageBox box;
  PlacedText title = {};
  PlacedText acrossTitle = {};
  std::vector<PlacedText> names = {};  ///< one per line, or empty

  /// Pixels from two fractions of the box.
  Eigen::Vector2d place(double acrossShare, double upShare) const {
    return {box.left + acrossShare * box.width, box.lower() - upShare * box.height};
  }

  /// The position of a sample; absent if it is not drawn.
  std::optional<Eigen::Vector2d> pointOf(const PlotLine& line, std::size_t sample) const {
    const double value = line.values[sample], at = line.across[sample];
    if (!std::isfinite(at) || !std::isfinite(value)) return std::nullopt;
    if (up.isLogarithmic && value <= 0) return std::nullopt;
    const double shown = up.isLogarithmic ? std::max(value, up.low) : value;
    return place(across.shareOf(at), up.shareOf(shown));
  }
};

namespace {

/// Curves begin and end at the borders.
picture::Axis makeAcrossAxis(const std::vector<double>& values, int maxTicks) {
  picture::Axis axis = picture::makeAxis(values, maxTicks);
  const auto [least, largest] = std::ranges::minmax_element(values);
  if (*least < *largest) {
    axis.low = *least;
    axis.high = *largest;
  }
  return axis;
}

/// All curves of a diagram share one axis; missing values are omitted.
picture::Axis makeUpAxis(const Diagram& diagram, int maxTicks) {
  std::vector<double> values;
  for (const PlotLine& line : diagram.lines) {
    std::ranges::copy_if(line.values, std::back_inserter(values),
                         [](double value) { return std::isfinite(value); });
  }
  if (!diagram.isLogarithmic) return picture::makeAxis(values, maxTicks);
  if (!diagram.isRounding()) {
    double least = std::numeric_limits<double>::infinity();
    for (const PlotLine& line : diagram.lines) {
      double largest = 0;
      for (const double value : line.values) {
        if (std::isfinite(value)) largest = std::max(largest, value);
      }
      if (largest > 0) least = std::min(least, std::max(diagram.rounding, largest / kLargestRatio));
    }
    for (double& value : values) value = value > 0 ? std::max(value, least) : value;
  }
  return picture::makeLogarithmicAxis(values, maxTicks);
}

/// Whether the axis, cut to the ends of its curves, still has this tick.
bool hasTick(const picture::Axis& axis, double tick) {
  const double share = axis.shareOf(tick);
  return share >= -1e-9 && share <= 1 + 1e-9;
}

/// The finite values of the abscissa of all diagrams with its title, which share an axis.
std::vector<double> acrossValues(const Diagram& diagram, const std::vector<PlottedRun>& runs) {
  std::vector<double> values;
  for (const PlottedRun& run : runs) {
    if (run.abscissa.title != diagram.across) continue;
    std::ranges::copy_if(run.abscissa.values, std::back_inserter(values),
                         [](double value) { return std::isfinite(value); });
  }
  return values;
}

/// A line for each sequence of samples with values, and the dashes of dashed lines. `em`: pixels.
std::vector<picture::Canvas::Points> linesOf(const PlotLine& line, const DiagramAxes& axes,
                                             int em) {
  std::vector<picture::Canvas::Points> lines, dashes;
  picture::Canvas::Points points;
  bool isDashed = false;
  const auto endLine = [&] {
    // A single sample makes no line.
    if (points.size() > 1 && isDashed) {
      for (picture::Canvas::Points& dash : dashesOf(points, kDash * em, kGap * em)) {
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

/// Finds axes and positions of texts of a diagram in its column. Lengths are in em of the text.
class DiagramLayout {
 public:
  /// `left`, `right`: of the column, pixels. The runs and the diagram must outlive it.
  DiagramLayout(const Diagram& diagram, const std::vector<PlottedRun>& runs,
                const picture::LabelWriter& writer, int em, double left, double right)
      : diagram_(diagram), runs_(runs), writer_(writer), em_(em), left_(left), right_(right) {}

  /// Space that the numbers of the vertical axis need on the left of a diagram of this height,
  /// pixels.
  double numbersWidth(double height) const { return writer_.widest(upAxis(height).texts) + em_; }

  /// The layout in a box, which has kTitleEms above it and kBelowEms below it.
  DiagramAxes axesIn(const picture::PageBox& box) const {
    DiagramAxes axes{acrossAxis(box.width), upAxis(box.height), box};
    const bool hasDashes = std::ranges::any_of(diagram_.lines, &PlotLine::hasDashes);
    const std::string title = diagram_.title + (hasDashes ? " (dashed: unstable)" : "") +
                              (diagram_.isRounding() ? " (only rounding)" : "");
    axes.title = fitted(title, left_ + kLetterEms * em_, box.left, box.upper - 0.6 * em_);
    axes.acrossTitle =
        fitted(diagram_.across, left_, box.left + 0.5 * box.width - 0.5 * width(diagram_.across),
               box.lower() + 2.5 * em_);
    if (diagram_.lines.size() > 1 && !placeNextToTitle(axes) && !placeInCorner(axes, true) &&
        !placeInLines(axes)) {
      placeInCorner(axes, false);
    }
    return axes;
  }

 private:
  picture::Axis upAxis(double height) const {
    const int most = static_cast<int>(height / (kTickLineEms * em_));
    return makeUpAxis(diagram_, std::clamp(most, 2, kTicksUp));
  }

  /// With as many ticks as have space.
  picture::Axis acrossAxis(double length) const {
    const std::vector<double> values = acrossValues(diagram_, runs_);
    picture::Axis axis;
    for (int most = kTicksAcross; most >= 1; --most) {
      axis = makeAcrossAxis(values, most);
      double end = -std::numeric_limits<double>::infinity();
      bool hasSpace = true;
      for (std::size_t k = 0; k < axis.ticks.size(); ++k) {
        if (!hasTick(axis, axis.ticks[k])) continue;
        const double middle = axis.shareOf(axis.ticks[k]) * length;
        hasSpace &= middle - 0.5 * width(axis.texts[k]) >= end;
        end = middle + 0.5 * width(axis.texts[k]) + 0.5 * em_;
      }
      if (hasSpace) break;
    }
    return axis;
  }

  double width(const std::string& text) const { return writer_.width(text); }

  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const PlotLine& line : diagram_.lines) all.push_back(line.name);
    return all;
  }

  /// The text as near to `preferred` as it can be between `least` and the right border; smaller if
  /// it is too long.
  PlacedText fitted(const std::string& text, double least, double preferred,
                    double baseline) const {
    const double share = std::min(1.0, (right_ - least) / std::max(1.0, width(text)));
    const int em = std::max(1, static_cast<int>(std::floor(share * em_)));
    const double last = right_ - width(text) * em / em_;
    return {text, std::max(least, std::min(preferred, last)), baseline, em};
  }

  /// The names end at the right border of the diagram, in the order of the curves.
  bool placeNextToTitle(DiagramAxes& axes) const {
    double needed = width(axes.title.text);
    for (const PlotLine& line : diagram_.lines) needed += em_ + width(line.name);
    if (needed > axes.box.width) return false;
    double right = axes.box.right();
    for (std::size_t k = diagram_.lines.size(); k-- > 0;) {
      const std::string& name = diagram_.lines[k].name;
      right -= width(name);
      axes.names.insert(axes.names.begin(), {name, right, axes.title.baseline, em_});
      right -= em_;
    }
    return true;
  }

  /// One below the other in the corner where the lines are shortest: upper right, upper left, lower
  /// right or lower left. `isFree`: only where there are none.
  bool placeInCorner(DiagramAxes& axes, bool isFree) const {
    const picture::PageBox& box = axes.box;
    const auto count = static_cast<double>(diagram_.lines.size());
    picture::PageBox part{0, 0, static_cast<double>(writer_.widest(names()) + em_),
                          (kNameLineEms * count + 0.5) * em_};
    if (isFree && (part.width > box.width || part.height > box.height)) return false;
    const double lefts[] = {box.right() - part.width, box.left};
    const double uppers[] = {box.upper, box.lower() - part.height};
    double shortest = std::numeric_limits<double>::infinity();
    bool isRight = true;
    for (const double upper : uppers) {
      for (const double left : lefts) {
        const double length = lengthIn({left, upper, part.width, part.height}, axes);
        if (length >= shortest) continue;
        shortest = length;
        part.left = left;
        part.upper = upper;
        isRight = left == lefts[0];
      }
    }
    if (isFree && shortest > 0) return false;
    for (std::size_t k = 0; k < diagram_.lines.size(); ++k) {
      const std::string& name = diagram_.lines[k].name;
      const double inner = isRight ? part.width - 0.5 * em_ - width(name) : 0.5 * em_;
      axes.names.push_back(
          fitted(name, left_, part.left + inner,
                 part.upper + (1.2 + kNameLineEms * static_cast<double>(k)) * em_));
    }
    return true;
  }

  /// In lines between title and diagram, which becomes lower. Smaller letters if they do not fit.
  bool placeInLines(DiagramAxes& axes) const {
    const double start = std::min(axes.box.left, axes.title.left);
    for (const double share : {1.0, 0.85, 0.7}) {
      const int em = std::max(1, static_cast<int>(share * em_));
      const auto widthOf = [&](const std::string& name) { return width(name) * em / em_; };
      double pen = start, baseline = axes.title.baseline + kNameLineEms * em_;
      std::vector<PlacedText> placed;
      for (const PlotLine& line : diagram_.lines) {
        if (pen > start && pen + widthOf(line.name) > right_) {
          pen = start;
          baseline += kNameLineEms * em;
        }
        placed.push_back(fitted(line.name, left_, pen, baseline));
        placed.back().em = std::min(placed.back().em, em);
        placed.back().left = std::max(left_, std::min(pen, right_ - widthOf(line.name)));
        pen += widthOf(line.name) + em;
      }
      const double lowered = baseline - axes.title.baseline;
      if (axes.box.height - lowered < kLowestEms * em_) continue;
      axes.names = std::move(placed);
      axes.box.upper += lowered;
      axes.box.height -= lowered;
      axes.up = upAxis(axes.box.height);
      return true;
    }
    return false;
  }

  /// Length of all lines in a part of a diagram, pixels. Pieces of up to a quarter of an em count
  /// where they begin.
  double lengthIn(const picture::PageBox& part, const DiagramAxes& axes) const {
    double length = 0;
    for (const PlotLine& line : diagram_.lines) {
      for (const picture::Canvas::Points& points : linesOf(line, axes, em_)) {
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

  const Diagram& diagram_;
  const std::vector<PlottedRun>& runs_;
  const picture::LabelWriter& writer_;
  int em_;
  double left_, right_;
};

/// Draws diagrams of one figure. Lengths are in em of its text.
class Plotter {
 public:
  Plotter(picture::Canvas& canvas, int em, picture::Colour background)
      : canvas_(canvas), em_(em), colours_(background), writer_(em) {}

  /// Lines are 0.13 em wide, 0.9 points in a figure with text of 7 points.
  void draw(const Diagram& diagram, const DiagramAxes& axes) {
    drawGrid(axes);
    for (std::size_t k = 0; k < diagram.lines.size(); ++k) {
      canvas_.lines(linesOf(diagram.lines[k], axes, em_), 0.13 * em_, colours_.line(k));
    }
    write(axes.title, colours_.text);
    for (std::size_t k = 0; k < axes.names.size(); ++k) write(axes.names[k], colours_.line(k));
    write(axes.acrossTitle, colours_.text);
  }

 private:
  /// Ticks and numbers of both axes, and the two axes themselves.
  void drawGrid(const DiagramAxes& axes) {
    const picture::Axis &across = axes.across, &up = axes.up;
    const picture::PageBox& box = axes.box;
    std::vector<picture::Canvas::Points> grid;
    for (std::size_t k = 0; k < up.ticks.size(); ++k) {
      const double share = up.shareOf(up.ticks[k]);
      grid.push_back({axes.place(0, share), axes.place(1, share)});
      write({up.texts[k], box.left - 0.5 * em_ - width(up.texts[k]),
             axes.place(0, share).y() + 0.35 * em_, em_},
            colours_.text);
    }
    for (std::size_t k = 0; k < across.ticks.size(); ++k) {
      if (!hasTick(across, across.ticks[k])) continue;
      const double share = across.shareOf(across.ticks[k]);
      grid.push_back({axes.place(share, 0), axes.place(share, 1)});
      write({across.texts[k], axes.place(share, 0).x() - 0.5 * width(across.texts[k]),
             box.lower() + 1.25 * em_, em_},
            colours_.text);
    }
    canvas_.lines(grid, 0.06 * em_, colours_.grid);
    canvas_.lines({{axes.place(0, 1), axes.place(0, 0), axes.place(1, 0)}}, 0.08 * em_,
                  colours_.frame);
  }

  double width(const std::string& text) const { return writer_.width(text); }

  void write(const PlacedText& placed, picture::Colour colour) {
    canvas_.text(placed.text, placed.left, placed.baseline, placed.em, colour);
  }

  picture::Canvas& canvas_;
  int em_;
  PlotColours colours_;
  picture::LabelWriter writer_;
};

/// The positions of the diagrams of a figure.
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
  layout.first = {kNumbersEms * em, kTitleEms * em, wide,
                  kAspect * wide / (diagrams == 1 ? 1.2 : 1)};
  layout.down = layout.first.height + (kTitleEms + kBelowEms) * em;
  return layout;
}

}  // namespace

PlotSheet::PlotSheet(const std::vector<PlottedRun>& runs, int em, picture::Colour background)
    : runs_(runs), diagrams_(diagramsOf(runs)), em_(em), background_(background) {
  if (!diagrams_.empty()) return;
  std::vector<std::string> empty;
  for (const PlottedRun& run : runs_) {
    for (const trajectory::CurveGroup& group : run.groups) empty.push_back(group.name);
  }
  throw InputError(empty.empty() ? "error: the run has no curve to plot"
                                 : fmt::format("error: the run has no values of {} to plot. Choose "
                                               "other curves",
                                               fmt::join(empty, ", ")));
}

PlotSheet::~PlotSheet() = default;

int PlotSheet::rows(int columns) const {
  return (static_cast<int>(diagrams_.size()) + columns - 1) / columns;
}

double PlotSheet::height(double width, int columns) const {
  const auto diagrams = static_cast<int>(diagrams_.size());
  return rows(columns) * layOut(diagrams, em_, width, columns).down;
}

double PlotSheet::minHeight(int columns) const {
  return rows(columns) * (kMinEms + kTitleEms + kBelowEms) * em_;
}

std::vector<DiagramAxes> PlotSheet::axes(const picture::PageBox& box, int columns) const {
  const auto count = static_cast<int>(diagrams_.size());
  PlotLayout layout = layOut(count, em_, box.width, columns);
  layout.first.left += box.left;
  layout.first.upper += box.upper;
  if (box.height > 0) {
    layout.down = box.height / rows(columns);
    layout.first.height = layout.down - (kTitleEms + kBelowEms) * em_;
  }
  const picture::LabelWriter writer(em_);
  std::vector<DiagramLayout> layouts;
  double numbers = std::min(kNumbersEms * em_, kNumbersShare * layout.across);
  for (int k = 0; k < count; ++k) {
    const picture::PageBox place = layout.box(k);
    const bool isLast = k % layout.columns == layout.columns - 1;
    const double right = isLast ? box.left + box.width : place.right() + em_;
    layouts.emplace_back(diagrams_[k], runs_, writer, em_, place.left - kNumbersEms * em_, right);
    numbers = std::max(numbers, layouts.back().numbersWidth(place.height));
  }
  std::vector<DiagramAxes> axes;
  for (int k = 0; k < count; ++k) {
    picture::PageBox place = layout.box(k);
    place.left += numbers - kNumbersEms * em_;
    place.width -= numbers - kNumbersEms * em_;
    axes.push_back(layouts[k].axesIn(place));
  }
  return axes;
}

void PlotSheet::draw(picture::Canvas& page, const picture::PageBox& box, int columns,
                     const std::string& prefix) const {
  const std::vector<DiagramAxes> placed = axes(box, columns);
  Plotter plotter(page, em_, background_);
  for (std::size_t k = 0; k < diagrams_.size(); ++k) {
    page.begin(prefix + "curves_" + std::to_string(k + 1));
    plotter.draw(diagrams_[k], placed[k]);
    page.end();
  }
}

std::vector<DrawnCurve> PlotSheet::drawnCurves(const picture::PageBox& box, int columns) const {
  const std::vector<DiagramAxes> placed = axes(box, columns);
  const PlotColours colours(background_);
  std::vector<DrawnCurve> curves;
  for (std::size_t k = 0; k < diagrams_.size(); ++k) {
    for (std::size_t number = 0; number < diagrams_[k].lines.size(); ++number) {
      const PlotLine& line = diagrams_[k].lines[number];
      curves.push_back({colours.line(number), {}});
      for (std::size_t sample = 0; sample < line.values.size(); ++sample) {
        curves.back().points.push_back(placed[k].pointOf(line, sample));
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
  const int columns = size.width < kNarrowFigureEms * em ? 1 : PlotSheet::kColumns;
  size.height = picture::wholePixels(sheet.height(size.width, columns));
  picture::requireValidSize(size);
  const std::unique_ptr<picture::Canvas> canvas =
      picture::makeCanvas(format, {.size = size,
                                   .pixelsPerInch = settings.dotsPerInch,
                                   .outlines = {.colour = kFrame},
                                   .fontFamily = picture::fontFamily(),
                                   .description = settings.madeBy});
  sheet.draw(*canvas, {.width = static_cast<double>(size.width)}, columns, "");
  return canvas->finish();
}

}  // namespace kirireel::record
