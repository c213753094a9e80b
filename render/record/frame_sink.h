/// Where painted frames go: into the video, into single files, or both.
///
/// Frames come in the order of the video. The sink keeps the last one, since nobody knows that it
/// is the last before finish() is called, and it may have to be shown longer.
#pragma once

#include <optional>

#include "render/png/png.h"
#include "render/record/record.h"
#include "render/video/video.h"

namespace kirireel {

/// How the run's video is encoded.
VideoSettings videoSettings(const PictureSettings& settings);

/// How its single pictures are written.
PngSettings pngSettings(const PictureSettings& settings);

/// How many more frames the first and the last one are shown for. Rounded: settings.heldSeconds()
/// times the frames a second.
int heldFrames(const PictureSettings& settings);

/// Encodes and writes frames in order; holds the first and the last as long as the settings say.
/// Belongs to the thread that makes it.
class FrameSink {
 public:
  /// Throws OutputError when the video cannot be made. Settings and report must outlive the sink.
  FrameSink(const PictureSettings& settings, PictureReport& report);

  /// Shows a card before the first frame. Throws OutputError.
  void putTitle(const Frame& card);

  /// Returns a frame that is needed no more, empty at first. Throws OutputError. With `frames` it
  /// also writes frames/frame_00000.png and so on.
  Frame put(Frame frame);

  /// Puts the video in place and reports; without it, no video is left. Throws OutputError.
  void finish();

 private:
  void encode(const Frame& frame, int times);

  const PictureSettings& settings_;
  PictureReport& report_;
  std::optional<VideoWriter> video_;
  int heldFrames_;
  int number_ = 0;  ///< of the next frame
  Frame last_;
  int videoFrames_ = 0;
  std::vector<std::string> files_;
};

}  // namespace kirireel
