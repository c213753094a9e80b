/// Samples that are handed from thread to thread.
///
/// A sample is shared and never changed, so that no thread needs a copy or a lock to read it; it
/// goes when the last thread has done with it.
#pragma once

#include <cstddef>
#include <memory>

#include "sim/trajectory/trajectory.h"

namespace kirireel {

/// A sample that several threads may read at the same time.
using SharedSample = std::shared_ptr<const Sample>;

/// How many samples wait between two threads: enough to even out their pace, and all the memory
/// that they may take.
inline constexpr std::size_t kWaitingSamples = 16;

}  // namespace kirireel
