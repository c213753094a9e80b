/// Expansion: every brick is pushed away from the common centre (PyKirigami's --cm_expansion).
#pragma once

#include "sim/actuation/drive_force.h"

namespace kirireel {

/// F = k (x - centre) - c v on a brick's centre of mass, with the centre of mass of all bricks, and
/// the torque damping of the settings. The push grows outwards, so it is taken at the start of a
/// step: its stiffness is zero, only the damping is implicit.
class Expansion : public DriveForce {
 public:
  /// k is the spring stiffness of the settings, N/m, c their force damping, N s/m. `bricks` must
  /// outlive this.
  Expansion(const std::vector<Brick>& bricks, const TargetSpringSettings& settings)
      : bricks_(bricks), settings_(settings) {}

  void addLoads(const Poses& poses, std::vector<Load>& loads) const override;
  double energy(const Poses&) const override { return 0; }
  void addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const override;
  bool isEndless() const override { return true; }

 private:
  Vector3 centreOf(const Poses& poses) const;

  const std::vector<Brick>& bricks_;
  TargetSpringSettings settings_;
};

}  // namespace kirireel
