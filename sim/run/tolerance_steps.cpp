// Steps to a tolerance among contacts: extrapolated steps (extrapolation.h) among contacts that are
// held.
//
// 1. Contacts that still touch are held. Bricks at rest at a singular state leave it
//    (singular_start.h).
// 2. A filter checks each step. If bricks collide during the step, it is rejected, and the violated
//    contacts are stored.
// 3. For each of these contacts, bisection on cubics between the step's ends finds the moment at
//    which its gap becomes 0. The first of these moments is the impact. The moment at which a
//    pushing corner leaves the region of two faces is found in the same way.
//    Friction jumps if slip reverses. Slip that is linear in time predicts this moment: at first
//    between the ends of the rejected step, then from each step that ends before it (Newton's
//    method).
// 4. A step ends exactly at this moment. The impact changes velocities by the least amount in the
//    metric of the masses that lets no contact approach (no rebound; J. J. Moreau's sweeping
//    process). Its contacts are held from then on.
// 5. After more than eight impacts in one call, or if no step keeps the tolerance, the rest of the
//    call has fixed steps of first order. The report contains their duration.
#include "sim/run/tolerance_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/trajectory/measures.h"

namespace kirireel::run {
namespace {

// Times that differ by less than this fraction of a call are the same.
constexpr double kSameMoment = 1e-9;
constexpr int kMostImpacts = 8;      // impacts in one call
constexpr int kMostReversals = 100;  // steps rejected for reversals of slip in one call
// Slip below this fraction of the tolerance in the longest step counts as 0.
constexpr double kSlowSlip = 0.1;
// Steps end at these fractions of the time to a reversal. The reversal itself disturbs the
// prediction of a rejected step.
constexpr double kBeforeReversal = 0.999;
constexpr double kAfterRejection = 0.5;
// After too many impacts or changes of contacts, this number of calls has only first-order steps.
constexpr int kCallsToWait = 8;
constexpr int kImpactBisections = 60;  // these find the time to the last bit

/// The motion of only the bricks of a contact. Renumbers them in the contact.
Motion motionOf(brick::Contact& contact, const Motion& all) {
  Motion motion;
  for (int* number : {&contact.brickA, &contact.brickB}) {
    if (!brick::isBrick(*number)) continue;
    motion.poses.push_back(all.poses[*number]);
    motion.velocities.push_back(all.velocities[*number]);
    *number = static_cast<int>(motion.poses.size()) - 1;
  }
  return motion;
}

/// When a contact closes during a step, seconds after its start and at most `latest`: the last
/// moment at which it is open.
double momentOfClosing(const brick::Contact& closing, const Motion& from, const Motion& to,
                       double seconds, double latest) {
  brick::Contact contact = closing, atEnd = closing;
  const Motion start = motionOf(contact, from), end = motionOf(atEnd, to);
  double open = 0, closed = latest;
  for (int k = 0; k < kImpactBisections && brick::contactGap(contact, start.poses) > 0; ++k) {
    const double middle = 0.5 * (open + closed);
    const Poses poses = mechanics::posesBetween(start, {}, end, seconds, middle);
    (brick::contactGap(contact, poses) > 0 ? open : closed) = middle;
  }
  return open;
}

}  // namespace

/// Whether bricks touch or pass through each other in a step. Touching pairs of its start do not
/// count.
bool ToleranceSteps::touchInStep(const Motion& from, const Motion& to, double seconds) {
  if (!contacts_.exact) return false;
  std::vector<brick::Contact> violated;
  contacts_.exact->startStep(from.poses);
  contacts_.exact->appendViolated(to.poses, violated);
  if (violated.empty()) return false;
  meeting_ = {StepEvent::Collision, from, to, seconds, std::move(violated)};
  return true;
}

/// Whether a corner of a region pushes in a step at whose end it is outside.
bool ToleranceSteps::leaveBorders(const Motion& from, const Motion& to, double seconds) {
  if (!contacts_.exact) return false;
  std::vector<brick::Contact> leaving = solver_.pushingContacts();
  std::erase_if(leaving, [&](const brick::Contact& contact) {
    return contacts_.exact->insideBorders(contact, to.poses) >= -contacts_.touching;
  });
  if (leaving.empty()) return false;
  meeting_ = {StepEvent::Leaving, from, to, seconds, std::move(leaving)};
  return true;
}

/// Whether slip reverses in a step. Slip that stops is an error of the step itself.
bool ToleranceSteps::reverseSlip(const Motion& from, const Motion& to, double seconds) {
  const double slow =
      kSlowSlip * settings_.tolerance * settings_.lengthScale / settings_.longestStep;
  reversal_ = seconds * solver_.timeOfReversal(from, to, slow);
  if (reversal_ > seconds || reversals_ == kMostReversals) return false;
  ++reversals_;
  meeting_ = {StepEvent::Reversal, from, to, seconds};
  return true;
}

/// When in the step that was not taken the first corner is as far outside its region as points that
/// touch may be, seconds after its start.
double ToleranceSteps::momentOfLeaving() const {
  const auto& [event, from, to, seconds, contacts] = *meeting_;
  double inside = 0, outside = seconds;
  for (int k = 0; k < kImpactBisections && outside - inside > kSameMoment * seconds; ++k) {
    const double middle = 0.5 * (inside + outside);
    const Poses poses = mechanics::posesBetween(from, {}, to, seconds, middle);
    const bool isOut = std::ranges::any_of(contacts, [&](const brick::Contact& contact) {
      return contacts_.exact->insideBorders(contact, poses) < -0.5 * contacts_.touching;
    });
    (isOut ? outside : inside) = middle;
  }
  return outside;
}

/// When in the step that was not taken the first of its contacts closes, seconds after its start.
/// Holds nothing if bricks passed through each other.
std::optional<double> ToleranceSteps::momentOfImpact() const {
  const auto& [event, from, to, seconds, contacts] = *meeting_;
  if (event == StepEvent::Reversal) return kAfterRejection * reversal_;
  if (event == StepEvent::Leaving) return momentOfLeaving();
  std::optional<double> first;
  for (const brick::Contact& contact : contacts) {
    if (brick::contactGap(contact, to.poses) >= -0.5 * contacts_.touching)
      continue;  // touches, no more
    first = momentOfClosing(contact, from, to, seconds, first.value_or(seconds));
  }
  return first;
}

/// Has the solver hold these contacts.
void ToleranceSteps::setHeld(std::vector<brick::Contact> contacts) {
  const auto isHeld = [](const brick::Contact& contact) {
    return !brick::isBrick(contact.brickA) || !brick::isBrick(contact.brickB);
  };
  extrapolation_.setSupported(isPinned_ || contacts_.hasGroundFriction ||
                              std::ranges::any_of(contacts, isHeld));
  solver_.holdContacts(contacts);
}

/// Keeps of the contacts that are held those whose points still touch. Regions get the corners that
/// they have now.
void ToleranceSteps::holdTouching(const Poses& poses) {
  std::vector<brick::Contact> held = solver_.heldContacts();
  if (!held.empty()) contacts_.exact->startStep(poses);
  const auto isOver = [&](const brick::Contact& contact) {
    return brick::contactGap(contact, poses) > contacts_.touching ||
           !contacts_.exact->isCurrent(contact);
  };
  std::erase_if(held, isOver);
  std::vector<brick::Contact> touching;
  for (const brick::Contact& contact : held) {
    if (!contact.isRegion) {
      touching.push_back(contact);
    } else if (std::ranges::none_of(touching, [&](const brick::Contact& other) {
                 return brick::onOnePlane(other, contact);
               })) {
      const std::size_t first = touching.size();
      contacts_.exact->appendRegion(contact, touching);
      touching.erase(std::remove_if(touching.begin() + static_cast<std::ptrdiff_t>(first),
                                    touching.end(), isOver),
                     touching.end());
    }
  }
  setHeld(std::move(touching));
}

/// The impact on those of these contacts that have closed, at this moment of the call. From now on
/// they are held too. The motion before and after it are both passed. Returns the energy that is
/// lost.
double ToleranceSteps::collide(double now, const std::vector<brick::Contact>& closing,
                               Motion& motion) {
  std::vector<brick::Contact> held = solver_.heldContacts();
  for (const brick::Contact& contact : closing) {
    const bool isHeld = std::ranges::find(held, contact) != held.end();
    if (!isHeld && brick::contactGap(contact, motion.poses) <= contacts_.touching)
      held.push_back(contact);
  }
  setHeld(std::move(held));
  const double energy = trajectory::kineticEnergy(bricks_, motion);
  passed_.push_back({now, motion});
  solver_.collide(motion);
  passed_.push_back({now, motion});
  return energy - trajectory::kineticEnergy(bricks_, motion);
}

/// Continues a departure from a singular state, or begins one. Returns the seconds done.
double ToleranceSteps::depart(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                              const mechanics::StepFilter& isFree, StepReport& report) {
  const bool isHeld = !solver_.heldContacts().empty();
  if (departure_ && (isHeld || !departure_->isCurrent(motion, loads))) departure_.reset();
  if (!departure_ && !isHeld) {
    departure_ = mechanics::leaveSingularState(bricks_, solver_, settings_, motion, seconds, loads,
                                               isFree, report);
  }
  if (!departure_) return 0;
  const double done = departure_->advance(solver_, motion, seconds, passed_, report);
  if (departure_->isOver()) departure_.reset();
  return done;
}

/// Takes steps that keep the tolerance, from impact to impact, until the end of the call or until
/// no step keeps it. Returns the seconds done.
double ToleranceSteps::advanceByOrders(Motion& motion, double seconds,
                                       const mechanics::TimedLoads& loads, StepReport& report) {
  const mechanics::StepFilter isFree = [this](const Motion& from, const Motion& to, double length) {
    return !touchInStep(from, to, length) && !leaveBorders(from, to, length) &&
           !reverseSlip(from, to, length);
  };
  double done = 0;
  const mechanics::TimedLoads fromHere = [&](double after, const Poses& poses,
                                             std::vector<brick::Load>& out) {
    loads(done + after, poses, out);
  };
  const double shortest = kSameMoment * seconds;
  holdTouching(motion.poses);
  double goal = seconds;                // or the moment of the next impact
  std::vector<brick::Contact> closing;  // then
  int impacts = 0;
  reversals_ = 0;
  bool isReversing = false;  // soon
  done = depart(motion, seconds, loads, isFree, report);
  if (done > 0 && done < seconds - shortest) passed_.push_back({done, motion});
  while (done < seconds - shortest) {
    meeting_.reset();
    const auto taken = extrapolation_.step(motion, goal - done, fromHere, isFree, report);
    if (taken) {
      done += *taken;
      holdTouching(motion.poses);
      if (isReversing) goal = std::min(seconds, done + kBeforeReversal * (reversal_ - *taken));
      if (done < goal - shortest) passed_.push_back({done, motion});
    } else {
      const auto after = meeting_ ? momentOfImpact() : std::nullopt;
      if (!after) break;
      isReversing = meeting_->event == StepEvent::Reversal;
      if (!isReversing && ++impacts > kMostImpacts) break;
      goal = done + *after;
      closing.clear();
      if (meeting_->event == StepEvent::Collision) closing = meeting_->contacts;
    }
    if (done < goal - shortest) continue;
    if (!closing.empty()) report.impacted += collide(done, closing, motion);
    goal = seconds;
    closing.clear();
    isReversing = false;
  }
  return done;
}

/// Advances from one moment of the call to another in equal steps of first order with contacts.
StepReport ToleranceSteps::advanceByFirstOrder(Motion& motion, double begin, double end,
                                               const mechanics::TimedLoads& loads) {
  const double parts = std::ceil((end - begin) / firstOrderStep_ - kSameMoment);
  const int count = std::max(1, static_cast<int>(parts));
  StepReport report;
  for (int k = 0; k < count; ++k) {
    const double now = begin + k * (end - begin) / count;
    if (now > 0) passed_.push_back({now, motion});
    const mechanics::LoadSource loadsNow = [&](const Poses& poses, std::vector<brick::Load>& out) {
      loads(now, poses, out);
    };
    report += solver_.advance(motion, (end - begin) / count, loadsNow, contacts_.coarse);
  }
  return report;
}

// Steps to the tolerance as far as possible, then fixed steps.
StepReport ToleranceSteps::advance(Motion& motion, double seconds,
                                   const mechanics::TimedLoads& loads, bool isPinned) {
  isPinned_ = isPinned;
  passed_.clear();
  meeting_.reset();
  StepReport report;
  const bool isWaiting = callsToWait_ > 0;
  if (isWaiting) --callsToWait_;
  const double done = isWaiting ? 0 : advanceByOrders(motion, seconds, loads, report);
  if (done >= (1 - kSameMoment) * seconds) return report;
  const bool touch =
      isWaiting || contacts_.hasGroundFriction || meeting_ || !solver_.heldContacts().empty();
  (touch ? report.touchingTime : report.singularTime) += seconds - done;
  if (touch && !isWaiting) callsToWait_ = kCallsToWait;
  // The last state is repeated as the start of the steps that follow.
  if (done == 0) passed_.clear();
  if (!passed_.empty()) passed_.pop_back();
  report += advanceByFirstOrder(motion, done, seconds, loads);
  return report;
}

}  // namespace kirireel::run
