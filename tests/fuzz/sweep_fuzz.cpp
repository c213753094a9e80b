// A sweep file, and the first and the last run of its plan.
#include "render/sweep/sweep_plan.h"
#include "tests/fuzz/fuzz_input.h"

using namespace kirireel;

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzz::place("sweep.toml", fuzz::inputText(bytes, size));
  fuzz::read([] {
    const sweep::SweepPlan plan = sweep::readSweepFile(fuzz::folder() / "sweep.toml").plan;
    plan.run(0);
    plan.run(plan.size() - 1);
  });
  return 0;
}
