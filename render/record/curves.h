/// The curves of a run as files: a table, and figures for print.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/picture/canvas.h"
#include "sim/trajectory/run_curves.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// Curves of a run as a figure for print.
//
// The same figure can be had as SVG, PDF and PNG; sizes are those of print in all three.

/// What lies along the horizontal axes of a figure.
struct PlotAbscissa {
  std::string title;           ///< quantity and unit, such as "simulated time, s"
  std::vector<double> values;  ///< one a sample
};

/// How a figure is set.
struct PlotSettings {
  double width = 180;        ///< of the whole figure, millimetres
  double dotsPerInch = 300;  ///< its unit, and the pixels of a PNG
  double fontPoints = 7;     ///< of all text
  std::string madeBy;        ///< who makes it from what, noted in the file
};

/// A file of this format with a diagram for each group that has values, two in a row, and one line
/// for each curve, named in its colour. The same curves give the same bytes. Throws InputError
/// where no group has any, OutputError when the font is missing. Also throws InputError for a
/// figure of more pixels than a frame may have. `abscissa` has a value for each sample of the
/// curves.
std::string plotCurves(const trajectory::RunCurves& curves, const PlotAbscissa& abscissa,
                       picture::PageFormat format, const PlotSettings& settings);

// ------------------------------------------------------------------------------------------------
// The curves of a run as files: a table, and figures.

/// What a figure's curves are drawn against.
enum class CurvesAgainst {
  Time,      ///< simulated seconds
  Progress,  ///< the share of the motion, see MotionCurve
  Opening,   ///< the mean opening of the joints, degrees
};

/// The outputs of a run's curves.
struct CurvesSettings {
  std::filesystem::path folder;                 ///< made if need be
  std::vector<picture::PageFormat> plots;       ///< curves.svg, curves.pdf, curves.png
  CurvesAgainst against = CurvesAgainst::Time;  ///< what the horizontal axis shows
  PlotSettings plot;                            ///< the style of the figure
};

/// The table: a row a sample, first time_s and progress, then every curve's column, those of each
/// joint last; numbers read back to the last bit, and empty fields are where a value does not
/// exist. `progress` has an entry a sample, 0 to 1.
std::string curvesTable(const trajectory::RunCurves& curves, const std::vector<double>& progress);

/// Writes curves.csv and the figures into the folder, all of them or none, and lists them in
/// contents.json. Returns their names. Throws InputError if files of others are in the way and
/// for figures against what the run does not have, OutputError when one cannot be written. Reads
/// the whole trajectory once.
std::vector<std::string> writeCurves(const trajectory::TrajectoryReader& run,
                                     const CurvesSettings& settings);

}  // namespace kirireel::record
