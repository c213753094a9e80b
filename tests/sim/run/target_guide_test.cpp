#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/run/forces.h"

namespace kirireel {
namespace {

double largestDistance(const std::vector<model::Tile>& a, const std::vector<model::Tile>& b) {
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < a[i].vertices.size(); ++k) {
      largest = std::max(largest, (a[i].vertices[k] - b[i].vertices[k]).norm());
    }
  }
  return largest;
}

TEST(TargetGuide, BeginsAtTheStartAndEndsAtTheTarget) {
  const model::Model model = generate::makeTessellation({});
  std::vector<model::Tile> target = *model.target;
  target[3].vertices[1] += Vector3(0.1, -0.05, 0.02);  // no rigid image of its start
  const run::TargetGuide guide(model.tiles, target);
  EXPECT_LT(largestDistance(guide.at(0), model.tiles), 1e-14);  // measured 9e-16
  EXPECT_LT(largestDistance(guide.at(1), target), 1e-14);       // measured 2e-15
}

TEST(TargetGuide, TurnsATileEvenlyAboutItsMiddle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 1;
  const std::vector<model::Tile> start = generate::makeTessellation(shape).tiles;
  const auto turnedBy = [&](double angle) {
    std::vector<model::Tile> tiles = start;
    Vector3 middle = Vector3::Zero();
    for (const Vector3& vertex : start[0].vertices) middle += 0.25 * vertex;
    const Quaternion turn = rotationFromVector(angle * Vector3(0.6, 0, 0.8));
    for (Vector3& vertex : tiles[0].vertices) {
      vertex = middle + 0.4 * angle * Vector3::UnitX() + turn * (vertex - middle);
    }
    return tiles;
  };
  const run::TargetGuide guide(start, turnedBy(2.5));
  for (const double progress : {0.1, 0.5, 0.9}) {
    EXPECT_LT(largestDistance(guide.at(progress), turnedBy(2.5 * progress)), 1e-14);
  }
}

TEST(BestFitPoses, PutBricksOntoACongruentTarget) {
  const model::Model model = generate::makeTessellation({});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const Poses poses = run::bestFitPoses(bricks, *model.target);
  EXPECT_LT(largestDistance(brick::bottomTiles(bricks, poses), *model.target), 1e-14);
}

}  // namespace
}  // namespace kirireel
