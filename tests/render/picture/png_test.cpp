#include "render/picture/png.h"

#include <csignal>
#include <cstdint>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "sim/base/error.h"
#include "tests/support/files.h"
#include "tests/support/png.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// A picture with different bytes everywhere.
picture::Frame noise(picture::FrameSize size, bool opaque) {
  std::mt19937 random(5);
  picture::Frame frame = picture::makeFrame(size, {});
  for (std::uint8_t& byte : frame.pixels) byte = static_cast<std::uint8_t>(random());
  if (opaque) {
    for (std::size_t alpha = 3; alpha < frame.pixels.size(); alpha += 4) frame.pixels[alpha] = 255;
  }
  return frame;
}

/// The colour type in a PNG's header: 2 RGB, 6 RGBA.
int colourType(const std::string& file) {
  return file.at(25);
}

/// Limits the size of files while it exists: writing then fails as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) : oldHandler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limit{bytes, old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, oldHandler_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  void (*oldHandler_)(int);
  rlimit old_ = {};
};

TEST(Png, ComesBackExactly) {
  const test::TemporaryFolder folder;
  for (const bool opaque : {true, false}) {
    for (const picture::FrameSize size : {picture::FrameSize{1, 1}, {7, 3}, {640, 5}}) {
      const picture::Frame frame = noise(size, opaque);
      picture::writePng(frame, folder / "a.png");
      const picture::Frame back = test::readPng(folder / "a.png");
      EXPECT_EQ(back.size, size);
      EXPECT_EQ(back.pixels, frame.pixels);
      EXPECT_EQ(colourType(test::bytesOf(folder / "a.png")), opaque ? 2 : 6);
    }
  }
}

TEST(Png, IsReadEquallyByAnotherDecoder) {
  if (!test::hasProgram("ffmpeg")) GTEST_SKIP() << "ffmpeg is not installed";
  const test::TemporaryFolder folder;
  const picture::Frame frame = noise({33, 21}, false);
  picture::writePng(frame, folder / "a.png");
  const std::string decoded = test::outputOf("ffmpeg -v error -i " + (folder / "a.png").string() +
                                             " -f rawvideo -pix_fmt rgba -");
  EXPECT_EQ(decoded, std::string(frame.pixels.begin(), frame.pixels.end()));
}

TEST(Png, HasTheSameBytesEachTime) {
  const test::TemporaryFolder folder;
  picture::writePng(noise({50, 40}, true), folder / "a.png");
  picture::writePng(noise({50, 40}, true), folder / "b.png");
  EXPECT_EQ(test::bytesOf(folder / "a.png"), test::bytesOf(folder / "b.png"));
}

TEST(Png, NotesThePrintedResolution) {
  const test::TemporaryFolder folder;
  picture::PngSettings settings;
  settings.dotsPerInch = 254;
  picture::writePng(noise({2, 2}, true), folder / "a.png", settings);
  // 254 dots an inch are 10000 (0x2710) a metre, unit 1.
  const std::string chunk("pHYs\0\0\x27\x10\0\0\x27\x10\1", 13);
  EXPECT_THAT(test::bytesOf(folder / "a.png"), HasSubstr(chunk));
}

TEST(Png, LeavesNothingOnAFullDisk) {
  const test::TemporaryFolder folder;
  const picture::Frame frame = noise({400, 300}, true);
  std::string message;
  // The second limit excludes only the last bytes, which the library writes at the end.
  for (const rlim_t limit : {1000U, 360000U}) {
    const FullDisk disk(limit);
    try {
      picture::writePng(frame, folder / "a.png");
      ADD_FAILURE();
    } catch (const OutputError& error) {
      EXPECT_EQ(std::string(error.what()), (folder / "a.png").string() +
                                               ": error: cannot be written (File too large); free "
                                               "some space or choose another folder");
    }
    EXPECT_TRUE(folder.isEmpty());
  }
}

TEST(Png, NamesAFolderThatIsMissing) {
  const test::TemporaryFolder folder;
  try {
    picture::writePng(noise({2, 2}, true), folder / "none/a.png");
    ADD_FAILURE();
  } catch (const OutputError& error) {
    EXPECT_THAT(error.what(), StartsWith((folder / "none").string() + ": error: "));
  }
}

}  // namespace
}  // namespace kirireel
