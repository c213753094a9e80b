// Figures of a state. Kinetic energy of a brick with mass m (kg), inertia I in brick axes (kg m^2),
// velocity v (m/s) and angular velocity w (rad/s, world axes):
//   T = m |v|^2 / 2 + s . I s / 2,     s = R^T w
// with R the brick's rotation: turning w into brick axes is cheaper than turning I into the
// world's.
#include "sim/measure/measures.h"

#include <cmath>

namespace kirireel {
namespace {

/// The larger of two figures. What is no number stays: std::max would drop it.
double largerOf(double largest, double figure) {
  return std::isnan(largest) || figure <= largest ? largest : figure;
}

}  // namespace

JointGap jointGap(std::span<const Pivot> pivots, const Poses& poses) {
  JointGap gap;
  if (pivots.empty()) return gap;
  for (const Pivot& pivot : pivots) {
    const double distance = pivotGap(pivot, poses);
    gap.max = largerOf(gap.max, distance);
    gap.mean += distance;
  }
  gap.mean /= static_cast<double>(pivots.size());
  return gap;
}

double targetError(const std::vector<Tile>& target, const std::vector<Brick>& bricks,
                   const Poses& poses) {
  double largest = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    for (size_t k = 0; k < bricks[i].bottom.size(); ++k) {
      const Vector3 vertex = poses[i].apply(bricks[i].bottom[k]);
      largest = largerOf(largest, (vertex - target[i].vertices[k]).norm());
    }
  }
  return largest;
}

double kineticEnergy(const std::vector<Brick>& bricks, const Motion& motion) {
  double energy = 0;
  for (size_t i = 0; i < bricks.size(); ++i) {
    const Velocity& velocity = motion.velocities[i];
    const Vector3 spin = motion.poses[i].rotation.conjugate() * velocity.angular;
    energy += 0.5 * bricks[i].mass * velocity.linear.squaredNorm();
    energy += 0.5 * spin.dot(bricks[i].inertia * spin);
  }
  return energy;
}

}  // namespace kirireel
