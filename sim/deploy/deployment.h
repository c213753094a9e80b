/// A deployment: one run from the start towards the target.
#pragma once

#include "sim/run/checkpoints.h"
#include "sim/run/result.h"
#include "sim/run/search.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// Runs the scene along its path (see planPath and chooseDynamicPath). Samples it at the start,
/// every `sampleInterval` simulated seconds, and at the end. The interval does not affect the
/// steps: a sample between two steps is interpolated from their poses. Throws InputError for
/// invalid scenes. A run that diverges does not throw: it ends with its last step that lost no
/// brick. `searching` receives each trial of the path search and may end the run. Either observer
/// may be empty.
run::DeploymentResult deploy(const scene::Scene& scene, double sampleInterval,
                             const run::SampleObserver& observer,
                             const run::TrialObserver& searching = {});

/// The same, but only the observer receives the samples. The result's trajectory holds none, and
/// memory does not grow with the run. `checkpoints` may be null. Otherwise the run continues from a
/// checkpoint if there is one, with its samples first. It writes new ones during the run and when
/// the observer ends it. An engine's hidden state cannot be saved: such runs write none.
run::DeploymentResult deployUnkept(const scene::Scene& scene, double sampleInterval,
                                   const run::SampleObserver& observer,
                                   const run::TrialObserver& searching = {},
                                   run::Checkpoints* checkpoints = nullptr);

}  // namespace kirireel::deploy
