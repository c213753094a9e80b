#include "render/record/snapshot_choice.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

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

std::vector<double> timesOf(const Trajectory& trajectory) {
  std::vector<double> times;
  for (const Sample& sample : trajectory.samples) times.push_back(sample.time);
  return times;
}

/// The entry of rising numbers that is nearest to a wanted one.
int nearestIndex(const std::vector<double>& numbers, double wanted) {
  const auto above = std::lower_bound(numbers.begin(), numbers.end(), wanted);
  if (above == numbers.begin()) return 0;
  const auto below = above - 1;
  const bool takeBelow = above == numbers.end() || wanted - *below <= *above - wanted;
  return static_cast<int>((takeBelow ? below : above) - numbers.begin());
}

}  // namespace

std::vector<double> travelledWay(const Trajectory& trajectory) {
  std::vector<double> way = {0};
  for (std::size_t i = 1; i < trajectory.samples.size(); ++i) {
    const Poses& before = trajectory.samples[i - 1].poses;
    const Poses& after = trajectory.samples[i].poses;
    way.push_back(way.back() + meanVertexMove(trajectory.bricks, before, after));
  }
  return way;
}

std::vector<int> chooseSnapshots(const Trajectory& trajectory, int count, SnapshotSpacing spacing) {
  const int last = static_cast<int>(trajectory.samples.size()) - 1;
  if (count == 1) return {last};
  const std::vector<double> marks =
      spacing == SnapshotSpacing::Time ? timesOf(trajectory) : travelledWay(trajectory);
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

}  // namespace kirireel
