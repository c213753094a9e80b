// A state between two samples is interpolated by StateInterpolator (sim/deploy/interpolation.h),
// which closes the joints again. The two samples around the time are kept, so that frames that
// follow each other read each sample once.
#include "render/record/replay.h"

#include <algorithm>

namespace kirireel {
namespace {

/// Times closer than this part of the way between two samples are the same.
constexpr double kSameShare = 1e-6;

}  // namespace

Replay::Replay(const TrajectoryReader& run) : run_(run), interpolator_(run.subject()) {}

/// Keeps the sample of this index and the next.
void Replay::loadPair(std::size_t index) {
  if (!pair_.empty() && index_ == index) return;
  // The later of the pair so far is often the earlier of the next.
  const bool isKept = !pair_.empty() && index_ + 1 == index;
  Sample first = isKept ? std::move(pair_[1]) : run_.sample(index);
  pair_.clear();
  pair_.push_back(std::move(first));
  pair_.push_back(run_.sample(index + 1));
  index_ = index;
}

/// Times within a millionth of a sample are that sample, so that its own measures are told and not
/// interpolated ones.
Sample Replay::at(double time) {
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

StateFeed replay(const TrajectoryReader& run, const std::vector<FrameMoment>& moments,
                 const ProgressObserver& observer, PictureReport& report) {
  return [&run, &moments, &observer, &report](const StateTaker& take) {
    Replay states(run);
    for (std::size_t k = 0; k < moments.size(); ++k) {
      const FrameMoment& moment = moments[k];
      if (!take(std::make_shared<const FrameState>(FrameState{moment, states.at(moment.time)}))) {
        return;
      }
      const bool isLast = k + 1 == moments.size();
      const double share = static_cast<double>(k + 1) / static_cast<double>(moments.size());
      const Interruption interruption = observer({"painting", share});
      if (!interruption || isLast) continue;
      report.stoppedAt = moment.time;
      report.stoppedBy = *interruption;
      return;
    }
  };
}

}  // namespace kirireel
