// Paths made shorter: oracles are the direct way, a geodesic in closed form, and mechanisms that
// have no other path.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "sim/deploy/continuation.h"
#include "sim/deploy/forces.h"
#include "sim/generate/shells.h"
#include "sim/model/isometry.h"
#include "sim/model/lattice.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

constexpr double kAnyOverlap = std::numeric_limits<double>::infinity();  // metres

/// A row of squares, each joined to the next at a corner; of four it has three freedoms.
scene::Scene row(int squares = 4) {
  scene::Scene scene;
  model::TessellationShape shape;
  shape.columns = squares;
  shape.rows = 1;
  scene.model = model::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene::fillFromModel(scene);
  return scene;
}

/// The start with each square turned against the one before, by these radians; joints closed.
Poses folded(const scene::Scene& scene, double angle) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  Poses guide = model::startPoses(scene.model.tiles, bricks);
  for (std::size_t i = 0; i < guide.size(); ++i) {
    const double turn = i % 2 == 0 ? angle : -angle;
    guide[i].rotation = Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()));
  }
  deploy::SearchBudget budget;
  return deploy::connect(scene, {model::startPoses(scene.model.tiles, bricks), guide}, budget)
      .states.back();
}

bool areSame(const Pose& a, const Pose& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs();
}

TEST(Shortcuts, LeaveADetourOut) {
  const scene::Scene scene = row();
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  const Poses from = folded(scene, 0.3), by = folded(scene, 1.2), to = folded(scene, 0.6);
  deploy::SearchBudget budget;
  const deploy::MechanismPath detour = deploy::connect(scene, {from, by, to}, budget);
  const deploy::MechanismPath direct = deploy::connect(scene, {from, to}, budget);
  ASSERT_TRUE(deploy::isDetour(scene, detour));
  ASSERT_FALSE(deploy::isDetour(scene, direct));
  const deploy::MechanismPath cut = deploy::withShortcuts(scene, detour, kAnyOverlap, budget);
  EXPECT_LE(cut.length(), 1.001 * direct.length());  // measured: 1.0000
  EXPECT_TRUE(std::ranges::equal(cut.states.front(), detour.states.front(), areSame));
  EXPECT_TRUE(std::ranges::equal(cut.states.back(), detour.states.back(), areSame));
  ASSERT_EQ(cut.states.size(), cut.lengths.size());
  for (std::size_t k = 1; k < cut.states.size(); ++k) {
    EXPECT_LE(trajectory::jointGap(pivots, cut.states[k]).max, 1e-11);  // 1e-12
    EXPECT_NEAR(cut.lengths[k] - cut.lengths[k - 1],
                deploy::pathDistance(bricks, cut.states[k - 1], cut.states[k]), 1e-12);
  }
}

/// Rotating squares have one freedom: closed at 0 and at 180 degrees, they open in between.
scene::Scene nearlyClosedAgain() {
  scene::Scene scene;
  model::TessellationShape shape;
  shape.columns = shape.rows = 3;
  shape.targetAngle = 3.0;
  scene.model = model::makeTessellation(shape);
  scene::fillFromModel(scene);
  return scene;
}

TEST(Shortcuts, KeepThePathOfAMechanismThatHasNoOther) {
  const scene::Scene scene = nearlyClosedAgain();
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  deploy::SearchBudget budget;
  const deploy::MechanismPath path =
      deploy::continueAlong(scene,
                            {model::startPoses(scene.model.tiles, bricks),
                             deploy::bestFitPoses(bricks, *scene.model.target)},
                            {}, budget);
  ASSERT_FALSE(path.isStuck);
  EXPECT_GE(deploy::withShortcuts(scene, path, kAnyOverlap, budget).length(),
            0.999 * path.length());
}

TEST(Shortcuts, EndWithTheBudget) {
  const scene::Scene scene = row();
  deploy::SearchBudget budget;
  const deploy::MechanismPath detour =
      deploy::connect(scene, {folded(scene, 0.3), folded(scene, 1.2), folded(scene, 0.6)}, budget);
  deploy::SearchBudget none(0);
  EXPECT_EQ(deploy::withShortcuts(scene, detour, kAnyOverlap, none).states.size(),
            detour.states.size());
  const deploy::MechanismPath stopped =
      deploy::withShortcuts(scene, detour, kAnyOverlap, budget, [](double) { return false; });
  EXPECT_EQ(stopped.states.size(), detour.states.size());
}

// ------------------------------------------------------------------------------------------------
// Paths pulled tight.

/// A path through these states with joints closed.
deploy::MechanismPath pathThrough(const scene::Scene& scene, std::vector<Poses> states) {
  deploy::SearchBudget budget;
  return deploy::connect(scene, std::move(states), budget);
}

deploy::MechanismPath pulledTight(const scene::Scene& scene, const deploy::MechanismPath& path,
                                  double turnWeight = 1) {
  deploy::SearchBudget budget;
  return deploy::pulledTight(scene, path, turnWeight, kAnyOverlap, budget);
}

/// The whole turned about the origin and moved.
Poses carried(Poses poses, double angle, const Vector3& by) {
  const Quaternion turn(Eigen::AngleAxisd(angle, Vector3::UnitZ()));
  for (Pose& pose : poses) {
    pose.position = turn * pose.position + by;
    pose.rotation = turn * pose.rotation;
  }
  return poses;
}

/// Checks that a path has the given ends, closed joints and the lengths that it says.
void expectWhole(const scene::Scene& scene, const deploy::MechanismPath& path,
                 const deploy::MechanismPath& before) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  EXPECT_EQ(deploy::pathDistance(bricks, path.states.front(), before.states.front()), 0);
  EXPECT_EQ(deploy::pathDistance(bricks, path.states.back(), before.states.back()), 0);
  ASSERT_EQ(path.states.size(), path.lengths.size());
  for (std::size_t k = 1; k < path.states.size(); ++k) {
    EXPECT_LE(trajectory::jointGap(pivots, path.states[k]).max, 1e-11) << k;  // measured: 1e-12
    EXPECT_NEAR(path.lengths[k] - path.lengths[k - 1],
                deploy::pathDistance(bricks, path.states[k - 1], path.states[k]), 1e-12);
  }
}

TEST(PulledTight, APathOfTwoSquaresIsTheGeodesicInClosedForm) {
  // Two equal squares, hinged at a corner, move on a geodesic as if nothing pushed them: about
  // their common centre, which rests, they turn by opposite angles. Each centre is r from the
  // hinge, at an angle p from the line of symmetry, and moves across it: with s = r sin p,
  //   L = integral of sqrt(r^2 cos^2 p + rho^2) dp,  rho = r for the corners of a square.
  const scene::Scene scene = row(2);
  const Poses from = folded(scene, 0.2), to = folded(scene, 0.7);
  const Poses by = carried(folded(scene, 0.5), 0.4, {0.3, -0.2, 0});
  const deploy::MechanismPath detour = pathThrough(scene, {from, by, to});
  const deploy::MechanismPath path = pulledTight(scene, detour);
  expectWhole(scene, path, detour);
  const double r = std::sqrt(0.5);
  const auto angleOf = [&](const Poses& state) {
    return std::asin(0.5 * (state[1].position - state[0].position).norm() / r);
  };
  const double first = angleOf(from), last = angleOf(to);
  double length = 0;
  constexpr int kParts = 1000;
  for (int k = 0; k < kParts; ++k) {
    const double p = first + (last - first) * (k + 0.5) / kParts;
    length += std::abs(last - first) / kParts * r * std::sqrt(1 + std::cos(p) * std::cos(p));
  }
  EXPECT_GT(detour.length(), 2 * length);  // measured: 2.2
  // The detour's first fortieth is kept: 1.016.
  EXPECT_LE(path.length(), 1.03 * length);
  EXPECT_GE(path.length(), 0.999 * length);
}

TEST(PulledTight, APathIsNoLongerThanTheDirectOneAndEven) {
  const scene::Scene scene = row();
  const Poses from = folded(scene, 0.3), by = folded(scene, 1.2), to = folded(scene, 0.6);
  const deploy::MechanismPath detour = pathThrough(scene, {from, by, to});
  const deploy::MechanismPath direct = pathThrough(scene, {from, to});
  EXPECT_TRUE(deploy::turnsBack(scene, detour));
  EXPECT_FALSE(deploy::turnsBack(scene, direct));
  const deploy::MechanismPath path = pulledTight(scene, detour);
  expectWhole(scene, path, detour);
  EXPECT_FALSE(deploy::turnsBack(scene, path));
  EXPECT_GT(detour.length(), 5 * direct.length());     // measured: 5.2
  EXPECT_LE(path.length(), 1.0001 * direct.length());  // 0.999994
  EXPECT_NEAR(pulledTight(scene, path).length(), path.length(), 1e-3 * path.length());
}

TEST(PulledTight, APathOfAMechanismThatHasNoOtherKeepsItsLength) {
  const scene::Scene scene = nearlyClosedAgain();
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const deploy::MechanismPath path =
      pathThrough(scene, {model::startPoses(scene.model.tiles, bricks),
                          deploy::bestFitPoses(bricks, *scene.model.target)});
  ASSERT_FALSE(path.isStuck);
  // Measured: 0.9998, since the images are fewer than the states.
  EXPECT_NEAR(pulledTight(scene, path).length(), path.length(), 1e-3 * path.length());
}

TEST(PulledTight, APathIsTheSameButForExponentsInOtherUnits) {
  const scene::Scene scene = row();
  const deploy::MechanismPath detour =
      pathThrough(scene, {folded(scene, 0.3), folded(scene, 1.2), folded(scene, 0.6)});
  const deploy::MechanismPath path = pulledTight(scene, detour);
  scene::Scene scaled = scene;
  for (model::Tile& tile : scaled.model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex *= 1024;
  }
  scaled.brick.thickness *= 1024;
  deploy::MechanismPath larger = detour;
  for (Poses& state : larger.states) {
    for (Pose& pose : state) pose.position *= 1024;
  }
  for (double& length : larger.lengths) length *= 1024;
  deploy::SearchBudget budget;
  larger = deploy::pulledTight(scaled, larger, 1, kAnyOverlap, budget);
  ASSERT_EQ(larger.states.size(), path.states.size());
  for (std::size_t k = 0; k < path.states.size(); ++k) {
    EXPECT_EQ(larger.lengths[k], 1024 * path.lengths[k]) << k;
    for (std::size_t i = 0; i < path.states[k].size(); ++i) {
      EXPECT_EQ(larger.states[k][i].position, 1024 * path.states[k][i].position) << k;
      EXPECT_EQ(larger.states[k][i].rotation.coeffs(), path.states[k][i].rotation.coeffs()) << k;
    }
  }
}

TEST(PulledTight, APathAmongContactsStaysClear) {
  // Folded by 1.4, the first square and the third of a row all but touch.
  scene::Scene scene = row(3);
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<model::Pivot> pivots = model::makePivots(scene.model.joints, bricks);
  const Poses from = folded(scene, 0.1), to = folded(scene, 1.4);
  scene.environment.contacts = scene::ContactFilter::All;
  const deploy::MechanismPath detour =
      pathThrough(scene, {from, folded(scene, 0.9), folded(scene, 0.2), to});
  deploy::SearchBudget budget;
  trajectory::PenetrationMeter meter(bricks, pivots, scene.environment.pivotZone, from, 0);
  const double most = 1e-4 * model::tileSize(scene.model);
  const deploy::MechanismPath path = deploy::pulledTight(scene, detour, 1, most, budget);
  EXPECT_LT(path.length(), 0.6 * detour.length());  // measured: 0.52
  for (const Poses& state : path.states) EXPECT_LE(meter.at(state).grown, most);
}

TEST(PulledTight, ADetourLeavesASaddleAndKeepsItsSymmetries) {
  // The even way of a tube is a saddle: others with its symmetries are shorter.
  scene::Scene scene;
  scene.model = generate::makeCylinder({.columns = 6, .rows = 8, .length = 1, .width = 1});
  model::alignStartToTarget(scene.model);
  scene.environment.contacts = scene::ContactFilter::None;
  scene::fillFromModel(scene);
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  deploy::SearchBudget budget;
  const deploy::MechanismPath path =
      deploy::continueAlong(scene,
                            {model::startPoses(scene.model.tiles, bricks),
                             deploy::bestFitPoses(bricks, *scene.model.target)},
                            {}, budget);
  ASSERT_TRUE(deploy::isDetour(scene, path));  // measured: 2.16
  const deploy::MechanismPath shorter = pulledTight(scene, path);
  EXPECT_LT(shorter.length(), 0.85 * path.length());  // measured: 0.77
  ASSERT_GT(shorter.symmetries.size(), 1u);
  for (const Poses& state : shorter.states) {
    EXPECT_LE(model::asymmetry(state, shorter.symmetries, 1), 1e-9 * model::tileSize(scene.model));
  }
}

/// The length of a path in which turns have a weight, metres.
double weightedLength(const scene::Scene& scene, const deploy::MechanismPath& path,
                      double turnWeight) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  double length = 0;
  for (std::size_t k = 1; k < path.states.size(); ++k) {
    length += deploy::pathDistance(bricks, path.states[k - 1], path.states[k], turnWeight);
  }
  return length;
}

TEST(PulledTight, ThePathIsTheShortestInTheMetricThatItWasPulledIn) {
  const scene::Scene scene = row();
  const Poses to = carried(folded(scene, 1.2), 1.5, {2, 1, 0});
  const deploy::MechanismPath detour =
      pathThrough(scene, {folded(scene, 0.3), folded(scene, 0.9), to});
  const deploy::MechanismPath plain = pulledTight(scene, detour, 1);
  const deploy::MechanismPath even = pulledTight(scene, detour, 100);
  expectWhole(scene, even, detour);
  EXPECT_LT(weightedLength(scene, plain, 1), weightedLength(scene, even, 1));
  EXPECT_LT(weightedLength(scene, even, 100), weightedLength(scene, plain, 100));
  EXPECT_EQ(weightedLength(scene, plain, 1), plain.length());
}

TEST(PulledTight, APathStaysAsItIsWithoutBudgetAndWhenStopped) {
  const scene::Scene scene = row();
  const deploy::MechanismPath detour =
      pathThrough(scene, {folded(scene, 0.3), folded(scene, 1.2), folded(scene, 0.6)});
  deploy::SearchBudget none(0), budget;
  EXPECT_EQ(deploy::pulledTight(scene, detour, 1, kAnyOverlap, none).lengths, detour.lengths);
  const deploy::MechanismPath stopped =
      deploy::pulledTight(scene, detour, 1, kAnyOverlap, budget, [](double) { return false; });
  EXPECT_EQ(stopped.lengths, detour.lengths);
  deploy::MechanismPath point = detour;
  point.states.resize(1);
  point.lengths.resize(1);
  EXPECT_EQ(deploy::pulledTight(scene, point, 1, kAnyOverlap, budget).lengths, point.lengths);
}

// ------------------------------------------------------------------------------------------------
// Paths that turn back.

/// Two squares that turn evenly about their joint by one radian, back by so many of 200 equal parts
/// of that, and on by half a radian.
deploy::MechanismPath withAKink(const scene::Scene& scene, int back) {
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const Poses start = model::startPoses(scene.model.tiles, bricks);
  const model::Pivot pivot = model::makePivots(scene.model.joints, bricks).front();
  const Vector3 joint = start[static_cast<std::size_t>(pivot.brickA)].apply(pivot.pointA);
  deploy::MechanismPath path;
  for (int k = 0; k <= 300 + 2 * back; ++k) {
    const int part = k <= 200 ? k : std::max(400 - k, k - 2 * back);
    Poses state = start;
    const Quaternion turn(Eigen::AngleAxisd(0.005 * part, Vector3::UnitZ()));
    state[1].rotation = turn;
    state[1].position = joint + turn * (state[1].position - joint);
    path.lengths.push_back(path.states.empty()
                               ? 0
                               : path.length() +
                                     deploy::pathDistance(bricks, path.states.back(), state));
    path.states.push_back(std::move(state));
  }
  return path;
}

TEST(Kinks, AreLeftOutWhereBricksMayGoStraight) {
  const scene::Scene scene = row(2);
  const std::vector<model::Brick> bricks = model::makeBricks(scene.model.tiles, scene.brick);
  const deploy::MechanismPath path = withAKink(scene, 3);
  ASSERT_TRUE(deploy::turnsBack(scene, path));
  // Joints open by less than 1e-4 m where bricks go straight.
  const deploy::MechanismPath even = deploy::withoutKinks(scene, path, 1e-4, kAnyOverlap);
  EXPECT_FALSE(deploy::turnsBack(scene, even));
  // Back and forth takes 6 of 306 moves; what is shorter than a piece that is looked at may stay.
  EXPECT_LE(even.length(), path.length() * 303 / 306);  // measured: 302
  EXPECT_GE(even.length(), path.length() * 299.9 / 306);
  EXPECT_EQ(deploy::pathDistance(bricks, even.states.front(), path.states.front()), 0);
  EXPECT_EQ(deploy::pathDistance(bricks, even.states.back(), path.states.back()), 0);
  for (std::size_t k = 1; k < even.states.size(); ++k) {
    EXPECT_NEAR(even.lengths[k] - even.lengths[k - 1],
                deploy::pathDistance(bricks, even.states[k - 1], even.states[k]), 1e-12);
  }
}

TEST(Kinks, StayWhereJointsMayNotOpen) {
  const scene::Scene scene = row(2);
  const deploy::MechanismPath path = withAKink(scene, 3);
  EXPECT_EQ(deploy::withoutKinks(scene, path, -1, kAnyOverlap).lengths, path.lengths);
}

TEST(Kinks, APathThatDoesNotMoveHasNone) {
  const scene::Scene scene = row(2);
  deploy::MechanismPath still = withAKink(scene, 3);
  still.states.assign(5, still.states.front());
  still.lengths.assign(5, 0);
  EXPECT_FALSE(deploy::turnsBack(scene, still));
  EXPECT_EQ(deploy::withoutKinks(scene, still, 1, kAnyOverlap).lengths, still.lengths);
}

}  // namespace
}  // namespace kirireel
