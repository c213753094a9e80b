/// Whole trajectories as files, for tests.
#pragma once

#include <filesystem>

#include "sim/trajectory/trajectory_file.h"

namespace kirireel::test {

/// Throws InputError.
inline trajectory::Trajectory readTrajectory(const std::filesystem::path& path) {
  const trajectory::TrajectoryReader reader(path);
  trajectory::Trajectory trajectory{reader.subject(), reader.end(), {}};
  for (std::size_t i = 0; i < reader.times().size(); ++i) {
    trajectory.samples.push_back(reader.sample(i));
  }
  return trajectory;
}

/// Throws OutputError.
inline void writeTrajectory(const trajectory::Trajectory& trajectory,
                            const std::filesystem::path& path) {
  trajectory::TrajectoryWriter writer(path, trajectory);
  for (const trajectory::Sample& sample : trajectory.samples) writer.append(sample);
  writer.finish(trajectory);
}

}  // namespace kirireel::test
