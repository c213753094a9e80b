/// Writes a run's trajectory on a thread of its own while the deployment goes on.
#pragma once

#include <filesystem>
#include <vector>

#include "render/record/bounded_queue.h"
#include "render/record/crew.h"
#include "render/record/samples.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Owns the file and the thread. A scribe that goes without finish() leaves no file.
class Scribe {
 public:
  /// The file gets the curves' channels (makeCurveMeter). `subject` must outlive this. Throws
  /// OutputError when the file cannot be made.
  Scribe(const std::filesystem::path& path, const Subject& subject);

  /// Hands over a sample. False once writing has failed; finish() says why. May wait for room in
  /// the queue.
  bool take(const SharedSample& sample);

  /// Waits for the last sample and puts the file in place. Throws OutputError.
  void finish(const TrajectoryEnd& end);

 private:
  void writeAll();

  TrajectoryWriter writer_;
  BoundedQueue<SharedSample> samples_;
  Crew crew_;  // last: its thread ends before what it uses
};

}  // namespace kirireel
