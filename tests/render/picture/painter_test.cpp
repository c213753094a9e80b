#include "render/picture/painter.h"

#include <cmath>
#include <map>
#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "render/picture/gl_context.h"
#include "sim/base/error.h"
#include "tests/render/picture/sample_bricks.h"
#include "tests/support/polygons.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

/// Black, unlit, without outlines: a pixel's darkness is its covered fraction.
picture::Style silhouette() {
  picture::Style style;
  style.brick = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  style.slitWidth = 0;
  return style;
}

/// Sum over the picture of the part of each pixel that is covered.
double coveredPixels(const picture::Frame& frame) {
  double sum = 0;
  for (std::size_t red = 0; red < frame.pixels.size(); red += 4) {
    sum += (255 - frame.pixels[red]) / 255.0;
  }
  return sum;
}

/// A parallel view of `height` metres onto the point.
picture::Camera parallelCamera(const Vector3& centre, picture::ViewAngles view, double height) {
  const std::vector<Vector3> point = {centre};
  picture::CameraFit fit{view, 1, true};
  picture::Camera camera = picture::fitCamera(point, fit);
  camera.eye = centre + 50 * (camera.eye - centre).normalized();
  camera.viewHeight = height;
  camera.far = 100;
  return camera;
}

picture::Frame paintOnce(const SampleBricks& sample, picture::FrameSize size,
                         const picture::Camera& camera, const picture::Style& style) {
  return picture::Painter(size, sample.bricks, style).paint(sample.poses, camera);
}

picture::Camera fittedCamera(const SampleBricks& sample, picture::FrameSize size,
                             picture::ViewAngles view) {
  picture::CameraFit fit;
  fit.view = view;
  fit.aspect = size.aspect();
  return picture::fitCamera(picture::brickCorners(sample.bricks, sample.poses), fit);
}

/// Thirty colours that differ.
picture::Colour kindOf(int k) {
  return {static_cast<std::uint8_t>(8 * k), static_cast<std::uint8_t>(240 - 7 * k), 128};
}

TEST(Painter, CoversTheAreaOfABrickSeenFromAbove) {
  SampleBricks sample = sampleBricks({rectangleTile(0, 0, 3, 2)}, 0.4);
  for (const double angle : {0.0, 0.3, 0.8, 1.4}) {
    sample.poses[0].rotation = rotationFromVector(Vector3(0, 0, angle));
    const picture::Camera camera = parallelCamera(sample.poses[0].position, picture::kTopView, 5);
    const picture::Frame frame = paintOnce(sample, {400, 300}, camera, silhouette());
    const double expected = 3 * 2 * std::pow(300 / 5.0, 2);
    EXPECT_NEAR(coveredPixels(frame) / expected, 1, 0.005) << angle;  // measured 5e-4
  }
}

TEST(Painter, CoversTheAreaOfConcaveBricks) {
  for (const model::Tile& tile : {test::starShape(5, 2, 0.7), test::lShape()}) {
    SampleBricks sample = sampleBricks({tile}, 0.4);
    for (const double angle : {0.0, 0.8}) {
      sample.poses[0].rotation = rotationFromVector(Vector3(0, 0, angle));
      const picture::Camera camera = parallelCamera(sample.poses[0].position, picture::kTopView, 6);
      const picture::Frame frame = paintOnce(sample, {400, 300}, camera, silhouette());
      const double expected = model::tileArea(tile) * std::pow(300 / 6.0, 2);
      EXPECT_NEAR(coveredPixels(frame) / expected, 1, 0.005) << angle;  // measured 1e-3
    }
  }
}

// Second method: OpenGL, which draws the sheet if one brick is higher.
TEST(Painter, DrawsFlatSheetsAsOpenGlDoes) {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 30; ++k) tiles.push_back(rectangleTile(0.9 * (k % 6), 1.1 * (k / 6), 1, 1));
  SampleBricks sample = sampleBricks(tiles, 0.2);
  for (int k = 0; k < 30; ++k) sample.poses[k].rotation = rotationFromVector({0, 0, 0.1 * k});
  picture::Style style;
  style.occlusion = style.slitWidth = 0;
  const picture::Camera camera = parallelCamera({2.7, 2.7, 0}, picture::kTopView, 7);
  for (const auto smoothness : {picture::Smoothness::Still, picture::Smoothness::Film}) {
    for (const picture::FrameSize size : {picture::FrameSize{400, 301}, {97, 33}}) {
      picture::Painter painter(size, sample.bricks, style, smoothness);
      picture::PictureItems items{sample.poses};
      for (int k = 0; k < 30; ++k) items.colours.push_back(picture::shadesOf(kindOf(k)));
      const picture::Frame flat = painter.paint(items, camera);
      // The last brick is drawn last, so it is below the others where they overlap.
      Poses raised = sample.poses;
      for (int k = 0; k < 30; ++k) raised[k].position.z() -= 1e-3 * k;
      picture::PictureItems steps{raised};
      steps.colours = items.colours;
      const picture::Frame byDepth = painter.paint(steps, camera);
      long differing = 0;
      for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) differing += flat.at(x, y) != byDepth.at(x, y);
      }
      EXPECT_LE(differing, 8);  // 0 to 2, on sides that nearly touch a sample
      EXPECT_NE(flat.at(size.width / 2, size.height / 2), style.background);
    }
  }
}

TEST(Painter, CoversTheProjectedAreaOfABrickSeenFromACorner) {
  // A box's shadow along d is the sum of face areas times |d . normal|.
  const Vector3 sides(3, 2, 0.4);
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, sides.x(), sides.y())}, sides.z());
  const Vector3 faces(sides.y() * sides.z(), sides.x() * sides.z(), sides.x() * sides.y());
  for (const picture::ViewAngles view :
       {picture::kIsometricView, picture::kObliqueView, picture::ViewAngles{0.3, 0.2}}) {
    const picture::Camera camera = parallelCamera(sample.poses[0].position, view, 5);
    const Vector3 direction = (camera.eye - camera.centre).normalized();
    const picture::Frame frame = paintOnce(sample, {400, 300}, camera, silhouette());
    const double expected = faces.dot(direction.cwiseAbs()) * std::pow(300 / 5.0, 2);
    EXPECT_NEAR(coveredPixels(frame) / expected, 1, 0.005);  // measured 1e-3
  }
}

TEST(Painter, CoversTheAreaAcrossThePartsOfALargePicture) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 4, 0.8)}, 0.4);
  const picture::Camera camera = parallelCamera(sample.poses[0].position, picture::kTopView, 1);
  const picture::Frame frame = paintOnce(sample, {5000, 1000}, camera, silhouette());
  EXPECT_NEAR(coveredPixels(frame) / (4000.0 * 800), 1, 1e-6);  // measured 0
  // The seam between two parts lies within the brick and must be invisible.
  for (int x = 500; x < 4500; ++x) ASSERT_EQ(frame.at(x, 500), (picture::Colour{0, 0, 0})) << x;
}

TEST(Painter, GivesFacesSeenFaceOnOneColourInAnyPlane) {
  picture::Style style;
  style.slitWidth = 0;
  // One brick at a time, seen face on: the picture's middle is the face.
  const SampleBricks cube = sampleBricks({rectangleTile(0, 0, 1, 1)}, 1);
  SampleBricks sample = cube;
  picture::Painter painter({64, 64}, cube.bricks, style);
  for (int k = 0; k < 40; ++k) {
    const Quaternion turn = rotationFromVector(Vector3(0.37 * k, 1 - 0.21 * k, 0.13 * k));
    sample.poses[0].rotation = turn;
    for (const auto& [axis, base] :
         {std::pair<Vector3, picture::Colour>{Vector3::UnitZ(), style.brick.top},
          {-Vector3::UnitZ(), style.brick.bottom},
          {Vector3::UnitX(), style.brick.side},
          {-Vector3::UnitY(), style.brick.side}}) {
      const Vector3 normal = turn * axis;
      const picture::ViewAngles view{std::atan2(normal.y(), normal.x()), std::asin(normal.z())};
      const picture::Camera camera = parallelCamera(cube.poses[0].position, view, 2.5);
      EXPECT_EQ(painter.paint(sample.poses, camera).at(32, 32),
                picture::faceColour(Vector3::UnitZ(), base, style));
    }
  }
}

/// A rotation of the model together with its camera changes nothing.
TEST(Painter, LightsMoveWithTheCamera) {
  picture::Style style;
  style.slitWidth = 0;
  const SampleBricks cube = sampleBricks({rectangleTile(0, 0, 1, 1)}, 1);
  picture::Painter painter({64, 64}, cube.bricks, style);
  const picture::Camera camera =
      parallelCamera(cube.poses[0].position, picture::kIsometricView, 2.5);
  const picture::Frame expected = painter.paint(cube.poses, camera);
  std::size_t differing = 0;
  for (int k = 1; k < 10; ++k) {
    const Pose turn{{}, rotationFromVector(Vector3(0.37 * k, 1 - 0.21 * k, 0.13 * k))};
    const auto turned = [&](const Vector3& point) -> Vector3 { return turn.rotation * point; };
    picture::Camera moved = camera;
    moved.eye = turned(camera.eye);
    moved.centre = turned(camera.centre);
    moved.up = turned(camera.up);
    SampleBricks sample = cube;
    sample.poses[0] = {turned(cube.poses[0].position), turn.rotation * cube.poses[0].rotation};
    const picture::Frame frame = painter.paint(sample.poses, moved);
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) differing += frame.at(x, y) == expected.at(x, y) ? 0 : 1;
    }
  }
  EXPECT_LE(differing, 9 * 8U);  // samples on borders
}

TEST(Painter, ShowsOnlyFaceColoursWithinFaces) {
  // Seen from a corner, a brick shows three faces; all pixels that are not mixtures have one of
  // three colours, or the background's.
  picture::Style style;
  style.slitWidth = 0;
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 1);
  const picture::FrameSize size{200, 200};
  const picture::Frame frame =
      paintOnce(sample, size, fittedCamera(sample, size, picture::kIsometricView), style);
  std::map<int, int> counts;
  for (std::size_t k = 0; k < frame.pixels.size(); k += 4) {
    ++counts[frame.pixels[k] << 16 | frame.pixels[k + 1] << 8 | frame.pixels[k + 2]];
  }
  const auto count = [&](picture::Colour c) { return counts[c.red << 16 | c.green << 8 | c.blue]; };
  const Matrix3 axes =
      picture::pictureFromWorld(fittedCamera(sample, size, picture::kIsometricView));
  const int flat = count(picture::faceColour(axes.col(2), style.brick.top, style)) +
                   count(picture::faceColour(axes.col(0), style.brick.side, style)) +
                   count(picture::faceColour(-axes.col(1), style.brick.side, style)) +
                   count(style.background);
  EXPECT_GT(flat, 0.96 * 200 * 200);  // measured 0.986: the rest are edges
}

TEST(Painter, ShowsNoSeamBetweenFlushBricks) {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 16; ++k) tiles.push_back(rectangleTile(k % 4, k / 4, 1, 1));
  const SampleBricks sample = sampleBricks(tiles, 0.3);
  picture::Style style;
  style.slitWidth = 0;
  const picture::Colour top = picture::faceColour(Vector3::UnitZ(), style.brick.top, style);
  const picture::FrameSize size{301, 203};
  const picture::Camera camera = fittedCamera(sample, size, picture::kTopView);
  const picture::Frame frame = paintOnce(sample, size, camera, style);
  for (int y = 20; y < 183; ++y) {
    for (int x = 80; x < 220; ++x) ASSERT_EQ(frame.at(x, y), top) << x << ' ' << y;
  }
}

TEST(Painter, DrawsWholeLinesOnEdges) {
  // Two flush faces, 20 to 100 and 100 to 180, in a picture of 200 pixels.
  const SampleBricks sample =
      sampleBricks({rectangleTile(0, 0, 0.8, 0.8), rectangleTile(0.8, 0, 0.8, 0.8)}, 0.1);
  picture::Style style;
  style.slitWidth = 0.04;        // 96 to 104
  style.silhouetteWidth = 0.06;  // 14 to 26, and 174 to 186
  const picture::Camera camera = parallelCamera(Vector3(0.8, 0.4, 0), picture::kTopView, 2);
  const picture::Frame frame = paintOnce(sample, {200, 200}, camera, style);
  const picture::Colour face = picture::faceColour(Vector3::UnitZ(), style.brick.top, style);
  for (int x = 10; x < 190; ++x) {
    const bool isLine = (x >= 14 && x < 26) || (x >= 96 && x < 104) || (x >= 174 && x < 186);
    const bool isOutside = x < 14 || x >= 186;
    EXPECT_EQ(frame.at(x, 100), isLine ? style.edge : isOutside ? style.background : face) << x;
  }
}

/// The darkness across a line over the whole picture is its width, for any position of it and any
/// rotation of its face.
TEST(Painter, LinesAreAsWideOnTurnedFaces) {
  SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 1e-4);
  picture::Style style = silhouette();
  style.brick = {{255, 255, 255}, {255, 255, 255}, {255, 255, 255}};
  style.edge = {0, 0, 0};
  style.ambient = 1;
  style.slitWidth = 0.02;
  style.silhouetteWidth = 0.03;  // 6 pixels
  for (const double angle : {0.0, 0.6, 1.2}) {
    sample.poses[0].rotation = rotationFromVector(Vector3(0, angle, 0));
    const picture::Frame frame = paintOnce(
        sample, {200, 200}, parallelCamera(sample.poses[0].position, picture::kTopView, 2), style);
    double dark = 0;
    for (int x = 0; x < 100; ++x) dark += (255 - frame.at(x, 100).red) / 255.0;
    EXPECT_NEAR(dark, 6, 0.05) << angle;  // measured 0.02
  }
}

/// Lines of a video of 1280 pixels, 160 mm wide: 0.5 and 0.75 pt. Flat sheets and others.
TEST(Painter, LinesAreEquallyWideInAllDirections) {
  SampleBricks sample =
      sampleBricks({rectangleTile(0, 0, 0.8, 0.8), rectangleTile(0.8, 0, 0.8, 0.8)}, 0.02);
  picture::Style style = silhouette();
  style.brick = {{255, 255, 255}, {255, 255, 255}, {255, 255, 255}};
  style.edge = {0, 0, 0};
  style.ambient = 1;
  style.slitWidth = 1.411 / 200;
  style.silhouetteWidth = 2.117 / 200;
  const Poses start = sample.poses;
  const Vector3 middle(0.8, 0.4, 0);
  for (const auto smoothness : {picture::Smoothness::Still, picture::Smoothness::Film}) {
    picture::Painter painter({200, 200}, sample.bricks, style, smoothness);
    for (int k = 0; k < 40; ++k) {
      // Upright lines at other places on the pixels, and level ones after a quarter of a turn.
      picture::Camera camera =
          parallelCamera(middle + Vector3(0.00137, 0.00071, 0) * k, picture::kTopView, 2);
      const bool isLevel = k % 2 == 1;
      if (isLevel) camera.up = Vector3::UnitX();
      for (int brick = 0; brick < 2; ++brick) {
        sample.poses[brick].position.z() = start[brick].position.z() - 1e-3 * brick * (k / 20);
      }
      const picture::Frame frame = painter.paint(sample.poses, camera);
      double slit = 0, silhouette = 0;
      for (int j = 0; j < 200; ++j) {
        const double dark = 1 - (isLevel ? frame.at(110, j) : frame.at(j, 110)).red / 255.0;
        (j > 60 && j < 140 ? slit : silhouette) += dark;
      }
      EXPECT_NEAR(slit, 1.411, 0.0625) << k;  // 1/16 pixel; measured 0.04 and 0.054
      EXPECT_NEAR(silhouette / 2, 2.117, 0.0625) << k;
    }
  }
}

TEST(Painter, BlendsTranslucentLinesOnce) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 0.1);
  picture::Style style = silhouette();
  style.brick = picture::withOpacity(style.brick, 0.5);
  style.brick.top = style.brick.bottom = {255, 255, 255, 128};
  style.ambient = 1;
  style.edge = {0, 0, 0};
  style.slitWidth = 0.05;
  style.silhouetteWidth = 0.05;
  const picture::Camera camera = parallelCamera(sample.poses[0].position, picture::kTopView, 2);
  const picture::Frame frame = paintOnce(sample, {200, 200}, camera, style);
  // On the middle of a side, and at a corner where two sides overlap.
  EXPECT_NEAR(frame.at(50, 100).red, 127, 1);
  EXPECT_NEAR(frame.at(50, 50).red, 127, 1);
}

TEST(Painter, LeavesATransparentBackgroundEmpty) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 0.1);
  picture::Style style = silhouette();
  style.background.alpha = 0;
  picture::Camera camera = parallelCamera(sample.poses[0].position, picture::kTopView, 2);
  camera.eye.x() += 0.005;  // half a pixel: the brick's left and right borders split pixels
  camera.centre.x() += 0.005;
  const picture::Frame frame = paintOnce(sample, {200, 200}, camera, style);
  EXPECT_EQ(frame.at(10, 10).alpha, 0);
  EXPECT_EQ(frame.at(100, 100), (picture::Colour{0, 0, 0, 255}));
  EXPECT_EQ(frame.at(49, 100), (picture::Colour{0, 0, 0, 128}));  // brick's colour, half covered
}

TEST(Painter, DrawsTheGroundInItsColourFromAboveOnly) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 0.1);
  picture::Style style;
  style.plate = picture::groundUnder(picture::brickCorners(sample.bricks, sample.poses), 0);
  const Vector3 middle = sample.poses[0].position;
  const picture::Frame above =
      paintOnce(sample, {100, 100}, parallelCamera(middle, picture::kTopView, 3), style);
  EXPECT_EQ(above.at(5, 5), style.ground);
  EXPECT_EQ(above.at(50, 50), picture::faceColour(Vector3::UnitZ(), style.brick.top, style));
  const picture::ViewAngles fromBelow{picture::kTopView.azimuth, -picture::kTopView.elevation};
  const picture::Frame below =
      paintOnce(sample, {100, 100}, parallelCamera(middle, fromBelow, 3), style);
  EXPECT_EQ(below.at(5, 5), style.background);
  EXPECT_EQ(below.at(50, 50), picture::faceColour(Vector3::UnitZ(), style.brick.bottom, style));
}

/// An invisible plate, under the bricks' lowest point.
picture::GroundPlate shadowCatcher(const SampleBricks& sample, double height) {
  picture::GroundPlate plate =
      picture::groundUnder(picture::brickCorners(sample.bricks, sample.poses), height);
  plate.visible = false;
  return plate;
}

TEST(Painter, CastsAShadowOfTheProjectedArea) {
  // A box's shadow on the plane is the sum over lit faces of area * (light . normal) / light.z.
  SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 0.5);
  sample.poses[0].position.z() = 30;  // far up, so the brick does not hide its shadow
  picture::Style style = silhouette();
  style.plate = shadowCatcher(sample, 0);
  style.shadow = {0, 0, 0};
  style.shadowSoftness = 0;
  const Vector3 light = style.shadowSource;
  const Vector3 centre = sample.poses[0].position - 30 / light.z() * light;
  const picture::Frame frame =
      paintOnce(sample, {300, 300}, parallelCamera(centre, picture::kTopView, 5), style);
  const Vector3 faces(0.5, 0.5, 1);
  const double expected = faces.dot(light.cwiseAbs()) / light.z() * std::pow(300 / 5.0, 2);
  EXPECT_NEAR(coveredPixels(frame) / expected, 1, 0.005);  // measured 3e-5
}

// At the distance d beyond the hard edge, t = 1 - d / (s h) for the softness s and the height h,
// and the shadow's share is 3 t^2 - 2 t^3.
TEST(Painter, ShadowsFadeWithTheHeightOfBricks) {
  for (const double height : {5.0, 10.0}) {
    SampleBricks sample = sampleBricks({rectangleTile(0, 0, 2, 2)}, 0.001);
    sample.poses[0].position.z() = height;
    picture::Style style;
    style.slitWidth = 0;
    style.background = {255, 255, 255};
    style.shadow = {0, 0, 0};
    style.plate = shadowCatcher(sample, 0);
    const double slope = style.shadowSource.x() / style.shadowSource.z();
    const Vector3 centre =
        sample.poses[0].position - height / style.shadowSource.z() * style.shadowSource;
    const picture::Frame frame =
        paintOnce(sample, {601, 601}, parallelCamera(centre, picture::kTopView, 6), style);
    const double pixel = 6.0 / 601;
    for (int x = 0; x < 601; ++x) {
      const double distance = std::abs(x - 300) * pixel - 1 - 0.5 * 0.001 * std::abs(slope);
      const double left = std::clamp(1 - distance / (style.shadowSoftness * height), 0.0, 1.0);
      const double share = left * left * (3 - 2 * left);
      const double drawn = 1 - frame.at(x, 300).red / 255.0;
      // Half a step, at the steepest slope of 1.5. Measured 0.072.
      ASSERT_NEAR(drawn, share, 0.076) << height << ' ' << x;
    }
  }
}

TEST(Painter, ShadowsAreCrispWhereBricksTouchThePlate) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 2, 2)}, 0.001);
  picture::Style soft;
  soft.plate = shadowCatcher(sample, -0.0005);
  picture::Style hard = soft;
  hard.shadowSoftness = 0;
  const picture::Camera camera = parallelCamera(Vector3::Zero(), picture::kTopView, 3);
  EXPECT_EQ(paintOnce(sample, {200, 200}, camera, soft).pixels,
            paintOnce(sample, {200, 200}, camera, hard).pixels);
}

TEST(Painter, ShadowsThatOverlapAreAsDarkAsOne) {
  SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1), rectangleTile(0, 0, 1, 1)}, 0.1);
  sample.poses[1].position.z() += 0.3;
  picture::Style style;
  style.background.alpha = 0;
  style.shadow = {0, 0, 0, 60};
  style.plate = shadowCatcher(sample, -4);
  const Vector3 light = style.shadowSource;
  const Vector3 centre = sample.poses[0].position - 4 / light.z() * light;
  const picture::Frame frame =
      paintOnce(sample, {100, 100}, parallelCamera(centre, picture::kTopView, 0.5), style);
  for (int y = 0; y < 100; ++y) ASSERT_EQ(frame.at(50, y), (picture::Colour{0, 0, 0, 60}));
}

/// Two plates with opacities, the first one below the other.
picture::PictureItems stackedPlates(const SampleBricks& sample, double lower, double upper) {
  picture::PictureItems items{sample.poses};
  items.colours = {picture::withOpacity(picture::shadesOf({200, 40, 40}), lower),
                   picture::withOpacity(picture::shadesOf({40, 40, 200}), upper)};
  return items;
}

SampleBricks stackedSample() {
  SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1), rectangleTile(0.2, 0, 1, 1)}, 0.1);
  sample.poses[1].position.z() += 0.5;
  return sample;
}

picture::Style withoutOcclusion() {
  picture::Style style;
  style.occlusion = 0;
  return style;
}

TEST(Painter, TranslucentBricksAreBlendedFromTheFarthestOn) {
  const SampleBricks sample = stackedSample();
  const picture::Style style = withoutOcclusion();
  const picture::Camera camera = parallelCamera(Vector3(0.6, 0.5, 0), picture::kTopView, 2);
  const picture::PictureItems items = stackedPlates(sample, 0.6, 0.4);
  const picture::Frame frame =
      picture::Painter({200, 200}, sample.bricks, style).paint(items, camera);
  const auto over = [](picture::Colour above, Eigen::Array3d below) -> Eigen::Array3d {
    const double alpha = above.alpha / 255.0;
    return alpha * Eigen::Array3d(above.red, above.green, above.blue) + (1 - alpha) * below;
  };
  const auto top = [&](int brick) {
    return picture::faceColour(Vector3::UnitZ(), items.colours[brick].top, style);
  };
  const Eigen::Array3d white(255, 255, 255);
  const auto near = [&](int x, const Eigen::Array3d& expected) {
    const picture::Colour drawn = frame.at(x, 100);
    const Eigen::Array3d difference = Eigen::Array3d(drawn.red, drawn.green, drawn.blue) - expected;
    // Two roundings to bytes. Measured 0.4.
    EXPECT_LE(difference.abs().maxCoeff(), 1.5) << x;
    EXPECT_EQ(drawn.alpha, 255);
  };
  near(48, over(top(0), white));
  near(100, over(top(1), over(top(0), white)));
  near(152, over(top(1), white));
}

TEST(Painter, TranslucentBricksMayComeInAnyOrder) {
  SampleBricks sample = stackedSample();
  // They cross each other.
  sample.poses[0].rotation = rotationFromVector(Vector3(0.8, 0.1, 0));
  sample.poses[1].rotation = rotationFromVector(Vector3(-0.5, 0.3, 0.2));
  sample.poses[1].position.z() -= 0.4;
  picture::PictureItems items = stackedPlates(sample, 0.6, 0.4);
  const picture::Camera camera = parallelCamera(Vector3(0.6, 0.5, 0), picture::kIsometricView, 2);
  const picture::Frame one =
      picture::Painter({200, 200}, sample.bricks, picture::Style()).paint(items, camera);
  std::swap(sample.bricks[0], sample.bricks[1]);
  std::swap(items.poses[0], items.poses[1]);
  std::swap(items.colours[0], items.colours[1]);
  const picture::Frame other =
      picture::Painter({200, 200}, sample.bricks, picture::Style()).paint(items, camera);
  int differ = 0;
  for (std::size_t k = 0; k < one.pixels.size(); ++k) {
    differ += std::abs(one.pixels[k] - other.pixels[k]) > 2 ? 1 : 0;
  }
  EXPECT_LE(differ, 0);  // measured 0
}

TEST(Painter, BricksOfOpacityZeroAreInvisible) {
  const SampleBricks sample = stackedSample();
  picture::Style style;
  style.plate = shadowCatcher(sample, -1);
  const picture::Camera camera = parallelCamera(Vector3(0.6, 0.5, 0), picture::kIsometricView, 3);
  const picture::Frame frame =
      picture::Painter({200, 200}, sample.bricks, style).paint(stackedPlates(sample, 1, 0), camera);
  picture::PictureItems single{{sample.poses[0]}};
  single.colours = {picture::shadesOf({200, 40, 40})};
  EXPECT_EQ(frame.pixels,
            picture::Painter({200, 200}, {sample.bricks[0]}, style).paint(single, camera).pixels);
}

TEST(Painter, TranslucentBricksOnATransparentPageKeepTheirOpacity) {
  const SampleBricks sample = stackedSample();
  picture::Style style = withoutOcclusion();
  style.background.alpha = 0;
  const picture::Camera camera = parallelCamera(Vector3(0.6, 0.5, 0), picture::kTopView, 2);
  const picture::Frame frame = picture::Painter({200, 200}, sample.bricks, style)
                                   .paint(stackedPlates(sample, 0.6, 0.4), camera);
  EXPECT_EQ(frame.at(48, 100).alpha, 153);
  EXPECT_NEAR(frame.at(100, 100).alpha, 255 * (1 - 0.4 * 0.6), 1);
  EXPECT_EQ(frame.at(152, 100).alpha, 102);
  EXPECT_EQ(frame.at(2, 2).alpha, 0);
}

TEST(Painter, DrawsPinnedBricksInTheirColour) {
  const SampleBricks sample =
      sampleBricks({rectangleTile(0, 0, 1, 1), rectangleTile(1, 0, 1, 1)}, 0.1);
  const picture::Style style;
  picture::PictureItems items{sample.poses};
  items.pinned = {1};
  const picture::Camera camera = parallelCamera(Vector3(1, 0.5, 0), picture::kTopView, 2.5);
  const picture::Frame frame =
      picture::Painter({100, 100}, sample.bricks, style).paint(items, camera);
  EXPECT_EQ(frame.at(30, 50), picture::faceColour(Vector3::UnitZ(), style.brick.top, style));
  EXPECT_EQ(frame.at(70, 50), picture::faceColour(Vector3::UnitZ(), style.pinned.top, style));
}

TEST(Painter, DrawsEachBrickInItsOwnColours) {
  const SampleBricks sample =
      sampleBricks({rectangleTile(0, 0, 1, 1), rectangleTile(1, 0, 1, 1)}, 0.1);
  picture::PictureItems items{sample.poses};
  items.colours = {picture::shadesOf({10, 200, 30}), picture::shadesOf({200, 10, 30})};
  const picture::Camera camera = parallelCamera(Vector3(1, 0.5, 0), picture::kTopView, 2.5);
  const picture::Frame frame = picture::Painter({100, 100}, sample.bricks, {}).paint(items, camera);
  EXPECT_EQ(frame.at(30, 50), picture::faceColour(Vector3::UnitZ(), {10, 200, 30}, {}));
  EXPECT_EQ(frame.at(70, 50), picture::faceColour(Vector3::UnitZ(), {200, 10, 30}, {}));
}

TEST(Painter, DashesLinesWhereBricksHideThem) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 2, 2)}, 1);
  picture::Style style;
  style.overlayWidth = 0.1;
  picture::PictureItems items{sample.poses};
  items.overlay = {rectangleTile(0.5, 0.5, 1, 1)};  // on the brick's far side
  const picture::Camera camera = parallelCamera(Vector3(1, 1, 0), picture::kTopView, 2);
  const picture::Colour face = picture::faceColour(Vector3::UnitZ(), style.brick.top, style);
  const picture::Frame hidden =
      picture::Painter({100, 100}, sample.bricks, style).paint(items, camera);
  EXPECT_EQ(hidden.at(25, 30), style.overlay);
  EXPECT_EQ(hidden.at(25, 50), face);           // between two dashes
  EXPECT_EQ(hidden.at(21, 21), style.overlay);  // the corner is closed
  EXPECT_EQ(hidden.at(50, 50), face);
  for (Vector3& corner : items.overlay[0].vertices) corner.z() = 1;  // on its near side
  const picture::Frame seen =
      picture::Painter({100, 100}, sample.bricks, style).paint(items, camera);
  EXPECT_EQ(seen.at(25, 50), style.overlay);
  EXPECT_EQ(seen.at(21, 21), style.overlay);
  EXPECT_EQ(seen.at(50, 50), face);
}

/// A trail of many points half way up a thick brick, and beyond it. 200 pixels are 1 m, the line is
/// 0.04 m wide, and dashes of 0.12 m begin every 0.24 m, for any number of points.
TEST(Painter, DashesTrailsWhereBricksHideThem) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 1);
  picture::Style style;
  style.overlayWidth = 0.02;
  const picture::Camera camera = parallelCamera(Vector3(1, 0.5, 0), picture::kTopView, 2);
  for (const int points : {1, 7, 80}) {
    picture::PictureItems items{sample.poses};
    items.trails.emplace_back();
    for (int k = 0; k <= points; ++k) items.trails[0].emplace_back(1.9 * k / points, 0.5, 0.5);
    const picture::Frame frame =
        picture::Painter({400, 400}, sample.bricks, style).paint(items, camera);
    int wrong = 0;
    for (int column = 6; column < 375; ++column) {
      const double x = (column + 0.5) / 200, dash = std::fmod(x, 0.24);
      // Pixels at the ends of dashes and at the brick's edge are mixed.
      if (std::abs(x - 1) < 0.02 || std::min(dash, std::abs(dash - 0.12)) < 0.01) continue;
      const bool isLine = frame.at(column, 200) == style.overlay;
      wrong += isLine == (x > 1 || dash < 0.12) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0) << points;
  }
}

TEST(Painter, MarksPointsByWholeDots) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 2, 2)}, 0.2);
  picture::Style style;
  style.slitWidth = 0;
  style.markSize = 0.2;
  picture::PictureItems items{sample.poses};
  items.marks = {Vector3(2, 2, 0.2)};
  const picture::Camera camera = parallelCamera(Vector3(1, 1, 0), picture::kIsometricView, 6);
  picture::Painter painter({300, 300}, sample.bricks, style);
  const picture::Frame frame = painter.paint(items, camera);
  double dot = 0;
  for (std::size_t k = 0; k < frame.pixels.size(); k += 4) {
    dot += frame.pixels[k] == style.mark.red && frame.pixels[k + 1] == style.mark.green;
  }
  // A polygon of 16 sides of radius 30, less its border pixels.
  EXPECT_NEAR(dot / (8 * 900 * std::sin(M_PI / 8)), 1, 0.06);  // measured 0.025
}

/// Darkness of a row of outlines, which should not depend on their position on the pixels.
TEST(Painter, OutlinesDoNotFlickerWhenTheyMove) {
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 1)}, 0.02);
  picture::Style style = silhouette();
  style.brick = {{255, 255, 255}, {255, 255, 255}, {255, 255, 255}};
  style.edge = {0, 0, 0};
  style.ambient = 1;
  style.slitWidth = style.silhouetteWidth = 0.01;  // two pixels of 200
  picture::Painter painter({200, 200}, sample.bricks, style);
  double least = 1e9, most = 0;
  for (int k = 0; k < 40; ++k) {
    const Vector3 centre = sample.poses[0].position + Vector3(0.00137, 0.00071, 0) * k;
    const double dark =
        coveredPixels(painter.paint(sample.poses, parallelCamera(centre, picture::kTopView, 2)));
    least = std::min(least, dark);
    most = std::max(most, dark);
  }
  EXPECT_LT(most / least, 1.02);  // measured 1.002
}

TEST(Painter, TurningBricksAndCameraTogetherKeepsTheOutline) {
  // Metamorphic: a quarter turn of everything about the view's axis turns the picture.
  const SampleBricks sample = sampleBricks({rectangleTile(0, 0, 1, 0.6)}, 0.2);
  const Vector3 middle = sample.poses[0].position;
  const picture::Frame upright =
      paintOnce(sample, {150, 150}, parallelCamera(middle, picture::kTopView, 2), silhouette());
  SampleBricks turned = sample;
  turned.poses[0].rotation = rotationFromVector(Vector3(0, 0, M_PI / 2));
  picture::Camera camera = parallelCamera(middle, picture::kTopView, 2);
  camera.up = -Vector3::UnitX();
  EXPECT_EQ(upright.pixels, paintOnce(turned, {150, 150}, camera, silhouette()).pixels);
}

TEST(Painter, PaintsTheSameBytesAgain) {
  const SampleBricks sample = tumbledBricks();
  const picture::FrameSize size{320, 200};
  const picture::Camera camera = fittedCamera(sample, size, picture::kIsometricView);
  picture::Painter painter(size, sample.bricks, {});
  const picture::Frame first = painter.paint(sample.poses, camera);
  SampleBricks moved = sample;
  for (Pose& pose : moved.poses) pose.position *= 1.5;
  EXPECT_NE(painter.paint(moved.poses, camera).pixels, first.pixels);
  EXPECT_EQ(painter.paint(sample.poses, camera).pixels, first.pixels);
  EXPECT_EQ(paintOnce(sample, size, camera, {}).pixels, first.pixels);
}

TEST(Painter, ShowsOtherBricksLikeANewPainter) {
  const SampleBricks sample = tumbledBricks();
  const picture::FrameSize size{160, 100};
  const picture::Camera camera = fittedCamera(sample, size, picture::kIsometricView);
  picture::Style glass;
  glass.background = {10, 20, 30, 0};
  const SampleBricks other = sampleBricks({rectangleTile(0, 0, 3, 2)}, 0.4);
  picture::Painter painter(size, other.bricks, silhouette());
  painter.paint(other.poses, camera);
  for (const picture::Style& style : {picture::Style(), glass, silhouette()}) {
    painter.show(sample.bricks, style);
    EXPECT_EQ(painter.paint(sample.poses, camera).pixels,
              paintOnce(sample, size, camera, style).pixels);
  }
}

TEST(Painter, SharesAThreadWithAnother) {
  const SampleBricks sample = tumbledBricks();
  const picture::FrameSize size{160, 100};
  const picture::Camera camera = fittedCamera(sample, size, picture::kIsometricView);
  picture::Painter first(size, sample.bricks, {});
  auto second =
      std::make_unique<picture::Painter>(picture::FrameSize{80, 50}, sample.bricks, silhouette());
  const picture::Frame frame = first.paint(sample.poses, camera);
  second->paint(sample.poses, camera);
  EXPECT_EQ(first.paint(sample.poses, camera).pixels, frame.pixels);
  second.reset();
  EXPECT_EQ(first.paint(sample.poses, camera).pixels, frame.pixels);
}

/// The output of picture_hash in these environments. Only regions with bricks are drawn and read. A
/// plate with the colour of the background extends them to the whole picture.
TEST(Painter, LeavesOutNothingThatBricksTouch) {
  const SampleBricks sample = tumbledBricks();
  picture::Style bare;
  picture::Style covered;
  covered.ground = covered.background;
  covered.plate = picture::groundUnder(picture::brickCorners(sample.bricks, sample.poses), -10);
  covered.plate->shadow = false;
  picture::Painter painter({331, 217}, sample.bricks, bare);
  for (const double height : {2.0, 5.0, 30.0, 2.0}) {
    picture::Camera camera = fittedCamera(sample, {331, 217}, picture::kIsometricView);
    camera.orthographic = true;
    camera.viewHeight = height;
    painter.show(sample.bricks, bare);
    const picture::Frame tight = painter.paint(sample.poses, camera);
    painter.show(sample.bricks, covered);
    const picture::Frame whole = painter.paint(sample.poses, camera);
    int different = 0;
    for (std::size_t k = 0; k < tight.pixels.size(); ++k) {
      different += std::abs(tight.pixels[k] - whole.pixels[k]) > 2 ? 1 : 0;
    }
    // Rounding of positions within a part moves few samples.
    EXPECT_LT(different, 60) << height;
  }
}

/// A frame of any size can be reused for another one.
TEST(Painter, PaintsTheSameIntoMemoryThatWasUsed) {
  const SampleBricks sample = tumbledBricks();
  const picture::Camera camera = fittedCamera(sample, {120, 80}, picture::kIsometricView);
  picture::Painter painter({120, 80}, sample.bricks, {});
  const picture::Frame fresh =
      painter.paint(picture::PictureItems{sample.poses, {}, {}, {}, {}, {}}, camera);
  for (const picture::FrameSize size : {picture::FrameSize{8, 8}, picture::FrameSize{400, 300}}) {
    const picture::Frame again =
        painter.paint(picture::PictureItems{sample.poses, {}, {}, {}, {}, {}}, camera,
                      picture::makeFrame(size, {1, 2, 3, 4}));
    EXPECT_EQ(again.pixels, fresh.pixels);
  }
}

std::string hashUnder(const std::string& environment, const std::string& library = "") {
  return test::outputOf("env " + environment + " '" PICTURE_HASH_PROGRAM "' " + library);
}

TEST(Painter, PaintsTheSameBytesWithAnyNumberOfThreads) {
  const std::string hash = hashUnder("LP_NUM_THREADS=0");
  ASSERT_EQ(hash.size(), 17U);  // 16 digits and the line's end
  EXPECT_EQ(hashUnder("LP_NUM_THREADS=0"), hash);
  EXPECT_EQ(hashUnder("LP_NUM_THREADS=2"), hash);
  EXPECT_EQ(hashUnder("LP_NATIVE_VECTOR_WIDTH=128"), hash);
}

TEST(Painter, PaintsTheSameBytesThroughEgl) {
  const std::string egl = hashUnder("LP_NUM_THREADS=0", "egl");
  if (egl.empty()) GTEST_SKIP() << "built without EGL, or EGL has no display without a screen";
  EXPECT_EQ(egl, hashUnder("LP_NUM_THREADS=0"));
  EXPECT_EQ(hashUnder("LP_NUM_THREADS=2", "egl"), egl);
}

TEST(Painter, RefusesAnEmptyPicture) {
  EXPECT_THROW(picture::Painter({0, 100}, {}, {}), InputError);
  EXPECT_THROW(picture::Painter({100, 20000}, {}, {}), InputError);
}

TEST(Painter, PaintsBackgroundWithoutBricks) {
  const picture::Frame frame = picture::Painter({8, 8}, {}, {}).paint(Poses{}, {});
  EXPECT_EQ(frame.pixels, picture::makeFrame({8, 8}, {255, 255, 255}).pixels);
}

}  // namespace
}  // namespace kirireel
