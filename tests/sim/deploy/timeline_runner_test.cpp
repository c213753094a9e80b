#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/timeline_runner.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

using namespace timeline;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

/// Notes what it is told to do.
struct NotingStage : TimelineStage {
  void setPinned(const std::vector<bool>& pinned) override {
    done.push_back("pinned " + std::to_string(std::count(pinned.begin(), pinned.end(), true)));
  }
  void goTo(const std::vector<Tile>* target) override { done.push_back(target ? "go" : "home"); }
  void reset() override { done.push_back("reset"); }
  void quit() override { done.push_back("quit"); }
  std::vector<std::string> done;
};

class TimelineRunnerTest : public testing::Test {
 protected:
  Model model = makeTessellation({});
  std::vector<Brick> bricks = makeBricks(model.tiles, {});
  Poses poses = startPoses(model.tiles, bricks);
  NotingStage stage;
  std::vector<Event> events;

  TimelineView viewAt(double time) { return {time, false, 1, 1, false, &poses}; }
};

TEST_F(TimelineRunnerTest, DoesWhatIsDueAtItsTime) {
  const Timeline timeline = {{{Occasion::Kind::AtTime, 0.5}, Pin{{3, 1}}},
                             {{Occasion::Kind::After, 0.25}, Unpin{}},
                             {{}, Quit{}}};
  TimelineRunner runner(timeline, bricks);
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
  const Timeline timeline = {{{Occasion::Kind::AtTime, 0.3}, Quit{}}};
  TimelineRunner runner(timeline, bricks);
  EXPECT_TRUE(runner.carryOut(viewAt(0.1 + 0.2 - 1e-12), stage, events));
}

TEST_F(TimelineRunnerTest, WaitsForRestTargetErrorAndProgress) {
  const Timeline timeline = {{{Occasion::Kind::AtRest}, Snapshot{}},
                             {{Occasion::Kind::ErrorBelow, 0.1}, Export{}},
                             {{Occasion::Kind::ProgressAbove, 0.95}, Forces{false}},
                             {{Occasion::Kind::AtTarget}, Reset{}}};
  TimelineRunner runner(timeline, bricks);
  TimelineView view = viewAt(0);
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
  EXPECT_TRUE(runner.forcesAreOn());  // a reset begins anew
  EXPECT_THAT(stage.done, ElementsAre("pinned 0", "reset"));
}

TEST_F(TimelineRunnerTest, OneStateServesOneEntry) {
  // What the first does changes the state that the second waits for.
  const Timeline timeline = {{{Occasion::Kind::AtRest}, GoTo{}},
                             {{Occasion::Kind::AtRest}, Quit{}}};
  TimelineRunner runner(timeline, bricks);
  TimelineView view = viewAt(0);
  view.atRest = true;
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_THAT(stage.done, ElementsAre("home"));
  EXPECT_TRUE(runner.carryOut(view, stage, events));
  EXPECT_THAT(stage.done, ElementsAre("home", "quit"));
}

TEST_F(TimelineRunnerTest, PausesForItsTime) {
  const Timeline timeline = {{{Occasion::Kind::AtTime, 1}, Pause{0.5}}};
  TimelineRunner runner(timeline, bricks);
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
  const Timeline timeline = {{{}, Drag{2, {}, {corner, corner + Vector3(0, 3, 0)}, 4, 10, 7}}};
  TimelineRunner runner(timeline, bricks);
  runner.carryOut(viewAt(0), stage, events);
  std::vector<Load> loads(bricks.size());
  runner.addDrags(2, poses, loads);
  const Vector3 force = loads[2].force.head<3>();
  EXPECT_LT((force - 10 * Vector3(1, 1, 0)).norm(), 1e-12);
  EXPECT_NEAR(loads[2].damping(0, 0), 7, 1e-12);
  EXPECT_TRUE(loads[1].force.isZero(0));
  // Let go at the end.
  runner.carryOut(viewAt(4), stage, events);
  loads.assign(bricks.size(), Load{});
  runner.addDrags(4, poses, loads);
  EXPECT_TRUE(loads[2].force.isZero(0));
  EXPECT_TRUE(runner.isOver(4));
}

}  // namespace
}  // namespace kirireel
