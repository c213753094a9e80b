/// The first step from rest at a state whose joints are singular.
#pragma once

#include <optional>

#include "sim/mechanics/extrapolation.h"

namespace kirireel::mechanics {

/// Moves bricks that are at rest at a singular state, such as a closed sheet, by one step of at
/// most `seconds`. There joints allow velocities that begin no motion, so extrapolated steps would
/// lose time and energy. The bricks accelerate evenly along the path that is nearest to their
/// acceleration by those velocities, in the metric of the masses: Gauss's principle of least
/// constraint. The step is so short that the change of the loads is within the tolerance. The bend
/// of the path adds an error of about 1e-4 of the speed at its end. Returns its length, seconds.
/// Returns nothing, with an unchanged motion, if the state is regular or bricks move. Also if
/// `mayTake` refuses the step or no such path is found, as in sheets of many bricks, whose joints
/// are too near to singular at the step's end: then `seconds` count as StepReport::singularTime.
std::optional<double> leaveSingularState(JointSolver& solver, const ExtrapolationSettings& settings,
                                         Motion& motion, double seconds, const TimedLoads& loads,
                                         const StepFilter& mayTake, StepReport& report);

}  // namespace kirireel::mechanics
