// Pictures follow the length of the run's path, s(t) = integral of ds with
//   ds^2 = mean over bricks of |dx|^2 + rho^2 |dphi|^2  (pathDistance),
// where dx is a brick's displacement, dphi its rotation and rho its radius of gyration. A mechanism
// may open in a tenth of a second and then creep for two seconds: each part of its motion is shown
// equally long. A frame at video time tau of T has s = S p(tau / T), p the integral of a trapezoid.
#include "render/record/pace.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "render/picture/state_painter.h"
#include "sim/base/error.h"
#include "sim/trajectory/run_curves.h"

namespace kirireel::record {
namespace {

/// Duration of the ramps of an even pace, seconds of video.
constexpr double kRampSeconds = 0.6;
/// Times closer than this fraction of a step are equal.
constexpr double kSameFrameTime = 1e-6;

/// The distance between two states of the bricks that both pictures show, metres. Bricks that have
/// flown off would dominate the path's length.
double shownDistance(const trajectory::Subject& subject, const picture::PictureContent& content,
                     const Poses& from, const Poses& to) {
  if (picture::showsAllBricks(content, from) && picture::showsAllBricks(content, to)) {
    return run::pathDistance(subject.bricks, from, to);
  }
  std::vector<brick::Brick> bricks;
  Poses before, after;
  for (std::size_t i = 0; i < subject.bricks.size(); ++i) {
    if (!picture::isShown(content, i, from[i]) || !picture::isShown(content, i, to[i])) continue;
    bricks.push_back(subject.bricks[i]);
    before.push_back(from[i]);
    after.push_back(to[i]);
  }
  return bricks.empty() ? 0 : run::pathDistance(bricks, before, after);
}

/// The ramp is a fraction of the time with motion, at most 1/2.
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

/// One frame if the run has no duration.
std::vector<FrameMoment> realMoments(const MotionCurve& motion, const PictureSettings& settings) {
  const double step = settings.speed / settings.framesPerSecond;
  // The last frame shows the end; its step may be shorter.
  const long steps = static_cast<long>(std::ceil(motion.endTime() / step - kSameFrameTime));
  std::vector<FrameMoment> moments;
  for (long k = 0; k <= steps; ++k) {
    const double time = std::min(motion.endTime(), static_cast<double>(k) * step);
    moments.push_back(momentAt(motion, Pace::Real, time));
  }
  return moments;
}

}  // namespace

int heldFrames(const PictureSettings& settings) {
  return static_cast<int>(std::lround(settings.heldSeconds() * settings.framesPerSecond));
}

MotionCurve::MotionCurve(std::vector<double> times, std::vector<double> lengths)
    : times_(std::move(times)), lengths_(std::move(lengths)) {}

double MotionCurve::shareAt(double time) const {
  return length() > 0 ? trajectory::valueAt(times_, lengths_, time) / length() : 1;
}

double MotionCurve::timeAt(double share) const {
  return share >= 1 ? endTime() : trajectory::valueAt(lengths_, times_, share * length());
}

MotionCurve motionOf(const trajectory::TrajectoryReader& run) {
  const picture::PictureContent content =
      picture::makeContent(run.subject().model, run.subject().brickRule, {});
  std::vector<double> lengths = {0};
  Poses before = run.sample(0).poses;
  for (std::size_t i = 1; i < run.times().size(); ++i) {
    Poses poses = run.sample(i).poses;
    lengths.push_back(lengths.back() + shownDistance(run.subject(), content, before, poses));
    before = std::move(poses);
  }
  return {run.times(), std::move(lengths)};
}

FrameMoment momentAt(const MotionCurve& motion, Pace pace, double time) {
  const double progress = motion.shareAt(time);
  if (pace == Pace::Even) return {time, progress, progress};
  return {time, progress, motion.endTime() > 0 ? time / motion.endTime() : 0};
}

/// With r = ramp and the constant speed v = 1 / (1 - r): p = v x^2 / 2 r within the ramp and
/// v (x - r / 2) after it. The second half mirrors the first.
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

// ------------------------------------------------------------------------------------------------
// StateInterpolator (sim/run/state_interpolator.h) interpolates between two samples and closes the
// joints again. The last two samples are kept, so frames in sequence read each sample once.

namespace {

/// Times closer than this fraction of the interval between two samples are equal.
constexpr double kSameShare = 1e-6;

}  // namespace

Replay::Replay(const trajectory::TrajectoryReader& run) : run_(run), interpolator_(run.subject()) {}

/// Keeps the sample of this index and the next.
void Replay::loadPair(std::size_t index) {
  if (!pair_.empty() && index_ == index) return;
  // The second sample of one pair is often the first of the next.
  const bool isKept = !pair_.empty() && index_ + 1 == index;
  trajectory::Sample first = isKept ? std::move(pair_[1]) : run_.sample(index);
  pair_.clear();
  pair_.push_back(std::move(first));
  pair_.push_back(run_.sample(index + 1));
  index_ = index;
}

/// A time within a millionth of a sample gives that sample with its own measures.
trajectory::Sample Replay::at(double time) {
  const std::vector<double>& times = run_.times();
  const auto above = std::lower_bound(times.begin(), times.end(), time);
  if (above == times.begin()) return run_.sample(0);
  if (above == times.end()) return run_.sample(times.size() - 1);
  const auto upper = static_cast<std::size_t>(above - times.begin());
  const double share = (time - times[upper - 1]) / (times[upper] - times[upper - 1]);
  if (share > 1 - kSameShare) return run_.sample(upper);
  if (share < kSameShare) return run_.sample(upper - 1);
  loadPair(upper - 1);
  return interpolator_.between(pair_[0], pair_[1], share);
}

StateSource replay(const std::vector<FilmedRun>& runs, const ProgressObserver& observer,
                   PictureReport& report) {
  return [&runs, &observer, &report](const StateConsumer& take) {
    std::vector<Replay> replays;
    std::size_t count = 0;
    for (const FilmedRun& filmed : runs) {
      replays.emplace_back(filmed.run);
      count = std::max(count, filmed.moments.size());
    }
    for (std::size_t k = 0; k < count; ++k) {
      std::vector<FrameState> states;
      double latest = 0;
      for (std::size_t run = 0; run < runs.size(); ++run) {
        const std::vector<FrameMoment>& moments = runs[run].moments;
        const FrameMoment& moment = moments[std::min(k, moments.size() - 1)];
        states.push_back({moment, replays[run].at(moment.time)});
        latest = std::max(latest, moment.time);
      }
      if (!take(std::make_shared<const std::vector<FrameState>>(std::move(states)))) return;
      const bool isLast = k + 1 == count;
      const double share = static_cast<double>(k + 1) / static_cast<double>(count);
      const Interruption interruption = observer({"painting", share});
      if (!interruption || isLast) continue;
      report.stoppedAt = latest;
      report.stoppedBy = *interruption;
      return;
    }
  };
}

// ------------------------------------------------------------------------------------------------
// Selection of the samples of a run for single pictures.

namespace {

/// A requested time may be this much after the end, seconds, because people round.
constexpr double kAfterEnd = 0.01;

/// Throws InputError for times after the end.
int nearestToTime(const std::vector<double>& times, double time) {
  if (time > times.back() + kAfterEnd) {
    throw InputError(
        fmt::format("error: --frames-at: {:g} s is after the end of the run at {:g} s; give times "
                    "up to it, or shares such as 100%",
                    time, times.back()));
  }
  return static_cast<int>(trajectory::nearestIndex(times, time));
}

}  // namespace

std::vector<int> chooseFrames(const std::vector<double>& times, const MotionCurve& motion,
                              const std::vector<FrameChoice>& requested) {
  std::set<int> indices;
  for (const FrameChoice& choice : requested) {
    const bool isShare = choice.unit == FrameChoice::Unit::Share;
    indices.insert(nearestToTime(times, isShare ? motion.timeAt(choice.value) : choice.value));
  }
  return {indices.begin(), indices.end()};
}

std::vector<std::size_t> samplesOf(const std::string& event,
                                   const trajectory::TrajectoryReader& run) {
  std::vector<std::size_t> found;
  const std::vector<double>& times = run.times();
  for (const trajectory::Event& happened : run.end().events) {
    if (happened.text != event) continue;
    const auto at = std::lower_bound(times.begin(), times.end() - 1, happened.time - 1e-9);
    found.push_back(static_cast<std::size_t>(at - times.begin()));
  }
  return found;
}

}  // namespace kirireel::record
