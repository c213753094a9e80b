#include "render/picture/state_painter.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

picture::PictureContent tessellationContent(
    const std::optional<scene::Ground>& ground = std::nullopt) {
  return picture::makeContent(generate::makeTessellation({}), {}, ground);
}

TEST(PictureSetup, DrawsTheGroundIfItExistsOrIsRequested) {
  const scene::Ground ground{-1, 0.5};
  EXPECT_FALSE(
      picture::PictureSetup({}, tessellationContent(), {300, 300}).style().plate.has_value());
  EXPECT_EQ(
      picture::PictureSetup({}, tessellationContent(ground), {300, 300}).style().plate->height, -1);
  picture::Appearance appearance;
  appearance.ground = picture::GroundLook::None;
  EXPECT_FALSE(picture::PictureSetup(appearance, tessellationContent(ground), {300, 300})
                   .style()
                   .plate.has_value());
  appearance.ground = picture::GroundLook::Shadow;
  const picture::PictureSetup setup(appearance, tessellationContent(), {300, 300});
  EXPECT_FALSE(setup.style().plate->visible);
  EXPECT_EQ(setup.style().plate->height, 0);  // the tiles' own height
}

TEST(PictureSetup, GivesLinesTheirWidthsInPrint) {
  const auto styleOf = [](const picture::Appearance& appearance, picture::FrameSize size) {
    return picture::PictureSetup(appearance, tessellationContent(), size).style();
  };
  // 160 mm are 453.5 points.
  const picture::Style plain = styleOf({}, {1280, 720});
  EXPECT_NEAR(plain.slitWidth * 720, 0.5 * 1280 / 453.543, 1e-4);         // 1.411 pixels
  EXPECT_NEAR(plain.silhouetteWidth * 720, 0.75 * 1280 / 453.543, 1e-4);  // 2.117 pixels
  EXPECT_NEAR(plain.slitWidth, picture::Style().slitWidth, 1e-5);
  EXPECT_NEAR(plain.silhouetteWidth, picture::Style().silhouetteWidth, 1e-5);
  picture::Appearance appearance;
  appearance.pixelsPerInch = 600;
  appearance.outlineWidths = {0.25, 1};
  const picture::Style printed = styleOf(appearance, {900, 500});
  EXPECT_NEAR(printed.slitWidth * 500, 0.25 * 600 / 72, 1e-9);
  EXPECT_NEAR(printed.silhouetteWidth * 500, 600.0 / 72, 1e-9);
  appearance.outlines = false;
  EXPECT_EQ(styleOf(appearance, {900, 500}).slitWidth, 0);
}

TEST(PictureSetup, SharesOneScaleOnlyInAStillParallelView) {
  picture::Appearance appearance;
  appearance.camera.view = picture::kTopView;
  EXPECT_GT(
      picture::PictureSetup(appearance, tessellationContent(), {300, 300}).sharedHeight().value(),
      4);
  appearance.camera.orthographic = false;
  EXPECT_FALSE(picture::PictureSetup(appearance, tessellationContent(), {300, 300})
                   .sharedHeight()
                   .has_value());
  appearance.camera.orthographic = true;
  appearance.camera.orbit = 1;
  EXPECT_FALSE(picture::PictureSetup(appearance, tessellationContent(), {300, 300})
                   .sharedHeight()
                   .has_value());
}

TEST(PictureSetup, MarksJointsAndDrawsTheTargetOnRequest) {
  picture::Appearance appearance;
  appearance.jointMarks = true;
  appearance.targetLines = true;
  const picture::PictureSetup setup(appearance, tessellationContent(), {300, 300});
  const picture::PictureItems items = setup.items({0, setup.content().start, {}});
  EXPECT_EQ(items.marks.size(), 48U);  // 24 joints on both faces
  EXPECT_EQ(items.overlay.size(), 16U);
}

TEST(PictureSetup, DrawsObstaclesInGreyFromBothSides) {
  picture::PictureContent content = tessellationContent();
  const std::size_t without =
      picture::PictureSetup({}, content, {300, 300}).geometry({0, content.start, {}}).solid.size();
  content.obstacles = {{{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}}},
                       {{{0, 0, -1}, {0, 1, -1}, {1, 0, -1}}}};
  const picture::PictureGeometry geometry =
      picture::PictureSetup({}, content, {300, 300}).geometry({0, content.start, {}});
  ASSERT_EQ(geometry.solid.size(), without + 2);
  const picture::Colour colour = geometry.solid.back().colour;
  EXPECT_EQ(colour, geometry.solid[without].colour);  // for both senses of its corners
  EXPECT_LE(std::max({colour.red, colour.green, colour.blue}) -
                std::min({colour.red, colour.green, colour.blue}),
            3);
}

TEST(PictureSetup, RefusesACameraWithinABrick) {
  picture::Appearance appearance;
  appearance.camera.orthographic = false;
  appearance.camera.view = picture::kTopView;
  appearance.camera.distance = 1e-3;
  brick::BrickRule rule;
  rule.thickness = 1;
  const picture::PictureSetup setup(
      appearance,
      picture::makeContent({"", {generate::makeTessellation({}).tiles[0]}, {}, {}, {}}, rule, {}),
      {300, 300});
  EXPECT_EQ(test::refusalOf([&] {
              setup.camera({0.25, setup.content().start, {}});
            }),
            "error: at 0.25 s the camera is within brick 0; move it away with --distance, or "
            "choose --projection parallel");
}

TEST(PictureSetup, HasScalesInTheUnitOfTheModel) {
  picture::Appearance appearance;
  appearance.colouring = picture::Colouring::TargetError;
  picture::PictureContent content = tessellationContent();
  const picture::ColourScale metres =
      *picture::PictureSetup(appearance, content, {300, 300}).colourScale();
  content.unit = *findLengthUnit("mm");
  const picture::PictureSetup setup(appearance, content, {300, 300});
  EXPECT_EQ(setup.colourScale()->title, "target error, mm");
  EXPECT_NEAR(setup.colourScale()->most, 1000 * metres.most, 1e-12 * metres.most);
}

/// The legend has the colours of the painted tiles, also of translucent ones, in all planes.
TEST(PictureSetup, LegendShowsTilesAsPaintedFaceOn) {
  const picture::PictureContent flat = tessellationContent();
  for (const double opacity : {1.0, 0.5}) {
    for (const picture::Theme theme : {picture::Theme::Light, picture::Theme::Dark}) {
      for (const auto& [turn, view] :
           {std::pair{Vector3(0, 0, 0), picture::kTopView},
            std::pair{Vector3(std::numbers::pi / 2, 0, 0), picture::kFrontView},
            std::pair{Vector3(0, std::numbers::pi / 2, 0), picture::kRightView},
            std::pair{Vector3(std::numbers::pi, 0, 0), picture::kBottomView}}) {
        picture::PictureContent content = flat;
        const Quaternion rotation = rotationFromVector(turn);
        for (Pose& pose : content.start) {
          pose = {rotation * pose.position, rotation * pose.rotation};
        }
        content.target.reset();
        content.points = picture::shownCorners(content, content.start);
        picture::Appearance appearance;
        appearance.theme = theme;
        appearance.opacity = opacity;
        appearance.colouring = picture::Colouring::Shape;
        appearance.camera.view = view;
        appearance.outlines = false;
        const picture::FrameSize size{100, 100};
        picture::StatePainter painter(size, appearance, content, {});
        const picture::PictureSetup setup(appearance, content, size);
        const picture::Frame frame = painter.paint({0, content.start, {}}, {});
        const picture::Colour expected = setup.legend().at(0).colour;
        int found = 0;
        for (int y = 0; y < size.height; ++y) {
          for (int x = 0; x < size.width; ++x) found += frame.at(x, y) == expected ? 1 : 0;
        }
        EXPECT_GT(found, 4000) << opacity << ' ' << turn.transpose();
        if (theme == picture::Theme::Dark && opacity == 1) {
          EXPECT_GE(picture::contrastOf(expected, setup.style().background), 3);
        }
      }
    }
  }
}

TEST(PictureSetup, DrawsATrailUntilTheMomentOfThePicture) {
  picture::Appearance appearance;
  appearance.trails = {{2, 1}};
  picture::PictureContent content = tessellationContent();
  content.paths = {{{0, 1, 2}, {{9, 0, 0}, {9, 1, 0}, {9, 2, 0}}}};
  const picture::PictureSetup setup(appearance, content, {300, 300});
  const picture::PictureItems items = setup.items({1.5, content.start, {}});
  // The earlier samples, then the position of the vertex: the middle of the brick's edge there.
  const Vector3 here =
      content.start[2].apply(0.5 * (content.bricks[2].bottom[1] + content.bricks[2].top[1]));
  ASSERT_EQ(items.trails.size(), 1U);
  EXPECT_THAT(items.trails[0], testing::ElementsAre(Vector3(9, 0, 0), Vector3(9, 1, 0), here));
  // A visible line per part, none at the first sample.
  const std::size_t before = setup.geometry({0, content.start, {}}).solid.size();
  EXPECT_EQ(setup.geometry({1.5, content.start, {}}).solid.size(), before + 2);
}

TEST(PictureSetup, RefusesTrailsOfMissingVertices) {
  picture::Appearance appearance;
  appearance.trails = {{16, 0}};
  EXPECT_EQ(test::refusalOf([&] {
              picture::PictureSetup(appearance, tessellationContent(), {300, 300});
            }),
            "error: --trail: the model has no tile 16. Give tiles from 0 to 15");
  appearance.trails = {{0, 4}};
  EXPECT_EQ(test::refusalOf([&] {
              picture::PictureSetup(appearance, tessellationContent(), {300, 300});
            }),
            "error: --trail: tile 0 has no vertex 4. Give vertices from 0 to 3");
}

TEST(PictureSetup, RefusesLinesOfAMissingTarget) {
  picture::Appearance appearance;
  appearance.targetLines = true;
  picture::PictureContent content = tessellationContent();
  content.target.reset();
  EXPECT_EQ(test::refusalOf([&] {
              picture::PictureSetup(appearance, content, {300, 300});
            }),
            "error: the model has no target to draw; remove --target-lines or add target.txt");
}

TEST(PictureSetup, RefusesAGhostOfAMissingTarget) {
  picture::Appearance appearance;
  appearance.ghost = picture::Ghost::Target;
  picture::PictureContent content = tessellationContent();
  content.target.reset();
  EXPECT_EQ(test::refusalOf([&] {
              picture::PictureSetup(appearance, content, {300, 300});
            }),
            "error: the model has no target to draw; remove --ghost target or add target.txt");
  appearance.ghost = picture::Ghost::Start;
  EXPECT_EQ(test::refusalOf([&] {
              picture::PictureSetup(appearance, content, {300, 300});
            }),
            "accepted");
}

/// Pixel coordinates of points, from the camera's matrix.
std::vector<Eigen::Vector2d> projected(const std::vector<Vector3>& points,
                                       const picture::Camera& camera, picture::FrameSize size) {
  const Eigen::Matrix4d clip = picture::clipFromWorld(camera, size.aspect());
  std::vector<Eigen::Vector2d> pixels;
  for (const Vector3& point : points) {
    const Eigen::Vector4d at = clip * point.homogeneous();
    pixels.emplace_back(0.5 * (1 + at.x() / at.w()) * size.width,
                        0.5 * (1 - at.y() / at.w()) * size.height);
  }
  return pixels;
}

/// Whether a point is within a convex hull, or outside by at most `margin`: no direction separates
/// them.
bool isWithin(const Eigen::Vector2d& point, const std::vector<Eigen::Vector2d>& corners,
              double margin) {
  constexpr int kDirections = 720;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * 3.14159265358979 * k / kDirections;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double most = -1e300;
    for (const Eigen::Vector2d& corner : corners) most = std::max(most, direction.dot(corner));
    if (direction.dot(point) > most + margin) return false;
  }
  return true;
}

TEST(StatePainter, GhostChangesPixelsOnlyWithinTheTargetsBricks) {
  for (const bool isParallel : {true, false}) {
    picture::Appearance appearance;
    appearance.camera.view = picture::kIsometricView;
    appearance.camera.orthographic = isParallel;
    const picture::FrameSize size{160, 120};
    picture::PictureContent content = tessellationContent();
    // The target is the start, displaced.
    content.target = generate::makeTessellation({}).tiles;
    for (model::Tile& tile : *content.target) {
      for (Vector3& vertex : tile.vertices) vertex += Vector3(2.5, 0.5, 0.25);
      content.points.insert(content.points.end(), tile.vertices.begin(), tile.vertices.end());
    }
    picture::StatePainter painter(size, appearance, content);
    const picture::Frame without = painter.paint({0, content.start, {}});
    appearance.ghost = picture::Ghost::Target;
    painter.show(appearance, content);
    const picture::Frame with = painter.paint({0, content.start, {}});

    const picture::Camera camera = painter.setup().camera({0, content.start, {}});
    std::vector<std::vector<Eigen::Vector2d>> outlines;
    for (std::size_t i = 0; i < content.target->size(); ++i) {
      std::vector<Vector3> corners = (*content.target)[i].vertices;
      const std::size_t count = corners.size();
      for (std::size_t k = 0; k < count; ++k) {
        corners.push_back(corners[k] + content.bricks[i].thickness * content.bricks[i].normal);
      }
      outlines.push_back(projected(corners, camera, size));
    }
    int changed = 0, inside = 0, darkest = 255;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        const std::size_t at = 4 * (static_cast<std::size_t>(y) * size.width + x);
        if (std::equal(&with.pixels[at], &with.pixels[at] + 4, &without.pixels[at])) continue;
        ++changed;
        // Outlines of bricks in front may become slits.
        if (without.pixels[at + 1] == 255) darkest = std::min<int>(darkest, with.pixels[at + 1]);
        // A pixel reaches 0.7 pixels from its middle, half a line 0.6 pixels from the outline.
        const Eigen::Vector2d middle(x + 0.5, y + 0.5);
        inside += std::ranges::any_of(
            outlines, [&](const auto& corners) { return isWithin(middle, corners, 1.4); });
      }
    }
    EXPECT_GT(changed, 500);
    EXPECT_EQ(inside, changed);
    EXPECT_GE(darkest, 120);  // lines of bricks have 35
  }
}

TEST(PictureSetup, DepthCueMixesFacesByTheirDistance) {
  picture::Appearance appearance;
  appearance.camera.view = picture::kFrontView;  // the eye is on the side of -y
  appearance.camera.orthographic = true;
  appearance.background = picture::Colour{10, 200, 30};
  appearance.occlusion = 0;
  picture::PictureContent content = tessellationContent();
  content.target.reset();
  // Facing the eye: each tile is rotated about x, so its bottom's normal is -y.
  Poses poses = content.start;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].rotation = Eigen::AngleAxisd(1.5707963267948966, Vector3::UnitX());
    poses[i].position = Vector3(2.0 * static_cast<double>(i), 0.5 * static_cast<double>(i), 0);
  }
  content.start = poses;
  const picture::ShownState state{0, poses, {}};
  const picture::PictureGeometry plain =
      picture::PictureSetup(appearance, content, {300, 300}).geometry(state);
  appearance.depthCue = 0.4;
  const picture::PictureGeometry cued =
      picture::PictureSetup(appearance, content, {300, 300}).geometry(state);
  double nearest = 1e300, farthest = -1e300;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (const auto* corners : {&content.bricks[i].bottom, &content.bricks[i].top}) {
      for (const Vector3& corner : *corners) {
        nearest = std::min(nearest, poses[i].apply(corner).y());
        farthest = std::max(farthest, poses[i].apply(corner).y());
      }
    }
  }
  ASSERT_EQ(cued.solid.size(), plain.solid.size());
  for (std::size_t k = 0; k < cued.solid.size(); ++k) {
    double depth = 0;
    for (const Vector3& corner : cued.corners(cued.solid[k])) depth += corner.y();
    depth /= cued.solid[k].count;
    const double share = 0.4 * (depth - nearest) / (farthest - nearest);
    const picture::Colour before = plain.solid[k].colour, after = cued.solid[k].colour;
    EXPECT_NEAR(after.red, (1 - share) * before.red + share * 10, 0.51);
    EXPECT_NEAR(after.green, (1 - share) * before.green + share * 200, 0.51);
    EXPECT_NEAR(after.blue, (1 - share) * before.blue + share * 30, 0.51);
    EXPECT_EQ(after.alpha, before.alpha);
  }
}

TEST(PictureSetup, DepthCueKeepsAFlatSheetSeenFromAbove) {
  picture::Appearance appearance;
  appearance.camera.view = picture::kTopView;
  picture::PictureContent content = tessellationContent();
  content.target.reset();
  const picture::ShownState state{0, content.start, {}};
  const picture::PictureGeometry plain =
      picture::PictureSetup(appearance, content, {300, 300}).geometry(state);
  appearance.depthCue = 1;
  const picture::PictureGeometry cued =
      picture::PictureSetup(appearance, content, {300, 300}).geometry(state);
  ASSERT_EQ(cued.solid.size(), plain.solid.size());
  for (std::size_t k = 0; k < cued.solid.size(); ++k) {
    EXPECT_EQ(cued.solid[k].colour, plain.solid[k].colour);
  }
}

TEST(StatePainter, RefusesAnEmptyPictureBeforeItDividesByIt) {
  EXPECT_EQ(test::refusalOf([] {
              picture::StatePainter({100, 0}, {}, tessellationContent());
            }),
            "error: a picture of 100 x 0 pixels cannot be drawn; width and height may be 1 to "
            "16384, for example --size 1280x720");
}

TEST(StatePainter, PutsABarOfColoursUnderPicturesThatNeedIt) {
  picture::Appearance appearance;
  appearance.colouring = picture::Colouring::TargetError;
  picture::StatePainter painter({320, 180}, appearance, tessellationContent(), {.colours = true});
  const picture::ShownState state{0, painter.setup().content().start, {}};
  const picture::Frame frame = painter.paint(state);
  EXPECT_EQ(frame.size, (picture::FrameSize{320, 180}));
  const int height = painter.setup().pictureSize().height;
  EXPECT_LT(height, 170);
  // Above the strip is the picture, in a smaller format.
  picture::StatePainter small({320, height}, appearance, tessellationContent());
  const picture::Frame picture = small.paint(state);
  EXPECT_TRUE(std::equal(picture.pixels.begin(), picture.pixels.end(), frame.pixels.begin()));
  picture::StatePainter plain({320, 180}, {}, tessellationContent());
  picture::StatePainter asked({320, 180}, {}, tessellationContent(), {.colours = true});
  EXPECT_EQ(plain.paint(state).pixels, asked.paint(state).pixels);
}

// The shadow is larger than the bricks, and is still visible as a whole.
TEST(StatePainter, KeepsTheShadowInThePicture) {
  picture::Appearance appearance;
  appearance.ground = picture::GroundLook::Shadow;
  appearance.camera.view = picture::kIsometricView;
  picture::PictureContent tall = tessellationContent();
  for (Vector3& point : tall.points) point.z() += 3;
  for (Pose& pose : tall.start) pose.position.z() += 3;
  tall.points.emplace_back(0, 0, 0);
  picture::StatePainter painter({320, 180}, appearance, tall);
  const picture::Frame frame = painter.paint({0, tall.start, {}});
  for (int x = 0; x < frame.size.width; ++x) {
    ASSERT_EQ(frame.at(x, 0), picture::Style().background);
    ASSERT_EQ(frame.at(x, frame.size.height - 1), picture::Style().background);
  }
  for (int y = 0; y < frame.size.height; ++y) {
    ASSERT_EQ(frame.at(0, y), picture::Style().background);
    ASSERT_EQ(frame.at(frame.size.width - 1, y), picture::Style().background);
  }
}

TEST(StatePainter, RefusesAScaleBarInPerspective) {
  picture::Appearance appearance;
  appearance.camera.view = picture::kIsometricView;
  EXPECT_THROW(
      picture::StatePainter({320, 180}, appearance, tessellationContent(), {.scaleBar = true}),
      InputError);
}

TEST(StatePainter, ShowsOtherContentLikeANewPainter) {
  picture::Appearance dark;
  dark.theme = picture::Theme::Dark;
  dark.colouring = picture::Colouring::TargetError;
  picture::PictureContent wide = tessellationContent();
  wide.points.emplace_back(40, 0, 0);
  const auto paintIn = [](picture::StatePainter& painter) {
    return painter.paint({0, painter.setup().content().start, {}}).pixels;
  };
  picture::Appearance light = dark;
  light.theme = picture::Theme::Light;
  picture::StatePainter painter({320, 180}, light, tessellationContent(), {.colours = true});
  paintIn(painter);
  painter.show(dark, wide);
  picture::StatePainter fresh({320, 180}, dark, wide, {.colours = true});
  EXPECT_EQ(paintIn(painter), paintIn(fresh));
}

}  // namespace
}  // namespace kirireel
