#include "render/export/export.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/files.h"
#include "tests/support/opening_squares.h"
#include "tests/support/refusal.h"
#include "tests/support/start_warnings.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

/// Four hinged squares that open, and two events.
trajectory::Trajectory opening() {
  trajectory::Trajectory run = test::openingSquares();
  run.events = {{0.31, "ground off"}, {0.72, "pinned tile 3"}};
  return run;
}

/// The run, written to a file and read again.
class Export : public testing::Test {
 protected:
  Export() {
    test::writeTrajectory(opening(), folder_ / "trajectory.h5");
    reader_ = std::make_unique<trajectory::TrajectoryReader>(folder_ / "trajectory.h5");
  }

  std::vector<std::size_t> states(const std::vector<std::string>& names) const {
    std::vector<std::size_t> samples;
    for (const exports::ChosenState& state : exports::chooseStates(*reader_, names))
      samples.push_back(state.sample);
    return samples;
  }

  std::string refusal(const std::vector<std::string>& names) const {
    return test::refusalOf([&] { states(names); });
  }

  std::filesystem::path out() const { return folder_ / "out"; }

  std::vector<std::string> filesOut() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(out())) {
      names.push_back(entry.path().filename().string());
    }
    std::ranges::sort(names);
    return names;
  }

  TemporaryFolder folder_;
  std::unique_ptr<trajectory::TrajectoryReader> reader_;
};

TEST_F(Export, FindsStatesBySharesTimesAnglesAndEvents) {
  EXPECT_THAT(states({"initial", "25%", "50%", "final"}), ElementsAre(0, 2, 5, 10));
  EXPECT_THAT(states({"0", "0.32", "0.98s"}), ElementsAre(0, 3, 10));
  // Tiles turn by 0.05 rad = 2.86 degrees a sample.
  EXPECT_THAT(states({"10deg"}), ElementsAre(4));
  EXPECT_THAT(states({"event:pinned"}), ElementsAre(7));
  EXPECT_EQ(states({"all"}).size(), 11U);
}

TEST_F(Export, ReportsWhatIsNotInTheTrajectory) {
  EXPECT_EQ(refusal({"1.2"}), "error: state '1.2' is not in the trajectory; it goes from 0 to 1 s");
  EXPECT_EQ(refusal({"-1s"}), "error: state '-1s' is not in the trajectory; it goes from 0 to 1 s");
  EXPECT_EQ(refusal({"101%"}),
            "error: state '101%' is not in the trajectory; shares go from 0% to 100%");
  EXPECT_EQ(
      refusal({"40deg"}),
      "error: state '40deg' is not in the trajectory; its tiles rotate by at most 28.65 degrees");
  EXPECT_EQ(refusal({"event:reset"}),
            "error: state 'event:reset' is not in the trajectory; its "
            "events are 'ground off', 'pinned tile 3'");
  EXPECT_EQ(refusal({"half"}),
            "error: 'half' is not a state; use initial, final, all, a share (25%), a time (1.5 or "
            "1.5s), an angle (30deg) or an event (event:TEXT)");
  EXPECT_THAT(refusal({"nan"}), testing::StartsWith("error: 'nan' is not a state"));
}

TEST_F(Export, RefusesStatesWhoseFilesWouldClash) {
  EXPECT_EQ(refusal({"50%", "0.52"}),
            "error: states '50%' and '0.52' are both sample 5; remove one of them");
  EXPECT_EQ(
      refusal({"event:off", "event:pinned tile", "event:tile 3"}),
      "error: states 'event:pinned tile' and 'event:tile 3' are both sample 7; remove one of them");
}

TEST_F(Export, TakesTheOnlySampleForBothDefaults) {
  trajectory::Trajectory run = opening();
  run.samples.resize(1);
  run.events.clear();
  test::writeTrajectory(run, folder_ / "one.h5");
  const trajectory::TrajectoryReader reader(folder_ / "one.h5");
  const std::vector<exports::ChosenState> chosen =
      exports::chooseStates(reader, exports::ExportSettings().states);
  EXPECT_EQ(chosen, (std::vector<exports::ChosenState>{{0, "initial"}}));
  EXPECT_EQ(test::refusalOf([&] {
              exports::chooseStates(reader, {"initial", "0%"});
            }),
            "error: states 'initial' and '0%' are both sample 0; remove one of them");
}

TEST_F(Export, NamesFilesByTheRequestedStates) {
  std::vector<std::string> labels;
  for (const exports::ChosenState& state : exports::chooseStates(
           *reader_, {"initial", "25%", "10deg", "0.5s", "event:pinned tile", "final"})) {
    labels.push_back(state.label);
  }
  EXPECT_THAT(labels,
              ElementsAre("initial", "25pct", "10deg", "0.5s", "event_pinned_tile", "final"));
  EXPECT_EQ(exports::chooseStates(*reader_, {"all"})[7].label, "0007");
}

TEST_F(Export, WritesJobsThatFollowTheDeployment) {
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  settings.elements.perEdge = 2;
  settings.decks.drive = {fea::DriveChoice::Some, {0}};
  settings.decks.buckling = true;
  settings.states = {"initial", "final"};
  const std::vector<std::string> names = exports::exportStates(*reader_, settings, out());
  for (const std::string& name : names) EXPECT_TRUE(exports::isExported(name, settings)) << name;
  EXPECT_THAT(filesOut(), ElementsAre("contents.json", "state_final_buckle.inp",
                                      "state_final_job.inp", "state_final_mesh.inp",
                                      "state_initial_buckle.inp", "state_initial_drive.inp",
                                      "state_initial_job.inp", "state_initial_mesh.inp"));
  EXPECT_THAT(test::bytesOf(out() / "state_initial_drive.inp"), HasSubstr("*AMPLITUDE, NAME=A"));
  settings.states = {"final"};
  EXPECT_THROW(exports::exportStates(*reader_, settings, out()), InputError);
}

TEST_F(Export, MapsTheFirstStateToTheOthers) {
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  settings.elements.perEdge = 2;
  settings.decks.stateMap = true;
  settings.decks.periodic = true;
  const std::vector<std::string> names = exports::exportStates(*reader_, settings, out());
  for (const std::string& name : names) EXPECT_TRUE(exports::isExported(name, settings)) << name;
  EXPECT_THAT(filesOut(), ElementsAre("contents.json", "state_final_job.inp", "state_final_map.inp",
                                      "state_final_mesh.inp", "state_final_periodic.inp",
                                      "state_initial_job.inp", "state_initial_mesh.inp",
                                      "state_initial_periodic.inp"));
  EXPECT_THAT(test::bytesOf(out() / "state_final_map.inp"),
              HasSubstr("INPUT=state_initial_mesh.inp"));
  const auto refused = [&] {
    try {
      exports::exportStates(*reader_, settings, out());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  settings.states = {"final"};
  EXPECT_THAT(refused(), HasSubstr("choose several, as in --states initial,final"));
  settings.elements.joints = fea::JointStyle::Neck;
  EXPECT_THAT(refused(), HasSubstr("a sheet with necks has only the start"));
}

TEST_F(Export, DrivesCoarseElementsUnlessTheyWereChosen) {
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  settings.decks.drive = {fea::DriveChoice::All, {}};
  settings.states = {"initial"};
  for (const std::string& name : exports::exportStates(*reader_, settings, out())) {
    EXPECT_TRUE(exports::isExported(name, settings)) << name;
  }
  EXPECT_THAT(filesOut(), ElementsAre("contents.json", "state_initial_drive.inp",
                                      "state_initial_drive_mesh.inp", "state_initial_job.inp",
                                      "state_initial_mesh.inp"));
  EXPECT_THAT(test::bytesOf(out() / "state_initial_drive.inp"),
              HasSubstr("INPUT=state_initial_drive_mesh.inp"));
  EXPECT_THAT(test::bytesOf(out() / "state_initial_drive_mesh.inp"), HasSubstr("TYPE=C3D8I"));
}

TEST_F(Export, WritesEveryFormat) {
  exports::ExportSettings settings;
  settings.formats = exports::exportFormatNames();
  settings.states = {"50%"};
  const std::vector<std::string> names = exports::exportStates(*reader_, settings, out());
  // New formats may be added, these names stay.
  EXPECT_THAT(
      filesOut(),
      IsSupersetOf({"contents.json", "cut_pattern.dxf", "cut_pattern.svg", "deployment.fold",
                    "deployment.glb", "deployment.pvd", "state_50pct.msh", "state_50pct.obj",
                    "state_50pct.ply", "state_50pct.stl", "state_50pct.vtu", "state_50pct_job.inp",
                    "state_50pct_mesh.inp", "state_50pct_planar.obj", "state_50pct_vertices.txt"}));
  EXPECT_EQ(names.size() + 1, filesOut().size());
  for (const std::string& name : names) {
    EXPECT_GT(std::filesystem::file_size(out() / name), 0U);
    EXPECT_TRUE(exports::isExported(name, settings)) << name;
    EXPECT_FALSE(exports::isExported(name, {})) << name;
  }
  EXPECT_THAT(test::bytesOf(out() / "state_50pct_job.inp"),
              HasSubstr("INPUT=state_50pct_mesh.inp"));
  EXPECT_THAT(test::bytesOf(out() / "state_50pct_mesh.inp"), HasSubstr("state 50pct, at 0.5 s.\n"));
}

TEST_F(Export, ListsTheNamesOfFilesBeforehand) {
  exports::ExportSettings settings;
  settings.formats = {"inp", "stl"};
  settings.states = {"final", "30deg", "all"};
  for (const char* name : {"state_final.stl", "state_30deg_job.inp", "state_0123_mesh.inp"}) {
    EXPECT_TRUE(exports::isExported(name, settings)) << name;
  }
  for (const char* name : {"state_initial.stl", "state_31deg.stl", "state_123.stl",
                           "state_final_drive.inp", "state_final_buckle.inp", "sheet_job.inp"}) {
    EXPECT_FALSE(exports::isExported(name, settings)) << name;
  }
  settings.elements.joints = fea::JointStyle::Neck;
  EXPECT_TRUE(exports::isExported("sheet_job.inp", settings));
  EXPECT_TRUE(exports::isExported("state_final.stl", settings));
  EXPECT_FALSE(exports::isExported("state_final_job.inp", settings));
}

TEST_F(Export, LeavesNoFilesOfASetThatFails) {
  exports::ExportSettings settings;
  settings.formats = {"obj", "svg"};
  settings.hingeWidth = 2;  // wider than a tile, found after the meshes are written
  EXPECT_THROW(exports::exportStates(*reader_, settings, out()), InputError);
  EXPECT_FALSE(std::filesystem::exists(out()));
}

TEST(ExportWarnings, ReportFewerElementsThanByDefault) {
  const auto warnings = [](int side, const exports::ExportSettings& settings) {
    scene::Scene scene;
    scene.model = generate::makeTessellation(test::squares(side, side, 0.5));
    return test::startWarnings(scene, settings);
  };
  exports::ExportSettings settings;
  settings.formats = {"msh"};
  EXPECT_THAT(warnings(21, settings), ElementsAre());
  EXPECT_THAT(warnings(22, settings),
              ElementsAre("warning: a sheet of 484 tiles has 7 elements per edge; 8 would bend "
                          "more accurately. Use --elements-per-edge or --element-size"));
  settings.elements.perEdge = 2;
  EXPECT_THAT(warnings(22, settings), ElementsAre());
}

TEST(ExportWarnings, ReportTheErrorOfSlivers) {
  const auto warnings = [](const std::vector<Vector3>& corners, int perEdge) {
    scene::Scene scene;
    scene.model.tiles = {model::Tile{corners}};
    exports::ExportSettings settings;
    settings.formats = {"msh"};
    settings.elements.perEdge = perEdge;
    return test::startWarnings(scene, settings);
  };
  const auto triangle = [](double degrees) {
    return std::vector<Vector3>{
        {0, 0, 0}, {1, 0, 0}, {std::cos(degrees * kDegree), std::sin(degrees * kDegree), 0}};
  };
  // The figures are those of 8 elements per edge, for any number of them here.
  for (const int perEdge : {8, 16}) {
    EXPECT_THAT(
        warnings(triangle(1), perEdge),
        ElementsAre(HasSubstr("tile 0 has a corner of 1 degrees, so natural frequencies may "
                              "be too high: the first five of triangles with 8 elements")));
  }
  EXPECT_THAT(warnings(triangle(11), 8), ElementsAre());
  // A notch of 4 degrees between corners of 88 degrees and more.
  EXPECT_THAT(
      warnings(
          {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.52, 1, 0}, {0.5, 0.4, 0}, {0.48, 1, 0}, {0, 1, 0}},
          8),
      ElementsAre());
}

TEST(ExportWarnings, ReportThinAndSharpTilesOfSheetsWithNecks) {
  scene::Scene scene;
  scene.model = generate::makeTessellation(test::squares(2, 2, 0));
  scene.brick.thickness = 0.002;
  exports::ExportSettings settings;
  settings.formats = {"msh"};
  settings.elements.joints = fea::JointStyle::Neck;
  settings.elements.neck.width = 0.1;
  EXPECT_THAT(test::startWarnings(scene, settings),
              ElementsAre("warning: tile 0 is 500 times as wide as thick; a clamped square that "
                          "is as thin deflects about 10% too little with 8 elements per edge: use "
                          "more with --elements-per-edge"));
  settings.elements.family = fea::ElementFamily::Plane;  // does not bend
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre());
  const double c = std::cos(kDegree), s = std::sin(kDegree);
  scene.model.tiles = {model::Tile{{{0, 0, 0}, {1, 0, 0}, {c, s, 0}}}};
  scene.model.joints.clear();
  scene.model.target.reset();
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre(HasSubstr("by 13 to 237%")));
}

TEST(ExportUnit, IsRefusedIfNoFormatUsesIt) {
  const model::Model model = generate::makeTessellation(test::squares(2, 2, 0));
  exports::ExportSettings settings;
  settings.unit = millimetre();
  for (const std::string& format : exports::exportFormatNames()) {
    settings.formats = {format};
    const bool isIgnored =
        format == "step" || format == "inp" || format == "glb" || format == "svg";
    const std::string refusal =
        test::refusalOf([&] { exports::requireExportable(model, {}, settings); });
    EXPECT_EQ(refusal, isIgnored ? "error: --export-unit has no effect on " + format +
                                       ". Remove --export-unit, or set --deck-unit for inp"
                                 : "accepted");
  }
  settings.formats = {"step", "stl"};
  EXPECT_NO_THROW(exports::requireExportable(model, {}, settings));
}

TEST(ExportedNecks, AreNotTooNarrowForTheirSheet) {
  model::Model model = generate::makeTessellation(test::squares(2, 2, 0));
  model.unit = millimetre();
  exports::ExportSettings settings;
  settings.elements.joints = fea::JointStyle::Neck;
  for (const char* format : {"inp", "msh", "stl", "step"}) {
    settings.formats = {format};
    settings.elements.neck.width = 1e-9;
    EXPECT_EQ(test::refusalOf([&] { exports::requireExportable(model, {}, settings); }),
              "error: necks of 1e-06 mm are too narrow for a sheet of 2830 mm; choose a "
              "--neck-width of at least 0.0031 mm");
    settings.elements.neck.width = 3.1e-6;
    EXPECT_NO_THROW(exports::requireExportable(model, {}, settings));
  }
}

// Two squares at 60 degrees: their bricks overlap next to the edge that makes them one part.
TEST(ExportWarnings, DoNotCountOverlapsOfJoinedTiles) {
  const double c = 0.5, s = std::sqrt(0.75);
  std::vector<model::Tile> tiles = {
      model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
      model::Tile{{{1, 0, 0}, {1 + c, 0, s}, {1 + c, 1, s}, {1, 1, 0}}}};
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  scene::Scene scene;
  scene.brick.thickness = 0.1;
  scene.model.tiles = tiles;
  scene.model.joints = {model::makeFixedJoint(tiles, 0, 1)};
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre());
  // A third tile lies half a thickness above the first.
  for (Vector3& vertex : tiles[0].vertices) vertex -= Vector3(0.5, 0, -0.05);
  scene.model.tiles.push_back(tiles[0]);
  EXPECT_THAT(test::startWarnings(scene, settings),
              ElementsAre(HasSubstr("bricks overlap by 0.05 m, 50% of their thickness")));
}

TEST(ExportWarnings, ReportSpringsAtFolds) {
  const std::vector<model::Tile> tiles = {
      model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
      model::Tile{{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}}}};
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  settings.elements.joints = fea::JointStyle::Patch;
  scene::Scene scene;
  scene.brick.thickness = 0.1;
  scene.hinges.stiffness = 1;
  scene.solver.planar = false;
  scene.model.tiles = tiles;
  const auto joined = [](int a, int b) {
    return model::Joint{{0, a}, {1, b}, model::JointFace::Top};
  };
  scene.model.joints = {joined(1, 0), joined(2, 3)};
  EXPECT_THAT(test::startWarnings(scene, settings),
              ElementsAre("warning: these decks lack the run's springs at folds (1 of 1). Only "
                          "hinges across the tiles have springs"));
  // A hinge across the tiles, upright.
  for (model::Tile& tile : scene.model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = {vertex.x(), 0, vertex.y()};
  }
  scene.model.joints = {{{0, 1}, {1, 0}, model::JointFace::Both}};
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre());
}

TEST(ExportWarnings, ReportLigamentsThatDecksDoNotHave) {
  scene::Scene scene;
  scene.model = generate::makeTessellation(test::squares(2, 2, 0.5));
  scene.brick.thickness = 0.02;
  scene.hinges.neck = scene::HingeNeck{0.02, 0.1, 1e6, 0.3};
  scene.hinges.areLigaments = true;
  exports::ExportSettings settings;
  settings.formats = {"inp"};
  settings.elements.joints = fea::JointStyle::Patch;
  const std::string warning =
      "warning: these decks join tiles exactly, but the run's ligaments stretch and shear; "
      "--joints neck gives the start with its necks";
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre(warning));
  scene.hinges = {};
  EXPECT_THAT(test::startWarnings(scene, settings), ElementsAre());
}

TEST(ExportedNecks, AreOfTheStart) {
  const model::Model model = generate::makeTessellation(test::squares(2, 2, 0));
  exports::ExportSettings settings;
  settings.elements.joints = fea::JointStyle::Neck;
  settings.elements.neck.width = 0.1;
  const auto refusal = [&](std::vector<std::string> formats, std::vector<std::string> states) {
    settings.formats = std::move(formats);
    settings.states = std::move(states);
    return test::refusalOf([&] { exports::requireExportable(model, {}, settings); });
  };
  const std::vector<std::string> byDefault = exports::ExportSettings{}.states;
  for (const std::string format : {"inp", "msh", "stl", "step"}) {
    EXPECT_THAT(refusal({format}, {"initial", "50%"}),
                HasSubstr("--states 50% has no effect, because a sheet with necks has only the "
                          "start. Remove --states or choose other --joints"));
    EXPECT_EQ(refusal({format, "obj"}, {"final"}), "accepted");
    EXPECT_EQ(refusal({format}, {"initial"}), "accepted");
    EXPECT_EQ(refusal({format}, byDefault), "accepted");
  }
}

TEST_F(Export, RefusesAFormatGivenTwice) {
  exports::ExportSettings settings;
  settings.formats = {"obj", "ply", "obj"};
  try {
    exports::exportStates(*reader_, settings, out());
    ADD_FAILURE() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "error: format obj is given twice, so its files would have the same name; remove one");
  }
}

}  // namespace
}  // namespace kirireel
