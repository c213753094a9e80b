/// What a run measures over its time: the curves that papers plot.
#pragma once

#include <memory>
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
  ///     Energy            kinetic, stored in springs and joints that give, and at hinges, J; of a
  ///                       walked path kinetic alone, by central differences: it tells the pace
  ///                       of the walk
  ///     Work of the drives    put in so far, J; see Energies, as the next
  ///     Lost energy       taken so far by dampers, by contacts and by the integrator, J
  ///     Joint force       mean and largest, and the largest of those that are indeterminate, N
  ///     Force on held tiles   the largest of a pin, of a grip and of a contact, N
  ///     Target error, Joint gap, Overlap    as samples have them, m
  std::vector<CurveGroup> groups;
  /// For each joint its opening in degrees, the size of its force in newtons and whether that is
  /// indeterminate (1): opening_J_deg, joint_force_J_N, joint_force_J_indeterminate; J counts as
  /// the model's files do.
  std::vector<Curve> joints;
};

/// What is said of a run without energies and forces.
inline constexpr const char* kNoMechanics =
    "the run has no energies and forces: a path of the mechanism is geometry, and engines do not "
    "tell theirs; one recorded with --path dynamic has both";

/// Measures from the poses of samples what trajectory.h5 does not have already: the channels width
/// to opening_largest of the list above, and each joint's opening as rows. The subject must outlive
/// the meter.
std::unique_ptr<SampleMeter> makeCurveMeter(const Subject& subject);

/// Measures all samples of a run. Throws InputError as the reader does.
RunCurves curvesOf(const TrajectoryReader& run);

/// The same curves but those of each joint at other times, rising, straight between the samples;
/// NaN where either side is.
RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times);

}  // namespace kirireel
