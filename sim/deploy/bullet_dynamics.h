/// `--solver bullet`: the baseline.
#pragma once

#include "sim/deploy/dynamics.h"
#include "sim/world/bullet_world.h"

namespace kirireel {

/// Bullet's sequential impulses, with the actuation taken anew in each substep.
class BulletDynamics : public Dynamics {
 public:
  BulletDynamics(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start);

  void assemble(Poses& /*poses*/) override {}  // Bullet pulls open joints together as it goes
  void setPinned(const std::vector<bool>& pinned) override;
  void setJointStiffness(double /*stiffness*/) override {}  // they give as it is
  StepReport advance(Motion& motion, double step, const LoadSource& actuation) override;

 private:
  BulletWorld world_;
  int substeps_;
  std::vector<Load> loads_;
};

}  // namespace kirireel
