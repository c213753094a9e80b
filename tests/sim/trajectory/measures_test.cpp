#include "sim/trajectory/measures.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

struct Sheet {
  model::Model model = generate::makeTessellation({});
  std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  std::vector<brick::Pivot> pivots = brick::makePivots(model.joints, bricks);
  Poses poses = brick::startPoses(model.tiles, bricks);
};

TEST(JointGap, ClosedSheetHasNone) {
  const Sheet sheet;
  EXPECT_LT(trajectory::jointGap(sheet.pivots, sheet.poses).max, 1e-14);  // measured 0
}

TEST(JointGap, OneMovedBrickOpensItsJoints) {
  Sheet sheet;
  sheet.poses[0].position += Vector3(0.03, 0, 0.04);
  const trajectory::JointGap gap = trajectory::jointGap(sheet.pivots, sheet.poses);
  EXPECT_NEAR(gap.max, 0.05, 1e-15);
  // A corner tile has two joints on both faces: four pivots of 48.
  EXPECT_NEAR(gap.mean, 4 * 0.05 / 48, 1e-15);
}

TEST(JointGap, ZeroWithoutJoints) {
  EXPECT_EQ(trajectory::jointGap({}, {}).max, 0);
  EXPECT_EQ(trajectory::jointGap({}, {}).mean, 0);
}

TEST(JointGap, PosesThatAreNoNumbersAreNoSmallGap) {
  Sheet sheet;
  sheet.poses[0].position.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(trajectory::jointGap(sheet.pivots, sheet.poses).max));
  EXPECT_TRUE(std::isnan(trajectory::targetError(sheet.model.tiles, sheet.bricks, sheet.poses)));
}

TEST(TargetError, IsTheLargestVertexDistance) {
  Sheet sheet;
  EXPECT_LT(trajectory::targetError(sheet.model.tiles, sheet.bricks, sheet.poses), 1e-14);
  // A unit square turned by 60 degrees about its middle: each corner moves by sqrt(1/2).
  const double half = 0.5 * sheet.bricks[5].thickness;
  sheet.poses[5].rotation = rotationFromVector({0, 0, 1.0471975511965976});
  EXPECT_NEAR(trajectory::targetError(sheet.model.tiles, sheet.bricks, sheet.poses), std::sqrt(0.5),
              1e-14);
  sheet.poses[5] = {{0, 0, half}, Quaternion::Identity()};
  sheet.poses[5].position = sheet.poses[5].position + Vector3(-0.5, -0.5, 2);
  EXPECT_NEAR(trajectory::targetError(sheet.model.tiles, sheet.bricks, sheet.poses), 2, 1e-14);
}

TEST(RigidBound, IsZeroForMovedTiles) {
  const Sheet sheet;
  EXPECT_LT(trajectory::rigidBound(sheet.model.tiles, *sheet.model.target),
            1e-14);  // measured 5e-16
}

TEST(RigidBound, OfAStretchedTileIsHalfTheStretch) {
  const std::vector<model::Tile> square{{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}};
  const std::vector<model::Tile> longer{{{{3, 0, 0}, {3, 1.2, 0}, {2, 1.2, 0}, {2, 0, 0}}}};
  EXPECT_NEAR(trajectory::rigidBound(square, longer), 0.1, 1e-15);
}

/// The smallest maximum residual over plane motions, by search: rotations in steps that are refined
/// about the best one; for each rotation the smallest circle around the vertices' misfits.
class PlaneSearch {
 public:
  PlaneSearch(const model::Tile& tile, const model::Tile& target) : tile_(tile), target_(target) {}

  double least() const {
    double best = 0;
    double width = 3.2;
    double error = std::numeric_limits<double>::infinity();
    for (int round = 0; round < 12; ++round) {
      const double middle = best;
      for (int i = -100; i <= 100; ++i) {
        const double angle = middle + width * i / 100;
        const double found = circleRound(misfits(angle));
        if (found >= error) continue;
        error = found;
        best = angle;
      }
      width /= 20;
    }
    return error;
  }

 private:
  std::vector<Vector3> misfits(double angle) const {
    const Matrix3 turn = rotationFromVector({0, 0, angle}).toRotationMatrix();
    std::vector<Vector3> gaps;
    for (std::size_t k = 0; k < tile_.vertices.size(); ++k) {
      gaps.push_back(target_.vertices[k] - turn * tile_.vertices[k]);
    }
    return gaps;
  }

  /// The radius of the smallest circle: of those through two or three points, the smallest that
  /// contains all.
  static double circleRound(const std::vector<Vector3>& points) {
    double least = std::numeric_limits<double>::infinity();
    const auto tryCentre = [&](const Vector3& centre) {
      double radius = 0;
      for (const Vector3& point : points) radius = std::max(radius, (point - centre).norm());
      least = std::min(least, radius);
    };
    for (const Vector3& a : points) {
      for (const Vector3& b : points) {
        tryCentre(0.5 * (a + b));
        for (const Vector3& c : points) {
          const Vector3 u = b - a, v = c - a;
          const double area = 2 * (u.x() * v.y() - u.y() * v.x());
          if (std::abs(area) < 1e-14) continue;
          tryCentre(a + Vector3(v.y() * u.squaredNorm() - u.y() * v.squaredNorm(),
                                u.x() * v.squaredNorm() - v.x() * u.squaredNorm(), 0) /
                            area);
        }
      }
    }
    return least;
  }

  const model::Tile& tile_;
  const model::Tile& target_;
};

/// A regular polygon with every coordinate off by up to `noise`.
model::Tile roughPolygon(int corners, double noise, bool flat, std::mt19937& random) {
  std::uniform_real_distribution<double> off(-noise, noise);
  model::Tile tile;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * 3.14159265358979323846 * k / corners;
    tile.vertices.emplace_back(std::cos(angle) + off(random), std::sin(angle) + off(random),
                               flat ? 0 : off(random));
  }
  return tile;
}

TEST(RigidBound, AgreesWithASearchInThePlane) {
  std::mt19937 random(4);
  for (int trial = 0; trial < 12; ++trial) {
    const int corners = 3 + trial % 4;
    const model::Tile tile = roughPolygon(corners, 0.1, true, random);
    const model::Tile target = roughPolygon(corners, 0.1, true, random);
    const double least = PlaneSearch(tile, target).least();
    EXPECT_NEAR(trajectory::rigidBound({tile}, {target}), least, 1e-7 * least);
  }
}

TEST(RigidBound, NoMotionInSpaceGoesBelow) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3(normal(random), normal(random), normal(random)); };
  for (int trial = 0; trial < 10; ++trial) {
    const model::Tile tile = roughPolygon(4, 0.2, false, random);
    const model::Tile target = roughPolygon(4, 0.2, false, random);
    const double bound = trajectory::rigidBound({tile}, {target});
    for (int i = 0; i < 3000; ++i) {
      const double size = std::pow(10, -i % 5);
      const model::RigidMotion best = model::bestRigidMotion(tile.vertices, target.vertices);
      const Matrix3 turn = rotationFromVector(size * vector()).toRotationMatrix() * best.rotation;
      const Vector3 move = best.translation + size * vector();
      double largest = 0;
      for (int k = 0; k < 4; ++k) {
        largest = std::max(largest, (turn * tile.vertices[k] + move - target.vertices[k]).norm());
      }
      EXPECT_GE(largest, bound);
    }
  }
}

TEST(RigidBound, LiesBelowTheBestFitInSquares) {
  // One corner of a square is displaced: the least-squares fit leaves most of this at the corner,
  // the minimax fit distributes it.
  const model::Tile square{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}};
  model::Tile bent = square;
  bent.vertices[2] += Vector3(0.2, 0.2, 0);
  const model::RigidMotion fit = model::bestRigidMotion(square.vertices, bent.vertices);
  const double ofSquares = (fit.apply(square.vertices[2]) - bent.vertices[2]).norm();
  const double bound = trajectory::rigidBound({square}, {bent});
  EXPECT_LT(bound / ofSquares, 0.7);  // measured 0.667
  EXPECT_NEAR(bound, PlaneSearch(square, bent).least(), 1e-9);
}

TEST(RigidBound, IsThatOfTheWorstTile) {
  std::mt19937 random(6);
  std::vector<model::Tile> tiles, targets;
  double largest = 0;
  for (int i = 0; i < 30; ++i) {
    tiles.push_back(roughPolygon(3 + i % 4, 0.1, false, random));
    targets.push_back(roughPolygon(3 + i % 4, 0.1, false, random));
    largest = std::max(largest, trajectory::rigidBound({tiles.back()}, {targets.back()}));
  }
  EXPECT_NEAR(trajectory::rigidBound(tiles, targets), largest, 1e-11 * largest);
}

TEST(KineticEnergy, OfABoxHasTheClosedForm) {
  brick::BrickRule rule;
  rule.thickness = 0.2;
  const std::vector<brick::Brick> bricks{
      brick::makeBrick({{{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {0, 2, 0}}}, rule)};
  Motion motion{Poses(1), std::vector<Velocity>(1)};
  motion.velocities[0].linear = {1, -2, 2};
  EXPECT_NEAR(trajectory::kineticEnergy(bricks, motion), 4.5, 1e-14);
  // If upright, the brick's z axis is the world's -y.
  motion.poses[0].rotation = rotationFromVector({1.5707963267948966, 0, 0});
  motion.velocities[0].angular = {0, 4, 0};
  EXPECT_NEAR(trajectory::kineticEnergy(bricks, motion), 4.5 + 0.5 * (9 + 4) / 12.0 * 16, 1e-13);
}

}  // namespace
}  // namespace kirireel
