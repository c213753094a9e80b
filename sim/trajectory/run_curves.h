/// Measures of a run over time: curves as in papers.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/length_unit.h"
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/model/model.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::trajectory {

/// One quantity over time.
struct Curve {
  std::string name;            ///< one short phrase, such as "width"
  std::string column;          ///< in tables, with its unit, such as "width_mm"
  std::vector<double> values;  ///< one per sample; NaN if undefined
  bool isReference = false;    ///< exact values for the other curves: dashed in plots

  /// Whether a plot shows it: two consecutive samples are numbers, or the only sample is one.
  bool hasLine() const;
};

/// Curves with the same unit, for one diagram.
struct CurveGroup {
  std::string name;            ///< one short phrase, such as "Size"
  std::string unit;            ///< "mm", "degrees", ...; may be empty
  bool isLogarithmic = false;  ///< values may fall over many decades
  std::vector<Curve> curves;   ///< one or more
  int lengthPower = 0;         ///< of the length in its values: 1 of lengths, 2 of areas, else 0

  /// Whether any curve has a line.
  bool hasLine() const;
};

/// All curves of a run.
struct RunCurves {
  std::vector<double> times;  ///< of the samples, simulated seconds
  /// Always the same groups and curves in the same order. L is the unit of the model:
  ///
  ///     Size              width, height, depth: the box around the tiles along x, y, z; L
  ///     Area              hull: within the convex outline seen from above, see
  ///                       model::viewFrame(); covered: by tiles that lie flat; L^2
  ///     Hull perimeter    of that outline, L
  ///     Porosity          1 - covered / hull
  ///     Poisson's ratio   since the start, see poissonsRatio()
  ///     Opening           of the joints, see openingAngles(): least, mean, largest; degrees
  ///     Energy            kinetic, stored in springs and compliant joints, and at hinges, J. The
  ///                       rows from here to the forces need dynamics by the direct solver
  ///     Work of the drives    since the start, J; see Energies
  ///     Lost energy       in dampers, contacts and the integrator since the start, J
  ///     Joint force       mean and largest, and the largest of those that are indeterminate, N
  ///     Force on held tiles   the largest of a pin, of a grip and of a contact, N
  ///     Target error      largest, as in samples, and mean of the vertices, L
  ///     Joint gap, Overlap    as in samples, L
  ///     Radius            largest distance of a vertex from the mean of all, L: of the sheet, and
  ///                       of its exact motion at the same mean opening, see ExactMotion
  ///     Shape error       distance of the vertices from that motion, largest and mean, L
  std::vector<CurveGroup> groups;
  /// For each joint its opening in degrees, the magnitude of its force in newtons and whether that
  /// is indeterminate (1): opening_J_deg, joint_force_J_N, joint_force_J_indeterminate. J counts as
  /// in the model's files.
  std::vector<Curve> joints;
};

/// The groups of all runs, without values, with lengths in this unit.
std::vector<CurveGroup> curveGroups(const LengthUnit& unit = {});

/// Message for a run without energies and forces.
inline constexpr const char* kNoMechanics =
    "the run has no energies and forces: kinematic paths have none, and engines do not report "
    "theirs. Record it with `path = dynamic`";

/// Measures quantities that trajectory.h5 does not contain, from the poses of samples: the channels
/// width to opening_largest of the list above, and each joint's opening as rows. Keeps a reference
/// to the subject.
std::unique_ptr<SampleMeter> makeCurveMeter(const Subject& subject);

/// Measures all samples of a run. Throws InputError like the reader.
RunCurves curvesOf(const TrajectoryReader& run);

/// The curves at other times, ascending, without those of each joint. Interpolates linearly between
/// the samples; NaN if either side is NaN.
RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times);

/// The value at a time, linear between those at one or more ascending times (or other numbers),
/// constant beyond. NaN if a value that it needs is NaN.
double valueAt(const std::vector<double>& times, const std::vector<double>& values, double time);

/// The index of the entry of one or more ascending times that is nearest to `time`; of two that are
/// equally near, the earlier one.
std::size_t nearestIndex(const std::vector<double>& times, double time);

// ------------------------------------------------------------------------------------------------
// Measures of a whole sheet in one state: sizes, areas, openings.

/// Sides of the box around all vertices, along x, y and z, metres.
Vector3 boxSides(const std::vector<model::Tile>& tiles);

/// The convex outline of all vertices seen along z.
struct HullSize {
  double area = 0;       ///< square metres
  double perimeter = 0;  ///< metres
};

/// For one or more tiles. O(n log n) in the vertices. A sheet seen from its edge has area 0.
HullSize hullSize(const std::vector<model::Tile>& tiles);

/// The area that tiles cover, square metres, if all are in one horizontal plane (to 1e-6 of the
/// box). Absent otherwise, because tiles then hide each other. Overlapping areas count once.
std::optional<double> coveredArea(const std::vector<model::Tile>& tiles);

/// Poisson's ratio between two states seen along z, from the logarithmic (Hencky) strain of the
/// affine map that fits the motion of the tiles' centres (means of their corners) best:
///   -e_yy / e_xx,   e = log(F^T F) / 2,   F = argmin sum |F (c_i - c) - (c'_i - c')|^2.
/// Borders do not count: it is -1 for all rotating squares, triangles and hexagons at any opening.
/// Absent if e_xx is below 1e-3, because rounding would dominate, or if all centres are on a line.
std::optional<double> poissonsRatio(const std::vector<model::Tile>& before,
                                    const std::vector<model::Tile>& now);

/// For each joint the rotation between its tiles, 0 at the start. It measures the opening of the
/// joint. Radians, [0, pi]. `poses` has one pose per tile. In the order of the joints; links and
/// fixed joints count too.
std::vector<double> openingAngles(const std::vector<model::Joint>& joints, const Poses& poses);

// ------------------------------------------------------------------------------------------------
// Measures of single bricks, for colours and tables.

/// For each brick the largest distance of its bottom vertices from their targets, metres. `target`
/// has one tile per brick, vertex by vertex.
std::vector<double> brickTargetErrors(const std::vector<model::Tile>& target,
                                      const std::vector<brick::Brick>& bricks, const Poses& poses);

/// For each brick the distance of its centre of mass from its start position, metres.
std::vector<double> brickDisplacements(const Poses& start, const Poses& poses);

/// For each brick the rotation angle since its start, radians, [0, pi].
std::vector<double> brickRotations(const Poses& start, const Poses& poses);

/// For each brick the largest gap of its pivots, metres; 0 for a brick without joints.
std::vector<double> brickJointGaps(std::span<const brick::Pivot> pivots, const Poses& poses);

/// For each brick the largest moment of its hinges, absolute value, N m. 0 if it has none. See
/// endMoments().
std::vector<double> brickMoments(const brick::PairForces& forces, const Poses& poses);

/// For each brick the energy of its pair forces, joules. Each of the two bricks counts one half:
/// the sum over all bricks is the total energy.
std::vector<double> brickElasticEnergies(const brick::PairForces& forces, const Poses& poses);

}  // namespace kirireel::trajectory
