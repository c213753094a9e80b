// Pictures follow the length of the run's path, s(t) = integral of ds with
//   ds^2 = mean over bricks of |dx|^2 + rho^2 |dphi|^2  (pathDistance),
// dx a brick's move, dphi its turn, rho its radius of gyration: a mechanism that snaps open in a
// tenth of a second and then creeps for two shows each part of its motion for equally long. A frame
// at video time tau of T has s = S p(tau / T), p the integral of a trapezoid.
#include "render/record/pace.h"

#include <algorithm>
#include <cmath>

#include "render/record/frame_sink.h"
#include "render/studio/studio.h"
#include "sim/deploy/continuation.h"

namespace kirireel {
namespace {

/// In which an even pace gathers and loses speed, seconds of video.
constexpr double kRampSeconds = 0.6;
/// Times closer than this part of a step are the same.
constexpr double kSameTime = 1e-6;

/// How far the bricks that both pictures show are from one state to the next, metres. Bricks that
/// have flown off would take most of the path's length.
double shownDistance(const Subject& subject, const Motif& motif, const Poses& from,
                     const Poses& to) {
  if (showsAllBricks(motif, from) && showsAllBricks(motif, to)) {
    return pathDistance(subject.bricks, from, to);
  }
  std::vector<Brick> bricks;
  Poses before, after;
  for (std::size_t i = 0; i < subject.bricks.size(); ++i) {
    if (!isShown(motif, i, from[i]) || !isShown(motif, i, to[i])) continue;
    bricks.push_back(subject.bricks[i]);
    before.push_back(from[i]);
    after.push_back(to[i]);
  }
  return bricks.empty() ? 0 : pathDistance(bricks, before, after);
}

/// The value of a line through points of rising x at a place within them. Straight between the
/// points, constant beyond.
double along(const std::vector<double>& x, const std::vector<double>& y, double place) {
  const auto above = std::lower_bound(x.begin(), x.end(), place);
  if (above == x.begin()) return y.front();
  if (above == x.end()) return y.back();
  const auto k = above - x.begin();
  const double share = (place - x[k - 1]) / (x[k] - x[k - 1]);
  return y[k - 1] + share * (y[k] - y[k - 1]);
}

/// The ramp is a share of the time in which something moves, at most a half.
std::vector<FrameMoment> evenMoments(const MotionCurve& motion, const PictureSettings& settings) {
  if (motion.length() == 0) return {momentAt(motion, Pace::Even, 0)};
  const double seconds = settings.length - 2 * settings.heldSeconds();
  const int frames =
      std::max(2, static_cast<int>(std::lround(settings.length * settings.framesPerSecond)) -
                      2 * heldFrames(settings));
  std::vector<FrameMoment> moments;
  for (int k = 0; k < frames; ++k) {
    const double share = static_cast<double>(k) / (frames - 1);
    const double progress = easedProgress(share, std::min(0.5, kRampSeconds / seconds));
    moments.push_back({motion.timeAt(progress), progress, progress});
  }
  return moments;
}

/// One frame where the run has no time.
std::vector<FrameMoment> realMoments(const MotionCurve& motion, const PictureSettings& settings) {
  const double step = settings.speed / settings.framesPerSecond;
  // The last frame shows the end, a shorter step after the one before.
  const long steps = static_cast<long>(std::ceil(motion.endTime() / step - kSameTime));
  std::vector<FrameMoment> moments;
  for (long k = 0; k <= steps; ++k) {
    const double time = std::min(motion.endTime(), static_cast<double>(k) * step);
    moments.push_back(momentAt(motion, Pace::Real, time));
  }
  return moments;
}

}  // namespace

MotionCurve::MotionCurve(std::vector<double> times, std::vector<double> lengths)
    : times_(std::move(times)), lengths_(std::move(lengths)) {}

double MotionCurve::shareAt(double time) const {
  return length() > 0 ? along(times_, lengths_, time) / length() : 1;
}

double MotionCurve::timeAt(double share) const {
  return share >= 1 ? endTime() : along(lengths_, times_, share * length());
}

MotionCurve motionOf(const TrajectoryReader& run) {
  const Motif motif = makeMotif(run.subject().model, run.subject().brickRule, {});
  std::vector<double> lengths = {0};
  Poses before = run.sample(0).poses;
  for (std::size_t i = 1; i < run.times().size(); ++i) {
    Poses poses = run.sample(i).poses;
    lengths.push_back(lengths.back() + shownDistance(run.subject(), motif, before, poses));
    before = std::move(poses);
  }
  return {run.times(), std::move(lengths)};
}

FrameMoment momentAt(const MotionCurve& motion, Pace pace, double time) {
  const double progress = motion.shareAt(time);
  if (pace == Pace::Even) return {time, progress, progress};
  return {time, progress, motion.endTime() > 0 ? time / motion.endTime() : 0};
}

/// With r = ramp, v = 1 / (1 - r) is the even speed; p = v x^2 / 2 r within the ramp, v (x - r / 2)
/// after it, and the second half mirrors the first.
double easedProgress(double share, double ramp) {
  if (share > 0.5) return 1 - easedProgress(1 - share, ramp);
  const double speed = 1 / (1 - ramp);
  return share < ramp ? 0.5 * speed * share * share / ramp : speed * (share - 0.5 * ramp);
}

std::vector<FrameMoment> videoMoments(const MotionCurve& motion, const PictureSettings& settings) {
  return settings.pace == Pace::Even ? evenMoments(motion, settings)
                                     : realMoments(motion, settings);
}

std::vector<FrameMoment> snapshotMoments(const MotionCurve& motion, const PictureSettings& settings,
                                         int count) {
  std::vector<FrameMoment> moments;
  for (int k = 0; k < count; ++k) {
    const double share = count > 1 ? static_cast<double>(k) / (count - 1) : 1;
    const bool byTime = settings.spacing == SnapshotSpacing::Time || motion.length() == 0;
    const double time = byTime ? share * motion.endTime() : motion.timeAt(share);
    moments.push_back(momentAt(motion, settings.pace, time));
  }
  return moments;
}

}  // namespace kirireel
