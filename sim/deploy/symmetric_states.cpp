#include "sim/deploy/symmetric_states.h"

#include <cmath>
#include <span>
#include <utility>

#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// A state has a symmetry up to this part of a tile.
constexpr double kSymmetric = 1e-6;
// Below this part of a tile asymmetry is that of the model's own data, which closed states have.
constexpr double kNegligible = 5e-10;
// Joints are closed up to this part of a tile.
constexpr double kClosed = 1e-11;

}  // namespace

SymmetricStates::SymmetricStates(const Scene& scene, std::vector<Symmetry> group)
    : group_(std::move(group)), tile_(tileSize(scene.model)) {
  pivots_ = makePivots(scene.model.joints, makeBricks(scene.model.tiles, scene.brick));
}

void SymmetricStates::keepThoseOf(const Poses& state) {
  std::erase_if(group_, [&](const Symmetry& symmetry) {
    return asymmetry(state, std::span(&symmetry, 1), tile_) > kSymmetric * tile_;
  });
}

void SymmetricStates::restore(Poses& poses, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  if (asymmetry(poses, group_, tile_) <= kNegligible * tile_) return;
  Poses mean = symmetricMean(poses, group_);
  const bool isExact = !std::isfinite(dynamics.jointStiffness());
  const bool isOpen = isExact && jointGap(pivots_, mean).max > kClosed * tile_;
  if (isOpen && !dynamics.assemble(mean)) return;
  poses = std::move(mean);
}

void SymmetricStates::restore(Motion& motion, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  restore(motion.poses, dynamics);
  motion.velocities = symmetricMean(motion.velocities, group_);
}

}  // namespace kirireel
