/// A sheet that grips hold, move and push: its equilibria in place of a deployment.
#pragma once

#include "sim/deploy/deployment.h"

namespace kirireel {

/// Follows the equilibria of a scene with grips (see followLoad()) from the load 0 to 1 and samples
/// them as a walk at an even pace (PathSettings::walkTime). Limit points and bifurcations are
/// events and states of the result's load curve. Settled where the load 1 is reached, else Locked.
/// Throws InputError where the scene has what equilibria of a planar sheet do not know (contacts,
/// gravity, a timeline, links, space) or no grip moves or pushes, RunError where nothing resists or
/// no equilibrium is found at the start.
DeploymentResult followGrips(const Scene& scene, double sampleInterval,
                             const SampleObserver& observer);

}  // namespace kirireel
