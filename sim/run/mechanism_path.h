/// A path of closed states, and what is measured on it.
#pragma once

#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/isometry.h"
#include "sim/run/dynamics.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {

/// A kinematic path: states with closed joints, each a small move away from the one before.
struct MechanismPath {
  std::vector<Poses> states;      ///< the first is the start; one pose per tile
  std::vector<double> lengths;    ///< path length up to each state, metres; see pathDistance()
  double guideLength = 0;         ///< length of the guide from start to goal, metres
  double error = 0;               ///< target error at the end, metres; 0 without a target
  bool isStuck = false;           ///< the path ended early: the bricks no longer follow the guide
  bool isCutShort = false;        ///< the budget was spent or the caller stopped
  bool endsAtOpenJoints = false;  ///< joints would open beyond the end, or are open at it
  bool isRounded = false;         ///< joints close only within the rounding of the coordinates
  std::vector<model::Symmetry> symmetries;  ///< model symmetries that all states have; a group

  /// Length of the whole path, metres.
  double length() const { return lengths.back(); }
  /// The state at a share ([0, 1]) of the length, interpolated linearly between two states.
  Poses at(double share) const;
};

/// The root mean square distance of a brick's bottom vertices from its centre of mass, metres.
double gyrationRadius(const brick::Brick& brick);

/// Distance between two states of the same bricks, metres: the root of the mean over bricks of
///   |dx|^2 + w rho^2 |dphi|^2,
/// with dx the displacement of the centre of mass, dphi the rotation in radians, rho the brick's
/// gyrationRadius() and w `turnWeight`. Path lengths use w = 1.
double pathDistance(const std::vector<brick::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight = 1);

/// Translations, and rotations as arcs at the radii of gyration, from one state to another: 6
/// numbers for each brick, metres.
Eigen::VectorXd displacement(const std::vector<brick::Brick>& bricks, const Poses& from,
                             const Poses& to);

/// The polynomial through these states, each at its own node, evaluated at `place` (Lagrange).
/// Rotations are interpolated as vectors from `origin`.
Poses polynomialAt(double place, std::span<const double> nodes, std::span<const Poses> states,
                   const Poses& origin);

/// The bricks of a scene with the metric of pathDistance() in place of their masses and inertias.
std::vector<brick::Brick> metricBricks(const scene::Scene& scene, double turnWeight = 1);

/// Loads of Dynamics::advance() for bricks that only move by their velocities: none.
void withoutForces(const Poses& poses, std::vector<brick::Load>& loads);

/// Closes the compliant joints of metricBricks() with the smallest motion, until a move is below
/// `least`, metres. Tiles that do not fit each other come as near as they can. One move is a
/// Gauss-Newton step, which leaves gaps of half the square of the rotations. Returns the work.
double settle(const std::vector<brick::Brick>& bricks, double least, Dynamics& dynamics,
              Poses& poses);

/// The length of a path up to each of its states, one or more; metres.
std::vector<double> pathLengths(const std::vector<brick::Brick>& bricks,
                                const std::vector<Poses>& states);

/// Closes joints as Dynamics::assemble() does, but keeps the bricks' common centre fixed. Near
/// singular states, rounding errors times the stiffness would otherwise shift the whole sheet.
bool closeInPlace(Poses& poses, Dynamics& dynamics);

/// Measures how much deeper bricks overlap than at `start`. It counts the pairs that these contacts
/// keep apart, or all pairs if contacts are off. The meter keeps a reference to `bricks`.
trajectory::PenetrationMeter overlapMeter(const scene::Environment& environment,
                                          const std::vector<brick::Brick>& bricks,
                                          std::span<const brick::Pivot> pivots, const Poses& start);

}  // namespace kirireel::run
