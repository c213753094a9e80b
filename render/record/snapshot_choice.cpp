#include "render/record/snapshot_choice.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "sim/base/error.h"

namespace kirireel {
namespace {

/// A wanted time may lie this much after the end, seconds: people round.
constexpr double kAfterEnd = 0.01;

double meanVertexMove(const std::vector<Brick>& bricks, const Poses& from, const Poses& to) {
  double sum = 0;
  std::size_t vertices = 0;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const Vector3& vertex : bricks[i].bottom) {
      sum += (to[i].apply(vertex) - from[i].apply(vertex)).norm();
    }
    vertices += bricks[i].bottom.size();
  }
  return vertices == 0 ? 0 : sum / static_cast<double>(vertices);
}

std::vector<double> travelledWay(const TrajectoryReader& run) {
  WayMeter meter(run.subject().bricks);
  std::vector<double> way;
  for (std::size_t i = 0; i < run.times().size(); ++i)
    way.push_back(meter.add(run.sample(i).poses));
  return way;
}

/// The entry of rising numbers that is nearest to a wanted one.
int nearestIndex(const std::vector<double>& numbers, double wanted) {
  const auto above = std::lower_bound(numbers.begin(), numbers.end(), wanted);
  if (above == numbers.begin()) return 0;
  const auto below = above - 1;
  const bool takeBelow = above == numbers.end() || wanted - *below <= *above - wanted;
  return static_cast<int>((takeBelow ? below : above) - numbers.begin());
}

int nearestToTime(const std::vector<double>& times, double time) {
  if (time > times.back() + kAfterEnd) {
    throw InputError(fmt::format(
        "--frames-at: {:g} s is after the end of the run at {:g} s; give times up to it, or shares "
        "such as 100%",
        time, times.back()));
  }
  return nearestIndex(times, time);
}

bool isShare(const FrameChoice& choice) {
  return choice.unit == FrameChoice::Unit::Share;
}

}  // namespace

double WayMeter::add(const Poses& poses) {
  if (!before_.empty()) way_ += meanVertexMove(bricks_, before_, poses);
  before_ = poses;
  return way_;
}

std::vector<double> marksOf(const TrajectoryReader& run, SnapshotSpacing spacing) {
  return spacing == SnapshotSpacing::Time ? run.times() : travelledWay(run);
}

std::vector<int> chooseSnapshots(const std::vector<double>& marks, int count) {
  const int last = static_cast<int>(marks.size()) - 1;
  if (count == 1) return {last};
  const int chosen = std::min(count, last + 1);
  std::vector<int> indices;
  for (int i = 0; i < chosen - 1; ++i) {
    const double share = static_cast<double>(i) / (chosen - 1);
    const int nearest = nearestIndex(marks, marks.front() + share * (marks.back() - marks.front()));
    // Every picture its own sample, and enough samples left for those that follow.
    const int least = indices.empty() ? 0 : indices.back() + 1;
    indices.push_back(std::clamp(nearest, least, last - (chosen - 1 - i)));
  }
  indices.push_back(last);
  return indices;
}

std::vector<int> chooseFrames(const TrajectoryReader& run, const std::vector<FrameChoice>& wanted) {
  const bool anyShare = std::ranges::any_of(wanted, isShare);
  const std::vector<double> way = anyShare ? travelledWay(run) : std::vector<double>();
  std::set<int> indices;
  for (const FrameChoice& choice : wanted) {
    indices.insert(isShare(choice) ? nearestIndex(way, choice.value * way.back())
                                   : nearestToTime(run.times(), choice.value));
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
