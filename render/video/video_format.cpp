// The table of formats. To add one, give its ending, its muxer and encoder as `ffmpeg -muxers` and
// `ffmpeg -encoders` name them, and the filters that lead from RGBA to a pixel format of the
// encoder.
//
// GIF: 256 colours a frame at most; palettegen finds them for each frame by itself
// (stats_mode=single), and paletteuse without dither keeps flat faces flat. Its times are
// hundredths of a second, and many players show frames that are shorter than two of them more
// slowly, so at most 50 frames a second are written.
#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "render/video/video.h"
#include "sim/base/error.h"

namespace kirireel {
namespace {

constexpr std::array kPresets = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                 "medium",    "slow",      "slower",   "veryslow", "placebo"};

// GIF counts hundredths of a second, and players slow down what has fewer than two a frame.
// Without dither, flat faces stay flat.
constexpr const char* kToPalette =
    "fps=fps='min(source_fps,50)':eof_action=pass,format=rgb24,split[a][b];"
    "[a]palettegen=stats_mode=single[p];[b][p]paletteuse=dither=none:new=1";

std::string nameAll(const std::vector<VideoFormat>& formats) {
  std::vector<std::string> endings;
  for (const VideoFormat& format : formats) endings.emplace_back(format.ending);
  return fmt::format("{}", fmt::join(endings, ", "));
}

/// Colour planes of half the size need even sides; padding by a row would show as a line.
void requireFittingSize(const VideoFormat& format, FrameSize size) {
  requireValidSize(size);
  const auto [width, height] = size;
  if (!format.evenSides || (width % 2 == 0 && height % 2 == 0)) return;
  throw InputError(
      fmt::format("error: a video of {} x {} pixels has an odd side; {} needs even "
                  "ones, for example --size {}x{}",
                  width, height, format.name, width + width % 2, height + height % 2));
}

void requireFittingQuality(const VideoFormat& format, std::optional<int> crf) {
  if (!crf) return;
  if (format.usualCrf < 0) {
    throw InputError(fmt::format("error: {} has no crf to choose; leave --crf away", format.name));
  }
  if (*crf >= 0 && *crf <= format.worstCrf) return;
  throw InputError(
      fmt::format("error: the video's crf is {}; give 0 (best) to {} (worst), for example {}", *crf,
                  format.worstCrf, format.usualCrf));
}

}  // namespace

const std::vector<VideoFormat>& videoFormats() {
  static const std::vector<VideoFormat> formats = {
      {".mp4", "H.264", "mp4", "libx264", nullptr, true, false, 18, 51},
      {".webm", "VP9", "webm", "libvpx-vp9", nullptr, true, false, 24, 63},
      {".gif", "GIF", "gif", "gif", kToPalette, false, false, -1, -1},
      {".apng", "APNG", "apng", "apng", "format=rgba", false, true, -1, -1},
      {".mkv", "FFV1", "matroska", "ffv1", "format=bgr0", false, false, -1, -1},
  };
  return formats;
}

bool isVideo(const std::filesystem::path& file) {
  return std::ranges::find(videoFormats(), file.extension().string(), &VideoFormat::ending) !=
         videoFormats().end();
}

const VideoFormat& videoFormatOf(const std::filesystem::path& file) {
  const std::vector<VideoFormat>& formats = videoFormats();
  const std::string ending = file.extension().string();
  const auto found = std::ranges::find_if(
      formats, [&](const VideoFormat& format) { return format.ending == ending; });
  if (found != formats.end()) return *found;
  throw InputError(fmt::format("{}: error: no video format goes with this name; let it end in {}",
                               file.string(), nameAll(formats)));
}

void requireValidSettings(const std::filesystem::path& file, const VideoSettings& settings) {
  const VideoFormat& format = videoFormatOf(file);
  requireFittingSize(format, settings.size);
  if (settings.framesPerSecond < 1 || settings.framesPerSecond > 1000) {
    throw InputError(fmt::format("error: {} frames a second are not possible; give 1 to 1000",
                                 settings.framesPerSecond));
  }
  requireFittingQuality(format, settings.crf);
  const bool isKnown =
      settings.preset == "auto" || std::ranges::find(kPresets, settings.preset) != kPresets.end();
  if (!isKnown) {
    throw InputError(fmt::format("error: x264 has no preset \"{}\"; give auto, or one of {}",
                                 settings.preset, fmt::join(kPresets, ", ")));
  }
}

int presetStep(const std::string& preset) {
  const auto place = std::ranges::find(kPresets, preset == "auto" ? "veryfast" : preset);
  return static_cast<int>(place - kPresets.begin());
}

}  // namespace kirireel
