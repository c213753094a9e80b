#include <array>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/png.h"
#include "render/record/record.h"
#include "render/record/run_pictures.h"
#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/png.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

class FigureTest : public testing::Test {
 protected:
  /// Records a sheet of squares; returns its trajectory.
  fs::path recorded(const std::string& name, int side, double duration = 0.5) {
    scene::Scene scene;
    scene.model = generate::makeTessellation({.columns = side, .rows = side});
    scene.model.name = name;
    scene.stop.duration = duration;
    record::RecordSettings settings;
    settings.folder = folder_.path() / fmt::format("{} {} {}", name, side, duration);
    settings.video = settings.snapshots = settings.meshes = false;
    record::record(scene, settings, proceed_);
    return settings.folder / "trajectory.h5";
  }

  record::PictureSettings settings() const {
    record::PictureSettings figure;
    figure.folder = folder_.path() / "figure";
    figure.size = {160, 120};
    figure.grid.columns = 3;
    figure.video = false;
    return figure;
  }

  /// Frames of a video at real pace, as PNG files.
  record::PictureSettings framesIn(const std::string& folder) const {
    record::PictureSettings figure = settings();
    figure.folder = folder_.path() / folder;
    figure.size = {320, 200};
    figure.frames = true;
    figure.snapshots = false;
    figure.pace = record::Pace::Real;
    figure.framesPerSecond = 10;
    return figure;
  }

  /// The frames of a video as a single run has them, for a part of a frame of this height.
  record::PictureSettings partIn(const std::string& folder, int stripHeight) const {
    record::PictureSettings figure = framesIn(folder);
    figure.appearance.pixelsPerInch = picture::pixelsPerInchOf(figure.size);
    figure.size = {160, 200 - stripHeight};
    return figure;
  }

  test::TemporaryFolder folder_;
  record::ProgressObserver proceed_ = [](const record::Progress&) {
    return record::Interruption();
  };
};

TEST_F(FigureTest, ShowsARowOfStatesOfEachRun) {
  const trajectory::TrajectoryReader small(recorded("small", 2)), large(recorded("large", 4));
  const std::array<const trajectory::TrajectoryReader*, 2> runs = {&small, &large};
  record::PictureSettings figure = settings();
  for (const bool sameScale : {true, false}) {
    figure.sameScale = sameScale;
    const std::vector<record::PanelRow> rows = record::figureRows(runs, figure);
    ASSERT_EQ(rows.size(), 2);
    std::vector<double> scales;
    for (const record::PanelRow& row : rows) {
      EXPECT_EQ(row.states.size(), 3);
      scales.push_back(
          picture::PictureSetup(row.appearance, row.content, {160, 120}).metresPerPixel());
    }
    if (sameScale) {
      EXPECT_NEAR(scales[0] / scales[1], 1, 1e-12);  // 1e-16: zoomed by the ratio of the two
    } else {
      EXPECT_LT(scales[0] / scales[1], 0.6);  // half as large a sheet fills the same picture
    }
    EXPECT_EQ(rows[0].captions, (std::vector<std::string>{"0%", "50%", "100%"}));
    EXPECT_EQ(rows[0].head, "small");
    EXPECT_EQ(rows[1].head, "large");
  }
}

TEST_F(FigureTest, LeavesPictureAndPages) {
  record::PictureSettings figure = settings();
  figure.gridWidth = 100;
  figure.fontPoints = 7;
  figure.dotsPerInch = 100;
  figure.pages = {picture::PageFormat::Svg, picture::PageFormat::Pdf};
  record::renderSeveral({recorded("small", 2), recorded("large", 3)}, figure, proceed_);
  const std::string svg = test::bytesOf(figure.folder / "snapshots.svg");
  EXPECT_THAT(svg, testing::HasSubstr(">large<"));
  EXPECT_THAT(svg, testing::HasSubstr("picture_06"));
  EXPECT_THAT(svg, testing::HasSubstr("model small, large"));
  EXPECT_TRUE(fs::exists(figure.folder / "snapshots.png"));
  EXPECT_TRUE(fs::exists(figure.folder / "snapshots.pdf"));
}

TEST_F(FigureTest, RefusesWhatHasNoOneScale) {
  record::PictureSettings figure = settings();
  figure.sameScale = true;
  figure.appearance.camera.orbit = 1;
  const trajectory::TrajectoryReader run(recorded("small", 2));
  const std::array<const trajectory::TrajectoryReader*, 2> runs = {&run, &run};
  try {
    record::figureRows(runs, figure);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: --same-scale needs a parallel projection and a fixed camera; remove "
                 "--projection perspective, --orbit and --camera-keys");
  }
}

/// Rows have their own heights: a sheet of 1 x 4 squares needs half of that of 2 x 4 and less.
TEST_F(FigureTest, GivesRowsTheirOwnHeightsAndBoldLetters) {
  record::PictureSettings figure = settings();
  figure.gridWidth = 100;
  figure.fontPoints = 7;
  figure.dotsPerInch = 150;
  figure.letters = picture::PanelLetters::Small;
  figure.pages = {picture::PageFormat::Svg};
  record::renderSeveral({recorded("small", 2), recorded("large", 3)}, figure, proceed_);
  const std::string svg = test::bytesOf(figure.folder / "snapshots.svg");
  EXPECT_THAT(svg, testing::ContainsRegex("font-weight=\"bold\" fill=\"#1e1e1e\">a</text>"));
  EXPECT_THAT(svg, testing::ContainsRegex("font-weight=\"bold\" fill=\"#1e1e1e\">b</text>"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr(">c</text>")));
}

// ------------------------------------------------------------------------------------------------
// Videos of several runs. The oracle is the single video of each run: a part of the frame is equal
// to its frame, pixel by pixel, above the line with the name, 1.5 x 9 pixels high.

constexpr int kNameHeight = 14;

picture::Frame frameOf(const record::PictureSettings& settings, int number) {
  return test::readPng(settings.folder / fmt::format("frames/frame_{:05}.png", number));
}

picture::Frame partOf(const picture::Frame& frame, int left, picture::FrameSize size) {
  picture::Frame part = picture::makeFrame(size, {});
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) part.set(x, y, frame.at(left + x, y));
  }
  return part;
}

TEST_F(FigureTest, PartsOfAVideoAreTheVideosOfItsRuns) {
  const fs::path longRun = recorded("small", 2, 0.5), shortRun = recorded("large", 3, 0.2);
  const record::PictureSettings both = framesIn("both");
  record::renderSeveral({longRun, shortRun}, both, proceed_);
  EXPECT_FALSE(fs::exists(both.folder / "frames/frame_00006.png"));
  const record::PictureSettings left = partIn("left", kNameHeight),
                                right = partIn("right", kNameHeight);
  record::render(longRun, left, proceed_);
  record::render(shortRun, right, proceed_);
  for (int k = 0; k <= 5; ++k) {
    SCOPED_TRACE(k);
    const picture::Frame frame = frameOf(both, k);
    EXPECT_TRUE(partOf(frame, 0, left.size).pixels == frameOf(left, k).pixels);
    // The shorter run stays at its end.
    EXPECT_TRUE(partOf(frame, 160, right.size).pixels == frameOf(right, std::min(k, 2)).pixels);
  }
  EXPECT_FALSE(frameOf(left, 0).pixels == frameOf(left, 5).pixels);
}

TEST_F(FigureTest, AVideoOfRunsDoesNotDependOnThreads) {
  const fs::path longRun = recorded("small", 2, 0.5), shortRun = recorded("large", 3, 0.2);
  std::string first;
  for (const int painters : {1, 3}) {
    record::PictureSettings settings = framesIn("both");
    settings.frames = false;
    settings.video = true;
    settings.painterCount = painters;
    settings.inset = "radius";
    settings.size = {640, 256};
    EXPECT_EQ(record::renderSeveral({longRun, shortRun}, settings, proceed_).videoFrames, 6);
    const std::string bytes = test::bytesOf(settings.folder / "deployment.mp4");
    if (painters == 1) first = bytes;
    EXPECT_TRUE(bytes == first);
  }
}

/// Widths of the sheet in pixels: columns that are not white.
int widthOf(const picture::Frame& frame, int left, int width, int height) {
  int columns = 0;
  for (int x = left; x < left + width; ++x) {
    bool isWhite = true;
    for (int y = 0; y < height; ++y) {
      isWhite = isWhite && frame.at(x, y) == picture::Colour{255, 255, 255};
    }
    columns += isWhite ? 0 : 1;
  }
  return columns;
}

/// Closed sheets of 2 x 2 and 4 x 4 equal squares.
TEST_F(FigureTest, AVideoOfRunsHasOneScaleIfRequested) {
  const fs::path small = recorded("small", 2), large = recorded("large", 4);
  for (const bool sameScale : {false, true}) {
    record::PictureSettings settings = framesIn("both");
    settings.sameScale = sameScale;
    record::renderSeveral({small, large}, settings, proceed_);
    const picture::Frame frame = frameOf(settings, 0);
    const double ratio = static_cast<double>(widthOf(frame, 0, 160, 200 - kNameHeight)) /
                         widthOf(frame, 160, 160, 200 - kNameHeight);
    if (sameScale) {
      EXPECT_NEAR(ratio, 0.5, 0.02);
    } else {
      EXPECT_GT(ratio, 0.8);
    }
  }
}

TEST_F(FigureTest, RunsOfOneModelHaveTheNamesOfTheirFolders) {
  const fs::path first = recorded("sheet", 2, 0.5), second = recorded("sheet", 2, 0.2);
  const trajectory::TrajectoryReader a(first), b(second);
  const std::array<const trajectory::TrajectoryReader*, 2> runs = {&a, &b};
  EXPECT_EQ(record::namesOf(runs, {first, second}),
            (std::vector<std::string>{"sheet 2 0.5", "sheet 2 0.2"}));
}

}  // namespace
}  // namespace kirireel
