#include "sim/actuation/expansion.h"

namespace kirireel {

Vector3 centreOfMass(const std::vector<Brick>& bricks, const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    sum += bricks[i].mass * poses[i].position;
    mass += bricks[i].mass;
  }
  return sum / mass;
}

Load expansionLoad(const TargetSpringSettings& settings, const Vector3& centre, const Pose& pose) {
  Load load;
  load.force.head<3>() = settings.springStiffness * (pose.position - centre);
  load.damping.diagonal() << Vector3::Constant(settings.forceDamping),
      Vector3::Constant(settings.torqueDamping);
  return load;
}

}  // namespace kirireel
