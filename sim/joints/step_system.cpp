// The matrices of one implicit Euler step.
//
// Of a brick with the mass m, the inertia I in world axes, the load F (N, N m), its damping D and
// stiffness K by velocity and position, and the velocity u0 at the start of the step h,
//   A = diag(m 1, I) + h D + h^2 K,        f = diag(m 1, I) u0 + h F
// so that A x = f gives the velocity at the end of a step without joints: m (x - u0) = h (F - D x -
// h K x). Springs at hinges add rows s (the rate of the hinge's angle by both bricks' velocities):
// A gains (h^2 k + h c) s^T s, f gains h m s^T, m the moment at the start. The joint rows J are the
// velocities of pivot points of one brick against the other; kappa J^T J makes H of A, which is
// positive definite whatever J is.
//
// Exact joints take kappa = 1e10 times the mean mass and multipliers; joints that are springs of
// stiffness k take kappa = h^2 k, which is their implicit Euler step. H's blocks stand on the graph
// of bricks. An edge that a contact brings stays in the graph for the rest of the run, as the same
// bricks mostly touch again, and a new plan costs more than some zeros.
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
  return Coordinates<D>::inertia(brick.mass, brick.inertia, pose.rotation.toRotationMatrix());
}

/// The rotations of all bricks as matrices: a brick has several pivots.
std::vector<Matrix3> rotationMatrices(const Poses& poses) {
  std::vector<Matrix3> matrices;
  matrices.reserve(poses.size());
  for (const Pose& pose : poses) matrices.push_back(pose.rotation.toRotationMatrix());
  return matrices;
}

}  // namespace

template <int D>
StepSystem<D>::StepSystem(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                          double lengthScale, std::vector<HingeSpring> springs,
                          std::vector<Ligament> ligaments)
    : bricks_(bricks),
      lengthScale_(lengthScale),
      pinned_(bricks.size(), false),
      edgesAt_(bricks.size()),
      springs_(std::move(springs)),
      springRows_(springs_.size()),
      ligaments_(std::move(ligaments), lengthScale),
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
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    springRows_[s].edge = edgeOf(springs_[s].hinge.brickA, springs_[s].hinge.brickB);
  }
  for (std::size_t k = 0; k < ligaments_.size(); ++k) {
    const Ligament& ligament = ligaments_.ligament(k);
    ligamentEdges_.push_back(edgeOf(ligament.brickA, ligament.brickB));
  }
}

template <int D>
// The number of the edge between two bricks, which is made where there is none yet.
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
  for (SpringRow& row : springRows_) row.weight = row.moment = 0;
  ligaments_.clear();
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
  setSprings(motion.poses, step);
  ligaments_.begin(motion.poses, step, pinned_);
  ownForce_ = f_;
  kappa_ = std::isfinite(jointStiffness) ? step * step * jointStiffness
                                         : kJointWeight * sum / static_cast<double>(bricks_.size());
  rho_ = kContactWeight * sum / static_cast<double>(bricks_.size());
}

template <int D>
void StepSystem<D>::setLigamentsAbout(const Vector& x, LigamentBlocks::Curvature curvature) {
  ligaments_.setAbout(x, curvature);
  f_ = ownForce_;
  ligaments_.addForce(f_);
}

template <int D>
double StepSystem<D>::potential(double step, const Vector& x) const {
  return x.dot(0.5 * ownTimesA(x) - ownForce_) + ligaments_.energyAfter(step * x);
}

/// Sets the rate of a hinge's angle; a brick that is held takes no part in it.
template <int D>
void StepSystem<D>::placeSpring(const HingeSpring& spring, const Poses& poses,
                                SpringRow& row) const {
  const Hinge& hinge = spring.hinge;
  row.b = Space::turning(poses[hinge.brickA].rotation * hinge.axis);
  row.a = -row.b;
  if (pinned_[hinge.brickA]) row.a.setZero();
  if (pinned_[hinge.brickB]) row.b.setZero();
}

/// Sets the springs' part of A and adds theirs to f.
template <int D>
void StepSystem<D>::setSprings(const Poses& poses, double step) {
  if (springs_.empty()) return;
  const std::vector<double> moments = hingeMoments(springs_, poses);
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const HingeSpring& spring = springs_[s];
    SpringRow& row = springRows_[s];
    placeSpring(spring, poses, row);
    row.moment = moments[s];
    row.weight = step * (step * spring.stiffness + spring.damping);
    f_.segment<D>(D * spring.hinge.brickA) += step * row.moment * row.a.transpose();
    f_.segment<D>(D * spring.hinge.brickB) += step * row.moment * row.b.transpose();
  }
}

template <int D>
void StepSystem<D>::placeJoints(const Poses& poses) {
  const std::vector<Matrix3> turns = rotationMatrices(poses);
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const Pivot& pivot = pivots_[p];
    JointRows& rows = jointRows_[p];
    rows.a = Space::pointVelocity(turns[pivot.brickA] * pivot.pointA);
    rows.b = -Space::pointVelocity(turns[pivot.brickB] * pivot.pointB);
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

/// Adds weight * [a b]^T [a b] for rows of a pair of bricks; those of a brick that does not move
/// are left out.
template <int D>
template <int kRows>
void StepSystem<D>::addRowsToMatrix(const PairOnGraph& pair,
                                    const Eigen::Matrix<double, kRows, D>& a,
                                    const Eigen::Matrix<double, kRows, D>& b, double weight) {
  const Eigen::Matrix<double, D, kRows> weightedA = weight * a.transpose();
  matrix_.addToDiagonal(pair.brickA, weightedA.lazyProduct(a));
  if (pair.brickB == kFixed) return;
  const Eigen::Matrix<double, D, kRows> weightedB = weight * b.transpose();
  matrix_.addToDiagonal(pair.brickB, weightedB.lazyProduct(b));
  if (pair.brickA < pair.brickB) {
    matrix_.addToOffDiagonal(pair.edge, weightedA.lazyProduct(b));
  } else {
    matrix_.addToOffDiagonal(pair.edge, weightedB.lazyProduct(a));
  }
}

template <int D>
void StepSystem<D>::addJointsToMatrix() {
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const JointRows& rows = jointRows_[p];
    addRowsToMatrix<Space::kJointRows>({pivots_[p].brickA, pivots_[p].brickB, rows.edge}, rows.a,
                                       rows.b, kappa_);
  }
}

template <int D>
void StepSystem<D>::addSpringsToMatrix() {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const SpringRow& row = springRows_[s];
    if (row.weight == 0) continue;
    addRowsToMatrix<1>({springs_[s].hinge.brickA, springs_[s].hinge.brickB, row.edge}, row.a, row.b,
                       row.weight);
  }
}

template <int D>
void StepSystem<D>::addLigamentsToMatrix() {
  if constexpr (D == 3) {
    for (std::size_t k = 0; k < ligaments_.size(); ++k) {
      const Ligament& ligament = ligaments_.ligament(k);
      const Matrix6& weight = ligaments_.block(k).weight;
      matrix_.addToDiagonal(ligament.brickA, weight.template topLeftCorner<3, 3>());
      matrix_.addToDiagonal(ligament.brickB, weight.template bottomRightCorner<3, 3>());
      const Block across = weight.template topRightCorner<3, 3>();
      const bool isInOrder = ligament.brickA < ligament.brickB;
      matrix_.addToOffDiagonal(ligamentEdges_[k], isInOrder ? across : Block(across.transpose()));
    }
  }
}

template <int D>
void StepSystem<D>::addContactToMatrix(const ContactRow<D>& row) {
  PairOnGraph pair{row.contact.brickA, row.contact.brickB};
  if (pair.brickB != kFixed) pair.edge = edgeOf(pair.brickA, pair.brickB);
  if (row.active) addRowsToMatrix<1>(pair, row.normalA, row.normalB, rho_);
  if (!row.rubs()) return;
  // The tangents along the slip stiffness' own directions.
  Eigen::SelfAdjointEigenSolver<typename ContactRow<D>::TangentMatrix> own;
  own.computeDirect(row.slipStiffness);
  const typename ContactRow<D>::TangentRows a = own.eigenvectors().transpose() * row.tangentA;
  const typename ContactRow<D>::TangentRows b = own.eigenvectors().transpose() * row.tangentB;
  for (int k = 0; k < ContactRow<D>::kTangents; ++k) {
    addRowsToMatrix<1>(pair, a.row(k), b.row(k), rho_ * own.eigenvalues()[k]);
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
  for (int i = 0; i < brickCount(); ++i) matrix_.addToDiagonal(i, A_[i]);
  addJointsToMatrix();
  addSpringsToMatrix();
  addLigamentsToMatrix();
  for (const ContactRow<D>& row : contacts) {
    if (row.acts()) addContactToMatrix(row);
  }
  ++factorizations_;
  work_ +=
      matrix_.work() + kWorkOfBrick * brickCount() +
      kWorkOfRow * static_cast<double>(jointRows_.size() + springRows_.size() + contacts.size());
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
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const double turn = springRate(s, further);
    const double middle = springRate(s, first) + 0.5 * turn;
    work -= turn * (springRows_[s].moment - springs_[s].stiffness * middle);
  }
  return work + ligaments_.energyAfter(first + further) - ligaments_.energyAfter(first);
}

template <int D>
double StepSystem<D>::dampedBySprings(double step, const Vector& x) const {
  double energy = 0;
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    energy += step * springs_[s].damping * std::pow(springRate(s, x), 2);
  }
  return energy;
}

/// A x, but for ligaments.
template <int D>
Eigen::VectorXd StepSystem<D>::ownTimesA(const Vector& x) const {
  Vector result(x.size());
  for (int i = 0; i < brickCount(); ++i) {
    result.segment<D>(D * i) = A_[i] * x.segment<D>(D * i);
  }
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const SpringRow& row = springRows_[s];
    const double share = row.weight * springRate(s, x);
    result.segment<D>(D * springs_[s].hinge.brickA) += share * row.a.transpose();
    result.segment<D>(D * springs_[s].hinge.brickB) += share * row.b.transpose();
  }
  return result;
}

template <int D>
Eigen::VectorXd StepSystem<D>::timesA(const Vector& x) const {
  Vector result = ownTimesA(x);
  ligaments_.addProduct(x, result);
  return result;
}

/// The rate of a hinge's angle at velocities x, rad/s.
template <int D>
double StepSystem<D>::springRate(std::size_t spring, const Vector& x) const {
  const SpringRow& row = springRows_[spring];
  const Hinge& hinge = springs_[spring].hinge;
  return row.a.dot(x.segment<D>(D * hinge.brickA)) + row.b.dot(x.segment<D>(D * hinge.brickB));
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
  const std::vector<Matrix3> turns = rotationMatrices(poses);
  Vector result(jointRowCount());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const Pivot& pivot = pivots_[p];
    const Vector3 between = poses[pivot.brickA].position - poses[pivot.brickB].position +
                            turns[pivot.brickA] * pivot.pointA - turns[pivot.brickB] * pivot.pointB;
    typename Space::Gap gap = Space::gap(between);
    if (pivot.distance > 0) gap = (between.norm() - pivot.distance) * Space::Gap::UnitX();
    result.segment<kRows>(kRows * p) = gap;
  }
  return result;
}

template class StepSystem<3>;
template class StepSystem<6>;

}  // namespace kirireel
