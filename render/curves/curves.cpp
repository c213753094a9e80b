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
constexpr const char* kOpening = "opening_mean_deg";

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
