// A run during changes of the system's clock, by libfaketime.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

std::vector<std::string> recordArguments(const std::filesystem::path& out) {
  return {"record",     shippedModel("tessellation_4x4").string(),
          "--out",      out.string(),
          "--duration", "0.3",
          "--fps",      "10",
          "--size",     "160x120"};
}

TEST(Clock, ThatJumpsChangesNothing) {
  const TemporaryFolder scratch;
  ASSERT_EQ(runKirireel(recordArguments(scratch / "undisturbed")).exitCode, 0);
  // Each reading of the wall clock is a day earlier, or later, than the last one.
  for (const std::string jump : {"-86400", "+86400"}) {
    std::vector<std::string> words = {"--exclude-monotonic", "-f", "@2001-01-01 00:00:00 i" + jump,
                                      KIRIREEL_PROGRAM};
    for (const std::string& word : recordArguments(scratch / jump)) words.push_back(word);
    const ProgramEnd end = runTool("faketime", words);
    if (end.exitCode == 127) GTEST_SKIP() << "install faketime to let the clock jump";
    ASSERT_EQ(end.exitCode, 0) << end.err;
    for (const std::string& name : filesIn(scratch / "undisturbed")) {
      if (name == "summary.json") continue;
      EXPECT_TRUE(readText(scratch / "undisturbed" / name) == readText(scratch / jump / name))
          << jump << ' ' << name;
    }
    const auto summary = nlohmann::json::parse(readText(scratch / jump / "summary.json"));
    for (const auto& [name, cost] : summary["cost"].items()) EXPECT_GE(cost, 0) << name;
    EXPECT_LT(summary["cost"]["wall_seconds"], 3600);
  }
}

}  // namespace
}  // namespace kirireel
