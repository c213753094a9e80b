#include "sim/deploy/path_follower.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

// Turning counts this much more than place while the tiles are led.
constexpr double kTurnShare = 40;
// Damping while led, N s/m and, at a tile of 1 m, N m s.
constexpr double kForceDamping = 50;
constexpr double kTorqueDamping = 2;
// Seconds to catch up with a target that has stopped, and to stiffen joints that gave.
constexpr double kCatchUp = 0.5;
constexpr double kStiffeningTime = 0.5;
// The joints' stiffness at the end, N/m: what is left of their openings closes in one step.
constexpr double kClosingStiffness = 1e10;

TargetSpringSettings leadingSprings(const Scene& scene) {
  const double edge = tileSize(scene.model);
  TargetSpringSettings springs;
  springs.springStiffness = scene.path.ledStiffness;
  springs.torqueStiffness = kTurnShare * scene.path.ledStiffness;
  springs.forceDamping = kForceDamping;
  springs.torqueDamping = kTorqueDamping * edge * edge;
  springs.adaptive = false;
  return springs;
}

}  // namespace

PathFollower::PathFollower(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start,
                           const std::vector<Tile>& target, double beginTime)
    : path_(scene.path),
      beginTime_(beginTime),
      guide_(bottomTiles(bricks, start), target),
      springs_(bricks, target, scene.model.pulledTiles, leadingSprings(scene)) {}

bool PathFollower::prepareStep(double time, Dynamics& dynamics) {
  const double elapsed = time - beginTime_;
  springs_.setTarget(guide_.at(std::min(1.0, elapsed / path_.ledTime)));
  const double late = elapsed - path_.ledTime - kCatchUp;
  if (!path_.jointsGive()) return late <= 0;
  const double part = std::clamp(late / kStiffeningTime, 0.0, 1.0);
  const double range = std::max(1.0, kClosingStiffness / path_.jointStiffness);
  dynamics.setJointStiffness(path_.jointStiffness * std::pow(range, part));
  return late <= kStiffeningTime;
}

}  // namespace kirireel
