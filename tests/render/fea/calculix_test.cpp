// CalculiX as the judge of decks: skipped where ccx is not installed.
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "sim/base/pending_file.h"
#include "tests/render/fea/read_deck.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::Layout;
using ::testing::HasSubstr;
using ::testing::Not;

/// What ccx said and what it left in job.dat.
struct JobEnd {
  std::string log;
  std::string data;
};

JobEnd run(const std::string& meshText, const std::string& jobText) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "x_mesh.inp", meshText);
  writeTextFile(folder / "job.inp", jobText);
  JobEnd end;
  end.log = test::outputOf("cd '" + folder.path().string() + "' && OMP_NUM_THREADS=1 ccx -i job");
  end.data = test::bytesOf(folder / "job.dat");
  return end;
}

/// The displacements in the rows "node ux uy uz" of job.dat.
std::vector<Vector3> displacements(const std::string& data) {
  std::vector<Vector3> found;
  std::istringstream lines(data);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream row(line);
    int node = 0;
    Vector3 u;
    if (row >> node >> u.x() >> u.y() >> u.z()) found.push_back(u);
  }
  return found;
}

/// The template as it is, but that its displacements are printed too.
std::string printing(std::string job) {
  return job.insert(job.find("*END STEP"), "*NODE PRINT, NSET=NALL\nU\n");
}

class JobTemplate : public testing::TestWithParam<ElementRule> {
 protected:
  void SetUp() override {
    if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to judge decks by it";
  }
};

void expectToRun(const Layout& layout, const ElementRule& rule) {
  const ElementMesh mesh = makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
  const JobEnd end = run(meshDeck(mesh, "test"), printing(jobDeck(mesh, "x_mesh.inp")));
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  EXPECT_THAT(end.log, Not(HasSubstr("WARNING")));
  EXPECT_THAT(end.log, Not(HasSubstr("ERROR")));
  const std::vector<Vector3> moved = displacements(end.data);
  EXPECT_GE(moved.size(), mesh.nodes.size());
  double most = 0;
  for (const Vector3& u : moved) most = std::max(most, u.norm());
  // A mechanism gives 1e9. Measured: 1.5e-9 (one linear element a tile) to 0.023.
  EXPECT_GT(most, 1e-10);
  EXPECT_LT(most, 0.1);
}

TEST_P(JobTemplate, RunsAsItIs) {
  const Model open = makeTessellation(test::squares(3, 2, 0.9));
  expectToRun(test::layoutOf(open.tiles, open.joints), GetParam());
  expectToRun(test::polygons(), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Deck, JobTemplate,
                         testing::Values(ElementRule{1, 1}, ElementRule{4, 2},
                                         ElementRule{2, 1, true}, ElementRule{4, 2, true},
                                         ElementRule{2, 1, false, JointStyle::Equation},
                                         ElementRule{2, 1, true, JointStyle::Equation},
                                         ElementRule{4, 1, false, JointStyle::Patch, 0.26},
                                         ElementRule{4, 1, true, JointStyle::Patch, 0.26}));

/// How far tile 3 of hinged squares moves from one opening angle to another while tile 0 stays
/// as it is: the analytic linkage.
Vector3 linkage(double from, double to) {
  const auto between = [](double angle) {
    const std::vector<Tile> tiles = tessellationTiles(test::squares(2, 2, 0), angle);
    const Vector3 across = tiles[3].vertices[0] - tiles[0].vertices[0];
    // Tile 0 is even: turned by half the angle, backwards.
    return Quaternion(Eigen::AngleAxisd(angle / 2, Vector3::UnitZ())) * across;
  };
  const Quaternion back(Eigen::AngleAxisd(-from / 2, Vector3::UnitZ()));
  return back * (between(to) - between(from));
}

std::string drivenJob(int node, double y) {
  return fmt::format(
      "*INCLUDE, INPUT=x_mesh.inp\n*MATERIAL, NAME=SHEET\n*ELASTIC\n1.e9, 0.3\n"
      "*SOLID SECTION, ELSET=EALL, MATERIAL=SHEET\n*BOUNDARY\nTILE_00000_N, 1, 3\n"
      "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.\n*BOUNDARY\n{}, 2, 2, {}\n"
      "*NODE PRINT, NSET=TILE_00003_BOT\nU\n*END STEP\n",
      node, deckNumber(y));
}

class HingeMechanism : public testing::TestWithParam<JointStyle> {};

TEST_P(HingeMechanism, MovesAsTheLinkageDoes) {
  if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to judge decks by it";
  const double start = 0.7;
  const Layout layout = test::hingedSquares(start);
  const ElementMesh mesh = makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                           {.perEdge = 2, .joints = GetParam()});
  const Vector3 wanted = linkage(start, 1.1);
  // A node of tile 3 that follows no other: the middle of its bottom.
  const int driven = mesh.tiles[3].bottom[4] + 1;
  const JobEnd end = run(meshDeck(mesh, "test"), drivenJob(driven, wanted.y()));
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  const std::vector<Vector3> moved = displacements(end.data);
  ASSERT_GE(moved.size(), 9U);
  for (std::size_t k = moved.size() - 9; k < moved.size(); ++k) {
    EXPECT_LT((moved[k] - wanted).norm(), 1e-5)  // measured: 6.5e-8
        << moved[k].transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Deck, HingeMechanism,
                         testing::Values(JointStyle::Shared, JointStyle::Equation));

}  // namespace
}  // namespace kirireel
