// The summary.json of a run: unchanged, and with a matching seal.
#include "render/output/output_folder.h"
#include "render/record/summary.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/support/trajectories.h"

using namespace kirireel;

namespace {

/// The trajectory that the summary is compared with: a sheet of four tiles at rest.
bool writeRun() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  scene.model = generate::makeTessellation(shape);
  trajectory::Trajectory run{trajectory::subjectOf(scene)};
  for (const double time : {0.0, 0.5}) {
    run.samples.push_back(
        {.time = time, .poses = brick::startPoses(scene.model.tiles, run.bricks)});
  }
  test::writeTrajectory(run, fuzz::folder() / "trajectory.h5");
  return true;
}

void readSummary(const std::string& text) {
  fuzz::place("summary.json", text);
  fuzz::read([] { record::verifyRun(fuzz::folder()); });
  fuzz::read([] { record::findFinishedRun(fuzz::folder(), "order"); });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const bool once = writeRun();
  const std::string text(fuzz::inputText(bytes, size));
  readSummary(text);
  constexpr std::size_t kEnd = 3;  // "\n}\n", which the seal goes before
  if (once && size >= kEnd) readSummary(output::sealed(text));
  return 0;
}
