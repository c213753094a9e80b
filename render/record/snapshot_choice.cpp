#include "render/record/snapshot_choice.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// A wanted time may lie this much after the end, seconds: people round.
constexpr double kAfterEnd = 0.01;

/// The entry of rising numbers that is nearest to a wanted one. Of two that are equally near, the
/// lower.
int nearestIndex(const std::vector<double>& numbers, double wanted) {
  const auto above = std::lower_bound(numbers.begin(), numbers.end(), wanted);
  if (above == numbers.begin()) return 0;
  const auto below = above - 1;
  const bool takeBelow = above == numbers.end() || wanted - *below <= *above - wanted;
  return static_cast<int>((takeBelow ? below : above) - numbers.begin());
}

/// Throws InputError for times after the end.
int nearestToTime(const std::vector<double>& times, double time) {
  if (time > times.back() + kAfterEnd) {
    throw InputError(fmt::format(
        "--frames-at: {:g} s is after the end of the run at {:g} s; give times up to it, or shares "
        "such as 100%",
        time, times.back()));
  }
  return nearestIndex(times, time);
}

}  // namespace

std::vector<int> chooseFrames(const std::vector<double>& times, const MotionCurve& motion,
                              const std::vector<FrameChoice>& wanted) {
  std::set<int> indices;
  for (const FrameChoice& choice : wanted) {
    const bool isShare = choice.unit == FrameChoice::Unit::Share;
    indices.insert(isShare ? nearestIndex(times, motion.timeAt(choice.value))
                           : nearestToTime(times, choice.value));
  }
  return {indices.begin(), indices.end()};
}

std::vector<std::size_t> samplesOf(const std::string& event, const TrajectoryReader& run) {
  std::vector<std::size_t> found;
  const std::vector<double>& times = run.times();
  for (const Event& happened : run.end().events) {
    if (happened.text != event) continue;
    const auto at = std::lower_bound(times.begin(), times.end() - 1, happened.time - 1e-9);
    found.push_back(static_cast<std::size_t>(at - times.begin()));
  }
  return found;
}

}  // namespace kirireel
