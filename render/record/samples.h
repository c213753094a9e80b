/// Where the samples of a run come from: a deployment under way, or a file.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

#include "sim/trajectory/trajectory.h"

namespace kirireel {

/// A sample that several threads may read at the same time.
using SharedSample = std::shared_ptr<const Sample>;

/// How many samples wait between two threads: enough to even out their pace, and all the memory that
/// they may take.
inline constexpr std::size_t kWaitingSamples = 16;

/// Takes the next sample of a run; false asks for an early end.
using SampleTaker = std::function<bool(const SharedSample&)>;

/// Gives a run to a taker, sample by sample, and returns when it is over.
using SampleFeed = std::function<void(const SampleTaker&)>;

}  // namespace kirireel
