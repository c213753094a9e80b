// The method of multipliers for
//   min 1/2 x^T A x - f^T x   with   J x = 0,   c_i x >= b_i,   |t_i x| bounded by friction.
// With multipliers l of the joints, p of the contacts and s of their slip, a round minimises
//   1/2 x^T A x - f^T x - l^T J x + kappa/2 |J x|^2
//     + sum_i max(0, p_i - rho (c_i x - b_i))^2 / (2 rho) + the same of the slip, cut to its bound,
// which is convex and quadratic in pieces: which contacts push, and which slip, says which piece.
// Newton's method on it is exact within a piece, so that a whole step is taken at first, and a line
// search only where whole steps run in circles (semismooth Newton). Then the multipliers move to
//   l - kappa J x,   p = max(0, p - rho (c x - b)),   s likewise,
// and the next round begins. With kappa and rho large against A a round gains ten digits or so.
// Rockafellar, "Augmented Lagrange multiplier functions and duality in nonconvex programming",
// 1974; Qi and Sun, "A nonsmooth version of Newton's method", 1993.
#include "sim/joints/step_program.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

constexpr double kNewtonTolerance = 1e-7;  // of a Newton step; rounding is 1e-10 to 1e-8
constexpr int kNewtonRounds = 60;
constexpr int kBoldRounds = 8;  // whole steps at first: most often they settle the contacts' states
constexpr int kSearchRounds = 30;

/// Derivative of the augmented Lagrangian at x, apart from the contacts' normals.
template <int D>
Eigen::VectorXd smoothGradient(const StepSystem<D>& system, const StepProgram<D>& program,
                               const Eigen::VectorXd& x) {
  Eigen::VectorXd result = system.timesA(x) - program.force;
  const Eigen::VectorXd impulse = program.multipliers - system.kappa() * system.jointVelocity(x);
  system.addJointImpulse(-1.0, impulse, result);
  for (const ContactRow<D>& row : program.contacts) {
    if (row.rubs()) row.addTangent(-row.trialSlipImpulse(x, system.rho(), nullptr), result);
  }
  return result;
}

/// Derivative of the augmented Lagrangian at x.
template <int D>
Eigen::VectorXd gradient(const StepSystem<D>& system, const StepProgram<D>& program,
                         const Eigen::VectorXd& x) {
  Eigen::VectorXd result = smoothGradient(system, program, x);
  for (const ContactRow<D>& row : program.contacts) {
    const double normal = row.trialImpulse(x, system.rho());
    if (normal > 0) row.addNormal(-normal, result);
  }
  return result;
}

/// The same of the quadratic piece in which the contacts are in the states that they have: where x
/// is on another piece, a whole step from it still leads to this one's minimum.
template <int D>
Eigen::VectorXd gradientOfPiece(const StepSystem<D>& system, const StepProgram<D>& program) {
  Eigen::VectorXd result = smoothGradient(system, program, program.x);
  for (const ContactRow<D>& row : program.contacts) {
    if (row.active) row.addNormal(-row.pushingImpulse(program.x, system.rho()), result);
  }
  return result;
}

/// A step length at which the convex function no longer falls steeply along dx: the whole step, or
/// near where its slope changes sign.
template <int D>
double lineSearch(const StepSystem<D>& system, const StepProgram<D>& program,
                  const Eigen::VectorXd& dx, double firstSlope) {
  double low = 0;
  double high = 1;
  double length = 1;
  for (int round = 0; round < kSearchRounds; ++round) {
    const double slope = gradient<D>(system, program, program.x + length * dx).dot(dx);
    const bool uphill = slope > -0.1 * firstSlope;
    if (!uphill && (length == 1.0 || slope >= 0.5 * firstSlope)) return length;
    (uphill ? high : low) = length;
    length = 0.5 * (low + high);
  }
  return length;
}

/// Sets which contacts push and how they slip at x. Returns whether any state changed.
template <int D>
bool setContactStates(StepProgram<D>& program, double rho) {
  bool changed = setSlipStates(program, rho);
  for (ContactRow<D>& row : program.contacts) {
    const bool active = row.trialImpulse(program.x, rho) > 0;
    changed = changed || active != row.active;
    row.active = active;
  }
  return changed;
}

template <int D>
// Newton's method on the pieces: whole steps at first, then with a line search.
RoundReport minimize(StepSystem<D>& system, StepProgram<D>& program, double slow) {
  for (int round = 0; round < kNewtonRounds; ++round) {
    const Eigen::VectorXd slope = gradientOfPiece(system, program);
    Eigen::VectorXd dx = -slope;
    system.solveInPlace(dx);
    // Close to the minimum the slope along dx is lost in rounding, and a whole step is right.
    const double speed = std::max(system.largestSpeed(program.x), slow);
    const double change = system.largestSpeed(dx);
    const bool smooth = program.contacts.empty() || change <= kNewtonTolerance * speed;
    const bool bold = smooth || round < kBoldRounds;
    const double length = bold ? 1.0 : lineSearch(system, program, dx, slope.dot(dx));
    program.x += length * dx;
    if (smooth) return {true, change, 0};
    // While no contact changes state the function is quadratic and a whole step is its minimum.
    const bool changed = setContactStates(program, system.rho());
    if (!changed && length == 1.0) return {true, change, 0};
    if (changed && !system.factor(program.contacts)) break;
  }
  return {};
}

}  // namespace

template <int D>
bool setSlipStates(StepProgram<D>& program, double rho) {
  bool changed = false;
  for (ContactRow<D>& row : program.contacts) {
    if (!row.rubs()) continue;
    typename ContactRow<D>::TangentMatrix stiffness;
    row.trialSlipImpulse(program.x, rho, &stiffness);
    changed = changed || stiffness != row.slipStiffness;
    row.slipStiffness = stiffness;
  }
  return changed;
}

template <int D>
RoundReport solveRound(StepSystem<D>& system, StepProgram<D>& program, double slow) {
  RoundReport report = minimize(system, program, slow);
  if (!report.found) return report;
  if (program.exactJoints && system.hasJoints()) {
    const Eigen::VectorXd speeds = system.jointVelocity(program.x);
    program.multipliers -= system.kappa() * speeds;
    report.jointSpeed = speeds.template lpNorm<Eigen::Infinity>();
  }
  double& change = report.contactChange;
  for (ContactRow<D>& row : program.contacts) {
    const double normal = row.trialImpulse(program.x, system.rho());
    change = std::max(change, std::abs(normal - row.multiplier) / system.rho());
    row.multiplier = normal;
    if (!row.rubs()) continue;
    const auto slip = row.trialSlipImpulse(program.x, system.rho(), nullptr);
    change = std::max(change, (slip - row.slipMultiplier).norm() / system.rho());
    row.slipMultiplier = slip;
  }
  return report;
}

template bool setSlipStates<3>(StepProgram<3>&, double);
template bool setSlipStates<6>(StepProgram<6>&, double);
template RoundReport solveRound<3>(StepSystem<3>&, StepProgram<3>&, double);
template RoundReport solveRound<6>(StepSystem<6>&, StepProgram<6>&, double);

}  // namespace kirireel
