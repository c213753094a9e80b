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
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::vector<cli::NamedText>& pages() {
  static const std::vector<cli::NamedText> all = cli::manPages(cli::describeProgram(), "1.2.3");
  return all;
}

/// The text of a page in lines of 200 letters, without padding.
std::string shown(const std::string& name) {
  const test::TemporaryFolder folder;
  for (const auto& [file, text] : pages()) {
    if (file == name) writeTextFile(folder / file, text);
  }
  return outputOf(fmt::format("(groff -man -Tascii -P-c -P-b -P-u -rLL=200n -rHY=0 {} | tr -s ' ')",
                              (folder / name).string()));
}

TEST(ManPages, ExistForEachCommand) {
  std::vector<std::string> names;
  for (const auto& page : pages()) names.push_back(page.first);
  std::vector<std::string> expected = {"kirireel.1"};
  for (const cli::CommandDescription& command : cli::describeProgram().commands) {
    expected.push_back("kirireel-" + command.name + ".1");
  }
  EXPECT_EQ(names, expected);
}

TEST(ManPages, HaveNoWarningsFromTroff) {
  if (!hasProgram("groff")) GTEST_SKIP() << "install groff to check man pages";
  const test::TemporaryFolder folder;
  for (const auto& [name, text] : pages()) {
    writeTextFile(folder / name, text);
    const std::string file = (folder / name).string();
    EXPECT_THAT(outputOf(fmt::format("groff -ww -man -z -Tutf8 {} 2>&1", file)), IsEmpty()) << name;
  }
}

TEST(ManPages, ShowEveryOptionWithItsHelp) {
  if (!hasProgram("groff")) GTEST_SKIP() << "install groff to show man pages";
  const cli::CommandDescription program = cli::describeProgram();
  const std::string page = shown("kirireel-record.1");
  for (const cli::OptionDescription& option : cli::commandNamed(program, "record").options) {
    EXPECT_THAT(page, HasSubstr(option.names.back())) << option.key;
    EXPECT_THAT(page, HasSubstr(option.help.substr(0, 40))) << option.key;
  }
  EXPECT_THAT(page, HasSubstr("--thickness LENGTH"));
  EXPECT_THAT(page, HasSubstr("kirireel 1.2.3"));
}

TEST(ManPages, ShowFamiliesAndExamples) {
  if (!hasProgram("groff")) GTEST_SKIP() << "install groff to show man pages";
  EXPECT_THAT(shown("kirireel-generate.1"), HasSubstr("SQUARE-TO-DISK"));
  EXPECT_THAT(shown("kirireel-record.1"),
              HasSubstr("EXAMPLES\n kirireel record data/tessellation_4x4\n"));
}

TEST(ManPages, KeepSpecialLettersOfTroff) {
  cli::CommandDescription program{"name", "a \\ b", "  .so file\n  'quoted'", {}, {}, {}};
  program.options.push_back({{"-x", "--x-y"}, "x_y", "", "Options", "", ".begins so", {}, true});
  const std::string text = cli::manPages(program, "1").front().second;
  EXPECT_THAT(text, HasSubstr("name \\- a \\e b"));
  EXPECT_THAT(text, HasSubstr("\\fB\\-x\\fR, \\fB\\-\\-x\\-y\\fR"));
  EXPECT_THAT(text, HasSubstr("\n\\&.begins so"));
}

}  // namespace
}  // namespace kirireel
