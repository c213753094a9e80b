#include <cmath>

#include <gtest/gtest.h>

#include "render/picture/camera.h"
#include "sim/base/error.h"
#include "tests/render/picture/sample_bricks.h"

namespace kirireel {
namespace {

constexpr double kDegree = M_PI / 180;

std::vector<Vector3> tumbledCorners() {
  const SampleBricks sample = tumbledBricks();
  return picture::brickCorners(sample.bricks, sample.poses);
}

/// The largest |x| or |y| of the points in the picture, where 1 is the border.
double reach(const picture::Camera& camera, const std::vector<Vector3>& points, double aspect) {
  const Eigen::Matrix4d clip = picture::clipFromWorld(camera, aspect);
  double largest = 0;
  for (const Vector3& point : points) {
    const Eigen::Vector4d seen = clip * point.homogeneous();
    largest = std::max(largest, (seen.head<2>() / seen.w()).cwiseAbs().maxCoeff());
  }
  return largest;
}

TEST(CameraPath, IsFixedByDefault) {
  const std::vector<Vector3> points = tumbledCorners();
  const picture::CameraPath path({}, points, 1.5);
  EXPECT_TRUE(path.isStill());
  EXPECT_EQ(path.at(0, 0).eye, path.at(3, 1).eye);
  picture::CameraFit fit;
  fit.aspect = 1.5;
  EXPECT_EQ(path.at(0, 0).eye, picture::fitCamera(points, fit).eye);
}

TEST(CameraPath, TurnsAboutTheVerticalInOrbit) {
  const std::vector<Vector3> points = tumbledCorners();
  picture::CameraChoice choice;
  choice.view = picture::kIsometricView;
  choice.orbit = 90 * kDegree;
  const picture::CameraPath path(choice, points, 1.5);
  const picture::Camera start = path.at(0, 0), end = path.at(0, 1);
  const Vector3 turned =
      Eigen::AngleAxisd(M_PI / 2, Vector3::UnitZ()) * Vector3(start.eye - start.centre);
  EXPECT_LT((end.eye - end.centre - turned).norm(), 1e-12 * turned.norm());  // measured 4e-16
  EXPECT_EQ(path.at(0, 2).eye, end.eye);
}

TEST(CameraPath, KeepsAllPointsInThePictureFromEverySide) {
  const std::vector<Vector3> points = tumbledCorners();
  for (const bool orthographic : {false, true}) {
    for (const double aspect : {0.6, 1.0, 1.8}) {
      picture::CameraChoice choice;
      choice.orbit = 2 * M_PI;
      choice.orthographic = orthographic;
      const picture::CameraPath path(choice, points, aspect);
      for (double turn = 0; turn < 1; turn += 0.05) {
        EXPECT_LE(reach(path.at(0, turn), points, aspect), 1 - 2 * choice.margin + 1e-9);
      }
    }
  }
}

TEST(CameraPath, PassesThroughItsKeys) {
  picture::CameraChoice choice;
  choice.keys = {{0, {0.1, 0.2}, 1}, {2, {1.5, 0.9}, 2}, {3, {-0.5, -0.3}, 0.5}};
  const picture::CameraPath path(choice, tumbledCorners(), 1.5);
  for (const picture::CameraKey& key : choice.keys) {
    const picture::Camera camera = path.at(key.time, 0);
    const Vector3 back = (camera.eye - camera.centre).normalized();
    EXPECT_NEAR(std::atan2(back.y(), back.x()), key.view.azimuth, 1e-12);  // measured 2e-16
    EXPECT_NEAR(std::asin(back.z()), key.view.elevation, 1e-12);
    EXPECT_NEAR(
        std::tan(0.5 * picture::CameraFit().fieldOfView) / std::tan(0.5 * camera.fieldOfView),
        key.zoom, 1e-12);
  }
}

TEST(CameraPath, MovesWithoutJumps) {
  picture::CameraChoice choice;
  choice.keys = {{0, {0, 0.2}, 1}, {1, {2, 0.9}, 2}, {3, {2.5, -0.3}, 1}};
  const picture::CameraPath path(choice, tumbledCorners(), 1.5);
  const double step = 1e-3;
  const auto speed = [&](double time) -> Vector3 {
    return (path.at(time + step, 0).eye - path.at(time, 0).eye) / step;
  };
  for (double time = 0; time < 3; time += step) {
    // The speed is at most 30 m/s here; a kink would change it at once by more than this.
    EXPECT_LT((speed(time + step) - speed(time)).norm(), 0.6) << time;  // measured 0.21
  }
}

TEST(CameraPath, ZoomEnlargesTheMiddle) {
  const std::vector<Vector3> points = tumbledCorners();
  for (const bool orthographic : {false, true}) {
    picture::CameraChoice choice;
    choice.orthographic = orthographic;
    const double before =
        picture::heightAtCentre(picture::CameraPath(choice, points, 1.5).at(0, 0));
    choice.zoom = 3;
    EXPECT_NEAR(before / picture::heightAtCentre(picture::CameraPath(choice, points, 1.5).at(0, 0)),
                3, 1e-12);
  }
}

TEST(CameraPath, HasTheRequestedDistance) {
  picture::CameraChoice choice;
  choice.distance = 7.5;
  const picture::Camera camera = picture::CameraPath(choice, tumbledCorners(), 1.5).at(0, 0);
  EXPECT_NEAR((camera.eye - camera.centre).norm(), 7.5, 1e-12);
}

TEST(CameraPath, HasTheAnglesOfPyBulletsCamera) {
  EXPECT_EQ(picture::viewFromYawPitch(0, 0), picture::kFrontView);
  EXPECT_EQ(picture::viewFromYawPitch(0, -90 * kDegree), picture::kTopView);
  // Yaw 50 and pitch -35, PyBullet's first view: the eye is to the right and in front, above.
  const picture::ViewAngles view = picture::viewFromYawPitch(50 * kDegree, -35 * kDegree);
  EXPECT_NEAR(view.azimuth, -40 * kDegree, 1e-12);
  EXPECT_NEAR(view.elevation, 35 * kDegree, 1e-12);
}

TEST(CameraPath, RefusesKeysOutOfOrder) {
  picture::CameraChoice choice;
  choice.keys = {{1, {}, 1}, {0.5, {}, 1}};
  try {
    picture::CameraPath(choice, tumbledCorners(), 1.5);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "error: the camera's key at 0.5 s does not come after the one at 1 s; give the "
                 "keys in the order of their times");
  }
}

TEST(BrickAround, FindsTheBrickThatHoldsAPoint) {
  const SampleBricks sample = tumbledBricks();
  for (int k = 0; k < 12; ++k) {
    EXPECT_EQ(picture::brickAround(sample.bricks, sample.poses, sample.poses[k].position), k);
  }
  EXPECT_EQ(picture::brickAround(sample.bricks, sample.poses, Vector3(0, 0, 9)), std::nullopt);
}

}  // namespace
}  // namespace kirireel
