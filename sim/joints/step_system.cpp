#include "sim/joints/step_system.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kirireel {
namespace {

// Weight of the joint rows in H, relative to the mean of A's translational part: 1e6 stalls near
// singular states and 1e8 leaves gaps on large models; from 1e12 on rounding shows.
constexpr double kJointWeight = 1e10;
// The contact rows' weight is far smaller, so that Newton's line search can step over the kinks of
// many contacts at once; their multipliers do the rest in two or three rounds.
constexpr double kContactWeight = 1e5;
// What setting up a brick and a row is worth, in multiplications.
constexpr double kWorkOfBrick = 2000;
constexpr double kWorkOfRow = 500;

/// Mass and inertia of a brick in world axes.
template <int D>
typename Coordinates<D>::Block massMatrix(const Brick& brick, const Pose& pose) {
  const Matrix3 R = pose.rotation.toRotationMatrix();
  return Coordinates<D>::inertia(brick.mass, R * brick.inertia * R.transpose());
}

}  // namespace

template <int D>
StepSystem<D>::StepSystem(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                          double lengthScale)
    : bricks_(bricks),
      lengthScale_(lengthScale),
      pinned_(bricks.size(), false),
      edgesAt_(bricks.size()),
      A_(bricks.size()),
      f_(D * bricks.size()) {
  for (const Pivot& pivot : pivots) {
    // In the plane both faces' pivots coincide.
    if (D == 6 || !pivot.isUpper) pivots_.push_back(pivot);
  }
  jointRows_.resize(pivots_.size());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    jointRows_[p].edge = edgeOf(pivots_[p].brickA, pivots_[p].brickB);
  }
}

template <int D>
int StepSystem<D>::edgeOf(int brickA, int brickB) {
  const auto [low, high] = std::minmax(brickA, brickB);
  for (const auto& [other, edge] : edgesAt_[low]) {
    if (other == high) return edge;
  }
  const int edge = static_cast<int>(edges_.size());
  edges_.emplace_back(low, high);
  edgesAt_[low].emplace_back(high, edge);
  graphChanged_ = true;
  return edge;
}

template <int D>
void StepSystem<D>::transfer(StateTape& tape) {
  std::vector<std::pair<int, int>> edges = edges_;
  tape.transfer(edges);
  for (const auto& [low, high] : edges) edgeOf(low, high);
}

template <int D>
void StepSystem<D>::setMasses(const Poses& poses) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    A_[i] = massMatrix<D>(bricks_[i], poses[i]);
    sum += A_[i](0, 0);
  }
  f_.setZero();
  kappa_ = kJointWeight * sum / static_cast<double>(bricks_.size());
  rho_ = kContactWeight * sum / static_cast<double>(bricks_.size());
}

template <int D>
void StepSystem<D>::setStep(const Motion& motion, const std::vector<Load>& loads, double step,
                            double jointStiffness) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Block M = massMatrix<D>(bricks_[i], motion.poses[i]);
    if (pinned_[i]) {
      // No joint row touches it, so that nothing but zero solves its equations.
      f_.segment<D>(D * i).setZero();
      A_[i] = M;
    } else {
      f_.segment<D>(D * i) =
          M * Space::pack(motion.velocities[i]) + step * Space::restrict(loads[i].force);
      A_[i] = M + step * Space::restrict(loads[i].damping) +
              step * step * Space::restrict(loads[i].stiffness);
    }
    sum += A_[i](0, 0);
  }
  kappa_ = std::isfinite(jointStiffness) ? step * step * jointStiffness
                                         : kJointWeight * sum / static_cast<double>(bricks_.size());
  rho_ = kContactWeight * sum / static_cast<double>(bricks_.size());
}

template <int D>
void StepSystem<D>::placeJoints(const Poses& poses) {
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const Pivot& pivot = pivots_[p];
    JointRows& rows = jointRows_[p];
    rows.a = Space::pointVelocity(poses[pivot.brickA].rotation * pivot.pointA);
    rows.b = -Space::pointVelocity(poses[pivot.brickB].rotation * pivot.pointB);
    if (pivot.distance > 0) keepLengthwiseRow(pivot, poses, rows);
    if (pinned_[pivot.brickA]) rows.a.setZero();
    if (pinned_[pivot.brickB]) rows.b.setZero();
  }
}

/// A link is one row, the velocity along it; its other rows are empty.
template <int D>
void StepSystem<D>::keepLengthwiseRow(const Pivot& pivot, const Poses& poses, JointRows& rows) {
  const typename Space::Gap along =
      Space::gap(poses[pivot.brickA].apply(pivot.pointA) - poses[pivot.brickB].apply(pivot.pointB));
  const typename Space::RowVector alongA = along.normalized().transpose() * rows.a;
  const typename Space::RowVector alongB = along.normalized().transpose() * rows.b;
  rows.a.setZero();
  rows.b.setZero();
  rows.a.row(0) = alongA;
  rows.b.row(0) = alongB;
}

/// Adds weight * [a b]^T [a b] for one row of a pair of bricks; the row of a brick that does not
/// move is left out.
template <int D>
void StepSystem<D>::addRowToMatrix(const PairOnGraph& pair, const RowVector& a, const RowVector& b,
                                   double weight) {
  const RowVector weightedA = weight * a;
  matrix_.diagonal(pair.brickA).noalias() += weightedA.transpose() * a;
  if (pair.brickB == kFixed) return;
  const RowVector weightedB = weight * b;
  matrix_.diagonal(pair.brickB).noalias() += weightedB.transpose() * b;
  if (pair.brickA < pair.brickB) {
    matrix_.offDiagonal(pair.edge).noalias() += weightedA.transpose() * b;
  } else {
    matrix_.offDiagonal(pair.edge).noalias() += weightedB.transpose() * a;
  }
}

template <int D>
void StepSystem<D>::addJointsToMatrix() {
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const JointRows& rows = jointRows_[p];
    const PairOnGraph pair{pivots_[p].brickA, pivots_[p].brickB, rows.edge};
    for (int k = 0; k < Space::kJointRows; ++k) {
      addRowToMatrix(pair, rows.a.row(k), rows.b.row(k), kappa_);
    }
  }
}

template <int D>
void StepSystem<D>::addContactToMatrix(const ContactRow<D>& row) {
  PairOnGraph pair{row.contact.brickA, row.contact.brickB};
  if (pair.brickB != kFixed) pair.edge = edgeOf(pair.brickA, pair.brickB);
  if (row.active) addRowToMatrix(pair, row.normalA, row.normalB, rho_);
  if (!row.rubs()) return;
  // The tangents along the slip stiffness' own directions.
  Eigen::SelfAdjointEigenSolver<typename ContactRow<D>::TangentMatrix> own;
  own.computeDirect(row.slipStiffness);
  const typename ContactRow<D>::TangentRows a = own.eigenvectors().transpose() * row.tangentA;
  const typename ContactRow<D>::TangentRows b = own.eigenvectors().transpose() * row.tangentB;
  for (int k = 0; k < ContactRow<D>::kTangents; ++k) {
    addRowToMatrix(pair, a.row(k), b.row(k), rho_ * own.eigenvalues()[k]);
  }
}

template <int D>
bool StepSystem<D>::factor(const std::vector<ContactRow<D>>& contacts) {
  for (const ContactRow<D>& row : contacts) {
    if (row.acts() && row.contact.brickB != kFixed) edgeOf(row.contact.brickA, row.contact.brickB);
  }
  if (graphChanged_) matrix_.analyze(brickCount(), edges_);
  graphChanged_ = false;
  matrix_.setZero();
  for (int i = 0; i < brickCount(); ++i) matrix_.diagonal(i) = A_[i];
  addJointsToMatrix();
  for (const ContactRow<D>& row : contacts) {
    if (row.acts()) addContactToMatrix(row);
  }
  ++factorizations_;
  work_ += matrix_.work() + kWorkOfBrick * brickCount() +
           kWorkOfRow * static_cast<double>(jointRows_.size() + contacts.size());
  return matrix_.factor();
}

template <int D>
double StepSystem<D>::kineticEnergy(const Poses& poses, const Vector& x) const {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector velocity = x.segment<D>(D * i);
    sum += 0.5 * velocity.dot(massMatrix<D>(bricks_[i], poses[i]) * velocity);
  }
  return sum;
}

template <int D>
double StepSystem<D>::workAgainst(const std::vector<Load>& loads, const Vector& first,
                                  const Vector& further) const {
  double work = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector move = further.segment<D>(D * i);
    const typename Space::Vector middle = first.segment<D>(D * i) + 0.5 * move;
    work -=
        move.dot(Space::restrict(loads[i].force) - Space::restrict(loads[i].stiffness) * middle);
  }
  return work;
}

template <int D>
Eigen::VectorXd StepSystem<D>::timesA(const Vector& x) const {
  Vector result(x.size());
  for (int i = 0; i < brickCount(); ++i) {
    result.segment<D>(D * i) = A_[i] * x.segment<D>(D * i);
  }
  return result;
}

template <int D>
double StepSystem<D>::largestSpeed(const Vector& x) const {
  double largest = 0;
  for (int i = 0; i < D * brickCount(); ++i) {
    const double scale = Space::isTurn(i % D) ? lengthScale_ : 1.0;
    largest = std::max(largest, scale * std::abs(x[i]));
  }
  return largest;
}

template <int D>
Eigen::VectorXd StepSystem<D>::jointVelocity(const Vector& u) const {
  constexpr int kRows = Space::kJointRows;
  Vector result(jointRowCount());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    result.segment<kRows>(kRows * p) = jointRows_[p].a * u.segment<D>(D * pivots_[p].brickA) +
                                       jointRows_[p].b * u.segment<D>(D * pivots_[p].brickB);
  }
  return result;
}

template <int D>
void StepSystem<D>::addJointImpulse(double scale, const Vector& multipliers, Vector& to) const {
  constexpr int kRows = Space::kJointRows;
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const auto impulse = (scale * multipliers.segment<kRows>(kRows * p)).eval();
    to.segment<D>(D * pivots_[p].brickA) += jointRows_[p].a.transpose() * impulse;
    to.segment<D>(D * pivots_[p].brickB) += jointRows_[p].b.transpose() * impulse;
  }
}

template <int D>
Eigen::VectorXd StepSystem<D>::jointGaps(const Poses& poses) const {
  constexpr int kRows = Space::kJointRows;
  Vector result(jointRowCount());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const Pivot& pivot = pivots_[p];
    const Vector3 between =
        poses[pivot.brickA].apply(pivot.pointA) - poses[pivot.brickB].apply(pivot.pointB);
    typename Space::Gap gap = Space::gap(between);
    if (pivot.distance > 0) gap = (between.norm() - pivot.distance) * Space::Gap::UnitX();
    result.segment<kRows>(kRows * p) = gap;
  }
  return result;
}

template class StepSystem<3>;
template class StepSystem<6>;

}  // namespace kirireel
