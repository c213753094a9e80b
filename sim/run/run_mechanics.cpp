// Forces on the bricks of a run: drive, drags, compliant joints, gravity, forces between pairs and
// contacts. Energies and reaction forces follow from them.
#include "sim/run/run_mechanics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/run/forces.h"
#include "sim/trajectory/measures.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// Acting forces.

mechanics::TimedLoads ActingForces::timedLoads() const {
  return [this](double seconds, const Poses& poses, std::vector<brick::Load>& loads) {
    addLoads(seconds, poses, loads);
  };
}

mechanics::LoadSource ActingForces::loadsNow() const {
  return [this](const Poses& poses, std::vector<brick::Load>& loads) { addLoads(0, poses, loads); };
}

// Drags move during the step. The drive keeps its current state.
void ActingForces::addLoads(double seconds, const Poses& poses,
                            std::vector<brick::Load>& loads) const {
  std::fill(loads.begin(), loads.end(), brick::Load{});
  if (timeline_.forcesAreOn()) drive_.addLoads(poses, loads);
  timeline_.addDrags(clock_.time() + seconds, poses, loads);
}

// Energy of drive, drags and compliant joints at a time in these poses, joules. Forces between
// pairs are counted separately.
double ActingForces::springEnergy(double time, const Poses& poses) const {
  double sum = timeline_.forcesAreOn() ? drive_.energy(poses) : 0;
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    sum += pointSpringEnergy(grip.spring, poses[grip.tile]);
  }
  const double stiffness = jointStiffness();
  if (!std::isfinite(stiffness)) return sum;
  for (const brick::Pivot& pivot : bricks_.pivots) {
    // In the plane the pivots of both faces coincide.
    if (bricks_.needs.planar.on && pivot.isUpper) continue;
    sum += 0.5 * stiffness * std::pow(brick::pivotGap(pivot, poses), 2);
  }
  return sum;
}

double ActingForces::pairEnergy(const Poses& poses) const {
  return bricks_.ties.pairForces.energy(poses);
}

// Forces without stored energy, newtons: gravity, and the part of a drive without springs.
std::vector<Vector3> ActingForces::freeForces(const Poses& poses) const {
  std::vector<Vector3> forces;
  for (const brick::Brick& brick : bricks_.bricks)
    forces.push_back(brick.mass * bricks_.scene.environment.gravity);
  if (timeline_.forcesAreOn()) drive_.addFreeForces(poses, forces);
  return forces;
}

// All forces except contacts and joints, with damping at these velocities: N and N m about the
// centres of mass.
std::vector<Vector6> ActingForces::appliedForces(double time, const Motion& motion) const {
  std::vector<brick::Load> loads(bricks_.bricks.size());
  addLoads(time - clock_.time(), motion.poses, loads);
  addEnvironmentLoads(bricks_.scene.environment, bricks_.bricks, motion.poses, loads);
  std::vector<Vector6> forces;
  for (std::size_t i = 0; i < bricks_.bricks.size(); ++i) {
    Vector6 velocity;
    velocity << motion.velocities[i].linear, motion.velocities[i].angular;
    forces.push_back(loads[i].force - loads[i].damping * velocity);
  }
  for (const std::shared_ptr<const brick::PairForce>& force : bricks_.ties.pairForces) {
    force->addForces(motion, forces);
  }
  return forces;
}

void ActingForces::addForcesOfReplacedJoints(const Poses& poses,
                                             std::vector<Vector3>& jointForces) const {
  for (const std::shared_ptr<const brick::PairForce>& force : bricks_.ties.pairForces) {
    for (std::size_t pair = 0; pair < force->size(); ++pair) {
      const int joint = force->joint(pair);
      if (joint == brick::PairForce::kNoJoint) continue;
      jointForces[static_cast<std::size_t>(joint)] -=
          force->derivatives(pair, poses).gradient.head<3>();
    }
  }
}

bool ActingForces::areContactsKnown() const {
  const scene::Environment& environment = bricks_.scene.environment;
  const bool mayTouch =
      bricks_.needs.contacts.on || environment.ground || !environment.obstacles.empty();
  return !mayTouch || clock_.time() > 0;
}

// Drags as grips, and the contacts of the last step.
std::vector<trajectory::Hold> ActingForces::holds(double time, const Motion& motion) const {
  std::vector<trajectory::Hold> holds;
  for (const DragSpring& grip : timeline_.dragSprings(time)) {
    const Pose& pose = motion.poses[grip.tile];
    brick::Load load;
    addPointSpring(grip.spring, pose, load);
    Vector6 velocity;
    velocity << motion.velocities[grip.tile].linear, motion.velocities[grip.tile].angular;
    holds.push_back({trajectory::HoldKind::Grip, grip.tile, trajectory::Hold::kGround,
                     (load.force - load.damping * velocity).head<3>(), Vector3::Zero(),
                     pose.apply(grip.spring.point)});
  }
  // Grips are sorted by tile, then in the timeline's order: the files do not depend on other
  // orders.
  std::ranges::stable_sort(holds, {}, &trajectory::Hold::tile);
  const std::vector<trajectory::Hold> contacts =
      clock_.time() > 0 ? motion_.solver().contacts(motion.poses) : std::vector<trajectory::Hold>{};
  holds.insert(holds.end(), contacts.begin(), contacts.end());
  return holds;
}

void addContact(const trajectory::Hold& contact, const Poses& poses, std::vector<Vector6>& forces) {
  const auto push = [&](int tile, double sign) {
    Vector6& force = forces[static_cast<std::size_t>(tile)];
    const Vector3 arm = contact.point - poses[static_cast<std::size_t>(tile)].position;
    force.head<3>() += sign * contact.force;
    force.tail<3>() += sign * (contact.moment + arm.cross(contact.force));
  };
  push(contact.tile, 1);
  if (contact.other >= 0) push(contact.other, -1);
}

// ------------------------------------------------------------------------------------------------
// Energies and forces.
//
// The account. Drives add energy in three forms:
// 1. Springs that are tightened, moved or stiffened between two steps: their energy jumps while the
//    bricks are fixed.
// 2. Springs that move within a step.
// 3. Forces without stored energy: gravity and expansion.
//
// Dampers and contacts remove energy, and the solver counts it. The remaining difference in
//   work - damped - impacted = kinetic + spring + elastic
// is lost in the integrator. Implicit Euler steps of length h damp a spring of frequency w by
// h w / 2 of its energy per radian. Steps to a tolerance lose what the tolerance allows.

namespace {

// Forces balance if the residual on each brick is below this fraction of the largest applied force
// or inertia. Forces of joints and contacts do not count: bricks can press each other with any
// force.
constexpr double kImbalance = 0.05;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double valueBetween(double first, double last, double share) {
  return share == 1 ? last : first + share * (last - first);
}

trajectory::Energies energiesBetween(const trajectory::Energies& first,
                                     const trajectory::Energies& last, double share) {
  trajectory::Energies between;
  forEachField(between, [&](const auto& field, double& value) {
    value = valueBetween(first.*field.member, last.*field.member, share);
  });
  return between;
}

}  // namespace

RunMechanics::RunMechanics(const SceneBricks& bricks, const ActingForces& acting)
    : bricks_(bricks),
      acting_(acting),
      reactions_(mechanics::makeReactionSolver(bricks.bricks, bricks.ties.pivots,
                                               bricks.needs.planar.on, bricks.tileSize)) {}

// Springs may have been moved or stiffened since the end of the last step. The change of their
// energy counts as work.
void RunMechanics::begin(double time, const Motion& motion) {
  trajectory::Energies& now = account_.now;
  const double there = now.kinetic + now.spring + now.elastic;
  now.kinetic = trajectory::kineticEnergy(bricks_.bricks, motion);
  now.spring = acting_.springEnergy(time, motion.poses);
  now.elastic = acting_.pairEnergy(motion.poses);
  now.work += now.kinetic + now.spring + now.elastic - there;
  // Closing joints between two steps also moves bricks.
  if (!account_.reached.empty()) now.work += workOfFreeForces(account_.reached, motion.poses);
  account_.reached = motion.poses;
  account_.before = now;
  account_.largestWork = std::max(account_.largestWork, std::abs(now.work));
}

// Springs that move within a step have the energy of their positions at its end.
void RunMechanics::end(const StepSpan& step) {
  trajectory::Energies& now = account_.now;
  const double springTime = step.time + (step.springsMove ? step.seconds : 0);
  now.kinetic = trajectory::kineticEnergy(bricks_.bricks, step.to);
  now.spring = acting_.springEnergy(springTime, step.to.poses);
  now.elastic = acting_.pairEnergy(step.to.poses);
  now.work += workOfFreeForces(step.from.poses, step.to.poses);
  if (step.springsMove) now.work += workOfMovingSprings(step);
  // Dampers only remove energy. Negative values of the extrapolation are its error.
  now.damped += std::max(0.0, step.damped);
  now.impacted += step.impacted;
  account_.reached = step.to.poses;
  account_.accelerations.clear();
  for (std::size_t i = 0; i < step.to.velocities.size(); ++i) {
    account_.accelerations.push_back(
        (step.to.velocities[i].linear - step.from.velocities[i].linear) / step.seconds);
  }
}

// The next begin() then finds no change of the kinetic energy.
void RunMechanics::addImpact(const Motion& before, const Motion& after) {
  const double lost = trajectory::kineticEnergy(bricks_.bricks, before) -
                      trajectory::kineticEnergy(bricks_.bricks, after);
  account_.now.kinetic -= lost;
  account_.now.impacted += lost;
}

/// Exact for forces that grow linearly with the distance from a point, as these do.
double RunMechanics::workOfFreeForces(const Poses& from, const Poses& to) const {
  const std::vector<Vector3> before = acting_.freeForces(from);
  const std::vector<Vector3> after = acting_.freeForces(to);
  double work = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    work += 0.5 * (before[i] + after[i]).dot(to[i].position - from[i].position);
  }
  return work;
}

double RunMechanics::workOfMovingSprings(const StepSpan& step) const {
  double work = 0, done = 0;
  const Motion* from = &step.from;
  for (const mechanics::PassedState& state : step.passed) {
    work += workOfMovingSprings(step.time + done, state.seconds - done, *from, state.motion);
    done = state.seconds;
    from = &state.motion;
  }
  return work + workOfMovingSprings(step.time + done, step.seconds - done, *from, step.to);
}

/// Energy that moving springs gain while bricks are fixed, averaged over the positions of the
/// bricks during the step (Simpson). Exact to fourth order for springs at constant speed.
double RunMechanics::workOfMovingSprings(double time, double seconds, const Motion& from,
                                         const Motion& to) const {
  const auto gain = [&](const Poses& poses) {
    return acting_.springEnergy(time + seconds, poses) - acting_.springEnergy(time, poses);
  };
  const Poses middle = interpolate(from, to, seconds, 0.5);
  return (gain(from.poses) + 4 * gain(middle) + gain(to.poses)) / 6;
}

/// Whether joints, contacts and applied forces give each free brick its acceleration in the last
/// step, up to kImbalance. `largest`: of applied forces without contacts, newtons. Contact forces
/// are those at the end of the last step, which may differ from those of the whole step.
bool RunMechanics::isBalanced(const mechanics::Reactions& reactions,
                              std::span<const Vector6> applied, double largest,
                              const Poses& poses) const {
  std::vector<Vector3> rest;
  double worst = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3 inertia = bricks_.bricks[i].mass * account_.accelerations[i];
    rest.emplace_back(applied[i].head<3>() - inertia);
    largest = std::max(largest, inertia.norm());
  }
  const std::vector<brick::Pivot>& pivots = bricks_.ties.pivots;
  for (std::size_t p = 0; p < pivots.size(); ++p) {
    rest[static_cast<std::size_t>(pivots[p].brickA)] += reactions.pivotForces[p];
    rest[static_cast<std::size_t>(pivots[p].brickB)] -= reactions.pivotForces[p];
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (acting_.pinned()[i]) continue;
    // In the plane, the plane itself supports the residual.
    if (bricks_.needs.planar.on) rest[i].z() = 0;
    worst = std::max(worst, rest[i].norm());
  }
  return worst <= kImbalance * largest;  // also false when not a number
}

// Energies are interpolated linearly between the ends of the step. Forces come from a separate
// solve for this state. Forces of joints, pins and contacts that do not balance are unknown, and so
// are all of them before the first step of bricks that may touch.
trajectory::Mechanics RunMechanics::at(double time, const Motion& motion, double share) {
  trajectory::Mechanics result;
  result.energies = energiesBetween(account_.before, account_.now, share);
  const std::vector<bool>& pinned = acting_.pinned();
  std::vector<trajectory::Hold> holds = acting_.holds(time, motion);
  std::vector<Vector6> applied = acting_.appliedForces(time, motion);
  const auto isContact = [](const trajectory::Hold& hold) {
    return hold.kind == trajectory::HoldKind::Contact;
  };
  double largest = 0;
  for (const Vector6& force : applied) largest = std::max(largest, force.head<3>().norm());
  for (const trajectory::Hold& hold : holds) {
    if (isContact(hold)) addContact(hold, motion.poses, applied);
  }
  const double stiffness = acting_.jointStiffness();
  const mechanics::Reactions reactions = reactions_->solve(motion, applied, pinned, stiffness);
  const std::size_t joints = bricks_.scene.model.joints.size();
  const bool areUnknown =
      !acting_.areContactsKnown() || (std::ranges::any_of(holds, isContact) &&
                                      !isBalanced(reactions, applied, largest, motion.poses));
  if (areUnknown) {
    result.jointForces.assign(joints, Vector3::Constant(kUnknown));
    result.isIndeterminate.assign(joints, false);
    std::erase_if(holds, isContact);
    result.holds = std::move(holds);
    return result;
  }
  const std::vector<brick::Pivot>& pivots = bricks_.ties.pivots;
  result.jointForces.assign(joints, Vector3::Zero());
  for (std::size_t p = 0; p < pivots.size(); ++p) {
    result.jointForces[static_cast<std::size_t>(pivots[p].joint)] += reactions.pivotForces[p];
  }
  acting_.addForcesOfReplacedJoints(motion.poses, result.jointForces);
  result.isIndeterminate = std::isfinite(stiffness) ? std::vector<bool>(joints, false)
                                                    : reactions_->indeterminateJoints(joints);
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    if (!pinned[i]) continue;
    result.holds.push_back({trajectory::HoldKind::Pin, static_cast<int>(i),
                            trajectory::Hold::kGround, reactions.pinForces[i].head<3>(),
                            reactions.pinForces[i].tail<3>(), motion.poses[i].position});
  }
  result.holds.insert(result.holds.end(), holds.begin(), holds.end());
  return result;
}

}  // namespace kirireel::run
