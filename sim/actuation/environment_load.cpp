#include "sim/actuation/environment_load.h"

#include <cmath>

namespace kirireel {

void addEnvironmentLoad(const Environment& environment, const Brick& brick, const Pose& pose,
                        Load& load) {
  load.force.head<3>() += brick.mass * environment.gravity;
  // exp(-rate) is the part of the velocity that is left after a second.
  const double linearRate = -std::log1p(-environment.linearDamping);
  const double angularRate = -std::log1p(-environment.angularDamping);
  const Matrix3 R = pose.rotation.toRotationMatrix();
  load.damping.topLeftCorner<3, 3>().diagonal().array() += linearRate * brick.mass;
  load.damping.bottomRightCorner<3, 3>() += angularRate * R * brick.inertia * R.transpose();
}

}  // namespace kirireel
