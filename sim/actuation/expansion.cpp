#include "sim/actuation/expansion.h"

namespace kirireel {

void Expansion::addLoads(const Poses& poses, std::vector<Load>& loads) const {
  const Vector3 centre = centreOf(poses);
  Vector6 damping;
  damping << Vector3::Constant(settings_.forceDamping), Vector3::Constant(settings_.torqueDamping);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    loads[i].force.head<3>() += settings_.springStiffness * (poses[i].position - centre);
    loads[i].damping.diagonal() += damping;
  }
}

void Expansion::addFreeForces(const Poses& poses, std::vector<Vector3>& forces) const {
  const Vector3 centre = centreOf(poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    forces[i] += settings_.springStiffness * (poses[i].position - centre);
  }
}

/// The centre of mass of all bricks, metres.
Vector3 Expansion::centreOf(const Poses& poses) const {
  Vector3 sum = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    sum += bricks_[i].mass * poses[i].position;
    mass += bricks_[i].mass;
  }
  return sum / mass;
}

}  // namespace kirireel
