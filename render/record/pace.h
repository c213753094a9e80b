/// Selection of the displayed moments of a run.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "render/record/job.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/state_interpolator.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// The motion of a run, and its relation to a video's time.

/// The motion of a run up to each time: the length of its path, which is the sum of pathDistance()
/// between samples, piecewise linear in time. Bricks too far away to be shown do not count.
/// Bisection finds a fraction in logarithmic time of the number of samples.
class MotionCurve {
 public:
  /// times: ascending, seconds, at least one; lengths: as many, metres, not decreasing, first 0.
  MotionCurve(std::vector<double> times, std::vector<double> lengths);

  /// End of the run, simulated seconds.
  double endTime() const { return times_.back(); }
  /// Length of the whole path, metres.
  double length() const { return lengths_.back(); }
  /// The completed fraction of the path at a time, [0, 1]; always 1 without motion.
  double shareAt(double time) const;
  /// The first time at which this fraction of the path is completed; at 1 the end of the run.
  double timeAt(double share) const;

 private:
  std::vector<double> times_;
  std::vector<double> lengths_;
};

/// The motion of a recorded run. Costs one pass over all samples.
MotionCurve motionOf(const trajectory::TrajectoryReader& run);

/// The state in one picture of a run.
struct FrameMoment {
  double time = 0;      ///< simulated seconds
  double progress = 0;  ///< completed fraction of the motion, [0, 1]
  double turn = 0;      ///< completed fraction of the camera's orbit, [0, 1]

  bool operator==(const FrameMoment&) const = default;
};

/// The moment of a simulated time, seconds. At an even pace the camera's orbit follows the motion,
/// at real pace the time.
FrameMoment momentAt(const MotionCurve& motion, Pace pace, double time);

/// The completed fraction of the motion at a fraction of the video's time, both [0, 1]: at rest at
/// both ends, constant speed in between, with linear ramps of the speed of length `ramp` (in [0,
/// 1/2] of the time).
double easedProgress(double share, double ramp);

/// Number of additional frames of the first and the last state: settings.heldSeconds() times the
/// frames per second, rounded.
int heldFrames(const PictureSettings& settings);

/// The frames of a video of the run, ascending in time. At an even pace each has the same motion,
/// except ramps of 0.6 s at both ends. Negligible motion after arrival takes no time. A run without
/// motion has one frame. At real pace they are equidistant in simulated time. Frames of
/// settings.hold are not included.
std::vector<FrameMoment> videoMoments(const MotionCurve& motion, const PictureSettings& settings);

/// The pictures of a snapshot grid, `count` of them, at equal fractions of the motion or of the
/// time from the start to the end (only the end if there is one picture).
std::vector<FrameMoment> snapshotMoments(const MotionCurve& motion, const PictureSettings& settings,
                                         int count);

// ------------------------------------------------------------------------------------------------
// A recorded run as a source of states to be painted.

/// The states of a run at any time. Keeps the samples read last, so nearby times are fast.
class Replay {
 public:
  /// The run must outlive the replay.
  explicit Replay(const trajectory::TrajectoryReader& run);

  /// The state at a time, seconds, from 0 to the run's end: a sample, or the result of
  /// StateInterpolator between two samples.
  trajectory::Sample at(double time);

 private:
  void loadPair(std::size_t index);

  const trajectory::TrajectoryReader& run_;
  run::StateInterpolator interpolator_;
  std::size_t index_ = 0;                 ///< of the first sample of the pair
  std::vector<trajectory::Sample> pair_;  ///< two consecutive samples; empty before first use
};

/// A state of a run with its moment.
struct FrameState {
  FrameMoment moment;         ///< its position in the video
  trajectory::Sample sample;  ///< data of the state
};

/// The states of runs in one frame, one per run. Several threads may read them at the same time.
using SharedStates = std::shared_ptr<const std::vector<FrameState>>;

/// Accepts the states of the next frame; false requests an early end.
using StateConsumer = std::function<bool(const SharedStates&)>;

/// Passes states to a consumer frame by frame; returns after the last.
using StateSource = std::function<void(const StateConsumer&)>;

/// A run in a video.
struct FilmedRun {
  const trajectory::TrajectoryReader& run;
  std::vector<FrameMoment> moments;  ///< one or more
};

/// Passes the states of the moments in order. A run with fewer moments than others stays at its
/// last one. The observer, called after each frame with the stage "painting", may end it early,
/// which the report then records. All arguments must outlive the source.
StateSource replay(const std::vector<FilmedRun>& runs, const ProgressObserver& observer,
                   PictureReport& report);

// ------------------------------------------------------------------------------------------------
// Selection of the samples of a run for single pictures.

/// The samples at which the timeline did this ("snapshot", "export"): the first not before each
/// event. In the order of the events, one each.
std::vector<std::size_t> samplesOf(const std::string& event,
                                   const trajectory::TrajectoryReader& run);

/// The indices of the samples nearest to the requested moments, ascending and unique. Throws
/// InputError for a time after the run's end.
std::vector<int> chooseFrames(const std::vector<double>& times, const MotionCurve& motion,
                              const std::vector<FrameChoice>& requested);

}  // namespace kirireel::record
