/// A deployment: one run from the start towards the target.
#pragma once

#include "sim/deploy/checkpoints.h"
#include "sim/deploy/result.h"
#include "sim/deploy/search.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// Runs the scene along its path (see choosePath) and samples it every `sampleInterval` simulated
/// seconds from the start on, and at the end. Nothing else depends on that interval: the steps are
/// the scene's, and a sample between two of them is made from their poses. Throws InputError when
/// the scene makes no sense; a run that diverges is reported, not thrown, and ends with its last
/// step that left no brick behind. `searching` is told of each trial while a path is sought, and
/// may end the run. Either observer may be empty.
DeploymentResult deploy(const scene::Scene& scene, double sampleInterval,
                        const SampleObserver& observer, const TrialObserver& searching = {});

/// The same, but the samples go to the observer alone: the result's trajectory holds none, so that
/// memory does not grow with the length of the run. With checkpoints, which may be null, the run
/// goes on from the one that was found there, its samples first, and leaves others on its way and
/// where the observer ends it. An engine's hidden state cannot be kept: such runs leave none.
DeploymentResult deployUnkept(const scene::Scene& scene, double sampleInterval,
                              const SampleObserver& observer, const TrialObserver& searching = {},
                              Checkpoints* checkpoints = nullptr);

}  // namespace kirireel::deploy
