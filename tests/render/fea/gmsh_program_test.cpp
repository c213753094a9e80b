// Checks meshes with Gmsh. Skipped if it is not installed.
#include <algorithm>
#include <iterator>
#include <numbers>
#include <numeric>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/element_mesh.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/generate/lattice.h"
#include "tests/render/fea/read_deck.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

/// The mesh as a deck written by Gmsh.
test::Deck throughGmsh(const fea::ElementMesh& mesh) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "x.msh", fea::gmshMesh(mesh, fea::SetChoice::All));
  test::outputOf("cd '" + folder.path().string() +
                 "' && gmsh x.msh -save -setnumber Mesh.SaveGroupsOfNodes 1 -o x.inp");
  return test::readDeck(test::bytesOf(folder / "x.inp"));
}

class GmshProgram : public testing::TestWithParam<bool> {};

TEST_P(GmshProgram, KeepsSetsAndElements) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to check meshes with it";
  const test::Layout layout = test::hingedSquares();
  const fea::ElementMesh mesh =
      fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                           {.perEdge = 2, .through = 1, .quadratic = GetParam()});
  const test::Deck deck = throughGmsh(mesh);
  EXPECT_EQ(deck.nodes.size(), mesh.nodes.size());
  for (int t = 0; t < 4; ++t) {
    const std::string name = "TILE_0000" + std::to_string(t);
    EXPECT_EQ(deck.nodeSets.at(name).size(), mesh.tiles[t].nodes.size());
    EXPECT_EQ(deck.nodeSets.at(name + "_SBOT").size(), mesh.tiles[t].bottom.size());
    EXPECT_EQ(deck.nodeSets.at(name + "_STOP").size(), mesh.tiles[t].top.size());
    // Gmsh writes 14 digits. Measured: below 1e-12.
    EXPECT_NEAR(volumeOf(deck, name) / layout.bricks[t].volume, 1, 1e-12);
    if (!GetParam()) continue;
    for (const int k : deck.elementSets.at(name)) {
      EXPECT_LT(largestMiddleMiss(deck, deck.elements.at(k)), 1e-13);  // measured: 5.0e-14
    }
  }
  for (int j = 0; j < 4; ++j) {
    for (const char* side : {"_A", "_B"}) {
      EXPECT_EQ(deck.nodeSets.at("JOINT_0000" + std::to_string(j) + side).size(),
                GetParam() ? 3U : 2U);
    }
  }
}

/// The output of gmsh -check for a mesh.
std::string checked(const fea::ElementMesh& mesh) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "x.msh", fea::gmshMesh(mesh));
  return test::outputOf("cd '" + folder.path().string() + "' && gmsh -check x.msh 2>&1; true");
}

/// Expects that gmsh -check reports no error for a mesh.
void expectCoherent(const fea::ElementMesh& mesh) {
  const std::string output = checked(mesh);
  EXPECT_THAT(output, testing::HasSubstr("Done checking mesh coherence"));
  EXPECT_THAT(output, testing::Not(testing::HasSubstr("Error"))) << output;
  EXPECT_THAT(output, testing::Not(testing::HasSubstr("Warning"))) << output;
}

TEST(GmshProgram, FindsNothingTwice) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to check meshes with it";
  for (const fea::JointStyle style :
       {fea::JointStyle::Shared, fea::JointStyle::Equation, fea::JointStyle::Patch}) {
    for (const double angle : {0.0, 1e-9, 0.7}) {
      const test::Layout layout = test::hingedSquares(angle);
      expectCoherent(
          fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {.joints = style}));
    }
  }
  const test::Layout shut = test::hingedSquares(0);
  expectCoherent(fea::makeElementMesh(shut.bricks, shut.joints, shut.poses,
                                      {.family = fea::ElementFamily::Shell}));
}

/// The number of connected pieces of a mesh.
int piecesOf(const fea::ElementMesh& mesh) {
  std::vector<int> parent(mesh.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int node) {
    while (parent[node] != node) node = parent[node] = parent[parent[node]];
    return node;
  };
  for (const fea::Element& element : mesh.elements) {
    for (int k = 1; k < fea::nodeCount(mesh.rule); ++k) {
      parent[root(element.nodes[k])] = root(element.nodes[0]);
    }
  }
  int pieces = 0;
  for (int node = 0; node < static_cast<int>(parent.size()); ++node) pieces += root(node) == node;
  return pieces;
}

fea::ElementRule necks(const writers::NeckShape& shape,
                       fea::ElementFamily family = fea::ElementFamily::Plane) {
  fea::ElementRule rule{.joints = fea::JointStyle::Neck, .family = family, .neck = shape};
  rule.perEdge = 4;
  return rule;
}

/// The area of the quadrilaterals of a plane mesh.
double areaOf(const fea::ElementMesh& mesh) {
  double area = 0;
  for (const fea::Element& element : mesh.elements) {
    const auto at = [&](int k) { return mesh.nodes[element.nodes[k]]; };
    area += 0.5 * (at(2) - at(0)).cross(at(3) - at(1)).z();
  }
  return area;
}

TEST(NeckMesh, IsOneSheetWhoseSlitsAreOpen) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to mesh sheets with necks";
  const model::Model model = generate::makeTessellation(test::squares(3, 3, 0));
  const fea::ElementMesh shut = fea::makeNeckMesh(model, 0.02, necks({.width = 0.1}));
  EXPECT_EQ(piecesOf(shut), 1);
  EXPECT_NEAR(areaOf(shut), 9, 1e-9);  // nine squares of 1 m; measured: exactly that
  // Tiles share nodes only at necks: within the width of a neck from a corner.
  for (std::size_t t = 0; t < shut.tiles.size(); ++t) {
    for (std::size_t other = 0; other < t; ++other) {
      std::vector<int> common;
      std::ranges::set_intersection(shut.tiles[t].nodes, shut.tiles[other].nodes,
                                    std::back_inserter(common));
      for (const int node : common) {
        double distance = 1;
        for (const Vector3& corner : model.tiles[t].vertices) {
          distance = std::min(distance, (shut.nodes[node] - corner).head<2>().norm());
        }
        EXPECT_LE(distance, 0.1 + 1e-9);
      }
    }
  }
  // With a kerf each of the 36 edges loses half of it. Slots and necks by hand: 12 of them. Each
  // slot removes (length - kerf) x width from its tiles. Each neck adds length x width, less the
  // part of its tiles.
  const writers::NeckShape beam{.width = 0.05, .length = 0.2, .kerf = 0.01};
  const fea::ElementMesh open = fea::makeNeckMesh(model, 0.02, necks(beam));
  EXPECT_EQ(piecesOf(open), 1);
  const double tiles = 9 * 0.99 * 0.99;
  const double expected = tiles + 12 * (0.01 * 0.05 - (0.2 - 0.01) * 0.05);
  EXPECT_NEAR(areaOf(open), expected, 1e-9);
}

TEST(NeckMesh, ReportsWhichNecksFit) {
  const model::Model shut = generate::makeTessellation(test::squares(2, 2, 0));
  const auto refusal = [](const model::Model& model,
                          const writers::NeckShape& shape) -> std::string {
    try {
      writers::neckOutline(model, shape);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal(shut, {}),
            "error: necks cannot be 0 m wide; give a positive --neck-width, or the sheet falls "
            "apart");
  EXPECT_EQ(
      refusal(shut, {.width = 0.1, .length = 0.1, .radius = 0.06}),
      "error: fillets of radius 0.06 m do not fit necks 0.1 m long; choose a --neck-radius of "
      "at most 0.05 m, or a --neck-length of at least 0.12 m");
  EXPECT_THAT(refusal(shut, {.width = 2}), testing::HasSubstr("; a --neck-width of 0.99 m does"));
  EXPECT_EQ(refusal(shut, {.width = 0.99}), "accepted");
  // Squares that meet at their corners are narrow there: a neck needs its own width of length.
  const model::Model open = generate::makeTessellation(test::squares(2, 2, std::numbers::pi / 2));
  EXPECT_THAT(refusal(open, {.width = 0.1, .length = 0.05}),
              testing::HasSubstr("; a --neck-length of 0.101 m does"));
  EXPECT_EQ(refusal(open, {.width = 0.1, .length = 0.101}), "accepted");
  model::Model bent = shut;
  bent.tiles[1].vertices[0].z() += 0.1;
  EXPECT_THAT(refusal(bent, {.width = 0.1}), testing::HasSubstr("the start is not flat"));
}

TEST(NeckMesh, JoinsOpenTilesAndTilesOfManySides) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to mesh sheets with necks";
  const model::Model open = generate::makeTessellation(test::squares(2, 2, 0.7));
  EXPECT_EQ(piecesOf(fea::makeNeckMesh(open, 0.02, necks({.width = 0.1}))), 1);
  EXPECT_EQ(piecesOf(fea::makeNeckMesh(open, 0.02, necks({.width = 0.05, .length = 0.1}))), 1);
  const fea::ElementMesh solid =
      fea::makeNeckMesh(open, 0.02, necks({.width = 0.1}, fea::ElementFamily::Solid));
  EXPECT_EQ(piecesOf(solid), 1);
  expectCoherent(solid);
  // Elements at the ends of closed slits are small and well shaped.
  const model::Model shut = generate::makeTessellation(test::squares(2, 2, 0));
  for (const fea::ElementFamily family : {fea::ElementFamily::Solid, fea::ElementFamily::Plane}) {
    expectCoherent(fea::makeNeckMesh(shut, 0.02, necks({.width = 0.05}, family)));
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, GmshProgram, testing::Bool());

TEST(GmshNecks, SidesOfSlitsAreContactPairs) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to mesh necks";
  const model::Model model = generate::makeTessellation(test::squares(3, 3, 0));
  for (const double kerf : {0.0, 0.02}) {
    const fea::ElementMesh mesh =
        fea::makeNeckMesh(model, 0.02,
                          {.through = 1,
                           .joints = fea::JointStyle::Neck,
                           .neck = {.width = 0.1, .length = 3 * kerf, .kerf = kerf}});
    const std::vector<fea::ContactPair> pairs = fea::contactPairs(mesh);
    // At each of 12 necks one pair with a slit between, and one in a line.
    EXPECT_EQ(pairs.size(), 24U) << kerf;
    int slits = 0;
    for (const fea::ContactPair& pair : pairs) {
      // The nodes of both sides are in a strip as wide as the cut.
      Eigen::AlignedBox3d box;
      for (const auto* side : {&pair.a, &pair.b}) {
        for (const fea::ElementFace& face : *side) {
          for (const int node : fea::faceNodes(mesh, face)) box.extend(mesh.nodes[node]);
        }
      }
      EXPECT_LE(box.sizes().head<2>().minCoeff(), kerf + 1e-9);  // measured: kerf + 1e-15
      if (box.sizes().head<2>().minCoeff() > 0.9 * kerf && kerf > 0) ++slits;
    }
    EXPECT_EQ(slits, kerf > 0 ? 12 : 0);
  }
}

}  // namespace
}  // namespace kirireel
