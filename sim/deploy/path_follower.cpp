// Leading tiles: springs k_f at the means and 40 k_f for the turns pull every tile to where its own
// rigid motion has it at the time (target_guide.h). After the last of it the springs have half a
// second to catch up. Compliant joints then stiffen geometrically, k(t) = k_0 (1e10 / k_0)^p with p
// from 0 to 1 in half a second, so that what is left of their openings is closed in one small step.
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

// Their damping does not depend on the scene's: tiles are to follow, not to swing.
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

// The guide leads from the bricks' poses at the start of leading, not from the model's start.
PathFollower::PathFollower(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start,
                           const std::vector<Tile>& target, double beginTime)
    : path_(scene.path),
      beginTime_(beginTime),
      guide_(bottomTiles(bricks, start), target),
      springs_(bricks, target, scene.model.pulledTiles, leadingSprings(scene)) {}

// Sets what the step at `time` (seconds) is led by. Returns false once leading is over.
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
