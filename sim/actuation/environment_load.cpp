// Gravity m g at the centre of mass, and viscous damping. A velocity that loses the part p of
// itself in a second obeys v(t) = v(0) (1 - p)^t, thus dv/dt = -c v with c = -ln(1 - p) (1/s); the
// force is -c m v and the torque -c I w with the inertia I turned into world axes. Damping enters
// as a matrix, so that the implicit step takes it without a bound on its length.
#include "sim/actuation/environment_load.h"

#include <cmath>

namespace kirireel {

void addEnvironmentLoads(const Environment& environment, std::span<const Brick> bricks,
                         const Poses& poses, std::vector<Load>& loads) {
  // exp(-rate) is the part of the velocity that is left after a second.
  const double linearRate = -std::log1p(-environment.linearDamping);
  const double angularRate = -std::log1p(-environment.angularDamping);
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Brick& brick = bricks[i];
    Load& load = loads[i];
    load.force.head<3>() += brick.mass * environment.gravity;
    load.damping.topLeftCorner<3, 3>().diagonal().array() += linearRate * brick.mass;
    if (angularRate == 0) continue;
    // The inertia in world axes: R I R^T.
    const Matrix3 R = poses[i].rotation.toRotationMatrix();
    load.damping.bottomRightCorner<3, 3>() += angularRate * R * brick.inertia * R.transpose();
  }
}

}  // namespace kirireel
