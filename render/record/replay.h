/// A recorded run as a feed of states to be painted.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "render/record/pace.h"
#include "render/record/record.h"
#include "sim/deploy/interpolation.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// The states of a run at any time. It remembers the samples read last, so that times that follow
/// each other closely cost little.
class Replay {
 public:
  /// The run must outlive the replay.
  explicit Replay(const TrajectoryReader& run);

  /// The state at a time, seconds from 0 to the run's end: a sample, or between two of them what
  /// StateInterpolator finds.
  Sample at(double time);

 private:
  void loadPair(std::size_t index);

  const TrajectoryReader& run_;
  StateInterpolator interpolator_;
  std::size_t index_ = 0;     ///< of the first sample of the pair
  std::vector<Sample> pair_;  ///< two samples in a row; none before they are needed
};

/// A state of a run, and the moment that it is of.
struct FrameState {
  FrameMoment moment;
  Sample sample;
};

/// A state that several threads may read at the same time.
using SharedState = std::shared_ptr<const FrameState>;

/// Takes the next state of a run; false asks for an early end.
using StateTaker = std::function<bool(const SharedState&)>;

/// Gives states to a taker, one after the other, and returns when there are no more.
using StateFeed = std::function<void(const StateTaker&)>;

/// Gives the states of the moments in turn. The observer may end it early, which the report then
/// notes. What is passed must outlive the feed. The feed calls the observer after each state, with
/// the stage "painting".
StateFeed replay(const TrajectoryReader& run, const std::vector<FrameMoment>& moments,
                 const ProgressObserver& observer, PictureReport& report);

}  // namespace kirireel
