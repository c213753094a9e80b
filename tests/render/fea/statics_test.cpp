// Problems with solutions from statics, in CalculiX, in every style of joints. Skipped if ccx is
// not installed.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "tests/render/fea/run_deck.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::displacements;
using test::kOrigin;
using test::Layout;
using ::testing::HasSubstr;

struct Style {
  fea::JointStyle joints = fea::JointStyle::Shared;
  bool quadratic = true;
};

class Statics : public testing::TestWithParam<Style> {
 protected:
  void SetUp() override {
    if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to check decks with it";
  }

  fea::ElementMesh meshOf(const Layout& layout, int perEdge = 4) const {
    const Style& style = GetParam();
    return fea::makeElementMesh(
        layout.bricks, layout.joints, layout.poses,
        {.perEdge = perEdge, .quadratic = style.quadratic, .joints = style.joints});
  }
};

model::Tile quad(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return model::Tile{{a, b, c, d}};
}

/// The independent nodes among these, which a job may fix.
std::vector<int> leadersAmong(const fea::ElementMesh& mesh, const std::vector<int>& nodes) {
  const std::vector<bool> follows = fea::followers(mesh);
  std::vector<int> leaders;
  std::ranges::copy_if(nodes, std::back_inserter(leaders), [&](int n) { return !follows[n]; });
  return leaders;
}

std::vector<int> allNodes(const fea::ElementMesh& mesh) {
  std::vector<int> nodes(mesh.nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) nodes[k] = static_cast<int>(k);
  return nodes;
}

TEST_P(Statics, ThreeHingedArchHasTheReactionsOfStatics) {
  // Feet A (0, 0) and B (2, 0), crown C (1, 1); 100 N down at (0.4, 0.6). About A, with a load only
  // on the left half, the right half pushes along BC: RB = (-20, 20), RA = (20, 80).
  const Vector3 a(0, 0, 0), b(2, 0, 0), c(1, 1, 0);
  const Layout layout = test::layoutOf(
      {quad(a, {0.6, 0.4, 0}, c, {0.4, 0.6, 0}), quad(b, {1.6, 0.6, 0}, c, {1.4, 0.4, 0})},
      {{{0, 2}, {1, 2}, model::JointFace::Both}});
  const fea::ElementMesh mesh = meshOf(layout, 0);
  const int loaded = mesh.tiles[0].edges[3].front();
  const std::string job = test::ownJob(
      test::setOf("FOOTA", mesh.tiles[0].edges[0]) + test::setOf("FOOTB", mesh.tiles[1].edges[0]) +
          test::setOf("FLAT", leadersAmong(mesh, allNodes(mesh))),
      "FOOTA, 1, 2\nFOOTB, 1, 2\nFLAT, 3, 3\n", fmt::format("*CLOAD\n{}, 2, -100.\n", loaded + 1),
      "FOOTA, TOTALS=ONLY\nRF\n*NODE PRINT, NSET=FOOTB, TOTALS=ONLY\nRF\n*NODE PRINT, NSET=FOOTA");
  const test::JobEnd end = test::run(fea::meshDeck(mesh, {}, kOrigin), job);
  const auto left = test::totalForces(end.data, "FOOTA");
  const auto right = test::totalForces(end.data, "FOOTB");
  ASSERT_FALSE(left.empty() || right.empty()) << end.log;
  // Measured: equal in the seven digits that ccx prints.
  EXPECT_LT((left[0] - Vector3(20, 80, left[0].z())).norm(), 1e-3) << left[0].transpose();
  EXPECT_LT((right[0] - Vector3(-20, 20, right[0].z())).norm(), 1e-3) << right[0].transpose();
}

TEST_P(Statics, HingeTurnsWithoutMoment) {
  // Two squares side by side on a hinge at the origin. One is fixed, the other is moved at one node
  // until it has rotated by 60 degrees.
  const Layout layout = test::layoutOf({quad({-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}),
                                        quad({0, 0, 0}, {0, -1, 0}, {1, -1, 0}, {1, 0, 0})},
                                       {{{0, 1}, {1, 0}, model::JointFace::Both}});
  const fea::ElementMesh mesh = meshOf(layout);
  const std::vector<int>& driven = mesh.tiles[1].edges[3];
  const double height = std::sqrt(0.75);
  std::string job = test::ownJob(
      test::setOf("DRIVEN", driven) + test::setOf("HELD", leadersAmong(mesh, mesh.tiles[0].nodes)),
      "HELD, 1, 3\n", fmt::format("*BOUNDARY\nDRIVEN, 2, 2, {}\n", height),
      "HELD, FREQUENCY=1000, TOTALS=ONLY\nRF\n*EL PRINT, ELSET=EALL, "
      "FREQUENCY=1000\nS\n*NODE PRINT, "
      "FREQUENCY=1000, NSET=DRIVEN");
  const std::string step = "*STEP\n*STATIC\n";
  // Forces are only rounding errors, so they need a reference, here 1 N.
  job.replace(job.find(step), step.size(),
              "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.\n"
              "*CONTROLS, PARAMETERS=FIELD, FIELD=DISPLACEMENT\n0.005, 0.01, 1., 1.\n");
  const test::JobEnd end = test::run(fea::meshDeck(mesh, {}, kOrigin), job);
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  for (const Vector3& force : test::totalForces(end.data, "HELD")) {
    EXPECT_LT(force.norm(), 1e-3);  // measured: 2.3e-4
  }
  EXPECT_LT(test::largestStress(end.data), 1);  // Pa, of 1 GPa; measured: 0.080
  EXPECT_GE(test::largestStress(end.data), 0);
  const std::string rows = end.data.substr(end.data.rfind("displacements"));
  ASSERT_GE(displacements(rows).size(), driven.size());
  for (const Vector3& u : displacements(rows)) {
    EXPECT_LT((u - Vector3(-0.5, height, 0)).norm(), 1e-6) << u.transpose();  // measured: 3.8e-9
  }
}

/// A job that moves nodes by a linear field u = G x, and the nodes' rows.
std::string fieldJob(const fea::ElementMesh& mesh, const std::vector<int>& moved,
                     const Matrix3& gradient) {
  std::string boundary;
  for (const int node : moved) {
    const Vector3 u = gradient * mesh.nodes[node];
    for (int axis = 0; axis < 3; ++axis) {
      boundary += fmt::format("{0}, {1}, {1}, {2}\n", node + 1, axis + 1, fea::deckNumber(u[axis]));
    }
  }
  // Displacements other than zero are a step's.
  return test::ownJob("", "", "*BOUNDARY\n" + boundary,
                      "NALL\nU\n*EL PRINT, ELSET=EALL\nS\n*NODE PRINT, NSET=NALL");
}

TEST_P(Statics, PatchTestKeepsAUniformStrain) {
  // Irregular tiles, of which two share a hinge in their middle. The nodes of all surfaces follow a
  // linear field, and the inner nodes must follow. Rigid patches cannot strain: they rotate.
  Layout layout = test::layoutOf({quad({0, 0, 0}, {1.3, 0.1, 0}, {1, 1, 0}, {-0.1, 0.8, 0}),
                                  quad({1, 1, 0}, {2.1, 0.9, 0}, {2.3, 1.9, 0}, {0.8, 2.1, 0})},
                                 {{{0, 2}, {1, 0}, model::JointFace::Both}});
  const fea::ElementMesh mesh = meshOf(layout, 0);
  Matrix3 gradient;
  gradient << 1e-3, 2e-4, -3e-4, 5e-4, -2e-3, 1e-4, 4e-4, 6e-4, 8e-4;
  if (GetParam().joints == fea::JointStyle::Patch)
    gradient = 0.5 * (gradient - gradient.transpose().eval());
  std::vector<int> surface;
  for (const fea::TileElements& tile : mesh.tiles) {
    for (const auto* face : {&tile.bottom, &tile.top}) {
      surface.insert(surface.end(), face->begin(), face->end());
    }
    for (const fea::ElementFace& face : tile.sides) {
      const std::array<int, 20>& nodes = mesh.elements[face.element].nodes;
      const int next = (face.side + 1) % 4;
      for (const int corner : {face.side, next}) {
        surface.push_back(nodes[corner]);
        surface.push_back(nodes[corner + 4]);
        if (GetParam().quadratic) surface.push_back(nodes[corner + 16]);
      }
      if (!GetParam().quadratic) continue;
      for (const int edge : {8, 12}) surface.push_back(nodes[edge + face.side]);
    }
  }
  std::ranges::sort(surface);
  const auto repeated = std::ranges::unique(surface);
  surface.erase(repeated.begin(), repeated.end());
  const test::JobEnd end = test::run(fea::meshDeck(mesh, {}, kOrigin),
                                     fieldJob(mesh, leadersAmong(mesh, surface), gradient));
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  const std::vector<Vector3> u = displacements(end.data.substr(end.data.rfind("displacements")));
  ASSERT_GE(u.size(), mesh.nodes.size());
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
    EXPECT_LT((u[k] - gradient * mesh.nodes[k]).norm(), 1e-8) << k;  // of 4e-3; measured: 7.1e-10
  }
}

TEST_P(Statics, VolumeIsThatOfTheBricks) {
  const Layout layout = test::hingedSquares();
  const fea::ElementMesh mesh = meshOf(layout);
  const std::vector<int> held = leadersAmong(mesh, allNodes(mesh));
  const std::string job =
      test::ownJob(test::setOf("HELD", held), "HELD, 1, 3\n", "",
                   "NALL\nU\n*EL PRINT, ELSET=EALL, TOTALS=ONLY\nEVOL\n*NODE PRINT, NSET=NALL");
  const test::JobEnd end = test::run(fea::meshDeck(mesh, {}, kOrigin), job);
  const std::size_t place = end.data.find("total volume");
  ASSERT_LT(place, end.data.size()) << end.log;
  const double volume = std::strtod(end.data.c_str() + end.data.find('\n', place), nullptr);
  EXPECT_NEAR(volume, 4 * 0.02, 1e-7);  // measured: exactly that, in seven digits
}

INSTANTIATE_TEST_SUITE_P(
    Joints, Statics,
    testing::Values(Style{fea::JointStyle::Shared, true}, Style{fea::JointStyle::Shared, false},
                    Style{fea::JointStyle::Equation, true}, Style{fea::JointStyle::Equation, false},
                    Style{fea::JointStyle::Patch, true}, Style{fea::JointStyle::Patch, false}));

}  // namespace
}  // namespace kirireel
