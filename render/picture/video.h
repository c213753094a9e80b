/// Videos, encoded as their frames come. No FFmpeg header is needed to make them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/picture/frame.h"

namespace kirireel::picture {

/// How a video is encoded. Its format is that of its file's ending, see videoFormats().
struct VideoSettings {
  FrameSize size;            ///< pixels
  int framesPerSecond = 60;  ///< 1 to 1000; a GIF shows at most 50
  std::optional<int> crf;    ///< constant quality, from 0 (best); absent: the format's usual one
  /// Of x264, "ultrafast" to "placebo"; VP9 has steps like it. "auto" is x264's "veryfast" with the
  /// quickest search for motion, which flat faces need no other than.
  std::string preset = "auto";
  std::string encoder;       ///< of libavcodec; empty: the format's usual one
  bool transparent = false;  ///< keeps alpha; else what is transparent shows white
  std::string description;   ///< who made it from what, UTF-8: the file's comment
};

/// A kind of video file. A row of the table in video.cpp.
struct VideoFormat {
  const char* ending;   ///< of its files, with the dot
  const char* name;     ///< that people know it by
  const char* muxer;    ///< of libavformat
  const char* encoder;  ///< of libavcodec, unless another is asked for
  /// Filters of libavfilter from sRGB to what the encoder takes; null: toVideoColours().
  const char* conversion;
  const char* alphaConversion;  ///< the same with alpha; null: the format has none
  bool evenSides;               ///< colour planes of half the size
  int usualCrf;                 ///< visually lossless; negative if the format has no such quality
  int worstCrf;                 ///< the largest, which is the least quality
};

/// All formats: .mp4 (H.264), .webm (VP9), .gif, .apng, .mkv (FFV1, lossless), .mov (ProRes 4444).
const std::vector<VideoFormat>& videoFormats();

/// The format of a file by its ending. Throws InputError for an ending of no format.
const VideoFormat& videoFormatOf(const std::filesystem::path& file);

/// Throws InputError that names the setting, what was given and what is allowed. MP4 and WebM need
/// even sides; crf is 0 to 51 (H.264) or 63 (VP9), and other formats have none. MP4 has no alpha.
void requireValidSettings(const std::filesystem::path& file, const VideoSettings& settings);

/// Throws OutputError when this machine's libavcodec lacks the encoder of such a file.
void requireEncoder(const std::filesystem::path& file, const VideoSettings& settings);

/// The place of an x264 preset in its list, 0 ("ultrafast") to 9 ("placebo"); that of "auto" is
/// "veryfast"'s. 10 for a word that is no preset.
int presetStep(const std::string& preset);

/// Whether videos of this name can be transparent. Throws InputError for an ending of no format.
bool hasAlpha(const std::filesystem::path& file);

/// Whether a file's ending is one of a video. Case counts.
bool isVideo(const std::filesystem::path& file);

/// The number of frames of a video file. Throws InputError if it is no video. Counts packets, one
/// per frame; decodes nothing.
int countVideoFrames(const std::filesystem::path& file);

/// Encodes frames as they come. The file appears under its final name in finish(); a writer that
/// goes without it leaves nothing. The same frames and settings give the same bytes.
///
/// Until finish() an MP4 is written frame by frame under the name of a pending file, which appears
/// with its first frame ("deployment.part.mp4"): the file that a killed process leaves plays.
///
/// Colours of MP4 and WebM are converted to BT.709, limited range, 4:2:0 (MOV: 4:4:4), and the
/// stream says so: untagged, players guess by the picture's size. GIF gets the best 256 colours of
/// each frame, one of them transparent where alpha is below a half; APNG and FFV1 keep every byte.
/// Belongs to one thread at a time. Encoding takes a thread's time for each frame; nothing is done
/// in the background.
class VideoWriter {
 public:
  /// Throws InputError for settings out of range, OutputError when the encoder is missing or the
  /// folder cannot be written.
  VideoWriter(std::filesystem::path path, const VideoSettings& settings);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Appends a frame of the settings' size. Throws OutputError (disk full, a frame of another size,
  /// already finished).
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

// ------------------------------------------------------------------------------------------------
// Pictures as video encoders take them: brightness and two differences of colours.

/// Where a plane of a picture goes.
struct VideoPlane {
  std::uint8_t* rows = nullptr;  ///< the first row
  std::ptrdiff_t stride = 0;     ///< bytes from one row's start to the next
};

/// All of a picture. The second and the third have half as many rows and columns as the first.
struct VideoPlanes {
  VideoPlane brightness;  ///< Y': 16 (black) to 235 (white)
  VideoPlane blueness;    ///< Cb: 16 to 240, 128 for grey
  VideoPlane redness;     ///< Cr: the same
};

/// Copies a row of RGBA pixels over white: c' = c a / 255 + 255 (1 - a / 255), rounded;
/// alpha becomes 255. `copy` has room for 4 width bytes.
void copyOverWhite(const std::uint8_t* row, int width, std::uint8_t* copy);

/// Converts a frame of even width and height from sRGB to BT.709, limited range, 4:2:0, the
/// coloured samples in line with the left pixels. What is transparent shows white. Each byte is the
/// nearest to the exact value, but for the rounding of floats. The planes must be large enough. One
/// pass over the frame.
void toVideoColours(const Frame& frame, const VideoPlanes& planes);

}  // namespace kirireel::picture
