/// Curves of a run as a figure for print.
///
/// The same figure can be had as SVG, PDF and PNG; sizes are those of print in all three.
#pragma once

#include <string>
#include <vector>

#include "render/vector/canvas.h"
#include "sim/measure/run_curves.h"

namespace kirireel {

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
std::string plotCurves(const RunCurves& curves, const PlotAbscissa& abscissa, PageFormat format,
                       const PlotSettings& settings);

}  // namespace kirireel
