/// `--solver direct`: exact joints.
#pragma once

#include "sim/deploy/dynamics.h"
#include "sim/world/contact_finder.h"

namespace kirireel {

/// The direct joint solver with implicit loads, and the contacts that the scene needs.
class DirectDynamics : public Dynamics {
 public:
  /// Throws InputError for a planar scene with obstacles, for a tile that lies in an obstacle at
  /// the start, and for springs or ligaments that the scene cannot have. `bricks` may end with the
  /// call.
  DirectDynamics(const Scene& scene, const Needs& needs, const std::vector<Brick>& bricks,
                 const Poses& start);

  bool assemble(Poses& poses) override;
  void fitVelocities(Motion& motion) override;
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double stiffness) override { solver_->setJointStiffness(stiffness); }
  double jointStiffness() const override { return solver_->jointStiffness(); }
  std::vector<Hold> contacts(const Poses& poses) const override;
  std::vector<std::string> loadedContacts() const override;
  StepReport advance(Motion& motion, double step, const LoadSource& actuation) override;
  void setTolerance(const TimeTolerance& tolerance) override;
  StepReport advanceToTolerance(Motion& motion, double seconds,
                                const TimedLoads& actuation) override;
  std::span<const PassedState> passed() const override { return passed_; }
  void transfer(StateTape& tape) override;

 private:
  bool hasObstacles() const { return !obstacles_.empty(); }
  void appendObstacles(Poses& poses) const;
  void leaveObstacles(Motion& motion) const;
  std::string nameOf(const ContactLoad& load) const;
  /// A step that was not taken, because bricks meet in it.
  struct Meeting {
    Motion from;
    Motion to;
    double seconds = 0;
    std::vector<Contact> contacts;  // that are violated at its end, whole planes of them
  };

  TimedLoads allLoads(const TimedLoads& actuation) const;
  ContactFinder& exactFinder() { return exactContacts_ ? *exactContacts_ : *contacts_; }
  bool meetOnTheWay(const Motion& from, const Motion& to, double seconds);
  std::optional<double> momentOfImpact() const;
  void setHeld(std::vector<Contact> contacts);
  void holdTouching(const Poses& poses);
  double collide(double now, const std::vector<Contact>& closing, Motion& motion);
  double advanceByOrders(Motion& motion, double seconds, const TimedLoads& loads,
                         StepReport& report);
  StepReport goOnByFirstOrder(Motion& motion, double begin, double end, const TimedLoads& loads);

  std::size_t brickCount_;
  int countsFrom_;           // the first tile, in messages
  double tileSize_;          // metres
  double contactTolerance_;  // overlap that counts as none, metres
  Environment environment_;
  std::vector<ObstaclePart> obstacles_;
  std::vector<Brick> bodies_;  // the bricks, then pinned ones that stand for obstacles
  std::unique_ptr<JointSolver> solver_;
  std::unique_ptr<ContactFinder> contacts_;  // null where nothing can be touched
  int substeps_;
  bool keepsEnergy_;                              // to a tolerance in time
  bool isRubbing_;                                // planar bricks on a ground with friction
  bool isPinned_ = false;                         // some brick
  std::unique_ptr<Extrapolation> extrapolation_;  // null where no tolerance is asked for
  double firstOrderStep_ = 0;                     // seconds, with it
  double touching_ = 0;                           // gap of points that touch, metres
  std::unique_ptr<ContactFinder>
      exactContacts_;               // the same, finer; null without a tolerance in time
  std::optional<Meeting> meeting_;  // of the step that was tried last
  int callsToWait_ = 0;             // by first order, after impacts crowded
  std::vector<PassedState> passed_;
};

}  // namespace kirireel
