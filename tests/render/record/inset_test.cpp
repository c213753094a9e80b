// Oracles: the place of a dot follows from a motion with known curves, the corner from pixels that
// the sheet colours, the rest of a frame from the frame without an inset.
#include "render/record/inset.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/picture/label.h"
#include "render/record/pace.h"
#include "render/record/record.h"
#include "render/record/run_pictures.h"
#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using testing::HasSubstr;

/// Text of a frame of 640 pixels: 6 points at 640 / 160 mm are 8.47 pixels, at least 9.
constexpr int kEm = 9;
constexpr picture::FrameSize kSize{640, 400};

class InsetTest : public testing::Test {
 protected:
  /// Two squares of side 1, the second of which moves along x: the width of the sheet is 2 + t at t
  /// seconds, up to 1 s.
  InsetTest() {
    scene_.model = generate::makeTessellation({.columns = 2, .rows = 1});
    scene_.model.joints.clear();
    scene_.model.target.reset();
    trajectory::Trajectory trajectory{trajectory::subjectOf(scene_)};
    const Poses start = brick::startPoses(scene_.model.tiles, trajectory.bricks);
    for (int k = 0; k <= 10; ++k) {
      trajectory::Sample sample;
      sample.time = 0.1 * k;
      sample.poses = start;
      sample.poses[1].position.x() += 0.1 * k;
      trajectory.samples.push_back(sample);
    }
    test::writeTrajectory(trajectory, folder_ / "run.h5");
    settings_.folder = folder_ / "pictures";
    settings_.size = kSize;
    settings_.inset = "width";
    settings_.pace = record::Pace::Real;
    settings_.snapshots = false;
  }

  record::FrameState stateAt(const trajectory::TrajectoryReader& run, double time) const {
    return {{time, time, 0}, record::Replay(run).at(time)};
  }

  /// The place of the dot from the rules of plots: 4.5 em for numbers, 1.5 em on the right, 2 em
  /// above and 4 em below the diagram.
  static Eigen::Vector2d expectedPlace(const record::Inset& inset, double time) {
    std::vector<double> widths;
    for (int k = 0; k <= 10; ++k) widths.push_back(2 + 0.1 * k);
    const picture::Axis up = picture::makeAxis(widths, 5);
    const auto& [left, upper, width, height] = inset.box();
    const double wide = width - 6 * kEm, high = height - 6 * kEm;
    return {left + 4.5 * kEm + time * wide, upper + 2 * kEm + (1 - up.shareOf(2 + time)) * high};
  }

  std::string refusal(const trajectory::TrajectoryReader& run) const {
    try {
      record::FramePainter(run, settings_);
      return "accepted";
    } catch (const InputError& error) {
      return error.what();
    }
  }

  scene::Scene scene_;
  test::TemporaryFolder folder_;
  record::PictureSettings settings_;
};

/// The middle of the pixels by which two frames differ, weighted by that difference.
Eigen::Vector2d middleOfChange(const picture::Frame& a, const picture::Frame& b) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0;
  for (int y = 0; y < a.size.height; ++y) {
    for (int x = 0; x < a.size.width; ++x) {
      const double weight = std::abs(a.at(x, y).green - b.at(x, y).green);
      sum += weight * Eigen::Vector2d(x + 0.5, y + 0.5);
      weights += weight;
    }
  }
  return sum / weights;
}

TEST_F(InsetTest, TheDotIsAtTheValueOfTheFrame) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  for (const record::Pace pace : {record::Pace::Real, record::Pace::Even}) {
    settings_.pace = pace;  // the motion is uniform, so both axes give the same places
    const record::FramePainter painter(run, settings_);
    const record::Inset inset(run, settings_, painter.setup());
    for (const double time : {0.0, 0.1, 0.25, 0.333, 0.95, 1.0}) {
      const std::vector<record::Inset::Dot> dots = inset.dots(time);
      ASSERT_EQ(dots.size(), 1U);
      EXPECT_LT((dots[0].place - expectedPlace(inset, time)).norm(), 1e-6);  // measured: 8e-14
      // On a page without anything else. White differs most from the dot, and from its ring least.
      picture::Frame without = picture::makeFrame(kSize, {255, 255, 255}), with = without;
      picture::blendDisc(with, dots[0].place.x(), dots[0].place.y(), inset.dotRadius(),
                         dots[0].colour);
      EXPECT_LT((middleOfChange(with, without) - expectedPlace(inset, time)).norm(), 0.1);
      const auto x = static_cast<int>(dots[0].place.x()), y = static_cast<int>(dots[0].place.y());
      picture::Frame frame = picture::makeFrame(kSize, {255, 255, 255});
      inset.draw(frame, time);
      EXPECT_EQ(frame.at(x, y), dots[0].colour);
    }
  }
}

TEST_F(InsetTest, ChangesOnlyItsPartOfTheFrame) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  settings_.captions = picture::CaptionParts{.time = true};
  settings_.progressBar = true;
  record::FramePainter with(run, settings_);
  const record::Inset inset(run, settings_, with.setup());
  settings_.inset.clear();
  record::FramePainter without(run, settings_);
  const auto box = inset.box();
  for (const double time : {0.0, 0.5, 1.0}) {
    const picture::Frame a = with.paint(stateAt(run, time)), b = without.paint(stateAt(run, time));
    int inside = 0, outside = 0;
    for (int y = 0; y < kSize.height; ++y) {
      for (int x = 0; x < kSize.width; ++x) {
        const bool isInside = x >= box.left && x < box.right() && y >= box.upper && y < box.lower();
        if (!(a.at(x, y) == b.at(x, y))) ++(isInside ? inside : outside);
      }
    }
    EXPECT_EQ(outside, 0);
    EXPECT_GT(inside, 1000);
  }
}

/// Pixels of the sheet in a part of a frame on white.
int sheetIn(const picture::Frame& frame, const picture::PageBox& part) {
  int count = 0;
  for (int y = static_cast<int>(part.upper); y < part.lower(); ++y) {
    for (int x = static_cast<int>(part.left); x < part.right(); ++x) {
      count += frame.at(x, y) == picture::Colour{255, 255, 255} ? 0 : 1;
    }
  }
  return count;
}

/// A rod of two squares from one corner of the picture to the opposite one leaves two corners free.
TEST_F(InsetTest, IsInTheCornerThatTheSheetCoversLeast) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  settings_.size = {400, 400};
  settings_.appearance.camera.margin = 0;
  std::set<std::pair<bool, bool>> corners;
  for (const double roll : {35.0, -35.0, 145.0, 90.0, 10.0}) {
    SCOPED_TRACE(roll);
    settings_.appearance.camera.view = {-90 * kDegree, 90 * kDegree, roll * kDegree};
    settings_.inset = "width";
    const record::FramePainter painter(run, settings_);
    const record::Inset inset(run, settings_, painter.setup());
    settings_.inset.clear();
    record::FramePainter plain(run, settings_);
    const picture::PageBox box = inset.box();
    const double right = settings_.size.width - box.right(), lower = 400 - box.lower();
    const auto mirrored = [&](bool isAcross, bool isUp) {
      picture::PageBox other = box;
      if (isAcross) other.left = right;
      if (isUp) other.upper = lower;
      return other;
    };
    std::vector<int> covers(4, 0);
    for (const double time : {0.0, 0.25, 0.5, 0.75, 1.0}) {
      const picture::Frame frame = plain.paint(stateAt(run, time));
      for (int k = 0; k < 4; ++k) covers[k] += sheetIn(frame, mirrored(k % 2 == 1, k / 2 == 1));
    }
    // In pixels of 22,680 in each corner and state.
    EXPECT_LE(covers[0], *std::ranges::min_element(covers) + 5 * 0.01 * box.width * box.height)
        << covers[0] << " " << covers[1] << " " << covers[2] << " " << covers[3];
    corners.insert({box.left > 200, box.upper > 200});
  }
  EXPECT_GE(corners.size(), 2U);
}

TEST_F(InsetTest, RefusesCurvesThatTheRunLacks) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  settings_.inset = "widht";
  EXPECT_THAT(refusal(run),
              HasSubstr("error: --inset: there is no curve 'widht'; give some of size, width, "
                        "height, depth, area"));
  // Without a target, joints and dynamics.
  for (const char* name : {"target_error", "theta", "kinetic_energy", "joint_gap", "load_curve"}) {
    settings_.inset = name;
    EXPECT_THAT(refusal(run), HasSubstr(fmt::format("no curve '{}'", name)));
    EXPECT_THAT(refusal(run), testing::Not(HasSubstr("theta,")));
    EXPECT_THAT(refusal(run), testing::EndsWith("radius"));
  }
}

TEST_F(InsetTest, RefusesFramesThatAreTooSmall) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  settings_.size = {240, 180};
  EXPECT_EQ(refusal(run),
            "error: --inset needs pictures of at least 225 x 230 pixels, here they have 240 x 180; "
            "give a larger --size or remove --inset");
  settings_.size = {225, 230};
  EXPECT_EQ(refusal(run), "accepted");
  // With the highest strip.
  settings_.captions = picture::CaptionParts{.time = true};
  settings_.progressBar = settings_.scaleBar = true;
  settings_.appearance.colouring = picture::Colouring::Rotation;
  const record::FramePainter painter(run, settings_);
  const picture::PageBox box = record::Inset(run, settings_, painter.setup()).box();
  EXPECT_LE(box.lower(), painter.setup().pictureSize().height);
  EXPECT_GE(box.upper, 0);
}

/// Text and lines have a contrast of 4.5 to the background.
TEST_F(InsetTest, IsReadableOnEveryBackground) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  settings_.inset = "size";
  for (const picture::Colour background :
       {picture::Colour{255, 255, 255}, picture::Colour{22, 24, 28}, picture::Colour{120, 130, 60},
        picture::Colour{0, 0, 0}, picture::Colour{200, 60, 60}}) {
    settings_.appearance.background = background;
    const record::FramePainter painter(run, settings_);
    for (const auto& [colour, place] : record::Inset(run, settings_, painter.setup()).dots(0.5)) {
      EXPECT_GE(picture::contrastOf(colour, background), 4.5);  // measured: 4.5 to 6.4
    }
  }
}

/// Its pixels do not depend on what is below it, also in transparent frames.
TEST_F(InsetTest, HidesWhatIsBelowIt) {
  const trajectory::TrajectoryReader run(folder_ / "run.h5");
  for (const bool isTransparent : {false, true}) {
    settings_.appearance.transparent = isTransparent;
    const record::FramePainter painter(run, settings_);
    const record::Inset inset(run, settings_, painter.setup());
    picture::Frame empty = picture::makeFrame(kSize, {255, 255, 255, 0});
    picture::Frame covered = picture::makeFrame(kSize, {20, 60, 90});
    inset.draw(empty, 0.5);
    inset.draw(covered, 0.5);
    const picture::PageBox box = inset.box();
    int different = 0, ink = 0;
    for (int y = static_cast<int>(box.upper); y < box.lower(); ++y) {
      for (int x = static_cast<int>(box.left); x < box.right(); ++x) {
        different += empty.at(x, y) == covered.at(x, y) ? 0 : 1;
        ink += empty.at(x, y) == picture::Colour{255, 255, 255} ? 0 : 1;
      }
    }
    EXPECT_EQ(different, 0);
    EXPECT_GT(ink, 500);
    EXPECT_LT(ink, 0.2 * box.width * box.height);
  }
}

TEST_F(InsetTest, VideosDoNotDependOnThreads) {
  std::string first;
  for (const int painters : {1, 3}) {
    settings_.painterCount = painters;
    settings_.framesPerSecond = 10;
    record::render(folder_ / "run.h5", settings_,
                   [](const record::Progress&) { return record::Interruption(); });
    const std::string bytes = test::bytesOf(settings_.folder / "deployment.mp4");
    if (painters == 1) first = bytes;
    EXPECT_TRUE(bytes == first);
  }
}

/// A run whose curves are not known before keeps its pictures.
TEST_F(InsetTest, ARecordingWithoutTheCurveHasAVideoWithoutInset) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({.columns = 2, .rows = 2});
  scene.model.target.reset();
  scene.stop.duration = 0.2;
  record::RecordSettings settings;
  settings.folder = folder_ / "recorded";
  settings.size = kSize;
  settings.inset = "target_error";
  settings.snapshots = false;
  std::string remark;
  record::record(scene, settings, [&remark](const record::Progress& progress) {
    if (!progress.remark.empty()) remark = progress.remark;
    return record::Interruption();
  });
  EXPECT_THAT(remark, HasSubstr("the video has no inset: error: --inset: there is no curve "
                                "'target_error'; give some of size"));
  settings.inset = "unknown";
  EXPECT_THROW(record::record(scene, settings,
                              [](const record::Progress&) { return record::Interruption(); }),
               InputError);
}

}  // namespace
}  // namespace kirireel
