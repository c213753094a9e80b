// Hinges, their angles, and the energies of springs there.
#include "sim/brick/hinge.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "tests/support/pair_forces.h"

namespace kirireel {
namespace {

struct Sheet {
  explicit Sheet(const model::Model& start, double thickness = 0.02)
      : model(start),
        bricks(brick::makeBricks(start.tiles, {thickness, brick::MassRule::Unit, 1})),
        poses(brick::startPoses(start.tiles, bricks)) {}
  brick::FoundHinges hinges(bool planar) const {
    return brick::findHinges(bricks, brick::makePivots(model.joints, bricks), planar);
  }
  model::Model model;
  std::vector<brick::Brick> bricks;
  Poses poses;
};

model::Model squares(int side, double angle, model::JointFace face = model::JointFace::Both) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.startAngle = angle;
  shape.face = face;
  return generate::makeTessellation(shape);
}

/// Poses of a sheet of squares that is open by an angle, by the closed form of the mechanism.
Poses openedBy(const Sheet& sheet, int side, double startAngle, double angle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, angle);
  Poses poses = sheet.poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int column = static_cast<int>(i) % side, row = static_cast<int>(i) / side;
    const double sign = (column + row) % 2 == 0 ? -0.5 : 0.5;
    poses[i].rotation = rotationFromVector(Vector3(0, 0, sign * (angle - startAngle)));
    poses[i].position.head<2>() = meanPoint(tiles[i].vertices).head<2>();
  }
  return poses;
}

std::vector<brick::HingeSpring> springsAt(const brick::FoundHinges& found, double stiffness,
                                          double rest) {
  std::vector<brick::HingeSpring> springs;
  for (const brick::Hinge& hinge : found.hinges) springs.push_back({hinge, stiffness, rest, 0});
  return springs;
}

// Each hinge of rotating squares opens by the sheet's angle. The energy of n hinges is n k (angle -
// rest)^2 / 2, and their moment k (rest - angle) each.
TEST(Hinges, OfRotatingSquaresOpenByTheSheetsAngle) {
  for (const bool planar : {true, false}) {
    for (const double start : {0.0, 0.3, 1.2}) {
      const int side = 3;
      const Sheet sheet(squares(side, start));
      const brick::FoundHinges found = sheet.hinges(planar);
      ASSERT_EQ(found.hinges.size(), 12u);
      EXPECT_TRUE(found.ballJoints.empty());
      const std::vector<brick::HingeSpring> springs = springsAt(found, 2, 0.5);
      for (const double angle : {0.0, 0.4, 1.5, 3.0}) {
        const Poses poses = openedBy(sheet, side, start, angle);
        for (const brick::Hinge& hinge : found.hinges) {
          EXPECT_NEAR(hinge.start, start, 1e-12);
          EXPECT_NEAR(hinge.most, std::numbers::pi, 1e-12);
          EXPECT_NEAR(brick::hingeAngle(hinge, poses), angle, 1e-12);  // measured 4e-16
        }
        EXPECT_NEAR(brick::elasticEnergy(springs, poses), 12 * (angle - 0.5) * (angle - 0.5),
                    1e-12);
        for (const double moment : brick::hingeMoments(springs, poses)) {
          EXPECT_NEAR(moment, 2 * (0.5 - angle), 1e-12);
        }
      }
    }
  }
}

// As published folders list them: a row for the bottom faces and one for the top faces.
TEST(Hinges, OfJointsListedFaceByFaceAreTheSame) {
  model::Model listed = squares(3, 0.3);
  const std::vector<model::Joint> joints = listed.joints;
  listed.joints.clear();
  for (model::Joint joint : joints) {
    for (const model::JointFace face : {model::JointFace::Bottom, model::JointFace::Top}) {
      joint.face = face;
      listed.joints.push_back(joint);
    }
  }
  const Sheet whole(squares(3, 0.3)), sheet(listed);
  for (const bool planar : {true, false}) {
    const brick::FoundHinges expected = whole.hinges(planar), found = sheet.hinges(planar);
    ASSERT_EQ(found.hinges.size(), expected.hinges.size()) << planar;
    for (std::size_t k = 0; k < found.hinges.size(); ++k) {
      EXPECT_EQ(found.hinges[k].cornerA, expected.hinges[k].cornerA);
      EXPECT_NEAR(found.hinges[k].start, expected.hinges[k].start, 1e-12);
      EXPECT_NEAR(found.hinges[k].most, expected.hinges[k].most, 1e-12);
    }
  }
}

/// Two triangles that lie flush along an edge and turn about one of its ends.
model::Model flushTriangles() {
  model::Model model;
  const double high = std::sqrt(0.75);
  model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {0.5, high, 0}}},
                 {{{0, 0, 0}, {0.5, high, 0}, {-0.5, high, 0}}}};
  model.joints = {{{0, 0}, {1, 0}, model::JointFace::Both}};
  return model;
}

TEST(Hinges, HaveAnglesBeyondAStraightAngle) {
  const Sheet sheet(flushTriangles());
  const brick::Hinge hinge = sheet.hinges(true).hinges.at(0);
  EXPECT_NEAR(hinge.start, 0, 1e-12);
  EXPECT_NEAR(hinge.most, 240 * kDegree, 1e-12);
  for (int degrees = -50; degrees <= 290; degrees += 10) {
    Poses poses = sheet.poses;
    poses[1].rotation = rotationFromVector(Vector3(0, 0, degrees * kDegree));
    EXPECT_NEAR(brick::hingeAngle(hinge, poses), degrees * kDegree, 1e-12) << degrees;
    for (Pose& pose : poses) pose.rotation = rotationFromVector({0, 0, 2.5}) * pose.rotation;
    EXPECT_NEAR(brick::hingeAngle(hinge, poses), degrees * kDegree, 1e-12) << degrees;
  }
}

// Bricks that pass through each other turn the spring further: its angle does not jump by a full
// turn.
TEST(Hinges, AnglesAreContinuousBeyondWhatBricksCanReach) {
  const Sheet sheet(flushTriangles());
  const brick::Hinge hinge = sheet.hinges(true).hinges.at(0);
  const double middle = 0.5 * (hinge.least + hinge.most);
  for (const double sign : {-1.0, 1.0}) {
    Poses poses = sheet.poses;
    for (int step = 1; step <= 70; ++step) {
      // Many small rotations, as in a run.
      const auto turn = [&](int brick, double angle) {
        Quaternion& rotation = poses[static_cast<std::size_t>(brick)].rotation;
        rotation = (rotationFromVector(angle * hinge.axis) * rotation).normalized();
      };
      turn(hinge.brickA, -0.07 * sign);
      turn(hinge.brickB, 0.01 * sign);
      const double angle = hinge.start + 0.08 * sign * step;
      if (std::abs(angle - middle) > 2 * std::numbers::pi) break;
      EXPECT_NEAR(brick::hingeAngle(hinge, poses), angle, 1e-12) << step;
    }
  }
}

TEST(Hinges, HaveTheSameAnglesForBothOrdersOfTiles) {
  model::Model swapped = flushTriangles();
  std::swap(swapped.joints[0].a, swapped.joints[0].b);
  const brick::Hinge hinge = Sheet(swapped).hinges(true).hinges.at(0);
  Poses poses = Sheet(swapped).poses;
  poses[1].rotation = rotationFromVector(Vector3(0, 0, 0.7));
  EXPECT_NEAR(brick::hingeAngle(hinge, poses), 0.7, 1e-12);
}

/// Two unit squares with a common edge, joined at both its ends on one face.
model::Model folded(model::JointFace face, double angle) {
  model::Model model;
  const Vector3 up(0, std::cos(angle), std::sin(angle));
  model.tiles = {{{{0, -1, 0}, {1, -1, 0}, {1, 0, 0}, {0, 0, 0}}},
                 {{{0, 0, 0}, {1, 0, 0}, Vector3(1, 0, 0) + up, up}}};
  model.joints = {{{0, 3}, {1, 0}, face}, {{0, 2}, {1, 1}, face}};
  return model;
}

TEST(Hinges, AtFoldsHaveFoldsSign) {
  for (const double start : {-2.0, 0.0, 0.8}) {
    const Sheet sheet(folded(model::JointFace::Bottom, start));
    const brick::FoundHinges found = sheet.hinges(false);
    ASSERT_EQ(found.hinges.size(), 1u);
    const brick::Hinge& hinge = found.hinges[0];
    EXPECT_NEAR(hinge.start, start, 1e-12);  // the second tile rises: a valley
    Poses poses = sheet.poses;
    poses[1].rotation = rotationFromVector(Vector3(0.3 - start, 0, 0));
    EXPECT_NEAR(brick::hingeAngle(hinge, poses), 0.3, 1e-12);
  }
}

TEST(Hinges, AreAbsentWithoutAnAxis) {
  const Sheet balls(squares(2, 0.3, model::JointFace::Bottom));
  EXPECT_EQ(balls.hinges(true).hinges.size(), 4u);
  EXPECT_EQ(balls.hinges(false).hinges.size(), 0u);
  EXPECT_EQ(balls.hinges(false).ballJoints.size(), 4u);
  const Sheet rigid(folded(model::JointFace::Both, 0));
  EXPECT_TRUE(rigid.hinges(false).hinges.empty());
  EXPECT_TRUE(rigid.hinges(true).hinges.empty());
  EXPECT_TRUE(rigid.hinges(false).ballJoints.empty());
  model::Model fixed = squares(2, 0.3);
  fixed.joints.push_back(model::makeFixedJoint(fixed.tiles, 0, 1));
  EXPECT_EQ(Sheet(fixed).hinges(true).hinges.size(), 3u);
}

TEST(HingeSprings, ReportTheirEnergyAtBothEnds) {
  const Sheet sheet(squares(2, 0));
  const std::vector<brick::HingeSpring> springs = springsAt(sheet.hinges(true), 3, 0.5);
  const brick::Elasticity found =
      brick::elasticityOf(test::pairForces(springs), sheet.poses, openedBy(sheet, 2, 0, 0.75));
  EXPECT_EQ(found.count("springs"), 4);
  EXPECT_EQ(found.count("ligaments"), 0);
  EXPECT_NEAR(found.energyStart, 1.5, 1e-12);
  EXPECT_NEAR(found.energyEnd, 0.375, 1e-12);
  EXPECT_NEAR(found.momentEnd, 0.75, 1e-12);
}

}  // namespace
}  // namespace kirireel
