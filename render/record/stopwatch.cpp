#include "render/record/stopwatch.h"

#include <sys/resource.h>

namespace kirireel {

std::int64_t peakMemoryBytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;  // Linux counts kibibytes
}

}  // namespace kirireel
