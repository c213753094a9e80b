/// The samples of a run as arrays, one behind the other: what programs that work on arrays look at
/// without copying.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "sim/trajectory/trajectory.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Grows by whole samples. Its arrays stay where they are while it does not grow.
class SampleTable {
 public:
  /// Adds a sample later than those before, with as many poses as they have.
  void append(const Sample& sample);

  std::size_t size() const { return times_.size(); }  ///< samples
  std::size_t brickCount() const { return brickCount_; }

  /// The sample of an index from 0 to size() - 1.
  Sample sample(std::size_t index) const;

  const std::vector<double>& times() const { return times_; }  ///< samples; seconds
  /// samples x bricks x 3, metres, of the centres of mass.
  const std::vector<double>& positions() const { return positions_; }
  /// samples x bricks x 4, unit quaternions w x y z, brick axes to world.
  const std::vector<double>& rotations() const { return rotations_; }
  const std::vector<double>& jointGaps() const { return jointGaps_; }        ///< samples; metres
  const std::vector<double>& targetErrors() const { return targetErrors_; }  ///< samples; metres
  const std::vector<double>& penetrations() const { return penetrations_; }  ///< samples; metres

  /// samples x bricks x 6: velocity of the centre of mass in m/s, then that of turning in rad/s,
  /// world axes. Samples keep poses alone, so these are their central differences, and one-sided
  /// ones at both ends; zeros where there is one sample. Second order in the samples' interval.
  std::vector<double> velocities() const;

 private:
  Poses poses(std::size_t index) const;

  std::size_t brickCount_ = 0;
  std::vector<double> times_;
  std::vector<double> positions_;
  std::vector<double> rotations_;
  std::vector<double> jointGaps_;
  std::vector<double> targetErrors_;
  std::vector<double> penetrations_;
  std::vector<std::vector<int>> pinned_;
  std::vector<std::vector<StepRecord>> steps_;
  std::vector<std::optional<Mechanics>> mechanics_;
};

/// All samples of a trajectory. Throws InputError as the reader does.
SampleTable readSamples(const TrajectoryReader& run);

}  // namespace kirireel
