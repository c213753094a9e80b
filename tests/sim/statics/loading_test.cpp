// Scenes with grips: equilibria in place of a deployment.
#include "sim/statics/loading.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/brick/stiffness.h"
#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/files.h"
#include "tests/support/refusal.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

/// Four squares with springs, open by 20 degrees: one is held, its neighbour turned by 40 degrees.
scene::Scene turnedUnit() {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  shape.startAngle = 20 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::Auto;
  scene.path.kind = scene::PathKind::Auto;
  scene.hinges.stiffness = 3;
  scene::GripSetting held, turned;
  held.tiles = {0};
  held.x = held.y = held.turn = 0;
  turned.tiles = {1};
  turned.turn = 40 * kDegree;
  scene.grips = {held, turned};
  return scene;
}

/// The same unit with closed slits.
model::Model shutUnit() {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  return generate::makeTessellation(shape);
}

/// Energy of springs and ligaments, joules.
double elasticEnergyOf(const trajectory::Subject& subject, const Poses& poses) {
  return subject.pairForces.energy(poses);
}

TEST(Loading, IsSampledAsAPathWithItsLoadCurve) {
  const run::DeploymentResult run = deploy::deploy(turnedUnit(), 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  ASSERT_TRUE(run.loadCurve.has_value());
  EXPECT_EQ(run.loadCurve->leading, 3u);
  const mechanics::Equilibrium& last = run.loadCurve->states.back();
  const double turn = 40 * kDegree;
  EXPECT_EQ(last.load, 1);
  EXPECT_NEAR(last.forces[3], 12 * turn, 1e-9);  // 4 k t, as in the tests of equilibrium
  EXPECT_NEAR(run.elasticity->energyEnd, 6 * turn * turn, 1e-9);
  EXPECT_EQ(run.trajectory.samples.size(), 13u);
  for (const trajectory::Sample& sample : run.trajectory.samples) EXPECT_LT(sample.jointGap, 1e-11);
  const std::vector<brick::HingeSpring>& springs = brick::hingeSpringsOf(run.trajectory.pairForces);
  EXPECT_NEAR(brick::elasticEnergy(springs, run.trajectory.samples.back().poses), last.energy,
              1e-12);
}

TEST(Loading, KeepsAStateForEachFigure) {
  const run::DeploymentResult run = deploy::deploy(turnedUnit(), 0.5, nullptr);
  EXPECT_FALSE(run.trajectory.figureStates.empty());
  for (const trajectory::FigureState& state : run.trajectory.figureStates) {
    EXPECT_EQ(state.poses.size(), 4u) << state.figure;
  }
}

TEST(Loading, LeavesATable) {
  const run::DeploymentResult run = deploy::deploy(turnedUnit(), 0.5, nullptr);
  const std::string table = mechanics::loadTable(*run.loadCurve);
  EXPECT_THAT(table, testing::StartsWith(
                         "load,energy_J,grip_2_turn_stiffness_N_m_per_rad,unstable_modes,turning,"
                         "grip_1_x_m,grip_1_x_force_N,grip_1_y_m,grip_1_y_force_N,grip_1_turn_rad,"
                         "grip_1_turn_moment_N_m,grip_2_turn_rad,grip_2_turn_moment_N_m\n0,"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(table.begin(), table.end(), '\n')),
            run.loadCurve->states.size() + 1);
}

TEST(Loading, HasTheUnitOfTheModelInItsTable) {
  mechanics::LoadCurve curve;
  curve.grips = {{"grip 1 x", false}, {"grip 1 turn", true}};
  curve.states = {
      {.load = 1, .energy = 2, .displacements = {0.25, 0.5}, .forces = {3, 4}, .stiffness = 16}};
  EXPECT_EQ(mechanics::loadTable(curve, *findLengthUnit("mm")),
            "load,energy_J,grip_1_x_stiffness_N_per_mm,unstable_modes,turning,grip_1_x_mm,"
            "grip_1_x_force_N,grip_1_turn_rad,grip_1_turn_moment_N_m\n1,2,0.016,0,,250,3,0.5,4\n");
}

TEST(Loading, GivesTheSameEveryTime) {
  EXPECT_EQ(mechanics::loadTable(*deploy::deploy(turnedUnit(), 0.5, nullptr).loadCurve),
            mechanics::loadTable(*deploy::deploy(turnedUnit(), 0.1, nullptr).loadCurve));
}

TEST(Loading, NecksAreCompliantIfTheyAreLigaments) {
  scene::Scene scene = turnedUnit();
  scene.hinges.stiffness = 0;
  scene.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  const run::DeploymentResult pinned = deploy::deploy(scene, 0.5, nullptr);
  scene.hinges.areLigaments = true;
  const run::DeploymentResult ligaments = deploy::deploy(scene, 0.5, nullptr);
  EXPECT_EQ(ligaments.outcome, run::Outcome::Settled) << ligaments.reason;
  const double exact = pinned.loadCurve->states.back().forces[3];
  const double soft = ligaments.loadCurve->states.back().forces[3];
  EXPECT_GT(soft, 0);
  EXPECT_LT(soft, exact);
  EXPECT_GT(ligaments.accuracy.jointOpeningMax, 1e-6);
  EXPECT_LT(pinned.accuracy.jointGapMax, 1e-11);
  EXPECT_EQ(pinned.accuracy.jointOpeningMax, 0);
}

// The stiffness of a neck, given by numbers: a Timoshenko beam with k_l = E w t / L and 1 / (k_s
// L^2) = L / (12 E I) + 1 / (5/6 G w t L).
TEST(Loading, LigamentsOfGivenStiffnessAreThoseOfTheirNecks) {
  scene::Scene neck = turnedUnit();
  neck.hinges.stiffness = 0;
  neck.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  neck.hinges.areLigaments = true;
  const run::DeploymentResult a = deploy::deploy(neck, 0.5, nullptr);
  const double t = neck.brick.thickness, bending = 1e6 * t * std::pow(0.02, 3) / 12;
  const double shear = 1 / (0.1 / (12 * bending) + 1 / (5.0 / 6 * 1e6 / 2.6 * 0.02 * t * 0.1));
  for (const double unit : {1.0, 1e-3}) {
    scene::Scene given = turnedUnit();
    given.hinges.stiffness = brick::neckStiffness(1e6, t, 0.02, 0.1);
    given.hinges.ligament =
        scene::LigamentStiffness{1e6 * 0.02 * t / 0.1, shear / (0.1 * 0.1), 0.1};
    // Lengths of a scene in another unit, and back.
    scene::scaleLengths(given, unit);
    EXPECT_NEAR(given.hinges.ligament->length, 0.1 * unit, 1e-15);
    scene::scaleLengths(given, 1 / unit);
    const run::DeploymentResult b = deploy::deploy(given, 0.5, nullptr);
    const mechanics::Equilibrium& one = a.loadCurve->states.back();
    const mechanics::Equilibrium& other = b.loadCurve->states.back();
    EXPECT_NEAR(other.energy / one.energy, 1, 1e-12);        // measured 0
    EXPECT_NEAR(other.forces[3] / one.forces[3], 1, 1e-12);  // measured 0
    EXPECT_EQ(b.elasticity->count("ligaments"), 4);
  }
}

TEST(Loading, NecksAreCompliantInMotionToo) {
  scene::Scene scene = turnedUnit();
  scene.grips.clear();
  scene.hinges.stiffness = 0;
  scene.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  scene.environment.contacts = scene::ContactFilter::None;
  scene.stop.duration = 0.5;
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_GT(run.accuracy.jointOpeningMax, 1e-6);
  ASSERT_TRUE(run.elasticity.has_value());
  const trajectory::Sample& last = run.trajectory.samples.back();
  EXPECT_EQ(brick::ligamentsOf(run.trajectory.pairForces).size(), 4u);
  EXPECT_EQ(run.elasticity->energyEnd, elasticEnergyOf(run.trajectory, last.poses));
  EXPECT_EQ(run.elasticity->energyEnd, last.mechanics->energies.elastic);
}

// The energies of springs and ligaments in the file are those of the equilibria.
TEST(Loading, LeavesItsLigamentsInTheTrajectory) {
  for (const double length : {0.0, 0.1}) {
    scene::Scene scene = turnedUnit();
    scene.model = shutUnit();
    scene.hinges.stiffness = 0;
    scene.hinges.neck = scene::HingeNeck{0.05, length, 1e6, 0.3};
    scene.hinges.areLigaments = length > 0;
    const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
    ASSERT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    const test::TemporaryFolder folder;
    test::writeTrajectory(run.trajectory, folder / "run.h5");
    const trajectory::Trajectory read = test::readTrajectory(folder / "run.h5");
    ASSERT_EQ(brick::ligamentsOf(read.pairForces).size(), 4u);
    const double held = elasticEnergyOf(read, read.samples.back().poses);
    const double expected = run.loadCurve->states.back().energy;
    EXPECT_GT(brick::elasticEnergy(brick::ligamentsOf(read.pairForces), read.samples.back().poses),
              1e-6 * expected);
    EXPECT_NEAR(held, expected, 1e-12 * expected);  // measured 1.4e-16 of it
    EXPECT_EQ(run.elasticity->energyEnd, held);
    EXPECT_EQ(run.elasticity->count("ligaments"), 4);
  }
}

std::string refusalOf(const scene::Scene& scene) {
  return test::refusalOf<Error>([&] { deploy::deploy(scene, 1, nullptr); });
}

TEST(Loading, RefusesAPieceWithoutSupport) {
  scene::Scene scene = turnedUnit();
  scene.model.target.reset();
  model::Tile loose = scene.model.tiles.front();
  for (Vector3& vertex : loose.vertices) vertex.x() += 10;
  scene.model.tiles.push_back(loose);
  EXPECT_THAT(refusalOf(scene),
              HasSubstr("the model has 2 pieces, and nothing holds the piece of tile 4 (1 of 5 "
                        "tiles). Hold each piece with grips or `pin`"));
}

TEST(Loading, RefusesSettingsOfDynamics) {
  scene::Scene scene = turnedUnit();
  scene.environment.contacts = scene::ContactFilter::All;
  EXPECT_THAT(refusalOf(scene), HasSubstr("equilibria under grips have no contacts"));
  scene = turnedUnit();
  scene.environment.gravity = {0, 0, -9.81};
  EXPECT_THAT(refusalOf(scene), HasSubstr("but there is gravity. Remove it or the grips"));
  scene = turnedUnit();
  scene.solver.planar = false;
  EXPECT_THAT(refusalOf(scene),
              HasSubstr("grips load rigid tiles only in the plane, but `planar` is off"));
  scene = turnedUnit();
  scene.grips[1].turn = 0;
  EXPECT_THAT(refusalOf(scene), HasSubstr("no grip moves or pushes"));
  scene = turnedUnit();
  scene.grips.erase(scene.grips.begin());
  EXPECT_THAT(refusalOf(scene), HasSubstr("the sheet can move without resistance"));
  scene = turnedUnit();
  scene.hinges.stiffness = 0;
  scene.grips[1].isForce = true;
  EXPECT_THAT(refusalOf(scene), HasSubstr("the sheet can move without resistance"));
  scene = turnedUnit();
  scene.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  scene.grips.clear();
  scene.solver.planar = false;
  EXPECT_THAT(refusalOf(scene),
              HasSubstr("`ligaments` works only in the plane, but `planar` is off. Remove one"));
  scene.solver.planar.reset();
  scene.environment.gravity = {0, 1, -9.81};
  EXPECT_THAT(refusalOf(scene), HasSubstr("but gravity is not vertical. Remove one of them, or set "
                                          "`planar` to on"));
  scene.hinges.areLigaments = false;
  scene.hinges.neck.reset();
  scene.hinges.ligament.emplace();
  EXPECT_THAT(refusalOf(scene), HasSubstr("`ligament_stiffness` works only in the plane"));
  scene = turnedUnit();
  scene.hinges.neck = scene::HingeNeck{0.02, 0, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  EXPECT_THAT(refusalOf(scene), HasSubstr("`ligaments` needs necks with a length"));
  scene = turnedUnit();
  scene.grips[0].z = 0;
  EXPECT_THAT(refusalOf(scene), HasSubstr("grips load this sheet only in its plane. Remove z"));
}

/// Squares of which a column is held along x and the last one moved by so much.
scene::Scene pulledSquares(int columns, double angle, double move) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = 4;
  shape.startAngle = angle;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::Auto;
  scene.path.kind = scene::PathKind::Auto;
  scene.hinges.stiffness = 1;
  scene::GripSetting left, corner, right;
  for (int row = 0; row < 4; ++row) {
    left.tiles.push_back(row);
    right.tiles.push_back(4 * (columns - 1) + row);
  }
  left.x = 0;
  corner.tiles = {0};
  corner.y = 0;
  right.x = move;
  scene.grips = {left, corner, right};
  return scene;
}

TEST(Loading, ReportsTheStabilityOfTheLastState) {
  const run::DeploymentResult stable = deploy::deploy(turnedUnit(), 0.5, nullptr);
  EXPECT_THAT(stable.reason, HasSubstr("reached, stable, through"));
  EXPECT_TRUE(stable.warnings.empty());
}

// The middles of n squares in a row are (n - 1) (cos(t/2) + sin(t/2)) apart, at most (n - 1)
// sqrt 2.
TEST(Loading, ReportsFullExtension) {
  for (const int columns : {3, 5}) {
    const double angle = 10 * kDegree;
    const double extent =
        (columns - 1) * (std::sqrt(2.0) - std::cos(angle / 2) - std::sin(angle / 2));
    const run::DeploymentResult run =
        deploy::deploy(pulledSquares(columns, angle, 1.2 * extent), 0.5, nullptr);
    EXPECT_EQ(run.outcome, run::Outcome::Locked);
    EXPECT_THAT(run.reason, HasSubstr(fmt::format("fully extended at {:.4g} m", extent)));
    EXPECT_NEAR(run.loadCurve->states.back().displacements[2], extent,
                1e-7 * extent);  // measured 2e-8
    // The load was not reached.
    EXPECT_EQ(run.shortfall, run.reason);
  }
}

// Sliding rows: the force begins at zero. The sign of its slope there depends on the rounding of
// coordinates in another unit.
TEST(Loading, RoundingAtAClosedStartIsNoEvent) {
  for (const double unit : {1.0, 1e-3, 0.0254, 0.3048}) {
    scene::Scene scene = pulledSquares(4, 0, 0.4);
    scene.model.target.reset();
    for (model::Tile& tile : scene.model.tiles) {
      for (Vector3& vertex : tile.vertices) {
        for (double& x : vertex) x = std::stod(fmt::format("{:.15g}", x / unit)) * unit;
      }
    }
    scene.hinges.stiffness = 0.02;
    scene.grips[0].tiles = {0, 4, 8, 12};
    scene.grips[2].tiles = {3, 7, 11, 15};
    const run::DeploymentResult run = deploy::deploy(scene, 0.02, nullptr);
    EXPECT_EQ(run.outcome, run::Outcome::Settled) << unit << ": " << run.reason;
    // Only the end.
    EXPECT_EQ(run.trajectory.events.size(), 1U) << run.trajectory.events.front().text;
  }
}

TEST(Loading, ReportsASheetPressedThroughItself) {
  const run::DeploymentResult run =
      deploy::deploy(pulledSquares(4, 30 * kDegree, -1.2), 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Locked);
  EXPECT_THAT(run.reason, HasSubstr("pass through itself"));
  EXPECT_FALSE(run.shortfall.empty());
  // Not closed yet: not reached.
  const run::DeploymentResult open =
      deploy::deploy(pulledSquares(4, 30 * kDegree, -0.5), 0.5, nullptr);
  EXPECT_EQ(open.outcome, run::Outcome::Settled) << open.reason;
}

TEST(Loading, NamesGripsThatContradictEachOther) {
  scene::Scene twice = pulledSquares(4, 30 * kDegree, 0.3);
  scene::GripSetting again;
  again.tiles = {twice.grips[2].tiles.front()};
  again.x = 0.1;
  twice.grips.push_back(again);
  EXPECT_THAT(refusalOf(twice), HasSubstr("grips contradict each other: the joints do not allow x "
                                          "of tiles"));
  EXPECT_THAT(refusalOf(twice), HasSubstr("by 0.1 (grip 4 x) together"));
  // The height of squares that are pulled must change.
  scene::Scene held = pulledSquares(4, 30 * kDegree, 0.3);
  scene::GripSetting all;
  for (int tile = 0; tile < 16; ++tile) all.tiles.push_back(tile);
  all.y = 0;
  held.grips.push_back(all);
  EXPECT_THAT(refusalOf(held), HasSubstr("grip 4 y"));
  // Equal grips agree.
  scene::Scene same = pulledSquares(4, 30 * kDegree, 0.3);
  again.x = 0.3;
  same.grips.push_back(again);
  EXPECT_EQ(refusalOf(same), "accepted");
}

// ------------------------------------------------------------------------------------------------
// The same sheet in other planes. The oracle is the horizontal sheet.

/// A rotation of the sheet, and the axes of space in the names of its grips.
struct Turn {
  Matrix3 matrix;
  const char* named;
};
const Turn kTurns[] = {
    {Eigen::AngleAxisd(0.7, Vector3::UnitZ()).toRotationMatrix(), "xy"},
    {Eigen::AngleAxisd(0.7, Vector3::UnitX()).toRotationMatrix(), "xyz"},
    {Eigen::AngleAxisd(90 * kDegree, Vector3::UnitX()).toRotationMatrix(), "xz"},
    {Eigen::AngleAxisd(2.1, Vector3(0.3, -1, 0.5).normalized()).toRotationMatrix(), "xyz"}};

/// The scene rotated in space. Each grip that moves or pushes names x, y and z, or those of them in
/// `named`.
scene::Scene turnedInSpace(scene::Scene scene, const Matrix3& turn, const std::string& named) {
  scene.model.target.reset();
  for (model::Tile& tile : scene.model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
  }
  for (scene::GripSetting& grip : scene.grips) {
    if (!grip.x && !grip.y) continue;
    const Vector3 amounts = turn * Vector3(grip.x.value_or(0), grip.y.value_or(0), 0);
    std::optional<double>* const names[] = {&grip.x, &grip.y, &grip.z};
    for (int k = 0; k < 3; ++k) {
      names[k]->reset();
      if (named.find("xyz"[k]) != std::string::npos) *names[k] = amounts[k];
    }
  }
  return scene;
}

/// Squares of which one is held, and a column pushed, or a corner moved.
scene::Scene heldSquares(bool isForce, double x, double y) {
  scene::Scene scene = pulledSquares(4, 30 * kDegree, 0);
  scene::GripSetting held, loaded = scene.grips[2];
  held.tiles = {0};
  held.x = held.y = 0;
  // A corner that moves fixes the rotation of the sheet.
  if (isForce) held.turn = 0;
  if (!isForce) loaded.tiles = {15};
  loaded.isForce = isForce;
  loaded.x = x;
  loaded.y = y;
  scene.grips = {held, loaded};
  return scene;
}

/// The figure of a grip in the last state.
double lastOf(const run::DeploymentResult& run, const std::string& grip,
              std::vector<double> mechanics::Equilibrium::*figure) {
  const std::vector<mechanics::GripName>& names = run.loadCurve->grips;
  const auto found = std::ranges::find(names, grip, &mechanics::GripName::name);
  EXPECT_NE(found, names.end()) << grip;
  if (found == names.end()) return NAN;
  return (run.loadCurve->states.back().*figure)[static_cast<std::size_t>(found - names.begin())];
}

// A load along x of the sheet, in another plane or turned in its own, has the same stiffness, force
// and displacement along its direction.
TEST(Loading, StiffnessIsAlongTheLoadInAnyPlane) {
  scene::Scene scene = heldSquares(true, 0.5, 0);
  scene.grips[1].y.reset();
  const run::DeploymentResult level = deploy::deploy(scene, 0.5, nullptr);
  ASSERT_EQ(level.outcome, run::Outcome::Settled) << level.reason;
  const double expected = level.loadCurve->states.back().stiffness;
  const double moved = lastOf(level, "grip 2 x", &mechanics::Equilibrium::displacements);
  EXPECT_EQ(level.loadCurve->grips[level.loadCurve->leading].name, "grip 2 x");
  for (const auto& [turn, named] : kTurns) {
    const scene::Scene other = turnedInSpace(scene, turn, named);
    const run::DeploymentResult run = deploy::deploy(other, 0.5, nullptr);
    ASSERT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    EXPECT_NEAR(run.loadCurve->states.back().stiffness, expected, 1e-8 * expected);
    EXPECT_NEAR(run.loadCurve->states.back().energy, level.loadCurve->states.back().energy, 1e-9);
    const std::string name = run.loadCurve->grips[run.loadCurve->leading].name;
    EXPECT_EQ(name, turn.col(0) == Vector3::UnitX() ? "grip 2 x" : "grip 2 along");
    EXPECT_NEAR(lastOf(run, name, &mechanics::Equilibrium::displacements), moved, 1e-9);
    EXPECT_NEAR(lastOf(run, name, &mechanics::Equilibrium::forces), 0.5, 1e-12);
  }
}

TEST(Loading, StiffnessOfAMoveIsAlongItInAnyPlane) {
  const scene::Scene scene = heldSquares(false, 0.2, 0.1);
  const run::DeploymentResult level = deploy::deploy(scene, 0.5, nullptr);
  ASSERT_EQ(level.outcome, run::Outcome::Settled) << level.reason;
  const mechanics::Equilibrium& last = level.loadCurve->states.back();
  const double force = lastOf(level, "grip 2 along", &mechanics::Equilibrium::forces);
  EXPECT_GT(std::abs(force), 1e-3);
  for (const auto& [turn, named] : kTurns) {
    const scene::Scene other = turnedInSpace(scene, turn, named);
    const run::DeploymentResult run = deploy::deploy(other, 0.5, nullptr);
    ASSERT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    const mechanics::Equilibrium& found = run.loadCurve->states.back();
    EXPECT_NEAR(found.stiffness, last.stiffness, 1e-7 * std::abs(last.stiffness));
    EXPECT_NEAR(lastOf(run, "grip 2 along", &mechanics::Equilibrium::forces), force,
                1e-8 * std::abs(force));
    EXPECT_NEAR(lastOf(run, "grip 2 along", &mechanics::Equilibrium::displacements),
                std::hypot(0.2, 0.1), 1e-12);
  }
}

/// Squares of which the first row is held and the last one moved along y.
scene::Scene raisedSquares(double move) {
  scene::Scene scene = pulledSquares(4, 30 * kDegree, 0);
  scene::GripSetting &low = scene.grips[0], &corner = scene.grips[1], &high = scene.grips[2];
  low = high = {};
  for (int column = 0; column < 4; ++column) {
    low.tiles.push_back(4 * column);
    high.tiles.push_back(4 * column + 3);
  }
  low.y = 0;
  corner.y.reset();
  corner.x = 0;
  high.y = move;
  return scene;
}

/// A sheet rotated about x: its y direction is along y and z.
scene::Scene turnedAboutX(const scene::Scene& scene, double angle) {
  const Matrix3 turn = Eigen::AngleAxisd(angle, Vector3::UnitX()).toRotationMatrix();
  scene::Scene other = turnedInSpace(scene, turn, "yz");
  scene::GripSetting& corner = other.grips[1];
  corner.y.reset();
  corner.z.reset();
  corner.x = 0;
  return other;
}

// y and z are one direction in such a plane: the force is along it.
TEST(Loading, ForcesOfDependentAxesAreInThePlane) {
  const run::DeploymentResult level = deploy::deploy(raisedSquares(0.1), 0.5, nullptr);
  ASSERT_EQ(level.outcome, run::Outcome::Settled) << level.reason;
  for (const double angle : {0.7, -2.5}) {
    const run::DeploymentResult run =
        deploy::deploy(turnedAboutX(raisedSquares(0.1), angle), 0.5, nullptr);
    ASSERT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    EXPECT_NEAR(run.loadCurve->states.back().stiffness, level.loadCurve->states.back().stiffness,
                1e-8 * level.loadCurve->states.back().stiffness);
    for (const std::string grip : {"grip 1", "grip 3"}) {
      const double force = lastOf(level, grip + " y", &mechanics::Equilibrium::forces);
      EXPECT_GT(std::abs(force), 0.1);
      const double y = lastOf(run, grip + " y", &mechanics::Equilibrium::forces);
      const double z = lastOf(run, grip + " z", &mechanics::Equilibrium::forces);
      EXPECT_NEAR(y, std::cos(angle) * force, 1e-8 * std::abs(force));
      EXPECT_NEAR(z, std::sin(angle) * force, 1e-8 * std::abs(force));
    }
  }
}

TEST(Loading, RefusesDependentAxesThatLeaveThePlane) {
  scene::Scene scene = turnedAboutX(raisedSquares(0.1), 0.7);
  *scene.grips[2].z += 0.01;
  EXPECT_THAT(refusalOf(scene), HasSubstr("this grip moves out of the plane of the sheet"));
}

// Two columns can neither separate nor slide along each other if their heights are fixed.
TEST(Loading, NamesContradictionsInAnyPlane) {
  scene::Scene apart = pulledSquares(4, 30 * kDegree, 0.4);
  apart.grips[0].y = apart.grips[2].y = 0;
  scene::Scene across = pulledSquares(4, 30 * kDegree, 0.4);
  across.grips[0].tiles.push_back(4);
  across.grips[0].x.reset();
  across.grips[0].y = 0;
  across.grips[1].y.reset();
  across.grips[1].x = 0;
  across.grips[2].x.reset();
  across.grips[2].y = 0.1;
  EXPECT_THAT(refusalOf(apart), HasSubstr("grips contradict each other"));
  EXPECT_THAT(refusalOf(turnedAboutX(across, 0.7)), HasSubstr("grips contradict each other"));
  EXPECT_THAT(refusalOf(across), HasSubstr("grips contradict each other"));
  for (const auto& [turn, named] : kTurns) {
    EXPECT_THAT(refusalOf(turnedInSpace(apart, turn, named)),
                HasSubstr("grips contradict each other"));
    EXPECT_EQ(refusalOf(turnedInSpace(heldSquares(false, 0.2, 0.1), turn, named)), "accepted");
  }
}

// Its grips fix the height of a column and the rotation: a force along y moves nothing.
TEST(Loading, LockedDirectionsHaveNoStiffness) {
  scene::Scene scene = pulledSquares(4, 30 * kDegree, 0);
  scene.grips[0].tiles.push_back(4);
  scene.grips[0].x.reset();
  scene.grips[0].y = 0;
  scene.grips[1].y.reset();
  scene.grips[1].x = 0;
  scene.grips[2].x.reset();
  scene.grips[2].y = 0.1;
  scene.grips[2].isForce = true;
  for (const double angle : {0.0, 0.7}) {
    const run::DeploymentResult run =
        deploy::deploy(angle == 0 ? scene : turnedAboutX(scene, angle), 0.5, nullptr);
    EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    for (const mechanics::Equilibrium& state : run.loadCurve->states) {
      EXPECT_TRUE(std::isnan(state.stiffness)) << state.stiffness;
    }
    EXPECT_THAT(mechanics::loadTable(*run.loadCurve), HasSubstr("\n0,0,,0,,"));
  }
}

/// Two squares in the plane, joined at both ends of a common edge x = 1 as in folded sheets. The
/// left one is held, and the outer edge of the right one lifted.
scene::Scene liftedFold() {
  scene::Scene scene;
  scene.model.tiles = {model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                       model::Tile{{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}}}};
  scene.model.joints = {{{0, 1}, {1, 0}}, {{0, 2}, {1, 3}}};
  scene.brick.thickness = 0.01;
  scene.environment.contacts = scene::ContactFilter::Auto;
  scene.path.kind = scene::PathKind::Auto;
  scene.hinges.stiffness = 0.5;
  scene.hinges.panels = scene::PanelMaterial{1e9, 0.3, 0};
  scene::GripSetting held, lifted;
  held.tiles = {0};
  held.corners = {{0, 0}, {0, 1}, {0, 2}, {0, 3}};
  held.x = held.y = held.z = 0;
  lifted.tiles = {1};
  lifted.corners = {{1, 1}, {1, 2}};
  lifted.z = 0.6;
  scene.grips = {held, lifted};
  return scene;
}

// The fold's moment k t is that of the force at the arm cos(t), sin(t) = 0.6 up.
TEST(Loading, LiftsATileAboutAFold) {
  const run::DeploymentResult run = deploy::deploy(liftedFold(), 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  const mechanics::Equilibrium& last = run.loadCurve->states.back();
  const double angle = std::asin(0.6);
  EXPECT_NEAR(last.forces[3], 0.5 * angle / 0.8, 1e-5);  // bars are not rigid
  EXPECT_NEAR(last.energy, 0.25 * angle * angle, 1e-5);
  // The elasticity is that of bars and folds, not of the best rigid tiles.
  ASSERT_TRUE(run.elasticity.has_value());
  EXPECT_EQ(run.elasticity->count("bars"), 9);
  EXPECT_EQ(run.elasticity->count("folds"), 3);
  EXPECT_NEAR(run.elasticity->energyEnd, last.energy, 1e-12 * last.energy);
  EXPECT_NEAR(run.elasticity->momentEnd, 0.5 * angle, 1e-5);
}

// A tile that is pressed onto its neighbour cannot go on: fold angles end at half a turn.
TEST(Loading, ReportsAFoldThatCloses) {
  scene::Scene scene = liftedFold();
  const double rise = 100 * kDegree;
  for (const int corner : {1, 2}) {
    Vector3& vertex = scene.model.tiles[1].vertices[static_cast<std::size_t>(corner)];
    vertex.x() = 1 + std::cos(rise);
    vertex.z() = std::sin(rise);
  }
  scene.grips[1].z = -1.1;
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Locked);
  EXPECT_NEAR(run.loadCurve->states.back().load, std::sin(rise) / 1.1, 1e-4);
  EXPECT_EQ(run.reason, "tiles 0 and 1 lie on each other at the load 0.8953: their fold is closed");
}

// In tension along its edges a square is held by two bars of the area 2 S t / ((1 - nu) (2 + sqrt
// 2)) with S = 1/2. Its diagonal carries nothing, so tiles do not get narrower.
TEST(Loading, SquaresInTensionHaveTheStiffnessOfTheirBars) {
  scene::Scene scene = liftedFold();
  scene::GripSetting flat, left, corner, right;
  flat.corners = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {1, 1}, {1, 2}};
  flat.tiles = {0, 1};
  flat.z = 0;
  left.tiles = corner.tiles = {0};
  left.corners = {{0, 0}, {0, 3}};
  left.x = 0;
  corner.corners = {{0, 0}};
  corner.y = 0;
  right.tiles = {1};
  right.corners = {{1, 1}, {1, 2}};
  right.x = 1e-5;
  scene.grips = {flat, left, corner, right};
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  const double material = 1e9 * 0.01 * 1e-5 / 2;  // E t u / L
  EXPECT_NEAR(run.loadCurve->states.back().forces.back(),
              (2 - std::sqrt(2.0)) / (1 - 0.3) * material, 1e-5 * material);
}

// Every state of the panels has the energy of the solver. Fold angles and strains follow from the
// nodes.
TEST(Loading, StoresTheStatesOfPanels) {
  const run::DeploymentResult run = deploy::deploy(liftedFold(), 0.5, nullptr);
  ASSERT_TRUE(run.trajectory.panels);
  const trajectory::LoadedPanels& panels = *run.trajectory.panels;
  const std::vector<mechanics::Equilibrium>& states = run.loadCurve->states;
  ASSERT_EQ(panels.states.size(), states.size());
  EXPECT_EQ(panels.tileNodes[0][1], panels.tileNodes[1][0]);
  for (std::size_t k = 0; k < states.size(); ++k) {
    const trajectory::PanelState& state = panels.states[k];
    EXPECT_NEAR(panels.energy(state), states[k].energy, 1e-14);  // measured 0
    for (std::size_t b = 0; b < panels.bars.size(); ++b) {
      const auto& [nodeA, nodeB, rest, stiffness] = panels.bars[b];
      const double length = (state.nodes[static_cast<std::size_t>(nodeB)] -
                             state.nodes[static_cast<std::size_t>(nodeA)])
                                .norm();
      EXPECT_NEAR(state.strains[b], length / rest - 1, 1e-15);  // measured 1.1e-16
    }
  }
  EXPECT_EQ(panels.states.back().time, run.trajectory.samples.back().time);
}

// Bars between held nodes need no springs at folds, and still have energy.
TEST(Loading, CountsTheEnergyOfBarsWithoutFolds) {
  scene::Scene scene = liftedFold();
  scene.model.tiles = {model::Tile{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}};
  scene.model.joints.clear();
  scene.hinges.stiffness = 0;
  scene::GripSetting held, pulled;
  held.tiles = {0};
  held.corners = {{0, 0}, {0, 1}};
  held.x = held.y = held.z = 0;
  pulled.tiles = {0};
  pulled.corners = {{0, 2}};
  pulled.y = 0.1;
  pulled.x = pulled.z = 0;
  scene.grips = {held, pulled};
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  ASSERT_TRUE(run.elasticity.has_value());
  EXPECT_EQ(run.elasticity->count("bars"), 3);
  EXPECT_GT(run.elasticity->energyEnd, 0);
  EXPECT_NEAR(run.elasticity->energyEnd / run.loadCurve->states.back().energy, 1, 1e-12);
}

// Without springs the length scale defines the stiffness of folds: E t^3 / (12 (1 - nu^2)) / scale.
TEST(Loading, FoldsHaveTheStiffnessOfTheirLengthScale) {
  scene::Scene scene = liftedFold();
  scene.hinges.stiffness = 0;
  scene.hinges.panels->foldLength = 200;
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  const double angle = std::asin(0.6), stiffness = 1e9 * 1e-6 / (12 * 0.91) / 200;
  EXPECT_NEAR(run.loadCurve->states.back().forces[3], stiffness * angle / 0.8, 1e-5);
}

// A fold that is folded in the model's file rests there without its grip, for a stiffness from
// springs or from the length scale.
TEST(Loading, BeginsAtTheRestAnglesOfTheFile) {
  for (const double stiffness : {0.5, 0.0}) {
    scene::Scene scene = liftedFold();
    const double rest = 0.3;
    scene.model.foldAngles = {{{0, 1}, rest}, {{1, 0}, rest}};
    scene.hinges.stiffness = stiffness;
    scene.hinges.panels->foldLength = stiffness > 0 ? 0 : 200;
    scene.grips[1].isForce = true;
    scene.grips[1].z = 1e-3;
    const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
    ASSERT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
    const mechanics::Equilibrium& first = run.loadCurve->states.front();
    EXPECT_NEAR(first.energy, 0, 1e-15);
    EXPECT_NEAR(first.displacements[3], std::sin(rest), 1e-9);
    EXPECT_GT(run.loadCurve->states.back().displacements[3], std::sin(rest));
  }
}

TEST(Loading, RefusesSettingsWithoutMeaningForPanels) {
  scene::Scene scene = liftedFold();
  scene.model.joints[0].face = model::JointFace::Both;
  EXPECT_THAT(refusalOf(scene), HasSubstr("bending tiles must be joined at one face, not at both"));
  scene = liftedFold();
  scene.grips[1].corners.clear();
  scene.grips[1].turn = 0.1;
  EXPECT_THAT(refusalOf(scene), HasSubstr("bending tiles have no rotation"));
}

// An edge of two pieces is one fold, whose stiffness both have together.
TEST(Loading, FoldsOfTwoEdgesAreOneHinge) {
  scene::Scene scene = liftedFold();
  scene.model.tiles = {model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 0.3, 0}, {1, 1, 0}, {0, 1, 0}}},
                       model::Tile{{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 0.3, 0}}}};
  scene.model.joints = {{{0, 1}, {1, 0}}, {{0, 2}, {1, 4}}, {{0, 3}, {1, 3}}};
  scene.grips[0].corners = {{0, 0}, {0, 1}, {0, 2}, {0, 3}, {0, 4}};
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  const double angle = std::asin(0.6);
  EXPECT_NEAR(run.loadCurve->states.back().energy, 0.25 * angle * angle, 1e-5);
}

}  // namespace
}  // namespace kirireel
