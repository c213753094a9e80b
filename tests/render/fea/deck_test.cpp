#include "render/fea/deck.h"

#include <algorithm>
#include <filesystem>
#include <random>

#include <Eigen/SVD>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/job.h"
#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/trajectory/sheet.h"
#include "tests/render/fea/read_deck.h"
#include "tests/support/layouts.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using test::Deck;
using test::Layout;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

/// Rotates and moves the layout, so no coordinate is a round number.
Layout turned(Layout layout) {
  const Pose turn{{7, -3, 1e-5}, rotationFromVector({0.3, -0.8, 1.7})};
  for (Pose& pose : layout.poses) {
    pose = {turn.apply(pose.position), turn.rotation * pose.rotation};
  }
  return layout;
}

fea::ElementMesh meshOf(const Layout& layout, const fea::ElementRule& rule = {}) {
  return fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
}

const fea::DeckOrigin kOrigin = {"squares", "final", 0.5, 0.02, 0, "Kirireel", "a run"};

std::string textOf(const fea::ElementMesh& mesh, const fea::DeckSettings& settings = {}) {
  return fea::meshDeck(mesh, settings, kOrigin);
}

Deck deckOf(const Layout& layout, const fea::ElementRule& rule = {},
            const fea::DeckSettings& settings = {}) {
  return test::readDeck(textOf(meshOf(layout, rule), settings));
}

TEST(Deck, NumbersFitAndReadBack) {
  for (const double value : {1.0, -0.1, 1.0 / 3, -2.0 / 3e5, 123456.789, -9.87654321e-15}) {
    const std::string text = fea::deckNumber(value);
    EXPECT_LE(text.size(), 20U);
    // Measured: 3.6e-15; numbers with an exponent lose up to three digits.
    EXPECT_NEAR(std::strtod(text.c_str(), nullptr) / value, 1, 1e-13) << text;
  }
  EXPECT_EQ(fea::deckNumber(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(fea::deckNumber(-1e-300), "0.");
  EXPECT_EQ(fea::deckNumber(2500), "2500.0");
  EXPECT_EQ(fea::deckNumber(-2e22), "-2.0e+22");
  // CalculiX reads a number without point and exponent as an integer.
  for (const double value :
       {0.0, 1.0, -2500.0, 1e15, 123456789012345.0, 1e16, 1e20, 7e-90, 2.0 / 3e-9}) {
    const std::string text = fea::deckNumber(value);
    EXPECT_LE(text.size(), 20U);
    EXPECT_NE(text.find('.'), std::string::npos) << text;
    EXPECT_NEAR(std::strtod(text.c_str(), nullptr), value, 1e-13 * std::abs(value)) << text;
  }
}

TEST(Deck, KeepsTheLimitsOfItsReaders) {
  for (const bool quadratic : {false, true}) {
    const Deck deck = deckOf(turned(test::hingedSquares()), {.perEdge = 3, .quadratic = quadratic});
    EXPECT_LE(deck.longestLine, 256U);
    EXPECT_LE(deck.longestNumber, 20U);
    EXPECT_LE(deck.maxNumbers, 16U);
  }
}

TEST(Deck, HasTheVolumeOfEveryBrick) {
  for (const Layout& layout : {turned(test::hingedSquares()), turned(test::polygons())}) {
    for (const fea::ElementRule& rule :
         {fea::ElementRule{1, 1}, {2, 1, false}, {3, 2}, {4, 3, false}}) {
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

TEST(Deck, DividesTilesOfAnyNumberOfSidesIntoHexahedra) {
  const Deck deck = deckOf(test::polygons(), {.perEdge = 4, .through = 2});
  // A triangle is three grids of 2 x 2, a pentagon five triangles.
  EXPECT_EQ(deck.elementSets.at("TILE_00000").size(), 2U * 12U);
  EXPECT_EQ(deck.elementSets.at("TILE_00001").size(), 2U * 16U);
  EXPECT_EQ(deck.elementSets.at("TILE_00002").size(), 2U * 5U * 12U);
  EXPECT_EQ(deck.elementSets.at("EALL").size(), deck.elements.size());
  for (const auto& [number, element] : deck.elements) {
    EXPECT_EQ(element.type, "C3D20R");
    EXPECT_EQ(element.nodes.size(), 20U);
  }
  EXPECT_EQ(deckOf(test::polygons(), {.quadratic = false}).elements.at(1).type, "C3D8I");
  // With reduced integration one element across has no stiffness against some deformations.
  EXPECT_EQ(deckOf(test::polygons(), {.perEdge = 1}).elements.at(7).type, "C3D20");
}

TEST(Deck, DividesEdgesByTheirLengths) {
  const Layout strip =
      test::layoutOf({model::Tile{{{0, 0, 0}, {10, 0, 0}, {10, 1, 0}, {0, 1, 0}}}}, {});
  EXPECT_EQ(deckOf(strip, {.through = 1, .size = 0.5}).elements.size(), 20U * 2U);
  EXPECT_EQ(deckOf(strip, {.through = 1, .size = 0.51}).elements.size(), 20U * 2U);
  EXPECT_EQ(deckOf(strip).elements.size(), 8U * 8U * 2U);
}

TEST(Deck, PutsMiddleNodesWhereAbaqusHasThem) {
  const Deck deck = deckOf(turned(test::polygons()), {.quadratic = true});
  for (const auto& [number, element] : deck.elements) {
    EXPECT_LT(largestMiddleMiss(deck, element), 1e-14);  // measured: 1.0e-15
  }
}

TEST(Deck, SharesNodesAtHinges) {
  const Layout layout = test::hingedSquares();
  const Deck deck = deckOf(layout, {.perEdge = 2, .through = 2, .quadratic = false});
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

TEST(Deck, SharesOnlyTheNodesOfOneFace) {
  for (const model::JointFace face : {model::JointFace::Bottom, model::JointFace::Top}) {
    Layout layout = test::hingedSquares();
    for (model::Joint& joint : layout.joints) joint.face = face;
    const Deck deck = deckOf(layout, {2, 1, false});
    EXPECT_EQ(deck.nodes.size(), 4U * 18U - 4U);
    const int node = deck.nodeSets.at("JOINT_00000_A").at(0);
    const auto& onFace =
        deck.nodeSets.at(face == model::JointFace::Bottom ? "TILE_00000_BOT" : "TILE_00000_TOP");
    EXPECT_TRUE(std::ranges::binary_search(onFace, node));
  }
}

TEST(Deck, ReportsHowFarCornersWereApart) {
  Layout layout = test::hingedSquares();
  layout.poses[3].position.x() += 0.001;
  EXPECT_THAT(textOf(meshOf(layout)), HasSubstr("holds together: 0.00"));
  EXPECT_NEAR(meshOf(layout).largestGap, 0.001, 1e-15);  // measured: 8.7e-19
  // Equations do not move corners.
  const Deck tied = deckOf(layout, {2, 1, false, fea::JointStyle::Equation});
  EXPECT_EQ(tied.nodes.size(), 4U * 18U);
  EXPECT_EQ(tied.equations.size(), 4U * 2U * 3U);
  for (const std::vector<double>& row : tied.equations) {
    ASSERT_EQ(row.size(), 6U);
    EXPECT_GT(row[0], row[3]);  // the lowest node leads
    EXPECT_EQ(row[1], row[4]);
    EXPECT_EQ(row[2], -row[5]);
  }
}

TEST(Deck, HasOneIndependentNodePerCluster) {
  // Three tiles that meet at one corner, joined in a row.
  std::vector<model::Tile> tiles(3);
  for (int t = 0; t < 3; ++t) {
    const double turn = 2.0 * t;
    for (const double angle : {0.0, 1.5}) {
      tiles[t].vertices.emplace_back(std::cos(turn + angle), std::sin(turn + angle), 0);
    }
    tiles[t].vertices.emplace_back(0, 0, 0);
  }
  const Layout layout = test::layoutOf(tiles, {{{2, 2}, {1, 2}}, {{1, 2}, {0, 2}}});
  const fea::ElementMesh mesh = meshOf(layout, {2, 1, false, fea::JointStyle::Equation});
  ASSERT_EQ(mesh.clusters.size(), 1U);
  EXPECT_EQ(mesh.clusters[0].nodes.size(), 3U);
  EXPECT_EQ(mesh.clusters[0].nodes[0], mesh.tiles[0].edges[2][0]);
  EXPECT_EQ(test::readDeck(textOf(mesh)).equations.size(), 6U);
}

constexpr fea::ElementRule kPatches{4, 1, false, fea::JointStyle::Patch, 0.26};

TEST(Deck, TiesPatchesToReferenceNodes) {
  const Deck deck = deckOf(test::hingedSquares(), kPatches);
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

TEST(Deck, GivesAbaqusOneNodeForEachRigidBody) {
  const fea::ElementMesh mesh = meshOf(test::hingedSquares(), kPatches);
  const std::string text = textOf(mesh, {.solver = fea::Solver::Abaqus});
  const Deck deck = test::readDeck(text);
  std::map<int, int> uses;
  for (const auto& [set, node] : deck.rigidBodies) ++uses[node];
  EXPECT_EQ(uses.size(), 16U);
  EXPECT_EQ(deck.nodes.size(), mesh.nodes.size() + 16U);
  EXPECT_THAT(text, HasSubstr("*RIGID BODY, PIN NSET=PATCH_00000_0, REF NODE="));
  EXPECT_THAT(text, HasSubstr("*MPC\nPIN, "));
  EXPECT_EQ(text.find("*NODE,"), text.rfind("*NODE,"));  // one block: some readers support only one
}

TEST(Deck, ChoosesRadiusAndElementsOfPatches) {
  const fea::ElementMesh mesh = meshOf(test::hingedSquares(), {.joints = fea::JointStyle::Patch});
  EXPECT_DOUBLE_EQ(mesh.rule.patchRadius, 0.25);  // of edges 1 m long
  for (const fea::NodeCluster& cluster : mesh.clusters) {
    for (const auto& patch : cluster.patches) EXPECT_GE(patch.size(), 3U);
  }
  // A radius of a hundredth of an edge needs 50 quadratic elements along it.
  const fea::ElementMesh small = meshOf(
      test::hingedSquares(), {.through = 1, .joints = fea::JointStyle::Patch, .patchRadius = 0.01});
  EXPECT_EQ(small.tiles[0].layerCount, 50 * 50);
}

TEST(Deck, OmitsSetsThatAreNotRequested) {
  const Layout layout = test::hingedSquares();
  const Deck none = deckOf(layout, {}, {.sets = fea::SetChoice::None});
  EXPECT_THAT(none.elementSets, testing::SizeIs(1));
  EXPECT_FALSE(none.nodeSets.contains("JOINT_00000_A"));
  EXPECT_TRUE(none.nodeSets.contains("XMIN"));
  const Deck joints = deckOf(layout, {}, {.sets = fea::SetChoice::Joints});
  EXPECT_TRUE(joints.nodeSets.contains("JOINT_00000_A"));
  EXPECT_TRUE(joints.surfaces.empty());
}

TEST(Deck, NamesTheEndsOfTheSheet) {
  const Layout layout = test::hingedSquares(0);
  const Deck deck = deckOf(layout, {2, 1, false});
  for (const auto& [name, axis, end] :
       {std::tuple{"XMIN", 0, -1}, {"XMAX", 0, 1}, {"YMIN", 1, -1}, {"YMAX", 1, 1}}) {
    std::vector<int> expected;
    for (const auto& [number, at] : deck.nodes) {
      if (std::abs(at[axis] - end) < 1e-12) expected.push_back(number);
    }
    EXPECT_EQ(deck.nodeSets.at(name), expected) << name;
    EXPECT_GE(expected.size(), 2U * 5U);  // two edges of three nodes on two faces, some shared
  }
  EXPECT_EQ(deck.nodeSets.at("BOXCORNERS").size(), 2U * 4U);
  EXPECT_FALSE(deck.nodeSets.contains("ZMIN"));  // the tiles' own bottoms
}

TEST(Deck, WritesMillimetresToo) {
  const Layout layout = test::hingedSquares();
  const fea::ElementMesh mesh = meshOf(layout);
  const fea::DeckSettings settings{.material = {2e9, 0.3, 1200},
                                   .unit = fea::DeckUnit::MillimetresNewtons};
  const Deck deck = test::readDeck(textOf(mesh, settings));
  EXPECT_LT((deck.nodes.at(1) - 1000 * mesh.nodes[0]).norm(), 1e-9);
  const fea::DeckJob parts = fea::staticJob(mesh, settings, kOrigin, "a_mesh.inp");
  const std::string job = parts.sets + parts.text;
  EXPECT_THAT(job, HasSubstr("*ELASTIC\n2000.0, 0.3\n*DENSITY\n1.2e-09\n"));
  EXPECT_THAT(job, HasSubstr("mm, N, t, s, MPa"));
}

TEST(Deck, NamesSetsAndSurfacesOfTiles) {
  const Deck deck = deckOf(test::hingedSquares(), {.perEdge = 2, .through = 2, .quadratic = false});
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

TEST(Deck, NamesTheSidesOfTilesByTheirEdges) {
  const Deck deck = deckOf(test::polygons(), {.perEdge = 4, .through = 2});
  EXPECT_EQ(deck.surfaces.at("TILE_00001_SIDE").size(), 4U * 4U * 2U);
  for (int edge = 0; edge < 5; ++edge) {
    const std::string name = "TILE_00002_S" + std::to_string(edge);
    EXPECT_EQ(deck.surfaces.at(name).size(), 4U * 2U) << name;
  }
  // The corners of a face lie on the line between two corners of the tile.
  const test::Layout layout = test::polygons();
  const Vector3 from = layout.poses[1].apply(layout.bricks[1].bottom[2]);
  const Vector3 along = (layout.poses[1].apply(layout.bricks[1].bottom[3]) - from).normalized();
  for (const auto& [number, face] : deck.surfaces.at("TILE_00001_S2")) {
    const int side = face[1] - '3';
    for (const int k : {side, (side + 1) % 4}) {
      Vector3 offset = deck.nodes.at(deck.elements.at(number).nodes[k]) - from;
      offset.z() = 0;
      EXPECT_LT(offset.cross(along).norm(), 1e-12);  // measured: 1.1e-16
    }
  }
}

TEST(Deck, ReportsItsSourceAndIdealHinges) {
  const fea::ElementMesh mesh = meshOf(test::hingedSquares());
  EXPECT_THAT(textOf(mesh), HasSubstr("** Model squares, state final, at 0.5 s.\n"));
  EXPECT_THAT(textOf(mesh), HasSubstr("bricks 0.02 m thick.\n** Run: a run\n"));
  EXPECT_THAT(textOf(mesh), HasSubstr("overlap of two bricks in this state: 0. m.\n"));
  const std::string inMillimetres =
      fea::meshDeck(mesh, {.unit = fea::DeckUnit::MillimetresNewtons}, kOrigin);
  EXPECT_THAT(inMillimetres, HasSubstr("Units: mm, N, t, s, MPa; bricks 20"));
  EXPECT_THAT(inMillimetres, HasSubstr(" mm thick.\n"));
  EXPECT_THAT(inMillimetres, Not(HasSubstr(" m.\n")));
  EXPECT_THAT(textOf(mesh), Not(HasSubstr("WARNING: bricks overlap")));
  fea::DeckOrigin overlapping = kOrigin;
  overlapping.overlap = 0.01;
  EXPECT_THAT(fea::meshDeck(mesh, {}, overlapping),
              HasSubstr("WARNING: bricks overlap by 0.5 of their thickness"));
  EXPECT_THAT(textOf(mesh), HasSubstr("WARNING: joints are ideal hinges"));
  EXPECT_THAT(textOf(mesh), HasSubstr("WARNING: forces through a single node"));
  const std::string job = fea::staticJob(mesh, {}, kOrigin, "a_mesh.inp").text;
  EXPECT_THAT(job, testing::StartsWith("*HEADING\nsquares, state final, pulled at both ends"));
  EXPECT_THAT(job, HasSubstr("*INCLUDE, INPUT=a_mesh.inp\n"));
  EXPECT_THAT(job, Not(HasSubstr("*EQUATION")));
  EXPECT_THAT(job, HasSubstr("*NODE FILE\nU, RF\n*EL FILE\nS, E\n"));
  EXPECT_THAT(fea::staticJob(mesh, {.solver = fea::Solver::Abaqus}, kOrigin, "").text,
              HasSubstr("*ELEMENT OUTPUT\nS, E, MISES\n"));
  const fea::ElementMesh tied =
      meshOf(test::hingedSquares(), {.joints = fea::JointStyle::Equation});
  EXPECT_THAT(fea::staticJob(tied, {}, kOrigin, "").text,
              HasSubstr("WARNING: nodes that follow in *EQUATION"));
}

/// The number of motions of rigid tiles without strain, by another method: the first-order mobility
/// (sim/trajectory/sheet.h), and the six of the whole.
std::size_t freeMotions(const Layout& layout, double thickness) {
  model::Model model;
  model.joints = layout.joints;
  model.tiles = brick::bottomTiles(layout.bricks, layout.poses);
  return 6 +
         trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, thickness).freedoms;
}

TEST(Supports, AreSixAndOneForEachMechanism) {
  // Four squares on hinges: one mechanism in the plane. On ball joints of one face a square can
  // also tilt.
  for (const model::JointFace face : {model::JointFace::Both, model::JointFace::Bottom}) {
    Layout layout = test::hingedSquares();
    for (model::Joint& joint : layout.joints) joint.face = face;
    for (const fea::JointStyle style :
         {fea::JointStyle::Shared, fea::JointStyle::Equation, fea::JointStyle::Patch}) {
      const fea::ElementMesh mesh = meshOf(layout, {.joints = style});
      EXPECT_EQ(fea::minSupports(mesh).size(), freeMotions(layout, 0.02));
      const std::vector<bool> follows = fea::followers(mesh);
      for (const fea::NodeDisplacement& held : fea::minSupports(mesh))
        EXPECT_FALSE(follows[held.node]);
    }
  }
  EXPECT_EQ(fea::minSupports(meshOf(test::polygons())).size(),
            3U * 6U);  // no joints
}

TEST(Supports, AreAsManyHoweverThinLongOrInaccurateTheSheet) {
  for (const double thickness : {0.02, 0.002}) {
    for (const auto& [rows, columns] : {std::pair{2, 2}, {5, 5}, {2, 30}}) {
      const model::Model model = generate::makeTessellation(test::squares(rows, columns, 0.7));
      Layout layout = test::layoutOf(model.tiles, model.joints, thickness);
      const std::size_t known = freeMotions(layout, thickness);
      const fea::ElementRule rule{.perEdge = 2, .through = 1, .joints = fea::JointStyle::Equation};
      const auto supports = [&] {
        return fea::minSupports(
            fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule));
      };
      EXPECT_EQ(supports().size(), known) << rows << 'x' << columns << ' ' << thickness;
      // Corners a millionth of a tile apart, each by a different step.
      for (std::size_t t = 0; t < layout.poses.size(); ++t) {
        const double phase = 1.7 * static_cast<double>(t);
        layout.poses[t].position += 1e-6 * Vector3(std::sin(phase), std::cos(phase), 0);
      }
      EXPECT_EQ(supports().size(), known) << rows << 'x' << columns << ' ' << thickness;
    }
  }
}

TEST(Supports, AreThoseOfTheMobilityOnEveryModel) {
  int states = 0;
  for (const auto& entry : std::filesystem::directory_iterator(KIRIREEL_SOURCE_DIR "/data")) {
    if (!std::filesystem::exists(entry.path() / "vertices.txt")) continue;
    std::vector<std::string> notes;
    const model::Model model = formats::readModel(entry.path(), std::nullopt, notes);
    std::vector<std::vector<model::Tile>> tried = {model.tiles};
    if (model.target) tried.push_back(*model.target);
    for (const std::vector<model::Tile>& tiles : tried) {
      const Layout layout = test::layoutOf(tiles, model.joints);
      const fea::ElementMesh mesh =
          meshOf(layout, {.perEdge = 2, .through = 1, .joints = fea::JointStyle::Equation});
      if (mesh.largestGap > 1e-9) continue;  // open joints: not a state of the sheet
      ++states;
      EXPECT_EQ(fea::minSupports(mesh).size(), freeMotions(layout, 0.02)) << entry.path();
    }
  }
  EXPECT_GE(states, 30);
}

TEST(Supports, CountTheFlatMechanismsOfClosedSquares) {
  // Slits of n x n squares open along each of their 2 n - 2 lines, and the sheet turns as one: 2 n
  // + 1 motions in the plane. With hinges the whole has three more motions. On ball joints of one
  // face each tile has three, less one for each of the 2 n (n - 1) joints.
  for (const int n : {5, 20, 40}) {
    model::Model model = generate::makeTessellation(test::squares(n, n, 0));
    for (const model::JointFace face : {model::JointFace::Both, model::JointFace::Bottom}) {
      for (model::Joint& joint : model.joints) joint.face = face;
      const Layout layout = test::layoutOf(model.tiles, model.joints, 0.02);
      const std::size_t outOfPlane =
          face == model::JointFace::Both ? 3 : 3 * n * n - 2 * n * (n - 1);
      // Without delayed pivots 73 instead of 84 for 40 x 40 hinges.
      EXPECT_EQ(fea::minSupports(meshOf(layout, {.perEdge = 1, .through = 1})).size(),
                2 * n + 1 + outOfPlane)
          << n;
    }
  }
}

/// The smallest nonzero singular value of a matrix, relative to its largest.
double minSingularValue(const Eigen::MatrixXd& matrix, Eigen::Index nullity) {
  const Eigen::VectorXd values = Eigen::BDCSVD<Eigen::MatrixXd>(matrix).singularValues();
  return values[matrix.cols() - nullity - 1] / values[0];
}

TEST(Supports, HoldTheUnknownsThatMoveMost) {
  // A chain of tiles with as many equations as unknowns of a tile. In some tiles one unknown hardly
  // appears in the equations. It moves most in the chain's six motions.
  constexpr int kTiles = 9;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const double weak : {1e-2, 1e-4, 1e-6}) {
    for (int round = 0; round < 10; ++round) {
      std::vector<fea::PairEquations> equations;
      Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(6 * (kTiles - 1), 6 * kTiles);
      const int kind = static_cast<int>(random() % 3);
      for (int t = 0; t + 1 < kTiles; ++t) {
        fea::PairEquations pair{t, t + 1, {}, {}};
        for (auto* rows : {&pair.first, &pair.second}) {
          const int tile = rows == &pair.first ? t : t + 1;
          *rows = Eigen::Matrix<double, 6, 6>::NullaryExpr([&] { return number(random); });
          if (tile % 3 == kind) rows->col(round % 6) *= weak;
          dense.block<6, 6>(6 * t, 6 * tile) = *rows;
        }
        equations.push_back(pair);
      }
      const std::vector<fea::FreeColumn> free =
          fea::freeColumns(kTiles, equations, std::vector<bool>(kTiles), 1e-8);
      ASSERT_EQ(free.size(), 6U);
      Eigen::MatrixXd held = dense;
      for (const fea::FreeColumn& column : free)
        held.col(6 * column.tile + column.unknown).setZero();
      // With these nodes fixed, the smallest stiffness is not much smaller. Without delayed pivots:
      // down to 1e-7 of it.
      EXPECT_GT(minSingularValue(held, 6), 0.02 * minSingularValue(dense, 6))
          << weak << ' ' << round;
    }
  }
}

TEST(Drive, RefusesMissingOrRepeatedTiles) {
  fea::ElementMesh mesh = meshOf(test::hingedSquares());
  const auto refusal = [&](const std::vector<int>& tiles) -> std::string {
    try {
      fea::drivenTiles(mesh, {fea::DriveChoice::Some, tiles});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal({0, 3}), "accepted");
  EXPECT_EQ(refusal({4}), "error: --drive names tile 4, but the model has tiles 0 to 3");
  mesh.rule.countsFrom = 1;
  EXPECT_EQ(refusal({0}), "error: --drive names tile 0, but the model has tiles 1 to 4");
  EXPECT_EQ(fea::drivenTiles(mesh, {fea::DriveChoice::Some, {4, 1}}), (std::vector<int>{0, 3}));
  mesh.rule.countsFrom = 0;
  EXPECT_EQ(refusal({2, 0, 2}),
            "error: --drive names tile 2 twice, which would prescribe its displacements twice; "
            "leave one out");
}

TEST(Contact, PairsTheFlanksNextToEachJoint) {
  const fea::ElementMesh mesh = meshOf(test::hingedSquares(), {.perEdge = 4, .through = 1});
  // Four joints with a gap on either side of each; the inner gap's flanks meet at two joints each.
  const std::vector<fea::ContactPair> pairs = fea::contactPairs(mesh);
  EXPECT_EQ(pairs.size(), 8U);
  for (const fea::ContactPair& pair : pairs) {
    EXPECT_GE(pair.a.size(), 2U);  // of four, those at joints left out
    EXPECT_LE(pair.a.size(), 3U);
  }
}

TEST(Contact, IsBetweenSolidTilesWithFlanksAwayFromJoints) {
  const auto refusal = [](const fea::ElementRule& rule) {
    return test::refusalOf([&] { fea::contactPairs(meshOf(test::hingedSquares(), rule)); });
  };
  EXPECT_THAT(refusal({.family = fea::ElementFamily::Shell}),
              HasSubstr("remove --deck-contacts, or --shells and --plane-stress"));
  EXPECT_THAT(refusal({.perEdge = 1, .through = 1, .quadratic = false}),
              HasSubstr("use at least 3 elements per edge"));
}

TEST(Periodic, ReportsWhichSheetsRepeat) {
  const auto refusal = [](const Layout& layout, const fea::ElementRule& rule) {
    return test::refusalOf([&] { fea::periodicity(meshOf(layout, rule)); });
  };
  EXPECT_EQ(refusal(test::hingedSquares(), {}), "accepted");
  EXPECT_THAT(refusal(test::hingedSquares(), {.family = fea::ElementFamily::Shell}),
              HasSubstr("remove --shells"));
  const Layout triangle =
      test::layoutOf({model::Tile{{{0, 0, 0}, {1, 0.2, 0}, {0.3, 0.8, 0}}}}, {});
  EXPECT_THAT(refusal(triangle, {}),
              HasSubstr("choose a state or a number of tiles in which the sheet repeats"));
}

TEST(Periodic, FollowsNoNodeThatFollows) {
  const Layout layout =
      test::layoutOf({model::Tile{{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}}}, {});
  const fea::ElementMesh mesh = meshOf(layout, {.perEdge = 2, .through = 1, .quadratic = false});
  const fea::Periodicity found = fea::periodicity(mesh);
  EXPECT_EQ(found.period, (std::array<double, 2>{2, 1}));
  // Two levels of five nodes of nine: three at XMAX and three at YMAX, one of them both.
  ASSERT_EQ(found.ties.size(), 10U);
  int both = 0;
  for (const fea::PeriodicTie& tie : found.ties) {
    for (const fea::PeriodicTie& other : found.ties) EXPECT_NE(tie.leader, other.node);
    const Vector3 offset = mesh.nodes[tie.node] - mesh.nodes[tie.leader];
    EXPECT_LT((offset - Vector3(2 * tie.times[0], tie.times[1], 0)).norm(), 1e-12);
    both += tie.times[0] * tie.times[1];
  }
  EXPECT_EQ(both, 2);
}

TEST(StateMap, MovesSolids) {
  const fea::ElementMesh mesh =
      meshOf(test::hingedSquares(), {.family = fea::ElementFamily::Shell});
  EXPECT_THAT(test::refusalOf([&] { fea::stateMapJob(mesh, mesh, {}, kOrigin, "x_mesh.inp"); }),
              HasSubstr("--state-map moves solids only"));
}

}  // namespace
}  // namespace kirireel
