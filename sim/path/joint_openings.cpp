// The largest of many openings is not smooth. The sum of their powers is, and its minimum tends to
// that of the largest as the exponent p increases (the p-norm, see S. Boyd, L. Vandenberghe, Convex
// Optimization, 2004, section 6.1). For each joint, with w = (|c|/s)^(p-2) and the direction e of
// its opening c,
//   dC/dc / 2 = (w + share) c,   d2C/dc2 / 2 = w (I + (p - 2) e e') + share I.
#include "sim/path/joint_openings.h"

#include <algorithm>
#include <cmath>

#include "sim/run/mechanism_path.h"

namespace kirireel::path {

using Eigen::VectorXd;

namespace {

Vector3 apartOf(const brick::Pivot& pivot, const Poses& poses) {
  return brick::poseOf(pivot.brickA, poses).apply(pivot.pointA) -
         brick::poseOf(pivot.brickB, poses).apply(pivot.pointB);
}

}  // namespace

JointOpenings::JointOpenings(const std::vector<brick::Brick>& bricks,
                             const std::vector<brick::Pivot>& pivots, bool isPlanar)
    : isPlanar_(isPlanar), count_(static_cast<int>(bricks.size())) {
  for (const brick::Brick& brick : bricks) radii_.push_back(run::gyrationRadius(brick));
  for (const brick::Pivot& pivot : pivots) {
    if (isPlanar && pivot.isUpper) continue;
    pivots_.push_back(pivot);
    rows_ += pivot.rowCount(isPlanar_);
  }
}

VectorXd JointOpenings::openings(const Poses& poses) const {
  VectorXd values(rows_);
  int row = 0;
  for (const brick::Pivot& pivot : pivots_) {
    const int count = pivot.rowCount(isPlanar_);
    values.segment(row, count) = brick::pivotRows(pivot, apartOf(pivot, poses)).gaps.head(count);
    row += count;
  }
  return values;
}

double JointOpenings::largest(const VectorXd& openings) const {
  double largest = 0;
  int row = 0;
  for (const brick::Pivot& pivot : pivots_) {
    const int count = pivot.rowCount(isPlanar_);
    largest = std::max(largest, openings.segment(row, count).norm());
    row += count;
  }
  return largest;
}

SparseMatrix JointOpenings::jacobian(const Poses& poses) const {
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  for (const brick::Pivot& pivot : pivots_) {
    const brick::PivotRows rows = brick::pivotRows(pivot, apartOf(pivot, poses));
    for (int k = 0; k < pivot.rowCount(isPlanar_); ++k, ++row) {
      const Vector3 axis = rows.axes.row(k);
      addRow(row, pivot.brickA, axis, pivot.pointA, poses, entries);
      addRow(row, pivot.brickB, -axis, pivot.pointB, poses, entries);
    }
  }
  SparseMatrix matrix(rows_, columns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

OpeningCost JointOpenings::cost(const VectorXd& openings, double exponent, double scale,
                                double share) const {
  OpeningCost cost{0, VectorXd(rows_), SparseMatrix(rows_, rows_)};
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  for (const brick::Pivot& pivot : pivots_) {
    const int count = pivot.rowCount(isPlanar_);
    const VectorXd opening = openings.segment(row, count);
    const double size = opening.norm();
    const double weight = std::pow(size / scale, exponent - 2);  // 0^0 = 1
    cost.value += (2 / exponent * weight + share) * size * size;
    cost.gradient.segment(row, count) = (weight + share) * opening;
    const VectorXd along = size > 0 ? VectorXd(opening / size) : opening;
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < count; ++k) {
        const double bent = weight * (exponent - 2) * along[i] * along[k];
        entries.emplace_back(row + i, row + k, bent + (i == k ? weight + share : 0));
      }
    }
    row += count;
  }
  cost.hessian.setFromTriplets(entries.begin(), entries.end());
  return cost;
}

Poses JointOpenings::moved(Poses poses, const VectorXd& u) const {
  for (int i = 0; i < count_; ++i) {
    Vector6 move = Vector6::Zero();
    for (int k = 0; k < freedoms(); ++k) move[component(k)] = u[i * freedoms() + k];
    poses[i] = displaced(poses[i], move.head<3>(), move.tail<3>() / radii_[i]);
  }
  return poses;
}

double JointOpenings::partOf(const Vector6& form, int brick, int k) const {
  const int which = component(k);
  return which < 3 ? form[which] : form[which] / radii_[brick];
}

void JointOpenings::addRow(int row, int brick, const Vector3& axis, const Vector3& point,
                           const Poses& poses, std::vector<Eigen::Triplet<double>>& entries) const {
  if (!brick::isBrick(brick)) return;
  Vector6 form;
  form << axis, (poses[brick].rotation * point).cross(axis);
  for (int k = 0; k < freedoms(); ++k) {
    entries.emplace_back(row, brick * freedoms() + k, partOf(form, brick, k));
  }
}

}  // namespace kirireel::path
