// Published models, if they are next to the repository. Skipped otherwise.
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

/// A model, its options, and PyKirigami's target error at the end.
struct PublishedModel {
  std::string name;
  std::vector<std::string> options;
  double peerError = 0;
  double tileSize = 1;  // metres
};

void PrintTo(const PublishedModel& model, std::ostream* stream) {
  *stream << model.name;
}

class PublishedModels : public testing::TestWithParam<PublishedModel> {};

TEST_P(PublishedModels, EndNearerToTheTargetThanPyKirigami) {
  const PublishedModel& model = GetParam();
  const auto folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR).parent_path() / "shared/models" / model.name;
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const TemporaryFolder scratch;
  std::vector<std::string> arguments = {"simulate", folder.string(), "--out",
                                        scratch.path().string()};
  arguments.insert(arguments.end(), model.options.begin(), model.options.end());
  const ProgramEnd end = runKirireel(arguments);
  const auto summary = nlohmann::json::parse(readText(scratch / "summary.json"));
  // 3 on mobius, whose bricks overlap by 2.1e-4 of a tile, and on square2disk, whose springs rest
  // at 1.5 times the assembled error.
  EXPECT_EQ(end.exitCode, summary["shortfall"].is_null() ? 0 : kEndedShort) << end.out << end.err;
  const auto& accuracy = summary["accuracy"];
  EXPECT_LT(accuracy["target_error_end"], model.peerError);
  EXPECT_LT(accuracy["joint_gap_end"], 1e-9);  // 5.6e-11 on the cylinder, 1e-12 on the others
  EXPECT_LE(accuracy["joint_gap_max"], std::max(1e-9, accuracy["joint_opening_max"].get<double>()));
  // 2.3e-2 tile on the saddle, which exact joints cannot reach; 0 on the others.
  EXPECT_LT(accuracy["joint_opening_max"], 3e-2 * model.tileSize);
}

// Ends measured: 6.0e-7, 1.6e-4, 2.7e-4, 8.7e-3, 3.3e-6, 1.15e-3; the bricks may pass through each
// other.
INSTANTIATE_TEST_SUITE_P(
    Command, PublishedModels,
    testing::Values(
        PublishedModel{"cylinder", {"--force-damping", "80"}, 0.020},
        PublishedModel{"partialSphere", {}, 0.151},
        PublishedModel{"mobius", {"--spring-stiffness", "25", "--thickness", "0.005"}, 0.333},
        PublishedModel{"square2disk", {"--spring-stiffness", "25"}, 0.105},
        PublishedModel{"tess_m10_n10", {"--ground"}, 0.19},
        PublishedModel{
            "sphere-to-saddle", {"--thickness", "0.001", "--faces", "pykirigami"}, 0.292, 0.612}));

class PublishedPairs : public testing::TestWithParam<const char*> {};

TEST_P(PublishedPairs, DeployToTheirFloorWithNoFlags) {
  const auto folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR).parent_path() / "shared/models/obj-pairs";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const TemporaryFolder scratch;
  const ProgramEnd end =
      runKirireel({"simulate", (folder / GetParam()).string() + "_contracted.obj", "--out",
                   scratch.path().string(), "--fps", "10"});
  const auto summary = nlohmann::json::parse(readText(scratch / "summary.json"));
  EXPECT_EQ(end.exitCode, summary["shortfall"].is_null() ? 0 : kEndedShort) << end.out << end.err;
  const auto& accuracy = summary["accuracy"];
  const double rest = accuracy["springs_rest_error"];
  EXPECT_LE(accuracy["target_error_end"], 1.05 * rest);  // measured: 1.00 of 3.6e-6 to 0.012
  EXPECT_LE(accuracy["assembled_error"], accuracy["target_error_end"]);
}

INSTANTIATE_TEST_SUITE_P(Command, PublishedPairs,
                         testing::Values("hexagon_shear_w4_h2_i4_f0", "quad_sphere_w4_h4_i3_f0_r0",
                                         "triangle_circle_w3_h3_i3_f1_r1",
                                         "triangle_sphere_w3_h4_i3_f0_r0"));

const ProgramSetting kAmongSources{.folder = KIRIREEL_SOURCE_DIR};

/// Else run scripts/options. Options that equal those of record are listed once.
TEST(OptionsPage, HasWhatTheHelpPrints) {
  const std::string page = readText(KIRIREEL_SOURCE_DIR "/docs/options.md");
  EXPECT_NE(page.find(runKirireel({"record", "--help", "all"}).out + "```\n"), std::string::npos);
  for (const std::string command :
       {"render", "export", "curves", "figure", "page", "inspect", "convert", "sweep", "study"}) {
    const std::size_t first = page.find("\n## " + command + "\n");
    ASSERT_NE(first, std::string::npos);
    const std::string section = page.substr(first, page.find("\n## ", first + 1) - first);
    std::istringstream lines(runKirireel({command, "--help", "all"}).out);
    std::string entry;  // an option with its help, or a line that is none
    for (std::string line; std::getline(lines, line);) {
      const bool continues = line.starts_with("      ") && entry.starts_with("  -");
      if (!continues) {
        const bool isOption = entry.starts_with("  -");
        const std::string heading = entry.substr(0, entry.rfind(':'));
        EXPECT_NE((isOption ? page : section).find(isOption ? entry : heading), std::string::npos)
            << command << ": " << entry;
        entry.clear();
      }
      entry += line + '\n';
    }
  }
}

TEST(KnownModels, AreMissedWithAdvice) {
  const TemporaryFolder empty;
  const ProgramEnd end = runKirireel({"models"}, {.folder = empty.path()});
  if (end.exitCode == 0) GTEST_SKIP() << "models are installed: " << end.out;
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_EQ(end.err,
            "kirireel: error: there are no models in data/, and none are installed; change to the "
            "folder of the sources, or install the program\n");
}

TEST(KnownModels, AreListed) {
  const ProgramEnd end = runKirireel({"models"}, kAmongSources);
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.out, testing::MatchesRegex("name +tiles +joints +target\n(.*\n)*"
                                             "ammann_beenker_48 +[0-9]+ +[0-9]+  no\n(.*\n)*"
                                             "tessellation_4x4 +16 +24  yes\n(.*\n)*"));
  const TemporaryFolder scratch;
  std::filesystem::create_directories(scratch / "data/broken");
  writeText(scratch / "data/broken/vertices.txt", "0 0 0 1\n");
  const ProgramEnd broken = runKirireel({"models"}, {.folder = scratch.path()});
  EXPECT_EQ(broken.exitCode, 0);
  EXPECT_THAT(broken.out, testing::HasSubstr("vertices.txt:1:7: error: "));
}

TEST(KnownModels, AreSuggestedForMistypedNames) {
  for (const std::string name : {"tesselation_4x4", "data/tesselation_4x4/"}) {
    for (const char* command : {"record", "simulate", "inspect"}) {
      const ProgramEnd end = runKirireel({command, name}, kAmongSources);
      EXPECT_EQ(end.exitCode, 2);
      EXPECT_EQ(end.err, "kirireel: " + name +
                             ": error: there is no such model, did you mean tessellation_4x4?; see "
                             "kirireel models\n");
    }
  }
  EXPECT_THAT(
      runKirireel({"record", "nothing_like_it"}, kAmongSources).err,
      testing::HasSubstr("nothing_like_it: error: there is no such folder; give a folder with "
                         "vertices.txt and constraints.txt, or a name that kirireel models "
                         "lists"));
}

}  // namespace
}  // namespace kirireel
