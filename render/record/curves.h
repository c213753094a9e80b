/// The curves of a run as files: a table, and figures for print.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/canvas.h"
#include "sim/mechanics/load_path.h"
#include "sim/trajectory/run_curves.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// Diagrams of curves. A figure has the same size in print as SVG, PDF and PNG.

/// The horizontal axis of a figure.
struct PlotAbscissa {
  std::string title;           ///< quantity and unit, such as "simulated time, s"
  std::vector<double> values;  ///< one per sample
};

/// The curves of one run in a figure.
struct PlottedRun {
  std::string name;  ///< in the names of its lines, if there are several runs
  std::vector<trajectory::CurveGroup> groups;
  PlotAbscissa abscissa;  ///< with a value for each sample of the curves
  /// Whether the line from each sample to the next is dashed. Empty: no line is dashed.
  std::vector<bool> isDashed = {};
  bool isLoadCurve = false;  ///< of a run that also has other curves, see loadCurvesOf()
  /// Smaller values of logarithmic groups are rounding, in the groups' unit. A diagram of only
  /// such values reports this. The axes of others begin there.
  double rounding = 0;
};

/// Appearance of a figure.
struct PlotSettings {
  double width = 180;        ///< of the whole figure, millimetres
  double dotsPerInch = 300;  ///< its unit, and the pixels of a PNG
  double fontPoints = 7;     ///< of all text
  std::string madeBy;        ///< author and source, stored in the file
};

/// The bytes of a figure in this format. It has one diagram per group with values, two per row, and
/// one line for each curve of each run, labelled in its colour. Groups with the same name and the
/// same title of the abscissa share a diagram. Equal curves give equal bytes. Throws InputError if
/// no group has values or a figure has more pixels than a frame may have, OutputError if the font
/// is missing.
std::string plotCurves(const std::vector<PlottedRun>& runs, picture::PageFormat format,
                       const PlotSettings& settings);

struct Diagram;
struct DiagramAxes;

/// A curve on a page.
struct DrawnCurve {
  picture::Colour colour;
  /// One per sample, pixels from the upper left of the page; absent if the sample is not drawn.
  std::vector<std::optional<Eigen::Vector2d>> points;
};

/// The diagrams of curves, to be drawn on a page. The runs must outlive it.
class PlotSheet {
 public:
  /// Text is `em` pixels high. Colours have contrast to the background of the page. Throws
  /// InputError if no group has values.
  PlotSheet(const std::vector<PlottedRun>& runs, int em,
            picture::Colour background = picture::PageSettings().background);
  ~PlotSheet();
  PlotSheet(const PlotSheet&) = delete;
  PlotSheet& operator=(const PlotSheet&) = delete;

  /// Height of all diagrams in this width, `columns` per row; pixels.
  double height(double width, int columns) const;

  /// Minimum height at which curves can be read, pixels.
  double minHeight(int columns) const;

  /// Draws all diagrams into a box, as parts whose names begin with `prefix`. Without a height the
  /// box is as high as height(). Throws OutputError if the font is missing.
  void draw(picture::Canvas& page, const picture::PageBox& box, int columns,
            const std::string& prefix) const;

  /// The curves that draw() draws into this box. Throws like draw().
  std::vector<DrawnCurve> drawnCurves(const picture::PageBox& box, int columns) const;

  /// Columns in a figure, unless it has fewer diagrams.
  static constexpr int kColumns = 2;

 private:
  int rows(int columns) const;
  std::vector<DiagramAxes> axes(const picture::PageBox& box, int columns) const;

  const std::vector<PlottedRun>& runs_;
  std::vector<Diagram> diagrams_;
  int em_;
  picture::Colour background_;
};

/// The curves with these names: of groups ("target_error", "opening") or of columns without their
/// unit ("opening_mean"); "theta" is the mean opening. No names: all curves. Curves of one group
/// are in one group, in the order of the names. Throws InputError for an unknown name, with the
/// option and the list of known names.
std::vector<trajectory::CurveGroup> selectCurves(const std::vector<trajectory::CurveGroup>& groups,
                                                 const std::vector<std::string>& names,
                                                 const char* option = "--curves");

/// The force of each grip that moves or pushes over its displacement, one curve per direction of a
/// [[grip]]; moments over rotations. Lines are dashed at unstable equilibria. `modelSize`: metres.
/// Displacements are in `unit`.
std::vector<PlottedRun> loadCurvesOf(const std::string& name, const mechanics::LoadCurve& curve,
                                     double modelSize, const LengthUnit& unit = {});

// ------------------------------------------------------------------------------------------------
// Files of one or more runs.

/// Horizontal axis of a figure's curves.
enum class CurvesAgainst {
  Time,      ///< simulated seconds
  Progress,  ///< the fraction of the motion, see MotionCurve
  Opening,   ///< the mean opening of the joints, degrees
};

/// The curves of a run with this name, see selectCurves(), in the unit of the model. Only curves
/// with values count. Reads the trajectory once. Throws InputError like selectCurves().
PlottedRun plottedCurve(const trajectory::TrajectoryReader& run, const std::string& name,
                        CurvesAgainst against, const char* option);

/// A column of an external table.
struct FileColumn {
  std::filesystem::path file;  ///< comma-separated text with names in its first line
  std::string name;            ///< of the column
};

/// A run with its name in a figure.
struct NamedRun {
  std::string name;  ///< in figures of several runs
  std::unique_ptr<trajectory::TrajectoryReader> reader;
  std::optional<mechanics::LoadCurve> loadCurve = {};  ///< of a run under grips
  std::map<std::string, std::string> inputs = {};      ///< of a run of a sweep, see sweepInputs()
};

/// The outputs of runs' curves.
struct CurvesSettings {
  /// Selected curves, see selectCurves(), and "load_curve"; empty: all except curves that are only
  /// rounding.
  std::vector<std::string> selected;
  /// Additional data, in the diagram of the curve with this column, else in a separate one. The
  /// horizontal axis is the column with the same name as for runs, else the first. If that has no
  /// numbers, as in the table of a sweep, it is the first with numbers, under its own name.
  std::vector<FileColumn> columns;
  std::filesystem::path folder;                 ///< created if needed
  std::vector<picture::PageFormat> plots;       ///< curves.svg, curves.pdf, curves.png
  CurvesAgainst against = CurvesAgainst::Time;  ///< quantity of the horizontal axis
  PlotSettings plot;                            ///< the style of the figure
};

/// The table: a row per sample, first time_s and progress, then every curve's column, those of each
/// joint last. Numbers read back bitwise equal. Empty fields are missing values. `progress` has one
/// entry per sample, [0, 1].
std::string curvesTable(const trajectory::RunCurves& curves, const std::vector<double>& progress);

/// Called with the number of a run, its curves, and the completed fraction of the motion at each
/// sample.
using CurvesObserver = std::function<void(std::size_t run, const trajectory::RunCurves& curves,
                                          const std::vector<double>& progress)>;

/// The selected curves of runs, in the form for a figure. Lengths and areas are in the unit of the
/// first model. Runs of a sweep are named by the inputs in which they differ. Reads each trajectory
/// once. Throws InputError if a run lacks the quantity of the axis or a selected curve.
std::vector<PlottedRun> plottedRuns(const std::vector<NamedRun>& runs,
                                    const CurvesSettings& settings,
                                    const CurvesObserver& observer = {});

/// Opens the run of a trajectory.h5, with the name of its folder. Throws like TrajectoryReader.
NamedRun openRun(const std::filesystem::path& trajectory);

/// Writes curves.csv and the figures to the folder, all or none, and lists them in contents.json.
/// Several runs have one table each, curves_1.csv and so on, and one figure. Returns the file
/// names. Throws InputError if files from elsewhere are in the way or a run lacks the quantity of
/// the axis, OutputError if a file cannot be written. Reads each trajectory once.
std::vector<std::string> writeCurves(const std::vector<NamedRun>& runs,
                                     const CurvesSettings& settings);

}  // namespace kirireel::record
