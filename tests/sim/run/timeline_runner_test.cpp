#include "sim/run/timeline_runner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

using namespace scene::timeline;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Records its calls.
struct NotingStage : run::TimelineStage {
  void setPinned(const std::vector<bool>& pinned) override {
    done.push_back("pinned " + std::to_string(std::count(pinned.begin(), pinned.end(), true)));
  }
  void goTo(const std::vector<model::Tile>* target) override {
    done.push_back(target ? "go" : "home");
  }
  void reset() override { done.push_back("reset"); }
  void quit() override { done.push_back("quit"); }
  std::vector<std::string> done;
};

class TimelineRunnerTest : public testing::Test {
 protected:
  model::Model model = generate::makeTessellation({});
  std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  Poses poses = brick::startPoses(model.tiles, bricks);
  NotingStage stage;
  std::vector<trajectory::Event> events;

  run::TimelineView viewAt(double time) { return {time, false, 1, 1, false, &poses}; }
};

TEST_F(TimelineRunnerTest, DoesWhatIsDueAtItsTime) {
  const scene::Timeline timeline = {{{scene::Trigger::Kind::AtTime, 0.5}, Pin{{3, 1}}},
                                    {{scene::Trigger::Kind::After, 0.25}, Unpin{}},
                                    {{}, Quit{}}};
  run::TimelineRunner runner(timeline, bricks);
  EXPECT_FALSE(runner.carryOut(viewAt(0.49), stage, events));
  EXPECT_TRUE(runner.carryOut(viewAt(0.5), stage, events));
  EXPECT_THAT(runner.pinnedTiles(), ElementsAre(1, 3));
  EXPECT_FALSE(runner.carryOut(viewAt(0.7), stage, events));
  EXPECT_TRUE(runner.carryOut(viewAt(0.75), stage, events));
  EXPECT_THAT(runner.pinnedTiles(), IsEmpty());
  EXPECT_THAT(stage.done, ElementsAre("pinned 2", "pinned 0", "quit"));
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0].time, 0.5);
  EXPECT_EQ(events[0].text, "pin tiles 3, 1");
  EXPECT_EQ(events[1].text, "unpin all tiles");
  EXPECT_EQ(events[2].text, "quit");
  EXPECT_TRUE(runner.isOver(0.75));
}

TEST_F(TimelineRunnerTest, TimesThatAreSumsOfStepsAreMet) {
  const scene::Timeline timeline = {{{scene::Trigger::Kind::AtTime, 0.3}, Quit{}}};
  run::TimelineRunner runner(timeline, bricks);
  EXPECT_TRUE(runner.carryOut(viewAt(0.1 + 0.2 - 1e-12), stage, events));
}

TEST_F(TimelineRunnerTest, WaitsForRestTargetErrorAndProgress) {
  const scene::Timeline timeline = {{{scene::Trigger::Kind::AtRest}, Snapshot{}},
                                    {{scene::Trigger::Kind::ErrorBelow, 0.1}, Export{}},
                                    {{scene::Trigger::Kind::ProgressAbove, 0.95}, Forces{false}},
                                    {{scene::Trigger::Kind::AtTarget}, Reset{}}};
  run::TimelineRunner runner(timeline, bricks);
  run::TimelineView view = viewAt(0);
  EXPECT_FALSE(runner.carryOut(view, stage, events));
  EXPECT_EQ(runner.pending(), "the timeline still waits for rest to snapshot");
  view.atRest = true;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  view.error = 0.09;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_TRUE(runner.forcesAreOn());
  EXPECT_FALSE(runner.carryOut(view, stage, events));
  view.error = 0.05;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_FALSE(runner.forcesAreOn());
  view.atTarget = true;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_TRUE(runner.forcesAreOn());  // a reset starts again
  EXPECT_THAT(stage.done, ElementsAre("pinned 0", "reset"));
}

TEST_F(TimelineRunnerTest, OneStateServesOneEntry) {
  // The first action changes the state for which the second waits.
  const scene::Timeline timeline = {{{scene::Trigger::Kind::AtRest}, GoTo{}},
                                    {{scene::Trigger::Kind::AtRest}, Quit{}}};
  run::TimelineRunner runner(timeline, bricks);
  run::TimelineView view = viewAt(0);
  view.atRest = true;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_THAT(stage.done, ElementsAre("home"));
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_THAT(stage.done, ElementsAre("home", "quit"));
}

TEST_F(TimelineRunnerTest, PausesForItsTime) {
  const scene::Timeline timeline = {{{scene::Trigger::Kind::AtTime, 1}, Pause{0.5}}};
  run::TimelineRunner runner(timeline, bricks);
  runner.carryOut(viewAt(1), stage, events);
  EXPECT_TRUE(runner.isPaused(1.49));
  EXPECT_FALSE(runner.isOver(1.49));
  EXPECT_FALSE(runner.isPaused(1.5));
}

TEST_F(TimelineRunnerTest, DragsAlongThePathAtEvenSpeed) {
  // Two pieces of lengths 1 and 3 in four seconds: after two, one third of the way along the
  // second.
  const Vector3 start = poses[2].position;
  const Vector3 corner = start + Vector3(1, 0, 0);
  const scene::Timeline timeline = {
      {{}, Drag{2, {}, {corner, corner + Vector3(0, 3, 0)}, 4, 10, 7}}};
  run::TimelineRunner runner(timeline, bricks);
  runner.carryOut(viewAt(0), stage, events);
  std::vector<brick::Load> loads(bricks.size());
  runner.addDrags(2, poses, loads);
  const Vector3 force = loads[2].force.head<3>();
  EXPECT_LT((force - 10 * Vector3(1, 1, 0)).norm(), 1e-12);
  EXPECT_NEAR(loads[2].damping(0, 0), 7, 1e-12);
  EXPECT_TRUE(loads[1].force.isZero(0));
  // Released at the end.
  runner.carryOut(viewAt(4), stage, events);
  loads.assign(bricks.size(), brick::Load{});
  runner.addDrags(4, poses, loads);
  EXPECT_TRUE(loads[2].force.isZero(0));
  EXPECT_TRUE(runner.isOver(4));
}

}  // namespace
}  // namespace kirireel
