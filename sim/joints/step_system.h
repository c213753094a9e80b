/// One implicit step of the joined bricks as a linear system, and its factor.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/brick/load.h"
#include "sim/joints/block_cholesky.h"
#include "sim/joints/contact_rows.h"
#include "sim/joints/coordinates.h"
#include "sim/joints/ligament_blocks.h"

namespace kirireel {

/// The matrices of one step in D degrees of freedom a brick:
///   A = M + h D + h^2 K + S^T W S,   f = M u0 + h F + h S^T m,   joint rows J, contact rows C,
///   H = A + kappa J^T J + rho C^T C (over the contacts that act),
/// with the blocks of ligaments added to A and f (LigamentBlocks), on the graph of bricks that
/// share a joint, a ligament, or have touched. S has a row for each hinge with a spring, the rate
/// of its angle; m are the springs' moments at the start of the step, and W = h^2 k + h c their
/// stiffness and damping. About the axis of a closed hinge the rate is exact.
template <int D>
class StepSystem {
 public:
  using Space = Coordinates<D>;
  using Block = typename Space::Block;
  using RowVector = typename Space::RowVector;
  using Vector = Eigen::VectorXd;

  /// `lengthScale` in metres makes turning and moving comparable. `springs` are at hinges of the
  /// pivots.
  StepSystem(const std::vector<Brick>& bricks, std::span<const Pivot> pivots, double lengthScale,
             std::vector<HingeSpring> springs = {}, std::vector<Ligament> ligaments = {});

  int brickCount() const { return static_cast<int>(bricks_.size()); }
  int jointRowCount() const { return Space::kJointRows * static_cast<int>(pivots_.size()); }
  bool hasJoints() const { return !pivots_.empty(); }

  /// Holds these bricks where they are from now on: to a joint they are the world. One entry a
  /// brick.
  void setPinned(std::vector<bool> pinned) { pinned_ = std::move(pinned); }

  /// Sets A and f from the motion at the start of a step, but for ligaments. `jointStiffness` in
  /// N/m makes the joints springs: kappa = h^2 k; infinity makes them exact.
  void setStep(const Motion& motion, const std::vector<Load>& loads, double step,
               double jointStiffness);
  bool hasLigaments() const { return !ligaments_.empty(); }
  /// Sets the ligaments' part of A and f, about velocities x of the step.
  void setLigamentsAbout(const Vector& x, LigamentBlocks::Curvature curvature);
  /// What the step minimises, the ligaments' own energy in the place of their blocks, for
  /// velocities x, joules.
  double potential(double step, const Vector& x) const;
  /// Sets A = M alone, f = 0: for closing an open state.
  void setMasses(const Poses& poses);
  /// Sets the joint rows at these poses.
  void placeJoints(const Poses& poses);

  /// Factors H for the contacts' present states. Returns false when that fails.
  /// Contacts between bricks that never touched before make a new plan. Costs O(n^1.2) for planar
  /// sheets of n tiles and about O(n^1.4) in space, as measured from 100 to 10,000 tiles.
  bool factor(const std::vector<ContactRow<D>>& contacts);
  void solveInPlace(Vector& right) const { matrix_.solveInPlace(right); }

  /// Of bricks at these poses that move with velocities x, joules.
  double kineticEnergy(const Poses& poses, const Vector& x) const;
  /// What a further displacement costs against the loads, the hinges' springs as they were set
  /// last, and the ligaments, after a first one, joules.
  double workAgainst(const std::vector<Load>& loads, const Vector& first,
                     const Vector& further) const;
  /// What the hinges' dashpots take in a step with velocities x, joules.
  double dampedBySprings(double step, const Vector& x) const;
  /// A x.
  Vector timesA(const Vector& x) const;
  /// f.
  const Vector& force() const { return f_; }
  /// The largest component of a velocity of all bricks, turns counted at one length scale, m/s.
  double largestSpeed(const Vector& x) const;
  /// J u.
  Vector jointVelocity(const Vector& u) const;
  /// Adds scale * J^T multipliers.
  void addJointImpulse(double scale, const Vector& multipliers, Vector& to) const;
  /// The gaps of all joint rows at these poses, metres.
  /// Of links the difference of length, in their first row.
  Vector jointGaps(const Poses& poses) const;

  double kappa() const { return kappa_; }
  double rho() const { return rho_; }
  int factorizations() const { return factorizations_; }
  /// What they cost so far, in multiplications with an addition: counted, not measured.
  double work() const { return work_; }

  /// The graph: which bricks have touched decides the order of elimination, and so the rounding.
  void transfer(StateTape& tape);

 private:
  /// The two bricks of a pivot, as an edge of the graph.
  struct JointRows {
    int edge = 0;
    typename Space::Rows a, b;
  };

  /// The spring of a hinge in the step at hand.
  struct SpringRow {
    int edge = 0;
    RowVector a, b;     // the rate of its angle
    double moment = 0;  // at the start of the step, N m
    double weight = 0;  // of the row in A
  };

  void keepLengthwiseRow(const Pivot& pivot, const Poses& poses, JointRows& rows);
  void placeSpring(const HingeSpring& spring, const Poses& poses, SpringRow& row) const;
  void setSprings(const Poses& poses, double step);
  double springRate(std::size_t spring, const Vector& x) const;
  /// Two bricks, the second perhaps kFixed, and their edge of the graph.
  struct PairOnGraph {
    int brickA = 0;
    int brickB = 0;
    int edge = 0;
  };

  Vector ownTimesA(const Vector& x) const;
  int edgeOf(int brickA, int brickB);
  template <int kRows>
  void addRowsToMatrix(const PairOnGraph& pair, const Eigen::Matrix<double, kRows, D>& a,
                       const Eigen::Matrix<double, kRows, D>& b, double weight);
  void addJointsToMatrix();
  void addSpringsToMatrix();
  void addLigamentsToMatrix();
  void addContactToMatrix(const ContactRow<D>& row);

  const std::vector<Brick>& bricks_;
  double lengthScale_;
  std::vector<Pivot> pivots_;
  std::vector<bool> pinned_;
  std::vector<std::pair<int, int>>
      edges_;  // sorted pairs; joints first, then contacts as they come
  std::vector<std::vector<std::pair<int, int>>> edgesAt_;  // of the lower brick: (higher, edge)
  bool graphChanged_ = true;
  std::vector<JointRows> jointRows_;
  std::vector<HingeSpring> springs_;
  std::vector<SpringRow> springRows_;  // without weight while only masses count
  LigamentBlocks ligaments_;           // likewise
  std::vector<int> ligamentEdges_;
  Vector ownForce_;  // f without ligaments
  std::vector<Block, Eigen::aligned_allocator<Block>> A_;
  Vector f_;
  double kappa_ = 0;
  double rho_ = 0;
  int factorizations_ = 0;
  double work_ = 0;
  BlockCholesky<D> matrix_;
};

extern template class StepSystem<3>;
extern template class StepSystem<6>;

}  // namespace kirireel
