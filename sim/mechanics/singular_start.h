/// The first motion from rest at a state whose joints are singular.
#pragma once

#include <optional>
#include <vector>

#include "sim/base/state_tape.h"
#include "sim/mechanics/extrapolation.h"

namespace kirireel::mechanics {

/// A motion from rest at a singular state to a regular one, which several calls play back.
struct Departure {
  Motion start;                     ///< at rest
  std::vector<PassedState> states;  ///< with closed joints; the last one is the end
  double damped = 0;                ///< energy that dampers take until the end, joules
  std::vector<brick::Load> loads;   ///< at the start
  double done = 0;                  ///< seconds that have been played back
  Motion now;                       ///< the state then

  /// Whether a motion and the loads at the start are still those of this departure.
  bool isCurrent(const Motion& motion, const TimedLoads& loadsNow) const;
  /// Whether everything has been played back.
  bool isOver() const { return done >= states.back().seconds; }
  /// Advances the motion by at most `seconds`, and appends the states between. Returns the seconds.
  double advance(JointSolver& solver, Motion& motion, double seconds,
                 std::vector<PassedState>& passed, StepReport& report);

  void transfer(StateTape& tape) { tape.transfer(start, states, damped, loads, done, now); }
};

/// The motion of bricks that are at rest at a singular state, such as a closed sheet. There joints
/// allow velocities that begin no motion, so extrapolated steps would lose time and energy. The
/// bricks move along a path of closed states through the start: of the accelerations along it, the
/// one that is nearest to that of the loads, in the metric of the masses (Gauss's principle of
/// least constraint). The motion ends at the nearest state that is regular enough for rounding.
/// Returns nothing if the start is regular or bricks move. Also if no path is found or if `mayTake`
/// refuses the motion: then `seconds` count as StepReport::singularTime.
std::optional<Departure> leaveSingularState(const std::vector<brick::Brick>& bricks,
                                            JointSolver& solver,
                                            const ExtrapolationSettings& settings,
                                            const Motion& motion, double seconds,
                                            const TimedLoads& loads, const StepFilter& mayTake,
                                            StepReport& report);

}  // namespace kirireel::mechanics
