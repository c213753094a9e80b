// Samples as long arrays. Angular velocities come from the rotation vector between two samples: the
// axis times the angle of to * from^-1, divided by the time between them, which is exact for a turn
// at constant speed about a fixed axis and of second order else.
#include "sim/trajectory/sample_table.h"

#include <algorithm>

namespace kirireel {

// Quaternions are kept as w, x, y, z; Eigen's own order is x, y, z, w.
void SampleTable::append(const Sample& sample) {
  brickCount_ = sample.poses.size();
  times_.push_back(sample.time);
  for (const Pose& pose : sample.poses) {
    const Vector3& at = pose.position;
    const Quaternion& turn = pose.rotation;
    positions_.insert(positions_.end(), {at.x(), at.y(), at.z()});
    rotations_.insert(rotations_.end(), {turn.w(), turn.x(), turn.y(), turn.z()});
  }
  jointGaps_.push_back(sample.jointGap);
  targetErrors_.push_back(sample.targetError);
  penetrations_.push_back(sample.penetration);
  pinned_.push_back(sample.pinned);
  steps_.push_back(sample.steps);
  mechanics_.push_back(sample.mechanics);
}

Poses SampleTable::poses(std::size_t index) const {
  Poses poses;
  poses.reserve(brickCount_);
  for (std::size_t row = index * brickCount_; row < (index + 1) * brickCount_; ++row) {
    const double* turn = &rotations_[4 * row];
    poses.push_back({Vector3(&positions_[3 * row]), {turn[0], turn[1], turn[2], turn[3]}});
  }
  return poses;
}

Sample SampleTable::sample(std::size_t index) const {
  return {times_[index],        poses(index),   jointGaps_[index], targetErrors_[index],
          penetrations_[index], pinned_[index], steps_[index],     mechanics_[index]};
}

std::vector<double> SampleTable::velocities() const {
  std::vector<double> velocities;
  velocities.reserve(size() * brickCount_ * 6);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::size_t before = i == 0 ? 0 : i - 1;
    const std::size_t after = std::min(i + 1, size() - 1);
    const double seconds =
        std::max(times_[after] - times_[before], 1e-300);  // one sample: 0 / this
    const Poses from = poses(before);
    const Poses to = poses(after);
    for (std::size_t k = 0; k < brickCount_; ++k) {
      const Vector3 linear = (to[k].position - from[k].position) / seconds;
      const Vector3 angular = turnBetween(from[k].rotation, to[k].rotation) / seconds;
      velocities.insert(velocities.end(), linear.begin(), linear.end());
      velocities.insert(velocities.end(), angular.begin(), angular.end());
    }
  }
  return velocities;
}

SampleTable readSamples(const TrajectoryReader& run) {
  SampleTable table;
  for (std::size_t i = 0; i < run.times().size(); ++i) table.append(run.sample(i));
  return table;
}

}  // namespace kirireel
