// Runs of sheets with springs at their hinges.
#include <cmath>
#include <fstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/support/files.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

/// A sheet of 4 x 4 squares, open by 30 degrees, whose springs rest at 70 degrees.
scene::Scene sprungSheet(double stiffness) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.startAngle = 30 * kDegree;
  scene.model = generate::makeTessellation(shape);
  scene.model.target.reset();
  scene.actuation.drive = scene::Drive::None;
  scene.hinges.stiffness = stiffness;
  scene.hinges.rest = 70 * kDegree;
  scene.environment.linearDamping = scene.environment.angularDamping = 0.9;
  scene.environment.contacts = scene::ContactFilter::None;
  return scene;
}

double openingAtEnd(const run::DeploymentResult& run) {
  return brick::hingeAngle(brick::hingeSpringsOf(run.trajectory.pairForces).at(0).hinge,
                           run.trajectory.samples.back().poses);
}

TEST(SprungSheets, ComeToRestAtTheRestOfTheirSprings) {
  const run::DeploymentResult run = deploy::deploy(sprungSheet(5), 0.1, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  EXPECT_NEAR(openingAtEnd(run), 70 * kDegree, 1e-5);  // measured 2e-7
  ASSERT_TRUE(run.elasticity.has_value());
  EXPECT_EQ(run.elasticity->count("springs"), 24);
  const double turn = 40 * kDegree;
  EXPECT_NEAR(run.elasticity->energyStart, 24 * 2.5 * turn * turn, 1e-9);
  EXPECT_LT(run.elasticity->energyEnd, 1e-8);
  EXPECT_LT(run.elasticity->momentEnd, 1e-4);
}

TEST(SprungSheets, AreNotAtRestWhileSoftSpringsStillMoveThem) {
  scene::Scene scene = sprungSheet(1e-5);
  scene.stop.duration = 3;
  const run::DeploymentResult run = deploy::deploy(scene, 1, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::OutOfTime) << run.reason;
}

TEST(SprungSheets, LieBetweenTheirTargetAndTheirRest) {
  scene::Scene scene = sprungSheet(50);
  scene.hinges.rest = 30 * kDegree;
  generate::TessellationShape shape;
  shape.startAngle = 30 * kDegree;
  scene.model = generate::makeTessellation(shape);  // its target is open by 90 degrees
  scene.actuation.drive = scene::Drive::Target;
  const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
  EXPECT_GT(openingAtEnd(run), 40 * kDegree);
  EXPECT_LT(openingAtEnd(run), 89.9 * kDegree);
  EXPECT_GT(run.elasticity->energyEnd, 1);
}

// Four panels round one vertex, as in a Miura sheet with corners of 60 degrees. The creases in line
// fold by c and -c, the two others by -z: tan(c / 2) = cos(60 degrees) tan(z / 2), as the vertex
// closes (T. A. Evans, R. J. Lang, S. P. Magleby, L. L. Howell, Rigidly foldable origami gadgets
// and tessellations, R. Soc. Open Sci. 2, 2015).
TEST(SprungSheets, FoldByTheAnglesOfTheirFile) {
  const double z = 50, c = 2 * std::atan(0.5 * std::tan(0.5 * z * kDegree)) / kDegree;
  const double h = std::sqrt(0.75);
  const test::TemporaryFolder folder;
  std::ofstream(folder / "a.fold") << fmt::format(
      R"({{"vertices_coords": [[0,0],[1,0],[0.5,{0}],[-1,0],[0.5,{1}],[1.5,{0}],[-0.5,{0}],
                               [-0.5,{1}],[1.5,{1}]],
           "faces_vertices": [[0,1,5,2],[0,2,6,3],[0,3,7,4],[0,4,8,1]],
           "edges_vertices": [[0,1],[0,2],[0,3],[0,4]],
           "edges_foldAngle": [{2},{3},{4},{3}]}})",
      h, -h, c, -z, -c);
  std::vector<std::string> warnings;
  scene::Scene scene;
  scene.model = formats::readModel(folder / "a.fold", std::nullopt, warnings);
  ASSERT_TRUE(warnings.empty()) << warnings[0];
  scene.actuation.drive = scene::Drive::None;
  scene.hinges.stiffness = 5;
  scene.environment.linearDamping = scene.environment.angularDamping = 0.9;
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Settled) << run.reason;
  ASSERT_EQ(run.elasticity->count("springs"), 4);
  EXPECT_GT(run.elasticity->energyStart, 4);
  EXPECT_LT(run.elasticity->energyEnd, 1e-8);
  // The sheet is free, so its folds define its state.
  const Poses& last = run.trajectory.samples.back().poses;
  for (const brick::HingeSpring& spring : brick::hingeSpringsOf(run.trajectory.pairForces)) {
    EXPECT_NEAR(brick::hingeAngle(spring.hinge, last), spring.rest, 1e-5);
  }
}

// Tiles that pass through each other can wind a spring up. The run ends before the angle of the
// poses jumps. Up to there, the energies balance.
TEST(SprungSheets, EndBeforeASpringTurnsByMoreThanAFullTurn) {
  scene::Scene scene;
  for (const double at : {0.0, 1.0}) {
    const Vector3 low(at, at, 0);
    scene.model.tiles.push_back(
        {{low, low + Vector3(1, 0, 0), low + Vector3(1, 1, 0), low + Vector3(0, 1, 0)}});
  }
  scene.model.joints = {{{0, 2}, {1, 0}, model::JointFace::Both}};
  scene.actuation.drive = scene::Drive::None;
  scene.environment.contacts = scene::ContactFilter::None;
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.hinges.stiffness = 0.05;
  scene.velocities.push_back({.tiles = {0}, .angular = {0, 0, 6}});
  scene.solver.tolerance = 1e-6;
  scene.stop.duration = 4;
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_EQ(run.outcome, run::Outcome::Diverged);
  EXPECT_THAT(run.reason,
              testing::HasSubstr("the hinge of tiles 0 and 1 turned by more than a full turn at "));
  EXPECT_LT(std::abs(openingAtEnd(run) - 90 * kDegree), 360 * kDegree);
  EXPECT_GT(std::abs(openingAtEnd(run) - 90 * kDegree), 340 * kDegree);
  for (const trajectory::Sample& sample : run.trajectory.samples) {
    EXPECT_LT(std::abs(sample.mechanics->energies.integrated()), 1e-5);  // measured 6e-7
  }
}

TEST(SprungSheets, LeaveTheirSpringsInTheTrajectory) {
  const scene::Scene scene = sprungSheet(5);
  const test::TemporaryFolder folder;
  trajectory::Trajectory trajectory;
  static_cast<trajectory::Subject&>(trajectory) = trajectory::subjectOf(scene);
  trajectory.samples.push_back({.poses = brick::startPoses(scene.model.tiles, trajectory.bricks)});
  test::writeTrajectory(trajectory, folder / "run.h5");
  const trajectory::TrajectoryReader reader(folder / "run.h5");
  const std::vector<brick::HingeSpring>& read = brick::hingeSpringsOf(reader.subject().pairForces);
  ASSERT_EQ(read.size(), 24u);
  for (std::size_t s = 0; s < read.size(); ++s) {
    const brick::HingeSpring& written = brick::hingeSpringsOf(trajectory.pairForces)[s];
    EXPECT_EQ(read[s].hinge.brickA, written.hinge.brickA);
    EXPECT_EQ(read[s].hinge.brickB, written.hinge.brickB);
    EXPECT_EQ(read[s].hinge.axis, written.hinge.axis);
    EXPECT_EQ(read[s].hinge.start, written.hinge.start);
    EXPECT_EQ(read[s].hinge.most, written.hinge.most);
    EXPECT_EQ(read[s].stiffness, written.stiffness);
    EXPECT_EQ(read[s].rest, written.rest);
  }
  const Poses& poses = trajectory.samples[0].poses;
  EXPECT_EQ(brick::elasticEnergy(read, poses),
            brick::elasticEnergy(brick::hingeSpringsOf(trajectory.pairForces), poses));
}

}  // namespace
}  // namespace kirireel
