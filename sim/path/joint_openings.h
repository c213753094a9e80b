/// The openings of a sheet's joints at one state, with their derivatives and their cost.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "sim/brick/brick.h"

namespace kirireel::path {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// The cost C of the openings c of one state.
struct OpeningCost {
  double value = 0;          ///< square metres
  Eigen::VectorXd gradient;  ///< dC/dc / 2, metres
  SparseMatrix hessian;      ///< d2C/dc2 / 2, one block per joint
};

/// The joints of a sheet and their derivatives with respect to u. u stacks the displacement dx and
/// the arc rho dphi of each brick: 6 numbers, or 3 in the plane. rho is its radius of gyration.
class JointOpenings {
 public:
  JointOpenings(const std::vector<brick::Brick>& bricks, const std::vector<brick::Pivot>& pivots,
                bool isPlanar);

  int rows() const { return rows_; }
  /// Numbers per brick.
  int freedoms() const { return isPlanar_ ? 3 : 6; }
  int columns() const { return count_ * freedoms(); }
  /// Radius of gyration, metres.
  double radius(int brick) const { return radii_[brick]; }

  /// Openings c of the joints, metres. For a link, the excess of its length.
  Eigen::VectorXd openings(const Poses& poses) const;
  /// The norm of the largest opening of a joint, metres.
  double largest(const Eigen::VectorXd& openings) const;
  /// dc/du.
  SparseMatrix jacobian(const Poses& poses) const;
  /// C = sum over the joints of (2/p) s^2 (|c|/s)^p + share |c|^2, with an exponent p >= 2 and a
  /// scale s > 0, metres. If p is large, only openings near s and above count in the first term.
  OpeningCost cost(const Eigen::VectorXd& openings, double exponent, double scale,
                   double share) const;

  /// The state after the move u.
  Poses moved(Poses poses, const Eigen::VectorXd& u) const;
  /// Component k of u of a linear form in (dx, dphi) of one brick.
  double partOf(const Vector6& form, int brick, int k) const;
  /// The index in (dx, dphi) of a brick's component k.
  int component(int k) const { return isPlanar_ && k == 2 ? 5 : k; }

 private:
  void addRow(int row, int brick, const Vector3& axis, const Vector3& point, const Poses& poses,
              std::vector<Eigen::Triplet<double>>& entries) const;

  bool isPlanar_;
  int count_;  // bricks
  int rows_ = 0;
  std::vector<double> radii_;  // of gyration, metres
  std::vector<brick::Pivot> pivots_;
};

}  // namespace kirireel::path
