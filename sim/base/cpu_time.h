/// Time that the processor spent.
#pragma once

namespace kirireel {

/// CPU seconds that the calling thread has used so far.
double threadCpuSeconds();

/// The same of all threads of this process, those that libraries started too.
double processCpuSeconds();

}  // namespace kirireel
