#include "sim/measure/brick_measures.h"

#include <algorithm>

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

}  // namespace kirireel
