/// The quadratic program that both halves of a step are: finding velocities, and closing joints.
#pragma once

#include <vector>

#include "sim/joints/contact_rows.h"
#include "sim/joints/step_system.h"

namespace kirireel {

/// Minimise 1/2 x^T A x - f^T x over velocities x with J x = 0, and with the contact rows'
/// inequalities and friction.
template <int D>
struct StepProgram {
  Eigen::VectorXd x;            ///< the start of the search, then its end
  Eigen::VectorXd force;        ///< f
  Eigen::VectorXd multipliers;  ///< of the joint rows
  bool exactJoints = true;      ///< or springs, whose multipliers do not move
  std::vector<ContactRow<D>> contacts;
};

/// How far a round of the method of multipliers was from the end.
struct RoundReport {
  bool found = false;        ///< whether the minimum for the multipliers at hand was found
  double change = 0;         ///< of x in the last Newton step, m/s
  double contactChange = 0;  ///< by how much contact rows still were off, m/s
  double jointSpeed = 0;     ///< the largest component of J x, m/s; not of joints that are springs
};

/// One round: minimises the augmented Lagrangian for the multipliers at hand by semismooth Newton
/// (the contacts' states decide which quadratic piece is in force), then moves the multipliers. The
/// system must be factored for the contacts' states on entry. `slow` is a speed to which tolerances
/// refer besides that of x.
template <int D>
/// Costs one solve for a round without contacts; each change of the contacts' states costs a
/// factorisation.
RoundReport solveRound(StepSystem<D>& system, StepProgram<D>& program, double slow);

/// Sets how the contacts slip at x. Returns whether any state changed.
template <int D>
bool setSlipStates(StepProgram<D>& program, double rho);

}  // namespace kirireel
