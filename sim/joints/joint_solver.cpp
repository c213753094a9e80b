// A step: loads, velocities that joints and contacts allow, poses, closing, and what becomes of a
// step that fails. See JointSolver for the equations.
#include "sim/joints/joint_solver.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "sim/joints/stepper.h"

namespace kirireel {
namespace {

// All lengths are in length scales, all speeds in length scales a second.
constexpr double kSpeedTolerance = 1e-10;        // of joint rows, relative to the fastest brick
constexpr double kContactSpeedTolerance = 1e-7;  // of contact rows, likewise
constexpr double kChangeTolerance = 1e-6;        // of all rows in a round: the next would gain 1e-4
constexpr double kSlow = 1e-3;                   // below this speed tolerances shrink no more
constexpr double kWorkTolerance = 1e-6;          // of impulses, relative to that of the loads
constexpr double kRecovery = 2e-6;               // overlap taken back in a step
constexpr double kOverlapAccepted = 4e-5;        // at the end of a step
constexpr double kWorkOfPair = 1000;             // multiplications that looking at a pair is worth
constexpr int kHalvings = 8;
constexpr int kContactHalvings = 5;
// Exact joints mostly need one or two rounds, singular states a few more.
constexpr int kMultiplierRounds = 6;
constexpr int kContactRounds = 25;
// Bounds of friction that change by less than this part are settled.
constexpr double kBoundTolerance = 1e-7;
constexpr int kFrictionRounds = 20;
// Of ligaments: Newton steps in a step, the speed that they leave, and the least part of one.
constexpr int kLigamentRounds = 20;
constexpr double kLigamentTolerance = 1e-8;
constexpr double kLeastShare = 1e-6;

}  // namespace

template <int D>
// A step that would only repeat a standstill is answered without a try.
StepReport Stepper<D>::advance(Motion& motion, double step, const LoadSource& loads,
                               ContactSource* contacts) {
  loadSource_ = &loads;
  contactSource_ = contacts;
  report_ = {};
  if (standstill_.isWhole()) loads(motion.poses, loads_);
  if (!standstill_.beginStep(motion.poses, loads_, step)) return {.steps = 1, .unconverged = 1};
  const int before = system_.factorizations();
  const double workBefore = system_.work();
  const double pairsBefore = contacts ? contacts->pairsExamined() : 0;
  advanceHalving(motion, step, 0, true);
  standstill_.endStep(motion.poses, loads_);
  report_.factorizations = system_.factorizations() - before;
  const double pairs = contacts ? contacts->pairsExamined() - pairsBefore : 0;
  report_.work = system_.work() - workBefore + kWorkOfPair * pairs;
  return report_;
}

template <int D>
void Stepper<D>::setJointStiffness(double stiffness) {
  jointStiffness_ = stiffness;
  program_.exactJoints = !std::isfinite(stiffness);
  program_.multipliers.setZero();
  standstill_.forget();
}

/// `warm`: whether to begin with the contacts of the part before. Those that a step failed with may
/// have been the wrong ones: its first half begins without.
template <int D>
void Stepper<D>::advanceHalving(Motion& motion, double step, int level, bool warm) {
  jumped_ = false;
  isShortest_ = level == kHalvings || !standstill_.mayHalve();
  const StepOutcome outcome = tryStep(motion, step, warm);
  const bool halving = outcome == StepOutcome::JointsOpen ||
                       (outcome == StepOutcome::Overlapping && level < kContactHalvings);
  if (halving && !isShortest_) {
    ++report_.halved;
    advanceHalving(motion, 0.5 * step, level + 1, false);
    advanceHalving(motion, 0.5 * step, level + 1, true);
    return;
  }
  ++report_.steps;
  if (outcome != StepOutcome::Good || jumped_) ++report_.unconverged;
  if (outcome != StepOutcome::Good && contactSource_) {
    standstill_.noteStanding();
    standStill(motion.poses);
  } else {
    standstill_.noteMoving();
    keepMultipliers(step);
    countLosses(step);
  }
  finishStep(motion);
}

/// Sets the system and the program to a step under the loads at hand.
template <int D>
void Stepper<D>::beginStep(const Motion& start, double step) {
  system_.setStep(start, loads_, step, jointStiffness_);
  if (!program_.exactJoints) {
    // The spring at the step's end, k (gap + h J u), is that of a multiplier that does not move.
    program_.multipliers = -system_.kappa() / step * system_.jointGaps(start.poses);
  }
  program_.force = system_.force();
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const Velocity& velocity = start.velocities[i];
    program_.x.template segment<D>(D * i) = Space::pack(pinned_[i] ? Velocity{} : velocity);
  }
}

template <int D>
// The step as a whole from its start: loads, system, contacts of before.
StepOutcome Stepper<D>::tryStep(const Motion& start, double step, bool warm) {
  (*loadSource_)(start.poses, loads_);
  beginStep(start, step);
  startRows(start.poses, step, warm);
  startSpeed_ = program_.x;
  return solveContactRounds(start.poses, step);
}

/// Solves the step, looks what it runs into, and solves again with that until nothing is new.
template <int D>
StepOutcome Stepper<D>::solveContactRounds(const Poses& start, double step) {
  for (int round = 0; round < kContactRounds; ++round) {
    if (!solveWithLigaments(start, step)) return StepOutcome::JointsOpen;
    if (boundNewFriction() && !solveWithLigaments(start, step)) return StepOutcome::JointsOpen;
    forbidWork();
    if (!moveAndClose(start, step)) return StepOutcome::JointsOpen;
    payForClosing(start, step);
    if (!contactSource_) return StepOutcome::Good;
    std::vector<Contact> found;
    const double overlap = contactSource_->appendViolated(poses_, found);
    if (!appendRows(found, start, step)) {
      return overlap <= kOverlapAccepted * settings_.lengthScale ? StepOutcome::Good
                                                                 : StepOutcome::Overlapping;
    }
  }
  return StepOutcome::Overlapping;
}

/// Adds rows for contacts that have none yet. Returns whether there were any.
template <int D>
bool Stepper<D>::appendRows(const std::vector<Contact>& found, const Poses& start, double step) {
  const std::size_t before = program_.contacts.size();
  for (const Contact& contact : found) {
    const auto end = program_.contacts.begin() + static_cast<std::ptrdiff_t>(before);
    const bool known = std::any_of(program_.contacts.begin(), end,
                                   [&](const Row& row) { return row.contact == contact; });
    if (known) continue;
    Row row = contactRow(contact, start, step);
    row.active = row.trialImpulse(program_.x, system_.rho()) > 0;
    program_.contacts.push_back(row);
  }
  return program_.contacts.size() > before;
}

/// Contacts of the last step bring the bound of their friction; new ones get it from the load that
/// they were just found to carry. Returns whether there were any.
template <int D>
bool Stepper<D>::boundNewFriction() {
  bool any = false;
  for (Row& row : program_.contacts) {
    if (!row.hasNormal || row.slipBound > 0) continue;
    row.slipBound = row.contact.friction * row.multiplier;
    any = any || row.rubs();
  }
  return any;
}

/// Begins with the planes that carried load in the last step, as far as they still are current.
template <int D>
void Stepper<D>::startRows(const Poses& start, double step, bool warm) {
  program_.contacts.clear();
  addSupports(start, step);
  if (!contactSource_) return;
  contactSource_->startStep(start);
  if (!warm) return;
  for (auto first = kept_.begin(); first != kept_.end();) {
    const auto last = endOfPlane<D>(first, kept_.end());
    const bool isCurrent = std::any_of(first, last, [&](const Row& row) {
      return row.multiplier > 0 && contactSource_->isCurrent(row.contact);
    });
    if (isCurrent) {
      std::for_each(first, last, [&](const Row& row) { takeOver(row, start, step); });
    }
    first = last;
  }
}

/// Adds the row of a contact of the last step.
template <int D>
void Stepper<D>::takeOver(const Row& old, const Poses& start, double step) {
  Row row = contactRow(old.contact, start, step);
  // Multipliers are impulses: they go with the length of the step.
  row.multiplier = step / keptStep_ * old.multiplier;
  row.active = row.multiplier > 0;
  row.slipMultiplier = step / keptStep_ * old.slipMultiplier;
  row.slipBound = old.contact.friction * row.multiplier;
  program_.contacts.push_back(row);
}

template <int D>
void Stepper<D>::addSupports(const Poses& poses, double step) {
  for (std::size_t s = 0; s < settings_.supports.size(); ++s) {
    const Support& support = settings_.supports[s];
    Row row;
    row.contact = {support.brick, kFixed, support.point, Vector3::Zero(), Vector3::UnitZ()};
    row.hasNormal = false;
    row.slipBound = support.largestForce * step;
    if (s < supports_.size()) {
      row.slipMultiplier = step / keptStep_ * supports_[s].slipMultiplier;
    }
    placeRow(row, poses);
    holdPinned(row);
    program_.contacts.push_back(row);
  }
}

template <int D>
ContactRow<D> Stepper<D>::contactRow(const Contact& contact, const Poses& start,
                                     double step) const {
  Row row = makeContactRow<D>(contact, start, step, kRecovery * settings_.lengthScale);
  holdPinned(row);
  return row;
}

/// No contact moves a pinned brick.
template <int D>
void Stepper<D>::holdPinned(Row& row) const {
  if (pinned_[row.contact.brickA]) {
    row.normalA.setZero();
    row.tangentA.setZero();
  }
  if (row.contact.brickB != kFixed && pinned_[row.contact.brickB]) {
    row.normalB.setZero();
    row.tangentB.setZero();
  }
}

/// Finds the velocities of the step under the contacts at hand.
template <int D>
bool Stepper<D>::solveVelocities(const Poses& start) {
  system_.placeJoints(start);
  setSlipStates(program_, system_.rho());
  if (!system_.factor(program_.contacts)) return false;
  const double slow = kSlow * settings_.lengthScale;
  for (int round = 0; round < kMultiplierRounds; ++round) {
    const RoundReport report = solveRound(system_, program_, slow);
    if (!report.found) return false;
    const double speed = std::max(system_.largestSpeed(program_.x), slow);
    const bool refined = report.change <= kChangeTolerance * speed &&
                         report.contactChange <= kContactSpeedTolerance * speed;
    if (refined && report.jointSpeed <= kSpeedTolerance * speed) break;
  }
  return true;  // the rest is judged by the gap after closing
}

/// Finds the velocities of the step with the ligaments as they are at its end: Newton's method from
/// rest, each step cut until what is minimised falls, so that a step gains no energy however stiff
/// ligaments are. Joints and contacts allow all velocities between two that they allow; joints that
/// give are not in what is minimised, and steps are whole beside them.
template <int D>
bool Stepper<D>::solveWithLigaments(const Poses& start, double step) {
  if (!system_.hasLigaments()) return solveVelocities(start);
  Vector known = Vector::Zero(program_.x.size());
  double least = system_.potential(step, known);
  for (int round = 0; round < kLigamentRounds; ++round) {
    system_.setLigamentsAbout(known, LigamentBlocks::Curvature::Convex);
    program_.force = system_.force();
    if (!solveVelocities(start)) return false;
    const Vector change = program_.x - known;
    double share = 1, potential = system_.potential(step, program_.x);
    while (potential > least && share > kLeastShare && program_.exactJoints) {
      share *= 0.5;
      potential = system_.potential(step, known + share * change);
    }
    const double speed = std::max(system_.largestSpeed(program_.x), kSlow * settings_.lengthScale);
    if (potential > least && program_.exactJoints) share = 0;
    known += share * change;
    least = std::min(least, potential);
    if (share == 0 || system_.largestSpeed(share * change) <= kLigamentTolerance * speed) break;
  }
  program_.x = known;
  return true;
}

/// Joints and contacts do no work on the bricks: x.Ax, what moving costs, is at most x.f, what
/// there is. Where bricks wedge, impulses are still on their way when the rounds end, and may do
/// some: then all bricks move slower, which joints and contacts allow, as they allow rest.
template <int D>
void Stepper<D>::forbidWork() {
  if (program_.contacts.empty() || !program_.exactJoints) return;
  const double cost = program_.x.dot(system_.timesA(program_.x));
  const double means = program_.x.dot(system_.force());
  if (cost > (1 + kWorkTolerance) * means) program_.x *= std::max(0.0, means / cost);
}

template <int D>
// Moves all poses by displacements in D coordinates each.
void Stepper<D>::displace(const Vector& move) {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Space::displace(poses_[i], move.segment<D>(D * i));
  }
}

/// Keeps the impulses, of contacts by whole planes: a plane that carries load somewhere may do so
/// elsewhere in the next step.
template <int D>
void Stepper<D>::keepMultipliers(double step) {
  keptStep_ = multiplierStep_ = step;
  kept_.clear();
  supports_.clear();
  const std::vector<Row>& rows = program_.contacts;
  for (auto first = rows.begin(); first != rows.end();) {
    const auto last = endOfPlane<D>(first, rows.end());
    const bool loaded = std::any_of(first, last, [](const Row& row) { return row.multiplier > 0; });
    if (!first->hasNormal) {
      supports_.push_back(*first);
    } else if (loaded) {
      kept_.insert(kept_.end(), first, last);
    }
    first = last;
  }
}

/// What dampers take along the step, and contacts: their impulse times the mean of the velocities
/// before and after (Kelvin).
template <int D>
void Stepper<D>::countLosses(double step) {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector velocity = program_.x.template segment<D>(D * i);
    report_.damped += step * velocity.dot(Space::restrict(loads_[i].damping) * velocity);
  }
  report_.damped += system_.dampedBySprings(step, program_.x);
  const Vector mean = 0.5 * (startSpeed_ + program_.x);
  for (const Row& row : program_.contacts) {
    if (row.hasNormal) report_.impacted -= row.multiplier * row.normalVelocity(mean);
    report_.impacted -= row.slipMultiplier.dot(row.slipVelocity(mean));
  }
}

/// Writes the new state; angular momentum, not angular velocity, is carried across the turn.
template <int D>
void Stepper<D>::finishStep(Motion& motion) const {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    Velocity velocity = Space::unpack(program_.x.template segment<D>(D * i));
    if constexpr (D == 6) {
      const Quaternion& before = motion.poses[i].rotation;
      const Quaternion& after = poses_[i].rotation;
      const Vector3 momentum = bricks_[i].inertia * (before.conjugate() * velocity.angular);
      const Vector3 turned = after.conjugate() * (before * momentum);
      velocity.angular = after * bricks_[i].inertia.llt().solve(turned);
    }
    motion.velocities[i] = velocity;
  }
  motion.poses = poses_;
}

template <int D>
void Stepper<D>::setPinned(const std::vector<bool>& pinned) {
  pinned_ = pinned;
  system_.setPinned(pinned);
  standstill_.forget();
}

template <int D>
std::vector<ContactLoad> Stepper<D>::contactLoads() const {
  std::map<std::pair<int, int>, double> forces;
  for (const Row& row : kept_) {
    const auto [low, high] = std::minmax(row.contact.brickA, row.contact.brickB);
    const std::pair<int, int> pair =
        low == kFixed ? std::pair(high, kFixed) : std::pair<int, int>(low, high);
    if (row.multiplier > 0) forces[pair] += row.multiplier / keptStep_;
  }
  std::vector<ContactLoad> loads;
  for (const auto& [pair, force] : forces) loads.push_back({pair.first, pair.second, force});
  std::ranges::stable_sort(loads, std::greater{}, &ContactLoad::force);
  return loads;
}

template <int D>
std::vector<TouchForce> Stepper<D>::touchForces(const Poses& poses) const {
  std::vector<TouchForce> forces;
  for (const auto* rows : {&kept_, &supports_}) {
    for (Row row : *rows) {
      placeRow(row, poses);
      // The velocity of A's point along a direction begins with that direction.
      constexpr int kAxes = D == 6 ? 3 : 2;
      TouchForce touch = {row.contact.brickA, row.contact.brickB,
                          poses[row.contact.brickA].apply(row.contact.pointA), Vector3::Zero(), 0};
      touch.force.template head<kAxes>() =
          row.tangentA.template leftCols<kAxes>().transpose() * row.slipMultiplier / keptStep_;
      if (row.hasNormal) {
        touch.push = row.multiplier / keptStep_;
        touch.force.template head<kAxes>() +=
            touch.push * row.normalA.template head<kAxes>().transpose();
      }
      forces.push_back(touch);
    }
  }
  return forces;
}

/// Adds the momentum and the work that the loads give in a step with the program's velocities.
template <int D>
void Stepper<D>::addGain(const Poses& poses, double step, LoadGain& given) const {
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    const typename Space::Vector velocity = program_.x.template segment<D>(D * i);
    const typename Space::Block resistance =
        Space::restrict(loads_[i].damping) + step * Space::restrict(loads_[i].stiffness);
    const typename Space::Vector push =
        step * (Space::restrict(loads_[i].force) - resistance * velocity);
    const Velocity impulse = Space::unpack(push);
    given.momentum.linear += impulse.linear;
    given.momentum.angular += poses[i].position.cross(impulse.linear) + impulse.angular;
    given.work += velocity.dot(push);
  }
  given.work -= system_.dampedBySprings(step, program_.x) + report_.impacted;
}

template <int D>
// Contacts that were held already keep their impulses.
void Stepper<D>::holdContacts(const std::vector<Contact>& contacts) {
  std::vector<Row> held;
  for (const Contact& contact : contacts) {
    const auto known =
        std::ranges::find_if(kept_, [&](const Row& row) { return row.contact == contact; });
    Row row = known == kept_.end() ? Row{} : *known;
    row.contact = contact;
    held.push_back(std::move(row));
  }
  kept_ = std::move(held);
}

template <int D>
std::vector<Contact> Stepper<D>::heldContacts() const {
  std::vector<Contact> contacts;
  for (const Row& row : kept_) contacts.push_back(row.contact);
  return contacts;
}

/// The rows of the contacts that are held. They begin with the impulses of the step before.
template <int D>
void Stepper<D>::placeHeldRows(const Poses& poses, double step) {
  program_.contacts.clear();
  addSupports(poses, step);
  for (Row row : kept_) {
    placeRow(row, poses);
    holdPinned(row);
    row.bias = 0;
    row.multiplier *= step / keptStep_;
    row.slipMultiplier *= step / keptStep_;
    row.slipBound = row.contact.friction * row.multiplier;
    row.active = row.multiplier > 0;
    program_.contacts.push_back(std::move(row));
  }
}

template <int D>
void Stepper<D>::keepHeldRows(double step) {
  keptStep_ = step;
  const auto firstHeld = program_.contacts.end() - static_cast<std::ptrdiff_t>(kept_.size());
  supports_.assign(program_.contacts.begin(), firstHeld);
  kept_.assign(firstHeld, program_.contacts.end());
}

template <int D>
double Stepper<D>::caughtSpeed(const Motion& start) const {
  Vector velocities(D * bricks_.size());
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    velocities.segment<D>(D * i) = Space::pack(start.velocities[i]);
  }
  double fastest = 0;
  for (const std::vector<Row>* rows : {&kept_, &supports_}) {
    for (Row row : *rows) {
      const bool sticks = row.slipMultiplier.norm() < (1 - kBoundTolerance) * row.slipBound;
      if (!sticks) continue;
      placeRow(row, start.poses);
      fastest = std::max(fastest, row.slipVelocity(velocities).norm());
    }
  }
  return fastest;
}

/// Finds velocities under friction that is in force with its own normal impulses, not with those of
/// a step before. One more round of multipliers than speeds need makes impulses as exact as those.
template <int D>
bool Stepper<D>::solveWithFriction(const Poses& start) {
  for (int round = 0; round < kFrictionRounds; ++round) {
    if (!solveVelocities(start)) return false;
    if (program_.contacts.empty()) return true;
    if (!solveRound(system_, program_, kSlow * settings_.lengthScale).found) return false;
    if (!boundFriction()) return true;
  }
  return true;
}

/// Sets the bounds of friction to what the contacts carry. Returns whether any changed.
template <int D>
bool Stepper<D>::boundFriction() {
  bool changed = false;
  for (Row& row : program_.contacts) {
    if (!row.hasNormal) continue;
    const double bound = row.contact.friction * row.multiplier;
    changed = changed || std::abs(bound - row.slipBound) > kBoundTolerance * bound;
    row.slipBound = bound;
  }
  return changed;
}

template <int D>
StepReport Stepper<D>::eulerStep(Motion& motion, double step, const LoadSource& loads,
                                 LoadGain& given) {
  const int before = system_.factorizations();
  const double workBefore = system_.work();
  loads(motion.poses, loads_);
  // Multipliers are impulses: they go with the length of the step.
  program_.multipliers *= step / multiplierStep_;
  multiplierStep_ = step;
  beginStep(motion, step);
  if (system_.hasLigaments()) {
    const Vector rest = Vector::Zero(program_.x.size());
    system_.setLigamentsAbout(rest, LigamentBlocks::Curvature::Whole);
    program_.force = system_.force();
  }
  startSpeed_ = program_.x;
  placeHeldRows(motion.poses, step);
  report_ = {.steps = 1};
  if (!solveWithFriction(motion.poses)) report_.unconverged = 1;
  keepHeldRows(step);
  countLosses(step);
  addGain(motion.poses, step, given);
  poses_ = motion.poses;
  displace(step * program_.x);
  finishStep(motion);
  report_.factorizations = system_.factorizations() - before;
  report_.work = system_.work() - workBefore;
  return report_;
}

template <int D>
double Stepper<D>::energy(const Motion& motion) const {
  Vector x(D * bricks_.size());
  for (std::size_t i = 0; i < bricks_.size(); ++i) {
    x.segment<D>(D * i) = Space::pack(pinned_[i] ? Velocity{} : motion.velocities[i]);
  }
  return system_.kineticEnergy(motion.poses, x) +
         elasticEnergy(settings_.hingeSprings, motion.poses) +
         elasticEnergy(settings_.ligaments, motion.poses);
}

template <int D>
void Stepper<D>::transfer(StateTape& tape) {
  tape.transfer(jointStiffness_, pinned_, program_.multipliers, multiplierStep_, kept_, supports_,
                keptStep_, standstill_, system_);
  program_.exactJoints = !std::isfinite(jointStiffness_);
  system_.setPinned(pinned_);
}

template class Stepper<3>;
template class Stepper<6>;

std::unique_ptr<JointSolver> makeJointSolver(const std::vector<Brick>& bricks,
                                             std::span<const Pivot> pivots,
                                             const JointSolverSettings& settings) {
  assert(settings.planar || settings.ligaments.empty());
  if (settings.planar) return std::make_unique<Stepper<3>>(bricks, pivots, settings);
  return std::make_unique<Stepper<6>>(bricks, pivots, settings);
}

}  // namespace kirireel
