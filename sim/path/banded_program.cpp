// A primal-dual interior-point method with Mehrotra's predictor and corrector. With the slack s of
// the constraints and the multipliers l of them and u = c - l of t >= 0, a step solves
//   (H + A' W A) dy = -(H y + g - A' l) + A' W r,   W = 1 / (t / u + s / l),
// whose matrix has the band of H. J. Nocedal, S. J. Wright, Numerical Optimization, 2nd edition,
// 2006, chapter 16. If the minimum without constraints satisfies all of them, it is the solution.
#include "sim/path/banded_program.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Cholesky>

#include "sim/base/interruption.h"

namespace kirireel::path {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMaxSteps = 25;
// Initial slacks over the largest bound; initial multipliers over the largest gradient.
constexpr double kFirst = 1e-2;
// The price of a violated constraint, over the largest gradient.
constexpr double kPrice = 1e3;
// A step uses this fraction of the distance at which a slack or a multiplier becomes zero.
constexpr double kStepShare = 0.99;

/// Residuals of a solution, as fractions of the largest gradient and bound.
struct Tolerance {
  double complementarity, stationarity, feasibility;
};
// The iteration ends at the first. Near it rounding can make the matrix indefinite: then the second
// is enough. With 1e-7, 1e-5, 1e-3 for both, paths of one sheet at two places differed by 1e-5
// tile.
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

  BandedSolution find() {
    y_ = MatrixXd::Zero(program_.gradient.rows(), program_.gradient.cols());
    MatrixXd free = unconstrained();
    if (free.size() == 0 || isFeasible(free)) return {std::move(free), 1};
    size_ = program_.priceScale;
    top_ = std::max(bounds_.abs().maxCoeff(), std::numeric_limits<double>::min());
    slack_ = (-bounds_).max(kFirst * top_);
    excess_ = ArrayXd::Constant(count_, kFirst * top_);
    multiplier_ = ArrayXd::Constant(count_, kFirst * size_);
    other_ = kPrice * size_ - multiplier_;
    computeResiduals();
    int steps = 1;
    while (steps < kMaxSteps && !isSolved(kAim)) {
      checkInterruption();
      ++steps;
      if (!step()) return {isSolved(kEnough) ? y_ : MatrixXd(), steps};
      computeResiduals();
    }
    return {y_, steps};
  }

 private:
  struct Direction {
    MatrixXd y;
    ArrayXd slack, excess, multiplier;
  };

  MatrixXd unconstrained() const {
    const BandedCholesky factor(program_.hessian);
    return factor.isDefinite() ? factor.solve(-program_.gradient) : MatrixXd();
  }

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
           dual_.cwiseAbs().maxCoeff() < tolerance.stationarity * size_ &&
           primal_.abs().maxCoeff() < tolerance.feasibility * top_;
  }

  Direction direction(const BandedCholesky& factor, const ArrayXd& weights, const ArrayXd& toSlack,
                      const ArrayXd& toExcess) const {
    const ArrayXd right = -primal_ - toExcess / other_ + toSlack / multiplier_;
    Direction found;
    found.y = factor.solve(transposed(weights * right) - dual_);
    found.multiplier = weights * (right - constraintsOf(found.y));
    found.slack = (toSlack - slack_ * found.multiplier) / multiplier_;
    found.excess = (toExcess + excess_ * found.multiplier) / other_;
    return found;
  }

  std::pair<double, double> stepsAlong(const Direction& by) const {
    return {std::min(stepFor(slack_, by.slack), stepFor(excess_, by.excess)),
            std::min(stepFor(multiplier_, by.multiplier), stepFor(other_, -by.multiplier))};
  }

  bool step() {
    const ArrayXd weights = 1 / (excess_ / other_ + slack_ / multiplier_);
    const VectorXd roots = weights.sqrt().matrix();
    BandedMatrix matrix = program_.hessian;
    Eigen::Index row = 0;
    for (std::size_t i = 0; i < matrix.diagonal.size(); ++i) {
      const MatrixXd& rows = program_.constraints[i];
      const MatrixXd weighted = roots.segment(row, rows.rows()).asDiagonal() * rows;
      matrix.diagonal[i].selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
      row += rows.rows();
    }
    const BandedCholesky factor(std::move(matrix));
    if (!factor.isDefinite()) return false;
    const Direction predicted =
        direction(factor, weights, -slack_ * multiplier_, -excess_ * other_);
    const auto [primal, dual] = stepsAlong(predicted);
    const double reached =
        (((slack_ + primal * predicted.slack) * (multiplier_ + dual * predicted.multiplier)).sum() +
         ((excess_ + primal * predicted.excess) * (other_ - dual * predicted.multiplier)).sum()) /
        (2.0 * count_);
    const double aim = gap_ * std::pow(reached / gap_, 3);
    const Direction corrected = direction(
        factor, weights, aim - slack_ * multiplier_ - predicted.slack * predicted.multiplier,
        aim - excess_ * other_ + predicted.excess * predicted.multiplier);
    const auto [first, second] = stepsAlong(corrected);
    y_ += first * corrected.y;
    slack_ += first * corrected.slack;
    excess_ += first * corrected.excess;
    multiplier_ += second * corrected.multiplier;
    other_ -= second * corrected.multiplier;
    return true;
  }

  const BandedProgram& program_;
  Eigen::Index count_ = 0;  // constraints of all states
  ArrayXd bounds_;
  double size_ = 0, top_ = 0;  // the largest entry of the gradient, and of the bounds
  MatrixXd y_;
  ArrayXd slack_, excess_;      // s, t
  ArrayXd multiplier_, other_;  // l, u
  ArrayXd primal_;
  MatrixXd dual_;
  double gap_ = 0;  // mean product of a slack and its multiplier
};

}  // namespace

BandedCholesky::BandedCholesky(BandedMatrix matrix) : factor_(std::move(matrix)) {
  const std::size_t count = factor_.diagonal.size();
  for (std::size_t i = 0; i < count && isDefinite_; ++i) {
    MatrixXd& block = factor_.diagonal[i];
    auto lower = block.selfadjointView<Eigen::Lower>();
    if (i >= 1) lower.rankUpdate(factor_.first[i - 1], -1);
    if (i >= 2) lower.rankUpdate(factor_.second[i - 2], -1);
    const Eigen::LLT<MatrixXd> root(block);
    isDefinite_ = root.info() == Eigen::Success;
    block = root.matrixL();
    const auto upper = block.triangularView<Eigen::Lower>();
    // B L^-T for a block B below the diagonal, by columns of its transpose.
    const auto divide = [&](MatrixXd& below) {
      below = upper.solve(below.transpose()).transpose().eval();
    };
    if (i + 1 < count) {
      if (i >= 1) factor_.first[i] -= factor_.second[i - 1] * factor_.first[i - 1].transpose();
      divide(factor_.first[i]);
    }
    if (i + 2 < count) divide(factor_.second[i]);
  }
}

MatrixXd BandedCholesky::solve(MatrixXd right) const {
  const auto count = static_cast<Eigen::Index>(factor_.diagonal.size());
  for (Eigen::Index i = 0; i < count; ++i) {
    if (i >= 1) right.col(i) -= factor_.first[i - 1] * right.col(i - 1);
    if (i >= 2) right.col(i) -= factor_.second[i - 2] * right.col(i - 2);
    factor_.diagonal[i].triangularView<Eigen::Lower>().solveInPlace(right.col(i));
  }
  for (Eigen::Index i = count; i-- > 0;) {
    if (i + 1 < count) right.col(i) -= factor_.first[i].transpose() * right.col(i + 1);
    if (i + 2 < count) right.col(i) -= factor_.second[i].transpose() * right.col(i + 2);
    factor_.diagonal[i].triangularView<Eigen::Lower>().transpose().solveInPlace(right.col(i));
  }
  return right;
}

BandedSolution solve(const BandedProgram& program) {
  return InteriorPoint(program).find();
}

}  // namespace kirireel::path
