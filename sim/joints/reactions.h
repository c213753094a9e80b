/// The forces that joints and pins carry in one state.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"

namespace kirireel {

/// What holds the bricks of one state, beside what is applied to them. World axes.
struct Reactions {
  /// One a pivot: on its brick A, newtons; brick B gets the opposite. Of the upper pivot of a
  /// planar scene zero: both faces' pivots are one there.
  std::vector<Vector3> pivotForces;
  /// One a brick: the force (N) and the torque about its centre of mass (N m) of what pins it; zero
  /// where nothing does.
  std::vector<Vector6> pinForces;
  /// The largest force that is left unbalanced on any brick, newtons: rounding.
  double imbalance = 0;
};

/// Finds the forces in a state by a solve of its own: see reactions.cpp for the equations.
class ReactionSolver {
 public:
  virtual ~ReactionSolver() = default;

  /// The forces in a state of motion under what is applied to each brick, force and torque about
  /// its centre of mass, contacts included. Where joints are redundant there are many that keep the
  /// balance; these have the least sum of squares, which is what equally stiff joints carry in the
  /// limit. `pinned`: one entry a brick. `jointStiffness` in N/m makes joints springs, whose forces
  /// follow from their gaps; infinity makes them exact.
  virtual Reactions solve(const Motion& motion, std::span<const Vector6> applied,
                          const std::vector<bool>& pinned, double jointStiffness) = 0;

  /// For each of so many joints, whether its force (the sum over its pivots) is indeterminate in
  /// the state of the last solve(), which had exact joints: whether some forces of joints alone are
  /// in balance (a state of self-stress) in which it is not zero. Then only least-norm forces are
  /// known, and others keep the balance as well.
  virtual std::vector<bool> indeterminateJoints(std::size_t joints) = 0;
};

/// A solver for these bricks and pivots, which must outlive it. `planar` and `lengthScale` as in
/// JointSolverSettings.
std::unique_ptr<ReactionSolver> makeReactionSolver(const std::vector<Brick>& bricks,
                                                   std::span<const Pivot> pivots, bool planar,
                                                   double lengthScale);

}  // namespace kirireel
