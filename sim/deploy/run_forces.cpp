// What acts on the bricks of a run: springs, expansion, drags, gravity, hinges, contacts.
#include <algorithm>
#include <cmath>

#include "sim/actuation/environment_load.h"
#include "sim/deploy/run.h"

namespace kirireel {

/// To the target headed for at present, from where that was set or the way to it was opened.
void Run::tieSprings() {
  follower_.reset();
  if (scene_.path.kind == PathKind::Led && !isOpening()) {
    follower_.emplace(scene_, bricks_, departure_, *target_, departureTime_);
  }
  springs_.emplace(bricks_, *target_, scene_.model.pulledTiles, springSettings_);
}

// The springs of the moving guide where tiles are led, else those to the target. Null where nothing
// pulls.
const TargetSprings* Run::targetSprings() const {
  if (follower_) return &follower_->springs();
  return springs_ ? &*springs_ : nullptr;
}

/// What drives the bricks.
void Run::pull(const Poses& poses, std::vector<Load>& loads) const {
  if (const DriveForce* drive = presentDrive()) {
    drive->addLoads(poses, loads);
  } else if (const TargetSprings* springs = targetSprings()) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] = springs->load(static_cast<int>(i), poses[i], stiffness_.factor());
    }
  }
}

// What drive, drags and yielding joints store at a time in these poses, joules. Hinges and
// ligaments are accounted for apart.
double Run::springEnergy(double time, const Poses& poses) const {
  double sum = 0;
  if (timeline_.forcesAreOn()) {
    const DriveForce* drive = presentDrive();
    const TargetSprings* springs = targetSprings();
    if (drive) sum += drive->energy(poses);
    if (!drive && springs) sum += springs->energy(poses, stiffness_.factor());
  }
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    sum += pointSpringEnergy(grip.spring, poses[grip.tile]);
  }
  const double stiffness = jointStiffness();
  if (!std::isfinite(stiffness)) return sum;
  for (const Pivot& pivot : pivots_) {
    // In the plane both faces' pivots are one.
    if (needs_.planar.on && pivot.isUpper) continue;
    sum += 0.5 * stiffness * std::pow(pivotGap(pivot, poses), 2);
  }
  return sum;
}

// Forces that store no energy here, newtons: gravity, and what of a drive is no spring.
std::vector<Vector3> Run::freeForces(const Poses& poses) const {
  std::vector<Vector3> forces;
  for (const Brick& brick : bricks_) forces.push_back(brick.mass * scene_.environment.gravity);
  const DriveForce* drive = timeline_.forcesAreOn() ? presentDrive() : nullptr;
  if (drive) drive->addFreeForces(poses, forces);
  return forces;
}

// Everything but contacts and joints, with its damping at these velocities: N and N m about the
// centres of mass.
std::vector<Vector6> Run::appliedForces(double time, const Motion& motion) const {
  std::vector<Load> loads(bricks_.size());
  actuation_(time - this->time(), motion.poses, loads);
  addEnvironmentLoads(scene_.environment, bricks_, motion.poses, loads);
  std::vector<Vector6> forces;
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Vector6 velocity;
    velocity << motion.velocities[i].linear, motion.velocities[i].angular;
    forces.push_back(loads[i].force - loads[i].damping * velocity);
  }
  const std::vector<HingeSpring>& springs = result_.trajectory.hingeSprings;
  const std::vector<double> moments = hingeMoments(springs, motion.poses);
  for (std::size_t s = 0; s < springs.size(); ++s) {
    const Hinge& hinge = springs[s].hinge;
    const double moment = moments[s] - springs[s].damping * hingeRate(hinge, motion);
    const Vector3 onB = moment * (motion.poses[hinge.brickA].rotation * hinge.axis);
    forces[hinge.brickA].tail<3>() -= onB;
    forces[hinge.brickB].tail<3>() += onB;
  }
  for (const Ligament& ligament : ties_.ligaments) {
    const Vector6 slope = ligamentEnergy(ligament, motion.poses).gradient;
    const auto pull = [&](int brick, const Vector3& by) {
      forces[brick].head<2>() -= by.head<2>();
      forces[brick][5] -= by[2];
    };
    pull(ligament.brickA, slope.head<3>());
    pull(ligament.brickB, slope.tail<3>());
  }
  return forces;
}

// Adds what ligaments push their first brick with to the force of their joint, newtons. The plane's
// two components alone.
void Run::addLigamentForces(const Poses& poses, std::vector<Vector3>& jointForces) const {
  for (const Ligament& ligament : ties_.ligaments) {
    const Vector6 slope = ligamentEnergy(ligament, poses).gradient;
    jointForces[static_cast<std::size_t>(ligament.joint)].head<2>() -= slope.head<2>();
  }
}

// One entry a brick: whether the timeline holds it at present.
std::vector<bool> Run::pinned() const {
  std::vector<bool> pinned(bricks_.size(), false);
  for (const int tile : timeline_.pinnedTiles()) pinned[static_cast<std::size_t>(tile)] = true;
  return pinned;
}

// Drags as grips, and the contacts of the last step.
std::vector<Hold> Run::holds(double time, const Motion& motion) const {
  std::vector<Hold> holds;
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    const Pose& pose = motion.poses[grip.tile];
    Load load;
    addPointSpring(grip.spring, pose, load);
    Vector6 velocity;
    velocity << motion.velocities[grip.tile].linear, motion.velocities[grip.tile].angular;
    holds.push_back({HoldKind::Grip, grip.tile, Hold::kGround,
                     (load.force - load.damping * velocity).head<3>(), Vector3::Zero(),
                     pose.apply(grip.spring.point)});
  }
  // Grips come by tile, in the timeline's order within a tile, so that files do not depend on it.
  std::ranges::stable_sort(holds, {}, &Hold::tile);
  const std::vector<Hold> contacts =
      this->time() > 0 ? dynamics_->contacts(motion.poses) : std::vector<Hold>{};
  holds.insert(holds.end(), contacts.begin(), contacts.end());
  return holds;
}

/// How fast the bricks are so many seconds after the last step's start: straight between the states
/// on the way that are known.
std::vector<Velocity> Run::velocitiesAt(double seconds) const {
  const auto passed = wasSmooth_ ? dynamics_->passed() : std::span<const PassedState>{};
  return velocitiesBetween(before_, passed, motion_, length_, seconds);
}

/// How the bricks move in these poses at a time within the last step.
Motion Run::motionAt(double time, const Poses& poses) const {
  if (time == this->time()) return {poses, motion_.velocities};
  return {poses, velocitiesAt(length_ - (this->time() - time))};
}

}  // namespace kirireel
