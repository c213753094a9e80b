/// Bricks in the world of a physics engine: the baselines.
#pragma once

#include "sim/deploy/dynamics.h"
#include "sim/world/brick_world.h"

namespace kirireel {

/// An engine's own solver in short substeps, with the actuation taken anew in each.
class WorldDynamics : public Dynamics {
 public:
  /// `substeps` of the engine in each step.
  WorldDynamics(std::unique_ptr<BrickWorld> world, int substeps, std::size_t brickCount);

  bool assemble(Poses& /*poses*/) override {
    return true;  // engines pull open joints together as they go
  }
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double /*stiffness*/) override {}         // they give as it is
  double jointStiffness() const override { return kExactJoints; }  // as far as engines tell
  std::vector<Hold> contacts(const Poses& /*poses*/) const override { return {}; }
  std::vector<std::string> loadedContacts() const override { return {}; }
  StepReport advance(Motion& motion, double step, const LoadSource& actuation) override;
  void setTolerance(const TimeTolerance& /*tolerance*/) override {}  // engines step by fixed steps
  StepReport advanceToTolerance(Motion& motion, double seconds,
                                const TimedLoads& actuation) override;
  std::span<const PassedState> passed() const override { return {}; }
  void transfer(StateTape& /*tape*/) override {}

 private:
  std::unique_ptr<BrickWorld> world_;
  int substeps_;
  std::vector<Load> loads_;
};

/// `--solver bullet`: Bullet's sequential impulses.
/// Throws InputError for links and obstacles.
std::unique_ptr<Dynamics> makeBulletDynamics(const Scene& scene, const std::vector<Brick>& bricks,
                                             const Poses& start);

}  // namespace kirireel
