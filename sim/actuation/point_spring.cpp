// A spring between a point r of a brick (brick axes) and an anchor a: with the arm s = R r, the
// force is f = k (a - x - s), the torque s x f. The point moves by G dq = dx - s x dtheta for a
// small displacement dq = (dx, dtheta), G = [1, -[s]x]. The Gauss-Newton part k G^T G of the
// stiffness is positive semidefinite, and so is the damping c G^T G, which acts on the point's
// velocity.
#include "sim/actuation/point_spring.h"

namespace kirireel {

void addPointSpring(const PointSpring& spring, const Pose& pose, Load& load) {
  const Vector3 arm = pose.rotation * spring.point;
  const Vector3 force = spring.stiffness * (spring.anchor - pose.position - arm);
  load.force.head<3>() += force;
  load.force.tail<3>() += arm.cross(force);
  // The point moves by G (dx, dtheta); how the arm's turn changes the torque is left out, since it
  // may be indefinite.
  Eigen::Matrix<double, 3, 6> G;
  G << Matrix3::Identity(), -crossMatrix(arm);
  const Matrix6 outer = G.transpose() * G;
  load.stiffness += spring.stiffness * outer;
  load.damping += spring.damping * outer;
}

double pointSpringEnergy(const PointSpring& spring, const Pose& pose) {
  return 0.5 * spring.stiffness * (spring.anchor - pose.apply(spring.point)).squaredNorm();
}

}  // namespace kirireel
