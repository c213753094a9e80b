// Figures of single bricks. A measure that belongs to two bricks (a joint's gap, a spring's moment)
// counts for both of them as it is; energies are shared by halves, so that the sum over all bricks
// is the sum over all springs.
#include "sim/measure/brick_measures.h"

#include <algorithm>
#include <cmath>

namespace kirireel {

std::vector<double> brickTargetErrors(const std::vector<Tile>& target,
                                      const std::vector<Brick>& bricks, const Poses& poses) {
  std::vector<double> errors(bricks.size(), 0);
  for (std::size_t brick = 0; brick < bricks.size(); ++brick) {
    for (std::size_t k = 0; k < bricks[brick].bottom.size(); ++k) {
      const Vector3 point = poses[brick].apply(bricks[brick].bottom[k]);
      errors[brick] = std::max(errors[brick], (point - target[brick].vertices[k]).norm());
    }
  }
  return errors;
}

std::vector<double> brickDisplacements(const Poses& start, const Poses& poses) {
  std::vector<double> distances;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    distances.push_back((poses[brick].position - start[brick].position).norm());
  }
  return distances;
}

std::vector<double> brickRotations(const Poses& start, const Poses& poses) {
  std::vector<double> angles;
  for (std::size_t brick = 0; brick < poses.size(); ++brick) {
    // The angle of the shortest turn: 2 acos |q . q'| for unit quaternions, from 0 to pi.
    angles.push_back(start[brick].rotation.angularDistance(poses[brick].rotation));
  }
  return angles;
}

std::vector<double> brickJointGaps(std::span<const Pivot> pivots, const Poses& poses) {
  std::vector<double> gaps(poses.size(), 0);
  for (const Pivot& pivot : pivots) {
    const double gap =
        (poses[pivot.brickA].apply(pivot.pointA) - poses[pivot.brickB].apply(pivot.pointB)).norm();
    for (const int brick : {pivot.brickA, pivot.brickB}) gaps[brick] = std::max(gaps[brick], gap);
  }
  return gaps;
}

std::vector<double> brickMoments(std::span<const HingeSpring> springs, const Poses& poses) {
  std::vector<double> largest(poses.size(), 0);
  const std::vector<double> moments = hingeMoments(springs, poses);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    for (const int brick : {springs[s].hinge.brickA, springs[s].hinge.brickB}) {
      largest[brick] = std::max(largest[brick], std::abs(moments[s]));
    }
  }
  return largest;
}

std::vector<double> brickElasticEnergies(std::span<const HingeSpring> springs, const Poses& poses) {
  std::vector<double> energies(poses.size(), 0);
  for (const HingeSpring& spring : springs) {
    const double half = 0.5 * elasticEnergy({&spring, 1}, poses);
    energies[spring.hinge.brickA] += half;
    energies[spring.hinge.brickB] += half;
  }
  return energies;
}

}  // namespace kirireel
