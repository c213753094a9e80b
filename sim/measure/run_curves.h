/// What a run measures over its time: the curves that papers plot.
#pragma once

#include <string>
#include <vector>

#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// One quantity by time.
struct Curve {
  std::string name;            ///< one short phrase, such as "width"
  std::string column;          ///< in tables, with its unit, such as "width_m"
  std::vector<double> values;  ///< one a sample; NaN where it does not exist

  bool hasValues() const;
};

/// Curves of one unit that stand together in one diagram.
struct CurveGroup {
  std::string name;            ///< one short phrase, such as "Size"
  std::string unit;            ///< "m", "degrees", ...; may be empty
  bool isLogarithmic = false;  ///< what matters is how small it is: it may fall by many decades
  std::vector<Curve> curves;   ///< one or more

  /// Whether any curve has any value.
  bool hasValues() const;
};

/// All curves of a run.
struct RunCurves {
  std::vector<double> times;  ///< of the samples, simulated seconds
  /// Always the same groups and curves in the same order:
  ///
  ///     Size              width, height, depth: the box around the tiles along x, y, z; m
  ///     Area              hull: within the convex outline seen along z; covered: by tiles that lie
  ///                       flat; m^2
  ///     Hull perimeter    of that outline, m
  ///     Porosity          1 - covered / hull
  ///     Poisson's ratio   since the start, see poissonsRatio()
  ///     Opening           of the joints, see openingAngles(): least, mean, largest; degrees
  ///     Kinetic energy    by central differences of the samples, J; of a walked path it tells the
  ///                       pace of the walk
  ///     Target error, Joint gap, Overlap    as samples have them, m
  std::vector<CurveGroup> groups;
};

/// Measures all samples of a run. Throws InputError as the reader does.
RunCurves curvesOf(const TrajectoryReader& run);

/// The same curves at other times, rising, straight between the samples; NaN where either side is.
RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times);

}  // namespace kirireel
