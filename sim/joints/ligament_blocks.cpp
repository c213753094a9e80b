// Ligaments in a step. Over a step h from poses q with velocities x, the energy E(q + h x) is
// replaced by its second-order expansion about known velocities x0,
//   f gains -h g + h^2 K x0,     A gains h^2 K
// with the gradient g and the second derivative K at q + h x0, so that the minimum of the step's
// quadratic function is one Newton step for the true one. K is made positive semidefinite by
// dropping its negative eigenvalues, in coordinates in which a turn of one radian counts as the
// length scale: else the cut would depend on the unit of length. A brick that is pinned does not
// move; its rows are left out.
#include "sim/joints/ligament_blocks.h"

#include <Eigen/Eigenvalues>

#include "sim/joints/coordinates.h"

namespace kirireel {
namespace {

using Plane = Coordinates<3>;

/// A symmetric matrix without its negative part, as seen in units in which turns are lengths.
Matrix6 withoutNegative(const Matrix6& matrix, double lengthScale) {
  Vector6 units;
  units << 1, 1, 1 / lengthScale, 1, 1, 1 / lengthScale;
  const Matrix6 scaled = units.asDiagonal() * matrix * units.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6> own(scaled);
  const Vector6 kept = own.eigenvalues().cwiseMax(0);
  const Matrix6 cut = own.eigenvectors() * kept.asDiagonal() * own.eigenvectors().transpose();
  const Vector6 back = units.cwiseInverse();
  return back.asDiagonal() * cut * back.asDiagonal();
}

// The six entries of a vector of all bricks (x, y, turn each) that a ligament's two bricks have.
Vector6 pairOf(const Ligament& ligament, const Eigen::VectorXd& x) {
  Vector6 pair;
  pair << x.segment<3>(3 * ligament.brickA), x.segment<3>(3 * ligament.brickB);
  return pair;
}

// Adds six entries of a ligament back to the vector of all bricks.
void addPair(const Ligament& ligament, const Vector6& pair, Eigen::VectorXd& to) {
  to.segment<3>(3 * ligament.brickA) += pair.head<3>();
  to.segment<3>(3 * ligament.brickB) += pair.tail<3>();
}

}  // namespace

// Starts a step with the expansion about bricks at rest, x0 = 0. `step` in seconds; bricks that are
// held do not move in it.
void LigamentBlocks::begin(const Poses& poses, double step, const std::vector<bool>& held) {
  if (empty()) return;
  start_ = poses;
  step_ = step;
  held_ = held;
}

// The poses at the start displaced by (metres, metres, radians) a brick.
Poses LigamentBlocks::posesAfter(const Vector& displacement) const {
  Poses poses = start_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Plane::displace(poses[i], displacement.segment<3>(3 * static_cast<Eigen::Index>(i)));
  }
  return poses;
}

// Expands about the velocities x0 and stores h^2 K and its share of f. The force is h^2 K x0 - h g:
// a Newton step solves for all velocities, not for a change of them.
void LigamentBlocks::setAbout(const Vector& x0, Curvature curvature) {
  const Poses poses = posesAfter(step_ * x0);
  for (std::size_t k = 0; k < ligaments_.size(); ++k) {
    const Ligament& ligament = ligaments_[k];
    const LigamentEnergy energy = ligamentEnergy(ligament, poses);
    LigamentBlock& block = blocks_[k];
    const bool isWhole = curvature == Curvature::Whole;
    block.weight =
        step_ * step_ * (isWhole ? energy.hessian : withoutNegative(energy.hessian, lengthScale_));
    block.force = block.weight * pairOf(ligament, x0) - step_ * energy.gradient;
    const auto leaveOut = [&](int brick, int first) {
      if (!held_[static_cast<std::size_t>(brick)]) return;
      block.force.segment<3>(first).setZero();
      block.weight.middleRows<3>(first).setZero();
      block.weight.middleCols<3>(first).setZero();
    };
    leaveOut(ligament.brickA, 0);
    leaveOut(ligament.brickB, 3);
  }
}

// The exact energy after a displacement, joules. The step compares it with what the expansion
// foretold.
double LigamentBlocks::energyAfter(const Vector& displacement) const {
  return empty() ? 0 : elasticEnergy(ligaments_, posesAfter(displacement));
}

void LigamentBlocks::addForce(Vector& f) const {
  for (std::size_t k = 0; k < ligaments_.size(); ++k) addPair(ligaments_[k], blocks_[k].force, f);
}

// Adds h^2 K x without building a matrix.
void LigamentBlocks::addProduct(const Vector& x, Vector& to) const {
  for (std::size_t k = 0; k < ligaments_.size(); ++k) {
    addPair(ligaments_[k], blocks_[k].weight * pairOf(ligaments_[k], x), to);
  }
}

}  // namespace kirireel
