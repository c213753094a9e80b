/// H.264 video in MP4, as every player and paper supplement takes it. No FFmpeg header is needed to
/// use it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// How a video is encoded.
struct VideoSettings {
  FrameSize size;                   ///< pixels; both sides even, as halved colour planes need
  int framesPerSecond = 60;         ///< 1 to 1000
  int crf = 18;                     ///< constant quality, 0 (lossless) to 51; 18 looks lossless
  std::string preset = "veryfast";  ///< of x264, "ultrafast" to "placebo"
  std::string encoder = "libx264";  ///< of libavcodec; one that takes x264's options
};

/// Throws InputError that names the setting, what was given and what is allowed.
void requireValidSettings(const VideoSettings& settings);

/// Encodes frames as they come. The file appears under its final name in finish(); a writer that
/// goes without it leaves nothing. The same frames and settings give the same bytes.
///
/// Colours are converted to BT.709, limited range, 4:2:0, and the stream says so: untagged, players
/// guess by the picture's size.
class VideoWriter {
 public:
  /// Throws InputError for settings out of range, OutputError when the encoder is missing or the
  /// folder cannot be written.
  VideoWriter(std::filesystem::path path, const VideoSettings& settings);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Appends a frame of the settings' size; what is transparent shows white. Throws OutputError
  /// (disk full, a frame of another size, already finished).
  void write(const Frame& frame);

  /// Encodes what is pending and puts the file in place. Call it once, after one frame at least;
  /// throws OutputError.
  void finish();

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The version of libavcodec in use, e.g. "59.37.100".
std::string encoderLibraryVersion();

}  // namespace kirireel
