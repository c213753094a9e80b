#include "render/picture/video.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim/base/error.h"
#include "tests/support/files.h"
#include "tests/support/program.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using test::bytesOf;
using test::hasProgram;
using test::outputOf;
using test::TemporaryFolder;
using ::testing::HasSubstr;

constexpr picture::FrameSize kVideoSize{320, 180};

picture::VideoSettings settingsOf(picture::FrameSize size) {
  picture::VideoSettings settings;
  settings.size = size;
  return settings;
}

void fill(picture::Frame& frame, int left, int top, int width, int height, picture::Colour colour) {
  for (int y = top; y < top + height; ++y) {
    for (int x = left; x < left + width; ++x) frame.set(x, y, colour);
  }
}

/// A disk with an antialiased rim, which moves with time over white: like a picture of bricks.
picture::Frame diskFrame(int index, picture::FrameSize size = kVideoSize) {
  picture::Frame frame = picture::makeFrame(size, {255, 255, 255, 255});
  const double radius = 0.28 * size.height;
  const double centreX = (0.2 + 0.015 * index) * size.width;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double inside = radius - std::hypot(x - centreX, y - 0.5 * size.height);
      const double cover = std::clamp(inside, 0.0, 1.0);
      const auto mix = [&](int colour) {
        return static_cast<std::uint8_t>(std::lround(255 + cover * (colour - 255)));
      };
      frame.set(x, y, {mix(196), mix(88), mix(44), 255});
    }
  }
  return frame;
}

void writeDiskVideo(const std::filesystem::path& path, int frames) {
  picture::VideoWriter writer(path, settingsOf(kVideoSize));
  for (int k = 0; k < frames; ++k) writer.write(diskFrame(k));
  writer.finish();
}

/// Decodes one frame with the ffmpeg program and converts its planes to colours by the formulas of
/// BT.709, limited range. This check does not use libswscale or its tables.
class DecodedFrame {
 public:
  DecodedFrame(const std::filesystem::path& video, int index, picture::FrameSize size)
      : size_(size) {
    planes_ = outputOf("ffmpeg -i '" + video.string() + "' -vf \"select=eq(n\\," +
                       std::to_string(index) + ")\" -vsync 0 -f rawvideo -pix_fmt yuv420p -");
  }

  bool isWhole() const {
    return planes_.size() == static_cast<std::size_t>(size_.width) * size_.height * 3 / 2;
  }

  std::array<double, 3> at(int x, int y) const {
    const int pixels = size_.width * size_.height;
    const int chroma = (y / 2) * (size_.width / 2) + x / 2;
    const double luma = (byte(y * size_.width + x) - 16) / 219.0;
    const double blueness = (byte(pixels + chroma) - 128) / 224.0;
    const double redness = (byte(pixels + pixels / 4 + chroma) - 128) / 224.0;
    const double red = luma + 1.5748 * redness;
    const double blue = luma + 1.8556 * blueness;
    const double green = (luma - 0.2126 * red - 0.0722 * blue) / 0.7152;
    return {255 * red, 255 * green, 255 * blue};
  }

 private:
  double byte(int index) const { return static_cast<std::uint8_t>(planes_[index]); }

  picture::FrameSize size_;
  std::string planes_;
};

/// Peak signal to noise ratio over all channels, decibels.
double psnr(const DecodedFrame& decoded, const picture::Frame& source) {
  double sum = 0;
  for (int y = 0; y < source.size.height; ++y) {
    for (int x = 0; x < source.size.width; ++x) {
      const std::array<double, 3> colour = decoded.at(x, y);
      const picture::Colour expected = source.at(x, y);
      sum += std::pow(colour[0] - expected.red, 2) + std::pow(colour[1] - expected.green, 2) +
             std::pow(colour[2] - expected.blue, 2);
    }
  }
  const double meanSquare = sum / (3.0 * source.size.width * source.size.height);
  return 10 * std::log10(255 * 255 / meanSquare);
}

void expectColour(const DecodedFrame& decoded, int x, int y, picture::Colour expected,
                  double tolerance) {
  const std::array<double, 3> colour = decoded.at(x, y);
  EXPECT_NEAR(colour[0], expected.red, tolerance);
  EXPECT_NEAR(colour[1], expected.green, tolerance);
  EXPECT_NEAR(colour[2], expected.blue, tolerance);
}

TEST(Video, IsConfirmedByFfprobe) {
  if (!hasProgram("ffprobe")) GTEST_SKIP() << "install ffmpeg to check videos with ffprobe";
  const TemporaryFolder folder;
  writeDiskVideo(folder / "disk.mp4", 25);
  const std::string stream =
      outputOf("ffprobe -v error -count_frames -show_streams -show_format '" +
               (folder / "disk.mp4").string() + "'");
  for (const char* line :
       {"codec_name=h264", "pix_fmt=yuv420p", "width=320", "height=180", "color_range=tv",
        "color_space=bt709", "color_transfer=bt709", "color_primaries=bt709",
        "chroma_location=left", "r_frame_rate=60/1", "avg_frame_rate=60/1", "nb_read_frames=25",
        "duration=0.416667", "start_time=0.000000", "format_name=mov,mp4"}) {
    EXPECT_THAT(stream, HasSubstr(line));
  }
  EXPECT_THAT(stream, ::testing::Not(HasSubstr("creation_time")));
}

constexpr std::array<picture::Colour, 8> kStripes = {{{255, 255, 255, 255},
                                                      {0, 0, 0, 255},
                                                      {128, 128, 128, 255},
                                                      {230, 40, 30, 255},
                                                      {30, 160, 60, 255},
                                                      {20, 60, 200, 255},
                                                      {240, 200, 80, 255},
                                                      {120, 40, 140, 255}}};

/// A video of three frames of upright stripes, 40 pixels wide.
void writeStripes(const std::filesystem::path& path) {
  picture::Frame frame = picture::makeFrame(kVideoSize, {255, 255, 255, 255});
  for (int k = 0; k < 8; ++k) fill(frame, 40 * k, 0, 40, 180, kStripes[k]);
  picture::VideoWriter writer(path, settingsOf(kVideoSize));
  for (int k = 0; k < 3; ++k) writer.write(frame);
  writer.finish();
}

TEST(Video, KeepsFlatColours) {
  if (!hasProgram("ffmpeg")) GTEST_SKIP() << "install ffmpeg to check videos with its decoder";
  for (const char* name : {"flat.mp4", "flat.webm"}) {
    const TemporaryFolder folder;
    writeStripes(folder / name);
    const DecodedFrame decoded(folder / name, 2, kVideoSize);
    ASSERT_TRUE(decoded.isWhole());
    for (int k = 0; k < 8; ++k) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(k));
      expectColour(decoded, 40 * k + 20, 90, kStripes[k], 2);  // measured: 1.5 in both
    }
  }
}

TEST(Video, KeepsFlatColoursExactlyWithoutChroma) {
  if (!hasProgram("ffmpeg")) GTEST_SKIP() << "install ffmpeg to check videos with its decoder";
  for (const char* name : {"flat.gif", "flat.apng", "flat.mkv"}) {
    const TemporaryFolder folder;
    writeStripes(folder / name);
    const std::string pixels =
        outputOf("ffmpeg -i '" + (folder / name).string() + "' -f rawvideo -pix_fmt rgb24 -");
    ASSERT_GE(pixels.size(), 2U * 320 * 180 * 3) << name;
    for (int k = 0; k < 8; ++k) {
      const char* pixel = pixels.data() + 3 * (90 * 320 + 40 * k + 20);
      const picture::Colour found = {static_cast<std::uint8_t>(pixel[0]),
                                     static_cast<std::uint8_t>(pixel[1]),
                                     static_cast<std::uint8_t>(pixel[2]), 255};
      EXPECT_EQ(found, kStripes[k]) << name << " " << k;
    }
  }
}

TEST(Video, OtherFormatsAreConfirmedByFfprobe) {
  if (!hasProgram("ffprobe")) GTEST_SKIP() << "install ffmpeg to check videos with ffprobe";
  const TemporaryFolder folder;
  const std::vector<std::pair<const char*, std::vector<const char*>>> expected = {
      {"disk.webm",
       {"codec_name=vp9", "pix_fmt=yuv420p", "color_range=tv", "color_space=bt709",
        "color_transfer=bt709", "color_primaries=bt709", "nb_read_frames=25"}},
      {"disk.gif", {"codec_name=gif", "r_frame_rate=50/1", "nb_read_frames=20"}},
      {"disk.apng", {"codec_name=apng", "pix_fmt=rgba", "nb_read_frames=25"}},
      {"disk.mkv", {"codec_name=ffv1", "pix_fmt=bgr0", "nb_read_frames=25"}},
      {"disk.mov",
       {"codec_name=prores", "pix_fmt=yuv444p", "color_space=bt709", "nb_read_frames=25"}}};
  for (const auto& [name, lines] : expected) {
    writeDiskVideo(folder / name, 25);
    const std::string stream =
        outputOf("ffprobe -v error -count_frames -show_streams '" + (folder / name).string() + "'");
    for (const char* line : lines) EXPECT_THAT(stream, HasSubstr(line)) << name;
  }
}

TEST(Video, MatchesItsLastFrame) {
  if (!hasProgram("ffmpeg")) GTEST_SKIP() << "install ffmpeg to check videos with its decoder";
  const TemporaryFolder folder;
  writeDiskVideo(folder / "disk.mp4", 25);
  const DecodedFrame decoded(folder / "disk.mp4", 24, kVideoSize);
  ASSERT_TRUE(decoded.isWhole());
  EXPECT_GT(psnr(decoded, diskFrame(24)), 35);  // measured: 41
  EXPECT_LT(psnr(decoded, diskFrame(20)), 25);
}

TEST(Video, ShowsWhiteThroughTransparency) {
  if (!hasProgram("ffmpeg")) GTEST_SKIP() << "install ffmpeg to check videos with its decoder";
  picture::Frame frame = picture::makeFrame(kVideoSize, {0, 0, 0, 0});
  fill(frame, 0, 0, 160, 180, {200, 40, 80, 128});
  const TemporaryFolder folder;
  picture::VideoWriter writer(folder / "glass.mp4", settingsOf(kVideoSize));
  writer.write(frame);
  writer.finish();
  const DecodedFrame decoded(folder / "glass.mp4", 0, kVideoSize);
  ASSERT_TRUE(decoded.isWhole());
  expectColour(decoded, 80, 90, {227, 147, 167, 255}, 2);
  expectColour(decoded, 240, 90, {255, 255, 255, 255}, 2);
}

/// Second method: ffmpeg's decoders. VP9's alpha needs the one of libvpx.
TEST(Video, KeepsAlphaInFormatsThatHaveIt) {
  if (!hasProgram("ffmpeg")) GTEST_SKIP() << "install ffmpeg to check videos with its decoder";
  picture::Frame frame = picture::makeFrame(kVideoSize, {255, 255, 255, 0});
  fill(frame, 0, 0, 160, 180, {200, 40, 80, 255});
  const TemporaryFolder folder;
  for (const picture::VideoFormat& format : picture::videoFormats()) {
    const std::filesystem::path file = folder / (std::string("glass") + format.ending);
    picture::VideoSettings settings = settingsOf(kVideoSize);
    settings.transparent = true;
    if (format.alphaConversion == nullptr) {
      std::string message;
      try {
        picture::requireValidSettings(file, settings);
      } catch (const InputError& error) {
        message = error.what();
      }
      EXPECT_EQ(message,
                "error: a video in H.264 cannot be transparent; use a name that ends in .webm, "
                ".gif, .apng, .mkv, .mov");
      continue;
    }
    picture::VideoWriter writer(file, settings);
    for (int k = 0; k < 3; ++k) writer.write(frame);
    writer.finish();
    const std::string raw = (folder / "raw").string();
    const std::string decoder = std::string(format.ending) == ".webm" ? "-c:v libvpx-vp9 " : "";
    outputOf("ffmpeg -v error -y " + decoder + "-i '" + file.string() +
             "' -vf select='eq(n\\,1)' -frames:v 1 -pix_fmt rgba -f rawvideo '" + raw + "'");
    const std::string pixels = bytesOf(raw);
    ASSERT_EQ(pixels.size(), std::size_t{4} * kVideoSize.width * kVideoSize.height)
        << format.ending;
    const auto at = [&](int x, int channel) {
      return static_cast<int>(static_cast<unsigned char>(
          pixels[4 * (std::size_t{90} * kVideoSize.width + x) + channel]));
    };
    EXPECT_EQ(at(240, 3), 0) << format.ending;
    EXPECT_EQ(at(80, 3), 255) << format.ending;
    EXPECT_NEAR(at(80, 0), 200, 3) << format.ending;
    EXPECT_NEAR(at(80, 1), 40, 3) << format.ending;
    EXPECT_NEAR(at(80, 2), 80, 3) << format.ending;
  }
}

TEST(Video, StartsWithItsIndex) {
  const TemporaryFolder folder;
  writeDiskVideo(folder / "disk.mp4", 5);
  const std::string bytes = bytesOf(folder / "disk.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

/// The bytes of a video that is encoded while new memory is filled with a pattern. They change if
/// the encoder reads uninitialised memory.
std::string bytesWithMemoryOf(int pattern, picture::FrameSize size, const std::string& preset) {
  const TemporaryFolder folder;
  ::mallopt(M_PERTURB, pattern);
  picture::VideoSettings settings = settingsOf(size);
  settings.preset = preset;
  picture::VideoWriter writer(folder / "disk.mp4", settings);
  for (int k = 0; k < 25; ++k) writer.write(diskFrame(k, size));
  writer.finish();
  ::mallopt(M_PERTURB, 0);
  return bytesOf(folder / "disk.mp4");
}

TEST(Video, HasTheSameBytesInTwoRuns) {
  const TemporaryFolder folder;
  for (const picture::VideoFormat& format : picture::videoFormats()) {
    const std::string ending = format.ending;
    writeDiskVideo(folder / ("first" + ending), 25);
    writeDiskVideo(folder / ("second" + ending), 25);
    const std::string first = bytesOf(folder / ("first" + ending));
    EXPECT_GT(first.size(), 1000U);
    EXPECT_TRUE(first == bytesOf(folder / ("second" + ending))) << ending;
  }
}

TEST(Video, PlaysUpToTheKillOfItsProcess) {
  if (!hasProgram("ffprobe")) GTEST_SKIP() << "install ffmpeg to check videos with ffprobe";
  for (const int count : {1, 4, 5, 6, 8, 20, 300}) {
    const TemporaryFolder folder;
    const pid_t child = ::fork();
    if (child == 0) {
      picture::VideoWriter writer(folder / "disk.mp4", settingsOf(kVideoSize));
      for (int k = 0; k < count; ++k) writer.write(diskFrame(k % 30));
      ::kill(::getpid(), SIGKILL);
    }
    ::waitpid(child, nullptr, 0);
    // x264 looks ahead; until it has given a frame there is no file.
    const int given = count - 4;
    EXPECT_EQ(folder.isEmpty(), given <= 0) << count;
    if (folder.isEmpty()) continue;
    const std::string frames = outputOf(
        "ffprobe -v error -count_frames -show_entries stream=nb_read_frames -of csv=p=0 '" +
        (folder / "disk.part.mp4").string() + "'");
    EXPECT_EQ(std::atoi(frames.c_str()), given);
  }
}

TEST(Video, HasTheSameBytesForAnyContentOfMemory) {
  for (const picture::FrameSize size :
       {picture::FrameSize{384, 216}, {320, 180}, {144, 96}, {600, 600}}) {
    for (const char* preset : {"auto", "veryfast", "medium"}) {
      SCOPED_TRACE(std::to_string(size.width) + " " + preset);
      const std::string zeros = bytesWithMemoryOf(255, size, preset);
      EXPECT_TRUE(zeros == bytesWithMemoryOf(85, size, preset));
      EXPECT_TRUE(zeros == bytesWithMemoryOf(170, size, preset));
    }
  }
}

TEST(Video, LeavesNothingWhenAbandoned) {
  const TemporaryFolder folder;
  {
    picture::VideoWriter writer(folder / "disk.mp4", settingsOf(kVideoSize));
    writer.write(diskFrame(0));
    EXPECT_FALSE(std::filesystem::exists(folder / "disk.mp4"));
  }
  EXPECT_TRUE(folder.isEmpty());
}

TEST(Video, RefusesSettingsOutOfRange) {
  const auto refusal = [](auto change) {
    picture::VideoSettings settings = settingsOf(kVideoSize);
    change(settings);
    return test::refusalOf<InputError>(
        [&] { picture::requireValidSettings("disk.mp4", settings); });
  };
  EXPECT_EQ(
      refusal([](picture::VideoSettings& s) {
        s.size = {641, 480};
      }),
      "error: a video of 641 x 480 pixels has an odd side; H.264 needs even ones, for example "
      "--size 642x480");
  EXPECT_EQ(refusal([](picture::VideoSettings& s) { s.framesPerSecond = 0; }),
            "error: 0 frames per second are not possible; give 1 to 1000");
  EXPECT_EQ(refusal([](picture::VideoSettings& s) { s.crf = 52; }),
            "error: the video's crf is 52; give 0 (best) to 51 (worst), for example 18");
  EXPECT_EQ(
      refusal([](picture::VideoSettings& s) { s.preset = "quick"; }),
      "error: x264 has no preset \"quick\"; give auto, or one of ultrafast, superfast, veryfast, "
      "faster, fast, medium, slow, slower, veryslow, placebo");
  EXPECT_THAT(refusal([](picture::VideoSettings& s) { s.size = {0, 480}; }), HasSubstr("0 x 480"));
  EXPECT_THAT(refusal([](picture::VideoSettings& s) {
                s.size = {100000, 480};
              }),
              HasSubstr("100000 x 480"));
}

TEST(Video, RefusesSettingsThatItsFormatLacks) {
  const auto refusal = [](const char* file, const picture::VideoSettings& settings) {
    return test::refusalOf<InputError>([&] { picture::requireValidSettings(file, settings); });
  };
  EXPECT_EQ(refusal("disk.avi", settingsOf(kVideoSize)),
            "disk.avi: error: the ending of this name is not a video format; use .mp4, .webm, "
            ".gif, .apng, .mkv, .mov");
  picture::VideoSettings settings = settingsOf({641, 480});
  EXPECT_EQ(refusal("disk.gif", settings), "accepted");
  EXPECT_THAT(refusal("disk.webm", settings), HasSubstr("an odd side; VP9 needs even ones"));
  settings = settingsOf(kVideoSize);
  settings.crf = 63;
  EXPECT_EQ(refusal("disk.webm", settings), "accepted");
  EXPECT_EQ(refusal("disk.gif", settings), "error: GIF has no crf; remove --crf");
}

TEST(Video, ReportsWhichEncoderIsMissing) {
  const TemporaryFolder folder;
  picture::VideoSettings settings = settingsOf(kVideoSize);
  settings.encoder = "libx999";
  const std::filesystem::path path = folder / "disk.mp4";
  EXPECT_EQ(test::refusalOf<OutputError>([&] { picture::VideoWriter writer(path, settings); }),
            path.string() +
                ": error: libavcodec has no encoder libx999 here, so no video can be made; "
                "install Debian's libavcodec-extra, or choose another with --encoder or another "
                "ending with --video");
  EXPECT_TRUE(folder.isEmpty());
}

TEST(Video, ReportsThatTheEncoderRefusesTheSize) {
  const TemporaryFolder folder;
  const picture::VideoSettings settings = settingsOf({16384, 16384});
  const std::filesystem::path path = folder / "disk.mp4";
  EXPECT_EQ(test::refusalOf<OutputError>([&] { picture::VideoWriter writer(path, settings); }),
            path.string() +
                ": error: libx264 refuses a video of 16384 x 16384 pixels (Invalid argument); try "
                "a smaller --size");
  EXPECT_TRUE(folder.isEmpty());
}

TEST(Video, RefusesAFrameOfAnotherSize) {
  const TemporaryFolder folder;
  picture::VideoWriter writer(folder / "disk.mp4", settingsOf(kVideoSize));
  const picture::Frame frame = picture::makeFrame({64, 32}, {});
  EXPECT_THAT(test::refusalOf<OutputError>([&] { writer.write(frame); }),
              HasSubstr("disk.mp4: error: a frame of 64 x 32 pixels in a video of 320 x 180"));
}

TEST(Video, IsFinishedOnce) {
  const TemporaryFolder folder;
  picture::VideoWriter writer(folder / "disk.mp4", settingsOf(kVideoSize));
  EXPECT_THAT(test::refusalOf<OutputError>([&] { writer.finish(); }),
              HasSubstr("disk.mp4: error: a video needs at least one frame"));
  writer.write(diskFrame(0));
  writer.finish();
  for (const auto& message : {test::refusalOf<OutputError>([&] { writer.finish(); }),
                              test::refusalOf<OutputError>([&] { writer.write(diskFrame(1)); })}) {
    EXPECT_THAT(message, HasSubstr("disk.mp4: error: the video is finished already"));
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "disk.mp4"));
}

/// While it lives, no file may grow beyond this size, as on a disk that is full.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

TEST(Video, ReportsThatTheDiskIsFull) {
  const TemporaryFolder folder;
  std::string message;
  {
    const FileSizeLimit limit(2000);
    message = test::refusalOf<OutputError>([&] { writeDiskVideo(folder / "disk.mp4", 60); });
  }
  EXPECT_EQ(message, (folder / "disk.mp4").string() +
                         ": error: the video cannot be written (File too large); free some space "
                         "or choose another folder with --out");
  EXPECT_TRUE(folder.isEmpty());
}

}  // namespace
}  // namespace kirireel
