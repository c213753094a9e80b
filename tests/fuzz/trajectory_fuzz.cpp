// A trajectory.h5: all except the poses, then those of the first and the last sample.
#include "sim/trajectory/trajectory_file.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

/// For the sanitizer: HDF5 leaks some memory for a file that it refuses.
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libhdf5";
}

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzz::place("trajectory.h5", fuzz::inputText(bytes, size));
  fuzz::read([] {
    const trajectory::TrajectoryReader run(fuzz::folder() / "trajectory.h5");
    fuzz::requireSound(run.subject().model);
    run.sample(0);
    run.sample(run.times().size() - 1);
  });
  return 0;
}
