/// The motion of a run, and how a video's time follows it.
#pragma once

#include <vector>

#include "render/record/record.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// How far a run has moved by each of its times: the length of its path, the sum of pathDistance()
/// from sample to sample, straight in between. Bricks too far away to be shown do not count. It is
/// piecewise linear in time. A share is found by bisection, so a question costs the logarithm of
/// the number of samples.
class MotionCurve {
 public:
  /// times: rising, seconds, at least one; lengths: as many, never falling, metres, the first 0.
  MotionCurve(std::vector<double> times, std::vector<double> lengths);

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
MotionCurve motionOf(const TrajectoryReader& run);

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

/// The frames of a video of the run, rising in time. At an even pace each brings the same motion
/// but for ramps of 0.6 s at both ends, and what hardly moves after its arrival takes no time; a
/// run in which nothing moves is one frame. At real pace they are equally far apart in simulated
/// time. What settings.hold adds is not among them.
std::vector<FrameMoment> videoMoments(const MotionCurve& motion, const PictureSettings& settings);

/// The pictures of a snapshot grid, `count` of them, at equal shares of the motion or of the time
/// from the start to the end (the end alone when it is one).
std::vector<FrameMoment> snapshotMoments(const MotionCurve& motion, const PictureSettings& settings,
                                         int count);

}  // namespace kirireel
