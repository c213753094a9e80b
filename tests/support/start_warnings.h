/// Warnings of `export` at the start of a scene.
#pragma once

#include <string>
#include <vector>

#include "render/export/export.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/files.h"
#include "tests/support/trajectories.h"

namespace kirireel::test {

/// Warnings of an export of the start. `settings.states` is ignored.
inline std::vector<std::string> startWarnings(const scene::Scene& scene,
                                              exports::ExportSettings settings) {
  trajectory::Trajectory run{trajectory::subjectOf(scene)};
  run.samples.push_back({.time = 0, .poses = brick::startPoses(run.model.tiles, run.bricks)});
  settings.states = {"initial"};
  const TemporaryFolder folder;
  test::writeTrajectory(run, folder / "trajectory.h5");
  return exports::exportWarnings(trajectory::TrajectoryReader(folder / "trajectory.h5"), settings);
}

}  // namespace kirireel::test
