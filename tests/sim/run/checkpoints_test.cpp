// Continued deployments against uninterrupted ones.
#include "sim/run/checkpoints.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;
using namespace scene::timeline;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

constexpr double kInterval = 0.05;
// A checkpoint between any two samples.
constexpr run::CheckpointPace kAlways{0, std::numeric_limits<double>::infinity()};

struct Killed : std::runtime_error {
  Killed() : std::runtime_error("killed") {}
};

/// The end of a process before its run ends.
enum class Ending { Asked, Killed };

/// One process that starts or continues a deployment and ends at its sample with this number.
run::DeploymentResult runProcess(const scene::Scene& scene, const fs::path& folder,
                                 std::size_t lastSample, Ending ending,
                                 std::string* found = nullptr) {
  run::Checkpoints checkpoints(folder, "this order", kAlways);
  const std::string remark = checkpoints.find();
  if (found) *found = remark;
  std::vector<trajectory::Sample> samples;
  run::DeploymentResult result = deploy::deployUnkept(
      scene, kInterval,
      [&](const trajectory::Sample& sample) {
        samples.push_back(sample);
        if (samples.size() <= lastSample) return true;
        if (ending == Ending::Killed) throw Killed();
        return false;
      },
      {}, &checkpoints);
  result.trajectory.samples = std::move(samples);
  return result;
}

constexpr std::size_t kNoLast = std::numeric_limits<std::size_t>::max();

void expectSame(const trajectory::Sample& a, const trajectory::Sample& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.jointGap, b.jointGap);
  EXPECT_EQ(a.penetration, b.penetration);
  EXPECT_EQ(a.targetError, b.targetError);
  EXPECT_EQ(a.pinned, b.pinned);
  ASSERT_EQ(a.poses.size(), b.poses.size());
  for (std::size_t i = 0; i < a.poses.size(); ++i) {
    EXPECT_EQ(a.poses[i].position, b.poses[i].position);
    EXPECT_EQ(a.poses[i].rotation.coeffs(), b.poses[i].rotation.coeffs());
  }
}

std::vector<double> figuresOf(run::DeploymentResult result) {
  result.cost.cpuSeconds = 0;
  StateTape tape;
  tape.transfer(result.accuracy, result.cost);
  return tape.numbers();
}

void expectSame(const run::DeploymentResult& a, const run::DeploymentResult& b) {
  ASSERT_EQ(a.trajectory.samples.size(), b.trajectory.samples.size());
  for (std::size_t k = 0; k < a.trajectory.samples.size(); ++k) {
    SCOPED_TRACE(k);
    expectSame(a.trajectory.samples[k], b.trajectory.samples[k]);
    if (testing::Test::HasFailure()) return;
  }
  EXPECT_EQ(a.outcome, b.outcome);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.trajectory.events, b.trajectory.events);
  EXPECT_EQ(figuresOf(a), figuresOf(b));
}

/// Ends processes at these samples, one after the other, and completes the last one.
void expectResumedAt(const std::vector<std::size_t>& samples, const scene::Scene& scene,
                     const run::DeploymentResult& undisturbed) {
  for (const Ending ending : {Ending::Asked, Ending::Killed}) {
    const test::TemporaryFolder scratch;
    const fs::path folder = scratch / "checkpoint";
    for (const std::size_t sample : samples) {
      if (ending == Ending::Killed) {
        EXPECT_THROW(runProcess(scene, folder, sample, ending), Killed);
      } else {
        EXPECT_EQ(runProcess(scene, folder, sample, ending).outcome, run::Outcome::Interrupted);
      }
    }
    std::string found;
    const run::DeploymentResult resumed = runProcess(scene, folder, kNoLast, ending, &found);
    EXPECT_THAT(found, StartsWith("continues at"));
    expectSame(resumed, undisturbed);
  }
}

scene::Scene sheetScene(int columns, double startAngle, double targetAngle) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = shape.rows = columns;
  shape.startAngle = startAngle;
  shape.targetAngle = targetAngle;
  scene.model = generate::makeTessellation(shape);
  scene.path.kind = scene::PathKind::Straight;
  return scene;
}

run::DeploymentResult deployWhole(const scene::Scene& scene) {
  return deploy::deploy(scene, kInterval, nullptr);
}

TEST(Checkpoints, ContinueWithTouchingBricks) {
  // A sheet on the ground, under gravity, that is pulled together until its bricks touch.
  scene::Scene scene = sheetScene(3, 0.5, 0);
  for (model::Tile& tile : *scene.model.target) {
    for (Vector3& vertex : tile.vertices) vertex *= 0.9;
  }
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.brickFriction = 0.3;
  scene.environment.gravity = Vector3(0, 0, -9.81);
  scene.environment.ground = scene::Ground{0, 0.4};
  scene.stop.duration = 1.5;
  using Planar = std::optional<bool>;
  for (const auto& [planar, tolerance] :
       std::vector<std::pair<Planar, double>>{{Planar{}, 1e-3}, {Planar{false}, 0}}) {
    scene.solver.planar = planar;
    scene.solver.tolerance = tolerance;
    const run::DeploymentResult undisturbed = deployWhole(scene);
    scene::Scene withoutContacts = scene;
    withoutContacts.environment.contacts = scene::ContactFilter::None;
    // Contacts stop the bricks: metres, measured less than the thickness, 0.02.
    EXPECT_LT(undisturbed.accuracy.penetrationOutsidePivotsMax, 1e-3);
    EXPECT_GT(deployWhole(withoutContacts).accuracy.penetrationOutsidePivotsMax, 0.015);
    expectResumedAt({3, 6, 11}, scene, undisturbed);
  }
}

// Contact finders before their first call, and pins that a timeline sets.
TEST(Checkpoints, ContinueWithOverlappingBricks) {
  scene::Scene scene = sheetScene(3, 0.5, 0.2);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.environment.gravity = Vector3(0, 0, -9.81);
  scene.environment.ground = scene::Ground{0, 0.4};
  scene.solver.planar = false;
  scene.stop.duration = 0.5;
  for (const double tolerance : {0.0, 1e-3}) {
    scene.solver.tolerance = tolerance;
    for (const bool isPinned : {false, true}) {
      scene.timeline.clear();
      if (isPinned) scene.timeline.push_back({{}, Pin{{0}}});
      expectResumedAt({2, 5, 8}, scene, deployWhole(scene));
    }
  }
}

TEST(Checkpoints, ContinueAmongObstacles) {
  // A sheet that falls on a sphere and a box, over which it folds and slides.
  scene::Scene scene = sheetScene(4, 0.4, 0.8);
  scene.model.target.reset();
  scene.actuation.drive = scene::Drive::None;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.environment.gravity = Vector3(0, 0, -9.81);
  for (const double x : {-0.8, 0.8}) {
    scene::Obstacle& obstacle = scene.environment.obstacles.emplace_back();
    obstacle.shape = x < 0 ? scene::Obstacle::Shape::Sphere : scene::Obstacle::Shape::Box;
    obstacle.radius = 0.5;
    obstacle.size = Vector3(0.4, 0.4, 0.4);
    obstacle.pose.position = Vector3(x, 0.1, x < 0 ? -0.6 : -0.4);
  }
  scene.stop.duration = 1;
  const run::DeploymentResult undisturbed = deployWhole(scene);
  const auto highest = std::ranges::max(undisturbed.trajectory.samples.back().poses, {},
                                        [](const Pose& pose) { return pose.position.z(); });
  EXPECT_GT(highest.position.z(), -1);  // it lies on them; falling freely it would be at -4.9
  expectResumedAt({3, 5, 7, 9, 11, 13, 15, 17, 19}, scene, undisturbed);
}

std::vector<model::Tile> shifted(std::vector<model::Tile> tiles, double x) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex.x() += x;
  }
  return tiles;
}

/// A sheet and its twin, this far to either side of the middle.
std::vector<model::Tile> twins(const std::vector<model::Tile>& sheet, double apart) {
  std::vector<model::Tile> tiles = shifted(sheet, -apart);
  for (const model::Tile& tile : shifted(sheet, apart)) tiles.push_back(tile);
  return tiles;
}

TEST(Checkpoints, StoreWhichBricksHaveTouched) {
  // Two sheets that touch and separate. After that, the elimination is in the order of bricks that
  // have touched.
  scene::Scene scene = sheetScene(3, 0.5, 0.5);
  const std::vector<model::Tile> sheet = scene.model.tiles;
  const double reach = 0.5 * model::modelSize(scene.model);
  for (const model::Joint& joint : std::vector<model::Joint>(scene.model.joints)) {
    scene.model.joints.push_back(joint);
    scene.model.joints.back().a.tile += static_cast<int>(sheet.size());
    scene.model.joints.back().b.tile += static_cast<int>(sheet.size());
  }
  scene.model.tiles = twins(sheet, reach);
  scene.model.target = twins(sheet, 1.1 * reach);
  scene.environment.contacts = scene::ContactFilter::All;
  scene.timeline = {{{}, GoTo{"together", twins(sheet, 0.6 * reach)}},
                    {{scene::Trigger::Kind::AtTime, 1}, GoTo{}}};
  scene.stop.duration = 2;
  const run::DeploymentResult undisturbed = deployWhole(scene);
  EXPECT_LT(undisturbed.accuracy.targetErrorEnd, 0.1 * reach);
  expectResumedAt({35}, scene, undisturbed);
}

TEST(Checkpoints, StoreHowFarBricksMayOverlap) {
  // Two bricks that overlap by 0.1 separate and approach each other again. Now contacts must stop
  // them.
  scene::Scene scene;
  const auto square = [](double left) {
    return model::Tile{{{left, 0, 0}, {left + 1, 0, 0}, {left + 1, 1, 0}, {left, 1, 0}}};
  };
  scene.model.tiles = {square(0), square(0.9)};
  scene.model.target = scene.model.tiles;
  scene.path.kind = scene::PathKind::Straight;
  scene.environment.contacts = scene::ContactFilter::All;
  scene.springs.adaptive = false;
  scene.timeline = {{{}, GoTo{"apart", {square(0), square(1.1)}}},
                    {{scene::Trigger::Kind::AtTime, 1}, GoTo{}}};
  scene.stop.duration = 2;
  const run::DeploymentResult undisturbed = deployWhole(scene);
  EXPECT_GT(undisturbed.accuracy.targetErrorEnd, 0.04);  // metres, measured below 0.05
  expectResumedAt({10, 30}, scene, undisturbed);
}

TEST(Checkpoints, ContinueATimeline) {
  scene::Scene scene = sheetScene(3, 0.3, 1.5);
  const scene::Scene half = sheetScene(3, 0.8, 1.5);
  scene.timeline = {{{}, Pin{{0}}},
                    {{scene::Trigger::Kind::AtTime, 0.2}, GoTo{"half", half.model.tiles}},
                    {{scene::Trigger::Kind::AtTime, 0.4}, Drag{8, 1, {{2, 2, 0}, {2, 3, 0}}, 0.5}},
                    {{scene::Trigger::Kind::AtTime, 0.6}, Pause{0.2}},
                    {{scene::Trigger::Kind::AtTime, 1.0}, Forces{false}},
                    {{scene::Trigger::Kind::After, 0.1}, Forces{true}},
                    {{}, Unpin{}},
                    {{scene::Trigger::Kind::AtTime, 1.3}, GoTo{}},
                    {{scene::Trigger::Kind::AtTime, 1.6}, Reset{}},
                    {{scene::Trigger::Kind::AtTime, 2.2}, Quit{}}};
  const run::DeploymentResult undisturbed = deployWhole(scene);
  ASSERT_THAT(undisturbed.trajectory.events, SizeIs(11));  // and the end
  // Before the waypoint, within the drag, within the pause, after the reset.
  expectResumedAt({2, 11, 14, 22, 35}, scene, undisturbed);
}

TEST(Checkpoints, ContinueGuidesWithCompliantJoints) {
  scene::Scene scene = sheetScene(3, 0.1, 1.5);
  scene.path = {scene::PathKind::Guided, 0, 0.5, 200, 1e5};
  const run::DeploymentResult undisturbed = deployWhole(scene);
  EXPECT_GT(undisturbed.accuracy.jointOpeningMax, 0);
  EXPECT_EQ(undisturbed.outcome, run::Outcome::Settled);
  // While the tiles are guided, while joints stiffen, and as the springs grow stiffer at last.
  expectResumedAt({4, 9, 22, 33}, scene, undisturbed);
}

TEST(Checkpoints, ContinueGuidesThatOpenFirst) {
  scene::Scene scene = sheetScene(3, 0.1, 1.5);
  scene.path = {.kind = scene::PathKind::Guided, .openTime = 0.5, .guideTime = 0.5};
  const run::DeploymentResult undisturbed = deployWhole(scene);
  EXPECT_EQ(undisturbed.outcome, run::Outcome::Settled);
  // While it is opened, and while the tiles are guided.
  expectResumedAt({4, 14}, scene, undisturbed);
}

TEST(Checkpoints, ContinueGuidesFromAWaypoint) {
  scene::Scene scene = sheetScene(3, 0.1, 1.5);
  const scene::Scene half = sheetScene(3, 0.8, 1.5);
  scene.path = {scene::PathKind::Guided, 0, 0.5, 200, 1e5};
  scene.timeline = {{{}, GoTo{"half", half.model.tiles}},
                    {{scene::Trigger::Kind::AtTime, 2}, GoTo{}}};
  scene.stop.duration = 4;
  expectResumedAt({45, 47}, scene, deployWhole(scene));
}

TEST(Checkpoints, DoNotRepeatATrial) {
  scene::Scene scene = sheetScene(3, 0, 3.14159265358979323846);
  scene.path.kind = scene::PathKind::Dynamic;
  scene.springs.springStiffness = 400;  // distances outweigh rotations: a straight pull locks
  scene.springs.torqueStiffness = 10;
  const run::DeploymentResult undisturbed = deployWhole(scene);
  const test::TemporaryFolder scratch;
  const fs::path folder = scratch / "checkpoint";
  {
    run::Checkpoints checkpoints(folder, "this order");
    // The straight path was tried. The interruption comes during the next search.
    int calls = 0;
    deploy::deployUnkept(
        scene, kInterval, [](const trajectory::Sample&) { return true; },
        [&](const run::SearchNews& news) {
          return !news.what.starts_with("motion of each tile") || ++calls < 9;
        },
        &checkpoints);
    EXPECT_EQ(calls, 9);
    EXPECT_TRUE(checkpoints.straightPull());
  }
  run::Checkpoints checkpoints(folder, "this order");
  EXPECT_EQ(checkpoints.find(),
            "continues the search for a path from the checkpoint in " + folder.string());
  EXPECT_TRUE(checkpoints.straightPull());
  const double earlierSeconds = checkpoints.searchSeconds();
  EXPECT_GT(earlierSeconds, 0);
  expectResumedAt({5}, scene, undisturbed);
  std::string found;
  const run::DeploymentResult resumed = runProcess(scene, folder, kNoLast, Ending::Asked, &found);
  expectSame(resumed, undisturbed);
  EXPECT_GT(resumed.cost.cpuSecondsSearch, earlierSeconds);
  EXPECT_THAT(found, HasSubstr("the search"));
}

TEST(Checkpoints, StayIfARunEndsBeforeTheirTime) {
  const scene::Scene scene = sheetScene(3, 0.3, 1.5);
  const run::DeploymentResult undisturbed = deployWhole(scene);
  const test::TemporaryFolder scratch;
  const fs::path folder = scratch / "checkpoint";
  runProcess(scene, folder, 20, Ending::Asked);
  const run::DeploymentResult early = runProcess(scene, folder, 5, Ending::Asked);
  EXPECT_EQ(early.outcome, run::Outcome::Interrupted);
  // Its report holds for the samples that it delivered.
  EXPECT_EQ(early.accuracy.targetErrorEnd, early.trajectory.samples.back().targetError);
  EXPECT_NEAR(early.trajectory.events.back().time, 5 * kInterval, 1e-9);
  std::string found;
  expectSame(runProcess(scene, folder, kNoLast, Ending::Asked, &found), undisturbed);
  EXPECT_THAT(found, StartsWith("continues at 1 s"));
}

TEST(Checkpoints, AreNotMadeOfARunByAnEngine) {
  scene::Scene scene = sheetScene(3, 0.3, 1.5);
  scene.solver.kind = scene::SolverKind::Bullet;
  const test::TemporaryFolder scratch;
  runProcess(scene, scratch / "checkpoint", 5, Ending::Asked);
  EXPECT_TRUE(scratch.isEmpty());
}

TEST(Checkpoints, AreNotMadeTooOften) {
  const test::TemporaryFolder scratch;
  run::Checkpoints patient(scratch / "checkpoint", "this order", {3600, 1});
  EXPECT_FALSE(patient.isDue());
  run::Checkpoints eager(scratch / "checkpoint", "this order", kAlways);
  EXPECT_TRUE(eager.isDue());
  // Measured: 1 part in 10^9 of the time to the next.
  run::Checkpoints thrifty(scratch / "checkpoint", "this order", {0, 1e-9});
  EXPECT_TRUE(thrifty.isDue());
  thrifty.save({});
  EXPECT_FALSE(thrifty.isDue());
}

/// A checkpoint of an interrupted run.
class LeftCheckpoint : public testing::Test {
 protected:
  void SetUp() override {
    EXPECT_THROW(runProcess(scene_, folder_, 6, Ending::Killed), Killed);
    ASSERT_TRUE(fs::exists(folder_ / "samples_00005.h5"));
  }

  /// Expects that a run starts from the beginning and reports the reason.
  void expectRestart(const std::string& why) {
    std::string found;
    const run::DeploymentResult result =
        runProcess(scene_, folder_, kNoLast, Ending::Asked, &found);
    EXPECT_EQ(found, "the checkpoint in " + folder_.string() + why);
    expectSame(result, deployWhole(scene_));
  }

  /// Flips one byte after the other in a file of the checkpoint. Undetected changes must have no
  /// effect: HDF5 has unused bytes. Returns the number of detected changes.
  int flipBytes(const std::string& name, std::size_t stride) {
    const std::string bytes = test::bytesOf(folder_ / name);
    const std::vector<double> whole = numbersOf(folder_);
    const fs::path copy = scratch_ / "copy";
    int noticed = 0;
    for (std::size_t place = 0; place < bytes.size(); place += stride) {
      fs::copy(folder_, copy, fs::copy_options::overwrite_existing);
      std::string flipped = bytes;
      flipped[place] = static_cast<char>(~flipped[place]);
      std::ofstream(copy / name, std::ios::binary) << flipped;
      const std::vector<double> numbers = numbersOf(copy);
      noticed += numbers.empty() ? 1 : 0;
      EXPECT_TRUE(numbers.empty() || numbers == whole) << place;
    }
    return noticed;
  }

  /// The state and the samples of a checkpoint; absent if it is not used.
  static std::vector<double> numbersOf(const fs::path& folder) {
    run::Checkpoints checkpoints(folder, "this order");
    checkpoints.find();
    if (!checkpoints.run()) return {};
    std::vector<double> numbers = checkpoints.run()->numbers;
    checkpoints.playSamples([&](StateTape& tape) {
      double number = 0;
      tape.transfer(number);
      numbers.push_back(number);
      return true;
    });
    return numbers;
  }

  const std::string damaged_ = " is damaged or incomplete. The run starts from the beginning";
  scene::Scene scene_ = sheetScene(3, 0.3, 1.5);
  test::TemporaryFolder scratch_;
  fs::path folder_ = scratch_ / "checkpoint";
};

TEST_F(LeftCheckpoint, ThatIsDamagedAnywhereIsNotUsed) {
  EXPECT_GT(flipBytes("state.h5", 37), 50);
  EXPECT_GT(flipBytes("samples_00003.h5", 37), 50);
}

TEST_F(LeftCheckpoint, ThatIsCutShortIsNotUsed) {
  fs::resize_file(folder_ / "state.h5", 100);
  expectRestart(damaged_);
}

TEST_F(LeftCheckpoint, WithoutAllOfItsSamplesIsNotUsed) {
  fs::remove(folder_ / "samples_00002.h5");
  expectRestart(damaged_);
}

TEST_F(LeftCheckpoint, OfAnotherOrderIsNotUsed) {
  run::Checkpoints other(folder_, "another order");
  EXPECT_EQ(other.find(),
            "the checkpoint in " + folder_.string() +
                " is from another order or program version. The run starts from the beginning");
  EXPECT_EQ(other.run(), nullptr);
  EXPECT_TRUE(scratch_.isEmpty());
}

TEST_F(LeftCheckpoint, BehindALinkIsNotUsed) {
  fs::rename(folder_, scratch_ / "elsewhere");
  fs::create_directory_symlink(scratch_ / "elsewhere", folder_);
  run::Checkpoints checkpoints(folder_, "this order");
  EXPECT_EQ(checkpoints.find(), "");
  EXPECT_FALSE(fs::exists(fs::symlink_status(folder_)));
  EXPECT_TRUE(fs::exists(scratch_ / "elsewhere/state.h5"));
}

}  // namespace
}  // namespace kirireel
