/// Time that the processor spent.
#pragma once

namespace kirireel {

/// CPU seconds that the calling thread has used so far.
double threadCpuSeconds();

}  // namespace kirireel
