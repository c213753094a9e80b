/// Least squares with exact constraints: the solver for all designed sheets.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace kirireel::generate {

/// Largest allowed residual of an exact equation. Largest seen: 2e-14.
inline constexpr double kExactFit = 1e-11;

/// Values of equations (zero if they hold) and their derivatives, at one point.
class EquationRows {
 public:
  /// Begins the next equation.
  void begin(double value) { values_.push_back(value); }
  /// Adds to the slope of the last equation along one unknown, numbered from 0.
  void slope(int unknown, double value) {
    slopes_.emplace_back(static_cast<int>(values_.size()) - 1, unknown, value);
  }

  /// One entry per equation.
  Eigen::VectorXd values() const;
  /// (equations x unknowns).
  Eigen::SparseMatrix<double> slopes(int unknowns) const;

 private:
  std::vector<double> values_;
  std::vector<Eigen::Triplet<double>> slopes_;
};

/// The equations of a design.
struct DesignEquations {
  EquationRows desired;  ///< soft: minimised as a sum of squares
  EquationRows exact;    ///< hard: hold to rounding; may be redundant
};

/// Writes the equations at the given unknowns. Every call writes the same equations, with slopes
/// along the same unknowns.
using DesignSource = std::function<void(const Eigen::VectorXd& unknowns, DesignEquations&)>;

/// Settings of a fit.
struct FitSettings {
  double damping = 1e-3;  ///< of the first round's step, positive
  int rounds = 200;       ///< at most
};

/// Result of a fit.
struct Fit {
  Eigen::VectorXd unknowns;  ///< at the end of the fit
  double violation = 0;      ///< the largest exact equation's value
};

/// Minimises |desired|^2 / 2 subject to exact = 0 from the given start. Uses damped Gauss-Newton
/// steps with a line search on |desired|^2 / 2 + rho |exact|_1 (Nocedal and Wright, Numerical
/// Optimization, chapter 18). Each step solves one quasi-definite system, which needs no pivots and
/// accepts redundant equations. At the end, Newton steps of least length fulfil the exact
/// equations. Does not throw: `violation` shows a failed fit. A round costs one sparse
/// factorisation and up to twelve evaluations of the equations.
Fit fitDesign(const DesignSource& source, Eigen::VectorXd start, const FitSettings& settings);

}  // namespace kirireel::generate
