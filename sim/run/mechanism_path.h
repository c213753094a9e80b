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
  bool endsAtOpenJoints = false;  ///< the next states open joints by more than rounding explains
  bool isRounded = false;         ///< joints close only within the rounding of the coordinates
  std::vector<model::Symmetry> symmetries;  ///< model symmetries that all states have; a group

  /// Length of the whole path, metres.
  double length() const { return lengths.back(); }
};

/// The root mean square distance of a brick's bottom vertices from its centre of mass, metres.
double gyrationRadius(const brick::Brick& brick);

/// Distance between two states of the same bricks, metres: the root of the mean over bricks of
///   |dx|^2 + w rho^2 |dphi|^2,
/// with dx the displacement of the centre of mass, dphi the rotation in radians, rho the brick's
/// gyrationRadius() and w `turnWeight`. Path lengths use w = 1.
double pathDistance(const std::vector<brick::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight = 1);

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
