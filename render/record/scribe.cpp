// Writing and compressing samples takes time: on a thread of its own it costs the deployment
// nothing as long as there is a core for it. Sixteen samples may wait; then the deployment waits.
#include "render/record/scribe.h"

#include "sim/measure/run_curves.h"

namespace kirireel {

Scribe::Scribe(const std::filesystem::path& path, const Subject& subject)
    : writer_(path, subject, makeCurveMeter(subject)),
      samples_(kWaitingSamples),
      crew_([this] { samples_.stop(); }) {
  crew_.start([this] { writeAll(); });
}

bool Scribe::take(const SharedSample& sample) {
  return samples_.push(sample);
}

void Scribe::writeAll() {
  while (const std::optional<SharedSample> sample = samples_.pop()) writer_.append(**sample);
}

void Scribe::finish(const TrajectoryEnd& end) {
  samples_.close();
  crew_.finish();
  writer_.finish(end);
}

}  // namespace kirireel
