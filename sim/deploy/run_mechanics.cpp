// Energies and forces of a run.
//
// The account: drives put energy in by tightening, moving and stiffening springs, which shows as a
// jump of the springs' energy between two steps, while the bricks stand; by moving springs within a
// step; and by forces that store nothing, gravity and expansion. Dampers and contacts take energy:
// the solver counts that as it goes. What is then missing of the sum
//   work - damped - impacted = kinetic + spring + elastic
// is what the integrator takes: implicit Euler steps of length h damp a spring of frequency w by
// h w / 2 of its energy a radian, steps to a tolerance by what the tolerance allows.
#include "sim/deploy/run_mechanics.h"

#include "sim/measure/measures.h"

namespace kirireel {
namespace {

double valueBetween(double first, double last, double share) {
  return share == 1 ? last : first + share * (last - first);
}

Energies energiesBetween(const Energies& first, const Energies& last, double share) {
  const auto value = [&](double Energies::*field) {
    return valueBetween(first.*field, last.*field, share);
  };
  return {value(&Energies::kinetic), value(&Energies::spring), value(&Energies::elastic),
          value(&Energies::work),    value(&Energies::damped), value(&Energies::impacted)};
}

/// Adds a contact's force to what is applied to its tiles.
void apply(const Hold& contact, const Poses& poses, std::vector<Vector6>& applied) {
  const auto push = [&](int tile, double sign) {
    Vector6& force = applied[static_cast<std::size_t>(tile)];
    const Vector3 arm = contact.point - poses[static_cast<std::size_t>(tile)].position;
    force.head<3>() += sign * contact.force;
    force.tail<3>() += sign * (contact.moment + arm.cross(contact.force));
  };
  push(contact.tile, 1);
  if (contact.other >= 0) push(contact.other, -1);
}

}  // namespace

RunMechanics::RunMechanics(const std::vector<Brick>& bricks, std::span<const Pivot> pivots,
                           std::size_t joints, bool planar, double lengthScale,
                           const ActingForces& acting)
    : bricks_(bricks),
      pivots_(pivots),
      joints_(joints),
      acting_(acting),
      reactions_(makeReactionSolver(bricks, pivots, planar, lengthScale)) {}

// What springs hold now and did not hold at the end of the last step was put in by whoever moved or
// stiffened them.
void RunMechanics::begin(double time, const Motion& motion) {
  Energies& now = account_.now;
  const double there = now.kinetic + now.spring + now.elastic;
  now.kinetic = kineticEnergy(bricks_, motion);
  now.spring = acting_.springEnergy(time, motion.poses);
  now.elastic = acting_.hingeEnergy(motion.poses);
  now.work += now.kinetic + now.spring + now.elastic - there;
  account_.before = now;
}

// Springs that move within a step hold their energy at its end by their places at its end.
void RunMechanics::end(const StepSpan& step) {
  Energies& now = account_.now;
  const double springTime = step.time + (step.springsMove ? step.seconds : 0);
  now.kinetic = kineticEnergy(bricks_, step.to);
  now.spring = acting_.springEnergy(springTime, step.to.poses);
  now.elastic = acting_.hingeEnergy(step.to.poses);
  now.work += workOfFreeForces(step.from, step.to);
  if (step.springsMove) now.work += workOfMovingSprings(step);
  now.damped += step.damped;
  now.impacted += step.impacted;
}

/// Exact where forces grow with the distance from a point, as these do.
double RunMechanics::workOfFreeForces(const Motion& from, const Motion& to) const {
  const std::vector<Vector3> before = acting_.freeForces(from.poses);
  const std::vector<Vector3> after = acting_.freeForces(to.poses);
  double work = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    work += 0.5 * (before[i] + after[i]).dot(to.poses[i].position - from.poses[i].position);
  }
  return work;
}

double RunMechanics::workOfMovingSprings(const StepSpan& step) const {
  double work = 0, done = 0;
  const Motion* from = &step.from;
  for (const PassedState& state : step.passed) {
    work += workOfMovingSprings(step.time + done, state.seconds - done, *from, state.motion);
    done = state.seconds;
    from = &state.motion;
  }
  return work + workOfMovingSprings(step.time + done, step.seconds - done, *from, step.to);
}

/// By how much springs that move while bricks stand gain, its mean over where the bricks come by
/// (Simpson): exact to fourth order for springs that move evenly.
double RunMechanics::workOfMovingSprings(double time, double seconds, const Motion& from,
                                         const Motion& to) const {
  const auto gain = [&](const Poses& poses) {
    return acting_.springEnergy(time + seconds, poses) - acting_.springEnergy(time, poses);
  };
  const Poses middle = interpolate(from, to, seconds, 0.5);
  return (gain(from.poses) + 4 * gain(middle) + gain(to.poses)) / 6;
}

// Energies lie on a straight line between the two ends of the step; forces come from a solve of
// their own in this state.
Mechanics RunMechanics::at(double time, const Motion& motion, double share) {
  Mechanics result;
  result.energies = energiesBetween(account_.before, account_.now, share);
  const std::vector<bool> pinned = acting_.pinned();
  std::vector<Hold> holds = acting_.holds(time, motion);
  std::vector<Vector6> applied = acting_.appliedForces(time, motion);
  for (const Hold& hold : holds) {
    if (hold.kind == HoldKind::Contact) apply(hold, motion.poses, applied);
  }
  const double stiffness = acting_.jointStiffness();
  const Reactions reactions = reactions_->solve(motion, applied, pinned, stiffness);
  result.jointForces.assign(joints_, Vector3::Zero());
  for (std::size_t p = 0; p < pivots_.size(); ++p) {
    result.jointForces[static_cast<std::size_t>(pivots_[p].joint)] += reactions.pivotForces[p];
  }
  acting_.addLigamentForces(motion.poses, result.jointForces);
  result.isIndeterminate = std::isfinite(stiffness) ? std::vector<bool>(joints_, false)
                                                    : reactions_->indeterminateJoints(joints_);
  for (std::size_t i = 0; i < pinned.size(); ++i) {
    if (!pinned[i]) continue;
    result.holds.push_back({HoldKind::Pin, static_cast<int>(i), Hold::kGround,
                            reactions.pinForces[i].head<3>(), reactions.pinForces[i].tail<3>(),
                            motion.poses[i].position});
  }
  result.holds.insert(result.holds.end(), holds.begin(), holds.end());
  return result;
}

}  // namespace kirireel
