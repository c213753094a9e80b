// `verify` on finished runs.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/output/output_folder.h"
#include "render/record/summary.h"
#include "sim/base/files.h"
#include "sim/trajectory/trajectory_file.h"
#include "tests/cli/run_program.h"
#include "tests/support/pair_forces.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

class Verify : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new TemporaryFolder;
    const ProgramEnd end =
        runKirireel({"record", shippedModel("nonrigid").string(), "--out", folder().string(),
                     "--size", "96x64", "--fps", "10", "--duration", "0.5", "--path", "dynamic",
                     "--frames", "--svg", "--export", "msh,glb"});
    ASSERT_EQ(end.exitCode, kEndedShort) << end.err;
  }
  static void TearDownTestSuite() { delete scratch_; }

  static std::filesystem::path folder() { return scratch_->path(); }
  static ProgramEnd verify() { return runKirireel({"verify", folder().string()}); }

  static TemporaryFolder* scratch_;
};
TemporaryFolder* Verify::scratch_ = nullptr;

TEST_F(Verify, AcceptsANewRun) {
  const ProgramEnd end = verify();
  EXPECT_EQ(end.exitCode, 0) << end.err;
  const std::size_t files = filesIn(folder()).size() - 1;
  EXPECT_EQ(end.out, folder().string() + ": " + std::to_string(files) +
                         " files and the figures of 6 samples agree with the summary\n");
}

TEST_F(Verify, CatchesAFlippedByteInEachFile) {
  for (const std::string& name : filesIn(folder())) {
    const std::string whole = readText(folder() / name);
    std::string damaged = whole;
    damaged[whole.size() / 2] ^= 4;
    writeText(folder() / name, damaged);
    const ProgramEnd end = verify();
    EXPECT_EQ(end.exitCode, 1) << name;
    EXPECT_THAT(end.out, HasSubstr((folder() / name).string() + ": "));
    writeText(folder() / name, whole);
  }
  EXPECT_EQ(verify().exitCode, 0);
}

TEST_F(Verify, ReportsWhatIsWrong) {
  const std::string whole = readText(folder() / "final.obj");
  writeText(folder() / "final.obj", whole + "#");
  EXPECT_EQ(verify().out, (folder() / "final.obj").string() + ": " +
                              std::to_string(whole.size() + 1) + " bytes, but the run wrote " +
                              std::to_string(whole.size()) + "\n");
  std::filesystem::remove(folder() / "final.obj");
  EXPECT_EQ(verify().out, (folder() / "final.obj").string() + ": the file is missing\n");
  writeText(folder() / "final.obj", whole);
}

/// Replaces a text in the summary, and renews its seal.
void falsify(const std::filesystem::path& file, const std::string& from, const std::string& to) {
  std::string text = readText(file);
  text.replace(text.find(from), from.size(), to);
  writeText(file, output::sealed(text.substr(0, text.rfind(",\n  \"sha256\"")) + "\n}\n"));
}

/// Parts of a summary that cannot be computed again: the cost of the run on this machine, and the
/// files, which have hashes.
bool isOutsideTheRun(const std::string& pointer) {
  for (const char* part : {"/cost/cpu_seconds", "/cost/wall_seconds", "/cost/peak_memory",
                           "/contents/", "/versions/"}) {
    if (pointer.starts_with(part)) return true;
  }
  return false;
}

// Finds every changed figure, one at a time, in a summary with a new seal.
TEST_F(Verify, FindsEachFigureThatIsFalsified) {
  const std::filesystem::path file = folder() / "summary.json";
  const std::string whole = readText(file);
  Json summary = Json::parse(whole);
  summary.erase("sha256");
  const Json flat = summary.flatten();
  int figures = 0;
  for (const auto& [pointer, value] : flat.items()) {
    if (!value.is_number() || isOutsideTheRun(pointer)) continue;
    Json falsified = summary;
    Json& figure = falsified.at(Json::json_pointer(pointer));
    if (value.is_number_integer()) {
      figure = value.get<int>() + 1;
    } else {
      // Lengths agree to 1e-12 of a tile.
      const double stated = value.get<double>();
      figure = std::abs(stated) < 1e-6 ? stated + 1e-3 : stated * 1.000001;
    }
    writeText(file, output::sealed(falsified.dump(2) + "\n"));
    EXPECT_FALSE(record::verifyRun(folder()).complaints.empty()) << pointer;
    ++figures;
  }
  writeText(file, whole);
  EXPECT_GT(figures, 50);
  EXPECT_EQ(verify().exitCode, 0);
}

TEST_F(Verify, ComputesTheFiguresAgain) {
  const std::string summary = readText(folder() / "summary.json");
  falsify(folder() / "summary.json", "\"target_error_end\": ", "\"target_error_end\": 1");
  const ProgramEnd end = verify();
  EXPECT_EQ(end.exitCode, 1);
  EXPECT_THAT(end.out, HasSubstr("summary.json: target_error_end is 1"));
  EXPECT_THAT(end.out, HasSubstr(", but the poses give "));
  writeText(folder() / "summary.json", summary);
}

/// Writes another trajectory into a run's folder, whose summary notes the new file.
void exchangeTrajectory(const std::filesystem::path& folder, const trajectory::Trajectory& run) {
  const std::filesystem::path file = folder / "trajectory.h5";
  const std::string hash = output::digestOf(folder, "trajectory.h5").sha256;
  const std::string size = "\"trajectory.h5\": {\n      \"bytes\": ";
  const std::string bytes = std::to_string(readText(file).size());
  test::writeTrajectory(run, file);
  falsify(folder / "summary.json", size + bytes, size + std::to_string(readText(file).size()));
  falsify(folder / "summary.json", hash, output::digestOf(folder, "trajectory.h5").sha256);
}

TEST_F(Verify, ComputesTheSamplesMeasuresAgain) {
  const std::filesystem::path file = folder() / "trajectory.h5";
  const std::string whole = readText(file);
  const std::string summary = readText(folder() / "summary.json");
  trajectory::Trajectory run = test::readTrajectory(file);
  run.samples[2].penetration += 1;
  exchangeTrajectory(folder(), run);
  EXPECT_THAT(verify().out, HasSubstr("trajectory.h5: penetration at 0.2 s is 1"));
  writeText(file, whole);
  writeText(folder() / "summary.json", summary);
}

// A sheet on compliant necks: the energy of its ligaments is computed again from the file.
TEST(VerifyLigaments, NoticesChangedLigaments) {
  const TemporaryFolder scratch;
  const std::string model = scratch / "sheet", run = scratch / "run",
                    scene = scratch / "scene.toml";
  runKirireel(
      {"generate", "tessellation", "--columns", "2", "--rows", "2", "--start-angle", "20", model});
  writeText(scene,
            "[model]\nligaments = true\nhinge_neck = \"0.1,0.1,1e6\"\n"
            "[[grip]]\ntiles = [0, 1]\nmove = {x = 0, y = 0}\n"
            "[[grip]]\ntiles = [2, 3]\nmove = {y = 0.1}\n");
  const ProgramEnd end =
      runKirireel({"simulate", model, "--scene", scene, "--out", run, "--verbose"});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr("springs at 4 hinges and 4 ligaments: "));
  ASSERT_TRUE(record::verifyRun(run).complaints.empty());
  const trajectory::Trajectory whole = test::readTrajectory(run + "/trajectory.h5");
  trajectory::Trajectory other = whole;
  std::vector<brick::Ligament> ligaments = brick::ligamentsOf(whole.pairForces);
  ligaments[2].shearStiffness *= 1.001;
  other.pairForces = test::pairForces(brick::hingeSpringsOf(whole.pairForces), ligaments);
  exchangeTrajectory(run, other);
  EXPECT_THAT(record::verifyRun(run).complaints, Contains(HasSubstr("elasticity.energy_end is ")));
  ligaments.pop_back();
  other.pairForces = test::pairForces(brick::hingeSpringsOf(whole.pairForces), ligaments);
  exchangeTrajectory(run, other);
  EXPECT_THAT(record::verifyRun(run).complaints,
              Contains(HasSubstr("elasticity.ligaments is 4, but the poses give 3")));
  exchangeTrajectory(run, whole);
  EXPECT_TRUE(record::verifyRun(run).complaints.empty());
}

// Tiles that bend under their weight: the summary has the energy of their diagonals. verify finds
// the same energy and the same overlaps. Parts of one tile do not overlap.
TEST(VerifyBendingTiles, AgreesWithTheirRun) {
  const TemporaryFolder scratch;
  const std::string run = scratch / "run";
  const ProgramEnd end = runKirireel({"simulate",      shippedModel("tessellation_4x4").string(),
                                      "--split-tiles", "all",
                                      "--panels",      "3e7",
                                      "--gravity",     "0,0,-9.81",
                                      "--pin",         "0",
                                      "--actuation",   "none",
                                      "--contacts",    "all",
                                      "--duration",    "0.2",
                                      "--fps",         "10",
                                      "--out",         run});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const auto summary = nlohmann::json::parse(readText(std::filesystem::path(run) / "summary.json"));
  EXPECT_EQ(summary["elasticity"]["springs"], 16);
  EXPECT_GT(summary["elasticity"]["energy_end"], 0);
  const ProgramEnd verified = runKirireel({"verify", run});
  EXPECT_EQ(verified.exitCode, 0) << verified.out;
}

// Most of the energy of tiles under grips is in bars. Poses do not contain it.
TEST(VerifyBendingTiles, AgreesWithTheirEquilibriaUnderGrips) {
  const TemporaryFolder scratch;
  const std::string model = scratch / "two.fold", scene = scratch / "scene.toml",
                    run = scratch / "run";
  writeText(model, R"({"vertices_coords": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "edges_vertices": [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2]],
    "edges_assignment": ["B", "B", "B", "B", "V"], "edges_foldAngle": [0, 0, 0, 0, 30],
    "faces_vertices": [[0, 1, 2], [0, 2, 3]]})");
  writeText(scene,
            "[model]\nhinge_stiffness = 0.1\npanels = \"1e7,0.3\"\n"
            "[[grip]]\ntile = 0\nvertex = 0\nmove = {x = 0, y = 0, z = 0}\n"
            "[[grip]]\ntile = 0\nvertex = 1\nmove = {y = 0, z = 0}\n"
            "[[grip]]\ntile = 0\nvertex = 2\nmove = {z = 0}\n"
            "[[grip]]\ntile = 1\nvertex = 2\nmove = {z = 0.1}\n");
  const ProgramEnd end = runKirireel({"simulate", model, "--scene", scene, "--out", run});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const ProgramEnd verified = runKirireel({"verify", run});
  EXPECT_EQ(verified.exitCode, 0) << verified.out;
}

TEST_F(Verify, ReadsNothingOutsideTheFolder) {
  const std::string summary = readText(folder() / "summary.json");
  for (const std::string name : {"/proc/kcore", "../final.obj", ""}) {
    falsify(folder() / "summary.json", "\"final.obj\": {", "\"" + name + "\": {");
    const ProgramEnd end = verify();
    EXPECT_EQ(end.exitCode, 1);
    EXPECT_THAT(end.out, HasSubstr(name + ": this is not the name of a file in the folder\n"));
    writeText(folder() / "summary.json", summary);
  }
}

TEST_F(Verify, NeedsASummary) {
  const TemporaryFolder empty;
  const ProgramEnd end = runKirireel({"verify", empty.path().string()});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_EQ(end.err, "kirireel: " + empty.path().string() +
                         ": error: there is no summary.json here; give the folder of a run of "
                         "kirireel record or simulate\n");
  writeText(empty / "summary.json", "{}\n");
  EXPECT_THAT(runKirireel({"verify", empty.path().string()}).out,
              HasSubstr("it lists no files to compare; record the run again"));
}

}  // namespace
}  // namespace kirireel
