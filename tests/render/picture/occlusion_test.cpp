#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "render/picture/picture_geometry.h"
#include "tests/render/picture/sample_bricks.h"

namespace kirireel::test {
namespace {

using Corners = std::vector<Vector3>;

/// The faces of a box between two corners: bottom, top, sides.
std::vector<Corners> box(const Vector3& least, const Vector3& most) {
  brick::BrickRule rule;
  rule.thickness = most.z() - least.z();
  const model::Tile tile{{least,
                          {most.x(), least.y(), least.z()},
                          {most.x(), most.y(), least.z()},
                          {least.x(), most.y(), least.z()}}};
  const std::vector<brick::Brick> bricks = brick::makeBricks({tile}, rule);
  const Poses poses = brick::startPoses({tile}, bricks);
  std::vector<Corners> faces = brick::brickFaces(bricks[0]);
  for (Corners& face : faces) {
    for (Vector3& corner : face) corner = poses[0].apply(corner);
  }
  return faces;
}

/// A face that faces up and is so small that all its points have the same view.
std::vector<Corners> speck() {
  return box({-1e-6, -1e-6, -1e-6}, {1e-6, 1e-6, 0});
}

double speckOcclusion(const std::vector<std::vector<Corners>>& others) {
  std::vector<std::vector<Corners>> faces = {speck()};
  faces.insert(faces.end(), others.begin(), others.end());
  return picture::Occluders(faces).occlusion(0, faces[0][1], Vector3::UnitZ());
}

/// Form factor from a point to a parallel rectangle a x b at distance c, one of whose corners is on
/// the point's normal (Howell, Siegel and Menguec, configuration B-3).
double cornerFactor(double a, double b, double c) {
  const double x = a / c, y = b / c;
  const double sx = std::sqrt(1 + x * x), sy = std::sqrt(1 + y * y);
  return (x / sx * std::atan(y / sx) + y / sy * std::atan(x / sy)) / (2 * std::numbers::pi);
}

TEST(Occluders, BlockTheFormFactorOfARectangle) {
  // 9e-13: the four points of the small face.
  EXPECT_NEAR(speckOcclusion({box({-2, -1, 0.5}, {2, 1, 0.6})}), 4 * cornerFactor(2, 1, 0.5), 1e-9);
}

// A wall on the point's plane blocks half of the light that its whole outline would block.
TEST(Occluders, AreCutAtTheHorizon) {
  const double whole = speckOcclusion({box({0.1, -1, 0}, {0.2, 1, 1})});
  const double below = speckOcclusion({box({0.1, -1, -1}, {0.2, 1, 1})});
  EXPECT_GT(whole, 0.1);
  EXPECT_NEAR(below, whole, 1e-12);
}

TEST(Occluders, AddUpAsIfIndependent) {
  const double left = speckOcclusion({box({-0.2, -1, 0}, {-0.1, 1, 1})});
  const double both =
      speckOcclusion({box({-0.2, -1, 0}, {-0.1, 1, 1}), box({0.1, -1, 0}, {0.2, 1, 1})});
  EXPECT_NEAR(both, 1 - (1 - left) * (1 - left), 1e-12);
}

TEST(Occluders, LeaveAFlatSheetOpen) {
  std::vector<std::vector<Corners>> faces;
  for (int k = 0; k < 9; ++k) {
    faces.push_back(box({k % 3 * 1.1, k / 3 * 1.1, 0}, {k % 3 * 1.1 + 1, k / 3 * 1.1 + 1, 0.1}));
  }
  const picture::Occluders occluders(faces);
  for (int k = 0; k < 9; ++k) {
    EXPECT_EQ(occluders.occlusion(k, faces[k][1], Vector3::UnitZ()), 0);
  }
  // A side next to a gap as wide as its height is dark, a side at the border is not.
  EXPECT_GT(occluders.occlusion(4, faces[4][2], -Vector3::UnitY()), 0.3);
  EXPECT_EQ(occluders.occlusion(0, faces[0][2], -Vector3::UnitY()), 0);
}

TEST(Occluders, DoNotDependOnTheAxes) {
  const SampleBricks sample = tumbledBricks();
  const Pose moved{Vector3(3, -2, 1), rotationFromVector(Vector3(0.4, -1.1, 0.7))};
  std::vector<std::vector<Corners>> faces, turned;
  for (std::size_t k = 0; k < sample.bricks.size(); ++k) {
    faces.push_back(brick::brickFaces(sample.bricks[k]));
    turned.push_back(faces.back());
    for (std::size_t i = 0; i < faces.back().size(); ++i) {
      for (std::size_t j = 0; j < faces.back()[i].size(); ++j) {
        // Close together, so they block each other's light.
        Pose near = sample.poses[k];
        near.position *= 0.5;
        faces.back()[i][j] = near.apply(faces.back()[i][j]);
        turned.back()[i][j] = moved.apply(faces.back()[i][j]);
      }
    }
  }
  const picture::Occluders before(faces), after(turned);
  double most = 0;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const auto normalOf = [](const Corners& face) -> Vector3 {
      return (face[1] - face[0]).cross(face[2] - face[1]).normalized();
    };
    const int brick = static_cast<int>(k);
    const double here = before.occlusion(brick, faces[k][1], normalOf(faces[k][1]));
    EXPECT_NEAR(after.occlusion(brick, turned[k][1], normalOf(turned[k][1])), here, 1e-12);
    most = std::max(most, here);
  }
  EXPECT_GT(most, 0.1);
}

}  // namespace
}  // namespace kirireel::test
