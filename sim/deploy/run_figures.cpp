// Figures of a run, measured at its start and after each step. A maximum or minimum keeps the state
// in which it was reached, so that it can be computed again from the trajectory; sums (mean gap,
// cost) follow from the steps' records. Records wait for the next sample, which takes those up to
// its own time along.
#include "sim/deploy/run_figures.h"

#include <algorithm>

#include "sim/measure/measures.h"

namespace kirireel {
namespace {

// Joints with gaps below this part of a tile are closed.
constexpr double kClosedShare = 1e-9;
// Of a state that is none of the run's.
constexpr double kNoTime = -1;

}  // namespace

// `asRead`: the state whose overlaps count as given, so that "grown" is measured from it.
RunFigures::RunFigures(const Model& model, const std::vector<Brick>& bricks,
                       std::span<const Pivot> pivots, double pivotZone, const Poses& asRead,
                       const AssembledState& nearest)
    : model_(model),
      bricks_(bricks),
      pivots_(pivots),
      tileSize_(tileSize(model)),
      overlaps_(std::make_unique<PenetrationMeter>(bricks, pivots, pivotZone, asRead,
                                                   kRoundingOverlap * tileSize_)),
      asRead_(asRead),
      assembledError_(nearest.error) {
  if (!model.target) return;
  accuracy_.springsRestError = nearest.restError;
  states_.push_back({"assembled_error", kNoTime, nearest.poses});
  states_.push_back({"springs_rest_error", kNoTime, nearest.restPoses});
}

// The start is observed as a step of no length: it counts in means and maxima.
void RunFigures::begin(const Poses& start, bool jointsGive) {
  accuracy_.assemblyMove = targetError(bottomTiles(bricks_, asRead_), bricks_, start);
  accuracy_.targetErrorStart = accuracy_.targetErrorMin = targetErrorOf(start);
  if (model_.target) accuracy_.rigidBound = rigidBound(model_.tiles, *model_.target);
  observe(0, start, {}, jointsGive);
}

// Measures the state after a step. `report` is that step's cost.
void RunFigures::observe(double time, const Poses& poses, const StepReport& report,
                         bool jointsGive) {
  // What may be ended from within comes first, while nothing has changed.
  const PenetrationDepths overlaps =
      overlaps_->atLeast({accuracy_.penetrationMax, accuracy_.penetrationOutsidePivotsMax,
                          accuracy_.penetrationGrownMax},
                         poses);
  time_ = time;
  poses_ = &poses;
  cost_.took += report;
  const JointGap gap = jointGap(pivots_, poses);
  gapBefore_ = gapNow_;
  gapNow_ = accuracy_.jointGapEnd = gap.max;
  gapSum_ += gap.mean;
  raise(accuracy_.jointGapMax, "joint_gap_max", gap.max);
  if (jointsGive) raise(accuracy_.jointOpeningMax, "joint_opening_max", gap.max);
  noteOverlaps(overlaps);
  observeTarget(gap);
  ++count_;
  steps_.push_back({time, gap.max, gap.mean, accuracy_.targetErrorEnd, report});
}

/// The state that is measured is the one that the figure stands for.
void RunFigures::keepState(const char* name) {
  auto state = std::ranges::find(states_, name, &FigureState::figure);
  if (state == states_.end()) state = states_.insert(state, FigureState{name, 0, {}});
  state->time = time_;
  state->poses = *poses_;
}

// The first value is taken whatever it is, so that each figure has a state.
void RunFigures::raise(double& figure, const char* name, double value) {
  if (count_ > 0 && !(value > figure)) return;
  figure = value;
  keepState(name);
}

void RunFigures::noteOverlaps(const PenetrationDepths& depths) {
  raise(accuracy_.penetrationMax, "penetration_max", depths.whole);
  raise(accuracy_.penetrationOutsidePivotsMax, "penetration_outside_pivots_max",
        depths.outsidePivots);
  raise(accuracy_.penetrationGrownMax, "penetration_grown_max", depths.grown);
}

// Two least errors: of any state, and of states with closed joints.
void RunFigures::observeTarget(const JointGap& gap) {
  if (!model_.target) return;
  const double error = accuracy_.targetErrorEnd = targetErrorOf(*poses_);
  if (count_ == 0 || error < accuracy_.targetErrorMin) {
    accuracy_.targetErrorMin = error;
    keepState("target_error_min");
  }
  if (gap.max <= kClosedShare * tileSize_ && error < assembledError_) {
    assembledError_ = error;
    keepState("assembled_error");
  }
}

// 0 without a target.
double RunFigures::targetErrorOf(const Poses& poses) const {
  return model_.target ? targetError(*model_.target, bricks_, poses) : 0;
}

// At both ends of the last step.
bool RunFigures::wereClosed() const {
  return std::max(gapBefore_, gapNow_) <= kClosedShare * tileSize_;
}

// A sample takes along the records of the steps up to its time; those of later ones wait.
Sample RunFigures::sampleAt(double time, Poses poses) {
  Sample sample;
  sample.time = time;
  sample.poses = std::move(poses);
  sample.jointGap = jointGap(pivots_, sample.poses).max;
  sample.targetError = targetErrorOf(sample.poses);
  sample.penetration = deepestPenetration(bricks_, sample.poses).depth;
  const auto later =
      std::ranges::find_if(steps_, [&](const StepRecord& step) { return step.time > time; });
  sample.steps.assign(steps_.begin(), later);
  steps_.erase(steps_.begin(), later);
  return sample;
}

// The figures of the end are the sample's. Kept states are dropped with it.
void RunFigures::endWith(const Sample& sample) {
  accuracy_.jointGapEnd = sample.jointGap;
  accuracy_.targetErrorEnd = sample.targetError;
  states_.clear();
}

void RunFigures::leave(DeploymentResult& result) const {
  result.accuracy = accuracy_;
  result.accuracy.jointGapMean = gapSum_ / static_cast<double>(count_);
  result.cost = cost_;
  result.assembledError = assembledError_;
  result.trajectory.figureStates = states_;
}

void RunFigures::transfer(StateTape& tape) {
  tape.transfer(accuracy_, assembledError_, cost_, count_, gapSum_);
}

void RunFigures::transferStates(StateTape& tape) {
  tape.transfer(states_, steps_, gapBefore_, gapNow_);
}

// ------------------------------------------------------------------------------------------------
// Energies and forces of a run.
//
// The account: drives put energy in by tightening, moving and stiffening springs, which shows as a
// jump of the springs' energy between two steps, while the bricks stand; by moving springs within a
// step; and by forces that store nothing, gravity and expansion. Dampers and contacts take energy:
// the solver counts that as it goes. What is then missing of the sum
//   work - damped - impacted = kinetic + spring + elastic
// is what the integrator takes: implicit Euler steps of length h damp a spring of frequency w by
// h w / 2 of its energy a radian, steps to a tolerance by what the tolerance allows.

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
