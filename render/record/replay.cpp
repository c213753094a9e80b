#include "render/record/replay.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

/// Times closer than this part of a step are the same.
constexpr double kSameTime = 1e-6;
}  // namespace

Sample sampleAt(const TrajectoryReader& run, double time) {
  const std::vector<double>& times = run.times();
  const auto above = std::lower_bound(times.begin(), times.end(), time);
  if (above == times.begin()) return run.sample(0);
  if (above == times.end()) return run.sample(times.size() - 1);
  const auto upper = static_cast<std::size_t>(above - times.begin());
  const double share = (time - times[upper - 1]) / (times[upper] - times[upper - 1]);
  if (share > 1 - kSameTime) return run.sample(upper);
  Sample sample = run.sample(upper - 1);
  if (share < kSameTime) return sample;
  sample.time = time;
  sample.poses = interpolate(sample.poses, run.sample(upper).poses, share);
  return sample;
}

SampleFeed replay(const TrajectoryReader& run, double step, const ProgressObserver& observer,
                  PictureReport& report) {
  return [&run, step, &observer, &report](const SampleTaker& take) {
    const double end = run.times().back();
    // The last frame shows the last sample, a shorter step after the one before.
    const auto steps = static_cast<long>(std::ceil(end / step - kSameTime));
    for (long k = 0; k <= steps; ++k) {
      const double time = std::min(end, static_cast<double>(k) * step);
      if (!take(std::make_shared<const Sample>(sampleAt(run, time)))) return;
      const double share = static_cast<double>(k + 1) / static_cast<double>(steps + 1);
      const Interruption interruption = observer({"painting", share});
      if (interruption && k < steps) {
        report.stoppedAt = time;
        report.stoppedBy = *interruption;
        return;
      }
    }
  };
}

}  // namespace kirireel
