#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/cli/manual.h"
#include "sim/base/files.h"
#include "tests/support/files.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::hasProgram;
using test::outputOf;
using ::testing::IsEmpty;

/// Completions of bash for these words, the last one unfinished.
std::string offered(const std::string& words) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "kirireel", cli::bashCompletion(cli::describeProgram()));
  writeTextFile(folder / "vertices.txt", "");
  writeTextFile(folder / "ask", fmt::format("cd '{}'; source ./kirireel; COMP_WORDS=({}); "
                                            "COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _kirireel; "
                                            "echo -n \"${{COMPREPLY[*]}}\"",
                                            folder.path().string(), words));
  return outputOf(fmt::format("bash {}", (folder / "ask").string()));
}

TEST(BashCompletion, OffersCommandsAndFamilies) {
  EXPECT_EQ(offered("kirireel re"), "record render");
  EXPECT_EQ(offered("kirireel generate tess"), "tessellation");
}

TEST(BashCompletion, OffersOptionsOfTheCommand) {
  EXPECT_EQ(offered("kirireel record --thick"), "--thickness");
  EXPECT_EQ(offered("kirireel verify --thick"), "");
  EXPECT_EQ(offered("kirireel generate tessellation --targ"), "--target-angle");
  EXPECT_EQ(offered("kirireel record folder --contacts none --grav"), "--gravity");
}

TEST(BashCompletion, OffersValues) {
  EXPECT_EQ(offered("kirireel record --mass ''"), "unit prism");
  EXPECT_EQ(offered("kirireel record --mass = p"), "prism");
  EXPECT_EQ(offered("kirireel record --thickness ''"), "");
}

TEST(BashCompletion, OffersFiles) {
  EXPECT_EQ(offered("kirireel record vert"), "vertices.txt");
  EXPECT_EQ(offered("kirireel record --target vert"), "vertices.txt");
}

/// Whether a shell accepts the script.
void expectInOrder(const std::string& shell, const std::string& check, const std::string& text) {
  if (!hasProgram(shell)) GTEST_SKIP() << "install " << shell << " to check its completion";
  const test::TemporaryFolder folder;
  writeTextFile(folder / "script", text);
  const std::string file = (folder / "script").string();
  EXPECT_EQ(outputOf(fmt::format("{} {} {} 2>&1 && echo fine", shell, check, file)), "fine\n");
}

TEST(ZshCompletion, IsInOrder) {
  expectInOrder("zsh", "-n", cli::zshCompletion(cli::describeProgram()));
}

TEST(FishCompletion, IsInOrder) {
  expectInOrder("fish", "--no-execute", cli::fishCompletion(cli::describeProgram()));
}

TEST(FishCompletion, OffersValues) {
  if (!hasProgram("fish")) GTEST_SKIP() << "install fish to ask its completion";
  const test::TemporaryFolder folder;
  writeTextFile(folder / "script", cli::fishCompletion(cli::describeProgram()));
  const std::string question = "complete -C \"kirireel record --mass \"";
  const std::string ask = fmt::format("(fish -c 'source {}; {}' | cut -f 1 | sort | paste -sd ' ')",
                                      (folder / "script").string(), question);
  EXPECT_EQ(outputOf(ask), "prism unit\n");
}

}  // namespace
}  // namespace kirireel
