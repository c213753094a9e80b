#include "sim/base/geometry.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

namespace kirireel {

Vector3 meanPoint(std::span<const Vector3> points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

Vector3 meanPosition(const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  for (const Pose& pose : poses) sum += pose.position;
  return sum / static_cast<double>(poses.size());
}

Vector3 doubledVectorArea(std::span<const Vector3> corners) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
    sum += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]);
  }
  return sum;
}

SymmetricEigen eigenOf(const Eigen::MatrixXd& matrix) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(matrix);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd withoutNegativePart(const Eigen::MatrixXd& matrix) {
  const SymmetricEigen own = eigenOf(matrix);
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  for (Eigen::Index k = 0; k < own.values.size(); ++k) {
    if (own.values[k] <= 0) continue;
    kept.noalias() += own.values[k] * own.vectors.col(k) * own.vectors.col(k).transpose();
  }
  return kept;
}

Eigen::VectorXd singularValuesOf(const Eigen::MatrixXd& matrix) {
  const Eigen::Index rows = matrix.rows(), columns = matrix.cols();
  // Only the lower triangle is read.
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(rows + columns, rows + columns);
  both.bottomLeftCorner(rows, columns) = matrix;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(both, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().tail(std::min(rows, columns)).reverse().cwiseMax(0);
}

Poses interpolate(const Poses& from, const Poses& to, double share) {
  Poses poses(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    poses[i].position = from[i].position + share * (to[i].position - from[i].position);
    poses[i].rotation = from[i].rotation.slerp(share, to[i].rotation);
  }
  return poses;
}

Vector3 turnRate(const Vector3& turn, const Vector3& angular) {
  const double angle = turn.norm();
  const double half = 0.5 * angle;
  // (1 - half cot(half)) / angle^2, by its limit if the quotient would lose digits.
  const double part =
      angle < 1e-3 ? 1.0 / 12 : (1 - half * std::cos(half) / std::sin(half)) / (angle * angle);
  return angular - 0.5 * turn.cross(angular) + part * turn.cross(turn.cross(angular));
}

Poses interpolate(const Motion& from, const Motion& to, double seconds, double share) {
  const double rest = 1 - share;
  const double begin = seconds * share * rest * rest;
  const double end = -seconds * share * share * rest;
  const double fraction = share * share * (3 - 2 * share);
  Poses poses(from.poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Pose& first = from.poses[i];
    const Pose& last = to.poses[i];
    poses[i].position = first.position + fraction * (last.position - first.position) +
                        begin * from.velocities[i].linear + end * to.velocities[i].linear;
    const Vector3 turn = turnBetween(first.rotation, last.rotation);
    const Vector3 turned = fraction * turn + begin * from.velocities[i].angular +
                           end * turnRate(turn, to.velocities[i].angular);
    poses[i].rotation = (rotationFromVector(turned) * first.rotation).normalized();
  }
  return poses;
}

}  // namespace kirireel
