// Minimises |w(x)|^2 / 2 subject to e(x) = 0, with the unknowns x, the soft equations w and the
// exact equations e.
//
// Each round solves one symmetric system for a step d and the multipliers y,
//   [ W^T W + m I   E^T  ] [ d ]       [ W^T w ]
//   [      E       -eps I ] [ y ]  =  - [   e   ]
// with the slopes W and E of w and e, the damping m and eps = 1e-9. The diagonal blocks are
// definite with opposite signs, so the matrix is quasi-definite: it has a factorisation L D L^T
// for any order of its rows. A sparse Cholesky factorisation without pivoting is enough (R. J.
// Vanderbei, Symmetric quasidefinite matrices, SIAM J. Optimization 5, 1995). Exact equations may
// be redundant, as those of closed voids are. eps keeps the lower block definite. Two rounds of
// iterative refinement remove most of its error.
//
// The step is halved until the merit |w|^2 / 2 + rho |e|_1 decreases. The penalty is exact if rho
// is at least the largest multiplier. The fit uses twice that. An accepted step multiplies the
// damping by 0.3, a rejected one by 10 (rule of Levenberg and Marquardt). Gauss-Newton ignores the
// second derivatives of w and e, so convergence is linear near the end. This does not matter, since
// a design may stop anywhere on e = 0. Finally, Newton steps of least length d = -E^T (E E^T)^-1 e
// reduce e to rounding. They use the same system with W = 0 and m = 1, converge quadratically and
// move the design by about the remaining violation.
//
// J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition, chapters 10 and 18.
#include "sim/generate/constrained_fit.h"

#include <algorithm>

#include <Eigen/SparseCholesky>

namespace kirireel::generate {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

// Less damping would not change a step. Some is needed, since W^T W may be singular.
constexpr double kMinDamping = 1e-9;
// Smaller steps are rounding, for tiles of size about 1.
constexpr double kSmallStep = 1e-10;
constexpr double kMinViolation = 1e-13;

DesignEquations equationsAt(const DesignSource& source, const Vector& unknowns) {
  DesignEquations equations;
  source(unknowns, equations);
  return equations;
}

double largest(const Vector& values) {
  return values.size() == 0 ? 0 : values.lpNorm<Eigen::Infinity>();
}

/// Solves [H J^T; J -epsilon] [step; multipliers] = -[gradient; values] for positive definite H.
/// Analyses the pattern of zeros once.
class QuasiDefiniteSystem {
 public:
  struct Solution {
    Vector step;
    Vector multipliers;
  };

  // `curvature` is H; the right side is minus the gradient and minus the exact equations' values.
  Solution solve(const Matrix& curvature, const Matrix& slopes, double epsilon,
                 const Vector& gradient, const Vector& values) {
    const Eigen::Index unknowns = gradient.size();
    const Matrix system = assemble(curvature, slopes, epsilon);
    Vector right(unknowns + values.size());
    right << -gradient, -values;
    // The source writes the same equations at every call, so the pattern of zeros does not change.
    if (!analysed_) factors_.analyzePattern(system);
    analysed_ = true;
    factors_.factorize(system);
    Vector both = factors_.solve(right);
    // Two rounds of refinement restore the digits lost without pivoting.
    for (int round = 0; round < 2; ++round) {
      both += factors_.solve(right - system.selfadjointView<Eigen::Lower>() * both);
    }
    return {both.head(unknowns), both.tail(values.size())};
  }

 private:
  /// The lower triangle.
  static Matrix assemble(const Matrix& curvature, const Matrix& slopes, double epsilon) {
    const Eigen::Index unknowns = curvature.rows();
    std::vector<Eigen::Triplet<double>> entries;
    const auto append = [&entries](const Matrix& matrix, Eigen::Index firstRow) {
      for (Eigen::Index column = 0; column < matrix.outerSize(); ++column) {
        for (Matrix::InnerIterator entry(matrix, column); entry; ++entry) {
          const Eigen::Index row = firstRow + entry.row();
          // The matrix is symmetric, so the lower triangle is enough.
          if (row >= column) entries.emplace_back(row, column, entry.value());
        }
      }
    };
    append(curvature, 0);
    append(slopes, unknowns);
    const Eigen::Index size = unknowns + slopes.rows();
    for (Eigen::Index k = unknowns; k < size; ++k) entries.emplace_back(k, k, -epsilon);
    Matrix system(size, size);
    system.setFromTriplets(entries.begin(), entries.end());
    return system;
  }

  Eigen::SimplicialLDLT<Matrix, Eigen::Lower> factors_;
  bool analysed_ = false;
};

Matrix identity(Eigen::Index size, double scale) {
  Matrix matrix(size, size);
  matrix.setIdentity();
  return matrix * scale;
}

/// The damped Gauss-Newton rounds.
class Descent {
 public:
  Descent(const DesignSource& source, Vector start, const FitSettings& settings)
      : source_(source), unknowns_(std::move(start)), damping_(settings.damping) {
    for (int round = 0; round < settings.rounds && !done_; ++round) advance();
  }

  const Vector& unknowns() const { return unknowns_; }

 private:
  double merit(const Vector& unknowns) const {
    const DesignEquations equations = equationsAt(source_, unknowns);
    // A sum of absolute values, since with squares a finite penalty would not give the minimum of
    // the constrained problem.
    return 0.5 * equations.desired.values().squaredNorm() +
           penalty_ * equations.exact.values().lpNorm<1>();
  }

  // One round: a step, the line search, the damping of the next.
  void advance() {
    const DesignEquations equations = equationsAt(source_, unknowns_);
    const int size = static_cast<int>(unknowns_.size());
    const Matrix desired = equations.desired.slopes(size);
    const Matrix curvature = Matrix(desired.transpose() * desired) + identity(size, damping_);
    const auto solution =
        system_.solve(curvature, equations.exact.slopes(size), 1e-9,
                      desired.transpose() * equations.desired.values(), equations.exact.values());
    // The penalty never decreases, which keeps merits of different rounds comparable.
    penalty_ = std::max(penalty_, 2 * largest(solution.multipliers));
    if (search(solution.step)) {
      damping_ = std::max(kMinDamping, 0.3 * damping_);
      done_ = largest(solution.step) < kSmallStep;
    } else {
      damping_ *= 10;
      // The steps are too short to change anything.
      done_ = damping_ > 1e12;
    }
  }

  /// Moves by the step or a half, a quarter, ... of it. False if no move lowers the merit.
  bool search(const Vector& step) {
    const double before = merit(unknowns_);
    double share = 1;
    for (int halving = 0; halving < 12; ++halving, share *= 0.5) {
      const Vector moved = unknowns_ + share * step;
      // A merit of NaN counts as worse.
      if (!(merit(moved) < before)) continue;
      unknowns_ = moved;
      return true;
    }
    return false;
  }

  const DesignSource& source_;
  Vector unknowns_;
  double damping_;
  double penalty_ = 1;
  bool done_ = false;
  QuasiDefiniteSystem system_;
};

}  // namespace

Eigen::VectorXd EquationRows::values() const {
  return Eigen::Map<const Eigen::VectorXd>(values_.data(), std::ssize(values_));
}

Eigen::SparseMatrix<double> EquationRows::slopes(int unknowns) const {
  Eigen::SparseMatrix<double> matrix(std::ssize(values_), unknowns);
  matrix.setFromTriplets(slopes_.begin(), slopes_.end());
  return matrix;
}

Fit fitDesign(const DesignSource& source, Eigen::VectorXd start, const FitSettings& settings) {
  Fit fit;
  fit.unknowns = Descent(source, std::move(start), settings).unknowns();
  QuasiDefiniteSystem system;
  const int size = static_cast<int>(fit.unknowns.size());
  // Newton's method doubles the number of digits in each round. Ten rounds are more than enough
  // near a solution.
  for (int round = 0; round < 10; ++round) {
    const DesignEquations equations = equationsAt(source, fit.unknowns);
    fit.violation = largest(equations.exact.values());
    if (!(fit.violation > kMinViolation)) break;
    fit.unknowns += system
                        .solve(identity(size, 1), equations.exact.slopes(size), 1e-12,
                               Vector::Zero(size), equations.exact.values())
                        .step;
  }
  fit.violation = largest(equationsAt(source, fit.unknowns).exact.values());
  return fit;
}

}  // namespace kirireel::generate
