// Encodes frames to a file with FFmpeg's libraries (libavfilter, libavcodec, libavformat;
// ffmpeg.org, "Doxygen Documentation"):
//
//     Frame (sRGB, RGBA)
//       -> toVideoColours (MP4, WebM), or a filter graph "buffer -> conversion -> buffersink"
//       -> encoder: avcodec_send_frame, avcodec_receive_packet until it asks for more
//       -> container: av_interleaved_write_frame
//
// The time base is 1 / frames per second, and frame k has the time k.
//
// MP4. During encoding the file is fragmented (ISO/IEC 14496-12, movie fragments): an index without
// samples, then a fragment per packet. The file of a killed process is playable up to there.
// finish() copies the packets, without encoding, to a file with the index before the samples
// ("faststart"). Players can then start before they have the whole file.
//
// Equal frames give equal bytes: one thread per encoder, the flags "bitexact", no creation times,
// and no macroblock tree in x264 if it would read uninitialised memory (kTreeWidth).
//
// libav reports errors by negative numbers. check() converts them to OutputError. An empty buffer
// (EAGAIN) and its end (EOF) are not errors.
#include "render/picture/video.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/base/interruption.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace kirireel::picture {
namespace {

// x264's macroblock tree (a bit-rate saving) reads uninitialised memory if the number of
// macroblocks per row is not a multiple of its vectors: 8 macroblocks of 16 pixels. Its output
// bytes then vary between runs.
constexpr int kTreeWidth = 128;

// A third less CPU time than "veryfast" at the same SSIM for a tenth more bytes (100 rotating
// squares, 1280 x 720, crf 18: 4.9 and 8.0 ms per frame, 0.9962 and 0.9963, 4.2 and 3.7 MB). There
// is no search for positions of B-frames: regular positions suit an even motion.
constexpr const char* kQuickSearch = "me=dia:subme=1:weightp=0:b-adapt=0";

// libav frees objects through a pointer to their pointer.
struct Free {
  void operator()(AVCodecContext* encoder) const { avcodec_free_context(&encoder); }
  void operator()(AVFrame* image) const { av_frame_free(&image); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVFilterGraph* graph) const { avfilter_graph_free(&graph); }
  void operator()(AVFilterInOut* ends) const { avfilter_inout_free(&ends); }
  void operator()(AVFormatContext* container) const {
    if (container->iformat != nullptr) {
      avformat_close_input(&container);
    } else {
      avio_closep(&container->pb);
      avformat_free_context(container);
    }
  }
};
template <typename T>
using Owned = std::unique_ptr<T, Free>;

std::string reasonOf(int code) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
  av_strerror(code, text.data(), text.size());
  return text.data();
}

/// A file name for libav: without the prefix, "a:b.mp4" would be a protocol "a".
std::string urlOf(const std::filesystem::path& file) {
  return "file:" + file.string();
}

/// Throws OutputError if there is no encoder with this name.
const AVCodec* findEncoder(const std::filesystem::path& file, const std::string& name) {
  const AVCodec* codec = avcodec_find_encoder_by_name(name.c_str());
  if (codec != nullptr) return codec;
  throw OutputError(
      fmt::format("{}: error: libavcodec has no encoder {} here, so no video can be "
                  "made; install Debian's libavcodec-extra, or choose another with --encoder or "
                  "another ending with --video",
                  file.string(), name));
}

/// `image` is RGBA and has the frame's size.
void copyPixels(const Frame& frame, bool keepAlpha, AVFrame& image) {
  for (int y = 0; y < frame.size.height; ++y) {
    const std::uint8_t* from = frame.pixels.data() + frame.rowStart(y);
    std::uint8_t* to = image.data[0] + static_cast<std::ptrdiff_t>(y) * image.linesize[0];
    if (keepAlpha) {
      std::memcpy(to, from, static_cast<std::size_t>(frame.size.width) * 4);
    } else {
      copyOverWhite(from, frame.size.width, to);
    }
  }
}

/// The three planes of a picture in YUV 4:2:0.
VideoPlanes planesOf(const AVFrame& image) {
  const auto plane = [&image](int k) { return VideoPlane{image.data[k], image.linesize[k]}; };
  return {plane(0), plane(1), plane(2)};
}

/// A dictionary of libav's options, freed at the end of its scope.
class Options {
 public:
  Options() = default;
  ~Options() { av_dict_free(&dictionary_); }
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;

  void set(const char* name, const std::string& value) {
    av_dict_set(&dictionary_, name, value.c_str(), 0);
  }
  AVDictionary** get() { return &dictionary_; }

 private:
  AVDictionary* dictionary_ = nullptr;
};

}  // namespace

/// Members are constructed in this order: filters need the encoder's format.
struct VideoWriter::Internals {
  Internals(std::filesystem::path path, const VideoSettings& videoSettings);

  void openFilters();
  void makeImage();
  void openEncoder();
  void setQuality() const;
  void openContainer();
  void flushFragment();
  void requireOpen() const;
  void put(const Frame& frame);
  void pullFiltered();
  void encode(const AVFrame* input);
  void close();
  void noteDescription();
  void moveIndexToFront();

  /// Throws OutputError if a libav call reported an error.
  void check(int code) const;
  /// The same for calls that may fail because of the size.
  void requireAccepted(int code) const;
  bool isMp4() const { return std::strcmp(format.muxer, "mp4") == 0; }

  VideoSettings settings;
  const VideoFormat& format;
  const char* conversion = nullptr;  ///< of the format, with or without alpha
  PendingFile file;
  Owned<AVFilterGraph> filters;
  Owned<AVCodecContext> encoder;
  Owned<AVFormatContext> container;
  Owned<AVFrame> image;     ///< as given
  Owned<AVFrame> filtered;  ///< as encoded
  Owned<AVPacket> packet;
  AVFilterContext* source = nullptr;  ///< owned by the filters; null without filters
  AVFilterContext* sink = nullptr;    ///< the same
  AVStream* stream = nullptr;         ///< owned by the container
  std::int64_t frames = 0;            ///< written so far
  bool hasIndex = false;              ///< whether the file has the index of fragments
  bool finished = false;
};

VideoWriter::Internals::Internals(std::filesystem::path path, const VideoSettings& videoSettings)
    : settings(videoSettings),
      format(videoFormatOf(path)),
      file(std::move(path)),
      image(av_frame_alloc()),
      filtered(av_frame_alloc()),
      packet(av_packet_alloc()) {
  // libav prints to standard error by itself; relevant errors are thrown.
  av_log_set_level(AV_LOG_QUIET);
  if (settings.encoder.empty()) settings.encoder = format.encoder;
  conversion = settings.transparent ? format.alphaConversion : format.conversion;
  if (conversion != nullptr) openFilters();
  makeImage();
  openEncoder();
}

void VideoWriter::Internals::check(int code) const {
  if (code >= 0) return;
  throw OutputError(
      fmt::format("{}: error: the video cannot be written ({}); free some space or "
                  "choose another folder with --out",
                  file.finalPath().string(), reasonOf(code)));
}

void VideoWriter::Internals::requireAccepted(int code) const {
  if (code >= 0) return;
  throw OutputError(
      fmt::format("{}: error: {} refuses a video of {} x {} pixels ({}); try a smaller "
                  "--size",
                  file.finalPath().string(), settings.encoder, settings.size.width,
                  settings.size.height, reasonOf(code)));
}

/// "in" and "out" are the open ends of the filter text.
void VideoWriter::Internals::openFilters() {
  filters.reset(avfilter_graph_alloc());
  filters->nb_threads = 1;
  const auto [width, height] = settings.size;
  const std::string given = fmt::format(
      "video_size={}x{}:pix_fmt={}:time_base=1/{}:frame_rate={}:pixel_aspect=1/1", width, height,
      static_cast<int>(AV_PIX_FMT_RGBA), settings.framesPerSecond, settings.framesPerSecond);
  requireAccepted(avfilter_graph_create_filter(&source, avfilter_get_by_name("buffer"), "in",
                                               given.c_str(), nullptr, filters.get()));
  check(avfilter_graph_create_filter(&sink, avfilter_get_by_name("buffersink"), "out", nullptr,
                                     nullptr, filters.get()));
  const auto end = [](const char* name, AVFilterContext* filter) {
    AVFilterInOut* made = avfilter_inout_alloc();
    *made = {av_strdup(name), filter, 0, nullptr};
    return made;
  };
  AVFilterInOut* from = end("in", source);
  AVFilterInOut* to = end("out", sink);
  const int code = avfilter_graph_parse_ptr(filters.get(), conversion, &to, &from, nullptr);
  avfilter_inout_free(&from);
  avfilter_inout_free(&to);
  check(code);
  requireAccepted(avfilter_graph_config(filters.get(), nullptr));
}

void VideoWriter::Internals::makeImage() {
  image->width = settings.size.width;
  image->height = settings.size.height;
  image->format = conversion == nullptr ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_RGBA;
  image->sample_aspect_ratio = {1, 1};
  requireAccepted(av_frame_get_buffer(image.get(), 0));
}

/// Each encoder uses the options that it knows and ignores the others.
void VideoWriter::Internals::setQuality() const {
  void* options = encoder->priv_data;
  const int crf = settings.crf.value_or(format.defaultCrf);
  if (crf >= 0) av_opt_set_int(options, "crf", crf, 0);
  if (settings.encoder == "libx264") {
    const bool isAuto = settings.preset == "auto";
    av_opt_set(options, "preset", isAuto ? "veryfast" : settings.preset.c_str(), 0);
    if (isAuto) av_opt_set(options, "x264-params", kQuickSearch, 0);
    if (settings.size.width % kTreeWidth != 0) av_opt_set_int(options, "mbtree", 0, 0);
  } else if (settings.encoder == "libvpx-vp9") {
    av_opt_set_int(options, "cpu-used", 5 - presetStep(settings.preset) / 2, 0);
  } else if (settings.encoder == "ffv1") {
    encoder->level = 3;  // slices with checksums
  }
}

/// Colours other than RGB are BT.709, limited range, and tagged so.
void VideoWriter::Internals::openEncoder() {
  const AVCodec* codec = findEncoder(file.finalPath(), settings.encoder);
  encoder.reset(avcodec_alloc_context3(codec));
  encoder->width = settings.size.width;
  encoder->height = settings.size.height;
  encoder->sample_aspect_ratio = {1, 1};
  if (sink != nullptr) {
    encoder->pix_fmt = static_cast<AVPixelFormat>(av_buffersink_get_format(sink));
    encoder->time_base = av_buffersink_get_time_base(sink);
    encoder->framerate = av_buffersink_get_frame_rate(sink);
  } else {
    encoder->pix_fmt = AV_PIX_FMT_YUV420P;
    encoder->time_base = {1, settings.framesPerSecond};
    encoder->framerate = {settings.framesPerSecond, 1};
  }
  const AVPixFmtDescriptor* pixels = av_pix_fmt_desc_get(encoder->pix_fmt);
  if ((pixels->flags & AV_PIX_FMT_FLAG_RGB) == 0) {
    encoder->color_primaries = AVCOL_PRI_BT709;
    encoder->color_trc = AVCOL_TRC_BT709;
    encoder->colorspace = AVCOL_SPC_BT709;
    encoder->color_range = AVCOL_RANGE_MPEG;
    if (pixels->log2_chroma_w == 1) encoder->chroma_sample_location = AVCHROMA_LOC_LEFT;
  }
  // x264 with several threads gives different bytes for different numbers of threads.
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  setQuality();
  const int code = avcodec_open2(encoder.get(), codec, nullptr);
  requireAccepted(code);
}

/// Called with the first packet: a video that fails earlier leaves no file.
void VideoWriter::Internals::openContainer() {
  AVFormatContext* made = nullptr;
  check(avformat_alloc_output_context2(&made, nullptr, format.muxer, urlOf(file.path()).c_str()));
  container.reset(made);
  // No creation time and no library version: equal frames give equal bytes.
  container->flags |= AVFMT_FLAG_BITEXACT;
  stream = avformat_new_stream(container.get(), nullptr);
  stream->time_base = encoder->time_base;
  stream->avg_frame_rate = encoder->framerate;
  check(avcodec_parameters_from_context(stream->codecpar, encoder.get()));
  check(avio_open(&container->pb, urlOf(file.path()).c_str(), AVIO_FLAG_WRITE));
  noteDescription();
  Options options;
  if (isMp4()) {
    options.set("movflags", "+delay_moov+default_base_moof+frag_custom");
  }
  if (std::strcmp(format.muxer, "apng") == 0) options.set("plays", "0");  // infinite loop
  container->flush_packets = 1;
  check(avformat_write_header(container.get(), options.get()));
}

/// Writes all encoded packets. The first call writes only the index.
void VideoWriter::Internals::flushFragment() {
  check(av_write_frame(container.get(), nullptr));
  if (!std::exchange(hasIndex, true)) check(av_write_frame(container.get(), nullptr));
}

void VideoWriter::Internals::requireOpen() const {
  if (!finished) return;
  throw OutputError(
      fmt::format("{}: error: the video is finished already", file.finalPath().string()));
}

/// All frames use the same image buffer.
void VideoWriter::Internals::put(const Frame& frame) {
  // The filters or the encoder may still use the buffer of the previous frame.
  check(av_frame_make_writable(image.get()));
  image->pts = frames++;
  if (source == nullptr) {
    toVideoColours(frame, planesOf(*image));
    encode(image.get());
    return;
  }
  copyPixels(frame, settings.transparent, *image);
  check(av_buffersrc_add_frame_flags(source, image.get(), AV_BUFFERSRC_FLAG_KEEP_REF));
  pullFiltered();
}

/// Encodes the output of the filters.
void VideoWriter::Internals::pullFiltered() {
  while (true) {
    const int code = av_buffersink_get_frame(sink, filtered.get());
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    check(code);
    filtered->pict_type = AV_PICTURE_TYPE_NONE;
    // ProRes stores the colours of frames.
    filtered->color_primaries = encoder->color_primaries;
    filtered->color_trc = encoder->color_trc;
    filtered->colorspace = encoder->colorspace;
    filtered->color_range = encoder->color_range;
    encode(filtered.get());
    av_frame_unref(filtered.get());
  }
}

/// A null frame flushes the encoder: it returns all remaining packets.
void VideoWriter::Internals::encode(const AVFrame* input) {
  check(avcodec_send_frame(encoder.get(), input));
  while (true) {
    const int code = avcodec_receive_packet(encoder.get(), packet.get());
    checkInterruption();
    // The encoder needs more frames, or has returned all packets.
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    check(code);
    // A file without frames would not be a video.
    if (!container) openContainer();
    packet->stream_index = stream->index;
    packet->duration = 1;
    av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
    check(av_interleaved_write_frame(container.get(), packet.get()));
    if (isMp4()) flushFragment();
    check(container->pb->error);
  }
}

/// Flushes the filters, then the encoder, then the container, since each may hold frames of the
/// previous one.
void VideoWriter::Internals::close() {
  if (source != nullptr) {
    check(av_buffersrc_add_frame(source, nullptr));
    pullFiltered();
  }
  encode(nullptr);
  check(av_write_trailer(container.get()));
  check(container->pb->error);
  check(avio_closep(&container->pb));
}

/// Stores the author and source as the file's comment.
void VideoWriter::Internals::noteDescription() {
  if (settings.description.empty()) return;
  check(av_dict_set(&container->metadata, "comment", settings.description.c_str(), 0));
}

/// Copies the fragments to one file that starts with its index. Players can start before they have
/// the whole file.
void VideoWriter::Internals::moveIndexToFront() {
  AVFormatContext* opened = nullptr;
  check(avformat_open_input(&opened, urlOf(file.path()).c_str(), nullptr, nullptr));
  const Owned<AVFormatContext> fragments(opened);
  const AVStream* from = fragments->streams[0];

  std::filesystem::path wholeName = file.finalPath();
  wholeName.replace_extension(".whole.mp4");
  PendingFile whole(wholeName);
  AVFormatContext* made = nullptr;
  check(avformat_alloc_output_context2(&made, nullptr, format.muxer, urlOf(whole.path()).c_str()));
  container.reset(made);
  container->flags |= AVFMT_FLAG_BITEXACT;
  AVStream* to = avformat_new_stream(container.get(), nullptr);
  check(avcodec_parameters_copy(to->codecpar, from->codecpar));
  to->time_base = from->time_base;
  to->avg_frame_rate = encoder->framerate;
  check(avio_open(&container->pb, urlOf(whole.path()).c_str(), AVIO_FLAG_WRITE));
  noteDescription();
  Options options;
  options.set("movflags", "+faststart");
  check(avformat_write_header(container.get(), options.get()));
  while (av_read_frame(fragments.get(), packet.get()) >= 0) {
    av_packet_rescale_ts(packet.get(), from->time_base, to->time_base);
    packet->pos = -1;
    check(av_interleaved_write_frame(container.get(), packet.get()));
    check(container->pb->error);
  }
  check(av_write_trailer(container.get()));
  check(container->pb->error);
  check(avio_closep(&container->pb));
  std::filesystem::rename(whole.path(), file.path());
}

void requireEncoder(const std::filesystem::path& file, const VideoSettings& settings) {
  findEncoder(file, settings.encoder.empty() ? videoFormatOf(file).encoder : settings.encoder);
}

VideoWriter::VideoWriter(std::filesystem::path path, const VideoSettings& settings) {
  requireValidSettings(path, settings);
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
  in.put(frame);
}

void VideoWriter::finish() {
  Internals& in = *internals_;
  in.requireOpen();
  if (in.frames == 0) {
    throw OutputError(
        fmt::format("{}: error: a video needs at least one frame", in.file.finalPath().string()));
  }
  in.close();
  if (in.isMp4()) in.moveIndexToFront();
  in.file.commit();
  in.finished = true;
}

int countVideoFrames(const std::filesystem::path& file) {
  AVFormatContext* opened = nullptr;
  const Owned<AVPacket> packet(av_packet_alloc());
  if (avformat_open_input(&opened, urlOf(file).c_str(), nullptr, nullptr) < 0) {
    throw InputError(fmt::format("{}: error: this is not a video", file.string()));
  }
  const Owned<AVFormatContext> video(opened);
  int frames = 0;
  while (av_read_frame(video.get(), packet.get()) >= 0) {
    ++frames;
    av_packet_unref(packet.get());
  }
  return frames;
}

std::string encoderLibraryVersion() {
  const unsigned version = avcodec_version();
  return fmt::format("{}.{}.{}", AV_VERSION_MAJOR(version), AV_VERSION_MINOR(version),
                     AV_VERSION_MICRO(version));
}

// ------------------------------------------------------------------------------------------------
// The table of formats. A new format needs its ending, its muxer and encoder as named by `ffmpeg
// -muxers` and `ffmpeg -encoders`, and the filters from RGBA to a pixel format of the encoder.
//
// GIF: at most 256 colours per frame. palettegen finds them for each frame separately
// (stats_mode=single), and paletteuse without dither keeps flat faces flat. Its times are in
// hundredths of a second. Many players slow down frames shorter than two hundredths, so at most 50
// frames per second are written.

namespace {

constexpr std::array kPresets = {"ultrafast", "superfast", "veryfast", "faster",   "fast",
                                 "medium",    "slow",      "slower",   "veryslow", "placebo"};

// GIF counts hundredths of a second, and players slow down frames shorter than two hundredths.
// Without dither, flat faces stay flat.
constexpr const char* kToPalette =
    "fps=fps='min(source_fps,50)':eof_action=pass,format=rgb24,split[a][b];"
    "[a]palettegen=stats_mode=single[p];[b][p]paletteuse=dither=none:new=1";
constexpr const char* kToClearPalette =
    "fps=fps='min(source_fps,50)':eof_action=pass,format=rgba,split[a][b];"
    "[a]palettegen=stats_mode=single:reserve_transparent=1[p];"
    "[b][p]paletteuse=dither=none:new=1:alpha_threshold=128";
constexpr const char* kToAlphaColours =
    "scale=out_color_matrix=bt709:out_range=limited,format=yuva420p";
constexpr const char* kToFullColours =
    "scale=out_color_matrix=bt709:out_range=limited,format=yuv444p10le";
constexpr const char* kToFullAlphaColours =
    "scale=out_color_matrix=bt709:out_range=limited,format=yuva444p10le";

std::string nameAll(const std::vector<VideoFormat>& formats) {
  std::vector<std::string> endings;
  for (const VideoFormat& format : formats) endings.emplace_back(format.ending);
  return fmt::format("{}", fmt::join(endings, ", "));
}

/// Colour planes of half size need even sides; a padding row would be visible as a line.
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
  if (format.defaultCrf < 0) {
    throw InputError(fmt::format("error: {} has no crf; remove --crf", format.name));
  }
  if (*crf >= 0 && *crf <= format.worstCrf) return;
  throw InputError(
      fmt::format("error: the video's crf is {}; give 0 (best) to {} (worst), for example {}", *crf,
                  format.worstCrf, format.defaultCrf));
}

}  // namespace

const std::vector<VideoFormat>& videoFormats() {
  static const std::vector<VideoFormat> formats = {
      {".mp4", "H.264", "mp4", "libx264", nullptr, nullptr, true, 18, 51},
      {".webm", "VP9", "webm", "libvpx-vp9", nullptr, kToAlphaColours, true, 24, 63},
      {".gif", "GIF", "gif", "gif", kToPalette, kToClearPalette, false, -1, -1},
      {".apng", "APNG", "apng", "apng", "format=rgba", "format=rgba", false, -1, -1},
      {".mkv", "FFV1", "matroska", "ffv1", "format=bgr0", "format=bgra", false, -1, -1},
      {".mov", "ProRes", "mov", "prores_ks", kToFullColours, kToFullAlphaColours, false, -1, -1},
  };
  return formats;
}

/// Throws InputError if the video format has no alpha.
void requireAlpha(const VideoFormat& format) {
  if (format.alphaConversion != nullptr) return;
  std::vector<VideoFormat> others = videoFormats();
  std::erase_if(others, [](const VideoFormat& other) { return other.alphaConversion == nullptr; });
  throw InputError(
      fmt::format("error: a video in {} cannot be transparent; use a name that ends in {}",
                  format.name, nameAll(others)));
}

bool hasAlpha(const std::filesystem::path& file) {
  return videoFormatOf(file).alphaConversion != nullptr;
}

bool isVideo(const std::filesystem::path& file) {
  return std::ranges::find(videoFormats(), endingOf(file), &VideoFormat::ending) !=
         videoFormats().end();
}

const VideoFormat& videoFormatOf(const std::filesystem::path& file) {
  const std::vector<VideoFormat>& formats = videoFormats();
  const std::string ending = endingOf(file);
  const auto found = std::ranges::find_if(
      formats, [&](const VideoFormat& format) { return format.ending == ending; });
  if (found != formats.end()) return *found;
  throw InputError(fmt::format("{}: error: the ending of this name is not a video format; use {}",
                               file.string(), nameAll(formats)));
}

void requireValidSettings(const std::filesystem::path& file, const VideoSettings& settings) {
  const VideoFormat& format = videoFormatOf(file);
  requireFittingSize(format, settings.size);
  if (settings.framesPerSecond < 1 || settings.framesPerSecond > 1000) {
    throw InputError(fmt::format("error: {} frames per second are not possible; give 1 to 1000",
                                 settings.framesPerSecond));
  }
  requireFittingQuality(format, settings.crf);
  if (settings.transparent) requireAlpha(format);
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

}  // namespace kirireel::picture
