// Expansion: F = k (x - c) - mu v away from the centre of mass c of all bricks (N, with k in N/m).
// Its derivative by x is +k, which is not the stiffness of a spring but the opposite; an implicit
// step would need a matrix that is not positive definite. The push is therefore taken at the step's
// start, and only its damping is implicit. All pushes together have no resultant where all masses
// are equal.
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
