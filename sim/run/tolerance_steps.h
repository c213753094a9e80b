/// Steps of a scene's bricks that keep a tolerance in time, from impact to impact.
#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/contacts/contact_finder.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/mechanics/singular_start.h"

namespace kirireel::run {

/// Contact finders for steps to a tolerance.
struct ToleranceContacts {
  contacts::ContactFinder* coarse =
      nullptr;  ///< for steps of first order; null if no contact is possible
  contacts::ContactFinder* exact =
      nullptr;                     ///< for steps to the tolerance; null if no contact is possible
  double touching = 0;             ///< gap of points that touch, metres
  bool hasGroundFriction = false;  ///< planar bricks lie on a ground with friction
};

/// Takes steps that keep a tolerance while contacts are held, and steps of first order if that is
/// impossible.
class ToleranceSteps {
 public:
  /// Bricks, solver and finders must outlive this. `firstOrderStep`: see TimeTolerance.
  ToleranceSteps(const std::vector<brick::Brick>& bricks, mechanics::JointSolver& solver,
                 const ToleranceContacts& contacts,
                 const mechanics::ExtrapolationSettings& settings, double firstOrderStep)
      : bricks_(bricks),
        solver_(solver),
        contacts_(contacts),
        settings_(settings),
        firstOrderStep_(firstOrderStep),
        extrapolation_(bricks, solver, settings) {
    // A long step shows which touching bricks press on each other.
    if (contacts.exact) extrapolation_.tryLongest();
  }

  /// Advances the motion by `seconds`. `isPinned`: whether any brick is pinned.
  StepReport advance(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                     bool isPinned);

  /// The states between the ends of the last call, in order.
  std::vector<mechanics::PassedState>& passed() { return passed_; }
  /// The same, read-only.
  const std::vector<mechanics::PassedState>& passed() const { return passed_; }

  /// State that the next call needs from earlier calls.
  void transfer(StateTape& tape) { tape.transfer(callsToWait_, extrapolation_, departure_); }

 private:
  bool touchInStep(const Motion& from, const Motion& to, double seconds);
  bool leaveBorders(const Motion& from, const Motion& to, double seconds);
  bool reverseSlip(const Motion& from, const Motion& to, double seconds);
  std::optional<double> momentOfImpact() const;
  double momentOfLeaving() const;
  void setHeld(std::vector<brick::Contact> contacts);
  void holdTouching(const Poses& poses);
  double collide(double now, const std::vector<brick::Contact>& closing, Motion& motion);
  double depart(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                const mechanics::StepFilter& isFree, StepReport& report);
  double advanceByOrders(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                         StepReport& report);
  StepReport advanceByFirstOrder(Motion& motion, double begin, double end,
                                 const mechanics::TimedLoads& loads);

  /// What ends a step: bricks collide, a pushing corner leaves its region, or slip reverses.
  enum class StepEvent { Collision, Leaving, Reversal };

  /// A rejected step with an event in it.
  struct Meeting {
    StepEvent event = StepEvent::Collision;
    Motion from;
    Motion to;
    double seconds = 0;
    std::vector<brick::Contact> contacts = {};  // violated at its end; whole planes
  };

  const std::vector<brick::Brick>& bricks_;
  mechanics::JointSolver& solver_;
  ToleranceContacts contacts_;
  mechanics::ExtrapolationSettings settings_;
  double firstOrderStep_;  // seconds
  mechanics::Extrapolation extrapolation_;
  bool isPinned_ = false;
  std::optional<Meeting> meeting_;  // of the last tried step
  double reversal_ = 0;             // of slip, seconds after the start of that step
  int reversals_ = 0;               // steps of the call that were rejected for them
  int callsToWait_ = 0;             // calls that use first order after too many impacts
  std::optional<mechanics::Departure> departure_;  // from a singular start; absent after it
  std::vector<mechanics::PassedState> passed_;
};

}  // namespace kirireel::run
