/// What a run measures over its time: the curves that papers plot.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"
#include "sim/model/hinge.h"
#include "sim/model/model.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::trajectory {

/// One quantity by time.
struct Curve {
  std::string name;            ///< one short phrase, such as "width"
  std::string column;          ///< in tables, with its unit, such as "width_m"
  std::vector<double> values;  ///< one a sample; NaN where it does not exist

  /// Whether any is a number.
  bool hasValues() const;
};

/// Curves of one unit that are in one diagram.
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
  ///     Area              hull: within the convex outline seen along the normal of a sheet that
  ///                       starts flat, else along z; covered: by tiles that lie flat; m^2
  ///     Hull perimeter    of that outline, m
  ///     Porosity          1 - covered / hull
  ///     Poisson's ratio   since the start, see poissonsRatio()
  ///     Opening           of the joints, see openingAngles(): least, mean, largest; degrees
  ///     Energy            kinetic, stored in springs and compliant joints, and at hinges, J;
  ///                       like all that follow down to the forces, only of runs with dynamics by
  ///                       the direct solver
  ///     Work of the drives    put in so far, J; see Energies, as the next
  ///     Lost energy       taken so far by dampers, by contacts and by the integrator, J
  ///     Joint force       mean and largest, and the largest of those that are indeterminate, N
  ///     Force on held tiles   the largest of a pin, of a grip and of a contact, N
  ///     Target error      largest, as samples have it, and mean of the vertices, m
  ///     Joint gap, Overlap    as samples have them, m
  ///     Radius            largest distance of a vertex from the mean of all, m
  std::vector<CurveGroup> groups;
  /// For each joint its opening in degrees, the size of its force in newtons and whether that is
  /// indeterminate (1): opening_J_deg, joint_force_J_N, joint_force_J_indeterminate; J counts as
  /// the model's files do.
  std::vector<Curve> joints;
};

/// What is said of a run without energies and forces.
inline constexpr const char* kNoMechanics =
    "the run has no energies and forces: a path of the mechanism is geometry, and engines do not "
    "tell theirs; one recorded with `path = dynamic` has both";

/// Measures from the poses of samples what trajectory.h5 does not have already: the channels width
/// to opening_largest of the list above, and each joint's opening as rows. The subject must outlive
/// the meter.
std::unique_ptr<SampleMeter> makeCurveMeter(const Subject& subject);

/// Measures all samples of a run. Throws InputError as the reader does.
RunCurves curvesOf(const TrajectoryReader& run);

/// The same curves but those of each joint at other times, rising, straight between the samples;
/// NaN where either side is.
RunCurves curvesAt(const RunCurves& curves, const std::vector<double>& times);

// ------------------------------------------------------------------------------------------------
// What a sheet measures as a whole in one state: sizes, areas, openings.

/// Sides of the box around all vertices, along x, y and z, metres.
Vector3 boxSides(const std::vector<model::Tile>& tiles);

/// The convex outline of all vertices seen along z.
struct HullSize {
  double area = 0;       ///< square metres
  double perimeter = 0;  ///< metres
};

/// Of one or more tiles.
/// O(n log n) in the vertices. A sheet that is seen from its edge has the area 0.
HullSize hullSize(const std::vector<model::Tile>& tiles);

/// The area that tiles cover, square metres, if all of them lie in one horizontal plane (to 1e-6 of
/// the box); none in space, where they hide each other. What several tiles cover counts once.
std::optional<double> coveredArea(const std::vector<model::Tile>& tiles);

/// Poisson's ratio from one state to another, of logarithmic (Hencky) strains of the box's sides:
///   -log(y / y0) / log(x / x0),
/// which is -1 for rotating squares at any opening. Absent if x hardly changes, by less than 1e-3
/// of itself, since rounding would decide.
std::optional<double> poissonsRatio(const Vector3& sidesBefore, const Vector3& sides);

/// For each joint the angle by which its tiles are turned against each other since the start, when
/// all rotations are identities: how far it is open. Radians, 0 to pi.
/// `poses` has one pose a tile. In the order of the joints; links and fixed joints count too.
std::vector<double> openingAngles(const std::vector<model::Joint>& joints, const Poses& poses);

// ------------------------------------------------------------------------------------------------
// Measures of each brick by itself, for colours and tables.

/// For each brick the largest distance of its bottom vertices from their targets, metres.
/// `target` has one tile a brick, vertex by vertex.
std::vector<double> brickTargetErrors(const std::vector<model::Tile>& target,
                                      const std::vector<model::Brick>& bricks, const Poses& poses);

/// For each brick the distance of its centre of mass from where it started, metres.
std::vector<double> brickDisplacements(const Poses& start, const Poses& poses);

/// For each brick the angle by which it is turned from its start, radians, 0 to pi.
std::vector<double> brickRotations(const Poses& start, const Poses& poses);

/// For each brick the largest gap of its pivots, metres; 0 for a brick without joints.
std::vector<double> brickJointGaps(std::span<const model::Pivot> pivots, const Poses& poses);

/// For each brick the largest moment on it of what joins it at its hinges, in size, N m; 0 without
/// any. See endMoments().
std::vector<double> brickMoments(const model::PairForces& forces, const Poses& poses);

/// For each brick what forces between it and others store, joules: each of their two bricks counts
/// one half: the sum over the bricks is what all forces store.
std::vector<double> brickElasticEnergies(const model::PairForces& forces, const Poses& poses);

}  // namespace kirireel::trajectory
