#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

bool sameBytes(const Trajectory& a, const Trajectory& b) {
  if (a.samples.size() != b.samples.size()) return false;
  for (std::size_t s = 0; s < a.samples.size(); ++s) {
    for (std::size_t i = 0; i < a.bricks.size(); ++i) {
      const Pose& poseA = a.samples[s].poses[i];
      const Pose& poseB = b.samples[s].poses[i];
      if (poseA.position != poseB.position) return false;
      if (poseA.rotation.coeffs() != poseB.rotation.coeffs()) return false;
    }
  }
  return true;
}

Scene sheet(bool planar, SolverKind kind) {
  Scene scene;
  scene.model = makeTessellation({});
  scene.solver.planar = planar;
  scene.solver.kind = kind;
  scene.stop.duration = 0.5;
  return scene;
}

TEST(DeployTwice, GivesTheSameBytes) {
  for (const SolverKind kind : {SolverKind::Direct, SolverKind::Bullet}) {
    for (const bool planar : {true, false}) {
      const Scene scene = sheet(planar, kind);
      EXPECT_TRUE(sameBytes(deploy(scene, 0.05, nullptr).trajectory,
                            deploy(scene, 0.05, nullptr).trajectory));
    }
  }
}

TEST(DeployTwice, AnotherSeedTakesAnotherWayFromASingularStart) {
  Scene scene = sheet(true, SolverKind::Direct);
  const Trajectory first = deploy(scene, 0.05, nullptr).trajectory;
  scene.solver.seed = 2;
  EXPECT_FALSE(sameBytes(first, deploy(scene, 0.05, nullptr).trajectory));
}

}  // namespace
}  // namespace kirireel
