/// One implicit step of joined bricks: its rows, its linear system and its quadratic program.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/brick/hinge.h"
#include "sim/brick/pair_force.h"
#include "sim/mechanics/block_cholesky.h"

namespace kirireel::mechanics {

// ------------------------------------------------------------------------------------------------
// The degrees of freedom of one brick: six in space, three in the plane.

/// D = 6: translation and rotation vector. D = 3: x, y and the turn about z. The solver is written
/// once for both; D decides at compile time. Vectors of all bricks hold D numbers per brick, brick
/// by brick: metres (or m/s) first, then radians (or rad/s).
template <int D>
struct Coordinates {
  static_assert(D == 3 || D == 6);
  static constexpr int kJointRows = D == 6 ? 3 : 2;  ///< a pivot is closed by this many rows

  /// One number per coordinate.
  using Vector = Eigen::Matrix<double, D, 1>;
  /// A matrix by the coordinates of one brick, or of two.
  using Block = Eigen::Matrix<double, D, D>;
  /// The rows of a pivot.
  using Rows = Eigen::Matrix<double, kJointRows, D>;
  /// One row.
  using RowVector = Eigen::Matrix<double, 1, D>;
  /// The gap of a pivot, metres.
  using Gap = Eigen::Matrix<double, kJointRows, 1>;

  /// Whether coordinate k of a brick is a rotation.
  static constexpr bool isTurn(int k) { return D == 6 ? k >= 3 : k == 2; }

  /// A force and torque, or a velocity, in these coordinates. D = 3 drops components out of the
  /// plane.
  static Vector restrict(const Vector6& v) {
    if constexpr (D == 6)
      return v;
    else
      return {v[0], v[1], v[5]};
  }

  /// The same for a matrix: rows and columns 0, 1 and 5.
  static Block restrict(const Matrix6& m) {
    if constexpr (D == 6) {
      return m;
    } else {
      constexpr std::array<int, D> kKept = {0, 1, 5};
      Block block;
      for (int column = 0; column < D; ++column) {
        for (int row = 0; row < D; ++row)
          block.coeffRef(row, column) = m.coeff(kKept[row], kKept[column]);
      }
      return block;
    }
  }

  /// Inertia of a brick in world axes: its mass, its inertia about the centre of mass in its own
  /// axes, and their rotation.
  static Block inertia(double mass, const Matrix3& ownInertia, const Matrix3& rotation) {
    Block block = Block::Zero();
    if constexpr (D == 6) {
      block.template topLeftCorner<3, 3>().diagonal().setConstant(mass);
      block.template bottomRightCorner<3, 3>() = rotation * ownInertia * rotation.transpose();
    } else {
      block.diagonal() << mass, mass, rotation.row(2).dot(ownInertia * rotation.row(2).transpose());
    }
    return block;
  }

  /// Velocity of a point with arm r (world axes) from the centre of mass, by the brick's velocity.
  static Rows pointVelocity(const Vector3& r) {
    Rows rows;
    if constexpr (D == 6) {
      rows << Matrix3::Identity(), -crossMatrix(r);
    } else {
      rows << 1, 0, -r.y(), 0, 1, r.x();
    }
    return rows;
  }

  /// Velocity of that point along a direction.
  static RowVector pointVelocity(const Vector3& r, const Vector3& direction) {
    const Vector3 turning = r.cross(direction);
    RowVector row;
    if constexpr (D == 6) {
      row << direction.transpose(), turning.transpose();
    } else {
      row << direction.x(), direction.y(), turning.z();
    }
    return row;
  }

  /// The row of the angular velocity about a vector.
  static RowVector turning(const Vector3& vector) {
    RowVector row = RowVector::Zero();
    if constexpr (D == 6) {
      row.template tail<3>() = vector.transpose();
    } else {
      row[2] = vector.z();
    }
    return row;
  }

  /// The components of a difference of two points that joint rows have, metres.
  static Gap gap(const Vector3& difference) { return difference.head<kJointRows>(); }

  /// Packs one brick's velocity; D = 3 drops the components out of the plane.
  static Vector pack(const Velocity& velocity) {
    if constexpr (D == 6) {
      Vector packed;
      packed << velocity.linear, velocity.angular;
      return packed;
    } else {
      return {velocity.linear.x(), velocity.linear.y(), velocity.angular.z()};
    }
  }

  /// A brick's velocity. Components out of the plane are 0 for D = 3.
  static Velocity unpack(const Vector& packed) {
    if constexpr (D == 6) {
      return {packed.template head<3>(), packed.template tail<3>()};
    } else {
      return {Vector3(packed[0], packed[1], 0), Vector3(0, 0, packed[2])};
    }
  }

  /// Moves a pose by a displacement in these coordinates.
  static void displace(Pose& pose, const Vector& displacement) {
    const Velocity move = unpack(displacement);
    pose.position += move.linear;
    pose.rotation = (turnBy(move.angular) * pose.rotation).normalized();
  }

 private:
  /// The rotation by this vector. Uses the series for small angles, where it is exact to rounding.
  static Quaternion turnBy(const Vector3& vector) {
    constexpr double kTinyTurn = 1e-4;
    const double square = vector.squaredNorm();
    if (square > kTinyTurn * kTinyTurn) return rotationFromVector(vector);
    const Vector3 imaginary = (0.5 - square / 48) * vector;
    return {1 - square / 8, imaginary.x(), imaginary.y(), imaginary.z()};
  }
};

// ------------------------------------------------------------------------------------------------
// The contacts of one step as rows of the step's system: normal rows that may only push, tangential
// rows that slip beyond Coulomb's bound.

/// One point contact, or one support of a planar scene, in D degrees of freedom per brick.
///
/// Normal: w = row u with w + bias >= 0 and multiplier >= 0, one of them zero. Tangential: the
/// multiplier opposes sliding, and its length is at most slipBound. slipBound is friction times the
/// normal multiplier of the previous step (lagged), which keeps each step convex.
template <int D>
struct ContactRow {
  static constexpr int kTangents = 2;  ///< the second is vertical, hence zero, for planar contacts
  /// The row's part for one brick.
  using RowVector = typename Coordinates<D>::RowVector;
  /// Two rows for one brick.
  using TangentRows = Eigen::Matrix<double, kTangents, D>;
  /// One number per tangent.
  using Tangent = Eigen::Matrix<double, kTangents, 1>;
  /// Two rows and columns, one per tangent.
  using TangentMatrix = Eigen::Matrix<double, kTangents, kTangents>;

  brick::Contact contact;  ///< as it was found
  bool hasNormal = true;   ///< false for rows with only friction
  /// The normal row's part for each brick: velocity along the normal by the brick's D velocities.
  /// Undefined for fixed bodies.
  RowVector normalA, normalB;
  /// Two rows for each brick, along two directions that span the contact's plane.
  TangentRows tangentA, tangentB;
  double bias = 0;        ///< gap / step, m/s; 0 if they overlap
  double aim = 0;         ///< target gap of a pushing contact when closing, metres
  double multiplier = 0;  ///< normal impulse, >= 0
  Tangent slipMultiplier = Tangent::Zero();  ///< tangential impulse on A
  double slipBound = 0;                      ///< largest tangential impulse
  /// For a friction row of a plane of contacts: its share of their normal force; else 0.
  double slipShare = 0;

  bool hasFrictionRows = false;  ///< first of a plane that has separate friction rows
  // The state of the current factor.
  bool active = false;                                  ///< whether the normal pushes
  TangentMatrix slipStiffness = TangentMatrix::Zero();  ///< times rho

  /// Velocity of A's point relative to B along the normal.
  double normalVelocity(const Eigen::VectorXd& u) const;
  /// The same along the tangents.
  Tangent slipVelocity(const Eigen::VectorXd& u) const;
  /// Adds scale * row^T to a vector of all bricks.
  void addNormal(double scale, Eigen::VectorXd& to) const;
  /// Adds (tangent rows)^T * scale.
  void addTangent(const Tangent& scale, Eigen::VectorXd& to) const;

  /// The normal impulse of the augmented Lagrangian at u for a contact that can push and pull.
  double pushingImpulse(const Eigen::VectorXd& u, double rho) const;
  /// The normal impulse of the augmented Lagrangian at u.
  double trialImpulse(const Eigen::VectorXd& u, double rho) const;
  /// The tangential impulse, cut to the bound; `stiffness` gets its negative derivative by the slip
  /// velocity, divided by rho.
  Tangent trialSlipImpulse(const Eigen::VectorXd& u, double rho, TangentMatrix* stiffness) const;
  /// Whether friction acts.
  bool hasFriction() const { return slipBound > 0; }
  /// Whether the contact has a force in its current state.
  bool acts() const { return active || hasFriction(); }

  /// State that the row of the next step needs from this one.
  void transfer(StateTape& tape) {
    tape.transfer(contact, hasNormal, multiplier, slipMultiplier, slipShare);
  }
};

/// The row of a contact at the start poses of a step of `step` seconds. The step may keep an
/// initial overlap, since removing it by a velocity would add energy. Closing reduces it by
/// `recovery` metres.
template <int D>
ContactRow<D> makeContactRow(const brick::Contact& contact, const Poses& poses, double step,
                             double recovery);

/// Sets the row's directions for its contact at these poses.
template <int D>
void placeRow(ContactRow<D>& row, const Poses& poses);

/// The end of the consecutive rows that belong to the same plane as the first.
template <int D, typename Iterator>
Iterator endOfPlane(Iterator first, Iterator end) {
  return std::find_if(first + 1, end, [&](const ContactRow<D>& row) {
    return !row.hasNormal || !brick::onOnePlane(first->contact, row.contact);
  });
}

// ------------------------------------------------------------------------------------------------
// The graph of the system of a step.

/// An edge for each pair of bricks that share a joint or a force, or have touched.
class BrickGraph {
 public:
  /// A graph of `bricks` nodes without edges.
  explicit BrickGraph(std::size_t bricks) : edgesAt_(bricks) {}

  /// The number of the edge between two bricks; makes it if it does not exist.
  int edgeOf(int brickA, int brickB);
  /// Sorted pairs, in the order in which they were made.
  const std::vector<std::pair<int, int>>& edges() const { return edges_; }
  /// Whether edges were added since the last call; true for the first call.
  bool hasGrown() { return std::exchange(hasGrown_, false); }

  /// The edges. Their order determines the order of elimination, and therefore the rounding.
  void transfer(StateTape& tape);

 private:
  std::vector<std::pair<int, int>> edges_;
  std::vector<std::vector<std::pair<int, int>>> edgesAt_;  // of the lower brick: (higher, edge)
  bool hasGrown_ = true;
};

/// Two bricks, or a brick and a fixed body (see brick::isBrick), and their edge of the graph.
struct PairOnGraph {
  int brickA = 0;  ///< its number, >= 0, or below 0
  int brickB = 0;  ///< the same
  int edge = 0;    ///< its number in the graph, if it exists

  /// Whether both move.
  bool hasEdge() const { return brick::isBrick(brickA) && brick::isBrick(brickB); }
};

// ------------------------------------------------------------------------------------------------
// Springs at hinges in a step.

/// The row of a spring in a step, the rate of its hinge's angle.
template <int D>
struct SpringRow {
  int edge = 0;                             ///< of its two bricks on the graph
  typename Coordinates<D>::RowVector a, b;  ///< for brick A, for brick B
  double moment = 0;                        ///< at the start of the step, N m
  double weight = 0;                        ///< of the row in A
};

/// The terms of hinge springs in a step: S, W and m of StepSystem. The rate about the axis of a
/// closed hinge is exact.
template <int D>
class SpringRows {
 public:
  /// One number per coordinate of all bricks.
  using Vector = Eigen::VectorXd;

  /// Of these springs, in their order; each pair becomes an edge of the graph.
  SpringRows(std::vector<brick::HingeSpring> springs, BrickGraph& graph);

  /// The number of springs.
  std::size_t size() const { return springs_.size(); }
  /// A spring by its number, >= 0.
  const brick::HingeSpring& spring(std::size_t s) const { return springs_[s]; }
  /// The row of a spring, by the same number.
  const SpringRow<D>& row(std::size_t s) const { return rows_[s]; }

  /// Sets the rows for a step of `step` seconds from these poses. `held`: one entry per brick; held
  /// bricks are fixed.
  void begin(const Poses& poses, double step, const std::vector<bool>& held);
  /// Removes all weights and moments.
  void clear();

  /// The rate of a hinge's angle at velocities x, rad/s.
  double rate(std::size_t s, const Vector& x) const;
  /// Adds h S^T m to f.
  void addForce(double step, Vector& f) const;
  /// Adds S^T W S x.
  void addProduct(const Vector& x, Vector& to) const;
  /// Adds the work against the springs of a displacement `further` after `first`, joules.
  void addWorkAgainst(const Vector& first, const Vector& further, double& work) const;
  /// Energy that the dashpots dissipate in a step with velocities x, joules.
  double damped(double step, const Vector& x) const;

 private:
  std::vector<brick::HingeSpring> springs_;
  std::vector<SpringRow<D>> rows_;
};

// ------------------------------------------------------------------------------------------------
// Pair forces in a step, except hinge springs: ligaments and others.

/// The energy E of such forces along a step of h seconds from poses q with velocities x, as a
/// quadratic function of x,
///   E(q + h x) ~ E + h g^T (x - x0) + h^2 (x - x0)^T K (x - x0) / 2,
/// about velocities x0. All terms belong to pairs of bricks and have the coordinates of both.
template <int D>
class PairBlocks {
 public:
  /// One number per coordinate of all bricks.
  using Vector = Eigen::VectorXd;
  /// One number per coordinate of a pair, brick A first.
  using PairVector = Eigen::Matrix<double, 2 * D, 1>;
  /// Rows and columns in the same order.
  using PairMatrix = Eigen::Matrix<double, 2 * D, 2 * D>;

  /// K: the second derivative, or only its positive part. With the latter every stationary point is
  /// a minimum, and Newton's steps reduce the energy. It has kinks at the buckling of a ligament,
  /// which reduce the order of extrapolated steps.
  enum class Curvature { Whole, Convex };

  /// Terms of one pair in a step.
  struct PairBlock {
    PairOnGraph pair;                        ///< its bricks, and their edge
    PairVector force = PairVector::Zero();   ///< to f: -h g + h^2 K x0, N s and N m s
    PairMatrix weight = PairMatrix::Zero();  ///< to A: h^2 K
  };

  /// `lengthScale` in metres makes rotations and translations comparable. Springs at hinges are
  /// omitted. Each pair becomes an edge of the graph.
  PairBlocks(const brick::PairForces& forces, double lengthScale, BrickGraph& graph);

  /// Whether there are no such forces.
  bool empty() const { return blocks_.empty(); }
  /// Force by force, pair by pair.
  const std::vector<PairBlock>& blocks() const { return blocks_; }

  /// Begins a step at these poses. Set its blocks next. `held`: one entry per brick; held bricks
  /// are fixed. `step` in seconds.
  void begin(const Poses& poses, double step, const std::vector<bool>& held);
  /// Sets the blocks about velocities x0.
  void setAbout(const Vector& x0, Curvature curvature);
  /// Removes all blocks.
  void clear();

  /// E after a displacement since begin(), joules.
  double energyAfter(const Vector& displacement) const;
  /// Adds the blocks' force to f.
  void addForce(Vector& f) const;
  /// Adds the product of the blocks' weights with x.
  void addProduct(const Vector& x, Vector& to) const;

 private:
  Poses posesAfter(const Vector& displacement) const;
  PairMatrix withoutNegative(const PairMatrix& matrix) const;
  void omitHeld(PairBlock& block) const;

  brick::PairForces forces_;
  double lengthScale_;
  std::vector<PairBlock> blocks_;  // force by force, pair by pair
  Poses start_;
  double step_ = 0;
  std::vector<bool> held_;
};

// ------------------------------------------------------------------------------------------------
// One implicit step of the joined bricks as a linear system, and its factor.

/// The rows of a pivot, and its bricks' edge of the graph.
template <int D>
struct JointRows {
  int edge = 0;                        ///< of its two bricks on the graph
  typename Coordinates<D>::Rows a, b;  ///< for brick A, for brick B
};

/// Total cost of factorisations.
struct FactorCost {
  int factorizations = 0;  ///< >= 0
  double work = 0;         ///< number of multiplications with an addition
};

/// The matrices of one step in D degrees of freedom per brick:
///   A = M + h D + h^2 K + S^T W S,   f = M u0 + h F + h S^T m,   joint rows J, contact rows C,
///   H = A + kappa J^T J + rho C^T C (over the contacts that act),
/// with the blocks of ligaments and other forces between pairs added to A and f (PairBlocks), on
/// the graph of bricks that share a joint or such a force, or have touched. S has a row for each
/// hinge with a spring, the rate of its angle; m are the springs' moments at the start of the step,
/// and W = h^2 k + h c their stiffness and damping. About the axis of a closed hinge the rate is
/// exact.
template <int D>
class StepSystem {
 public:
  /// The coordinates of a brick.
  using Space = Coordinates<D>;
  /// A matrix by those of one brick, or of two.
  using Block = typename Space::Block;
  /// One row for one brick.
  using RowVector = typename Space::RowVector;
  /// One number per coordinate of all bricks.
  using Vector = Eigen::VectorXd;

  /// `lengthScale` in metres makes rotations and translations comparable. Springs among
  /// `pairForces` are at hinges of the pivots; ligaments need D = 3.
  StepSystem(const std::vector<brick::Brick>& bricks, std::span<const brick::Pivot> pivots,
             double lengthScale, const brick::PairForces& pairForces = {});

  /// The number of bricks.
  int brickCount() const { return static_cast<int>(bricks_.size()); }
  /// The rows of all pivots together.
  int jointRowCount() const { return Space::kJointRows * static_cast<int>(pivots_.size()); }
  /// Pivots with rows. A planar scene has one for both faces.
  std::span<const brick::Pivot> pivots() const { return pivots_; }
  /// Omits from now on the rows of exact joints that other pivots of the same joint have, in space.
  /// The second pivot of a hinge keeps no row along the hinge, the third pivot of a fixed joint one
  /// row. All rows together are dependent while joints are closed, and only nearly dependent if
  /// they are open: the velocities that they then exclude are found only to a few digits.
  void omitRepeatedRows();
  /// Whether there is any pivot.
  bool hasJoints() const { return !pivots_.empty(); }

  /// Fixes these bricks from now on. One entry per brick.
  void setPinned(std::vector<bool> pinned) { pinned_ = std::move(pinned); }

  /// Sets A and f from the motion at the start of a step, without pair blocks. `jointStiffness` in
  /// N/m makes the joints springs: kappa = h^2 k; infinity makes them exact.
  void setStep(const Motion& motion, const std::vector<brick::Load>& loads, double step,
               double jointStiffness);
  /// Whether there are pair forces other than springs at hinges.
  bool hasPairBlocks() const { return !pairBlocks_.empty(); }
  /// Sets the pair blocks' part of A and f, about velocities x of the step.
  void setPairBlocksAbout(const Vector& x, typename PairBlocks<D>::Curvature curvature);
  /// The function that the step minimises, for velocities x, joules. It has the pairs' energy
  /// instead of their blocks.
  double potential(double step, const Vector& x) const;
  /// Sets A = M, f = 0: for closing an open state.
  void setMasses(const Poses& poses);
  /// Sets the joint rows at these poses.
  void placeJoints(const Poses& poses);

  /// Factors H for the contacts' current states. Returns false if that fails. A first contact of
  /// two bricks requires a new plan. Costs O(n^1.2) for planar sheets of n tiles and about O(n^1.4)
  /// in space, as measured from 100 to 10,000 tiles.
  bool factor(const std::vector<ContactRow<D>>& contacts);
  /// Replaces `right` by the solution of H x = right. Call factor() first.
  void solveInPlace(Vector& right) const { matrix_.solveInPlace(right); }

  /// Kinetic energy of bricks at these poses with velocities x, joules.
  double kineticEnergy(const Poses& poses, const Vector& x) const;
  /// Work of a displacement `further` after `first`, joules: against the loads, the hinge springs
  /// as last set, and the other pair forces.
  double workAgainst(const std::vector<brick::Load>& loads, const Vector& first,
                     const Vector& further) const;
  /// Energy that the hinges' dashpots dissipate in a step with velocities x, joules.
  double dampedBySprings(double step, const Vector& x) const;
  /// A x.
  Vector timesA(const Vector& x) const;
  /// f.
  const Vector& force() const { return f_; }
  /// The largest speed or angular speed of a brick, m/s. Rotations count times the length scale.
  double largestSpeed(const Vector& x) const;
  /// J u.
  Vector jointVelocity(const Vector& u) const;
  /// Adds scale * J^T multipliers.
  void addJointImpulse(double scale, const Vector& multipliers, Vector& to) const;
  /// The gaps of all joint rows at these poses, metres. For links, the first row has the difference
  /// of length.
  Vector jointGaps(const Poses& poses) const;
  /// The largest norm of the values of one pivot in joint rows. It is the same in all axes.
  static double largestOfPivots(const Vector& rows);

  /// The weight of joint rows in H, kg.
  double kappa() const { return kappa_; }
  /// The weight of contact rows in H, kg.
  double rho() const { return rho_; }
  /// Number of factorisations of H so far.
  int factorizations() const { return cost_.factorizations; }
  /// Their total cost, in counted multiplications with an addition.
  double work() const { return cost_.work; }

  /// The graph. Past contacts determine the order of elimination, and therefore the rounding.
  void transfer(StateTape& tape) { graph_.transfer(tape); }

 private:
  void omitRepeated(std::size_t pivot, const Matrix3& turnOfA, JointRows<D>& rows) const;
  void keepRows(const brick::Pivot& pivot, const Poses& poses, JointRows<D>& rows);
  Vector ownTimesA(const Vector& x) const;
  template <int kRows, typename Weight>
  void addRowsToMatrix(const PairOnGraph& pair, const Eigen::Matrix<double, kRows, D>& a,
                       const Eigen::Matrix<double, kRows, D>& b, const Weight& weight);
  void addJointsToMatrix();
  void addSpringsToMatrix();
  void addPairBlocksToMatrix();
  void addContactToMatrix(const ContactRow<D>& row);

  const std::vector<brick::Brick>& bricks_;
  double lengthScale_;
  std::vector<brick::Pivot> pivots_;
  std::vector<bool> pinned_;
  BrickGraph graph_;  // joints first, then contacts as they come
  std::vector<JointRows<D>> jointRows_;
  std::vector<Matrix3> repeated_;  // for each pivot, projector in brick A's axes; may be empty
  bool hasExactJoints_ = true;
  SpringRows<D> springs_;     // no weights while A = M
  PairBlocks<D> pairBlocks_;  // the same
  Vector ownForce_;           // f without pair blocks
  std::vector<Block, Eigen::aligned_allocator<Block>> A_;
  Vector f_;
  double kappa_ = 0;
  double rho_ = 0;
  FactorCost cost_;
  BlockCholesky<D> matrix_;
};

extern template class StepSystem<3>;
extern template class StepSystem<6>;

// ------------------------------------------------------------------------------------------------
// The quadratic program of both halves of a step: finding velocities, and closing joints.

/// Minimise 1/2 x^T A x - f^T x over velocities x with J x = 0, and with the contact rows'
/// inequalities and friction.
template <int D>
struct StepProgram {
  Eigen::VectorXd x;            ///< the start of the search, then its end
  Eigen::VectorXd force;        ///< f
  Eigen::VectorXd multipliers;  ///< of the joint rows
  bool exactJoints = true;      ///< or springs, with fixed multipliers
  /// Whether slow contacts change state too. Impulses are then exact for any normal speed.
  bool settlesSlowContacts = false;
  std::vector<ContactRow<D>> contacts;  ///< possible contacts
};

/// Residuals of a round of the method of multipliers.
struct RoundReport {
  bool found = false;        ///< whether the minimum for the current multipliers was found
  double change = 0;         ///< of x in the last Newton step, m/s
  double contactChange = 0;  ///< residual of the contact rows, m/s
  double jointSpeed = 0;     ///< the largest of a pivot in J x, m/s; exact joints only
};

/// One round: minimises the augmented Lagrangian for the current multipliers by semismooth Newton
/// (the contacts' states select the quadratic piece), then updates the multipliers. The system must
/// be factored for the contacts' states on entry. Tolerances are relative to the speed of x and to
/// `slow`, m/s. Costs one solve without contacts, and a factorisation for each change of the
/// contacts' states.
template <int D>
RoundReport solveRound(StepSystem<D>& system, StepProgram<D>& program, double slow);

/// Sets how the contacts slip at x. Returns whether any state changed.
template <int D>
bool setSlipStates(StepProgram<D>& program, double rho);

}  // namespace kirireel::mechanics
