/// Steps of a scene's bricks that keep a tolerance in time, from impact to impact.
#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/contacts/contact_finder.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"

namespace kirireel::run {

/// What bricks run into in steps to a tolerance.
struct ToleranceContacts {
  contacts::ContactFinder* coarse =
      nullptr;  ///< for steps of first order; null where nothing can be touched
  contacts::ContactFinder* exact = nullptr;  ///< for those that keep the tolerance; null likewise
  double touching = 0;                       ///< gap of points that touch, metres
  bool isRubbing = false;                    ///< planar bricks rub on a ground with friction
};

/// Takes steps that keep a tolerance among contacts that are held, and steps of first order where
/// that cannot be done.
class ToleranceSteps {
 public:
  /// Bricks, solver and finders must outlive this. `firstOrderStep`: see TimeTolerance.
  ToleranceSteps(const std::vector<model::Brick>& bricks, mechanics::JointSolver& solver,
                 const ToleranceContacts& contacts,
                 const mechanics::ExtrapolationSettings& settings, double firstOrderStep)
      : bricks_(bricks),
        solver_(solver),
        contacts_(contacts),
        firstOrderStep_(firstOrderStep),
        extrapolation_(bricks, solver, settings) {}

  /// Advances the motion by so many seconds. `isPinned`: some brick is.
  StepReport advance(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                     bool isPinned);

  /// The states between the ends of the last call, in order.
  std::vector<mechanics::PassedState>& passed() { return passed_; }
  /// The states within the last step, in rising time, its ends left out.
  const std::vector<mechanics::PassedState>& passed() const { return passed_; }

  /// What the next call takes from those before.
  void transfer(StateTape& tape) { tape.transfer(callsToWait_, extrapolation_); }

 private:
  bool meetOnTheWay(const Motion& from, const Motion& to, double seconds);
  bool leaveBorders(const Motion& from, const Motion& to, double seconds);
  std::optional<double> momentOfImpact() const;
  double momentOfLeaving() const;
  void setHeld(std::vector<model::Contact> contacts);
  void holdTouching(const Poses& poses);
  double collide(double now, const std::vector<model::Contact>& closing, Motion& motion);
  double advanceByOrders(Motion& motion, double seconds, const mechanics::TimedLoads& loads,
                         StepReport& report);
  StepReport goOnByFirstOrder(Motion& motion, double begin, double end,
                              const mechanics::TimedLoads& loads);

  /// A step that was not taken, because bricks meet in it, or because a corner of a region pushes
  /// that leaves it.
  struct Meeting {
    Motion from;
    Motion to;
    double seconds = 0;
    std::vector<model::Contact> contacts;  // that are violated at its end, whole planes of them
    bool isLeaving = false;                // else they meet
  };

  const std::vector<model::Brick>& bricks_;
  mechanics::JointSolver& solver_;
  ToleranceContacts contacts_;
  double firstOrderStep_;  // seconds
  mechanics::Extrapolation extrapolation_;
  bool isPinned_ = false;
  std::optional<Meeting> meeting_;  // of the step that was tried last
  int callsToWait_ = 0;             // by first order, after impacts crowded
  std::vector<mechanics::PassedState> passed_;
};

}  // namespace kirireel::run
