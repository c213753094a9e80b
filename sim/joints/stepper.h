/// The direct solver's step, in two parts: joint_solver.cpp finds velocities, joint_closing.cpp
/// closes joints.
#pragma once

#include <limits>
#include <vector>

#include "sim/joints/joint_solver.h"
#include "sim/joints/standstill.h"
#include "sim/joints/step_program.h"

namespace kirireel {

/// How a step went that was tried.
enum class StepOutcome { Good, JointsOpen, Overlapping };

/// The joint solver in D degrees of freedom a brick.
/// The functions are described where they are defined; they stand here in the order of a step.
template <int D>
class Stepper : public JointSolver {
 public:
  Stepper(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
          const JointSolverSettings& settings)
      : bricks_(bricks),
        settings_(settings),
        system_(bricks, pivots, settings.lengthScale, settings.hingeSprings, settings.ligaments),
        loads_(bricks.size()) {
    program_.multipliers = Vector::Zero(system_.jointRowCount());
    program_.x = Vector::Zero(D * bricks.size());
    pinned_.assign(bricks.size(), false);
  }

  StepReport advance(Motion& motion, double step, const LoadSource& loads,
                     ContactSource* contacts) override;
  void holdContacts(const std::vector<Contact>& contacts) override;
  std::vector<Contact> heldContacts() const override;
  StepReport eulerStep(Motion& motion, double step, const LoadSource& loads,
                       LoadGain& given) override;
  double energy(const Motion& motion) const override;
  double caughtSpeed(const Motion& start) const override;
  double project(Motion& motion) override;
  bool collide(Motion& motion) override;
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double stiffness) override;
  std::vector<ContactLoad> contactLoads() const override;
  std::vector<TouchForce> touchForces(const Poses& poses) const override;
  double jointStiffness() const override { return jointStiffness_; }
  double assemble(Poses& poses) override;
  void transfer(StateTape& tape) override;

 private:
  using Space = Coordinates<D>;
  using Vector = Eigen::VectorXd;
  using Row = ContactRow<D>;

  void advanceHalving(Motion& motion, double step, int level, bool warm);
  void beginStep(const Motion& start, double step);
  void placeHeldRows(const Poses& poses, double step);
  void keepHeldRows(double step);
  bool solveWithFriction(const Poses& start);
  bool boundFriction();
  bool projectVelocities(Motion& motion, bool withFriction);
  bool factorMasses(std::vector<Row>& held);
  double closeGaps(Poses& poses, std::vector<Row> held);
  double largestGap(const Vector& gaps, const std::vector<Row>& held) const;
  void countLosses(double step);
  void addGain(const Poses& poses, double step, LoadGain& given) const;
  StepOutcome tryStep(const Motion& start, double step, bool warm);
  StepOutcome solveContactRounds(const Poses& start, double step);
  bool appendRows(const std::vector<Contact>& found, const Poses& start, double step);
  bool boundNewFriction();
  void startRows(const Poses& start, double step, bool warm);
  void takeOver(const Row& old, const Poses& start, double step);
  void addSupports(const Poses& poses, double step);
  Row contactRow(const Contact& contact, const Poses& start, double step) const;
  void holdPinned(Row& row) const;
  bool solveVelocities(const Poses& start);
  bool solveWithLigaments(const Poses& start, double step);
  void forbidWork();
  bool moveAndClose(const Poses& start, double step);
  void payForClosing(const Poses& start, double step);
  void standStill(const Poses& start);
  bool closeJoints(const std::vector<Row>& contacts, double step);
  Vector closingMove(const Vector& gaps, const std::vector<Row>& contacts, bool withOverlaps) const;
  Vector foreseen(const Vector& move, const Vector& lastMove) const;
  double overlap(const Row& row) const;
  bool anyOverlap(const std::vector<Row>& contacts) const;
  void displace(const Vector& move);
  double product(const Vector& a, const Vector& b) const;
  double norm(const Vector& move) const;
  void finishStep(Motion& motion) const;
  void keepMultipliers(double step);

  const std::vector<Brick>& bricks_;
  JointSolverSettings settings_;
  StepSystem<D> system_;
  const LoadSource* loadSource_ = nullptr;
  ContactSource* contactSource_ = nullptr;
  double jointStiffness_ = std::numeric_limits<double>::infinity();
  StepReport report_;
  std::vector<bool> pinned_;

  // The step in work.
  std::vector<Load> loads_;
  bool isShortest_ = false;  // it will not be halved, and jumps are taken
  bool jumped_ = false;      // closing moved more than it should
  Poses poses_;              // at its end
  Vector startSpeed_;        // velocities where it starts
  Vector closing_;           // what closing added to the move
  StepProgram<D> program_;   // for its velocities; joint multipliers are warm from step to step
  std::vector<Row> kept_;    // held contacts, or planes of those that carried load in the last step
  std::vector<Row> supports_;  // likewise
  double multiplierStep_ = 1;  // seconds that the joints' multipliers refer to
  double keptStep_ = 1;        // seconds that these rows' impulses refer to
  Standstill standstill_;
};

}  // namespace kirireel
