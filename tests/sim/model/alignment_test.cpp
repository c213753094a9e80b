#include <random>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

std::vector<Vector3> randomPoints(int count, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i)
    points.emplace_back(normal(random), normal(random), normal(random));
  return points;
}

double residual(const model::RigidMotion& motion, const std::vector<Vector3>& from,
                const std::vector<Vector3>& to) {
  double sum = 0;
  for (size_t i = 0; i < from.size(); ++i) sum += (motion.apply(from[i]) - to[i]).squaredNorm();
  return sum;
}

std::vector<Vector3> moved(const model::RigidMotion& motion, const std::vector<Vector3>& points) {
  std::vector<Vector3> result;
  for (const Vector3& point : points) result.push_back(motion.apply(point));
  return result;
}

model::RigidMotion someMotion() {
  return {rotationFromVector({0.3, -1.9, 2.2}).toRotationMatrix(), {4, -5, 6}};
}

TEST(BestRigidMotion, FindsAMotionAgain) {
  std::mt19937 random(1);
  for (const int count : {2, 3, 4, 20}) {
    const std::vector<Vector3> from = randomPoints(count, random);
    const model::RigidMotion found = model::bestRigidMotion(from, moved(someMotion(), from));
    EXPECT_LT(residual(found, from, moved(someMotion(), from)), 1e-28);  // measured 4e-29
    EXPECT_NEAR(found.rotation.determinant(), 1, 1e-14);
  }
}

TEST(BestRigidMotion, NeverReflects) {
  std::mt19937 random(2);
  const std::vector<Vector3> from = randomPoints(12, random);
  std::vector<Vector3> mirrored = from;
  for (Vector3& point : mirrored) point.x() = -point.x();
  EXPECT_NEAR(model::bestRigidMotion(from, mirrored).rotation.determinant(), 1, 1e-14);
}

TEST(BestRigidMotion, NoOtherMotionIsBetter) {
  std::mt19937 random(3);
  const std::vector<Vector3> from = randomPoints(9, random);
  const std::vector<Vector3> to = randomPoints(9, random);
  const model::RigidMotion best = model::bestRigidMotion(from, to);
  const double least = residual(best, from, to);
  Vector3 middle = Vector3::Zero();
  for (const Vector3& point : from) middle += point / 9;
  for (const Vector3& change : randomPoints(200, random)) {
    for (const double size : {1e-3, 0.1, 1.0}) {
      // Turned further about the middle, then moved further.
      model::RigidMotion other = best;
      other.rotation = best.rotation * rotationFromVector(size * change).toRotationMatrix();
      other.translation = best.apply(middle) - other.rotation * middle;
      EXPECT_GT(residual(other, from, to), least);
      other = best;
      other.translation += size * change;
      EXPECT_GT(residual(other, from, to), least);
    }
  }
}

TEST(BestRigidMotion, OnePointNeedsNoTurn) {
  const std::vector<Vector3> from{{1, 2, 3}}, to{{3, 2, 1}};
  const model::RigidMotion motion = model::bestRigidMotion(from, to);
  EXPECT_EQ(motion.apply(from[0]), to[0]);
  EXPECT_NEAR(motion.rotation.determinant(), 1, 1e-15);
}

TEST(Alignment, NothingToDoWithoutTarget) {
  model::Model model = generate::makeTessellation({});
  model.target.reset();
  const model::RigidMotion motion = model::alignStartToTarget(model);
  EXPECT_EQ(motion.rotation, Matrix3::Identity());
  EXPECT_EQ(motion.translation, Vector3::Zero());
}

TEST(Alignment, BringsTheStartOntoAMovedTarget) {
  model::Model model = generate::makeTessellation({});
  std::vector<model::Tile> target = model.tiles;
  for (model::Tile& tile : target) tile.vertices = moved(someMotion(), tile.vertices);
  model.target = target;
  model::alignStartToTarget(model);
  for (size_t i = 0; i < target.size(); ++i) {
    for (size_t k = 0; k < 4; ++k) {
      // measured 4e-15
      EXPECT_LT((model.tiles[i].vertices[k] - target[i].vertices[k]).norm(), 1e-13);
    }
  }
}

TEST(Alignment, FlatSheetIsNeverFlippedOver) {
  // The best motion in space onto a mirrored sheet turns it over, which is not allowed in the
  // plane.
  generate::TessellationShape shape;
  shape.columns = 3;
  shape.rows = 2;
  model::Model model = generate::makeTessellation(shape);
  for (model::Tile& tile : *model.target) {
    for (Vector3& vertex : tile.vertices) vertex = Vector3(-vertex.x(), vertex.y(), 2);
  }
  const model::RigidMotion motion = model::alignStartToTarget(model);
  EXPECT_EQ(motion.rotation.col(2), Vector3::UnitZ());
  EXPECT_NEAR(motion.translation.z(), 2, 1e-15);
}

}  // namespace
}  // namespace kirireel
