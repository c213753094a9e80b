/// Steps of joined bricks to a tolerance in time, by extrapolation of Euler steps.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "sim/mechanics/joint_solver.h"

namespace kirireel::mechanics {

/// Writes the load on every brick, so many seconds after the call's start, at the given poses.
using TimedLoads =
    std::function<void(double seconds, const Poses&, std::vector<model::Load>& loads)>;

/// A state on the way, so many seconds after the call's start.
struct PassedState {
  double seconds = 0;  ///< since the step began
  Motion motion;       ///< of all bricks
};

/// Whether a step of so many seconds may join two motions: false if bricks would collide between
/// them.
using StepFilter = std::function<bool(const Motion& from, const Motion& to, double seconds)>;

/// How steps are chosen.
struct ExtrapolationSettings {
  double tolerance = 1e-4;        ///< error in time that one step may make, length scales, > 0
  double longestStep = 1.0 / 60;  ///< seconds, > 0
  double lengthScale = 1;         ///< a typical tile edge, metres
  /// Whether steps keep the energy too, but for what loads give (JointSolver::energy): each of the
  /// longest to a tenth of the tolerance, as a part of the most that there was so far, and others
  /// in proportion. Stiff ligaments swing faster than positions show.
  bool keepsEnergy = false;
};

/// Advances bricks by steps whose length and order follow from the tolerance. It knows only the
/// contacts that the solver holds. The error of a step is estimated as the farthest that a brick
/// may be off at its end and, by its speed, one step later.
class Extrapolation {
 public:
  /// Bricks and solver must outlive this.
  Extrapolation(const std::vector<model::Brick>& bricks, JointSolver& solver,
                const ExtrapolationSettings& settings);

  /// Takes one step of at most `seconds`; steps of its length divide them evenly.
  /// Joints must be exact, and closed at the start: they are closed to rounding at its end. Returns
  /// the seconds taken; nothing, with the motion as it was, where `mayTake` (may be empty) refuses
  /// the step, or no step keeps the tolerance that is long enough to be worth it: at states where
  /// the joints are singular.
  /// Costs 1 + 2 + ... + k Euler steps for a step of k rows, each of which factors once, and a
  /// closing.
  std::optional<double> step(Motion& motion, double seconds, const TimedLoads& loads,
                             const StepFilter& mayTake, StepReport& report);

  /// Whether what does not move pushes some bricks: the momentum of the whole is then not its own.
  void setSupported(bool supported) { isSupported_ = supported; }

  /// The length and order of the next step, and the most energy so far.
  void transfer(StateTape& tape) { tape.transfer(length_, order_, mostEnergy_); }

 private:
  struct Trial;

  bool addRow(Trial& trial, const TimedLoads& loads, StepReport& report);
  Motion combine(const Trial& trial, int first, int last) const;
  void estimate(Trial& trial) const;
  double energyError(const Trial& trial) const;
  double difference(const Motion& a, const Motion& b, double seconds) const;
  bool tryOrders(Trial& trial, const TimedLoads& loads, StepReport& report);
  bool finish(Trial& trial, const StepFilter& mayTake);
  double caughtError(const Trial& trial) const;
  void countLosses(const Trial& trial, StepReport& report) const;
  void keepMomentum(const Trial& trial, Motion& motion) const;
  void chooseNext(const Trial& trial, bool wasRejected);
  void chooseAgain(const Trial& trial);

  const std::vector<model::Brick>& bricks_;
  JointSolver& solver_;
  ExtrapolationSettings settings_;
  bool isSupported_ = false;
  double length_;          // of the next step, seconds
  int order_;              // of the next step: so many rows are expected to do
  double mostEnergy_ = 0;  // so far, joules
};

/// The poses so many seconds after the start of `length` seconds that led from one motion to
/// another through the states passed: cubics between their poses and velocities, joints open.
Poses posesBetween(const Motion& from, std::span<const PassedState> passed, const Motion& to,
                   double length, double seconds);

/// The same of the velocities, straight between the states: wrong by the square of the step.
std::vector<Velocity> velocitiesBetween(const Motion& from, std::span<const PassedState> passed,
                                        const Motion& to, double length, double seconds);

}  // namespace kirireel::mechanics
