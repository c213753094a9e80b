/// The curves of a run as files: a table, and figures.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/curves/plot.h"
#include "sim/measure/run_curves.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// What a figure's curves are drawn against.
enum class CurvesAgainst {
  Time,      ///< simulated seconds
  Progress,  ///< the share of the motion, see MotionCurve
  Opening,   ///< the mean opening of the joints, degrees
};

/// What is to be written of a run.
struct CurvesSettings {
  std::filesystem::path folder;   ///< made if need be
  std::vector<PageFormat> plots;  ///< curves.svg, curves.pdf, curves.png
  CurvesAgainst against = CurvesAgainst::Time;
  PlotSettings plot;
};

/// The table: a row a sample, first time_s and progress, then every curve's column, those of each
/// joint last; numbers read back to the last bit, and empty fields are where a value does not
/// exist. `progress` has an entry a sample, 0 to 1.
std::string curvesTable(const RunCurves& curves, const std::vector<double>& progress);

/// Writes curves.csv and the figures into the folder, all of them or none, and lists them in
/// contents.json. Returns their names. Throws InputError where files of others stand in the way and
/// for figures against what the run does not have, OutputError when one cannot be written. Reads
/// the whole trajectory once.
std::vector<std::string> writeCurves(const TrajectoryReader& run, const CurvesSettings& settings);

}  // namespace kirireel
