/// The pictures of a run: video, single frames, snapshot grid.
#pragma once

#include "render/record/bounded_queue.h"
#include "render/record/record.h"
#include "render/record/samples.h"
#include "render/studio/studio.h"
#include "sim/trajectory/trajectory_file.h"

namespace kirireel {

/// Whether a camera that cuts something off is the program's mistake, not the settings' wish.
bool choosesCamera(const PictureSettings& settings);

/// Whether the camera is known before the run, so that frames can be painted while it goes on.
bool paintsAlong(const Model& model, const PictureSettings& settings);

/// A run as a studio sees it before it begins, its start and its target in sight.
Motif motifOf(const Subject& subject);

/// The same of a finished run, with everything in sight that the settings ask for; `whole`: all of
/// it whatever they ask for.
Motif motifOf(const TrajectoryReader& run, const PictureSettings& settings, bool whole = false);

/// Throws InputError when the look or the grid asks for what the motif cannot give, before anything
/// is deployed.
void requirePaintable(const Motif& motif, const PictureSettings& settings);

/// One studio and what it photographs. Belongs to the thread that makes it.
class Album {
 public:
  /// Settings and report must outlive the album. Throws InputError when the look asks for what the
  /// motif lacks, OutputError when no graphics context can be made.
  Album(const PictureSettings& settings, Motif motif, PictureReport& report);

  /// From now on something that leaves the picture ends the video, see makeFrames().
  void watchSight() { watchesSight_ = true; }

  /// Paints what the feed gives and encodes it, all three at the same time on threads of their own
  /// (painting on this one). The bytes do not depend on which is faster. False when something left
  /// the picture that is watched: then there is no video, and the feed was taken to its end all the
  /// same.
  /// Throws the first error of any of the three.
  bool makeFrames(const SampleFeed& feed);

  /// Whether no sample of the run leaves the picture.
  bool sees(const TrajectoryReader& run) const;

  /// Writes the snapshot grid, the timeline's snapshots and chosen frames of a finished run. Throws
  /// OutputError.
  void writeSnapshots(const TrajectoryReader& run);

 private:
  using FrameQueue = BoundedQueue<Frame>;
  using SampleQueue = BoundedQueue<SharedSample>;

  void paint(SampleQueue& samples, FrameQueue& frames);
  void encode(FrameQueue& frames);
  bool isInSight(const Sample& sample) const;
  Frame take(const Sample& sample, Studio::Scales scales);
  std::string caption(const Sample& sample, bool hasTarget) const;
  void writeDrawing(const Sample& sample, int number);
  void writeGrid(const TrajectoryReader& run);
  void writeMoments(const TrajectoryReader& run);
  void writeChosenFrames(const TrajectoryReader& run);

  const PictureSettings& settings_;
  PictureReport& report_;
  Studio studio_;
  bool watchesSight_ = false;
  bool lostSight_ = false;
};

}  // namespace kirireel
