// Writes curves.csv and the figures of a run.
//
// curves.csv is text in UTF-8 with commas (RFC 4180, but with "\n" at line ends). The first line
// holds the names of the columns, each with its unit at its end (time_s, opening_mean_deg); each
// further line is a sample of the trajectory, by rising time. A value that does not exist is an
// empty field, which spreadsheets and pandas read as missing, where "nan" would make a column text.
//
// Numbers have the shortest digits that read back to the same double.
#include "render/curves/curves.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "render/folder/file_set.h"
#include "render/record/pace.h"
#include "render/record/versions.h"
#include "sim/base/error.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

constexpr const char* kTable = "curves.csv";
// The column that --against opening takes.
constexpr const char* kOpening = "opening_mean_deg";

/// A name for each format, so that all of them stand side by side.
const char* fileOf(PageFormat format) {
  switch (format) {
    case PageFormat::Svg:
      return "curves.svg";
    case PageFormat::Pdf:
      return "curves.pdf";
    case PageFormat::Png:
      break;
  }
  return "curves.png";
}

/// No field needs quotation marks: all are numbers.
std::string fieldText(double value) {
  return std::isnan(value) ? "" : fmt::format("{}", value);
}

/// The curves of all groups, in order.
std::vector<const Curve*> allCurves(const RunCurves& curves) {
  std::vector<const Curve*> all;
  for (const CurveGroup& group : curves.groups) {
    for (const Curve& curve : group.curves) all.push_back(&curve);
  }
  for (const Curve& curve : curves.joints) all.push_back(&curve);
  return all;
}

/// The values that curves are drawn against, one a sample. They need not rise: a sheet may close
/// again.
PlotAbscissa abscissaOf(const RunCurves& curves, const std::vector<double>& progress,
                        CurvesAgainst against) {
  if (against == CurvesAgainst::Time) return {"simulated time, s", curves.times};
  if (against == CurvesAgainst::Progress) return {"share of the motion", progress};
  for (const Curve* curve : allCurves(curves)) {
    if (curve->column == kOpening && curve->hasValues()) {
      return {"mean opening, degrees", curve->values};
    }
  }
  throw InputError("error: the model has no joints that open; plot --against time or progress");
}

}  // namespace

std::string curvesTable(const RunCurves& curves, const std::vector<double>& progress) {
  const std::vector<const Curve*> columns = allCurves(curves);
  std::string table = "time_s,progress";
  for (const Curve* curve : columns) table += "," + curve->column;
  table += '\n';
  for (std::size_t k = 0; k < curves.times.size(); ++k) {
    table += fmt::format("{},{}", curves.times[k], progress[k]);
    for (const Curve* curve : columns) table += "," + fieldText(curve->values[k]);
    table += '\n';
  }
  return table;
}

std::vector<std::string> writeCurves(const TrajectoryReader& run, const CurvesSettings& settings) {
  std::vector<std::string> names = {kTable};
  for (const PageFormat format : settings.plots) names.emplace_back(fileOf(format));
  FileSet files(settings.folder, output::kContents);
  files.requireFree([&names](const std::string& name) {
    return name == output::kContents || std::ranges::find(names, name) != names.end();
  });
  const RunCurves curves = curvesOf(run);
  // The share of the motion at a time, as in a video at an even pace; 0 at the start, 1 at the end.
  const MotionCurve motion = motionOf(run);
  std::vector<double> progress;
  for (const double time : curves.times) progress.push_back(motion.shareAt(time));
  writeTextFile(files.stage() / kTable, curvesTable(curves, progress));
  PlotSettings plot = settings.plot;
  plot.madeBy = fmt::format("Kirireel {}, model {}", programVersion(), run.subject().model.name);
  for (const PageFormat format : settings.plots) {
    writeTextFile(files.stage() / fileOf(format),
                  plotCurves(curves, abscissaOf(curves, progress, settings.against), format, plot));
  }
  files.commit(names);
  return names;
}

}  // namespace kirireel
