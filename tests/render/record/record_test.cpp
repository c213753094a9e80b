#include "render/record/record.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/png.h"
#include "render/record/run_pictures.h"
#include "render/record/summary.h"
#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/png.h"
#include "tests/support/program.h"
#include "tests/support/refusal.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

scene::Scene tessellationScene() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  scene.stop.duration = 0.4;
  return scene;
}

/// Whether the outermost rows and columns of a picture have only the background.
bool hasFreeBorder(const picture::Frame& frame) {
  const picture::Colour background = frame.at(0, 0);
  for (int x = 0; x < frame.size.width; ++x) {
    if (frame.at(x, 0) != background || frame.at(x, frame.size.height - 1) != background)
      return false;
  }
  for (int y = 0; y < frame.size.height; ++y) {
    if (frame.at(0, y) != background || frame.at(frame.size.width - 1, y) != background)
      return false;
  }
  return true;
}

class RecordTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "kirireel_test_XXXXXX").string();
    settings_.folder = ::mkdtemp(pattern.data());
    settings_.size = {96, 64};
    settings_.grid = {1, 2};
    settings_.framesPerSecond = 20;
    settings_.pace = record::Pace::Real;
  }
  void TearDown() override { fs::remove_all(settings_.folder); }

  std::string messageOfRecording() {
    return test::refusalOf([&] { record::record(tessellationScene(), settings_, proceed_); });
  }

  record::RecordSettings settings_;
  record::ProgressObserver proceed_ = [](const record::Progress&) {
    return record::Interruption();
  };
};

std::string bytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST_F(RecordTest, BytesDoNotDependOnTheNumberOfPainters) {
  settings_.frames = true;
  std::vector<std::string> videos, lastFrames;
  for (const int painters : {1, 2, 5}) {
    settings_.painterCount = painters;
    record::record(tessellationScene(), settings_, proceed_);
    videos.push_back(bytesOf(settings_.folder / "deployment.mp4"));
    lastFrames.push_back(bytesOf(settings_.folder / "frames/frame_00008.png"));
  }
  EXPECT_FALSE(videos[0].empty());
  EXPECT_EQ(videos, std::vector(3, videos[0]));
  EXPECT_EQ(lastFrames, std::vector(3, lastFrames[0]));
}

TEST_F(RecordTest, PaintsAFrameForEachSample) {
  settings_.frames = true;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_EQ(summary.videoFrames, 9);  // 0.4 s at 20 a second, and the start
  EXPECT_THAT(summary.files, Contains("frames/frame_00008.png"));
  EXPECT_THAT(summary.files, Not(Contains("frames/frame_00009.png")));
  EXPECT_GT(summary.recordCost.peakMemoryBytes, 1 << 20);
}

TEST_F(RecordTest, FillsItsLengthAtAnEvenPace) {
  settings_.pace = record::Pace::Even;
  settings_.length = 2;
  EXPECT_EQ(record::record(tessellationScene(), settings_, proceed_).videoFrames, 40);
  settings_.hold = 0;
  EXPECT_EQ(record::record(tessellationScene(), settings_, proceed_).videoFrames, 40);
  settings_.hold = 0.97;
  EXPECT_EQ(messageOfRecording(),
            "error: --length 2 leaves no time for motion between --hold 0.97 at the start and the "
            "end; give --length of 2.04 or more, or a shorter --hold");
}

TEST_F(RecordTest, ReportsProgressOfBothStagesToTheEnd) {
  std::vector<double> deploying;
  std::vector<double> painting;
  record::record(tessellationScene(), settings_, [&](const record::Progress& progress) {
    (std::string(progress.stage) == "deploying" ? deploying : painting).push_back(progress.share);
    return record::Interruption();
  });
  EXPECT_TRUE(std::is_sorted(deploying.begin(), deploying.end()));
  EXPECT_TRUE(std::is_sorted(painting.begin(), painting.end()));
  EXPECT_NEAR(deploying.back(), 1, 1e-12);
  EXPECT_EQ(painting.back(), 1);
}

TEST_F(RecordTest, InterruptedWhileDeployingKeepsFinishedFrames) {
  int samples = 0;
  const record::RunSummary summary =
      record::record(tessellationScene(), settings_, [&](const record::Progress& progress) {
        const bool continues = std::string(progress.stage) != "deploying" || ++samples < 4;
        return continues ? record::Interruption() : "the test";
      });
  EXPECT_EQ(summary.outcome, run::Outcome::Interrupted);
  EXPECT_EQ(summary.reason, "interrupted by the test");
  EXPECT_EQ(test::readTrajectory(settings_.folder / "trajectory.h5").events.back().text,
            "interrupted: interrupted by the test");
  EXPECT_EQ(summary.videoFrames, 4);
  EXPECT_TRUE(fs::exists(settings_.folder / "deployment.mp4"));
}

TEST_F(RecordTest, InterruptedWithinAStepKeepsFinishedFrames) {
  // No sample and no progress until the end.
  const record::Deployer stuck =
      [](const scene::Scene& scene, double interval, const run::SampleObserver& observer,
         const run::TrialObserver& searching, run::Checkpoints* checkpoints) {
        const InterruptionCatcher catcher;
        EXPECT_THROW(
            {
              for (;;) checkInterruption();
            },
            Interrupted);
        return deploy::deployUnkept(scene, interval, observer, searching, checkpoints);
      };
  int asked = 0;
  const record::RunSummary summary = record::record(
      tessellationScene(), settings_,
      [&asked](const record::Progress& progress) {
        if (std::string(progress.stage) == "painting") return record::Interruption();
        ++asked;
        return record::Interruption("the test");
      },
      stuck);
  EXPECT_EQ(asked, 1);  // a later signal would end the next stage
  EXPECT_EQ(summary.outcome, run::Outcome::Interrupted);
  EXPECT_EQ(summary.reason, "interrupted by the test");
  EXPECT_EQ(summary.videoFrames, 1);
}

TEST_F(RecordTest, InterruptedWhilePaintingEndsTheVideoThere) {
  const record::RunSummary summary =
      record::record(tessellationScene(), settings_, [](const record::Progress& progress) {
        const bool continues = std::string(progress.stage) == "deploying" || progress.share < 0.3;
        return continues ? record::Interruption() : "the test";
      });
  EXPECT_EQ(summary.outcome, run::Outcome::Interrupted);
  EXPECT_EQ(summary.reason, "interrupted by the test while painting; the video ends at 0.1 s");
  EXPECT_EQ(summary.videoFrames, 3);
}

TEST_F(RecordTest, RefusesAnImpossibleStyleBeforeDeploying) {
  settings_.appearance.camera.keys = {{1, {}, 1}, {0, {}, 1}};
  int calls = 0;
  EXPECT_THROW(record::record(tessellationScene(), settings_,
                              [&calls](const record::Progress&) {
                                ++calls;
                                return record::Interruption();
                              }),
               InputError);
  EXPECT_EQ(calls, 0);
}

TEST_F(RecordTest, WritesItsStyleToTheSummary) {
  settings_.appearance.colouring = picture::Colouring::State;
  settings_.video = settings_.meshes = false;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_THAT(record::summaryJson(tessellationScene(), settings_, summary),
              HasSubstr("\"colour\": \"state\""));
}

TEST_F(RecordTest, DrawsEachSnapshotAsVectorsOnRequest) {
  settings_.svg = true;
  settings_.video = false;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_THAT(summary.files, Contains("snapshot_01.svg"));
  EXPECT_THAT(summary.files, Contains("snapshot_02.svg"));
  EXPECT_TRUE(fs::exists(settings_.folder / "snapshot_02.svg"));
}

TEST_F(RecordTest, MakesAGridForPrint) {
  settings_.video = false;
  settings_.gridWidth = 90;
  settings_.fontPoints = 7;
  settings_.letters = picture::PanelLetters::Plain;
  settings_.scaleBar = true;
  settings_.pages = {picture::PageFormat::Svg, picture::PageFormat::Pdf};
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_THAT(summary.files, Contains("snapshots.svg"));
  EXPECT_THAT(summary.files, Contains("snapshots.pdf"));
  // 90 mm at 300 dots an inch are 1063 pixels; no fewer, and a few more by whole pixels of cells.
  const int width = test::readPng(settings_.folder / "snapshots.png").size.width;
  EXPECT_GE(width, 1063);
  EXPECT_LE(width, 1067);
  std::ifstream file(settings_.folder / "snapshots.svg");
  const std::string svg(std::istreambuf_iterator<char>(file), {});
  EXPECT_THAT(svg, HasSubstr("width=\"90mm\""));
  EXPECT_THAT(svg, HasSubstr(">(b)</text>"));
  EXPECT_THAT(svg, HasSubstr("<g id=\"picture_02_bricks\""));
  // A repeated run replaces them.
  EXPECT_NO_THROW(record::record(tessellationScene(), settings_, proceed_));
  settings_.gridWidth.reset();
  EXPECT_EQ(messageOfRecording(),
            "error: --font-size requires --width, as in --width 180mm. Add --width or remove "
            "--font-size");
  settings_.gridWidth = 5000;
  settings_.dotsPerInch = 1200;
  EXPECT_THAT(messageOfRecording(), HasSubstr("give a smaller --dpi"));
}

/// In poppler's units: three are a point.
TEST_F(RecordTest, TypeHasItsPointsInThePdf) {
  if (!test::hasProgram("pdftohtml")) {
    GTEST_SKIP() << "no pdftohtml here; scripts/setup --with-tools installs poppler-utils";
  }
  settings_.video = false;
  settings_.gridWidth = 180;
  settings_.letters = picture::PanelLetters::Plain;
  settings_.pages = {picture::PageFormat::Pdf};
  const std::string file = (settings_.folder / "snapshots.pdf").string();
  for (const double points : {7, 9}) {
    // 7 is the default.
    if (points != 7) settings_.fontPoints = points;
    record::record(tessellationScene(), settings_, proceed_);
    const std::string page = test::outputOf("pdftohtml -xml -i -stdout -zoom 3 " + file);
    EXPECT_THAT(page, HasSubstr("width=\"1530\""));  // 180 mm are 510.2 points
    EXPECT_THAT(page, HasSubstr(fmt::format("<fontspec id=\"0\" size=\"{}\"", 3 * points)));
    EXPECT_THAT(page, Not(HasSubstr("fontspec id=\"1\"")));
    // More exactly: "(a)" is 0.390 + 0.613 + 0.390 ems wide in DejaVu Sans. An em is whole
    // pixels, 29 at 300 dots an inch for 7 points, which are 6.96.
    const std::string words = test::outputOf("pdftotext -bbox " + file + " -");
    double left = 0, right = 0;
    const std::size_t end = words.find("\">(a)<"), begin = words.rfind("<word", end);
    ASSERT_EQ(std::sscanf(words.c_str() + begin, "<word xMin=\"%lf\" yMin=\"%*f\" xMax=\"%lf\"",
                          &left, &right),
              2);
    EXPECT_NEAR((right - left) / 1.393, points, 0.125);  // measured 6.96 and 9.1204
  }
}

TEST_F(RecordTest, RefusesAScaleBarInPerspective) {
  settings_.scaleBar = true;
  EXPECT_EQ(record::record(tessellationScene(), settings_, proceed_).outcome,
            run::Outcome::OutOfTime);
  settings_.appearance.camera.view = picture::kIsometricView;
  EXPECT_EQ(messageOfRecording(),
            "error: a scale bar needs a parallel projection and a fixed camera; add --projection "
            "parallel, or remove --scale-bar");
}

TEST_F(RecordTest, StoresTheViewInTheSummary) {
  settings_.video = false;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  ASSERT_TRUE(summary.view.has_value());
  EXPECT_EQ(summary.view->angles, picture::kTopView);
  EXPECT_THAT(record::summaryJson(tessellationScene(), settings_, summary),
              HasSubstr("\"elevation_deg\": 90.0"));
}

TEST_F(RecordTest, GivesOnePictureIfNothingMoves) {
  record::PictureSettings pictures = settings_;
  settings_.video = settings_.snapshots = settings_.meshes = false;
  record::record(tessellationScene(), settings_, proceed_);
  trajectory::Trajectory still = test::readTrajectory(settings_.folder / "trajectory.h5");
  for (trajectory::Sample& sample : still.samples) sample.poses = still.samples[0].poses;
  test::writeTrajectory(still, settings_.folder / "still.h5");
  pictures.folder = settings_.folder / "pictures";
  std::string remark;
  const record::PictureReport report = record::render(settings_.folder / "still.h5", pictures,
                                                      [&remark](const record::Progress& progress) {
                                                        if (!progress.remark.empty())
                                                          remark = progress.remark;
                                                        return record::Interruption();
                                                      });
  EXPECT_THAT(remark, HasSubstr("nothing moves, so there is one picture and no video"));
  EXPECT_THAT(report.files, testing::ElementsAre("snapshots.png"));
}

TEST_F(RecordTest, WithoutPicturesNeedsNoGraphics) {
  settings_.video = settings_.snapshots = settings_.meshes = false;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_EQ(summary.graphics, "");
  EXPECT_THAT(record::summaryJson(tessellationScene(), settings_, summary),
              HasSubstr("\"opengl\": null"));
  EXPECT_THAT(summary.files,
              testing::ElementsAre("trajectory.h5", "final_vertices.txt", "summary.json"));
}

TEST_F(RecordTest, ErrorsThatDoNotExistAreNull) {
  scene::Scene scene = tessellationScene();
  scene.model.target.reset();
  settings_.video = settings_.snapshots = settings_.meshes = false;
  const record::RunSummary summary = record::record(scene, settings_, proceed_);
  const std::string json = record::summaryJson(scene, settings_, summary);
  EXPECT_THAT(json, HasSubstr("\"target_error_end\": null"));
  EXPECT_THAT(json, HasSubstr("\"rigid_bound\": null"));
}

TEST_F(RecordTest, DivergedRunLeavesItsFilesAndReportsIt) {
  scene::Scene scene = tessellationScene();
  // The explicit baseline with a stiffness far beyond its step.
  scene.solver.kind = scene::SolverKind::Bullet;
  scene.solver.substeps = 1;
  scene.springs.springStiffness = 1e9;
  scene.springs.torqueStiffness = 1e9;
  const record::RunSummary summary = record::record(scene, settings_, proceed_);
  EXPECT_EQ(summary.outcome, run::Outcome::Diverged);
  EXPECT_THAT(summary.reason, HasSubstr("left all bounds"));
  for (const char* name : {"deployment.mp4", "snapshots.png", "final.obj", "summary.json"}) {
    EXPECT_TRUE(fs::exists(settings_.folder / name)) << name;
  }
}

TEST_F(RecordTest, RenderingAgainGivesTheSameBytes) {
  settings_.frames = true;
  record::record(tessellationScene(), settings_, proceed_);
  record::PictureSettings again = settings_;
  again.folder = settings_.folder / "again";
  const record::PictureReport report =
      record::render(settings_.folder / "trajectory.h5", again, proceed_);
  EXPECT_EQ(report.videoFrames, 9);
  for (const char* name : {"deployment.mp4", "snapshots.png", "frames/frame_00004.png"}) {
    EXPECT_TRUE(bytesOf(settings_.folder / name) == bytesOf(again.folder / name)) << name;
  }
}

TEST_F(RecordTest, BytesDoNotDependOnTheSlowestStage) {
  record::record(tessellationScene(), settings_, proceed_);
  const std::string quick = bytesOf(settings_.folder / "deployment.mp4");
  record::record(tessellationScene(), settings_, [](const record::Progress&) {
    std::this_thread::sleep_for(std::chrono::milliseconds(15));  // a slow deployment
    return record::Interruption();
  });
  EXPECT_TRUE(quick == bytesOf(settings_.folder / "deployment.mp4"));
}

TEST_F(RecordTest, SlowMotionTakesMoreSamples) {
  settings_.speed = 0.5;
  settings_.hold = 0.2;
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_EQ(summary.videoFrames, 17 + 2 * 4);  // 0.4 s at 40 a second, and the start; held
  record::PictureSettings lapse = settings_;
  lapse.speed = 4;
  lapse.hold = 0;
  // Frames at 0, 0.2 and 0.4 s.
  EXPECT_EQ(record::render(settings_.folder / "trajectory.h5", lapse, proceed_).videoFrames, 3);
}

TEST_F(RecordTest, TitleCardComesFirst) {
  settings_.title = "Rotating squares";
  EXPECT_EQ(record::record(tessellationScene(), settings_, proceed_).videoFrames, 9 + 40);
}

TEST_F(RecordTest, ChosenFramesAreTheNearestSamples) {
  settings_.video = settings_.snapshots = false;
  settings_.chosenFrames = {{0.1, record::FrameChoice::Unit::Seconds},
                            {1, record::FrameChoice::Unit::Share}};
  const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
  EXPECT_THAT(summary.files, Contains("frames/frame_00002.png"));
  EXPECT_THAT(summary.files, Contains("frames/frame_00008.png"));
  EXPECT_THAT(summary.files, Not(Contains("frames/frame_00001.png")));
  settings_.chosenFrames = {{7, record::FrameChoice::Unit::Seconds}};
  EXPECT_EQ(messageOfRecording(),
            "error: --frames-at: 7 s is after the end of the run at 0.4 s; give times up to it, or "
            "shares "
            "such as 100%");
}

/// Two squares at a distance that fall out of a picture fitted to their start and target.
scene::Scene fallingScene() {
  scene::Scene scene = tessellationScene();
  scene.environment.gravity = {0, 0, -400};
  return scene;
}

TEST_F(RecordTest, ShowsBricksThatLeaveAPictureOfTheEnds) {
  settings_.appearance.camera.view = picture::kFrontView;
  settings_.frames = true;
  settings_.snapshots = false;
  const record::RunSummary summary = record::record(fallingScene(), settings_, proceed_);
  ASSERT_EQ(summary.videoFrames, 9);
  EXPECT_TRUE(hasFreeBorder(test::readPng(settings_.folder / "frames/frame_00008.png")));
}

TEST_F(RecordTest, PicturesWithoutVideoShowTheRunWholeToo) {
  settings_.appearance.camera.view = picture::kFrontView;
  settings_.video = settings_.snapshots = false;
  settings_.chosenFrames = {{1, record::FrameChoice::Unit::Share}};
  record::record(fallingScene(), settings_, proceed_);
  EXPECT_TRUE(hasFreeBorder(test::readPng(settings_.folder / "frames/frame_00008.png")));
}

TEST_F(RecordTest, ErrorOfAStageEndsTheOthers) {
  // Folder for frames. There are more than queues hold.
  settings_.frames = true;
  settings_.pace = record::Pace::Even;
  const auto recording = [this] {
    record::record(tessellationScene(), settings_, [this](const record::Progress&) {
      const fs::path frames = settings_.folder / ".unfinished/frames";
      if (fs::remove_all(frames) > 0) std::ofstream(frames) << "no folder";
      return record::Interruption{};
    });
  };
  EXPECT_THROW(recording(), OutputError);
  EXPECT_FALSE(fs::exists(settings_.folder / "deployment.mp4"));
  EXPECT_FALSE(fs::exists(settings_.folder / "summary.json"));
}

TEST_F(RecordTest, MissesTheEncoderBeforeTheRun) {
  settings_.encoder = "libx999";
  const auto recording = [this] {
    record::record(tessellationScene(), settings_,
                   [](const record::Progress&) -> record::Interruption { std::abort(); });
  };
  EXPECT_THROW(recording(), OutputError);
}

TEST_F(RecordTest, RefusesSettingsOutOfRangeBeforeTheRun) {
  settings_.framesPerSecond = 0;
  EXPECT_THAT(messageOfRecording(), HasSubstr("0"));
  settings_.framesPerSecond = 30;
  settings_.size = {97, 64};
  EXPECT_THAT(messageOfRecording(), HasSubstr("--size 98x64"));
  settings_.size = {0, 64};
  EXPECT_NE(messageOfRecording(), "accepted");
  settings_.size = {8000, 8000};
  settings_.grid = {10, 10};
  EXPECT_NE(messageOfRecording(), "accepted");
}

TEST_F(RecordTest, CameraShowsEveryFrameWhole) {
  settings_.frames = true;
  for (const picture::ViewAngles view :
       {picture::kTopView, picture::kFrontView, picture::kIsometricView}) {
    settings_.appearance.camera.view = view;
    const record::RunSummary summary = record::record(tessellationScene(), settings_, proceed_);
    for (const std::string& file : summary.files) {
      if (!file.starts_with("frames/")) continue;
      EXPECT_TRUE(hasFreeBorder(test::readPng(settings_.folder / file))) << file;
    }
  }
}

}  // namespace
}  // namespace kirireel
