// The boundaries between rooms, read off the sources themselves.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;
using ::testing::IsEmpty;
using ::testing::SizeIs;

struct SourceFile {
  std::string path;  ///< relative to the repository
  std::set<std::string> includes;
};

std::string readText(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::set<std::string> includesOf(const std::string& text) {
  static const std::regex pattern("#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  std::set<std::string> includes;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    includes.insert((*match)[1]);
  }
  return includes;
}

/// All C++ files of sim/ and render/.
const std::vector<SourceFile>& sources() {
  static const std::vector<SourceFile> files = [] {
    std::vector<SourceFile> found;
    const fs::path root = KIRIREEL_SOURCE_DIR;
    for (const char* floor : {"sim", "render"}) {
      for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / floor)) {
        const fs::path ending = entry.path().extension();
        if (ending != ".h" && ending != ".cpp") continue;
        found.push_back(
            {fs::relative(entry.path(), root).string(), includesOf(readText(entry.path()))});
      }
    }
    return found;
  }();
  return files;
}

/// "FILE includes HEADER" for every include that matches, in files whose path starts so.
std::vector<std::string> uses(const std::string& room, const std::string& headerPattern) {
  const std::regex pattern(headerPattern);
  std::vector<std::string> found;
  for (const SourceFile& file : sources()) {
    if (!file.path.starts_with(room)) continue;
    for (const std::string& header : file.includes) {
      if (std::regex_match(header, pattern)) found.push_back(file.path + " includes " + header);
    }
  }
  return found;
}

/// The files anywhere that include a matching header.
std::set<std::string> usersOf(const std::string& headerPattern) {
  const std::regex pattern(headerPattern);
  std::set<std::string> users;
  for (const SourceFile& file : sources()) {
    for (const std::string& header : file.includes) {
      if (std::regex_match(header, pattern)) users.insert(file.path);
    }
  }
  return users;
}

constexpr const char* kBullet = "(bt[A-Z]|Bullet|LinearMath|bullet/).*";

TEST(Boundaries, SourcesAreFound) {
  // Otherwise everything below would hold of nothing.
  EXPECT_GT(sources().size(), 50U);
  EXPECT_THAT(uses("sim/base/", "sim/base/error\\.h"), testing::Not(IsEmpty()));
}

TEST(Boundaries, SimulationNeverIncludesRendering) {
  EXPECT_THAT(uses("sim/", "render/.*"), IsEmpty());
}

TEST(Boundaries, OnlyTheWorldIncludesBullet) {
  for (const std::string& user : usersOf(kBullet)) {
    EXPECT_TRUE(user.starts_with("sim/world/")) << user;
  }
  EXPECT_FALSE(usersOf(kBullet).empty());
}

TEST(Boundaries, JointsAndMeasuresDoNotKnowTheWorld) {
  EXPECT_THAT(uses("sim/joints/", "sim/world/.*"), IsEmpty());
  EXPECT_THAT(uses("sim/measure/", "sim/world/.*"), IsEmpty());
}

TEST(Boundaries, EachLibraryStaysInOneSourceFile) {
  EXPECT_THAT(usersOf("GL/osmesa\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("EGL/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("libav.*|libsw.*"), SizeIs(1));
  EXPECT_THAT(usersOf("png\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("hdf5\\.h|H5.*|highfive/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("zlib\\.h"), SizeIs(1));
  EXPECT_THAT(usersOf("assimp/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("openssl/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("toml\\+\\+/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("chipmunk/.*"), SizeIs(1));
  EXPECT_THAT(usersOf("ft2build\\.h|FT_.*|freetype/.*"), SizeIs(1));
}

TEST(Boundaries, CommandLineLibraryStaysInTheCommandLine) {
  for (const std::string& user : usersOf("CLI/.*")) EXPECT_TRUE(user.starts_with("render/cli/"));
}

TEST(Boundaries, EveryHeaderIsIncludedOnce) {
  for (const SourceFile& file : sources()) {
    if (!file.path.ends_with(".h")) continue;
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_NE(text.find("#pragma once"), std::string::npos) << file.path;
    EXPECT_TRUE(text.starts_with("/// ")) << file.path << " does not say what it is for";
  }
}

/// The product's own text files, tests apart.
std::vector<fs::path> productFiles() {
  std::vector<fs::path> files;
  const fs::path root = KIRIREEL_SOURCE_DIR;
  const std::set<std::string> apart = {".git", ".cache", "build", "out", "tests"};
  for (const fs::directory_entry& top : fs::directory_iterator(root)) {
    if (apart.contains(top.path().filename().string())) continue;
    if (top.is_regular_file()) files.push_back(top.path());
    if (!top.is_directory()) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(top.path())) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
  }
  return files;
}

TEST(Boundaries, ProductDependsOnNothingBesideTheRepository) {
  for (const fs::path& file : productFiles()) {
    EXPECT_EQ(readText(file).find("../shared"), std::string::npos) << file;
    EXPECT_EQ(readText(file).find("/work/"), std::string::npos) << file;
  }
}

TEST(Boundaries, NoOtherProgramIsEverStarted) {
  const std::regex start(
      "::(system|popen|execl|execle|execlp|execv|execve|execvp|execvpe|fexecve|"
      "posix_spawn|posix_spawnp|wordexp|dlopen)\\s*\\(");
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_FALSE(std::regex_search(text, start)) << file.path;
  }
}

TEST(Boundaries, TimeIsMeasuredByClocksThatNeverJump) {
  const std::regex wall(
      "system_clock|high_resolution_clock|CLOCK_REALTIME|gettimeofday|"
      "\\bstd::time\\(|\\btime\\((nullptr|NULL|0)\\)");
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_FALSE(std::regex_search(text, wall)) << file.path;
  }
}

TEST(Boundaries, SourceFilesStayShort) {
  for (const SourceFile& file : sources()) {
    const std::string text = readText(fs::path(KIRIREEL_SOURCE_DIR) / file.path);
    EXPECT_LT(std::count(text.begin(), text.end(), '\n'), 600) << file.path;
  }
}

}  // namespace
