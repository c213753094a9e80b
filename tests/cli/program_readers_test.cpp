// Checks decks, meshes and facets with other programs. Skipped if they are not installed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/cli/run_program.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

using test::kPython;

/// Exports states of a run, with joints in this style.
void exportAs(const std::string& run, const std::string& style, const std::string& out) {
  const ProgramEnd end = runKirireel({"export", run, "--format", "inp,msh,stl", "--states",
                                      "initial,final", "--joints", style, "--drive", "all",
                                      "--buckle", "--elements-per-edge", "6", "--out", out});
  ASSERT_EQ(end.exitCode, 0) << end.err;
}

/// The output of a shell loop over files of this ending.
std::string outputOfAll(const std::string& folder, const std::string& ending,
                        const std::string& command) {
  return test::outputOf("cd '" + folder + "' && for file in *" + ending + "; do " + command +
                        " 2>&1; done; true");
}

/// meshio opens every deck, also jobs, and finds elements in it.
void expectMeshioToOpen(const std::string& folder) {
  const std::string script =
      "import meshio, sys; mesh = meshio.read(sys.argv[1]); "
      "print(\"cells\" if sum(len(c.data) for c in mesh.cells) > 0 else \"none\")";
  const std::string output = outputOfAll(
      folder, ".inp", std::string(kPython) + " -c '" + script + "' $file | grep -v \"^$\"");
  EXPECT_THAT(output, HasSubstr("cells"));
  EXPECT_THAT(output, Not(HasSubstr("none")));
  EXPECT_THAT(output, Not(HasSubstr("Error"))) << output;
}

class Readers : public testing::TestWithParam<const char*> {};

TEST_P(Readers, FindNoFaults) {
  for (const char* program : {"gmsh", "admesh"}) {
    if (!test::hasProgram(program)) GTEST_SKIP() << "install " << program;
  }
  const bool hasMeshio =
      !test::outputOf(std::string(kPython) + " -c 'import meshio; print(1)'").empty();
  const TemporaryFolder scratch;
  const std::string run = scratch / "run";
  runKirireel({"simulate", shippedModel(GetParam()).string(), "--out", run, "--fps", "10",
               "--duration", "2", "--path", "straight"});
  for (const std::string style : {"shared", "equation", "patch"}) {
    const std::string out = scratch / style;
    exportAs(run, style, out);
    const std::string meshes = outputOfAll(out, ".msh", "gmsh -check $file");
    EXPECT_THAT(meshes, HasSubstr("Done checking mesh coherence"));
    EXPECT_THAT(meshes, Not(HasSubstr("Error"))) << meshes;
    EXPECT_THAT(meshes, Not(HasSubstr("Warning"))) << meshes;
    const std::string facets = outputOfAll(out, ".stl", "admesh $file");
    EXPECT_THAT(facets, HasSubstr("Normals fixed         :     0"));
    for (const char* repair : {"Edges fixed", "Facets removed", "Facets added", "Facets reversed",
                               "Backwards edges", "Normals fixed"}) {
      EXPECT_THAT(facets, Not(testing::ContainsRegex(std::string(repair) + " *: *[1-9]")));
    }
    if (hasMeshio) expectMeshioToOpen(out);
  }
  if (!hasMeshio) GTEST_SKIP() << "install python3-meshio to check decks with it";
}

INSTANTIATE_TEST_SUITE_P(Program, Readers,
                         testing::Values("tessellation_4x4", "cap", "hexagons", "stars"));

}  // namespace
}  // namespace kirireel
