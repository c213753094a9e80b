// A primal-dual interior-point method with Mehrotra's predictor and corrector. With the slack s of
// the constraints and the multipliers l of them and u = c - l of t >= 0, a step solves
//   (H + A' W A) dy = -(H y + g - A' l) + A' W r,   W = 1 / (t / u + s / l),
// whose matrix has the band of H. It starts at y = 0, where the constraints hold with their slacks
// and violations and all products s l and t u are equal. J. Nocedal, S. J. Wright, Numerical
// Optimization, 2nd edition, 2006, chapter 16. If the minimum without constraints satisfies all of
// them, it is the solution.
// At the end the active constraints are equations: this gives the last digits (method of
// multipliers, chapter 17).
#include "sim/path/banded_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Core>

#include "sim/base/interruption.h"
#include "sim/mechanics/dense_kernels.h"

namespace kirireel::path {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxSteps = 25;
// Initial products of slacks and multipliers over those of the largest bound and gradient, and the
// smallest initial slack over the largest bound.
constexpr double kFirstProduct = 0.03;
constexpr double kFirstSlack = 1e-3;
// The price of a violated constraint, over the largest gradient.
constexpr double kPrice = 1e3;
// A step uses this fraction of the distance at which a slack or a multiplier becomes zero.
constexpr double kStepShare = 0.99;
// The weight of a constraint that is an equation, and the number of steps with it.
constexpr double kEquationWeight = 1e6;
constexpr int kRefinements = 4;

/// Residuals of a solution, as fractions of the largest gradient and bound. A gradient counts by
/// the norm of a state, which does not depend on the state's basis.
struct Tolerance {
  double complementarity, stationarity, feasibility;
};
// The iteration ends at the first. Near it, rounding can make the matrix indefinite or the
// residuals grow again: then the last solution within the second is enough. With 1e-7, 1e-5, 1e-3
// for both, paths of one sheet at two places differed by 1e-5 tile.
constexpr Tolerance kAim = {1e-10, 1e-7, 1e-6};
constexpr Tolerance kEnough = {1e-7, 1e-5, 1e-3};

MatrixXd times(const BandedMatrix& matrix, const MatrixXd& y) {
  MatrixXd product(y.rows(), y.cols());
  for (Eigen::Index i = 0; i < y.cols(); ++i) product.col(i) = matrix.diagonal[i] * y.col(i);
  const auto addBand = [&](const std::vector<MatrixXd>& band, Eigen::Index offset) {
    for (Eigen::Index i = 0; i + offset < y.cols(); ++i) {
      product.col(i + offset) += band[i] * y.col(i);
      product.col(i) += band[i].transpose() * y.col(i + offset);
    }
  };
  addBand(matrix.first, 1);
  addBand(matrix.second, 2);
  return product;
}

/// The largest step, up to 1, that keeps v + step * dv above zero.
double stepFor(const ArrayXd& v, const ArrayXd& dv) {
  double step = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (dv[i] < 0) step = std::min(step, -v[i] / dv[i]);
  }
  return std::min(1.0, kStepShare * step);
}

class InteriorPoint {
 public:
  explicit InteriorPoint(const BandedProgram& program) : program_(program) {
    for (const VectorXd& bounds : program.bounds) count_ += bounds.size();
    bounds_.resize(count_);
    Eigen::Index row = 0;
    for (const VectorXd& bounds : program.bounds) {
      bounds_.segment(row, bounds.size()) = bounds;
      row += bounds.size();
    }
  }

  BandedSolution find(MatrixXd unconstrained) {
    if (unconstrained.size() == 0 || isFeasible(unconstrained)) return {std::move(unconstrained)};
    y_ = MatrixXd::Zero(program_.gradient.rows(), program_.gradient.cols());
    weighted_ = program_.hessian;
    size_ = program_.priceScale;
    top_ = std::max(bounds_.abs().maxCoeff(), std::numeric_limits<double>::min());
    const double product = kFirstProduct * size_ * top_;
    const double price = kPrice * size_;
    slack_ = (product / price - bounds_).max(kFirstSlack * top_);
    excess_ = slack_ + bounds_;
    multiplier_ = product / slack_;
    other_ = price - multiplier_;
    computeResiduals();
    int steps = 0;
    MatrixXd solved;  // the last solution within the second tolerance
    while (steps < kMaxSteps && !isSolved(kAim)) {
      checkInterruption();
      ++steps;
      if (isSolved(kEnough)) solved = y_;
      if (!step()) return {std::move(solved), steps};
      computeResiduals();
    }
    if (isSolved(kAim)) return {refined(), steps + 1};
    const bool isLast = isSolved(kEnough) || solved.size() == 0;
    return {isLast ? y_ : std::move(solved), steps};
  }

 private:
  struct Direction {
    MatrixXd y;
    ArrayXd slack, excess, multiplier;
  };

  ArrayXd constraintsOf(const MatrixXd& y) const {
    VectorXd values(count_);
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < y.cols(); ++i) {
      const MatrixXd& rows = program_.constraints[i];
      values.segment(row, rows.rows()).noalias() = rows * y.col(i);
      row += rows.rows();
    }
    return values.array();
  }

  bool isFeasible(const MatrixXd& y) const {
    return count_ == 0 || (constraintsOf(y) - bounds_).minCoeff() >= 0;
  }

  MatrixXd transposed(const ArrayXd& values) const {
    MatrixXd sum(y_.rows(), y_.cols());
    Eigen::Index row = 0;
    for (Eigen::Index i = 0; i < y_.cols(); ++i) {
      const MatrixXd& rows = program_.constraints[i];
      sum.col(i) = rows.transpose() * values.segment(row, rows.rows()).matrix();
      row += rows.rows();
    }
    return sum;
  }

  void computeResiduals() {
    primal_ = constraintsOf(y_) - bounds_ + excess_ - slack_;
    dual_ = times(program_.hessian, y_) + program_.gradient - transposed(multiplier_);
    gap_ = ((slack_ * multiplier_).sum() + (excess_ * other_).sum()) / (2.0 * count_);
  }

  /// Whether the residuals of the current point are below a tolerance.
  bool isSolved(const Tolerance& tolerance) const {
    return gap_ < tolerance.complementarity * size_ * top_ &&
           dual_.colwise().norm().maxCoeff() < tolerance.stationarity * size_ &&
           primal_.abs().maxCoeff() < tolerance.feasibility * top_;
  }

  Direction direction(const ArrayXd& weights, const ArrayXd& toSlack,
                      const ArrayXd& toExcess) const {
    const ArrayXd right = -primal_ - toExcess / other_ + toSlack / multiplier_;
    Direction found;
    found.y = factor_.solve(transposed(weights * right) - dual_);
    found.multiplier = weights * (right - constraintsOf(found.y));
    found.slack = (toSlack - slack_ * found.multiplier) / multiplier_;
    found.excess = (toExcess + excess_ * found.multiplier) / other_;
    return found;
  }

  double stepAlong(const Direction& by) const {
    return std::min({stepFor(slack_, by.slack), stepFor(excess_, by.excess),
                     stepFor(multiplier_, by.multiplier), stepFor(other_, -by.multiplier)});
  }

  /// Factors H + A' W A. Returns whether it is positive definite.
  bool factorize(const ArrayXd& weights) {
    const VectorXd roots = weights.sqrt().matrix();
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < weighted_.diagonal.size(); ++i) {
      const MatrixXd& rows = program_.constraints[i];
      const MatrixXd weighted = roots.segment(row, rows.rows()).asDiagonal() * rows;
      weighted_.diagonal[i] = program_.hessian.diagonal[i];
      weighted_.diagonal[i].selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
      row += rows.rows();
    }
    return factor_.factorize(weighted_);
  }

  /// The solution with all digits: the active constraints are equations, by the method of
  /// multipliers. y_ if they are not known for certain.
  MatrixXd refined() {
    using Mask = Eigen::Array<bool, Eigen::Dynamic, 1>;
    const Mask isViolated = excess_ * size_ > other_ * top_;
    const Mask isActive = multiplier_ * top_ > slack_ * size_ && !isViolated;
    const double price = kPrice * size_;
    const ArrayXd weights = isActive.cast<double>() * kEquationWeight;
    if (!factorize(weights)) return y_;
    ArrayXd multiplier = isViolated.select(price, multiplier_ * isActive.cast<double>());
    MatrixXd y = y_;
    for (int k = 0; k < kRefinements; ++k) {
      const MatrixXd left = times(program_.hessian, y) + program_.gradient - transposed(multiplier);
      const ArrayXd missing = bounds_ - constraintsOf(y);
      const MatrixXd change = factor_.solve(transposed(weights * missing) - left);
      multiplier += weights * (missing - constraintsOf(change));
      y += change;
    }
    const ArrayXd missing = bounds_ - constraintsOf(y);
    const bool isSolution =
        isViolated.select(0, missing).maxCoeff() < kAim.complementarity * top_ &&
        multiplier.minCoeff() > -kAim.complementarity * size_;
    return isSolution ? y : y_;
  }

  bool step() {
    const ArrayXd weights = 1 / (excess_ / other_ + slack_ / multiplier_);
    if (!factorize(weights)) return false;
    const Direction predicted = direction(weights, -slack_ * multiplier_, -excess_ * other_);
    const double tried = stepAlong(predicted);
    const double reached =
        (((slack_ + tried * predicted.slack) * (multiplier_ + tried * predicted.multiplier)).sum() +
         ((excess_ + tried * predicted.excess) * (other_ - tried * predicted.multiplier)).sum()) /
        (2.0 * count_);
    const double aim = gap_ * std::pow(reached / gap_, 3);
    const Direction corrected =
        direction(weights, aim - slack_ * multiplier_ - predicted.slack * predicted.multiplier,
                  aim - excess_ * other_ + predicted.excess * predicted.multiplier);
    const double step = stepAlong(corrected);
    y_ += step * corrected.y;
    slack_ += step * corrected.slack;
    excess_ += step * corrected.excess;
    multiplier_ += step * corrected.multiplier;
    other_ -= step * corrected.multiplier;
    return true;
  }

  const BandedProgram& program_;
  Eigen::Index count_ = 0;  // constraints of all states
  ArrayXd bounds_;
  double size_ = 0, top_ = 0;  // the scale of the gradient, and the largest bound
  MatrixXd y_;
  ArrayXd slack_, excess_;      // s, t
  ArrayXd multiplier_, other_;  // l, u
  ArrayXd primal_;
  MatrixXd dual_;
  BandedMatrix weighted_;  // H + A' W A
  BandedCholesky factor_;  // of this matrix
  double gap_ = 0;         // mean product of a slack and its multiplier
};

}  // namespace

// A state's front has its own columns and the rows of the next two states, to which it passes its
// update (J. W. H. Liu, The multifrontal method for sparse matrix solution, SIAM Review, 1992).
bool BandedCholesky::factorize(const BandedMatrix& matrix) {
  using Block = Eigen::Map<MatrixXd, 0, Eigen::OuterStride<>>;
  const auto blockOf = [](VectorXd& numbers, int rows, int columns) {
    return Block(numbers.data(), rows, columns, Eigen::OuterStride<>(mechanics::paddedRows(rows)));
  };
  const auto clear = [](VectorXd& numbers, int rows, int columns) {
    numbers.setZero(mechanics::paddedRows(rows) * columns + mechanics::kRowsTogether);
  };
  size_ = static_cast<int>(matrix.diagonal.front().rows());
  width_ = (size_ + 2) / 3 * 3;
  panels_.resize(matrix.diagonal.size());
  clear(update_, rows(0), rows(0));
  for (int i = 0; i < count(); ++i) {
    const int behind = rows(i) - width_;
    const int known = std::min(rows(i), 2 * width_);  // rows of the update
    clear(panels_[i], rows(i), width_);
    auto panel = blockOf(panels_[i], rows(i), width_);
    panel.topRows(known) = blockOf(update_, known, known).leftCols(width_);
    panel.topLeftCorner(size_, size_) += matrix.diagonal[i];
    panel.diagonal().tail(width_ - size_).setOnes();
    if (behind >= width_) panel.block(width_, 0, size_, size_) += matrix.first[i];
    if (behind > width_) panel.block(2 * width_, 0, size_, size_) += matrix.second[i];
    clear(nextUpdate_, behind, behind);
    if (behind >= width_) {
      blockOf(nextUpdate_, behind, behind).topLeftCorner(width_, width_) =
          blockOf(update_, known, known).bottomRightCorner(width_, width_);
    }
    double* const panelNumbers = panels_[i].data();
    if (!mechanics::denseKernels().eliminate(panelNumbers, rows(i), width_, nextUpdate_.data())) {
      return false;
    }
    std::swap(update_, nextUpdate_);
  }
  return true;
}

MatrixXd BandedCholesky::solve(const MatrixXd& right) const {
  const mechanics::DenseKernels& kernels = mechanics::denseKernels();
  VectorXd x = VectorXd::Zero(width_ * count());
  Eigen::Map<MatrixXd> columns(x.data(), width_, count());
  columns.topRows(size_) = right;
  VectorXd front(3 * width_ + 2 * mechanics::kRowsTogether);
  const auto solvePart = [&](int i, const auto& kernel) {
    front.setZero();
    front.head(rows(i)) = x.segment(i * width_, rows(i));
    kernel(panels_[i].data(), rows(i), width_, front.data());
    x.segment(i * width_, rows(i)) = front.head(rows(i));
  };
  for (int i = 0; i < count(); ++i) solvePart(i, kernels.solveForward);
  for (int i = count(); i-- > 0;) solvePart(i, kernels.solveBackward);
  return columns.topRows(size_);
}

MatrixXd unconstrainedMinimum(const BandedProgram& program) {
  BandedCholesky factor;
  return factor.factorize(program.hessian) ? factor.solve(-program.gradient) : MatrixXd();
}

BandedSolution solve(const BandedProgram& program, MatrixXd unconstrained) {
  return InteriorPoint(program).find(std::move(unconstrained));
}

}  // namespace kirireel::path
