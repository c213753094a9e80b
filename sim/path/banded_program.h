/// Quadratic programs over a chain of states. Each state is coupled to the next two only.
#pragma once

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
  /// O(states n^3).
  explicit BandedCholesky(BandedMatrix matrix);
  /// Whether the matrix was positive definite. If not, solve() is undefined.
  bool isDefinite() const { return isDefinite_; }
  /// The solution for a right side: one column per state, n rows.
  Eigen::MatrixXd solve(Eigen::MatrixXd right) const;

 private:
  BandedMatrix factor_;
  bool isDefinite_ = true;
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
  int factorisations = 0;  ///< of matrices of H's size, 1 to 25
};

/// Solves a program by an interior-point method.
BandedSolution solve(const BandedProgram& program);

/// The work of a factorisation over states n^3, in multiplications of a sparse factorisation: 3.2
/// multiplications in dense blocks, each of which takes a third of the time.
inline constexpr double kFactorisationCost = 1;

}  // namespace kirireel::path
