#include "sim/trajectory/trajectory_file.h"

#include <cmath>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/array_file.h"
#include "tests/support/files.h"
#include "tests/support/pair_forces.h"
#include "tests/support/program.h"
#include "tests/support/refusal.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using test::bytesOf;
using test::hasProgram;
using test::outputOf;
using test::TemporaryFolder;
using ::testing::HasSubstr;

/// A pin and a neck of random bits.
std::vector<brick::Ligament> randomLigaments(std::mt19937_64& generator) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vector3(uniform(generator), uniform(generator), 1e-300); };
  brick::Ligament pin{0, 4, 3, vector(), vector(), Vector3::Zero(), vector().normalized()};
  pin.stretchStiffness = uniform(generator);
  pin.shearStiffness = uniform(generator);
  pin.opening = {uniform(generator), uniform(generator)};
  brick::Ligament neck{5, 1, 2, vector(), vector(), vector(), Vector3::UnitY()};
  neck.stretchStiffness = 1e300;
  return {pin, neck};
}

/// Poses of random bits, which show any lost digit.
trajectory::Trajectory randomTrajectory(int samples) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  scene.environment.ground = scene::Ground{-0.25, 0.125};
  scene.brick.thickness = 0.1;
  scene::Obstacle sphere;
  sphere.shape = scene::Obstacle::Shape::Sphere;
  scene.environment.obstacles = {scene::Obstacle{}, sphere};
  trajectory::Trajectory trajectory{trajectory::subjectOf(scene)};
  trajectory.settings = "{\"seed\": 1, \"name\": \"Ångström\"}";
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int k = 0; k < samples; ++k) {
    trajectory::Sample sample;
    sample.time = k / 60.0;
    for (std::size_t i = 0; i < trajectory.bricks.size(); ++i) {
      const auto vector = [&] { return Vector3(uniform(generator), uniform(generator), 1e-300); };
      sample.poses.push_back({vector(), rotationFromVector(vector())});
    }
    sample.jointGap = uniform(generator);
    sample.targetError = uniform(generator);
    sample.penetration = uniform(generator);
    for (int step = std::max(0, 4 * k - 3); step <= 4 * k; ++step) {
      sample.steps.push_back({step == 4 * k ? sample.time : step / 240.0, uniform(generator),
                              uniform(generator), uniform(generator), 2, 1, 0, 7});
    }
    const auto vector = [&] { return Vector3(uniform(generator), uniform(generator), 1e300); };
    trajectory::Mechanics& mechanics = sample.mechanics.emplace();
    mechanics.energies = {uniform(generator), 1, 3, uniform(generator), 2, uniform(generator)};
    for (std::size_t j = 0; j < trajectory.model.joints.size(); ++j) {
      mechanics.jointForces.push_back(vector());
      mechanics.isIndeterminate.push_back((k + j) % 3 == 0);
    }
    for (int h = 0; h < k % 3; ++h) {
      mechanics.holds.push_back(
          {static_cast<trajectory::HoldKind>(h), 2, h - 3, vector(), vector(), vector()});
    }
    trajectory.samples.push_back(sample);
  }
  for (const char* name : {"joint_gap_max", "penetration_max"}) {
    trajectory.figureStates.push_back({name, 0.125, trajectory.samples.back().poses});
  }
  trajectory.findings = "{\"path\": \"straight\"}";
  trajectory.events = {{0.25, "paused"}, {1.5, "settled: came to rest 1e-7 from the target"}};
  return trajectory;
}

template <HasFields Struct>
void expectSame(const Struct& a, const Struct& b);

void expectSameValue(const Quaternion& a, const Quaternion& b, const char* name) {
  EXPECT_EQ(a.coeffs(), b.coeffs()) << name;
}
void expectSameValue(const StepReport& a, const StepReport& b, const char* name) {
  for (const StepFigure& figure : kStepFigures) {
    EXPECT_EQ(figure.get(a), figure.get(b)) << name << ", " << figure.name;
  }
}
template <typename Value>
void expectSameValue(const Value& a, const Value& b, const char* name) {
  if constexpr (HasFields<Value>) {
    expectSame(a, b);
  } else {
    EXPECT_EQ(a, b) << name;
  }
}
template <HasFields Value>
void expectSameValue(const std::vector<Value>& a, const std::vector<Value>& b, const char* name) {
  ASSERT_EQ(a.size(), b.size()) << name;
  for (std::size_t k = 0; k < a.size(); ++k) expectSame(a[k], b[k]);
}
template <HasFields Value>
void expectSameValue(const std::optional<Value>& a, const std::optional<Value>& b,
                     const char* name) {
  ASSERT_EQ(a.has_value(), b.has_value()) << name;
  if (a) expectSame(*a, *b);
}

/// All that the struct describes.
template <HasFields Struct>
void expectSame(const Struct& a, const Struct& b) {
  forEachField(a, [&](const auto& field, const auto& value) {
    expectSameValue(value, b.*field.member, field.name);
  });
}

void expectSameSubject(const trajectory::Subject& a, const trajectory::Subject& b) {
  EXPECT_EQ(a.model.name, b.model.name);
  expectSameValue(a.model.tiles, b.model.tiles, "tiles");
  ASSERT_EQ(a.model.target.has_value(), b.model.target.has_value());
  if (a.model.target) expectSameValue(*a.model.target, *b.model.target, "target");
  EXPECT_EQ(a.model.pulledTiles, b.model.pulledTiles);
  EXPECT_EQ(a.model.foldAngles, b.model.foldAngles);
  expectSameValue(a.model.joints, b.model.joints, "joints");
  expectSameValue(a.obstacles, b.obstacles, "obstacles");
  expectSame(a.brickRule, b.brickRule);
  EXPECT_EQ(a.ground.has_value(), b.ground.has_value());
  EXPECT_EQ(a.settings, b.settings);
  expectSameValue(brick::ligamentsOf(a.pairForces), brick::ligamentsOf(b.pairForces), "ligaments");
}

/// Panels of random bits, with a node for each vertex.
trajectory::LoadedPanels randomPanels(const std::vector<model::Tile>& tiles) {
  std::mt19937_64 generator(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  trajectory::LoadedPanels sheet;
  int nodes = 0;
  for (const model::Tile& tile : tiles) {
    std::vector<int>& numbers = sheet.tileNodes.emplace_back();
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) numbers.push_back(nodes++);
  }
  sheet.bars = {{0, 1, uniform(generator), uniform(generator)}, {1, 2, 1e-300, 1e300}};
  sheet.folds = {{{0, 1, 2, 3}, uniform(generator), uniform(generator), {2, 5}}};
  for (const double time : {0.0, 0.5, 0.5}) {
    trajectory::PanelState& state = sheet.states.emplace_back();
    state.time = time;
    for (int n = 0; n < nodes; ++n) {
      state.nodes.emplace_back(uniform(generator), uniform(generator), 1e-300);
    }
    state.strains = {uniform(generator), uniform(generator)};
    state.angles = {uniform(generator)};
  }
  return sheet;
}

std::string refusalOf(const std::filesystem::path& file) {
  return test::refusalOf<InputError>([&] { test::readTrajectory(file); });
}

TEST(TrajectoryFile, KeepsEveryBit) {
  const TemporaryFolder folder;
  trajectory::Trajectory written = randomTrajectory(7);
  written.model.rounding = 1e-6;
  written.model.pulledTiles = {0, 3};
  written.model.foldAngles = {{{0, 1}, 0.5}, {{1, 0}, 0.5}};
  std::mt19937_64 generator(2);
  written.pairForces = test::pairForces({}, randomLigaments(generator));
  written.model.joints[3].neck = {0.1, 1e-300, 1.0 / 3};
  written.model.joints.push_back(model::makeFixedJoint(written.model.tiles, 0, 5));
  for (trajectory::Sample& sample : written.samples) {
    sample.mechanics->jointForces.emplace_back(1, 2, 3);
    sample.mechanics->isIndeterminate.push_back(true);
  }
  test::writeTrajectory(written, folder / "run.h5");
  const trajectory::Trajectory read = test::readTrajectory(folder / "run.h5");
  expectSameSubject(read, written);
  expectSameValue(read.bricks, written.bricks, "bricks");
  EXPECT_EQ(read.model.rounding, 1e-6);
  EXPECT_EQ(read.ground->height, -0.25);
  EXPECT_EQ(read.ground->friction, 0.125);
  EXPECT_EQ(read.events, written.events);
  EXPECT_EQ(read.findings, written.findings);
  expectSameValue(read.figureStates, written.figureStates, "figures");
  ASSERT_EQ(read.samples.size(), 7U);
  for (std::size_t k = 0; k < 7; ++k) expectSame(read.samples[k], written.samples[k]);
}

TEST(TrajectoryFile, KeepsEveryBitOfPanels) {
  const TemporaryFolder folder;
  trajectory::Trajectory written = randomTrajectory(3);
  const trajectory::LoadedPanels a = randomPanels(written.model.tiles);
  written.panels = std::make_shared<const trajectory::LoadedPanels>(a);
  test::writeTrajectory(written, folder / "run.h5");
  const trajectory::TrajectoryReader reader(folder / "run.h5");
  ASSERT_TRUE(reader.end().panels);
  const trajectory::LoadedPanels& b = *reader.end().panels;
  EXPECT_EQ(a.tileNodes, b.tileNodes);
  ASSERT_EQ(a.bars.size(), b.bars.size());
  for (std::size_t k = 0; k < a.bars.size(); ++k) {
    EXPECT_EQ(a.bars[k].nodeA, b.bars[k].nodeA);
    EXPECT_EQ(a.bars[k].nodeB, b.bars[k].nodeB);
    EXPECT_EQ(a.bars[k].rest, b.bars[k].rest);
    EXPECT_EQ(a.bars[k].stiffness, b.bars[k].stiffness);
  }
  ASSERT_EQ(b.folds.size(), 1u);
  EXPECT_EQ(a.folds[0].nodes, b.folds[0].nodes);
  EXPECT_EQ(a.folds[0].tiles, b.folds[0].tiles);
  EXPECT_EQ(a.folds[0].stiffness, b.folds[0].stiffness);
  EXPECT_EQ(a.folds[0].rest, b.folds[0].rest);
  ASSERT_EQ(a.states.size(), b.states.size());
  for (std::size_t k = 0; k < a.states.size(); ++k) {
    EXPECT_EQ(a.states[k].time, b.states[k].time);
    EXPECT_EQ(a.states[k].nodes, b.states[k].nodes);
    EXPECT_EQ(a.states[k].strains, b.states[k].strains);
    EXPECT_EQ(a.states[k].angles, b.states[k].angles);
  }
}

// The FOLD text of the model that is read is that of the model that was written: two squares whose
// common edge has an angle, a vertex in no face, and two targets.
TEST(TrajectoryFile, KeepsTheSheetOfAFoldFile) {
  const TemporaryFolder folder;
  folder.write("a.fold", R"({"file_spec": 1.1, "frame_unit": "mm", "vertices_coords":
      [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1],[9,9]], "faces_vertices": [[0,1,4,5],[1,2,3,4]],
      "edges_vertices": [[4,1],[0,1],[4,5],[5,0],[1,2],[2,3],[3,4]],
      "edges_assignment": ["V","B","B","B","B","B","C"],
      "edges_foldAngle": [30,null,0,0,0,0,0],
      "file_frames": [{"frame_inherit": true, "vertices_coords":
      [[0,0,0],[1,0,0],[1,0,1],[1,1,1],[1,1,0],[0,1,0],[9,9,0]]}, {"frame_inherit": true,
      "vertices_coords": [[0,0,0],[1,0,0],[2,0,0],[2,1,0],[1,1,0],[0,1,0],[9,9,0]]}]})");
  std::vector<std::string> warnings;
  scene::Scene scene;
  scene.model = formats::readModel(folder / "a.fold", std::nullopt, warnings);
  trajectory::Trajectory run{trajectory::subjectOf(scene)};
  run.samples.emplace_back().poses = brick::startPoses(run.model.tiles, run.bricks);
  test::writeTrajectory(run, folder / "run.h5");
  const model::Model read = test::readTrajectory(folder / "run.h5").model;
  EXPECT_EQ(formats::foldText(read), formats::foldText(scene.model));
  const std::vector<formats::FoldState> states = {{"t = 0 s", {}}, {"t = 1 s", scene.model.tiles}};
  EXPECT_EQ(formats::foldText(read, states), formats::foldText(scene.model, states));
  EXPECT_EQ(read.waypoints.size(), 1U);
}

TEST(TrajectoryFile, RefusesOtherVersions) {
  const TemporaryFolder folder;
  for (const double version : {0.0, 4.0, 6.0}) {
    trajectory::ArrayWriter file(folder / "run.h5", folder / "run.h5");
    file.setAttribute("/", "format", std::string(trajectory::layout::kFormat));
    file.setAttribute("/", "format_version", version);
    file.close();
    EXPECT_THAT(refusalOf(folder / "run.h5"),
                HasSubstr(fmt::format("error: the format's version is {:g}, but this program reads "
                                      "5. Give a complete trajectory.h5",
                                      version)));
  }
}

TEST(TrajectoryFile, RefusesStepsThatDoNotFit) {
  const TemporaryFolder folder;
  trajectory::Trajectory written = randomTrajectory(3);
  std::swap(written.samples[1].steps[0], written.samples[1].steps[1]);
  test::writeTrajectory(written, folder / "run.h5");
  EXPECT_THAT(test::refusalOf<InputError>([&] { test::readTrajectory(folder / "run.h5"); }),
              HasSubstr("the times of the steps do not increase"));
}

TEST(TrajectoryFile, LeavesOutWhatIsAbsent) {
  const TemporaryFolder folder;
  trajectory::Trajectory written = randomTrajectory(1);
  written.model.target.reset();
  written.model.joints.clear();
  written.ground.reset();
  written.events.clear();
  test::writeTrajectory(written, folder / "run.h5");
  const trajectory::Trajectory read = test::readTrajectory(folder / "run.h5");
  expectSameSubject(read, written);
  EXPECT_TRUE(read.events.empty());
}

TEST(TrajectoryFile, GivesAnySampleInAnyOrder) {
  const TemporaryFolder folder;
  const trajectory::Trajectory written = randomTrajectory(2500);  // several chunks
  test::writeTrajectory(written, folder / "run.h5");
  const trajectory::TrajectoryReader reader(folder / "run.h5");
  EXPECT_EQ(reader.times().size(), 2500U);
  for (const std::size_t k : {2499, 0, 1024, 1023, 7}) {
    expectSame(reader.sample(k), written.samples[k]);
  }
}

TEST(TrajectoryFile, HasTheSameBytesInTwoRuns) {
  const TemporaryFolder folder;
  test::writeTrajectory(randomTrajectory(30), folder / "first.h5");
  test::writeTrajectory(randomTrajectory(30), folder / "second.h5");
  EXPECT_TRUE(bytesOf(folder / "first.h5") == bytesOf(folder / "second.h5"));
}

TEST(TrajectoryFile, LeavesNothingWhenAbandoned) {
  const TemporaryFolder folder;
  {
    const trajectory::Trajectory trajectory = randomTrajectory(1);
    trajectory::TrajectoryWriter writer(folder / "run.h5", trajectory);
    writer.append(trajectory.samples.front());
  }
  EXPECT_TRUE(folder.isEmpty());
}

TEST(TrajectoryFile, OpensInPython) {
  if (outputOf("/usr/bin/python3 -c 'import h5py; print(1)'").empty()) {
    GTEST_SKIP() << "install python3-h5py to check trajectories with another program";
  }
  const TemporaryFolder folder;
  const trajectory::Trajectory written = randomTrajectory(50);
  test::writeTrajectory(written, folder / "run.h5");
  std::ofstream(folder / "read.py") << R"(
import h5py, sys
f = h5py.File(sys.argv[1])
text = lambda owner, name: owner.attrs[name].decode()
print(text(f, "format"), f.attrs["format_version"], text(f["model"], "name"))
print(f["position"].shape, f["position"].dtype, text(f["position"], "unit"))
print(f["rotation"].shape, f["model/joints"].shape, f["events/text"].asstr()[0])
print(f["position"][49, 15, 1].hex(), f["rotation"][0, 2, 0].hex())
print(f["settings"].asstr()[0])
)";
  const std::string text = outputOf("/usr/bin/python3 '" + (folder / "read.py").string() + "' '" +
                                    (folder / "run.h5").string() + "'");
  EXPECT_THAT(text, HasSubstr("kirireel trajectory 5.0 " + written.model.name + "\n"));
  EXPECT_THAT(text, HasSubstr("(50, 16, 3) float64 m\n(50, 16, 4) (24, 6) paused\n"));
  // Python's hex() of a double reads back exactly; strtod reads it.
  const std::size_t at = text.find("paused\n") + 7;
  char* next = nullptr;
  EXPECT_EQ(std::strtod(text.c_str() + at, &next), written.samples[49].poses[15].position.y());
  EXPECT_EQ(std::strtod(next, nullptr), written.samples[0].poses[2].rotation.w());
  EXPECT_THAT(text, HasSubstr("Ångström"));
}

TEST(TrajectoryFile, RefusesAMissingOrForeignFile) {
  const TemporaryFolder folder;
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  const std::filesystem::path file = folder / "run.h5";
  EXPECT_EQ(
      refusalOf(file),
      file.string() + ": error: there is no such file. Give a trajectory.h5 from kirireel record");
  std::ofstream(file) << "0 0 0 1 0 0 1 1 0\n";
  EXPECT_EQ(refusalOf(file), file.string() + ": error: this is not an HDF5 file" + advice);
  trajectory::ArrayWriter(file, file).close();
  EXPECT_EQ(refusalOf(file),
            file.string() + ": error: this HDF5 file is not a trajectory" + advice);
}

TEST(TrajectoryFile, RefusesAFileThatIsCutShort) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "run.h5";
  test::writeTrajectory(randomTrajectory(200), file);
  const auto whole = std::filesystem::file_size(file);
  for (const double share : {0.99, 0.5, 0.1, 0.001}) {
    std::filesystem::resize_file(file, static_cast<std::uintmax_t>(share * whole));
    EXPECT_THAT(refusalOf(file), HasSubstr("run.h5: error: ")) << share;
    EXPECT_THAT(refusalOf(file), HasSubstr(". Give a complete trajectory.h5")) << share;
  }
}

TEST(TrajectoryFile, NoticesAChangedByteAmongThePoses) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder / "run.h5";
  test::writeTrajectory(randomTrajectory(200), file);
  const std::string whole = bytesOf(file);
  for (const double share : {0.4, 0.5, 0.6, 0.7}) {  // nearly all of the file are poses
    std::string bytes = whole;
    bytes[static_cast<std::size_t>(share * bytes.size())] ^= 1;
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
    EXPECT_THAT(refusalOf(file), HasSubstr(" is damaged. Give a complete trajectory.h5")) << share;
  }
}

/// A trajectory's file with one array replaced.
template <typename Change>
std::string refusalAfter(const Change& change) {
  const TemporaryFolder folder;
  trajectory::Trajectory trajectory = randomTrajectory(3);
  change(trajectory);
  test::writeTrajectory(trajectory, folder / "run.h5");
  const std::string message = refusalOf(folder / "run.h5");
  return message.substr(std::min(message.size(), message.find("error: ")));
}

TEST(TrajectoryFile, RefusesContradictions) {
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.samples.clear(); }),
            "error: there are no samples" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.samples[2].time = 0; }),
            "error: the times of the samples do not increase" + advice);
  EXPECT_EQ(
      refusalAfter([](trajectory::Trajectory& t) { t.samples[1].poses[2].position.x() = NAN; }),
      "error: a pose in position or rotation is not finite, or not a rotation" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.samples[1].poses[2].rotation.w() = 3; }),
            "error: a pose in position or rotation is not finite, or not a rotation" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.model.joints[0].b.vertex = 4; }),
            "error: model/joints names vertex 4 of tile " +
                std::to_string(generate::makeTessellation({}).joints[0].b.tile) +
                ", which does not exist" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) {
              t.model.joints[0].face = static_cast<model::JointFace>(7);
            }),
            "error: model/joints has the face 7 instead of 1 to 3" + advice);
  EXPECT_EQ(
      refusalAfter([](trajectory::Trajectory& t) { t.model.target->pop_back(); }),
      "error: the array model/target has 180 entries instead of 192, or another shape" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.bricks[3].normal *= 2; }),
            "error: the normal of brick 3 in bricks/normal is not a unit vector" + advice);
  for (const std::size_t sample : {0, 1, 2}) {
    EXPECT_EQ(refusalAfter([&](trajectory::Trajectory& t) { t.samples[sample].time = NAN; }),
              "error: the times of the samples do not increase" + advice);
  }
  EXPECT_EQ(
      refusalAfter([](trajectory::Trajectory& t) { t.samples[1].poses[2].position.x() = -1e300; }),
      "error: a brick in position is more than 1e+19 m away" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.model.tiles[0].vertices.clear(); }),
            "error: a tile in model/tile_sizes has 0 vertices" + advice);
}

TEST(TrajectoryFile, RefusesPanelsThatContradict) {
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  const auto refusal = [](const std::function<void(trajectory::LoadedPanels&)>& change) {
    return refusalAfter([&](trajectory::Trajectory& t) {
      trajectory::LoadedPanels sheet = randomPanels(t.model.tiles);
      change(sheet);
      t.panels = std::make_shared<const trajectory::LoadedPanels>(std::move(sheet));
    });
  };
  EXPECT_EQ(refusal([](trajectory::LoadedPanels& sheet) { sheet.tileNodes.pop_back(); }),
            "error: panels/vertex_node does not have a node for each vertex" + advice);
  EXPECT_EQ(refusal([](trajectory::LoadedPanels& sheet) { sheet.bars[1].nodeB = 64; }),
            "error: panels/bar_nodes does not have 2 indices below 64 in each row" + advice);
  EXPECT_EQ(refusal([](trajectory::LoadedPanels& sheet) { sheet.folds[0].tiles[1] = -1; }),
            "error: panels/fold_tiles does not have 2 indices below 16 in each row" + advice);
  EXPECT_EQ(refusal([](trajectory::LoadedPanels& sheet) { sheet.states[1].time = -1; }),
            "error: the times of the panels decrease" + advice);
  EXPECT_EQ(refusal([](trajectory::LoadedPanels& sheet) { sheet.states[2].strains[0] = NAN; }),
            "error: the array panels/bar_strain has a number that is not finite" + advice);
}

TEST(TrajectoryFile, RefusesLigamentsOfNoJoint) {
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  const auto refusalWith = [](const auto& change) {
    return refusalAfter([&](trajectory::Trajectory& t) {
      std::mt19937_64 generator(2);
      std::vector<brick::Ligament> ligaments = randomLigaments(generator);
      change(ligaments[1]);
      t.pairForces = test::pairForces({}, ligaments);
    });
  };
  EXPECT_EQ(refusalWith([](brick::Ligament& l) { l.brickB = 16; }),
            "error: model/joints names vertex 0 of tile 16, which does not exist" + advice);
  const std::string noJoint =
      "error: ligaments/joint does not name a joint of the model for each ligament" + advice;
  EXPECT_EQ(refusalWith([](brick::Ligament& l) { l.joint = 24; }), noJoint);
  EXPECT_EQ(refusalWith([](brick::Ligament& l) { l.joint = -1; }), noJoint);
  EXPECT_EQ(refusalWith([](brick::Ligament& l) { l.across *= 2; }),
            "error: the direction of ligament 1 in ligaments/across is not a unit vector" + advice);
  EXPECT_EQ(refusalWith([](brick::Ligament& l) { l.shearStiffness = NAN; }),
            "error: the array ligaments/shear has a number that is not finite" + advice);
}

TEST(TrajectoryFile, RefusesBricksThatAreNotSolid) {
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  EXPECT_EQ(
      refusalAfter([](trajectory::Trajectory& t) { t.bricks[3].thickness = 0; }),
      "error: the thickness of brick 3 in bricks/thickness is 0, but must be positive" + advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.bricks[3].thickness = -0.02; }),
            "error: the thickness of brick 3 in bricks/thickness is -0.02, but must be positive" +
                advice);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.bricks[1].mass = 0; }),
            "error: the mass of brick 1 in bricks/mass is 0, but must be positive" + advice);
  const std::string insideOut =
      "error: brick 2 is inverted: bricks/bottom, bricks/top and bricks/normal are inconsistent" +
      advice;
  EXPECT_EQ(refusalAfter(
                [](trajectory::Trajectory& t) { std::swap(t.bricks[2].bottom, t.bricks[2].top); }),
            insideOut);
  EXPECT_EQ(refusalAfter([](trajectory::Trajectory& t) { t.bricks[2].normal *= -1; }), insideOut);
  EXPECT_EQ(
      refusalAfter([](trajectory::Trajectory& t) { std::ranges::reverse(t.bricks[2].bottom); }),
      insideOut);
}

/// The error for a trajectory file after lines of Python that change `f`, the file in h5py.
std::string refusalAfterPython(const std::string& lines) {
  const TemporaryFolder folder;
  test::writeTrajectory(randomTrajectory(3), folder / "run.h5");
  std::ofstream(folder / "change.py") << "import h5py, sys\nf = h5py.File(sys.argv[1], 'r+')\n"
                                      << lines << "\nf.close()\nprint('changed')\n";
  EXPECT_EQ(outputOf("/usr/bin/python3 '" + (folder / "change.py").string() + "' '" +
                     (folder / "run.h5").string() + "'"),
            "changed\n");
  const std::string message = refusalOf(folder / "run.h5");
  return message.substr(std::min(message.size(), message.find("error: ")));
}

TEST(TrajectoryFile, RefusesStatesThatItsWriterNeverMakes) {
  if (outputOf("/usr/bin/python3 -c 'import h5py; print(1)'").empty()) {
    GTEST_SKIP() << "install python3-h5py to change trajectories by another program";
  }
  const std::string advice = ". Give a complete trajectory.h5 from kirireel record";
  EXPECT_EQ(refusalAfterPython("del f['time']; f['time'] = h5py.ExternalLink('/etc/passwd', '/')"),
            "error: the array time is missing" + advice);
  EXPECT_EQ(
      refusalAfterPython("f['t'] = f['time']; del f['time']; f['time'] = h5py.SoftLink('/t')"),
      "error: the array time is missing" + advice);
  EXPECT_EQ(refusalAfterPython("del f['time']\n"
                               "f.create_dataset('time', (3,), '<f8', external=[('x', 0, 24)])"),
            "error: the array time has another layout" + advice);
  EXPECT_EQ(refusalAfterPython("del f['time']; f.create_dataset('time', (3,), '<f8', "
                               "chunks=(3,), compression='lzf')"),
            "error: the array time has another layout" + advice);
  EXPECT_EQ(refusalAfterPython("del f['time']; f.create_dataset('time', (3,), '<f8', "
                               "maxshape=(None,), chunks=(10**8,))"),
            "error: the array time has another layout" + advice);
  EXPECT_EQ(refusalAfterPython("del f['time']; f.create_dataset('time', (3,), '>f4')"),
            "error: the array time does not have numbers of 64 bits" + advice);
  // HDF5 does not check the addresses of variable-length texts.
  EXPECT_EQ(refusalAfterPython("del f['events/text']\n"
                               "f.create_dataset('events/text', (3,), h5py.string_dtype())"),
            "error: the array events/text does not have texts of a fixed length" + advice);
  EXPECT_EQ(refusalAfterPython("del f['events/text']\n"
                               "f.create_dataset('events/text', (3,), 'S1000000000')"),
            "error: an array has more entries than its file" + advice);
  EXPECT_EQ(refusalAfterPython("f['time'].resize((10**9,))"),
            "error: an array has more entries than its file" + advice);
}

TEST(TrajectoryFile, ReportsThatItCannotBeWritten) {
  EXPECT_THAT(test::refusalOf<OutputError>(
                  [] { test::writeTrajectory(randomTrajectory(1), "/proc/kirireel/run.h5"); }),
              HasSubstr("/proc/kirireel: error: cannot write in this folder"));
}

}  // namespace
}  // namespace kirireel
