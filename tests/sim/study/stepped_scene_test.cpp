/// Studies run the scenes of users: both loops give one motion.
#include "sim/study/stepped_scene.h"

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

/// A sheet that springs open. Runs do not perturb such a start.
scene::Scene pulledSheet(double tolerance) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  shape.startAngle = 0.3;
  scene.model = generate::makeTessellation(shape);
  model::alignStartToTarget(scene.model);
  scene.brick.thickness = 0.02;
  scene.path.kind = scene::PathKind::Straight;
  scene.springs.adaptive = false;
  scene.solver.timestep = 1.0 / 240;
  scene.solver.tolerance = tolerance;
  scene.stop.duration = 0.5;
  return scene;
}

TEST(SteppedScene, MovesLikeARun) {
  for (const double tolerance : {0.0, 1e-6}) {
    const scene::Scene scene = pulledSheet(tolerance);
    study::SteppedScene stepped(scene);
    for (int step = 0; step < 120; ++step) stepped.advance();
    const run::DeploymentResult run = deploy::deploy(scene, 0.5, nullptr);
    ASSERT_NEAR(run.trajectory.samples.back().time, 0.5, 1e-12);
    const Poses& end = run.trajectory.samples.back().poses;
    double apart = 0;
    for (std::size_t i = 0; i < end.size(); ++i) {
      apart = std::max(apart, (end[i].position - stepped.motion().poses[i].position).norm());
    }
    const double moved =
        (end[0].position - run.trajectory.samples.front().poses[0].position).norm();
    EXPECT_GT(moved, 0.1);
    // A perturbation, which runs do not apply to such a start.
    EXPECT_LT(apart, 1e-8) << tolerance;  // measured 5.0e-10
  }
}

}  // namespace
}  // namespace kirireel
