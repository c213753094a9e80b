/// Prints how evenly the default video of recorded runs is paced, and how closed the joints are in
/// its frames: tests/bench/pace TRAJECTORY...
#include <algorithm>
#include <cstdio>
#include <vector>

#include <fmt/format.h>

#include "render/record/pace.h"
#include "sim/base/error.h"
#include "sim/run/mechanism_path.h"
#include "sim/trajectory/measures.h"

namespace kirireel::bench {
namespace {

constexpr std::size_t kRampFrames = 36;

/// Figures of the poses in a video's frames.
struct Figures {
  double least = 0;  ///< share of the motion between the ramps in a tenth of their time
  double most = 0;
  double gap = 0;        ///< largest in any frame, tiles
  double sampleGap = 0;  ///< in any sample, the same unit
};

Figures figuresOf(const trajectory::TrajectoryReader& run) {
  const std::vector<brick::Brick>& bricks = run.subject().bricks;
  const std::vector<brick::Pivot> pivots = brick::makePivots(run.subject().model.joints, bricks);
  const double tile = model::tileSize(run.subject().model);
  Figures figures;
  for (std::size_t i = 0; i < run.times().size(); ++i) {
    figures.sampleGap =
        std::max(figures.sampleGap, trajectory::jointGap(pivots, run.sample(i).poses).max / tile);
  }
  record::Replay states(run);
  std::vector<double> length = {0};
  Poses before;
  for (const record::FrameMoment& moment : record::videoMoments(record::motionOf(run), {})) {
    Poses poses = states.at(moment.time).poses;
    figures.gap = std::max(figures.gap, trajectory::jointGap(pivots, poses).max / tile);
    if (!before.empty()) length.push_back(length.back() + run::pathDistance(bricks, before, poses));
    before = std::move(poses);
  }
  if (length.size() <= 2 * kRampFrames) return figures;
  const std::size_t first = kRampFrames, steps = length.size() - 1 - 2 * kRampFrames;
  figures.least = 1;
  for (std::size_t k = 0; k < 10; ++k) {
    const double share = (length[first + (k + 1) * steps / 10] - length[first + k * steps / 10]) /
                         (length[first + steps] - length[first]);
    figures.least = std::min(figures.least, share);
    figures.most = std::max(figures.most, share);
  }
  return figures;
}

void print(const char* file) {
  const trajectory::TrajectoryReader run(file);
  const Figures figures = figuresOf(run);
  fmt::print("{:26} tenths {:5.2f} to {:5.2f}%, gap {:.1e} tiles in frames, {:.1e} in samples\n",
             run.subject().model.name, 100 * figures.least, 100 * figures.most, figures.gap,
             figures.sampleGap);
}

}  // namespace
}  // namespace kirireel::bench

int main(int count, char** arguments) {
  try {
    for (int k = 1; k < count; ++k) kirireel::bench::print(arguments[k]);
  } catch (const kirireel::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
  return 0;
}
