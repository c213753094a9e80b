/// Sheets deployed from compact to fully open, against the mechanism's exact motion.
#include <numbers>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

std::vector<Vector3> verticesOf(const std::vector<model::Tile>& tiles) {
  std::vector<Vector3> vertices;
  for (const model::Tile& tile : tiles) {
    vertices.insert(vertices.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return vertices;
}

/// The opening angle: the relative rotation of two neighbours.
double openingAngle(const Poses& poses) {
  const Quaternion relative = poses[0].rotation.conjugate() * poses[1].rotation;
  return 2 * std::atan2(relative.vec().norm(), std::abs(relative.w()));
}

/// Largest distance of a vertex from the exact motion at the same angle, best rigid fit.
double positionError(const generate::TessellationShape& shape,
                     const std::vector<brick::Brick>& bricks, const Poses& poses) {
  const std::vector<Vector3> found = verticesOf(brick::bottomTiles(bricks, poses));
  const std::vector<Vector3> exact =
      verticesOf(generate::tessellationTiles(shape, openingAngle(poses)));
  const model::RigidMotion fit = model::bestRigidMotion(exact, found);
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, (fit.apply(exact[k]) - found[k]).norm());
  }
  return largest;
}

/// The largest errors of one deployment, before and after it left the singular start.
struct MotionErrors {
  double compact = 0;
  int compactSamples = 0;
  double open = 0;
  double lastAngle = 0;
  double gap = 0;
};

MotionErrors deployedErrors(int side, bool planar, double stiffness) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.solver.planar = planar;
  scene.springs = scene::paperSprings();
  scene.springs.springStiffness = scene.springs.torqueStiffness = stiffness;
  const run::DeploymentResult result = deploy::deploy(scene, 1.0 / 60, nullptr);
  MotionErrors errors;
  for (const trajectory::Sample& sample : result.trajectory.samples) {
    errors.lastAngle = openingAngle(sample.poses);
    if (errors.lastAngle < 0.04) ++errors.compactSamples;
    double& largest = errors.lastAngle < 0.04 ? errors.compact : errors.open;
    const double error = positionError(shape, result.trajectory.bricks, sample.poses);
    largest = std::max(largest, error);
  }
  errors.gap = result.accuracy.jointGapMax / model::modelSize(scene.model);
  return errors;
}

void expectExactMotion(int side, bool planar) {
  SCOPED_TRACE(side);
  const MotionErrors errors = deployedErrors(side, planar, 100);
  EXPECT_NEAR(errors.lastAngle, std::numbers::pi / 2, 1e-3);
  EXPECT_LT(errors.compact, 1e-6);  // measured 0: one step leaves it
  EXPECT_LT(errors.open, 1e-8);     // measured 2e-10
  EXPECT_LT(errors.gap, 1e-10);     // measured 2e-13
}

TEST(TessellationMotion, IsExactInThePlane) {
  for (const int side : {4, 10, 20}) expectExactMotion(side, true);
}

TEST(TessellationMotion, IsExactInSpace) {
  for (const int side : {4, 10}) expectExactMotion(side, false);
}

TEST(TessellationMotion, IsExactInSpaceFor400Tiles) {
  expectExactMotion(20, false);
}

TEST(TessellationMotion, IsExactFromTheSmallestAnglesOn) {
  // Weak springs take many samples to leave the singular start.
  for (const bool planar : {true, false}) {
    const MotionErrors errors = deployedErrors(10, planar, 0.1);
    EXPECT_GT(errors.compactSamples, 5);
    EXPECT_LT(errors.compact, 1e-6);  // measured 2e-7
    EXPECT_LT(errors.open, 1e-8);     // measured 7e-13
  }
}

}  // namespace
}  // namespace kirireel
