/// `--solver direct`: exact joints.
#pragma once

#include "sim/deploy/dynamics.h"
#include "sim/world/contact_finder.h"

namespace kirireel {

/// The direct joint solver with implicit loads, and the contacts that the scene needs.
class DirectDynamics : public Dynamics {
 public:
  DirectDynamics(const Scene& scene, const Needs& needs, const std::vector<Brick>& bricks,
                 const Poses& start);

  void assemble(Poses& poses) override { solver_->assemble(poses); }
  void setPinned(const std::vector<bool>& pinned) override { solver_->setPinned(pinned); }
  void setJointStiffness(double stiffness) override { solver_->setJointStiffness(stiffness); }
  std::vector<ContactLoad> contactLoads() const override { return solver_->contactLoads(); }
  StepReport advance(Motion& motion, double step, const LoadSource& actuation) override;

 private:
  const std::vector<Brick>& bricks_;
  Environment environment_;
  std::unique_ptr<JointSolver> solver_;
  std::unique_ptr<ContactFinder> contacts_;  // null where nothing can be touched
  int substeps_;
};

}  // namespace kirireel
