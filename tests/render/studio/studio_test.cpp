#include "render/picture/studio.h"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

Motif tessellationMotif(const std::optional<Ground>& ground = std::nullopt) {
  return makeMotif(makeTessellation({}), {}, ground);
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Stage, DrawsTheGroundOnlyWhenThereIsOneOrItIsAskedFor) {
  const Ground ground{-1, 0.5};
  EXPECT_FALSE(Stage({}, tessellationMotif(), {300, 300}).style().plate.has_value());
  EXPECT_EQ(Stage({}, tessellationMotif(ground), {300, 300}).style().plate->height, -1);
  Look look;
  look.ground = GroundLook::None;
  EXPECT_FALSE(Stage(look, tessellationMotif(ground), {300, 300}).style().plate.has_value());
  look.ground = GroundLook::Shadow;
  const Stage stage(look, tessellationMotif(), {300, 300});
  EXPECT_FALSE(stage.style().plate->visible);
  EXPECT_EQ(stage.style().plate->height, 0);  // the tiles' own height
}

TEST(Stage, KeepsLinesTwoPixelsWideInSmallPictures) {
  EXPECT_EQ(Stage({}, tessellationMotif(), {160, 100}).style().edgeWidth, 0.02);
  EXPECT_EQ(Stage({}, tessellationMotif(), {2000, 2000}).style().edgeWidth, Style().edgeWidth);
}

TEST(Stage, SharesOneScaleOnlyInAStillParallelView) {
  Look look;
  look.camera.view = kTopView;
  EXPECT_GT(Stage(look, tessellationMotif(), {300, 300}).sharedHeight().value(), 4);
  look.camera.orthographic = false;
  EXPECT_FALSE(Stage(look, tessellationMotif(), {300, 300}).sharedHeight().has_value());
  look.camera.orthographic = true;
  look.camera.orbit = 1;
  EXPECT_FALSE(Stage(look, tessellationMotif(), {300, 300}).sharedHeight().has_value());
}

TEST(Stage, MarksJointsAndDrawsTheTargetOnRequest) {
  Look look;
  look.jointMarks = true;
  look.targetLines = true;
  const Stage stage(look, tessellationMotif(), {300, 300});
  const Shot shot = stage.shot({0, stage.motif().start, {}});
  EXPECT_EQ(shot.marks.size(), 48U);  // 24 joints on both faces
  EXPECT_EQ(shot.overlay.size(), 16U);
}

TEST(Stage, DrawsObstaclesInGreyFromBothSides) {
  Motif motif = tessellationMotif();
  const std::size_t without =
      Stage({}, motif, {300, 300}).sketch({0, motif.start, {}}).solid.size();
  motif.obstacles = {{{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}}},
                     {{{0, 0, -1}, {0, 1, -1}, {1, 0, -1}}}};
  const Sketch sketch = Stage({}, motif, {300, 300}).sketch({0, motif.start, {}});
  ASSERT_EQ(sketch.solid.size(), without + 2);
  const Colour colour = sketch.solid.back().colour;
  EXPECT_EQ(colour, sketch.solid[without].colour);  // whichever way round its corners are
  EXPECT_LE(std::max({colour.red, colour.green, colour.blue}) -
                std::min({colour.red, colour.green, colour.blue}),
            3);
}

TEST(Stage, RefusesACameraWithinABrick) {
  Look look;
  look.camera.orthographic = false;
  look.camera.view = kTopView;
  look.camera.distance = 1e-3;
  BrickRule rule;
  rule.thickness = 1;
  const Stage stage(look, makeMotif({"", {makeTessellation({}).tiles[0]}, {}, {}, {}}, rule, {}),
                    {300, 300});
  EXPECT_EQ(errorOf([&] {
              stage.camera({0.25, stage.motif().start, {}});
            }),
            "error: at 0.25 s the camera stands within brick 0; move it away with --distance, or "
            "choose --projection parallel");
}

TEST(Stage, RefusesLinesOfATargetThatIsNotThere) {
  Look look;
  look.targetLines = true;
  Motif motif = tessellationMotif();
  motif.target.reset();
  EXPECT_EQ(errorOf([&] {
              Stage(look, motif, {300, 300});
            }),
            "error: the model has no target to draw; leave --target-lines away or add target.txt");
}

TEST(Studio, RefusesAnEmptyPictureBeforeItDividesByIt) {
  EXPECT_EQ(errorOf([] {
              Studio({100, 0}, {}, tessellationMotif());
            }),
            "error: a picture of 100 x 0 pixels cannot be drawn; width and height may be 1 to "
            "16384, for example --size 1280x720");
}

TEST(Studio, PutsABarOfColoursUnderPicturesThatNeedIt) {
  Look look;
  look.colouring = Colouring::TargetError;
  Studio studio({320, 180}, look, tessellationMotif(), {.colours = true});
  const Moment moment{0, studio.stage().motif().start, {}};
  const Frame frame = studio.take(moment);
  EXPECT_EQ(frame.size, (FrameSize{320, 180}));
  const int height = studio.stage().pictureSize().height;
  EXPECT_LT(height, 170);
  // Above the strip is the picture, in a smaller format.
  Studio small({320, height}, look, tessellationMotif());
  const Frame picture = small.take(moment);
  EXPECT_TRUE(std::equal(picture.pixels.begin(), picture.pixels.end(), frame.pixels.begin()));
  Studio plain({320, 180}, {}, tessellationMotif());
  Studio asked({320, 180}, {}, tessellationMotif(), {.colours = true});
  EXPECT_EQ(plain.take(moment).pixels, asked.take(moment).pixels);
}

// The shadow reaches farther than the bricks, and is in sight all the same.
TEST(Studio, HoldsTheShadowInSight) {
  Look look;
  look.ground = GroundLook::Shadow;
  look.camera.view = kIsometricView;
  Motif tall = tessellationMotif();
  for (Vector3& point : tall.points) point.z() += 3;
  for (Pose& pose : tall.start) pose.position.z() += 3;
  tall.points.emplace_back(0, 0, 0);
  Studio studio({320, 180}, look, tall);
  const Frame frame = studio.take({0, tall.start, {}});
  for (int x = 0; x < frame.size.width; ++x) {
    ASSERT_EQ(frame.at(x, 0), Style().background);
    ASSERT_EQ(frame.at(x, frame.size.height - 1), Style().background);
  }
  for (int y = 0; y < frame.size.height; ++y) {
    ASSERT_EQ(frame.at(0, y), Style().background);
    ASSERT_EQ(frame.at(frame.size.width - 1, y), Style().background);
  }
}

TEST(Studio, RefusesAScaleBarInPerspective) {
  Look look;
  look.camera.view = kIsometricView;
  EXPECT_THROW(Studio({320, 180}, look, tessellationMotif(), {.scaleBar = true}), InputError);
}

TEST(Studio, ShowsAnotherMotifAsANewStudioWould) {
  Look dark;
  dark.theme = Theme::Dark;
  dark.colouring = Colouring::TargetError;
  Motif wide = tessellationMotif();
  wide.points.emplace_back(40, 0, 0);
  const auto takeIn = [](Studio& studio) {
    return studio.take({0, studio.stage().motif().start, {}}).pixels;
  };
  Look light = dark;
  light.theme = Theme::Light;
  Studio studio({320, 180}, light, tessellationMotif(), {.colours = true});
  takeIn(studio);
  studio.show(dark, wide);
  Studio fresh({320, 180}, dark, wide, {.colours = true});
  EXPECT_EQ(takeIn(studio), takeIn(fresh));
}

}  // namespace
}  // namespace kirireel
