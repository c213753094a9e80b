// Deployments that end within a step, against uninterrupted ones.
#include "sim/base/interruption.h"

#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::kStep;

/// Interrupts a run at its check with this number.
class InterruptAtCheck {
 public:
  explicit InterruptAtCheck(int check) : check_(check) {}

  void operator()() {
    if (InterruptionCatcher::exists() && ++checks_ == check_) throw Interrupted();
  }

 private:
  int check_;
  int checks_ = 0;
};

/// A sheet of 400 bricks with contacts, 2 s of work if not interrupted.
scene::Scene sheetThatFalls() {
  scene::Scene scene;
  scene.model = generate::makeTessellation({.columns = 20, .rows = 20});
  scene.solver.planar = false;
  scene.solver.timestep = kStep;
  scene.actuation.drive = scene::Drive::None;
  scene.environment.gravity = Vector3(1, 0.5, 0.1);
  scene.environment.contacts = scene::ContactFilter::All;
  scene.path.kind = scene::PathKind::Straight;
  scene.stop.duration = 40 * kStep;
  return scene;
}

void expectSameState(const trajectory::Sample& a, const trajectory::Sample& b) {
  EXPECT_EQ(a.time, b.time);
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].position, b.poses[i].position);
    EXPECT_EQ(a.poses[i].rotation.coeffs(), b.poses[i].rotation.coeffs());
  }
}

TEST(InterruptedStep, CountsAsNotBegun) {
  const scene::Scene scene = sheetThatFalls();
  const run::DeploymentResult whole = deploy::deploy(scene, kStep, nullptr);
  ASSERT_NE(whole.outcome, run::Outcome::Interrupted);
  for (const int check : {1, 3, 7}) {
    const InterruptionScope scope(InterruptAtCheck{check});
    const run::DeploymentResult part = deploy::deploy(scene, kStep, nullptr);
    ASSERT_EQ(part.outcome, run::Outcome::Interrupted) << check;
    const std::vector<trajectory::Sample>& samples = part.trajectory.samples;
    ASSERT_LT(samples.size(), whole.trajectory.samples.size());
    for (std::size_t k = 0; k < samples.size(); ++k) {
      expectSameState(samples[k], whole.trajectory.samples[k]);
      EXPECT_EQ(samples[k].steps.size(), whole.trajectory.samples[k].steps.size());
    }
    EXPECT_EQ(part.cost.took.steps, static_cast<long>(samples.size()) - 1);
  }
}

TEST(InterruptedSearch, ShowsTheStart) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({.columns = 30, .rows = 30});
  scene.path.kind = scene::PathKind::Auto;
  const InterruptionScope scope(InterruptAtCheck{3});
  const run::DeploymentResult result = deploy::deploy(scene, 0.1, nullptr);
  EXPECT_EQ(result.outcome, run::Outcome::Interrupted);
  ASSERT_EQ(result.trajectory.samples.size(), 1U);
  EXPECT_EQ(result.trajectory.samples.front().time, 0);
  EXPECT_EQ(result.pathReason, "the search for a path was interrupted");
}

struct EndedByTheCaller {};

TEST(Interruption, OfTheCallersOwnKindPassesThrough) {
  const scene::Scene scene = sheetThatFalls();
  const InterruptionScope scope([] { throw EndedByTheCaller(); });
  EXPECT_THROW(deploy::deploy(scene, kStep, nullptr), EndedByTheCaller);
}

}  // namespace
}  // namespace kirireel
