// Springs, contact, ties and maps of decks in CalculiX, each against a calculation by hand. Skipped
// if ccx is not installed.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/job.h"
#include "tests/render/fea/run_deck.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::displacements;
using test::JobEnd;
using test::kOrigin;
using test::Layout;
using ::testing::HasSubstr;

class CalculixJobs : public testing::Test {
 protected:
  void SetUp() override {
    if (!test::hasProgram("ccx")) GTEST_SKIP() << "install calculix-ccx to check decks with it";
  }
};

model::Tile square(double x, double y) {
  return model::Tile{{{x, y, 0}, {x + 1, y, 0}, {x + 1, y + 1, 0}, {x, y + 1, 0}}};
}

/// The independent nodes, of all tiles or of one.
std::vector<int> leaders(const fea::ElementMesh& mesh, int tile = -1) {
  const std::vector<bool> follows = fea::followers(mesh);
  std::vector<int> nodes;
  for (int k = 0; k < static_cast<int>(mesh.nodes.size()); ++k) {
    const bool isMeant = tile < 0 || std::ranges::binary_search(mesh.tiles[tile].nodes, k);
    if (!follows[k] && isMeant) nodes.push_back(k);
  }
  return nodes;
}

/// Tiles in another plane.
std::vector<model::Tile> placed(std::vector<model::Tile> tiles, const Quaternion& turn) {
  for (model::Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
  }
  return tiles;
}

/// Two squares, diagonal to each other, on a hinge at (1, 1) with a spring of 5 N m/rad. The lower
/// one is fixed, the upper one rotates.
class SpringHinge {
 public:
  /// `rest`: rest angle of the spring. `turn` rotates both squares.
  explicit SpringHinge(double rest, const Quaternion& turn = Quaternion::Identity())
      : layout_(test::layoutOf(placed({square(0, 0), square(1, 1)}, turn),
                               {{{0, 2}, {1, 0}, model::JointFace::Both}})),
        mesh_(fea::makeElementMesh(layout_.bricks, layout_.joints, layout_.poses,
                                   {.perEdge = 4, .joints = fea::JointStyle::Patch})) {
    const brick::Hinge hinge =
        brick::findHinges(layout_.bricks, brick::makePivots(layout_.joints, layout_.bricks), true)
            .hinges.at(0);
    // Angles grow with the rotation of tile 1 against tile 0, or of tile 0 against tile 1.
    const double sign = (hinge.brickA == 0 ? 1 : -1) * hinge.axis.dot(turn * Vector3::UnitZ());
    const double start = brick::hingeAngle(hinge, layout_.poses);
    const std::vector<brick::HingeSpring> springs = {{hinge, 5, start + sign * rest, 0}};
    EXPECT_EQ(fea::addHingeSprings(mesh_, layout_.bricks, springs, layout_.poses), 0);
  }

  /// The corner at (2, 1), through the thickness.
  const std::vector<int>& corner() const { return mesh_.tiles[1].edges[1]; }

  /// A job with these loads and that of the spring. `isFlat` fixes all nodes along z.
  JobEnd run(const std::string& step, const std::string& load, bool isFlat = true) const {
    std::string moments = "*CLOAD\n";
    fea::PatchDeck(mesh_, fea::Solver::Calculix).appendMoments(moments, fea::DeckUnit::Model);
    if (moments == "*CLOAD\n") moments.clear();
    std::string job = test::ownJob(
        test::setOf("HELD", leaders(mesh_, 0)) + test::setOf("FLAT", leaders(mesh_)) +
            test::setOf("DRIVEN", corner()),
        isFlat ? "HELD, 1, 3\nFLAT, 3, 3\n" : "HELD, 1, 3\n", load + moments,
        "DRIVEN, FREQUENCY=1000, TOTALS=ONLY\nRF\n*NODE PRINT, FREQUENCY=1000, NSET=DRIVEN");
    const std::string plain = "*STEP\n*STATIC\n";
    job.replace(job.find(plain), plain.size(), step);
    const JobEnd end = test::run(fea::meshDeck(mesh_, {}, kOrigin), job);
    EXPECT_THAT(end.log, HasSubstr("Job finished"));
    return end;
  }

 private:
  Layout layout_;
  fea::ElementMesh mesh_;
};

TEST_F(CalculixJobs, SpringsTurnTilesByMomentOverStiffness) {
  for (const double rest : {0.0, 2e-4}) {
    const SpringHinge hinge(rest);
    // 2 mN in y at an arm of 1 m.
    const JobEnd end =
        hinge.run("*STEP\n*STATIC\n", fmt::format("*CLOAD\n{}, 2, 2e-3\n", hinge.corner()[0] + 1));
    const std::size_t rows = end.data.rfind("displacements");
    ASSERT_NE(rows, std::string::npos);
    const std::vector<Vector3> moved = displacements(end.data.substr(rows));
    ASSERT_FALSE(moved.empty());
    EXPECT_NEAR(moved[0].y() / (2e-3 / 5 + rest), 1, 1e-4);  // measured: 1 + 6.2e-6
  }
}

// By hand: 0.5 N m turn a spring of 5 N m/rad by 0.1 and store 0.025 J.
TEST_F(CalculixJobs, SpringsInAnyPlaneStoreTheSameEnergy) {
  for (const Vector3& turn : {Vector3(0, 0, 0), Vector3(0.5 * std::numbers::pi, 0, 0),
                              Vector3(0, -0.5 * std::numbers::pi, 0),
                              Vector3(std::numbers::pi, 0, 0), Vector3(0.3, -0.8, 1.7)}) {
    for (const double rest : {0.0, 0.02}) {
      const Quaternion rotation = rotationFromVector(turn);
      const SpringHinge hinge(rest, rotation);
      const Vector3 across = rotation * Vector3::UnitY();
      std::string load = "*CLOAD\n";
      for (int axis = 0; axis < 3; ++axis) {
        load += fmt::format("{}, {}, {}\n", hinge.corner()[0] + 1, axis + 1,
                            fea::deckNumber(0.5 * across[axis]));
      }
      const JobEnd end = hinge.run("*STEP\n*STATIC\n", load, false);
      const std::size_t rows = end.data.rfind("displacements");
      ASSERT_NE(rows, std::string::npos);
      const std::vector<Vector3> moved = displacements(end.data.substr(rows));
      ASSERT_FALSE(moved.empty());
      const double angle = across.dot(moved[0]) - rest;
      EXPECT_NEAR(0.5 * 0.5 * angle / 0.025, 1, 1e-4);  // measured: 1 + 1.2e-5
    }
  }
}

TEST_F(CalculixJobs, SpringsFollowTheirAngleForAnyRotation) {
  const double turn = 0.5;
  for (const double rest : {0.0, 0.2}) {
    const SpringHinge hinge(rest);
    const JobEnd end = hinge.run(
        "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1.\n"
        "*CONTROLS, PARAMETERS=FIELD, FIELD=DISPLACEMENT\n0.005, 0.01, 1., 1.\n",
        fmt::format("*BOUNDARY\nDRIVEN, 2, 2, {}\n", std::sin(turn)));
    const std::vector<Vector3> forces = test::totalForces(end.data, "DRIVEN");
    ASSERT_FALSE(forces.empty());
    const double moment = forces.back().y() * std::cos(turn);
    // Measured: 1 + 4.7e-6.
    EXPECT_NEAR(moment / (5 * (turn - rest)), 1, 1e-4) << forces.back().transpose();
  }
}

/// The resultant force of one flank on the other, and its moment about the origin.
std::pair<Vector3, Vector3> contactForces(const std::string& data) {
  const std::size_t title = data.rfind("total surface force");
  std::istringstream rows(title == std::string::npos ? "" : data.substr(data.find('\n', title)));
  std::pair<Vector3, Vector3> found(Vector3::Zero(), Vector3::Zero());
  rows >> found.first.x() >> found.first.y() >> found.first.z();
  rows >> found.second.x() >> found.second.y() >> found.second.z();
  return found;
}

TEST_F(CalculixJobs, FlanksThatTouchCarryTheMomentAboutTheirHinge) {
  // Side by side, joined at (1, 0): 100 N on (2, 1) press the right square on the left one.
  const Layout layout =
      test::layoutOf({square(0, 0), square(1, 0)}, {{{0, 1}, {1, 0}, model::JointFace::Both}});
  const fea::ElementMesh mesh = fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                                     {.perEdge = 8, .through = 1});
  const std::vector<fea::ContactPair> pairs = fea::contactPairs(mesh);
  ASSERT_EQ(pairs.size(), 2U);
  fea::DeckSettings settings;
  settings.contactFriction = 0;
  std::string cards;
  fea::appendContactCards(cards, pairs.size(), settings, 0.02);
  const std::vector<int>& loaded = mesh.tiles[1].edges[2];
  std::string load = "*CLOAD\n";
  for (const int node : loaded) {
    load += fmt::format("{}, 1, {}\n", node + 1, -100.0 / static_cast<double>(loaded.size()));
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    load += fmt::format("*CONTACT PRINT, SLAVE=CONTACT_{0:05}_A, MASTER=CONTACT_{0:05}_B\nCF\n", k);
  }
  std::string job =
      test::ownJob(test::setOf("FLAT", leaders(mesh)), "XMIN, 1, 3\nFLAT, 3, 3\n", load, "XMAX");
  job.insert(job.find("*BOUNDARY"), cards);
  const JobEnd end = test::run(fea::meshDeck(mesh, settings, kOrigin), job);
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  const auto [force, moment] = contactForces(end.data);
  // About (1, 0): 100 N times 1 m, for any distribution of the pressure.
  const double about = moment.z() - (1 * force.y() - 0 * force.x());
  EXPECT_NEAR(std::abs(about), 100, 1e-2);  // measured: 100.0018
}

/// The results of a periodic job at its control nodes, and the energy of the sheet.
struct Strained {
  std::vector<Vector3> moved;
  double energy = 0;  ///< joules
};

Strained runPeriodic(const fea::ElementMesh& mesh) {
  fea::DeckSettings settings;
  settings.periodic = true;
  const fea::DeckJob job = fea::periodicJob(mesh, settings, kOrigin, "x_mesh.inp");
  const JobEnd end = test::run(fea::meshDeck(mesh, settings, kOrigin), job.text);
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  const std::size_t energy = end.data.find("total internal energy");
  if (energy == std::string::npos) return {};
  return {displacements(end.data.substr(0, end.data.find("forces (fx"))),
          std::strtod(end.data.c_str() + end.data.find('\n', energy), nullptr)};
}

TEST_F(CalculixJobs, APeriodicSheetIsStrainedUniformly) {
  const Layout layout = test::layoutOf({square(0, 0)}, {});
  const Strained found = runPeriodic(fea::makeElementMesh(layout.bricks, {}, layout.poses, {}));
  ASSERT_EQ(found.moved.size(), 2U);
  // Strained by 1e-3: E times that on a side of 1 m x 0.02 m; it narrows by Poisson's ratio.
  EXPECT_NEAR(found.moved[0].x(), 1e-3, 1e-12);
  EXPECT_NEAR(found.moved[1].y(), -0.3e-3, 1e-9);
  EXPECT_NEAR(2 * found.energy / 1e-3, 1e9 * 1e-3 * 0.02, 0.1);  // exact in all digits
}

TEST_F(CalculixJobs, PeriodicRotatingSquaresWidenAsTheyAreStretched) {
  // Poisson's ratio is -1: for as many squares across as along, both strains are equal.
  const model::Model model = generate::makeTessellation(test::squares(4, 4, 0.7));
  const Layout layout = test::layoutOf(model.tiles, model.joints);
  const Strained found = runPeriodic(fea::makeElementMesh(
      layout.bricks, layout.joints, layout.poses, {.perEdge = 2, .through = 1}));
  ASSERT_EQ(found.moved.size(), 2U);
  EXPECT_GT(found.moved[0].x(), 1e-3);
  EXPECT_NEAR(found.moved[1].y() / found.moved[0].x(), 1, 1e-6);
  EXPECT_LT(found.energy, 1e-6);  // J; measured: 6e-21
}

// The mechanism of parallelograms shears the sheet when it lengthens.
TEST_F(CalculixJobs, PeriodicParallelogramsShearFreelyAsTheyAreStretched) {
  generate::TessellationShape shape = test::squares(4, 3, 0.5);
  shape.length = 1.2;
  shape.width = 0.8;
  shape.skew = 0.35;
  const model::Model model = generate::makeTessellation(shape);
  const Layout layout = test::layoutOf(model.tiles, model.joints);
  const Strained found =
      runPeriodic(fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                       {.perEdge = 1, .through = 1, .quadratic = false}));
  ASSERT_EQ(found.moved.size(), 2U);
  EXPECT_GT(std::abs(found.moved[1].x()), 1e-4);
  EXPECT_LT(found.energy, 1e-6);  // J; measured: 2e-22
}

TEST_F(CalculixJobs, StateMapsLeadToTheLaterStateWithoutStress) {
  const model::Model first = generate::makeTessellation(test::squares(2, 2, 0));
  const Layout layout = test::layoutOf(first.tiles, first.joints);
  const std::vector<model::Tile> opened = generate::tessellationTiles(test::squares(2, 2, 0), 0.8);
  Poses poses = layout.poses;
  for (std::size_t t = 0; t < poses.size(); ++t) {
    const bool isEven = (t / 2 + t % 2) % 2 == 0;
    poses[t].rotation = rotationFromVector({0, 0, isEven ? -0.4 : 0.4});
    poses[t].position = model::tileCentroid(opened[t]) + Vector3(0, 0, 0.01);
  }
  for (const fea::JointStyle style :
       {fea::JointStyle::Shared, fea::JointStyle::Equation, fea::JointStyle::Patch}) {
    const fea::ElementRule rule{.perEdge = 4, .through = 1, .joints = style};
    const fea::ElementMesh mesh =
        fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
    const fea::ElementMesh later = fea::makeElementMesh(layout.bricks, layout.joints, poses, rule);
    fea::DeckJob job = fea::stateMapJob(mesh, later, {}, kOrigin, "x_mesh.inp");
    job.text.insert(job.text.find("*END STEP"), "*EL PRINT, ELSET=EALL\nS\n");
    const JobEnd end = test::run(fea::meshDeck(mesh, {}, kOrigin), job.text);
    EXPECT_THAT(end.log, HasSubstr("Job finished"));
    const std::vector<Vector3> moved = displacements(end.data.substr(0, end.data.find("stresses")));
    ASSERT_GE(moved.size(), mesh.nodes.size());
    for (std::size_t k = 0; k < mesh.nodes.size(); ++k) {
      EXPECT_LT((mesh.nodes[k] + moved[k] - later.nodes[k]).norm(), 1e-6) << k;  // printed digits
    }
    EXPECT_GE(test::largestStress(end.data), 0);
    EXPECT_LT(test::largestStress(end.data), 1);  // Pa, of 1 GPa; measured: 0.002
  }
}

}  // namespace
}  // namespace kirireel
