// Detours cut out of paths: oracles are the direct way, and mechanisms that have no other.
#include <algorithm>

#include <gtest/gtest.h>

#include "sim/deploy/continuation.h"
#include "sim/deploy/forces.h"
#include "sim/measure/measures.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

constexpr double kAnyOverlap = 1;  // metres

/// A row of four squares, each joined to the next at a corner: it has three freedoms.
Scene row() {
  Scene scene;
  TessellationShape shape;
  shape.columns = 4;
  shape.rows = 1;
  scene.model = makeTessellation(shape);
  fillFromModel(scene);
  return scene;
}

/// The start with each square turned against the one before, by these radians; joints closed.
Poses folded(const Scene& scene, double angle) {
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  Poses guide = startPoses(scene.model.tiles, bricks);
  for (std::size_t i = 0; i < guide.size(); ++i) {
    const double turn = i % 2 == 0 ? angle : -angle;
    guide[i].rotation = Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()));
  }
  SearchBudget budget(5);
  return connect(scene, {startPoses(scene.model.tiles, bricks), guide}, budget).states.back();
}

TEST(Shortcuts, LeaveADetourOut) {
  const Scene scene = row();
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  const std::vector<Pivot> pivots = makePivots(scene.model.joints, bricks);
  const Poses from = folded(scene, 0.3), by = folded(scene, 1.2), to = folded(scene, 0.6);
  SearchBudget budget(5);
  const MechanismPath detour = connect(scene, {from, by, to}, budget);
  const MechanismPath direct = connect(scene, {from, to}, budget);
  ASSERT_TRUE(isDetour(scene, detour));
  ASSERT_FALSE(isDetour(scene, direct));
  const MechanismPath cut = withShortcuts(scene, detour, kAnyOverlap, budget);
  EXPECT_LE(cut.length(), 1.001 * direct.length());  // measured: 1.0000
  EXPECT_EQ(pathDistance(bricks, cut.states.front(), detour.states.front()), 0);
  EXPECT_EQ(pathDistance(bricks, cut.states.back(), detour.states.back()), 0);
  ASSERT_EQ(cut.states.size(), cut.lengths.size());
  for (std::size_t k = 1; k < cut.states.size(); ++k) {
    EXPECT_LE(jointGap(pivots, cut.states[k]).max, 1e-11);  // 1e-12
    EXPECT_NEAR(cut.lengths[k] - cut.lengths[k - 1],
                pathDistance(bricks, cut.states[k - 1], cut.states[k]), 1e-12);
  }
}

TEST(Shortcuts, KeepThePathOfAMechanismThatHasNoOther) {
  // Rotating squares have one freedom: closed at 0 and at 180 degrees, they open in between.
  Scene scene;
  TessellationShape shape;
  shape.columns = shape.rows = 3;
  shape.targetAngle = 3.0;
  scene.model = makeTessellation(shape);
  fillFromModel(scene);
  const std::vector<Brick> bricks = makeBricks(scene.model.tiles, scene.brick);
  SearchBudget budget(5);
  const MechanismPath path = continueAlong(
      scene, {startPoses(scene.model.tiles, bricks), bestFitPoses(bricks, *scene.model.target)}, {},
      budget);
  ASSERT_FALSE(path.isStuck);
  EXPECT_GE(withShortcuts(scene, path, kAnyOverlap, budget).length(), 0.999 * path.length());
}

TEST(Shortcuts, EndWithTheBudget) {
  const Scene scene = row();
  SearchBudget budget(5);
  const MechanismPath detour =
      connect(scene, {folded(scene, 0.3), folded(scene, 1.2), folded(scene, 0.6)}, budget);
  SearchBudget none(0);
  EXPECT_EQ(withShortcuts(scene, detour, kAnyOverlap, none).states.size(), detour.states.size());
  const MechanismPath stopped =
      withShortcuts(scene, detour, kAnyOverlap, budget, [](double) { return false; });
  EXPECT_EQ(stopped.states.size(), detour.states.size());
}

}  // namespace
}  // namespace kirireel
