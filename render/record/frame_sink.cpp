// A video shows a title card for two seconds, its first frame 1 + h times, each other frame once,
// and its last frame h times more, with h = hold x frames a second. To repeat a frame costs its
// encoding, so it is done here and not by painting it again.
#include "render/record/frame_sink.h"

#include <cmath>
#include <utility>

#include "render/folder/output_folder.h"
#include "render/png/png.h"
#include "render/record/stopwatch.h"
#include "sim/base/interruption.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

constexpr double kTitleSeconds = 2;

}  // namespace

VideoSettings videoSettings(const PictureSettings& settings) {
  return {.size = settings.size,
          .framesPerSecond = settings.framesPerSecond,
          .crf = settings.crf,
          .preset = settings.preset,
          .encoder = settings.encoder,
          .description = settings.madeBy};
}

PngSettings pngSettings(const PictureSettings& settings) {
  return {.dotsPerInch = settings.dotsPerInch, .description = settings.madeBy};
}

int heldFrames(const PictureSettings& settings) {
  return static_cast<int>(std::lround(settings.heldSeconds() * settings.framesPerSecond));
}

FrameSink::FrameSink(const PictureSettings& settings, PictureReport& report)
    : settings_(settings), report_(report), heldFrames_(heldFrames(settings)) {
  if (settings.frames) makeFolder(settings.folder / output::kFrames);
  if (settings.video) video_.emplace(settings.folder / settings.videoFile, videoSettings(settings));
}

void FrameSink::encode(const Frame& frame, int times) {
  for (int k = 0; k < times; ++k) {
    checkInterruption();
    video_->write(frame);
  }
  videoFrames_ += times;
}

void FrameSink::putTitle(const Frame& card) {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) encode(card, static_cast<int>(kTitleSeconds * settings_.framesPerSecond));
}

Frame FrameSink::put(Frame frame) {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) encode(frame, number_ == 0 ? 1 + heldFrames_ : 1);
  if (settings_.frames) {
    writePng(frame, settings_.folder / frameFile(number_), pngSettings(settings_));
    files_.push_back(frameFile(number_).string());
  }
  ++number_;
  std::swap(last_, frame);
  return frame;
}

void FrameSink::finish() {
  const CpuTimer timer(report_.recordCost.cpuSecondsEncode);
  if (video_) {
    encode(last_, heldFrames_);
    video_->finish();
    files_.push_back(settings_.videoFile);
  }
  report_.videoFrames = videoFrames_;
  report_.files.insert(report_.files.end(), files_.begin(), files_.end());
}

}  // namespace kirireel
