#include "render/fea/deck.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/render/fea/read_deck.h"
#include "tests/support/layouts.h"

namespace kirireel {
namespace {

using test::Deck;
using test::Layout;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Turned in space and moved away, so that no coordinate is round.
Layout turned(Layout layout) {
  const Pose turn{{7, -3, 1e-5}, rotationFromVector({0.3, -0.8, 1.7})};
  for (Pose& pose : layout.poses) {
    pose = {turn.apply(pose.position), turn.rotation * pose.rotation};
  }
  return layout;
}

ElementMesh meshOf(const Layout& layout, const ElementRule& rule = {}) {
  return makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
}

Deck deckOf(const Layout& layout, const ElementRule& rule = {}) {
  return test::readDeck(meshDeck(meshOf(layout, rule), "test"));
}

TEST(Deck, NumbersFitAndReadBack) {
  for (const double value : {1.0, -0.1, 1.0 / 3, -2.0 / 3e5, 123456.789, -9.87654321e-15}) {
    const std::string text = deckNumber(value);
    EXPECT_LE(text.size(), 20U);
    // Measured: 3.6e-15; numbers with an exponent lose up to three digits.
    EXPECT_NEAR(std::strtod(text.c_str(), nullptr) / value, 1, 1e-13) << text;
  }
  EXPECT_EQ(deckNumber(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(deckNumber(-1e-300), "0.");
}

TEST(Deck, KeepsTheLimitsOfItsReaders) {
  for (const bool quadratic : {false, true}) {
    const Deck deck = deckOf(turned(test::hingedSquares()), {.perEdge = 3, .quadratic = quadratic});
    EXPECT_LE(deck.longestLine, 256U);
    EXPECT_LE(deck.longestNumber, 20U);
    EXPECT_LE(deck.mostNumbers, 16U);
  }
}

TEST(Deck, HasTheVolumeOfEveryBrick) {
  for (const Layout& layout : {turned(test::hingedSquares()), turned(test::polygons())}) {
    for (const ElementRule rule : {ElementRule{1, 1}, {2, 1, true}, {3, 2}, {4, 3, true}}) {
      const Deck deck = deckOf(layout, rule);
      for (std::size_t t = 0; t < layout.bricks.size(); ++t) {
        const std::string name = "TILE_0000" + std::to_string(t);
        // Measured: 4.2e-14; coordinates of size 9 are known to 2e-15, the thickness is 0.02.
        EXPECT_NEAR(volumeOf(deck, name) / layout.bricks[t].volume, 1, 1e-12);
        for (const int k : deck.elementSets.at(name)) {
          EXPECT_GT(volumeOf(deck, deck.elements.at(k)), 0);
        }
      }
    }
  }
}

TEST(Deck, ChoosesElementsByTheSidesOfTiles) {
  const Deck deck = deckOf(test::polygons(), {.perEdge = 3, .through = 2});
  const auto typeOf = [&](const char* tile) {
    return deck.elements.at(deck.elementSets.at(tile)[0]).type;
  };
  EXPECT_EQ(typeOf("TILE_00000"), "C3D6");
  EXPECT_EQ(typeOf("TILE_00001"), "C3D8");
  EXPECT_EQ(typeOf("TILE_00002"), "C3D6");
  EXPECT_EQ(deck.elementSets.at("TILE_00000").size(), 2U * 9U);
  EXPECT_EQ(deck.elementSets.at("TILE_00001").size(), 2U * 9U);
  EXPECT_EQ(deck.elementSets.at("TILE_00002").size(), 2U * 5U * 9U);
  EXPECT_EQ(deck.elementSets.at("EALL").size(), deck.elements.size());
  const Deck quadratic = deckOf(test::polygons(), {.quadratic = true});
  EXPECT_EQ(quadratic.elements.at(1).type, "C3D15");
  EXPECT_EQ(quadratic.elements.at(1).nodes.size(), 15U);
  EXPECT_EQ(quadratic.elements.at(5).type, "C3D20");
  EXPECT_EQ(quadratic.elements.at(5).nodes.size(), 20U);
}

TEST(Deck, PutsMiddleNodesWhereAbaqusHasThem) {
  const Deck deck = deckOf(turned(test::polygons()), {.quadratic = true});
  for (const auto& [number, element] : deck.elements) {
    EXPECT_LT(largestMiddleMiss(deck, element), 1e-14);  // measured: 8.9e-16
  }
}

TEST(Deck, SharesNodesAtHinges) {
  const Layout layout = test::hingedSquares();
  const Deck deck = deckOf(layout, {.perEdge = 2, .through = 2});
  // Four tiles of 3 x 3 x 3 nodes, less the three nodes of each hinge.
  EXPECT_EQ(deck.nodes.size(), 4U * 27U - 4U * 3U);
  for (int j = 0; j < 4; ++j) {
    const std::string name = "JOINT_0000" + std::to_string(j);
    EXPECT_EQ(deck.nodeSets.at(name + "_A").size(), 3U);
    EXPECT_EQ(deck.nodeSets.at(name + "_A"), deck.nodeSets.at(name + "_B"));
  }
  EXPECT_EQ(deck.nodeSets.at("NJOINT").size(), 12U);
  EXPECT_TRUE(deck.equations.empty());
}

TEST(Deck, SharesTheNodesOfOneFaceAlone) {
  for (const JointFace face : {JointFace::Bottom, JointFace::Top}) {
    Layout layout = test::hingedSquares();
    for (Joint& joint : layout.joints) joint.face = face;
    const Deck deck = deckOf(layout);
    EXPECT_EQ(deck.nodes.size(), 4U * 18U - 4U);
    const int node = deck.nodeSets.at("JOINT_00000_A").at(0);
    const auto& onFace =
        deck.nodeSets.at(face == JointFace::Bottom ? "TILE_00000_BOT" : "TILE_00000_TOP");
    EXPECT_TRUE(std::ranges::binary_search(onFace, node));
  }
}

TEST(Deck, SaysHowFarCornersWereApart) {
  Layout layout = test::hingedSquares();
  layout.poses[3].position.x() += 0.001;
  const Deck shared = deckOf(layout);
  EXPECT_THAT(meshDeck(meshOf(layout), "test"), HasSubstr("holds together: 0.00"));
  EXPECT_NEAR(meshOf(layout).largestGap, 0.001, 1e-15);  // measured: 1e-17
  // Equations keep corners where they are.
  const Deck tied = deckOf(layout, {.joints = JointStyle::Equation});
  EXPECT_EQ(tied.nodes.size(), 4U * 18U);
  EXPECT_EQ(tied.equations.size(), 4U * 2U * 3U);
  for (const std::vector<double>& row : tied.equations) {
    ASSERT_EQ(row.size(), 6U);
    EXPECT_GT(row[0], row[3]);  // the lowest node leads
    EXPECT_EQ(row[1], row[4]);
    EXPECT_EQ(row[2], -row[5]);
    const auto& held = tied.nodeSets.at("NHOLD");
    EXPECT_FALSE(std::ranges::binary_search(held, static_cast<int>(row[0])));
  }
}

TEST(Deck, LetsOneNodeLeadACluster) {
  // Three tiles that meet at one corner, joined in a row.
  std::vector<Tile> tiles(3);
  for (int t = 0; t < 3; ++t) {
    const double turn = 2.0 * t;
    for (const double angle : {0.0, 1.5}) {
      tiles[t].vertices.emplace_back(std::cos(turn + angle), std::sin(turn + angle), 0);
    }
    tiles[t].vertices.emplace_back(0, 0, 0);
  }
  const Layout layout = test::layoutOf(tiles, {{{2, 2}, {1, 2}}, {{1, 2}, {0, 2}}});
  const ElementMesh mesh = meshOf(layout, {.joints = JointStyle::Equation});
  ASSERT_EQ(mesh.clusters.size(), 1U);
  EXPECT_EQ(mesh.clusters[0].nodes.size(), 3U);
  EXPECT_EQ(mesh.clusters[0].nodes[0], mesh.tiles[0].edges[2][0]);
  EXPECT_EQ(test::readDeck(meshDeck(mesh, "")).equations.size(), 6U);
}

TEST(Deck, TiesPatchesToReferenceNodes) {
  const Deck deck = deckOf(test::hingedSquares(),
                           {.perEdge = 4, .joints = JointStyle::Patch, .patchRadius = 0.26});
  // Four hinges, each with a patch on two faces of two tiles.
  EXPECT_EQ(deck.rigidBodies.size(), 16U);
  std::map<int, int> uses;
  for (const auto& [set, node] : deck.rigidBodies) {
    EXPECT_EQ(deck.nodeSets.at(set).size(), 3U);
    ++uses[node];
  }
  EXPECT_EQ(uses.size(), 8U);
  for (const auto& [node, count] : uses) EXPECT_EQ(count, 2);
}

TEST(Deck, NamesSetsAndSurfacesOfTiles) {
  const Deck deck = deckOf(test::hingedSquares(), {.perEdge = 2, .through = 2});
  EXPECT_EQ(deck.nodeSets.at("TILE_00003_N").size(), 27U);
  EXPECT_EQ(deck.nodeSets.at("TILE_00003_BOT").size(), 9U);
  EXPECT_EQ(deck.nodeSets.at("TILE_00003_TOP").size(), 9U);
  const int first = deck.elementSets.at("TILE_00003")[0];
  using Face = std::pair<int, std::string>;
  EXPECT_THAT(deck.surfaces.at("TILE_00003_SBOT"),
              ElementsAre(Face{first, "S1"}, Face{first + 1, "S1"}, Face{first + 2, "S1"},
                          Face{first + 3, "S1"}));
  EXPECT_THAT(deck.surfaces.at("TILE_00003_STOP"),
              ElementsAre(Face{first + 4, "S2"}, Face{first + 5, "S2"}, Face{first + 6, "S2"},
                          Face{first + 7, "S2"}));
}

TEST(Deck, WarnsOfWhatIdealHingesDo) {
  const ElementMesh mesh = meshOf(test::hingedSquares());
  EXPECT_THAT(meshDeck(mesh, "square at 0.5 s"), HasSubstr("** square at 0.5 s\n"));
  EXPECT_THAT(meshDeck(mesh, ""), HasSubstr("WARNING: joints are ideal hinges"));
  EXPECT_THAT(meshDeck(mesh, ""), HasSubstr("WARNING: forces through a single node"));
  EXPECT_THAT(jobDeck(mesh, "a_mesh.inp"), HasSubstr("*INCLUDE, INPUT=a_mesh.inp\n"));
  EXPECT_THAT(jobDeck(mesh, "a_mesh.inp"), Not(HasSubstr("*EQUATION")));
  const ElementMesh tied = meshOf(test::hingedSquares(), {.joints = JointStyle::Equation});
  EXPECT_THAT(jobDeck(tied, ""), HasSubstr("WARNING: nodes that follow in *EQUATION"));
}

}  // namespace
}  // namespace kirireel
