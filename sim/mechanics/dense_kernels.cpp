// Compiled once for each instruction set (see CMakeLists.txt), with KIRIREEL_KERNELS as the name of
// the set. For all sets but the baseline, Eigen's namespace is renamed. Otherwise the linker could
// pick an Eigen function with newer instructions for the whole program. For the same reason this
// file uses no other inline functions.
//
// A front is processed three columns at a time, from the left; D is a multiple of three. The
// earlier columns act on these, and on the update behind the panel, by one product,
//   to(r, c) -= sum_k left(r, k) left(row + c, k),
// whose sums stay in registers: eight rows by three columns. Rows are processed in whole registers,
// and the rest of a column is padding. Entries above the diagonal are written too, but never read.
// Wide fronts, of sheets with thousands of tiles, use Eigen, which splits the product to fit the
// caches.
//
// After factoring, the diagonal holds each column's reciprocal square root: solves multiply and
// never divide.
#include "sim/mechanics/dense_kernels.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace kirireel::mechanics::KIRIREEL_KERNELS {
namespace {

constexpr int kTogether = 3;           // columns
constexpr int kLanes = kRowsTogether;  // rows in a register
// From this number of columns, Eigen's blocked product is faster.
constexpr int kWide = 60;

/// The rows of a register.
using Lanes = double __attribute__((vector_size(kLanes * sizeof(double))));

// Addresses need no more alignment than a double. Copies are compiled to unaligned moves.
inline Lanes load(const double* place) {
  Lanes lanes;
  __builtin_memcpy(&lanes, place, sizeof(lanes));
  return lanes;
}

inline void store(double* place, const Lanes& lanes) {
  __builtin_memcpy(place, &lanes, sizeof(lanes));
}

// First row of the register that holds this row: columns begin at whole registers.
inline int wholeRegisters(int rows) {
  return rows / kLanes * kLanes;
}

/// to(r, c) -= sum_k left(r, k) right(c, k) for kRegisters registers of rows and three columns.
template <int kRegisters>
inline void takeProduct(double* to, int toStride, const double* left, const double* right,
                        int stride, int columns) {
  Lanes sum[kTogether][kRegisters] = {};
  for (int k = 0; k < columns; ++k, left += stride, right += stride) {
    for (int c = 0; c < kTogether; ++c) {
      for (int n = 0; n < kRegisters; ++n) sum[c][n] += load(left + kLanes * n) * right[c];
    }
  }
  for (int c = 0; c < kTogether; ++c) {
    for (int n = 0; n < kRegisters; ++n)
      store(to + c * toStride + kLanes * n, load(to + c * toStride + kLanes * n) - sum[c][n]);
  }
}

/// The same for all rows from `first` to `last`, counted from `to` and `left`.
inline void takeProducts(double* to, int toStride, const double* left, const double* right,
                         int stride, int columns, int first, int last) {
  int row = wholeRegisters(first);
  for (; row + 2 * kLanes <= last; row += 2 * kLanes) {
    takeProduct<2>(to + row, toStride, left + row, right, stride, columns);
  }
  if (row < last) takeProduct<1>(to + row, toStride, left + row, right, stride, columns);
}

/// Factors three columns whose triangle begins at `row`. The diagonal stores reciprocals.
inline bool factorColumns(double* columns, int stride, int row) {
  double* const a = columns;
  double* const b = columns + stride;
  double* const c = columns + 2 * stride;
  if (!(a[row] > 0)) return false;
  const double overA = 1 / __builtin_sqrt(a[row]);
  const double ab = a[row + 1] * overA;
  const double ac = a[row + 2] * overA;
  const double squareB = b[row + 1] - ab * ab;
  if (!(squareB > 0)) return false;
  const double overB = 1 / __builtin_sqrt(squareB);
  const double bc = (b[row + 2] - ab * ac) * overB;
  const double squareC = c[row + 2] - ac * ac - bc * bc;
  if (!(squareC > 0)) return false;
  const double overC = 1 / __builtin_sqrt(squareC);
  for (int r = wholeRegisters(row); r < stride; r += kLanes) {
    store(a + r, load(a + r) * overA);
    store(b + r, (load(b + r) - load(a + r) * ab) * overB);
    store(c + r, (load(c + r) - load(a + r) * ac - load(b + r) * bc) * overC);
  }
  a[row] = overA;
  b[row + 1] = overB;
  c[row + 2] = overC;
  return true;
}

// The same elimination by Eigen: L11 = chol(A11), L21 = A21 L11^-T, S = A22 - L21 L21^T. Returns
// false if the pivot block is not positive definite.
bool eliminateWide(double* panel, int stride, int rows, int columns, double* update,
                   int updateStride) {
  using Stride = Eigen::OuterStride<>;
  using Map = Eigen::Map<Eigen::MatrixXd, 0, Stride>;
  Map front(panel, rows, columns, Stride(stride));
  auto pivot = front.topRows(columns);
  if (Eigen::internal::llt_inplace<double, Eigen::Lower>::blocked(pivot) >= 0) return false;
  auto lower = front.bottomRows(rows - columns);
  pivot.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(lower);
  Map schur(update, rows - columns, rows - columns, Stride(updateStride));
  schur.selfadjointView<Eigen::Lower>().rankUpdate(lower, -1.0);
  // Solves multiply by the reciprocal, as after the narrow elimination.
  front.diagonal() = front.diagonal().cwiseInverse();
  return true;
}

// A left-looking Cholesky factorisation of the first `columns` columns of a front of `rows` rows.
// Subtracts the product of the rows below from the lower triangle of `update`, the Schur complement
// for the parent fronts. `columns` is a multiple of three. Returns false at a pivot that is not
// positive. The panel is then undefined.
bool eliminate(double* panel, int rows, int columns, double* update) {
  const int stride = paddedRows(rows);
  const int below = rows - columns;
  if (columns >= kWide) {
    return eliminateWide(panel, stride, rows, columns, update, paddedRows(below));
  }
  for (int j = 0; j < columns; j += kTogether) {
    double* const to = panel + j * stride;
    // All columns on the left are factored: one product subtracts them from these three.
    takeProducts(to, stride, panel, panel + j, stride, j, j, stride);
    if (!factorColumns(to, stride, j)) return false;
  }
  const double* const lower = panel + columns;
  const int updateStride = paddedRows(below);
  for (int j = 0; j < below; j += kTogether) {
    // All columns are factored: the same product on the rows behind the panel is the update.
    takeProducts(update + j * updateStride, updateStride, lower, lower + j, stride, columns, j,
                 updateStride);
  }
  return true;
}

// L y = x for the columns of one front, in place. Subtracts the product of the columns from
// the rows below. Works on whole registers to the end: x must have room for the padded
// rows.
void solveForward(const double* panel, int rows, int columns, double* x) {
  const int stride = paddedRows(rows);
  for (int j = 0; j < columns; j += kTogether) {
    const double* const a = panel + j * stride;
    const double* const b = a + stride;
    const double* const c = b + stride;
    const double first = x[j] *= a[j];
    const double second = x[j + 1] = (x[j + 1] - a[j + 1] * first) * b[j + 1];
    const double third = x[j + 2] = (x[j + 2] - a[j + 2] * first - b[j + 2] * second) * c[j + 2];
    int r = j + kTogether;
    for (; r % kLanes != 0; ++r) x[r] -= a[r] * first + b[r] * second + c[r] * third;
    for (; r < stride; r += kLanes) {
      store(x + r,
            load(x + r) - (load(a + r) * first + load(b + r) * second + load(c + r) * third));
    }
  }
}

// L^T x = y for the columns of one front, in place, from the last three columns to the first. The
// rows below are already known. The three sums over them are computed together: each row of x is
// read only once.
void solveBackward(const double* panel, int rows, int columns, double* x) {
  const int stride = paddedRows(rows);
  for (int j = columns - kTogether; j >= 0; j -= kTogether) {
    const double* const a = panel + j * stride;
    const double* const b = a + stride;
    const double* const c = b + stride;
    double first = x[j], second = x[j + 1], third = x[j + 2];
    int r = j + kTogether;
    for (; r % kLanes != 0; ++r) {
      first -= a[r] * x[r];
      second -= b[r] * x[r];
      third -= c[r] * x[r];
    }
    Lanes sum[kTogether] = {};
    for (; r < stride; r += kLanes) {
      sum[0] += load(a + r) * load(x + r);
      sum[1] += load(b + r) * load(x + r);
      sum[2] += load(c + r) * load(x + r);
    }
    for (int n = 0; n < kLanes; ++n) {
      first -= sum[0][n];
      second -= sum[1][n];
      third -= sum[2][n];
    }
    x[j + 2] = third *= c[j + 2];
    x[j + 1] = second = (second - b[j + 2] * third) * b[j + 1];
    x[j] = (first - a[j + 1] * second - a[j + 2] * third) * a[j];
  }
}

}  // namespace

extern const DenseKernels kKernels;
const DenseKernels kKernels = {eliminate, solveForward, solveBackward, KIRIREEL_KERNELS_NAME};

}  // namespace kirireel::mechanics::KIRIREEL_KERNELS
