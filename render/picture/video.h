/// Videos, encoded frame by frame. Needs no FFmpeg header.
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

/// Encoding settings of a video. The ending of its file selects the format, see videoFormats().
struct VideoSettings {
  FrameSize size;            ///< pixels
  int framesPerSecond = 60;  ///< 1 to 1000; a GIF shows at most 50
  std::optional<int> crf;    ///< constant quality, >= 0 (best); absent: the format's default
  /// Of x264, "ultrafast" to "placebo"; VP9 has similar steps. "auto" is x264's "veryfast" with the
  /// fastest motion search, which is sufficient for flat faces.
  std::string preset = "auto";
  std::string encoder;       ///< of libavcodec; empty: the format's default
  bool transparent = false;  ///< keeps alpha; else transparent parts are white
  std::string description;   ///< author and source, UTF-8: the file's comment
};

/// A video format, a row of the table in video.cpp.
struct VideoFormat {
  const char* ending;   ///< of its files, with the dot
  const char* name;     ///< common name
  const char* muxer;    ///< of libavformat
  const char* encoder;  ///< default of libavcodec
  /// Filters of libavfilter from sRGB to the encoder's format; null: toVideoColours().
  const char* conversion;
  const char* alphaConversion;  ///< the same with alpha; null: the format has none
  bool evenSides;               ///< colour planes of half the size
  int defaultCrf;               ///< visually lossless; < 0 if the format has no such quality
  int worstCrf;                 ///< the maximum: the lowest quality
};

/// All formats: .mp4 (H.264), .webm (VP9), .gif, .apng, .mkv (FFV1, lossless), .mov (ProRes 4444).
const std::vector<VideoFormat>& videoFormats();

/// The format of a file by its ending. Throws InputError for an ending of no format.
const VideoFormat& videoFormatOf(const std::filesystem::path& file);

/// Throws InputError with the setting, its value and the allowed values. MP4 and WebM need even
/// sides; crf is 0 to 51 (H.264) or 63 (VP9), and other formats have none. MP4 has no alpha.
void requireValidSettings(const std::filesystem::path& file, const VideoSettings& settings);

/// Throws OutputError if this machine's libavcodec lacks the encoder for such a file.
void requireEncoder(const std::filesystem::path& file, const VideoSettings& settings);

/// Index of an x264 preset in its list, 0 ("ultrafast") to 9 ("placebo"). "auto" counts as
/// "veryfast". 10 for an unknown word.
int presetStep(const std::string& preset);

/// Whether videos with this name can be transparent. Throws InputError for an unknown ending.
bool hasAlpha(const std::filesystem::path& file);

/// Whether a file's ending is one of a video. Case counts.
bool isVideo(const std::filesystem::path& file);

/// The number of frames of a video file. Counts packets, one per frame, without decoding. Throws
/// InputError if it is not a video.
int countVideoFrames(const std::filesystem::path& file);

/// Encodes frames one by one. The file appears under its final name in finish(). Without finish()
/// nothing remains. Equal frames and settings give equal bytes.
///
/// Before finish() an MP4 is written frame by frame to a temporary file ("deployment.part.mp4"),
/// which appears with its first frame. If the process is killed, that file is playable.
///
/// Colours of MP4 and WebM are converted to BT.709, limited range, 4:2:0 (MOV: 4:4:4), and the
/// stream is tagged so. For untagged streams players guess by the picture's size. GIF gets the best
/// 256 colours per frame, one of them transparent for alpha below a half. APNG and FFV1 keep every
/// byte. Use it in one thread at a time. Encoding takes this thread's time; there is no background
/// work.
class VideoWriter {
 public:
  /// Throws InputError for settings out of range, OutputError if the encoder is missing or the
  /// folder cannot be written.
  VideoWriter(std::filesystem::path path, const VideoSettings& settings);
  ~VideoWriter();
  VideoWriter(const VideoWriter&) = delete;
  VideoWriter& operator=(const VideoWriter&) = delete;

  /// Appends a frame of the settings' size. Throws OutputError (disk full, a frame of another size,
  /// already finished).
  void write(const Frame& frame);

  /// Encodes pending frames and completes the file. Call it once, after at least one frame. Throws
  /// OutputError.
  void finish();

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

/// The version of libavcodec in use, e.g. "59.37.100".
std::string encoderLibraryVersion();

// ------------------------------------------------------------------------------------------------
// Pictures for video encoders: brightness and two colour differences.

/// A plane of a picture.
struct VideoPlane {
  std::uint8_t* rows = nullptr;  ///< the first row
  std::ptrdiff_t stride = 0;     ///< bytes from one row's start to the next
};

/// All planes of a picture. The second and the third have half as many rows and columns.
struct VideoPlanes {
  VideoPlane brightness;  ///< Y': 16 (black) to 235 (white)
  VideoPlane blueness;    ///< Cb: 16 to 240, 128 for grey
  VideoPlane redness;     ///< Cr: the same
};

/// Copies a row of RGBA pixels over white: c' = c a / 255 + 255 (1 - a / 255), rounded;
/// alpha becomes 255. `copy` has room for 4 width bytes.
void copyOverWhite(const std::uint8_t* row, int width, std::uint8_t* copy);

/// Converts a frame of even width and height from sRGB to BT.709, limited range, 4:2:0, with colour
/// samples aligned with the left pixels. Transparent parts become white. Each byte is the nearest
/// to the exact value, up to the rounding of floats. The planes must be large enough. One pass over
/// the frame.
void toVideoColours(const Frame& frame, const VideoPlanes& planes);

}  // namespace kirireel::picture
