// Time of other programs to read decks of 10,000 tiles. Skipped if these are not installed.
#include <algorithm>
#include <numeric>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/job.h"
#include "sim/base/files.h"
#include "tests/render/fea/run_deck.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::kOrigin;

/// CPU seconds that a command takes, the smallest of two tries.
double cpuSeconds(const std::filesystem::path& folder, const std::string& command) {
  double least = INFINITY;
  for (int k = 0; k < 2; ++k) {
    const std::string output = test::outputOf(
        fmt::format("cd '{}' && bash -c 'TIMEFORMAT=%U; {{ time {} > log 2>&1; }} 2>&1'",
                    folder.string(), command));
    least = std::min(least, std::strtod(output.c_str(), nullptr));
  }
  return least;
}

fea::ElementMesh sheetOf(const fea::ElementRule& rule) {
  const model::Model model = generate::makeTessellation(test::squares(100, 100, 0.3));
  const test::Layout layout = test::layoutOf(model.tiles, model.joints);
  return fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
}

/// The same elements as if they were of one tile without faces.
fea::ElementMesh inOneGroup(fea::ElementMesh mesh) {
  fea::TileElements all;
  all.elementCount = static_cast<int>(mesh.elements.size());
  all.nodes.resize(mesh.nodes.size());
  std::iota(all.nodes.begin(), all.nodes.end(), 0);
  mesh.tiles = {all};
  mesh.joints.clear();
  return mesh;
}

TEST(BigSheets, AreReadByGmshAsFastAsOneGroup) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to check meshes with it";
  const fea::ElementMesh mesh = sheetOf({});
  const test::TemporaryFolder folder;
  writeTextFile(folder / "sheet.msh", fea::gmshMesh(mesh));
  writeTextFile(folder / "one.msh", fea::gmshMesh(inOneGroup(mesh)));
  const double own = cpuSeconds(folder.path(), "gmsh sheet.msh -parse_and_exit");
  const double one = cpuSeconds(folder.path(), "gmsh one.msh -parse_and_exit");
  EXPECT_THAT(test::bytesOf(folder / "log"), testing::HasSubstr("Done reading"));
  EXPECT_LT(own, 3 * one);  // measured: 2.2 x
}

/// A deck without its sets, but those of all nodes, all elements and the job.
std::string withoutSets(const std::string& deck) {
  std::istringstream lines(deck);
  std::string kept;
  bool isKept = true;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("*")) {
      const bool isSet = line.starts_with("*NSET") || line.starts_with("*SURFACE");
      const bool isJobs =
          line.find("NHOLD") != std::string::npos || line.find("GRIP_") != std::string::npos;
      isKept = !isSet || isJobs;
    }
    if (isKept) kept += line + "\n";
  }
  return kept;
}

TEST(BigSheets, AreReadByCalculixAsFastAsWithoutSets) {
  if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to check decks with it";
  const fea::ElementMesh mesh = sheetOf({.perEdge = 1, .through = 1, .quadratic = false});
  const fea::DeckJob job = fea::staticJob(mesh, {}, kOrigin, "x_mesh.inp");
  const std::string deck = fea::meshDeck(mesh, {}, kOrigin) + job.sets;
  const test::TemporaryFolder folder;
  writeTextFile(folder / "job.inp", job.text);
  writeTextFile(folder / "x_mesh.inp", deck);
  const double own = cpuSeconds(folder.path(), "env OMP_NUM_THREADS=1 ccx -i job");
  EXPECT_THAT(test::bytesOf(folder / "log"), testing::HasSubstr("Job finished"));
  writeTextFile(folder / "x_mesh.inp", withoutSets(deck));
  const double without = cpuSeconds(folder.path(), "env OMP_NUM_THREADS=1 ccx -i job");
  EXPECT_THAT(test::bytesOf(folder / "log"), testing::HasSubstr("Job finished"));
  EXPECT_LT(own, 1.5 * without);  // measured: 0.95 x
}

}  // namespace
}  // namespace kirireel
