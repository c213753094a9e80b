#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/record/record.h"
#include "render/record/run_pictures.h"
#include "sim/base/error.h"
#include "sim/model/lattice.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

class FigureTest : public testing::Test {
 protected:
  /// Records a sheet of squares; returns its trajectory.
  fs::path recorded(const std::string& name, int side) {
    scene::Scene scene;
    scene.model = model::makeTessellation({.columns = side, .rows = side});
    scene.model.name = name;
    scene.stop.duration = 0.5;
    record::RecordSettings settings;
    settings.folder = folder_.path() / name;
    settings.video = settings.snapshots = settings.meshes = false;
    record::record(scene, settings, [](const record::Progress&) { return record::Interruption(); });
    return settings.folder / "trajectory.h5";
  }

  record::PictureSettings settings() const {
    record::PictureSettings figure;
    figure.folder = folder_.path() / "figure";
    figure.size = {160, 120};
    figure.grid.columns = 3;
    return figure;
  }

  test::TemporaryFolder folder_;
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
      scales.push_back(picture::PictureSetup(row.look, row.content, {160, 120}).metresPerPixel());
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
  record::renderFigure({recorded("small", 2), recorded("large", 3)}, figure);
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
  figure.look.camera.orbit = 1;
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
  record::renderFigure({recorded("small", 2), recorded("large", 3)}, figure);
  const std::string svg = test::bytesOf(figure.folder / "snapshots.svg");
  EXPECT_THAT(svg, testing::ContainsRegex("font-weight=\"bold\" fill=\"#1e1e1e\">a</text>"));
  EXPECT_THAT(svg, testing::ContainsRegex("font-weight=\"bold\" fill=\"#1e1e1e\">b</text>"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr(">c</text>")));
}

}  // namespace
}  // namespace kirireel
