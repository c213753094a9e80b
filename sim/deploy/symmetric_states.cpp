// Keeping a path symmetric. A state is replaced by the mean of its images under the group
// (model/symmetry.h) where it has drifted from it by more than the asymmetry of closed states
// themselves; the mean of closed states is closed to the second order of the drift, and its joints
// are closed again where that is not enough. A mean that cannot be closed is not taken.
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

// The pivots are kept to measure whether a mean is still closed.
SymmetricStates::SymmetricStates(const Scene& scene, std::vector<Symmetry> group)
    : group_(std::move(group)), tile_(tileSize(scene.model)) {
  pivots_ = makePivots(scene.model.joints, makeBricks(scene.model.tiles, scene.brick));
}

// Drops symmetries that the state does not have, so that the rest are those to be kept from here
// on. The symmetries of one state form a group again.
void SymmetricStates::keepThoseOf(const Poses& state) {
  std::erase_if(group_, [&](const Symmetry& symmetry) {
    return asymmetry(state, std::span(&symmetry, 1), tile_) > kSymmetric * tile_;
  });
}

// Replaces a state by its mean over the group where it has drifted. It leaves the state as it is
// where the mean cannot be closed.
void SymmetricStates::restore(Poses& poses, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  if (asymmetry(poses, group_, tile_) <= kNegligible * tile_) return;
  Poses mean = symmetricMean(poses, group_);
  const bool isExact = !std::isfinite(dynamics.jointStiffness());
  const bool isOpen = isExact && jointGap(pivots_, mean).max > kClosed * tile_;
  if (isOpen && !dynamics.assemble(mean)) return;
  poses = std::move(mean);
}

// Velocities are averaged always: their mean is a velocity of the mean state to the first order.
void SymmetricStates::restore(Motion& motion, Dynamics& dynamics) const {
  if (group_.size() < 2) return;
  restore(motion.poses, dynamics);
  motion.velocities = symmetricMean(motion.velocities, group_);
}

}  // namespace kirireel
