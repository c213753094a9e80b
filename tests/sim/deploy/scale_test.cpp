// The unit of length changes nothing but lengths.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/shells.h"
#include "sim/model/isometry.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

Scene scaled(Scene scene, double factor) {
  for (std::vector<Tile>* tiles : {&scene.model.tiles, &*scene.model.target}) {
    for (Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex *= factor;
    }
  }
  scene.brick.thickness *= factor;
  return scene;
}

/// The largest distance between the bricks of two runs at any sample, the second's lengths divided
/// by `factor`, metres.
double difference(const DeploymentResult& run, const DeploymentResult& other, double factor) {
  double largest = 0;
  for (std::size_t k = 0; k < run.trajectory.samples.size(); ++k) {
    const Poses& poses = run.trajectory.samples[k].poses;
    const Poses& others = other.trajectory.samples[k].poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      largest = std::max(largest, (poses[i].position - others[i].position / factor).norm());
      const auto turn = poses[i].rotation.coeffs() - others[i].rotation.coeffs();
      largest = std::max(largest, turn.norm());
    }
  }
  return largest;
}

void expectSameAtScale(const Scene& scene, double factor, double tolerance) {
  const DeploymentResult run = deploy(scene, 1.0 / 60, nullptr);
  const DeploymentResult other = deploy(scaled(scene, factor), 1.0 / 60, nullptr);
  EXPECT_EQ(run.outcome, other.outcome) << factor;
  EXPECT_EQ(run.pathReason, other.pathReason) << factor;
  ASSERT_EQ(run.trajectory.samples.size(), other.trajectory.samples.size()) << factor;
  EXPECT_LE(difference(run, other, factor), tolerance) << factor;
}

Scene sheet() {
  Scene scene;
  scene.model = makeTessellation({});
  return scene;
}

/// Tiles of 0.6 m, in space.
Scene cap() {
  Scene scene;
  scene.model = makeSphericalCap({.size = 4});
  return scene;
}

TEST(Scale, PowersOfTwoChangeExponentsAlone) {
  for (const double factor : {std::ldexp(1, -10), std::ldexp(1, 10)}) {
    expectSameAtScale(sheet(), factor, 0);
    expectSameAtScale(cap(), factor, 0);
  }
}

TEST(Scale, MillimetresTakeTheSamePath) {
  // Rounding grows where a closed start opens: measured 1.1e-8 and 5.3e-8.
  expectSameAtScale(sheet(), 1e-3, 1e-6);
  expectSameAtScale(cap(), 1e-3, 1e-6);
}

TEST(Scale, TorqueDampingGrowsWithTheTilesUnlessItIsGiven) {
  Scene scene = scaled(sheet(), 0.5);
  EXPECT_DOUBLE_EQ(springsOf(scene).torqueDamping, 0.5);
  scene.springs.dampsByArea = false;
  EXPECT_EQ(springsOf(scene).torqueDamping, 2);
}

}  // namespace
}  // namespace kirireel
