#include "render/picture/state_painter.h"

#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

PictureContent tessellationContent(const std::optional<Ground>& ground = std::nullopt) {
  return makeContent(makeTessellation({}), {}, ground);
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PictureSetup, DrawsTheGroundOnlyWhenThereIsOneOrItIsAskedFor) {
  const Ground ground{-1, 0.5};
  EXPECT_FALSE(PictureSetup({}, tessellationContent(), {300, 300}).style().plate.has_value());
  EXPECT_EQ(PictureSetup({}, tessellationContent(ground), {300, 300}).style().plate->height, -1);
  Look look;
  look.ground = GroundLook::None;
  EXPECT_FALSE(
      PictureSetup(look, tessellationContent(ground), {300, 300}).style().plate.has_value());
  look.ground = GroundLook::Shadow;
  const PictureSetup setup(look, tessellationContent(), {300, 300});
  EXPECT_FALSE(setup.style().plate->visible);
  EXPECT_EQ(setup.style().plate->height, 0);  // the tiles' own height
}

TEST(PictureSetup, KeepsLinesTwoPixelsWideInSmallPictures) {
  EXPECT_EQ(PictureSetup({}, tessellationContent(), {160, 100}).style().edgeWidth, 0.02);
  EXPECT_EQ(PictureSetup({}, tessellationContent(), {2000, 2000}).style().edgeWidth,
            Style().edgeWidth);
}

TEST(PictureSetup, SharesOneScaleOnlyInAStillParallelView) {
  Look look;
  look.camera.view = kTopView;
  EXPECT_GT(PictureSetup(look, tessellationContent(), {300, 300}).sharedHeight().value(), 4);
  look.camera.orthographic = false;
  EXPECT_FALSE(PictureSetup(look, tessellationContent(), {300, 300}).sharedHeight().has_value());
  look.camera.orthographic = true;
  look.camera.orbit = 1;
  EXPECT_FALSE(PictureSetup(look, tessellationContent(), {300, 300}).sharedHeight().has_value());
}

TEST(PictureSetup, MarksJointsAndDrawsTheTargetOnRequest) {
  Look look;
  look.jointMarks = true;
  look.targetLines = true;
  const PictureSetup setup(look, tessellationContent(), {300, 300});
  const PictureItems items = setup.items({0, setup.content().start, {}});
  EXPECT_EQ(items.marks.size(), 48U);  // 24 joints on both faces
  EXPECT_EQ(items.overlay.size(), 16U);
}

TEST(PictureSetup, DrawsObstaclesInGreyFromBothSides) {
  PictureContent content = tessellationContent();
  const std::size_t without =
      PictureSetup({}, content, {300, 300}).geometry({0, content.start, {}}).solid.size();
  content.obstacles = {{{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}}},
                       {{{0, 0, -1}, {0, 1, -1}, {1, 0, -1}}}};
  const PictureGeometry geometry =
      PictureSetup({}, content, {300, 300}).geometry({0, content.start, {}});
  ASSERT_EQ(geometry.solid.size(), without + 2);
  const Colour colour = geometry.solid.back().colour;
  EXPECT_EQ(colour, geometry.solid[without].colour);  // whichever way round its corners are
  EXPECT_LE(std::max({colour.red, colour.green, colour.blue}) -
                std::min({colour.red, colour.green, colour.blue}),
            3);
}

TEST(PictureSetup, RefusesACameraWithinABrick) {
  Look look;
  look.camera.orthographic = false;
  look.camera.view = kTopView;
  look.camera.distance = 1e-3;
  BrickRule rule;
  rule.thickness = 1;
  const PictureSetup setup(
      look, makeContent({"", {makeTessellation({}).tiles[0]}, {}, {}, {}}, rule, {}), {300, 300});
  EXPECT_EQ(errorOf([&] {
              setup.camera({0.25, setup.content().start, {}});
            }),
            "error: at 0.25 s the camera stands within brick 0; move it away with --distance, or "
            "choose --projection parallel");
}

TEST(PictureSetup, RefusesLinesOfATargetThatIsNotThere) {
  Look look;
  look.targetLines = true;
  PictureContent content = tessellationContent();
  content.target.reset();
  EXPECT_EQ(errorOf([&] {
              PictureSetup(look, content, {300, 300});
            }),
            "error: the model has no target to draw; leave --target-lines away or add target.txt");
}

TEST(StatePainter, RefusesAnEmptyPictureBeforeItDividesByIt) {
  EXPECT_EQ(errorOf([] {
              StatePainter({100, 0}, {}, tessellationContent());
            }),
            "error: a picture of 100 x 0 pixels cannot be drawn; width and height may be 1 to "
            "16384, for example --size 1280x720");
}

TEST(StatePainter, PutsABarOfColoursUnderPicturesThatNeedIt) {
  Look look;
  look.colouring = Colouring::TargetError;
  StatePainter painter({320, 180}, look, tessellationContent(), {.colours = true});
  const ShownState state{0, painter.setup().content().start, {}};
  const Frame frame = painter.paint(state);
  EXPECT_EQ(frame.size, (FrameSize{320, 180}));
  const int height = painter.setup().pictureSize().height;
  EXPECT_LT(height, 170);
  // Above the strip is the picture, in a smaller format.
  StatePainter small({320, height}, look, tessellationContent());
  const Frame picture = small.paint(state);
  EXPECT_TRUE(std::equal(picture.pixels.begin(), picture.pixels.end(), frame.pixels.begin()));
  StatePainter plain({320, 180}, {}, tessellationContent());
  StatePainter asked({320, 180}, {}, tessellationContent(), {.colours = true});
  EXPECT_EQ(plain.paint(state).pixels, asked.paint(state).pixels);
}

// The shadow reaches farther than the bricks, and is in sight all the same.
TEST(StatePainter, HoldsTheShadowInSight) {
  Look look;
  look.ground = GroundLook::Shadow;
  look.camera.view = kIsometricView;
  PictureContent tall = tessellationContent();
  for (Vector3& point : tall.points) point.z() += 3;
  for (Pose& pose : tall.start) pose.position.z() += 3;
  tall.points.emplace_back(0, 0, 0);
  StatePainter painter({320, 180}, look, tall);
  const Frame frame = painter.paint({0, tall.start, {}});
  for (int x = 0; x < frame.size.width; ++x) {
    ASSERT_EQ(frame.at(x, 0), Style().background);
    ASSERT_EQ(frame.at(x, frame.size.height - 1), Style().background);
  }
  for (int y = 0; y < frame.size.height; ++y) {
    ASSERT_EQ(frame.at(0, y), Style().background);
    ASSERT_EQ(frame.at(frame.size.width - 1, y), Style().background);
  }
}

TEST(StatePainter, RefusesAScaleBarInPerspective) {
  Look look;
  look.camera.view = kIsometricView;
  EXPECT_THROW(StatePainter({320, 180}, look, tessellationContent(), {.scaleBar = true}),
               InputError);
}

TEST(StatePainter, ShowsAnotherMotifAsANewStudioWould) {
  Look dark;
  dark.theme = Theme::Dark;
  dark.colouring = Colouring::TargetError;
  PictureContent wide = tessellationContent();
  wide.points.emplace_back(40, 0, 0);
  const auto paintIn = [](StatePainter& painter) {
    return painter.paint({0, painter.setup().content().start, {}}).pixels;
  };
  Look light = dark;
  light.theme = Theme::Light;
  StatePainter painter({320, 180}, light, tessellationContent(), {.colours = true});
  paintIn(painter);
  painter.show(dark, wide);
  StatePainter fresh({320, 180}, dark, wide, {.colours = true});
  EXPECT_EQ(paintIn(painter), paintIn(fresh));
}

}  // namespace
}  // namespace kirireel
