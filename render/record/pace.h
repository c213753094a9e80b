/// Which moments of a run are shown, and when.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "render/record/job.h"
#include "sim/deploy/continuation.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel::record {

// ------------------------------------------------------------------------------------------------
// The motion of a run, and how a video's time follows it.

/// How far a run has moved by each of its times: the length of its path, the sum of pathDistance()
/// from sample to sample, straight in between. Bricks too far away to be shown do not count. It is
/// piecewise linear in time. A share is found by bisection, so a question costs the logarithm of
/// the number of samples.
class MotionCurve {
 public:
  /// times: rising, seconds, at least one; lengths: as many, never falling, metres, the first 0.
  MotionCurve(std::vector<double> times, std::vector<double> lengths);

  /// Of the run, simulated seconds.
  double endTime() const { return times_.back(); }
  /// Of the whole path, metres.
  double length() const { return lengths_.back(); }
  /// The share of the path that is behind at a time, 0 to 1; 1 at all times when nothing moves.
  double shareAt(double time) const;
  /// The first time at which this share of the path is behind; at 1 the end of the run.
  double timeAt(double share) const;

 private:
  std::vector<double> times_;
  std::vector<double> lengths_;
};

/// The motion of a recorded run, all of whose samples are read. Costs a pass over the samples.
MotionCurve motionOf(const trajectory::TrajectoryReader& run);

/// What one picture of a run shows.
struct FrameMoment {
  double time = 0;      ///< simulated seconds
  double progress = 0;  ///< share of the motion that is behind, 0 to 1
  double turn = 0;      ///< share of the camera's orbit that is behind, 0 to 1
};

/// The moment of a simulated time, seconds. At an even pace the camera's orbit follows the motion,
/// at real pace the time.
FrameMoment momentAt(const MotionCurve& motion, Pace pace, double time);

/// The share of the motion that is behind at a share of the video's time, both 0 to 1: at rest at
/// both ends, even in between, with ramps of `ramp` (0 to 1/2 of the time) in which speed grows and
/// falls evenly.
double easedProgress(double share, double ramp);

/// How many more frames the first and the last one are shown for. Rounded: settings.heldSeconds()
/// times the frames a second.
int heldFrames(const PictureSettings& settings);

/// The frames of a video of the run, rising in time. At an even pace each brings the same motion
/// but for ramps of 0.6 s at both ends, and what hardly moves after its arrival takes no time; a
/// run in which nothing moves is one frame. At real pace they are equally far apart in simulated
/// time. What settings.hold adds is not among them.
std::vector<FrameMoment> videoMoments(const MotionCurve& motion, const PictureSettings& settings);

/// The pictures of a snapshot grid, `count` of them, at equal shares of the motion or of the time
/// from the start to the end (only the end if there is one picture).
std::vector<FrameMoment> snapshotMoments(const MotionCurve& motion, const PictureSettings& settings,
                                         int count);

// ------------------------------------------------------------------------------------------------
// A recorded run as a source of states to be painted.

/// The states of a run at any time. It stores the samples read last: times close to each other cost
/// little.
class Replay {
 public:
  /// The run must outlive the replay.
  explicit Replay(const trajectory::TrajectoryReader& run);

  /// The state at a time, seconds from 0 to the run's end: a sample, or between two of them what
  /// StateInterpolator finds.
  trajectory::Sample at(double time);

 private:
  void loadPair(std::size_t index);

  const trajectory::TrajectoryReader& run_;
  deploy::StateInterpolator interpolator_;
  std::size_t index_ = 0;                 ///< of the first sample of the pair
  std::vector<trajectory::Sample> pair_;  ///< two samples in a row; none before they are needed
};

/// A state of a run, and the moment that it is of.
struct FrameState {
  FrameMoment moment;         ///< its place in the video
  trajectory::Sample sample;  ///< what it shows
};

/// A state that several threads may read at the same time.
using SharedState = std::shared_ptr<const FrameState>;

/// Takes the next state of a run; false asks for an early end.
using StateConsumer = std::function<bool(const SharedState&)>;

/// Gives states to a consumer, one after the other, and returns when there are no more.
using StateSource = std::function<void(const StateConsumer&)>;

/// Gives the states of the moments in turn. The observer may end it early, which the report then
/// notes. What is passed must outlive the source. The source calls the observer after each state,
/// with the stage "painting".
StateSource replay(const trajectory::TrajectoryReader& run, const std::vector<FrameMoment>& moments,
                   const ProgressObserver& observer, PictureReport& report);

// ------------------------------------------------------------------------------------------------
// Which samples of a run become pictures of their own.

/// The samples at which the timeline did this ("snapshot", "export"): the first not before each
/// event. In the order of the events, one each.
std::vector<std::size_t> samplesOf(const std::string& event,
                                   const trajectory::TrajectoryReader& run);

/// The indices of the samples nearest to what was asked for, rising, each once. Throws InputError
/// for a time after the run's end.
std::vector<int> chooseFrames(const std::vector<double>& times, const MotionCurve& motion,
                              const std::vector<FrameChoice>& requested);

}  // namespace kirireel::record
