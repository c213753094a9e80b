/// The curves of a run as files: a table, and figures for print.
#pragma once

#include <filesystem>
#include <memory>
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

/// The curves of one run in a figure.
struct PlottedRun {
  std::string name;  ///< in the names of its lines, where there are several runs
  std::vector<trajectory::CurveGroup> groups;
  PlotAbscissa abscissa;  ///< with a value for each sample of the curves
};

/// How a figure is set.
struct PlotSettings {
  double width = 180;        ///< of the whole figure, millimetres
  double dotsPerInch = 300;  ///< its unit, and the pixels of a PNG
  double fontPoints = 7;     ///< of all text
  std::string madeBy;        ///< who makes it from what, noted in the file
};

/// A file of this format with a diagram for each group that has values, two in a row, and one line
/// for each curve of each run, named in its colour. Groups of one name share a diagram. The same
/// curves give the same bytes. Throws InputError where no group has any, OutputError when the font
/// is missing. Also throws InputError for a figure of more pixels than a frame may have.
std::string plotCurves(const std::vector<PlottedRun>& runs, picture::PageFormat format,
                       const PlotSettings& settings);

/// The curves of these names: of groups ("target_error", "opening") or of columns without their
/// unit
/// ("opening_mean"); "theta" is the mean opening. All for no names. Throws InputError for a name
/// that is none, with those that are.
std::vector<trajectory::CurveGroup> selectCurves(const trajectory::RunCurves& curves,
                                                 const std::vector<std::string>& names);

// ------------------------------------------------------------------------------------------------
// The curves of a run as files: a table, and figures.

/// What a figure's curves are drawn against.
enum class CurvesAgainst {
  Time,      ///< simulated seconds
  Progress,  ///< the share of the motion, see MotionCurve
  Opening,   ///< the mean opening of the joints, degrees
};

/// A column of a table that others made.
struct FileColumn {
  std::filesystem::path file;  ///< text with commas, names in its first line
  std::string name;            ///< of the column
};

/// A run whose curves are shown.
struct NamedRun {
  std::string name;  ///< in figures of several runs
  std::unique_ptr<trajectory::TrajectoryReader> reader;
};

/// The outputs of runs' curves.
struct CurvesSettings {
  std::vector<std::string> selected;  ///< plotted, see selectCurves(); empty: all
  /// Plotted too, in the diagram of the curve with this column, else in one of its own. Along the
  /// horizontal axis lies the column of the same name as for runs, else the first.
  std::vector<FileColumn> columns;
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
/// contents.json. Of several runs there is a table for each, curves_1.csv and so on, and one
/// figure. Returns their names. Throws InputError if files of others are in the way and for figures
/// against what the run does not have, OutputError when one cannot be written. Reads each
/// trajectory once.
std::vector<std::string> writeCurves(const std::vector<NamedRun>& runs,
                                     const CurvesSettings& settings);

}  // namespace kirireel::record
