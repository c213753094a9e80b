/// Steps of joined bricks to a tolerance in time, by extrapolation of Euler steps.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/mechanics/joint_solver.h"

namespace kirireel::mechanics {

/// Writes the loads on all bricks at these poses, at a time in seconds after the call's start.
using TimedLoads =
    std::function<void(double seconds, const Poses&, std::vector<brick::Load>& loads)>;

/// An intermediate state of a call.
struct PassedState {
  double seconds = 0;  ///< since the step began
  Motion motion;       ///< of all bricks

  void transfer(StateTape& tape) { tape.transfer(seconds, motion); }
};

/// Whether a step of this length in seconds may join two motions. False if bricks would collide
/// between them.
using StepFilter = std::function<bool(const Motion& from, const Motion& to, double seconds)>;

/// Settings of the step control.
struct ExtrapolationSettings {
  double tolerance = 1e-4;        ///< maximum error in time of one step, length scales, > 0
  double longestStep = 1.0 / 60;  ///< seconds, > 0
  double lengthScale = 1;         ///< a typical tile edge, metres
  /// Whether steps also conserve energy, except for the work of loads (JointSolver::energy). This
  /// is needed because stiff springs oscillate faster than positions show. The longest step may
  /// change the energy by a tenth of the tolerance, relative to the maximum so far. Shorter steps
  /// may change it in proportion. Errors below the rounding of the energy are not resolved, see
  /// StepReport::energyRounding.
  bool keepsEnergy = false;
};

/// Advances bricks by steps whose length and order follow from the tolerance. It knows only the
/// contacts that the solver holds. The error estimate of a step is the largest error of a brick's
/// position at its end, and of its speed times one further step.
class Extrapolation {
 public:
  /// Keeps references to bricks and solver.
  Extrapolation(const std::vector<brick::Brick>& bricks, JointSolver& solver,
                const ExtrapolationSettings& settings);

  /// Takes one step of at most `seconds`, whose length divides `seconds` evenly. Joints must be
  /// exact, and closed at the start. They are closed to rounding at the end. Returns the length of
  /// the step, seconds. Returns nothing, with an unchanged motion, if `mayTake` refuses the step or
  /// if no step above the minimum length keeps the tolerance, as in states with singular joints.
  /// A tolerance below 1e-6 may be less than rounding errors. The step then keeps the tolerance
  /// times the smallest possible power of ten, see StepReport::rounding. `mayTake` may be empty.
  /// Costs 1 + 2 + ... + k Euler steps for a step of k rows, each with one factorisation, and one
  /// closing of the joints.
  std::optional<double> step(Motion& motion, double seconds, const TimedLoads& loads,
                             const StepFilter& mayTake, StepReport& report);

  /// Tries the longest step next.
  void tryLongest() { length_ = settings_.longestStep; }

  /// Whether fixed objects push some bricks: total momentum is then not conserved.
  void setSupported(bool supported) { isSupported_ = supported; }

  /// The length and order of the next step, the maximum energy and rounding so far, and the slack.
  void transfer(StateTape& tape) {
    tape.transfer(length_, order_, maxEnergy_, energyRounding_, slack_);
  }

 private:
  struct Trial;

  /// Result of a search for a step.
  struct StepSearch {
    std::optional<double> taken = {};  // seconds
    bool isRefused = false;            // by the filter
  };

  double tolerance() const { return slack_ * settings_.tolerance; }
  StepSearch tryLengths(Motion& motion, double energy, double seconds, const TimedLoads& loads,
                        const StepFilter& mayTake, StepReport& report);
  void countRounding(const Trial& trial, StepReport& report) const;

  bool addRow(Trial& trial, const TimedLoads& loads, StepReport& report);
  Motion combine(const Trial& trial, int first, int last) const;
  void estimate(Trial& trial) const;
  double allowedEnergy(const Trial& trial, double most) const;
  double energyError(const Trial& trial) const;
  double roundingOf(const Motion& motion, double energy) const;
  double difference(const Motion& a, const Motion& b, double seconds) const;
  bool tryOrders(Trial& trial, const TimedLoads& loads, StepReport& report);
  bool finish(Trial& trial);
  double stickingError(const Trial& trial) const;
  void countLosses(const Trial& trial, StepReport& report) const;
  void keepMomentum(const Trial& trial, Motion& motion) const;
  void keepForces(const Trial& trial) const;
  void chooseNext(const Trial& trial, bool wasRejected);
  void chooseAgain(const Trial& trial);

  const std::vector<brick::Brick>& bricks_;
  JointSolver& solver_;
  ExtrapolationSettings settings_;
  bool isSupported_ = false;
  double length_;              // of the next step, seconds
  int order_;                  // of the next step: expected number of rows
  double maxEnergy_ = 0;       // maximum so far, joules
  double slack_ = 1;           // factor on the tolerance if rounding errors exceed it
  double energyRounding_ = 0;  // of an energy, maximum so far, joules
};

/// The poses at a time in a step of `length` seconds between two motions, through intermediate
/// states. They are cubics through poses and velocities. Joints are not closed.
Poses posesBetween(const Motion& from, std::span<const PassedState> passed, const Motion& to,
                   double length, double seconds);

/// Velocities at this time, interpolated linearly: the error is quadratic in the step.
std::vector<Velocity> velocitiesBetween(const Motion& from, std::span<const PassedState> passed,
                                        const Motion& to, double length, double seconds);

}  // namespace kirireel::mechanics
