// The choice of the dense kernels for the processor at hand, once for the whole program. Asking the
// processor at run time lets one binary serve old and new machines.
#include "sim/joints/dense_kernels.h"

namespace kirireel {

const DenseKernels& denseKernels() {
#ifdef KIRIREEL_HAS_AVX2_KERNELS
  static const bool newer = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (newer) return avx2::kKernels;
#endif
  return baseline::kKernels;
}

}  // namespace kirireel
