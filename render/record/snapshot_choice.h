/// Which samples of a run make a snapshot grid.
#pragma once

#include <vector>

#include "render/record/record.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Adds up how far bricks travel.
class WayMeter {
 public:
  /// The bricks must outlive the meter.
  explicit WayMeter(const std::vector<Brick>& bricks) : bricks_(bricks) {}

  /// The way so far: the sum over the poses so far of the mean distance that a bottom vertex moved
  /// since those before, metres. Starts with 0 and never falls.
  double add(const Poses& poses);

 private:
  const std::vector<Brick>& bricks_;
  Poses before_;
  double way_ = 0;
};

/// A number for each sample that never falls: its time, or the way so far.
std::vector<double> marksOf(const TrajectoryReader& run, SnapshotSpacing spacing);

/// Indices of at most `count` (at least 1) of the marks, rising, the first and the last among them
/// when count is 2 or more (the last alone when it is 1). Fewer marks are all chosen. In between
/// each is the one nearest to its equal share.
std::vector<int> chooseSnapshots(const std::vector<double>& marks, int count);

/// The samples at which the timeline did this ("snapshot", "export"): the first not before each
/// event.
std::vector<std::size_t> samplesOf(const std::string& event, const TrajectoryReader& run);

/// The indices of the samples nearest to what was asked for, rising, each once. Throws InputError
/// for a time after the run's end.
std::vector<int> chooseFrames(const TrajectoryReader& run, const std::vector<FrameChoice>& wanted);

}  // namespace kirireel
