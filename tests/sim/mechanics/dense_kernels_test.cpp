#include "sim/mechanics/dense_kernels.h"

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace kirireel {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Columns padded for the kernels, with the values that may be read after them.
Vector padded(const Matrix& matrix) {
  const auto rows = mechanics::paddedRows(static_cast<int>(matrix.rows()));
  Vector numbers = Vector::Zero(rows * matrix.cols() + mechanics::kRowsTogether);
  Eigen::Map<Matrix>(numbers.data(), rows, matrix.cols()).topRows(matrix.rows()) = matrix;
  return numbers;
}

/// The lower triangle without the padding.
Matrix lowerPart(const Vector& numbers, int rows, int columns) {
  Matrix matrix =
      Eigen::Map<const Matrix>(numbers.data(), mechanics::paddedRows(rows), columns).topRows(rows);
  matrix.topRows(columns).triangularView<Eigen::StrictlyUpper>().setZero();
  return matrix;
}

/// A front's panel, the update for its parent, and the results of a dense factorisation.
struct Front {
  Front(int rowCount, int columnCount) : rows(rowCount), columns(columnCount) {
    std::srand(static_cast<unsigned>(100 * rowCount + columnCount));
    const Matrix B = Matrix::Random(rows, rows);
    whole = B * B.transpose() + Matrix::Identity(rows, rows);
    panel = padded(whole.leftCols(columns));
    update = padded(whole.bottomRightCorner(rows - columns, rows - columns));
    L = whole.llt().matrixL();
  }

  bool eliminate(const mechanics::DenseKernels& kernels) {
    return kernels.eliminate(panel.data(), rows, columns, update.data());
  }

  int rows, columns;
  Matrix whole, L;
  Vector panel, update;
};

/// The baseline's kernels and the fastest that this processor runs.
std::vector<const mechanics::DenseKernels*> kernelSets() {
  return {&mechanics::baseline::kKernels, &mechanics::denseKernels()};
}

constexpr int kShapes[][2] = {{3, 3},   {6, 6},   {9, 3},   {15, 6},
                              {30, 12}, {33, 15}, {96, 48}, {150, 90}};

TEST(DenseKernels, EliminateAsADenseFactorisationDoes) {
  for (const mechanics::DenseKernels* kernels : kernelSets()) {
    for (const auto& [rows, columns] : kShapes) {
      Front front(rows, columns);
      ASSERT_TRUE(front.eliminate(*kernels)) << kernels->name;
      Matrix found = lowerPart(front.panel, rows, columns);
      found.diagonal() = found.diagonal().cwiseInverse();
      EXPECT_LT((found - front.L.leftCols(columns)).norm(), 1e-12 * front.L.norm())
          << kernels->name << rows;  // measured 2e-14 of 88
      // The remainder is the Schur complement, with the factor of the rest.
      const Matrix rest = front.L.bottomRightCorner(rows - columns, rows - columns);
      const int below = rows - columns;
      Matrix difference = lowerPart(front.update, below, below) - rest * rest.transpose();
      difference.triangularView<Eigen::StrictlyUpper>().setZero();
      EXPECT_LT(difference.norm(), 1e-12 * front.whole.norm());  // measured 1e-13 of 870
    }
  }
}

TEST(DenseKernels, SolveForwardAndBackward) {
  for (const mechanics::DenseKernels* kernels : kernelSets()) {
    for (const auto& [rows, columns] : kShapes) {
      Front front(rows, columns);
      ASSERT_TRUE(front.eliminate(*kernels));
      const Matrix pivot = front.L.topLeftCorner(columns, columns);
      const Matrix under = front.L.bottomLeftCorner(rows - columns, columns);
      Vector x = padded(Vector::Random(rows));
      x.tail(x.size() - columns).setZero();
      const Vector right = x.head(columns);
      kernels->solveForward(front.panel.data(), rows, columns, x.data());
      const Vector top = x.head(columns);
      EXPECT_LT((pivot * top - right).norm(), 1e-11);  // measured 2e-15
      EXPECT_LT((under * top + x.segment(columns, rows - columns)).norm(),
                1e-11);  // measured 2e-15
      x = padded(Vector::Random(rows));
      const Vector expected =
          x.head(columns) - under.transpose() * x.segment(columns, rows - columns);
      kernels->solveBackward(front.panel.data(), rows, columns, x.data());
      EXPECT_LT((pivot.transpose() * x.head(columns) - expected).norm(), 1e-11);  // measured 2e-14
    }
  }
}

TEST(DenseKernels, ReportAPivotThatIsNotPositive) {
  for (const mechanics::DenseKernels* kernels : kernelSets()) {
    for (const auto& [rows, columns] : kShapes) {
      Front front(rows, columns);
      front.panel[(columns - 1) * (mechanics::paddedRows(rows) + 1)] = -1;
      EXPECT_FALSE(front.eliminate(*kernels)) << kernels->name << rows;
    }
  }
}

TEST(DenseKernels, HaveNames) {
  EXPECT_STREQ(mechanics::baseline::kKernels.name, "baseline");
  const std::string fastest = mechanics::denseKernels().name;
  EXPECT_TRUE(fastest == "baseline" || fastest == "avx2") << fastest;
}

}  // namespace
}  // namespace kirireel
