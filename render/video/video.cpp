#include "render/video/video.h"

#include <algorithm>
#include <array>

#include <fmt/format.h>
#include <fmt/ranges.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "sim/base/error.h"
#include "sim/base/pending_file.h"

namespace kirireel {
namespace {

constexpr std::array kPresets = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                 "medium",    "slow",      "slower",   "veryslow", "placebo"};

// x264's macroblock tree (a bit-rate saving) reads unset memory, and so gives other bytes from run
// to run, where a row of macroblocks is no whole number of its vectors: 8 macroblocks of 16 pixels.
constexpr int kTreeWidth = 128;

// libav's objects are freed through a pointer to their pointer.
struct Free {
  void operator()(AVCodecContext* encoder) const { avcodec_free_context(&encoder); }
  void operator()(AVFrame* image) const { av_frame_free(&image); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(SwsContext* converter) const { sws_freeContext(converter); }
  void operator()(AVFormatContext* container) const {
    avio_closep(&container->pb);
    avformat_free_context(container);
  }
};
template <typename T>
using Owned = std::unique_ptr<T, Free>;

std::string reasonOf(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

/// A copy with every pixel composed over white.
std::vector<std::uint8_t> overWhite(const Frame& frame) {
  std::vector<std::uint8_t> pixels = frame.pixels;
  for (std::size_t k = 0; k < pixels.size(); k += 4) {
    const int alpha = pixels[k + 3];
    for (std::size_t channel = k; channel < k + 3; ++channel) {
      const int mixed = pixels[channel] * alpha + 255 * (255 - alpha);
      pixels[channel] = static_cast<std::uint8_t>((mixed + 127) / 255);
    }
  }
  return pixels;
}

}  // namespace

void requireValidSettings(const VideoSettings& settings) {
  requireValidSize(settings.size);
  const auto [width, height] = settings.size;
  if (width % 2 != 0 || height % 2 != 0) {
    throw InputError(
        fmt::format("error: a video of {} x {} pixels has an odd side; H.264 needs even "
                    "ones, for example --size {}x{}",
                    width, height, width + width % 2, height + height % 2));
  }
  if (settings.framesPerSecond < 1 || settings.framesPerSecond > 1000) {
    throw InputError(fmt::format("error: {} frames a second are not possible; give 1 to 1000",
                                 settings.framesPerSecond));
  }
  if (settings.crf < 0 || settings.crf > 51) {
    throw InputError(
        fmt::format("error: the video's crf is {}; give 0 (lossless) to 51 (worst), for example 18",
                    settings.crf));
  }
  if (std::ranges::find(kPresets, settings.preset) == kPresets.end()) {
    throw InputError(fmt::format("error: x264 has no preset \"{}\"; give one of {}",
                                 settings.preset, fmt::join(kPresets, ", ")));
  }
}

struct VideoWriter::Internals {
  Internals(std::filesystem::path path, const VideoSettings& videoSettings);

  void openEncoder();
  void openContainer();
  void openConverter();
  void requireOpen() const;
  void convert(const Frame& frame);
  void encode(const AVFrame* input);

  /// Throws OutputError when a libav call reported an error.
  void check(int code) const;

  VideoSettings settings;
  PendingFile file;
  Owned<AVCodecContext> encoder;
  Owned<AVFormatContext> container;
  Owned<SwsContext> converter;
  Owned<AVFrame> image;
  Owned<AVPacket> packet;
  AVStream* stream = nullptr;  ///< owned by the container
  std::int64_t frames = 0;     ///< written so far
  bool finished = false;
};

VideoWriter::Internals::Internals(std::filesystem::path path, const VideoSettings& videoSettings)
    : settings(videoSettings),
      file(std::move(path)),
      image(av_frame_alloc()),
      packet(av_packet_alloc()) {
  // libav prints on the error stream by itself; what matters is thrown.
  av_log_set_level(AV_LOG_QUIET);
  openEncoder();
  openContainer();
  openConverter();
}

void VideoWriter::Internals::check(int code) const {
  if (code >= 0) return;
  throw OutputError(
      fmt::format("{}: error: the video cannot be written ({}); free some space or "
                  "choose another folder with --out",
                  file.finalPath().string(), reasonOf(code)));
}

void VideoWriter::Internals::openEncoder() {
  const AVCodec* codec = avcodec_find_encoder_by_name(settings.encoder.c_str());
  if (codec == nullptr) {
    throw OutputError(
        fmt::format("{}: error: libavcodec has no encoder {} here, so no video can be "
                    "made; install Debian's libavcodec-extra, or an FFmpeg built with it",
                    file.finalPath().string(), settings.encoder));
  }
  encoder.reset(avcodec_alloc_context3(codec));
  encoder->width = settings.size.width;
  encoder->height = settings.size.height;
  encoder->sample_aspect_ratio = {1, 1};
  encoder->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder->time_base = {1, settings.framesPerSecond};
  encoder->framerate = {settings.framesPerSecond, 1};
  encoder->color_primaries = AVCOL_PRI_BT709;
  encoder->color_trc = AVCOL_TRC_BT709;
  encoder->colorspace = AVCOL_SPC_BT709;
  encoder->color_range = AVCOL_RANGE_MPEG;
  encoder->chroma_sample_location = AVCHROMA_LOC_LEFT;
  // x264 with several threads gives other bytes for another number of them.
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_opt_set_int(encoder->priv_data, "crf", settings.crf, 0);
  av_opt_set(encoder->priv_data, "preset", settings.preset.c_str(), 0);
  if (settings.size.width % kTreeWidth != 0) av_opt_set_int(encoder->priv_data, "mbtree", 0, 0);
  const int code = avcodec_open2(encoder.get(), codec, nullptr);
  if (code < 0) {
    throw OutputError(
        fmt::format("{}: error: {} refuses a video of {} x {} pixels ({}); try a smaller "
                    "--size",
                    file.finalPath().string(), settings.encoder, settings.size.width,
                    settings.size.height, reasonOf(code)));
  }
}

void VideoWriter::Internals::openContainer() {
  AVFormatContext* made = nullptr;
  check(avformat_alloc_output_context2(&made, nullptr, "mp4", file.path().c_str()));
  container.reset(made);
  // No creation time, no library version: the same frames give the same bytes.
  container->flags |= AVFMT_FLAG_BITEXACT;
  stream = avformat_new_stream(container.get(), nullptr);
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  check(avcodec_parameters_from_context(stream->codecpar, encoder.get()));
  check(avio_open(&container->pb, file.path().c_str(), AVIO_FLAG_WRITE));
  // The index goes to the front, so that players can start before they have the whole file.
  AVDictionary* options = nullptr;
  av_dict_set(&options, "movflags", "+faststart", 0);
  const int code = avformat_write_header(container.get(), &options);
  av_dict_free(&options);
  check(code);
}

void VideoWriter::Internals::openConverter() {
  const auto [width, height] = settings.size;
  converter.reset(sws_getContext(width, height, AV_PIX_FMT_RGBA, width, height, AV_PIX_FMT_YUV420P,
                                 SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP, nullptr,
                                 nullptr, nullptr));
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  constexpr int kFullRange = 1;
  constexpr int kLimitedRange = 0;
  constexpr int kUnchanged = 1 << 16;  // contrast and saturation, 16.16 fixed point
  check(sws_setColorspaceDetails(converter.get(), bt709, kFullRange, bt709, kLimitedRange, 0,
                                 kUnchanged, kUnchanged));
  image->width = width;
  image->height = height;
  image->format = AV_PIX_FMT_YUV420P;
  check(av_frame_get_buffer(image.get(), 0));
}

void VideoWriter::Internals::requireOpen() const {
  if (!finished) return;
  throw OutputError(
      fmt::format("{}: error: the video is finished already", file.finalPath().string()));
}

void VideoWriter::Internals::convert(const Frame& frame) {
  // The encoder may still hold the buffer of the frame before.
  check(av_frame_make_writable(image.get()));
  const std::vector<std::uint8_t> composed =
      isOpaque(frame) ? std::vector<std::uint8_t>() : overWhite(frame);
  const std::uint8_t* pixels = composed.empty() ? frame.pixels.data() : composed.data();
  const int stride = 4 * frame.size.width;
  sws_scale(converter.get(), &pixels, &stride, 0, frame.size.height, image->data, image->linesize);
}

void VideoWriter::Internals::encode(const AVFrame* input) {
  check(avcodec_send_frame(encoder.get(), input));
  while (true) {
    const int code = avcodec_receive_packet(encoder.get(), packet.get());
    // It wants more frames, or has given all.
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    check(code);
    packet->stream_index = stream->index;
    packet->duration = 1;
    av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
    check(av_interleaved_write_frame(container.get(), packet.get()));
    check(container->pb->error);
  }
}

VideoWriter::VideoWriter(std::filesystem::path path, const VideoSettings& settings) {
  requireValidSettings(settings);
  internals_ = std::make_unique<Internals>(std::move(path), settings);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const Frame& frame) {
  Internals& in = *internals_;
  in.requireOpen();
  if (frame.size != in.settings.size) {
    throw OutputError(fmt::format("{}: error: a frame of {} x {} pixels in a video of {} x {}",
                                  in.file.finalPath().string(), frame.size.width, frame.size.height,
                                  in.settings.size.width, in.settings.size.height));
  }
  in.convert(frame);
  in.image->pts = in.frames++;
  in.encode(in.image.get());
}

void VideoWriter::finish() {
  Internals& in = *internals_;
  in.requireOpen();
  if (in.frames == 0) {
    throw OutputError(
        fmt::format("{}: error: a video needs at least one frame", in.file.finalPath().string()));
  }
  in.encode(nullptr);
  in.check(av_write_trailer(in.container.get()));
  in.check(in.container->pb->error);
  in.check(avio_closep(&in.container->pb));
  in.file.commit();
  in.finished = true;
}

std::string encoderLibraryVersion() {
  const unsigned version = avcodec_version();
  return fmt::format("{}.{}.{}", AV_VERSION_MAJOR(version), AV_VERSION_MINOR(version),
                     AV_VERSION_MICRO(version));
}

}  // namespace kirireel
