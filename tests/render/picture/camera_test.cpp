#include "render/picture/camera.h"

#include <random>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/render/picture/sample_bricks.h"

namespace kirireel {
namespace {

std::vector<Vector3> randomPoints(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-1, 1);
  std::vector<Vector3> points;
  for (int k = 0; k < 50; ++k) {
    points.emplace_back(30 + 3 * coordinate(random), 2 * coordinate(random), coordinate(random));
  }
  return points;
}

/// Positions of points in the picture: -1 to 1 from border to border.
struct Footprint {
  Eigen::AlignedBox3d box;

  Footprint(const std::vector<Vector3>& points, const picture::Camera& camera, double aspect) {
    const Eigen::Matrix4d matrix = picture::clipFromWorld(camera, aspect);
    for (const Vector3& point : points) {
      const Eigen::Vector4d clip = matrix * point.homogeneous();
      box.extend(clip.head<3>() / clip.w());
    }
  }
};

TEST(FitCamera, FillsThePictureUpToItsMargin) {
  for (const bool orthographic : {false, true}) {
    for (const picture::ViewAngles view :
         {picture::kTopView, picture::kFrontView, picture::kIsometricView, picture::kObliqueView}) {
      for (const double aspect : {0.5, 1.0, 16.0 / 9.0}) {
        picture::CameraFit fit{view, aspect, orthographic};
        fit.margin = 0.1;
        const std::vector<Vector3> points = randomPoints(7);
        const Footprint seen(points, picture::fitCamera(points, fit), aspect);
        const double widest = std::max(seen.box.max().x(), seen.box.max().y());
        // Measured to 3e-15: one direction fills the picture, and both are centred.
        EXPECT_NEAR(widest, 1 - 2 * fit.margin, 1e-12);
        EXPECT_LE(seen.box.max().head<2>().maxCoeff(), 0.8 + 1e-12);
        EXPECT_GE(seen.box.min().head<2>().minCoeff(), -0.8 - 1e-12);
        EXPECT_GT(seen.box.min().z(), -1);
        EXPECT_LT(seen.box.max().z(), 1);
      }
    }
  }
}

TEST(FitCamera, CentresTheModelWhenParallel) {
  const std::vector<Vector3> points = randomPoints(11);
  picture::CameraFit fit;
  fit.orthographic = true;
  const Footprint seen(points, picture::fitCamera(points, fit), fit.aspect);
  EXPECT_NEAR(seen.box.center().head<2>().norm(), 0, 1e-12);  // measured 1e-15
}

TEST(FitCamera, MovesWithTheModel) {
  const std::vector<Vector3> points = randomPoints(3);
  const Vector3 shift(5, -7, 11);
  std::vector<Vector3> moved;
  for (const Vector3& point : points) moved.push_back(point + shift);
  const picture::Camera here = picture::fitCamera(points, {});
  const picture::Camera there = picture::fitCamera(moved, {});
  EXPECT_NEAR((there.eye - here.eye - shift).norm(), 0, 1e-11);  // measured 8e-15
  EXPECT_NEAR((there.centre - here.centre - shift).norm(), 0, 1e-11);
}

TEST(FitCamera, LooksAtASinglePoint) {
  const std::vector<Vector3> point = {Vector3(1, 2, 3)};
  for (const bool orthographic : {false, true}) {
    picture::CameraFit fit;
    fit.orthographic = orthographic;
    const picture::Camera camera = picture::fitCamera(point, fit);
    EXPECT_NEAR((camera.centre - point[0]).norm(), 0, 1e-12);
    EXPECT_GT((camera.eye - camera.centre).norm(), camera.near);
  }
}

TEST(FitCamera, RefusesNoPoints) {
  try {
    picture::fitCamera({}, {});
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "error: the camera has no points to frame; give it bricks");
  }
}

TEST(Views, HaveTheAxesOfTheirNames) {
  const std::vector<Vector3> cube = {Vector3(-1, -1, -1), Vector3(1, 1, 1)};
  const auto ndc = [&](picture::ViewAngles view, const Vector3& point) {
    picture::CameraFit fit{view, 1, true};
    const Eigen::Vector4d clip =
        picture::clipFromWorld(picture::fitCamera(cube, fit), 1) * point.homogeneous();
    return Eigen::Vector2d(clip.x(), clip.y());
  };
  EXPECT_GT(ndc(picture::kTopView, Vector3::UnitX()).x(), 0.1);
  EXPECT_GT(ndc(picture::kTopView, Vector3::UnitY()).y(), 0.1);
  EXPECT_GT(ndc(picture::kFrontView, Vector3::UnitX()).x(), 0.1);
  EXPECT_GT(ndc(picture::kFrontView, Vector3::UnitZ()).y(), 0.1);
  // Isometric: the three axes look equally long.
  const double x = ndc(picture::kIsometricView, Vector3::UnitX()).norm();
  EXPECT_NEAR(ndc(picture::kIsometricView, Vector3::UnitY()).norm(), x, 1e-12);  // measured 1e-16
  EXPECT_NEAR(ndc(picture::kIsometricView, Vector3::UnitZ()).norm(), x, 1e-12);
}

TEST(DefaultView, TiltsOnlyFlatModels) {
  std::vector<Vector3> points = {Vector3(0, 0, 0), Vector3(4, 3, 0.1)};
  EXPECT_EQ(picture::defaultView(points), picture::kTopView);
  points.emplace_back(1, 1, 2);
  EXPECT_EQ(picture::defaultView(points), picture::kIsometricView);
}

TEST(BrickCorners, AreBottomAndTopOfEveryBrick) {
  const SampleBricks sample = sampleBricks({rectangleTile(1, 2, 3, 4)}, 0.5);
  const std::vector<Vector3> corners = picture::brickCorners(sample.bricks, sample.poses);
  ASSERT_EQ(corners.size(), 8U);
  EXPECT_NEAR((corners[0] - Vector3(1, 2, 0)).norm(), 0, 1e-12);
  EXPECT_NEAR((corners[6] - Vector3(4, 6, 0.5)).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace kirireel
