#include "sim/brick/brick.h"

#include <filesystem>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

double relativeError(const Matrix3& found, const Matrix3& expected) {
  return (found - expected).norm() / expected.norm();
}

model::Tile moved(const model::Tile& tile, const Quaternion& turn, const Vector3& shift) {
  model::Tile result;
  for (const Vector3& vertex : tile.vertices) result.vertices.push_back(turn * vertex + shift);
  return result;
}

/// A convex polygon in the plane z = 0: points on an ellipse, in order.
model::Tile randomConvexTile(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const int count = 3 + static_cast<int>(6 * unit(random));
  const double stretch = 0.3 + 2 * unit(random);
  model::Tile tile;
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.8 * unit(random)) / count;
    tile.vertices.emplace_back(stretch * std::cos(angle), std::sin(angle), 0);
  }
  return tile;
}

Quaternion randomTurn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
}

brick::BrickRule rule(double thickness, brick::MassRule mass) {
  brick::BrickRule result;
  result.thickness = thickness;
  result.mass = mass;
  result.density = 700;
  return result;
}

/// The second method: volume, first and second moments of a solid from the tetrahedra between a
/// point outside it and the triangles of its outward faces.
struct SolidMoments {
  double volume = 0;
  Vector3 first = Vector3::Zero();
  Matrix3 second = Matrix3::Zero();

  void addTetrahedron(const Vector3& a, const Vector3& b, const Vector3& c) {
    const double v = a.dot(b.cross(c)) / 6;
    const Vector3 sum = a + b + c;
    volume += v;
    first += v * sum / 4;
    second += v / 20 *
              (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
  }
};

SolidMoments momentsByTetrahedra(const brick::Brick& brick) {
  const Vector3 apex(0.3, -0.2, 0.4);
  SolidMoments moments;
  for (const std::vector<Vector3>& face : brick::brickFaces(brick)) {
    for (size_t k = 1; k + 1 < face.size(); ++k) {
      moments.addTetrahedron(face[0] - apex, face[k] - apex, face[k + 1] - apex);
    }
  }
  // Back to the brick's origin: x = y + apex.
  moments.second += apex * moments.first.transpose() + moments.first * apex.transpose() +
                    moments.volume * apex * apex.transpose();
  moments.first += moments.volume * apex;
  return moments;
}

void expectClosedForm(const model::Tile& tile, double thickness, double area,
                      const Matrix3& covariance) {
  const brick::Brick brick = brick::makeBrick(tile, rule(thickness, brick::MassRule::Prism));
  const double mass = 700 * area * thickness;
  EXPECT_NEAR(brick.volume / (area * thickness), 1, 1e-12);  // measured 4e-16
  EXPECT_NEAR(brick.mass / mass, 1, 1e-12);                  // measured 7e-16
  const Matrix3 inertia = mass * (covariance.trace() * Matrix3::Identity() - covariance);
  EXPECT_LT(relativeError(brick.inertia, inertia), 1e-12);  // measured 5e-16
}

TEST(Brick, RectanglePrismHasTheClosedForm) {
  const double a = 3, b = 0.7, h = 0.2;
  const model::Tile tile{{{1, 2, 5}, {4, 2, 5}, {4, 2.7, 5}, {1, 2.7, 5}}};
  expectClosedForm(tile, h, a * b, Vector3(a * a / 12, b * b / 12, h * h / 12).asDiagonal());
  const brick::Brick brick = brick::makeBrick(tile, rule(h, brick::MassRule::Prism));
  EXPECT_LT((brick.bottom[0] - Vector3(-1.5, -0.35, -0.1)).norm(), 1e-15);
  EXPECT_LT((brick.top[2] - Vector3(1.5, 0.35, 0.1)).norm(), 1e-15);
}

TEST(Brick, RightTrianglePrismHasTheClosedForm) {
  const double a = 2, b = 1.5, h = 0.3;
  Matrix3 covariance = Vector3(a * a / 18, b * b / 18, h * h / 12).asDiagonal();
  covariance(0, 1) = covariance(1, 0) = -a * b / 36;
  expectClosedForm({{{0, 0, 0}, {a, 0, 0}, {0, b, 0}}}, h, a * b / 2, covariance);
}

TEST(Brick, HexagonPrismHasTheClosedForm) {
  const double side = 1.3, h = 0.05;
  model::Tile tile;
  for (int k = 0; k < 6; ++k) {
    tile.vertices.emplace_back(side * std::cos(k * std::numbers::pi / 3),
                               side * std::sin(k * std::numbers::pi / 3), 0);
  }
  const double inPlane = 5.0 / 24 * side * side;
  expectClosedForm(tile, h, 1.5 * std::sqrt(3) * side * side,
                   Vector3(inPlane, inPlane, h * h / 12).asDiagonal());
}

TEST(Brick, MatchesTetrahedraForRandomPolygons) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const model::Tile tile = moved(randomConvexTile(random), randomTurn(random), {1, -2, 3});
    const brick::Brick brick = brick::makeBrick(tile, rule(0.3, brick::MassRule::Prism));
    const SolidMoments moments = momentsByTetrahedra(brick);
    EXPECT_NEAR(brick.volume / moments.volume, 1, 1e-12);       // measured 1e-15
    EXPECT_LT((moments.first / moments.volume).norm(), 1e-12);  // measured 8e-16
    const Matrix3 inertia = 700 * (moments.second.trace() * Matrix3::Identity() - moments.second);
    EXPECT_LT(relativeError(brick.inertia, inertia), 1e-12);  // measured 1e-15
  }
}

TEST(Brick, TurnsWithItsTile) {
  std::mt19937 random(2);
  for (int i = 0; i < 50; ++i) {
    const model::Tile tile = randomConvexTile(random);
    const Quaternion turn = randomTurn(random);
    const brick::Brick flat = brick::makeBrick(tile, rule(0.1, brick::MassRule::Prism));
    const brick::Brick turned =
        brick::makeBrick(moved(tile, turn, {-4, 5, 6}), rule(0.1, brick::MassRule::Prism));
    const Matrix3 rotation = turn.toRotationMatrix();
    // measured 2e-15
    EXPECT_LT(relativeError(turned.inertia, rotation * flat.inertia * rotation.transpose()), 1e-12);
    EXPECT_LT((turned.normal - turn * flat.normal).norm(), 1e-13);
    EXPECT_LT((turned.top[0] - turn * flat.top[0]).norm(), 1e-13);
  }
}

TEST(Brick, UnitMassScalesTheInertia) {
  std::mt19937 random(3);
  const model::Tile tile = randomConvexTile(random);
  const brick::Brick unit = brick::makeBrick(tile, rule(0.02, brick::MassRule::Unit));
  const brick::Brick prism = brick::makeBrick(tile, rule(0.02, brick::MassRule::Prism));
  EXPECT_EQ(unit.mass, 1);
  EXPECT_LT(relativeError(unit.inertia * prism.mass, prism.inertia), 1e-15);
}

void expectOutwardAndClosed(const brick::Brick& brick) {
  Vector3 sum = Vector3::Zero();
  double area = 0;
  for (const std::vector<Vector3>& face : brick::brickFaces(brick)) {
    const model::Tile polygon{face};
    EXPECT_GT(model::tileNormal(polygon).dot(face[0]), 0);
    sum += model::tileArea(polygon) * model::tileNormal(polygon);
    area += model::tileArea(polygon);
  }
  EXPECT_LT(sum.norm(), 1e-13 * area);  // measured 2e-15
}

TEST(Brick, FacesLookOutwardAndCloseTheBrick) {
  std::mt19937 random(4);
  for (int i = 0; i < 50; ++i) {
    const model::Tile tile = moved(randomConvexTile(random), randomTurn(random), {1, 1, 1});
    expectOutwardAndClosed(brick::makeBrick(tile, rule(0.02, brick::MassRule::Unit)));
  }
}

TEST(Brick, FacesLookOutwardOnEveryModel) {
  const fs::path source(KIRIREEL_SOURCE_DIR);
  int models = 0;
  for (const fs::path& folder : {source / "data", source / "../shared/models"}) {
    if (!fs::exists(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (!fs::exists(entry.path() / "vertices.txt")) continue;
      std::vector<std::string> warnings;
      const model::Model model = formats::readModelFolder(entry.path(), warnings);
      const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
      for (const brick::Brick& brick : bricks) expectOutwardAndClosed(brick);
      ++models;
    }
  }
  EXPECT_GE(models, 2);
  if (models == 2) GTEST_SKIP() << "../shared/models is not there; the shipped models pass";
}

TEST(Brick, StartsWhereItsTileIs) {
  const model::Model model = generate::makeTessellation({});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const std::vector<model::Tile> bottoms =
      brick::bottomTiles(bricks, brick::startPoses(model.tiles, bricks));
  for (size_t i = 0; i < model.tiles.size(); ++i) {
    for (size_t k = 0; k < 4; ++k) {
      // measured 2e-16
      EXPECT_LT((bottoms[i].vertices[k] - model.tiles[i].vertices[k]).norm(), 1e-15);
    }
  }
}

TEST(Pivots, FollowJointsAndFaces) {
  const model::Model model = generate::makeTessellation({});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const std::vector<model::Joint> joints{{{0, 2}, {4, 3}, model::JointFace::Both},
                                         {{0, 3}, {1, 0}, model::JointFace::Top},
                                         {{1, 1}, {5, 0}, model::JointFace::Bottom}};
  const std::vector<brick::Pivot> pivots = brick::makePivots(joints, bricks);
  ASSERT_EQ(pivots.size(), 4u);
  EXPECT_EQ(pivots[0].pointA, bricks[0].bottom[2]);
  EXPECT_EQ(pivots[0].pointB, bricks[4].bottom[3]);
  EXPECT_EQ(pivots[1].pointA, bricks[0].top[2]);
  EXPECT_EQ(pivots[1].brickB, 4);
  EXPECT_EQ(pivots[2].pointB, bricks[1].top[0]);
  EXPECT_EQ(pivots[3].pointA, bricks[1].bottom[1]);
  EXPECT_EQ(pivots[3].joint, 2);
}

TEST(Pivots, OfLinksAndFixedJointsFitTheStart) {
  const model::Model model = generate::makeTessellation({});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const std::vector<brick::Pivot> pivots = brick::makePivots(
      {model::makeLink(model.tiles, {0, 1}, {5, 2}), model::makeFixedJoint(model.tiles, 3, 2)},
      bricks);
  ASSERT_EQ(pivots.size(), 4u);
  EXPECT_GT(pivots[0].distance, 0);
  const Poses start = brick::startPoses(model.tiles, bricks);
  for (const brick::Pivot& pivot : pivots) EXPECT_LT(brick::pivotGap(pivot, start), 1e-15);
  const Vector3 area =
      (pivots[2].pointA - pivots[1].pointA).cross(pivots[3].pointA - pivots[1].pointA);
  EXPECT_GT(area.norm(), 0.1);  // not in line
}

// Closed forms: |(3, -4, 12)| = 13. A small move changes a gap by its component along the row.
TEST(Pivots, RowsAreTheGradientsOfTheirGaps) {
  const Vector3 apart(3, -4, 12), move(2e-6, 1e-6, -3e-6);
  brick::Pivot pivot;
  EXPECT_EQ(pivot.rowCount(true), 2);
  EXPECT_EQ(pivot.rowCount(false), 3);
  EXPECT_EQ(brick::pivotRows(pivot, apart).gaps, apart);
  EXPECT_EQ(brick::pivotGap(pivot, apart), 13);
  pivot.distance = 10;
  EXPECT_EQ(pivot.rowCount(true), 1);
  EXPECT_EQ(pivot.rowCount(false), 1);
  EXPECT_EQ(brick::pivotGap(pivot, apart), 3);
  const brick::PivotRows rows = brick::pivotRows(pivot, apart);
  EXPECT_EQ(rows.gaps, Vector3(3, 0, 0));
  const double change = brick::pivotRows(pivot, apart + move).gaps.x() -
                        brick::pivotRows(pivot, apart - move).gaps.x();
  // measured 3e-16
  EXPECT_NEAR(change, 2 * rows.axes.row(0).dot(move), 1e-14);
}

}  // namespace
}  // namespace kirireel
