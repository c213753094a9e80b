// Rows of contacts and their augmented Lagrangian. A contact with the multiplier p has the normal
// impulse
//   max(0, p - rho (c x - b))
// and the friction impulse s - rho t x, limited to the length mu p of Coulomb's cone with p of the
// previous round. Points of one plane become rows together. The next step starts with the
// multipliers of loaded contacts.
#include "sim/mechanics/step_system.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace kirireel::mechanics {
namespace {

// Two unit vectors that span the plane across a unit normal. Any two give the same result, because
// the friction cone is round.
std::array<Vector3, 2> tangentsOf(const Vector3& normal) {
  const Vector3 first = normal.unitOrthogonal();
  return {first, normal.cross(first)};
}

/// Adds the effect of rotating edges. The normal of two edges rotates with both bricks,
///   d(a x b . d) = w_A . (a x (b x d)) + w_B . (b x (d x a)),
/// and only the part of d across the normal matters, since the normal keeps its length.
template <int D>
void addTurningNormal(ContactRow<D>& row, const Poses& poses) {
  const brick::Contact& contact = row.contact;
  const Pose& poseA = brick::poseOf(contact.brickA, poses);
  const Pose& poseB = brick::poseOf(contact.brickB, poses);
  const Vector3 a = poseA.rotation * contact.edgeA;
  const Vector3 b = poseB.rotation * contact.normal;
  const double length = a.cross(b).norm();
  const Vector3 normal = a.cross(b) / length;
  const auto [onA, onB] = brick::contactPoints(contact, poses);
  const Vector3 between = onA - onB;
  const Vector3 d = between - normal.dot(between) * normal;
  row.normalA += Coordinates<D>::turning(a.cross(b.cross(d)) / length);
  row.normalB += Coordinates<D>::turning(b.cross(d.cross(a)) / length);
}

}  // namespace

// w = C u for this row, m/s; positive if the points separate.
template <int D>
double ContactRow<D>::normalVelocity(const Eigen::VectorXd& u) const {
  double w = 0;
  if (brick::isBrick(contact.brickA)) w += normalA.dot(u.segment<D>(D * contact.brickA));
  if (brick::isBrick(contact.brickB)) w += normalB.dot(u.segment<D>(D * contact.brickB));
  return w;
}

template <int D>
typename ContactRow<D>::Tangent ContactRow<D>::slipVelocity(const Eigen::VectorXd& u) const {
  Tangent w = Tangent::Zero();
  if (brick::isBrick(contact.brickA)) w += tangentA * u.segment<D>(D * contact.brickA);
  if (brick::isBrick(contact.brickB)) w += tangentB * u.segment<D>(D * contact.brickB);
  return w;
}

template <int D>
void ContactRow<D>::addNormal(double scale, Eigen::VectorXd& to) const {
  const auto add = [&](int brick, const RowVector& row) {
    if (brick::isBrick(brick)) to.segment<D>(D * brick) += scale * row.transpose();
  };
  add(contact.brickA, normalA);
  add(contact.brickB, normalB);
}

template <int D>
void ContactRow<D>::addTangent(const Tangent& scale, Eigen::VectorXd& to) const {
  const auto add = [&](int brick, const TangentRows& rows) {
    if (brick::isBrick(brick)) to.segment<D>(D * brick) += rows.transpose() * scale;
  };
  add(contact.brickA, tangentA);
  add(contact.brickB, tangentB);
}

template <int D>
double ContactRow<D>::pushingImpulse(const Eigen::VectorXd& u, double rho) const {
  return multiplier - rho * (normalVelocity(u) + bias);
}

template <int D>
double ContactRow<D>::trialImpulse(const Eigen::VectorXd& u, double rho) const {
  return hasNormal ? std::max(0.0, pushingImpulse(u, rho)) : 0.0;
}

template <int D>
typename ContactRow<D>::Tangent ContactRow<D>::trialSlipImpulse(const Eigen::VectorXd& u,
                                                                double rho,
                                                                TangentMatrix* stiffness) const {
  const Tangent trial = slipMultiplier - rho * slipVelocity(u);
  const double length = trial.norm();
  if (length <= slipBound) {
    if (stiffness) stiffness->setIdentity();
    return trial;
  }
  const Tangent direction = trial / length;
  const double share = slipBound / length;
  if (stiffness) {
    *stiffness = share * (TangentMatrix::Identity() - direction * direction.transpose());
  }
  return share * trial;
}

template <int D>
void placeRow(ContactRow<D>& row, const Poses& poses) {
  const brick::Contact& contact = row.contact;
  const Pose& poseA = brick::poseOf(contact.brickA, poses);
  const Vector3 normal = brick::contactNormal(contact, poses);
  const auto [onA, onB] = brick::contactPoints(contact, poses);
  const bool isCrossing = contact.isEdge && contact.isRegion;
  const Vector3 armA =
      isCrossing ? Vector3(onA - poseA.position) : Vector3(poseA.rotation * contact.pointA);
  Vector3 armB = Vector3::Zero();
  if (brick::isBrick(contact.brickB)) {
    // A plane of B rotates with B, so B's arm also ends at A's point.
    const Pose& poseB = poses[contact.brickB];
    armB = isCrossing       ? Vector3(onB - poseB.position)
           : contact.isEdge ? Vector3(poseB.rotation * contact.pointB)
                            : Vector3(poseA.position + armA - poseB.position);
  }
  row.normalA = Coordinates<D>::pointVelocity(armA, normal);
  row.normalB = -Coordinates<D>::pointVelocity(armB, normal);
  if (contact.isEdge) addTurningNormal(row, poses);
  const std::array<Vector3, 2> tangents = tangentsOf(normal);
  for (int k = 0; k < ContactRow<D>::kTangents; ++k) {
    row.tangentA.row(k) = Coordinates<D>::pointVelocity(armA, tangents[k]);
    row.tangentB.row(k) = -Coordinates<D>::pointVelocity(armB, tangents[k]);
  }
}

template <int D>
ContactRow<D> makeContactRow(const brick::Contact& contact, const Poses& poses, double step,
                             double recovery) {
  ContactRow<D> row;
  row.contact = contact;
  placeRow(row, poses);
  const double gap = brick::contactGap(contact, poses);
  row.aim = std::min(0.0, gap + recovery);
  row.bias = std::max(0.0, gap) / step;
  return row;
}

template struct ContactRow<3>;
template struct ContactRow<6>;
template ContactRow<3> makeContactRow<3>(const brick::Contact&, const Poses&, double, double);
template ContactRow<6> makeContactRow<6>(const brick::Contact&, const Poses&, double, double);
template void placeRow<3>(ContactRow<3>&, const Poses&);
template void placeRow<6>(ContactRow<6>&, const Poses&);

// ------------------------------------------------------------------------------------------------
// The matrices of one implicit Euler step.
//
// For a brick with the mass m, the inertia I in world axes, the load F (N, N m), its damping D and
// stiffness K by velocity and position, and the velocity u0 at the start of the step h,
//   A = diag(m 1, I) + h D + h^2 K,        f = diag(m 1, I) u0 + h F.
// Without joints, A x = f gives the velocity x at the end of the step:
// m (x - u0) = h (F - D x - h K x). Springs at hinges add rows s (the rate of the hinge's angle by
// both bricks' velocities): A gains (h^2 k + h c) s^T s, f gains h m s^T, m the moment at the
// start. The joint rows J are the velocities of pivot points of one brick against the other.
// H = A + kappa J^T J is positive definite for any J.
//
// Exact joints have kappa = 1e10 times the mean mass, and multipliers. Joints that are springs of
// stiffness k have kappa = h^2 k, which is their implicit Euler step. H has the blocks of the graph
// of bricks. The edge of a contact stays in the graph for the rest of the run, because most
// contacts recur, and a new plan costs more than some zeros.

namespace {

// Weight of the joint rows in H, relative to the mean of A's translational part: 1e6 stalls near
// singular states, 1e8 leaves gaps on large models, and rounding errors are visible from 1e12 on.
constexpr double kJointWeight = 1e10;
// The contact rows' weight is far smaller: Newton's line search can step over the kinks of many
// contacts at once; their multipliers do the rest in two or three rounds.
constexpr double kContactWeight = 1e5;
// A smaller sine of directions between pivots of a joint is rounding.
constexpr double kSamePoint = 1e-9;
// Cost of setting up a brick and a row, in multiplications.
constexpr double kWorkOfBrick = 2000;
constexpr double kWorkOfRow = 500;

/// Mass and inertia of a brick in world axes.
template <int D>
typename Coordinates<D>::Block massMatrix(const brick::Brick& brick, const Pose& pose) {
  return Coordinates<D>::inertia(brick.mass, brick.inertia, pose.rotation.toRotationMatrix());
}

}  // namespace

int BrickGraph::edgeOf(int brickA, int brickB) {
  const auto [low, high] = std::minmax(brickA, brickB);
  for (const auto& [other, edge] : edgesAt_[low]) {
    if (other == high) return edge;
  }
  const int edge = static_cast<int>(edges_.size());
  edges_.emplace_back(low, high);
  edgesAt_[low].emplace_back(high, edge);
  hasGrown_ = true;
  return edge;
}

void BrickGraph::transfer(StateTape& tape) {
  std::vector<std::pair<int, int>> edges = edges_;
  tape.transfer(edges);
  for (const auto& [low, high] : edges) edgeOf(low, high);
}

template <int D>
SpringRows<D>::SpringRows(std::vector<brick::HingeSpring> springs, BrickGraph& graph)
    : springs_(std::move(springs)), rows_(springs_.size()) {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    rows_[s].edge = graph.edgeOf(springs_[s].hinge.brickA, springs_[s].hinge.brickB);
  }
}

template <int D>
void SpringRows<D>::begin(const Poses& poses, double step, const std::vector<bool>& held) {
  if (springs_.empty()) return;
  const std::vector<double> moments = brick::hingeMoments(springs_, poses);
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const brick::HingeSpring& spring = springs_[s];
    const brick::Hinge& hinge = spring.hinge;
    SpringRow<D>& row = rows_[s];
    row.b = Coordinates<D>::turning(poses[hinge.brickA].rotation * hinge.axis);
    row.a = -row.b;
    if (held[hinge.brickA]) row.a.setZero();
    if (held[hinge.brickB]) row.b.setZero();
    row.moment = moments[s];
    row.weight = step * (step * spring.stiffness + spring.damping);
  }
}

template <int D>
void SpringRows<D>::clear() {
  for (SpringRow<D>& row : rows_) row.weight = row.moment = 0;
}

template <int D>
double SpringRows<D>::rate(std::size_t s, const Vector& x) const {
  const brick::Hinge& hinge = springs_[s].hinge;
  return rows_[s].a.dot(x.segment<D>(D * hinge.brickA)) +
         rows_[s].b.dot(x.segment<D>(D * hinge.brickB));
}

template <int D>
void SpringRows<D>::addForce(double step, Vector& f) const {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const brick::Hinge& hinge = springs_[s].hinge;
    f.segment<D>(D * hinge.brickA) += step * rows_[s].moment * rows_[s].a.transpose();
    f.segment<D>(D * hinge.brickB) += step * rows_[s].moment * rows_[s].b.transpose();
  }
}

template <int D>
void SpringRows<D>::addProduct(const Vector& x, Vector& to) const {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const brick::Hinge& hinge = springs_[s].hinge;
    const double share = rows_[s].weight * rate(s, x);
    to.segment<D>(D * hinge.brickA) += share * rows_[s].a.transpose();
    to.segment<D>(D * hinge.brickB) += share * rows_[s].b.transpose();
  }
}

template <int D>
void SpringRows<D>::addWorkAgainst(const Vector& first, const Vector& further, double& work) const {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const double turn = rate(s, further);
    const double middle = rate(s, first) + 0.5 * turn;
    work -= turn * (rows_[s].moment - springs_[s].stiffness * middle);
  }
}

template <int D>
double SpringRows<D>::damped(double step, const Vector& x) const {
  double energy = 0;
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    energy += step * springs_[s].damping * std::pow(rate(s, x), 2);
  }
  return energy;
}

// ------------------------------------------------------------------------------------------------
// Forces between pairs of bricks in a step. Over a step h from poses q with velocities x, the
// energy E(q + h x) is replaced by its second-order expansion about known velocities x0,
//   f gains -h g + h^2 K x0,     A gains h^2 K
// with the gradient g and the second derivative K at q + h x0: the minimum of the step's quadratic
// function is one Newton step for the true one. In space, g and K are derivatives by rotations from
// the current pose instead of q, which differ by the angle of a step. K is made positive
// semidefinite by dropping its negative eigenvalues. Its rotations are multiplied by the length
// scale, so the result does not depend on the unit of length. Rows of pinned bricks are omitted.

namespace {

/// An energy in D coordinates per brick.
template <int D>
auto restricted(const brick::PairEnergy& energy) {
  if constexpr (D == 3) {
    return brick::inPlane(energy);
  } else {
    return energy;
  }
}

/// The entries of a vector of all bricks that a pair has.
template <int D>
typename PairBlocks<D>::PairVector pairOf(const PairOnGraph& pair, const Eigen::VectorXd& x) {
  typename PairBlocks<D>::PairVector both;
  both << x.segment<D>(D * pair.brickA), x.segment<D>(D * pair.brickB);
  return both;
}

/// Adds a pair's entries back to the vector of all bricks.
template <int D>
void addPair(const PairOnGraph& pair, const typename PairBlocks<D>::PairVector& both,
             Eigen::VectorXd& to) {
  to.segment<D>(D * pair.brickA) += both.template head<D>();
  to.segment<D>(D * pair.brickB) += both.template tail<D>();
}

}  // namespace

template <int D>
PairBlocks<D>::PairBlocks(const brick::PairForces& forces, double lengthScale, BrickGraph& graph)
    : lengthScale_(lengthScale) {
  for (const std::shared_ptr<const brick::PairForce>& force : forces) {
    // Springs at hinges are rows, see SpringRows.
    if (force->hingeSprings()) continue;
    forces_.add(force);
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      const auto [brickA, brickB] = force->bricks(pair);
      blocks_.push_back({{brickA, brickB, graph.edgeOf(brickA, brickB)}});
    }
  }
}

// Starts a step with the expansion about bricks at rest, x0 = 0. `step` in seconds. Held bricks do
// not move in it.
template <int D>
void PairBlocks<D>::begin(const Poses& poses, double step, const std::vector<bool>& held) {
  if (empty()) return;
  start_ = poses;
  step_ = step;
  held_ = held;
}

// The poses at the start displaced by D coordinates per brick.
template <int D>
Poses PairBlocks<D>::posesAfter(const Vector& displacement) const {
  Poses poses = start_;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Coordinates<D>::displace(poses[i], displacement.segment<D>(D * static_cast<Eigen::Index>(i)));
  }
  return poses;
}

/// A symmetric matrix without its negative part, as seen in units in which turns are lengths.
template <int D>
typename PairBlocks<D>::PairMatrix PairBlocks<D>::withoutNegative(const PairMatrix& matrix) const {
  PairVector units;
  for (int k = 0; k < 2 * D; ++k) {
    units[k] = Coordinates<D>::isTurn(k % D) ? 1 / lengthScale_ : 1;
  }
  const PairMatrix scaled = units.asDiagonal() * matrix * units.asDiagonal();
  const PairMatrix cut = withoutNegativePart(scaled);
  const PairVector back = units.cwiseInverse();
  return back.asDiagonal() * cut * back.asDiagonal();
}

template <int D>
void PairBlocks<D>::omitHeld(PairBlock& block) const {
  for (const auto& [brick, first] :
       {std::pair{block.pair.brickA, 0}, std::pair{block.pair.brickB, D}}) {
    if (!held_[static_cast<std::size_t>(brick)]) continue;
    block.force.template segment<D>(first).setZero();
    block.weight.template middleRows<D>(first).setZero();
    block.weight.template middleCols<D>(first).setZero();
  }
}

// Expands about the velocities x0 and stores h^2 K and its share of f. The force is h^2 K x0 - h g:
// a Newton step solves for all velocities, not for a change of them.
template <int D>
void PairBlocks<D>::setAbout(const Vector& x0, Curvature curvature) {
  const Poses poses = posesAfter(step_ * x0);
  auto block = blocks_.begin();
  for (const std::shared_ptr<const brick::PairForce>& force : forces_) {
    for (std::size_t pair = 0; pair < force->size(); ++pair, ++block) {
      const auto energy = restricted<D>(force->derivatives(pair, poses));
      const bool isWhole = curvature == Curvature::Whole;
      block->weight = step_ * step_ * (isWhole ? energy.hessian : withoutNegative(energy.hessian));
      block->force = block->weight * pairOf<D>(block->pair, x0) - step_ * energy.gradient;
      omitHeld(*block);
    }
  }
}

template <int D>
void PairBlocks<D>::clear() {
  for (PairBlock& block : blocks_) {
    block.force.setZero();
    block.weight.setZero();
  }
}

// The exact energy after a displacement, joules. The step compares it with what the expansion
// predicted.
template <int D>
double PairBlocks<D>::energyAfter(const Vector& displacement) const {
  return empty() ? 0 : forces_.energy(posesAfter(displacement));
}

template <int D>
void PairBlocks<D>::addForce(Vector& f) const {
  for (const PairBlock& block : blocks_) addPair<D>(block.pair, block.force, f);
}

// Adds h^2 K x without building a matrix.
template <int D>
void PairBlocks<D>::addProduct(const Vector& x, Vector& to) const {
  for (const PairBlock& block : blocks_) {
    addPair<D>(block.pair, block.weight * pairOf<D>(block.pair, x), to);
  }
}

// ------------------------------------------------------------------------------------------------
// The system.

template <int D>
StepSystem<D>::StepSystem(const std::vector<brick::Brick>& bricks,
                          std::span<const brick::Pivot> pivots, double lengthScale,
                          const brick::PairForces& pairForces)
    : bricks_(bricks),
      lengthScale_(lengthScale),
      pinned_(bricks.size(), false),
      graph_(bricks.size()),
      springs_({}, graph_),
      pairBlocks_({}, lengthScale, graph_),
      A_(bricks.size()),
      f_(D * bricks.size()) {
  for (const brick::Pivot& pivot : pivots) {
    // In the plane both faces' pivots coincide.
    if (D == 6 || !pivot.isUpper) pivots_.push_back(pivot);
  }
  jointRows_.resize(pivots_.size());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    jointRows_[p].edge = graph_.edgeOf(pivots_[p].brickA, pivots_[p].brickB);
  }
  // After the joints, because the order of edges determines the rounding.
  springs_ = SpringRows<D>(brick::hingeSpringsOf(pairForces), graph_);
  pairBlocks_ = PairBlocks<D>(pairForces, lengthScale, graph_);
}

template <int D>
void StepSystem<D>::setMasses(const Poses& poses) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    A_[i] = massMatrix<D>(bricks_[i], poses[i]);
    sum += A_[i](0, 0);
  }
  f_.setZero();
  springs_.clear();
  pairBlocks_.clear();
  hasExactJoints_ = true;
  kappa_ = kJointWeight * sum / static_cast<double>(bricks_.size());
  rho_ = kContactWeight * sum / static_cast<double>(bricks_.size());
}

template <int D>
void StepSystem<D>::setStep(const Motion& motion, const std::vector<brick::Load>& loads,
                            double step, double jointStiffness) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Block M = massMatrix<D>(bricks_[i], motion.poses[i]);
    if (pinned_[i]) {
      // No joint row has this column, so the solution is zero.
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
  springs_.begin(motion.poses, step, pinned_);
  springs_.addForce(step, f_);
  pairBlocks_.begin(motion.poses, step, pinned_);
  ownForce_ = f_;
  hasExactJoints_ = !std::isfinite(jointStiffness);
  kappa_ = std::isfinite(jointStiffness) ? step * step * jointStiffness
                                         : kJointWeight * sum / static_cast<double>(bricks_.size());
  rho_ = kContactWeight * sum / static_cast<double>(bricks_.size());
}

template <int D>
void StepSystem<D>::setPairBlocksAbout(const Vector& x,
                                       typename PairBlocks<D>::Curvature curvature) {
  pairBlocks_.setAbout(x, curvature);
  f_ = ownForce_;
  pairBlocks_.addForce(f_);
}

template <int D>
double StepSystem<D>::potential(double step, const Vector& x) const {
  return x.dot(0.5 * ownTimesA(x) - ownForce_) + pairBlocks_.energyAfter(step * x);
}

template <int D>
void StepSystem<D>::omitRepeatedRows() {
  repeated_.assign(pivots_.size(), Matrix3::Zero());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    Matrix3& repeated = repeated_[p];
    for (std::size_t q = p; q-- > 0 && pivots_[q].joint == pivots_[p].joint;) {
      const Vector3 between = pivots_[p].pointA - pivots_[q].pointA;
      const Vector3 along = between - repeated * between;
      if (along.norm() > kSamePoint * between.norm())
        repeated += along * along.transpose() / along.squaredNorm();
    }
  }
}

/// Removes the directions from a pivot's rows that earlier pivots of its joint have.
template <int D>
void StepSystem<D>::omitRepeated(std::size_t pivot, const Matrix3& turnOfA,
                                 JointRows<D>& rows) const {
  if constexpr (D == 6) {
    if (!hasExactJoints_ || repeated_.empty() || repeated_[pivot].isZero(0)) return;
    const Matrix3 kept = turnOfA * (Matrix3::Identity() - repeated_[pivot]) * turnOfA.transpose();
    rows.a = kept * rows.a;
    rows.b = kept * rows.b;
  }
}

template <int D>
void StepSystem<D>::placeJoints(const Poses& poses) {
  const std::vector<Matrix3> turns = rotationMatrices(poses);
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const brick::Pivot& pivot = pivots_[p];
    JointRows<D>& rows = jointRows_[p];
    rows.a = Space::pointVelocity(turns[pivot.brickA] * pivot.pointA);
    rows.b = -Space::pointVelocity(turns[pivot.brickB] * pivot.pointB);
    if (!pivot.joinsPoints()) keepRows(pivot, poses, rows);
    omitRepeated(p, turns[pivot.brickA], rows);
    if (pinned_[pivot.brickA]) rows.a.setZero();
    if (pinned_[pivot.brickB]) rows.b.setZero();
  }
}

/// Replaces the relative velocity of a pivot's points by its components along the pivot's rows. The
/// other rows are empty.
template <int D>
void StepSystem<D>::keepRows(const brick::Pivot& pivot, const Poses& poses, JointRows<D>& rows) {
  const brick::PivotRows kept = brick::pivotRows(
      pivot, poses[pivot.brickA].apply(pivot.pointA) - poses[pivot.brickB].apply(pivot.pointB));
  const typename Space::Rows a = rows.a, b = rows.b;
  rows.a.setZero();
  rows.b.setZero();
  for (int k = 0; k < pivot.rowCount(D == 3); ++k) {
    const typename Space::Gap axis = Space::gap(kept.axes.row(k));
    rows.a.row(k) = axis.transpose() * a;
    rows.b.row(k) = axis.transpose() * b;
  }
}

namespace {

/// The product of two small matrices.
// Eigen calls a function for each.
template <typename Left, typename Right>
auto productOf(const Left& left, const Right& right) {
  Eigen::Matrix<double, Left::RowsAtCompileTime, Right::ColsAtCompileTime> product;
  for (Eigen::Index column = 0; column < product.cols(); ++column) {
    for (Eigen::Index row = 0; row < product.rows(); ++row) {
      double sum = left.coeff(row, 0) * right.coeff(0, column);
      for (Eigen::Index k = 1; k < Left::ColsAtCompileTime; ++k) {
        sum += left.coeff(row, k) * right.coeff(k, column);
      }
      product.coeffRef(row, column) = sum;
    }
  }
  return product;
}

}  // namespace

/// Adds [a b]^T weight [a b] for rows of a pair of bricks, without those of fixed bodies. The
/// weight is a number or a symmetric matrix.
template <int D>
template <int kRows, typename Weight>
void StepSystem<D>::addRowsToMatrix(const PairOnGraph& pair,
                                    const Eigen::Matrix<double, kRows, D>& a,
                                    const Eigen::Matrix<double, kRows, D>& b,
                                    const Weight& weight) {
  const Eigen::Matrix<double, D, kRows> weightedA = a.transpose() * weight;
  const Eigen::Matrix<double, D, kRows> weightedB = b.transpose() * weight;
  if (brick::isBrick(pair.brickA)) matrix_.addToDiagonal(pair.brickA, productOf(weightedA, a));
  if (brick::isBrick(pair.brickB)) matrix_.addToDiagonal(pair.brickB, productOf(weightedB, b));
  if (!pair.hasEdge()) return;
  if (pair.brickA < pair.brickB) {
    matrix_.addToOffDiagonal(pair.edge, productOf(weightedA, b));
  } else {
    matrix_.addToOffDiagonal(pair.edge, productOf(weightedB, a));
  }
}

template <int D>
void StepSystem<D>::addJointsToMatrix() {
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    const JointRows<D>& rows = jointRows_[p];
    addRowsToMatrix<Space::kJointRows>({pivots_[p].brickA, pivots_[p].brickB, rows.edge}, rows.a,
                                       rows.b, kappa_);
  }
}

template <int D>
void StepSystem<D>::addSpringsToMatrix() {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const SpringRow<D>& row = springs_.row(s);
    const brick::Hinge& hinge = springs_.spring(s).hinge;
    if (row.weight == 0) continue;
    addRowsToMatrix<1>({hinge.brickA, hinge.brickB, row.edge}, row.a, row.b, row.weight);
  }
}

template <int D>
void StepSystem<D>::addPairBlocksToMatrix() {
  for (const auto& [pair, force, weight] : pairBlocks_.blocks()) {
    matrix_.addToDiagonal(pair.brickA, weight.template topLeftCorner<D, D>());
    matrix_.addToDiagonal(pair.brickB, weight.template bottomRightCorner<D, D>());
    const Block across = weight.template topRightCorner<D, D>();
    const bool isInOrder = pair.brickA < pair.brickB;
    matrix_.addToOffDiagonal(pair.edge, isInOrder ? across : Block(across.transpose()));
  }
}

template <int D>
void StepSystem<D>::addContactToMatrix(const ContactRow<D>& row) {
  PairOnGraph pair{row.contact.brickA, row.contact.brickB};
  if (pair.hasEdge()) pair.edge = graph_.edgeOf(pair.brickA, pair.brickB);
  if (row.active) addRowsToMatrix<1>(pair, row.normalA, row.normalB, rho_);
  if (!row.hasFriction()) return;
  const typename ContactRow<D>::TangentMatrix weight = rho_ * row.slipStiffness;
  addRowsToMatrix<ContactRow<D>::kTangents>(pair, row.tangentA, row.tangentB, weight);
}

template <int D>
bool StepSystem<D>::factor(const std::vector<ContactRow<D>>& contacts) {
  for (const ContactRow<D>& row : contacts) {
    const PairOnGraph pair{row.contact.brickA, row.contact.brickB};
    if (row.acts() && pair.hasEdge()) graph_.edgeOf(pair.brickA, pair.brickB);
  }
  if (graph_.hasGrown()) matrix_.analyze(brickCount(), graph_.edges());
  matrix_.setZero();
  for (int i = 0; i < brickCount(); ++i) matrix_.addToDiagonal(i, A_[i]);
  addJointsToMatrix();
  addSpringsToMatrix();
  addPairBlocksToMatrix();
  for (const ContactRow<D>& row : contacts) {
    if (row.acts()) addContactToMatrix(row);
  }
  ++cost_.factorizations;
  cost_.work +=
      matrix_.work() + kWorkOfBrick * brickCount() +
      kWorkOfRow * static_cast<double>(jointRows_.size() + springs_.size() + contacts.size());
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
double StepSystem<D>::workAgainst(const std::vector<brick::Load>& loads, const Vector& first,
                                  const Vector& further) const {
  double work = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector move = further.segment<D>(D * i);
    const typename Space::Vector middle = first.segment<D>(D * i) + 0.5 * move;
    work -=
        move.dot(Space::restrict(loads[i].force) - Space::restrict(loads[i].stiffness) * middle);
  }
  springs_.addWorkAgainst(first, further, work);
  return work + pairBlocks_.energyAfter(first + further) - pairBlocks_.energyAfter(first);
}

template <int D>
double StepSystem<D>::dampedBySprings(double step, const Vector& x) const {
  return springs_.damped(step, x);
}

/// A x without pair blocks.
template <int D>
Eigen::VectorXd StepSystem<D>::ownTimesA(const Vector& x) const {
  Vector result(x.size());
  for (int i = 0; i < brickCount(); ++i) {
    result.segment<D>(D * i) = A_[i] * x.segment<D>(D * i);
  }
  springs_.addProduct(x, result);
  return result;
}

template <int D>
Eigen::VectorXd StepSystem<D>::timesA(const Vector& x) const {
  Vector result = ownTimesA(x);
  pairBlocks_.addProduct(x, result);
  return result;
}

template <int D>
double StepSystem<D>::largestSpeed(const Vector& x) const {
  double largest = 0;
  for (int i = 0; i < brickCount(); ++i) {
    const Velocity velocity = Space::unpack(x.template segment<D>(D * i));
    largest = std::max({largest, velocity.linear.norm(), lengthScale_ * velocity.angular.norm()});
  }
  return largest;
}

template <int D>
Eigen::VectorXd StepSystem<D>::jointVelocity(const Vector& u) const {
  constexpr int kRows = Space::kJointRows;
  Vector result(jointRowCount());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    auto speed = result.segment<kRows>(kRows * p);
    speed.noalias() = jointRows_[p].a * u.segment<D>(D * pivots_[p].brickA);
    speed.noalias() += jointRows_[p].b * u.segment<D>(D * pivots_[p].brickB);
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
    const brick::Pivot& pivot = pivots_[p];
    const Vector3 between = poses[pivot.brickA].position - poses[pivot.brickB].position +
                            turns[pivot.brickA] * pivot.pointA - turns[pivot.brickB] * pivot.pointB;
    result.segment<kRows>(kRows * p) = Space::gap(brick::pivotRows(pivot, between).gaps);
  }
  return result;
}

template <int D>
double StepSystem<D>::largestOfPivots(const Vector& rows) {
  if (rows.size() == 0) return 0;
  return rows.reshaped(Space::kJointRows, Eigen::AutoSize).colwise().norm().maxCoeff();
}

template class StepSystem<3>;
template class StepSystem<6>;

// ------------------------------------------------------------------------------------------------
// The method of multipliers for
//   min 1/2 x^T A x - f^T x   with   J x = 0,   c_i x >= b_i,   |t_i x| bounded by friction.
// With multipliers l of the joints, p of the contacts and s of their slip, a round minimises
//   1/2 x^T A x - f^T x - l^T J x + kappa/2 |J x|^2
//     + sum_i max(0, p_i - rho (c_i x - b_i))^2 / (2 rho) + the same for the slip, limited to its
//     bound,
// which is convex and piecewise quadratic: the pushing and slipping contacts determine the piece.
// Newton's method is exact within a piece. It takes whole steps, and a line search only if whole
// steps cycle (semismooth Newton). Then the multipliers become
//   l - kappa J x,   p = max(0, p - rho (c x - b)),   s the same,
// and the next round begins. If kappa and rho are large compared with A, a round gains about ten
// digits. Rockafellar, "Augmented Lagrange multiplier functions and duality in nonconvex
// programming", 1974; Qi and Sun, "A nonsmooth version of Newton's method", 1993.

namespace {

constexpr double kNewtonTolerance = 1e-7;  // relative Newton step; rounding is 1e-10 to 1e-8
constexpr int kPieceRounds = 60;
constexpr int kBoldRounds = 8;  // whole steps at first: most often they settle the contacts' states
constexpr int kSearchRounds = 30;

/// Derivative of the augmented Lagrangian at x, apart from the contacts' normals.
template <int D>
Eigen::VectorXd smoothGradient(const StepSystem<D>& system, const StepProgram<D>& program,
                               const Eigen::VectorXd& x) {
  Eigen::VectorXd result = system.timesA(x) - program.force;
  const Eigen::VectorXd impulse = program.multipliers - system.kappa() * system.jointVelocity(x);
  system.addJointImpulse(-1.0, impulse, result);
  for (const ContactRow<D>& row : program.contacts) {
    if (row.hasFriction()) row.addTangent(-row.trialSlipImpulse(x, system.rho(), nullptr), result);
  }
  return result;
}

/// Derivative of the augmented Lagrangian at x.
template <int D>
Eigen::VectorXd gradient(const StepSystem<D>& system, const StepProgram<D>& program,
                         const Eigen::VectorXd& x) {
  Eigen::VectorXd result = smoothGradient(system, program, x);
  for (const ContactRow<D>& row : program.contacts) {
    const double normal = row.trialImpulse(x, system.rho());
    if (normal > 0) row.addNormal(-normal, result);
  }
  return result;
}

/// The same of the quadratic piece in which the contacts are in the states that they have: where x
/// is on another piece, a whole step from it still reaches this one's minimum.
template <int D>
Eigen::VectorXd gradientOfPiece(const StepSystem<D>& system, const StepProgram<D>& program) {
  Eigen::VectorXd result = smoothGradient(system, program, program.x);
  for (const ContactRow<D>& row : program.contacts) {
    if (row.active) row.addNormal(-row.pushingImpulse(program.x, system.rho()), result);
  }
  return result;
}

/// A step length at which the convex function no longer falls steeply along dx: the whole step, or
/// near where its slope changes sign.
template <int D>
double lineSearch(const StepSystem<D>& system, const StepProgram<D>& program,
                  const Eigen::VectorXd& dx, double firstSlope) {
  double low = 0;
  double high = 1;
  double length = 1;
  for (int round = 0; round < kSearchRounds; ++round) {
    const double slope = gradient<D>(system, program, program.x + length * dx).dot(dx);
    const bool uphill = slope > -0.1 * firstSlope;
    if (!uphill && (length == 1.0 || slope >= 0.5 * firstSlope)) return length;
    (uphill ? high : low) = length;
    length = 0.5 * (low + high);
  }
  return length;
}

/// Sets which contacts push and how they slip at x. Returns whether any state changed.
template <int D>
bool setContactStates(StepProgram<D>& program, double rho) {
  bool changed = setSlipStates(program, rho);
  for (ContactRow<D>& row : program.contacts) {
    const bool active = row.trialImpulse(program.x, rho) > 0;
    changed = changed || active != row.active;
    row.active = active;
  }
  return changed;
}

// Newton's method on the pieces: whole steps at first, then with a line search.
template <int D>
RoundReport minimize(StepSystem<D>& system, StepProgram<D>& program, double slow) {
  for (int round = 0; round < kPieceRounds; ++round) {
    const Eigen::VectorXd slope = gradientOfPiece(system, program);
    Eigen::VectorXd dx = -slope;
    system.solveInPlace(dx);
    // Close to the minimum the slope along dx is lost in rounding, and a whole step is right.
    const double speed = std::max(system.largestSpeed(program.x), slow);
    const double change = system.largestSpeed(dx);
    const bool smooth = program.contacts.empty() || change <= kNewtonTolerance * speed;
    const bool bold = smooth || round < kBoldRounds;
    const double length = bold ? 1.0 : lineSearch(system, program, dx, slope.dot(dx));
    program.x += length * dx;
    // Rounding may change the states of jammed bricks in every round.
    if (smooth && (!program.settlesSlowContacts || round >= kBoldRounds)) return {true, change, 0};
    // While no contact changes state the function is quadratic and a whole step is its minimum.
    const bool changed = setContactStates(program, system.rho());
    if (!changed && length == 1.0) return {true, change, 0};
    if (changed && !system.factor(program.contacts)) break;
  }
  return {};
}

}  // namespace

template <int D>
bool setSlipStates(StepProgram<D>& program, double rho) {
  bool changed = false;
  for (ContactRow<D>& row : program.contacts) {
    if (!row.hasFriction()) continue;
    typename ContactRow<D>::TangentMatrix stiffness;
    row.trialSlipImpulse(program.x, rho, &stiffness);
    changed = changed || stiffness != row.slipStiffness;
    row.slipStiffness = stiffness;
  }
  return changed;
}

template <int D>
RoundReport solveRound(StepSystem<D>& system, StepProgram<D>& program, double slow) {
  RoundReport report = minimize(system, program, slow);
  if (!report.found) return report;
  if (program.exactJoints && system.hasJoints()) {
    const Eigen::VectorXd speeds = system.jointVelocity(program.x);
    program.multipliers -= system.kappa() * speeds;
    report.jointSpeed = StepSystem<D>::largestOfPivots(speeds);
  }
  double& change = report.contactChange;
  for (ContactRow<D>& row : program.contacts) {
    const double normal = row.trialImpulse(program.x, system.rho());
    change = std::max(change, std::abs(normal - row.multiplier) / system.rho());
    row.multiplier = normal;
    if (!row.hasFriction()) continue;
    const auto slip = row.trialSlipImpulse(program.x, system.rho(), nullptr);
    change = std::max(change, (slip - row.slipMultiplier).norm() / system.rho());
    row.slipMultiplier = slip;
  }
  return report;
}

template bool setSlipStates<3>(StepProgram<3>&, double);
template bool setSlipStates<6>(StepProgram<6>&, double);
template RoundReport solveRound<3>(StepSystem<3>&, StepProgram<3>&, double);
template RoundReport solveRound<6>(StepSystem<6>&, StepProgram<6>&, double);

}  // namespace kirireel::mechanics
