// Shipped models equal the output of their commands. Conversions in both directions lose nothing.
#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

const fs::path kData = fs::path(KIRIREEL_SOURCE_DIR) / "data";

/// A model in data/ and the arguments that make it, without its folder.
struct ShippedModel {
  std::string name;
  std::vector<std::string> arguments;
};

void PrintTo(const ShippedModel& model, std::ostream* stream) {
  *stream << model.name;
}

/// The commands that data/README.md gives.
std::vector<ShippedModel> shippedModels() {
  const std::string page = readText(kData / "README.md");
  const std::regex command("`kirireel (generate [^`]*) data/([a-z0-9_]+)`");
  std::vector<ShippedModel> models;
  for (std::sregex_iterator match(page.begin(), page.end(), command), end; match != end; ++match) {
    ShippedModel& model = models.emplace_back();
    model.name = (*match)[2];
    std::istringstream words((*match)[1]);
    for (std::string word; words >> word;) model.arguments.push_back(word);
  }
  return models;
}

/// Whether two texts have the same words, with numbers within 1e-12 (other processors may round
/// otherwise).
bool sameNumbers(const std::string& a, const std::string& b) {
  std::istringstream left(a), right(b);
  for (std::string wordA, wordB;;) {
    const bool moreA = bool(left >> wordA), moreB = bool(right >> wordB);
    if (!moreA || !moreB) return moreA == moreB;
    if (wordA == wordB) continue;
    const double difference =
        std::strtod(wordA.c_str(), nullptr) - std::strtod(wordB.c_str(), nullptr);
    if (!(std::abs(difference) <= 1e-12)) return false;
  }
}

class ShippedModels : public testing::TestWithParam<ShippedModel> {};

TEST_P(ShippedModels, EqualTheOutputOfTheirCommands) {
  const TemporaryFolder scratch;
  std::vector<std::string> arguments = GetParam().arguments;
  const fs::path made = scratch / "model";
  arguments.push_back(made.string());
  const ProgramEnd end = runKirireel(arguments);
  ASSERT_EQ(end.exitCode, 0) << end.err;
  for (const char* file : {"vertices.txt", "constraints.txt", "target.txt"}) {
    const fs::path shipped = kData / GetParam().name / file;
    ASSERT_EQ(fs::exists(shipped), fs::exists(made / file)) << shipped;
    if (!fs::exists(shipped)) continue;
    EXPECT_TRUE(sameNumbers(readText(made / file), readText(shipped))) << shipped;
  }
}

TEST_P(ShippedModels, SurviveConversionInBothDirections) {
  const TemporaryFolder scratch;
  const fs::path model = kData / GetParam().name;
  for (const char* format : {"sheet.fold", "sheet_contracted.obj"}) {
    const std::string between = (scratch / format).string(), back = (scratch / "back").string();
    ASSERT_EQ(runKirireel({"convert", model.string(), between}).exitCode, 0);
    ASSERT_EQ(runKirireel({"convert", between, back}).exitCode, 0);
    for (const char* file : {"vertices.txt", "constraints.txt", "target.txt"}) {
      if (!fs::exists(model / file)) continue;
      EXPECT_TRUE(readText(fs::path(back) / file) == readText(model / file)) << format << file;
    }
  }
}

/// No path arrives on these with contacts.
const std::set<std::string> kShortModels = {"sphere_to_saddle", "stampfli_108"};

/// By the definition of arriving, from the figures of a summary.
bool isAtTarget(const nlohmann::json& summary) {
  const auto& accuracy = summary["accuracy"];
  const double size = summary["model"]["tile_size"], error = accuracy["target_error_end"];
  const double nearest = accuracy["assembled_error"];
  return error <= 1.05 * nearest + 1e-6 * size && error <= 0.1 * size;
}

/// For a run with contacts auto and enough search budget.
int expectedCode(const nlohmann::json& summary) {
  const double size = summary["model"]["tile_size"];
  const bool overlaps = summary["accuracy"]["penetration_grown_max"] > 1e-4 * size;
  const bool misses = summary["model"]["has_target"] && !isAtTarget(summary);
  return overlaps || misses ? kEndedShort : 0;
}

TEST_P(ShippedModels, ArriveOrReportWhatIsMissing) {
  const TemporaryFolder scratch;
  const fs::path model = kData / GetParam().name;
  const bool hasTarget = fs::exists(model / "target.txt");
  const ProgramEnd end = runKirireel({"simulate", model.string(), "--out", scratch.path().string(),
                                      "--actuation", hasTarget ? "target" : "expansion"});
  const auto summary = nlohmann::json::parse(readText(scratch / "summary.json"));
  const auto& accuracy = summary["accuracy"];
  EXPECT_EQ(end.exitCode, expectedCode(summary)) << end.out << end.err;
  EXPECT_EQ(summary["shortfall"].is_null(), end.exitCode == 0);
  EXPECT_EQ(end.exitCode == kEndedShort, kShortModels.contains(GetParam().name)) << end.out;
  const std::string firstLine = end.out.substr(0, end.out.find('\n'));
  EXPECT_EQ(firstLine.ends_with("; exit code 3"), end.exitCode == kEndedShort) << firstLine;
  EXPECT_LE(std::ranges::count(end.out, '\n'), 6) << end.out;
  EXPECT_LT(accuracy["joint_gap_end"], 1e-9);  // 8.8e-11 on the cylinder
  EXPECT_LE(accuracy["joint_gap_max"], std::max(1e-9, accuracy["joint_opening_max"].get<double>()));
  if (!hasTarget) return;
  const double least = accuracy["assembled_error"];
  const auto inspected =
      nlohmann::json::parse(runKirireel({"inspect", model.string(), "--json"}).out);
  // A run may come nearer than the earlier search. Measured: 2e-15 of the size; by 1.5e-5 of the
  // error on moebius, which ends out of its target's reach.
  EXPECT_LE(least, inspected["assembled_error"].get<double>() + 1e-9);
  EXPECT_NEAR(inspected["assembled_error"], least, 1e-9 + 1e-4 * least);
  EXPECT_EQ(summary["at_target"], isAtTarget(summary));
}

INSTANTIATE_TEST_SUITE_P(Data, ShippedModels, testing::ValuesIn(shippedModels()));

TEST(ProgramGenerate, EveryFolderOfDataIsOnThePage) {
  std::size_t folders = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kData)) {
    folders += fs::exists(entry.path() / "vertices.txt") ? 1 : 0;
  }
  EXPECT_EQ(shippedModels().size(), folders);
  EXPECT_GE(folders, 20U);
}

TEST(ProgramInspect, DescribesAModel) {
  const std::string model = (kData / "tessellation_4x4").string();
  const ProgramEnd end = runKirireel({"inspect", model, "--json"});
  ASSERT_EQ(end.exitCode, 0) << end.err;
  const auto json = nlohmann::json::parse(end.out);
  EXPECT_EQ(json["tiles"]["4"], 16);
  EXPECT_EQ(json["joints"]["both"], 24);
  EXPECT_EQ(json["target"]["mobility"]["plane"]["degrees_of_freedom"], 1);
  EXPECT_EQ(json["start"]["mobility"]["plane"]["degrees_of_freedom"], 6);
  EXPECT_LT(json["rigid_bound"], 1e-14);
  EXPECT_TRUE(json["start"]["overlaps"].empty());
  EXPECT_TRUE(json["needs"]["planar"]["on"]);
  const std::string text = runKirireel({"inspect", model}).out;
  EXPECT_NE(text.find("tiles: 16 with 4 vertices\njoints: 24 both\n"), std::string::npos) << text;
  EXPECT_NE(text.find("in the plane: 1 degree of freedom"), std::string::npos) << text;
}

// A run decides on contacts by a search, which inspect does not make.
TEST(ProgramInspect, DoesNotDecideOnContacts) {
  for (const char* name : {"cap", "fan", "cube_to_sphere"}) {
    EXPECT_THAT(runKirireel({"inspect", (kData / name).string()}).out,
                testing::HasSubstr("contacts off (unless bricks touch on the path)"))
        << name;
  }
}

TEST(ProgramInspect, PaintsNumbers) {
  const TemporaryFolder scratch;
  const std::string picture = (scratch / "numbers.png").string();
  ASSERT_EQ(runKirireel({"inspect", (kData / "tessellation_4x4").string(), "--picture", picture})
                .exitCode,
            0);
  EXPECT_GT(fs::file_size(picture), 20000U);  // measured 60 kB
}

TEST(ProgramConvert, NamesWhatAFormatDoesNotStore) {
  const TemporaryFolder scratch;
  const std::string model = (kData / "moebius").string();
  const ProgramEnd planar =
      runKirireel({"convert", model, (scratch / "strip_vertices.txt").string()});
  EXPECT_THAT(planar.err,
              ::testing::HasSubstr("cannot store 1 target, 20 joints on the bottom face, 14 joints "
                                   "on the top face; use a .fold file"));
  EXPECT_THAT(planar.out, ::testing::EndsWith(": 24 tiles, 34 joints\n"));
  const ProgramEnd whole = runKirireel({"convert", model, (scratch / "strip.fold").string()});
  EXPECT_EQ(whole.err, "");
  EXPECT_THAT(whole.out, ::testing::EndsWith(": 24 tiles, 34 joints, a target\n"));
}

TEST(ProgramConvert, ReadsPublishedPairsWithNoFlags) {
  const fs::path pairs = fs::path(KIRIREEL_SOURCE_DIR).parent_path() / "shared/models/obj-pairs";
  if (!fs::exists(pairs)) GTEST_SKIP() << pairs << " is not there";
  const TemporaryFolder scratch;
  int count = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(pairs)) {
    if (!entry.path().string().ends_with("_contracted.obj")) continue;
    const std::string out = (scratch / entry.path().stem().string()).string();
    const ProgramEnd end = runKirireel({"convert", entry.path().string(), out});
    EXPECT_EQ(end.exitCode, 0) << end.err;
    EXPECT_TRUE(fs::exists(fs::path(out) / "target.txt"));
    ++count;
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace kirireel
