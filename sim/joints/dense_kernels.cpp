// Compiled once for each instruction set (see CMakeLists.txt), with KIRIREEL_KERNELS naming the set
// and, for all but the baseline, with Eigen's namespace renamed: else the linker might pick the
// newer instructions' copy of an Eigen function for the whole program. For the same reason this
// file uses nothing else that is inline.
#include "sim/joints/dense_kernels.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace kirireel::KIRIREEL_KERNELS {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// Below this many columns plain column operations beat Eigen's blocked triangular solve.
constexpr int kNarrow = 25;

/// lower = lower * pivot^-T, column by column.
template <typename Pivot, typename Lower>
void divideNarrow(const Pivot& pivot, Lower& lower) {
  for (int j = 0; j < lower.cols(); ++j) {
    for (int k = 0; k < j; ++k) lower.col(j) -= pivot(j, k) * lower.col(k);
    lower.col(j) *= 1.0 / pivot(j, j);
  }
}

bool eliminate(double* panel, int rows, int columns, double* update) {
  Eigen::Map<Matrix> front(panel, rows, columns);
  auto pivot = front.topRows(columns);
  if (Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(pivot) >= 0) return false;
  const int below = rows - columns;
  if (below == 0) return true;
  auto lower = front.bottomRows(below);
  if (columns < kNarrow) {
    divideNarrow(pivot, lower);
  } else {
    pivot.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(lower);
  }
  Eigen::Map<Matrix> schur(update, below, below);
  schur.selfadjointView<Eigen::Lower>().rankUpdate(lower, -1.0);
  return true;
}

void solveForward(const double* panel, int rows, int columns, double* top, double* below) {
  const Eigen::Map<const Matrix> front(panel, rows, columns);
  Eigen::Map<Vector> x(top, columns);
  front.topRows(columns).triangularView<Eigen::Lower>().solveInPlace(x);
  Eigen::Map<Vector>(below, rows - columns).noalias() = front.bottomRows(rows - columns) * x;
}

void solveBackward(const double* panel, int rows, int columns, double* top, const double* below) {
  const Eigen::Map<const Matrix> front(panel, rows, columns);
  Eigen::Map<Vector> x(top, columns);
  x.noalias() -= front.bottomRows(rows - columns).transpose() *
                 Eigen::Map<const Vector>(below, rows - columns);
  front.topRows(columns).triangularView<Eigen::Lower>().transpose().solveInPlace(x);
}

}  // namespace

extern const DenseKernels kKernels;
const DenseKernels kKernels = {eliminate, solveForward, solveBackward, KIRIREEL_KERNELS_NAME};

}  // namespace kirireel::KIRIREEL_KERNELS
