#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/sweep/sweep_plan.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;

sweep::Sweep read(const std::string& text) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "sweep.toml") << text;
  return sweep::readSweepFile(folder / "sweep.toml");
}

void expectRefused(const std::string& text, const std::string& part) {
  EXPECT_THAT([&] { read(text); }, testing::ThrowsMessage<InputError>(HasSubstr(part))) << text;
}

TEST(SweepFile, ReadsBaseGridAndKeptFiles) {
  const sweep::Sweep sweep = read(
      "generate = \"fan\"\nkeep = \"pictures\"\n[base]\nduration = 2.5\nground = true\n"
      "[grid]\ncolumns = [4, 2]\ngravity = [[0, 0, -1], [0, 0, -9.81]]\n"
      "thickness = {from = 0.01, to = 0.1, count = 3}\n");
  EXPECT_EQ(sweep.family, "fan");
  EXPECT_EQ(sweep.keep, sweep::SweepKeep::Pictures);
  ASSERT_EQ(sweep.settings.size(), 2U);
  EXPECT_EQ(sweep.settings[0].value.text, "2.5");
  EXPECT_TRUE(sweep.settings[1].value.isSwitch);
  EXPECT_EQ(sweep.plan.size(), 12U);
  EXPECT_EQ(sweep.plan.run(0)[1].text, "0,0,-1");
  EXPECT_EQ(sweep.plan.run(1)[2].text, "0.055");
}

TEST(SweepFile, NamesOfFilesAreRelativeToIt) {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "fan");
  std::ofstream(folder / "sweep.toml")
      << "model = \"fan\"\n[list]\ntarget = [\"x/a\", \"/b\", \"cap\"]\n";
  const sweep::Sweep sweep = sweep::readSweepFile(folder / "sweep.toml");
  EXPECT_EQ(sweep.settings[0].value.text, (folder / "fan").string());
  EXPECT_EQ(sweep.plan.run(0)[0].text, "/b");
  EXPECT_EQ(sweep.plan.run(1)[0].text, (folder / "x/a").string());
  EXPECT_EQ(sweep.plan.run(2)[0].text, "cap");  // may be the name of a known model
}

TEST(SweepFile, RefusesEmptyParts) {
  expectRefused("model = \"a\"\n",
                "sweep.toml: error: there is nothing to vary; add [grid], [list] "
                "or [latin_hypercube]");
  expectRefused("[grid]\n", "sweep.toml:1:2: error: [grid] is empty; name parameters");
  expectRefused(
      "[grid]\nthickness = []\n",
      "sweep.toml:2:13: error: thickness has no values; give some, as in thickness = [1, 2]");
  expectRefused("[latin_hypercube]\nruns = 5\n",
                "[latin_hypercube] has no ranges; give runs = 100");
  expectRefused("[latin_hypercube]\nthickness = {from = 1, to = 2}\n",
                "[latin_hypercube] has no runs; give runs = 100");
}

TEST(SweepFile, RefusesMoreThanMemoryHolds) {
  const std::string few = "the parameters have more than 100000 values together; vary fewer, or ";
  expectRefused("[grid]\na = {from = 0, to = 1, count = 100001}\n",
                "give a whole number from 2 to 100000");
  expectRefused(
      "[grid]\na = {from = 0, to = 1, count = 60000}\nb = {from = 0, to = 1, count = 60000}\n",
      "sweep.toml:3:1: error: " + few);
  expectRefused("[latin_hypercube]\nruns = 60000\na = {from = 0, to = 1}\nb = {from = 0, to = 1}\n",
                few);
}

TEST(SweepFile, RefusesInvalidFiles) {
  expectRefused("[grids]\n", "sweep.toml:1:2: error: unknown key grids, did you mean grid?");
  expectRefused("keep = \"everything\"\n",
                "give \"state\", \"trajectory\", \"pictures\" or \"all\"");
  expectRefused("[grid]\nthickness = 0.1\n", "give a list [1, 2], or a range, as in {from = 0.01");
  expectRefused("[grid]\na = {from = 1, to = 2}\n",
                "give a range, as in {from = 0.01, to = 0.1, count");
  expectRefused("[grid]\na = {from = 0, to = 2, count = 3, scale = \"log\"}\n",
                "give ends above 0 for scale = \"log\"");
  expectRefused("[grid]\na = {from = 1, to = 2, cuont = 3}\n",
                "unknown key of a range cuont, did you mean count?");
  expectRefused("[list]\na = [1, 2]\nb = [1]\n",
                "sweep.toml:3:1: error: b has 1 values but a has 2");
  expectRefused("[grid]\na = [1]\n[list]\na = [1]\n",
                "one of [grid], [list] and [latin_hypercube]");
  expectRefused("[base]\na = 1\n[grid]\na = [1]\n", "a is set twice (also in line 2); remove one");
}

}  // namespace
}  // namespace kirireel
