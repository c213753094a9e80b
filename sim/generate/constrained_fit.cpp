#include "sim/generate/constrained_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>

namespace kirireel {
namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::SparseMatrix<double>;

constexpr double kLeastDamping = 1e-9;
// A step below this is rounding for sheets whose tiles are about 1 in size.
constexpr double kSmallStep = 1e-10;
constexpr double kLeastViolation = 1e-13;

DesignEquations equationsAt(const DesignSource& source, const Vector& unknowns) {
  DesignEquations equations;
  source(unknowns, equations);
  return equations;
}

double largest(const Vector& values) {
  return values.size() == 0 ? 0 : values.lpNorm<Eigen::Infinity>();
}

/// Solves [H J^T; J -epsilon] [step; multipliers] = -[gradient; values], where H is positive
/// definite: the pattern is analysed once.
class QuasiDefiniteSystem {
 public:
  struct Solution {
    Vector step;
    Vector multipliers;
  };

  Solution solve(const Matrix& curvature, const Matrix& slopes, double epsilon,
                 const Vector& gradient, const Vector& values) {
    const Eigen::Index unknowns = gradient.size();
    const Matrix system = assemble(curvature, slopes, epsilon);
    Vector right(unknowns + values.size());
    right << -gradient, -values;
    if (!analysed_) factors_.analyzePattern(system);
    analysed_ = true;
    factors_.factorize(system);
    Vector both = factors_.solve(right);
    // Two rounds of refinement return the digits that factors without pivots lose.
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
    return 0.5 * equations.wanted.values().squaredNorm() +
           penalty_ * equations.exact.values().lpNorm<1>();
  }

  void advance() {
    const DesignEquations equations = equationsAt(source_, unknowns_);
    const int size = static_cast<int>(unknowns_.size());
    const Matrix wanted = equations.wanted.slopes(size);
    const Matrix curvature = Matrix(wanted.transpose() * wanted) + identity(size, damping_);
    const auto solution =
        system_.solve(curvature, equations.exact.slopes(size), 1e-9,
                      wanted.transpose() * equations.wanted.values(), equations.exact.values());
    penalty_ = std::max(penalty_, 2 * largest(solution.multipliers));
    if (search(solution.step)) {
      damping_ = std::max(kLeastDamping, 0.3 * damping_);
      done_ = largest(solution.step) < kSmallStep;
    } else {
      damping_ *= 10;
      done_ = damping_ > 1e12;
    }
  }

  /// Moves by the step or a half, a quarter, ... of it; false when none of them helps.
  bool search(const Vector& step) {
    const double before = merit(unknowns_);
    double share = 1;
    for (int halving = 0; halving < 12; ++halving, share *= 0.5) {
      const Vector moved = unknowns_ + share * step;
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
  for (int round = 0; round < 10; ++round) {
    const DesignEquations equations = equationsAt(source, fit.unknowns);
    fit.violation = largest(equations.exact.values());
    if (!(fit.violation > kLeastViolation)) break;
    fit.unknowns += system
                        .solve(identity(size, 1), equations.exact.slopes(size), 1e-12,
                               Vector::Zero(size), equations.exact.values())
                        .step;
  }
  fit.violation = largest(equationsAt(source, fit.unknowns).exact.values());
  return fit;
}

}  // namespace kirireel
