/// Quadratic programs over a chain of states. Each state is coupled to the next two only.
#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

namespace kirireel::path {

/// A symmetric matrix of blocks of n by n: block (i, j) is zero if |i - j| > 2.
struct BandedMatrix {
  std::vector<Eigen::MatrixXd> diagonal;  ///< blocks (i, i), one per state
  std::vector<Eigen::MatrixXd> first;     ///< blocks (i + 1, i), one fewer
  std::vector<Eigen::MatrixXd> second;    ///< blocks (i + 2, i), two fewer
};

/// The Cholesky factor of a positive definite banded matrix: block by block, with the same band.
class BandedCholesky {
 public:
  /// Factors a matrix, O(states n^3). Returns whether it is positive definite. If not, solve() is
  /// undefined. The memory is used again for the next matrix.
  bool factorize(const BandedMatrix& matrix);
  /// The solution for a right side: one column per state, n rows.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;

 private:
  int count() const { return static_cast<int>(panels_.size()); }
  int rows(int state) const { return width_ * std::min(3, count() - state); }

  int size_ = 0;   // n
  int width_ = 0;  // n, filled up to a multiple of three with rows of the identity
  // One per state, as the dense kernels have them: the factor's blocks in its columns.
  std::vector<Eigen::VectorXd> panels_;
  Eigen::VectorXd update_, nextUpdate_;  // of the states before, for this state and the next two
};

/// minimise  y . H y / 2 + g . y + c sum t  subject to  A_i y_i + t_i >= b_i,  t >= 0.
/// t is the violation of the constraints, c a thousand times `priceScale`: constraints that
/// contradict each other are violated as little as possible.
struct BandedProgram {
  BandedMatrix hessian;                      ///< H, positive definite
  Eigen::MatrixXd gradient;                  ///< g, one column per state
  std::vector<Eigen::MatrixXd> constraints;  ///< A_i, one per state, n columns each
  std::vector<Eigen::VectorXd> bounds;       ///< b_i
  double priceScale = 0;                     ///< of g if that is not zero; > 0
};

/// The solution of a program, and what it cost.
struct BandedSolution {
  Eigen::MatrixXd y;       ///< one column per state; empty if H is not positive definite
  int factorisations = 0;  ///< of matrices of H's size, 0 to 26
};

/// The minimum of a program without its constraints, by one factorisation. Empty if H is not
/// positive definite.
Eigen::MatrixXd unconstrainedMinimum(const BandedProgram& program);

/// Solves a program by an interior-point method. `unconstrained`: see unconstrainedMinimum(); it is
/// the solution if it satisfies the constraints.
BandedSolution solve(const BandedProgram& program, Eigen::MatrixXd unconstrained);

/// The work of a factorisation over states n^3, in multiplications of a sparse factorisation: 3.2
/// multiplications in dense blocks, each of which takes a third of the time.
inline constexpr double kFactorisationCost = 1;

}  // namespace kirireel::path
