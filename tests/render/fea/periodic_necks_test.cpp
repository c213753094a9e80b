// Infinite sheets, grips, joined tiles and solids of sheets with necks, in CalculiX and Gmsh.
// Skipped if these are not installed.
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/job.h"
#include "render/fea/neck_solid.h"
#include "render/fea/outside_program.h"
#include "sim/base/files.h"
#include "sim/formats/read_model.h"
#include "sim/generate/families.h"
#include "sim/generate/lattice.h"
#include "tests/render/fea/run_deck.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

using test::kOrigin;
using test::turned;
using ::testing::HasSubstr;

fea::ElementRule plane(double width, int perEdge) {
  return {.perEdge = perEdge,
          .joints = fea::JointStyle::Neck,
          .family = fea::ElementFamily::Plane,
          .neck = {.width = width}};
}

/// Results of a periodic job in its first step.
struct CellResult {
  double energy = 0;    ///< J/m^2 at a strain of a thousandth
  double widening = 0;  ///< strain across over strain along
};

CellResult cellResult(const fea::ElementMesh& mesh) {
  fea::DeckSettings settings;
  settings.periodic = true;
  const fea::DeckJob job = fea::periodicJob(mesh, settings, kOrigin, "x_mesh.inp");
  const test::JobEnd end = test::run(fea::meshDeck(mesh, settings, kOrigin), job.text);
  EXPECT_THAT(end.log, HasSubstr("Job finished"));
  const std::size_t energy = end.data.find("total internal energy");
  if (energy == std::string::npos) return {};
  const auto moved = test::displacements(end.data.substr(0, end.data.find("forces (fx")));
  const std::array<double, 2> period = fea::periodicity(mesh).period;
  const double total = std::strtod(end.data.c_str() + end.data.find('\n', energy), nullptr);
  return {total / (period[0] * period[1]),
          moved.at(1).y() / period[1] / (moved.at(0).x() / period[0])};
}

class PeriodicNecks : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* program : {"ccx", "gmsh"}) {
      if (!test::hasProgram(program)) GTEST_SKIP() << "install " << program << " to check decks";
    }
  }
};

// An independent model of the infinite sheet, of triangles of six nodes, gives 0.0666 J/m^2 and
// +0.960 at E = 1 GPa and 0.02 m.
TEST_F(PeriodicNecks, EveryCellOfASheetIsTheSameSheet) {
  std::vector<CellResult> found;
  for (const auto& [columns, rows, degrees] : {std::tuple{2, 2, 0.0}, {2, 2, 30.0}, {4, 2, 0.0}}) {
    const model::Model model =
        turned(generate::makeTessellation(test::squares(columns, rows, 0)), degrees);
    found.push_back(cellResult(fea::makePeriodicNeckMesh(model, 0.02, plane(0.1, 4))));
  }
  const CellResult fine = cellResult(fea::makePeriodicNeckMesh(
      generate::makeTessellation(test::squares(2, 2, 0)), 0.02, plane(0.1, 8)));
  EXPECT_NEAR(fine.energy / 0.0666, 1, 0.005);  // measured: 1.0036; with 4 elements 1.0111
  EXPECT_NEAR(fine.widening, 0.960, 0.005);     // measured: 0.9599
  for (const CellResult& other : found) {
    EXPECT_NEAR(other.energy / found[0].energy, 1, 0.005);
    EXPECT_NEAR(other.widening, found[0].widening, 0.005);
  }
}

// Measured with 2 elements per edge: energies of 2 x 2, 4 x 4 and 6 x 6 squares differ by at most
// 5.2e-4, those of 2 x 2 and 3 x 3 triangles by 5e-4, ratios by 1e-4.
TEST_F(PeriodicNecks, CellsOfAnyWidthAndSizeAgree) {
  for (const double width : {0.05, 0.1, 0.2}) {
    const auto cell = [&](const model::Model& model) {
      return cellResult(fea::makePeriodicNeckMesh(model, 0.02, plane(width, 1)));
    };
    const auto triangles = [](int columns, int rows) {
      return generate::makeRotatingTriangles({.columns = columns, .rows = rows});
    };
    const std::array<std::array<CellResult, 2>, 2> sheets = {
        {{cell(generate::makeTessellation(test::squares(2, 2, 0))),
          cell(generate::makeTessellation(test::squares(4, 4, 0)))},
         {cell(triangles(2, 2)), cell(triangles(3, 2))}}};
    for (const auto& [small, large] : sheets) {
      EXPECT_NEAR(large.energy / small.energy, 1, 0.005) << width;
      EXPECT_NEAR(large.widening, small.widening, 0.005) << width;
    }
  }
}

// The corners of ideal hinges: no force, and as wide as long.
TEST_F(PeriodicNecks, ClosedSquaresOnHingesOpenFreely) {
  const model::Model model = turned(generate::makeTessellation(test::squares(4, 4, 0)), 1);
  const test::Layout layout = test::layoutOf(model.tiles, model.joints);
  for (const fea::JointStyle joints : {fea::JointStyle::Shared, fea::JointStyle::Equation}) {
    const CellResult found =
        cellResult(fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                        {.perEdge = 2, .through = 1, .joints = joints}));
    EXPECT_NEAR(found.widening, 1, 1e-5);
    EXPECT_LT(found.energy, 1e-9);
  }
}

double openingOf(const fea::ElementMesh& mesh) {
  const fea::DeckJob job = fea::staticJob(mesh, {}, kOrigin, "x_mesh.inp");
  return fea::openingByCalculix(fea::meshDeck(mesh, {}, kOrigin) + job.sets, job.text);
}

TEST_F(PeriodicNecks, GripsPullEquallyOnEveryMesh) {
  const model::Model model = generate::makeTessellation(test::squares(2, 2, 0));
  const double coarse = openingOf(fea::makeNeckMesh(model, 0.02, plane(0.05, 4)));
  const double fine = openingOf(fea::makeNeckMesh(model, 0.02, plane(0.05, 8)));
  EXPECT_NEAR(coarse / fine, 1, 0.01);  // measured: 0.9956
  // Odd numbers of slightly rotated squares are fixed at the same edges.
  const model::Model odd = generate::makeTessellation(test::squares(3, 3, 0));
  const double straight = openingOf(fea::makeNeckMesh(odd, 0.02, plane(0.1, 2)));
  const double aslant = openingOf(fea::makeNeckMesh(turned(odd, 1), 0.02, plane(0.1, 2)));
  EXPECT_NEAR(aslant / straight, 1, 0.01);  // measured with 4 elements: 0.9999
}

// Rhombi have two smallest rectangles, and ends that are not opposite each other.
TEST_F(PeriodicNecks, RhombiOpenEquallyInAnyRotation) {
  generate::TessellationShape skewed = test::squares(3, 3, 0);
  skewed.skew = 30 * kDegree;
  for (const model::Model& model :
       {generate::makeTessellation(skewed),
        generate::makeRotatingTriangles({.columns = 3, .rows = 3}),
        generate::makeHexagonsAndTriangles({.columns = 3, .rows = 3})}) {
    fea::ElementRule rule = plane(0.1, 2);
    rule.quadratic = false;
    const double straight = openingOf(fea::makeNeckMesh(model, 0.02, rule));
    for (const double degrees : {30.0, 137.0}) {
      const double other = openingOf(fea::makeNeckMesh(turned(model, degrees), 0.02, rule));
      EXPECT_NEAR(other / straight, 1, 0.01);  // measured: 1 to 1.006
    }
  }
}

TEST_F(PeriodicNecks, JoinedTilesArePulledAsOne) {
  const std::vector<model::Tile> tiles = {
      model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
      model::Tile{{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}}}};
  const test::Layout layout = test::layoutOf(tiles, {model::makeFixedJoint(tiles, 0, 1)});
  const double found = openingOf(fea::makeElementMesh(layout.bricks, layout.joints, layout.poses,
                                                      {.perEdge = 2, .through = 1}));
  // An even traction stretches a strip evenly: 2 m / (1 GPa x 1 m x 0.02 m).
  EXPECT_NEAR(found / 1e-7, 1, 1e-5);
}

TEST_F(PeriodicNecks, ShellsOpenLikeSolids) {
  for (const model::Model& model :
       {generate::makeTessellation(test::squares(2, 3, 0)),
        generate::makeRotatingTriangles({.columns = 2, .rows = 1}),
        generate::makeHexagonsAndTriangles({.columns = 2, .rows = 2})}) {
    const auto opening = [&](fea::ElementFamily family) {
      fea::ElementRule rule = plane(0.1, 1);
      rule.family = family;
      rule.through = 1;
      return openingOf(fea::makeNeckMesh(model, 0.02, rule));
    };
    const double solids = opening(fea::ElementFamily::Solid);
    EXPECT_NEAR(opening(fea::ElementFamily::Shell) / solids, 1, 0.02);  // measured: 0.9945 to 1
    EXPECT_NEAR(opening(fea::ElementFamily::Plane) / solids, 1,
                0.02);  // measured: 0.9931 to 0.9975
  }
}

TEST_F(PeriodicNecks, ShellsOfTurnedSheetsAreMeshed) {
  const model::Model odd = turned(generate::makeTessellation(test::squares(3, 3, 0)), 1);
  fea::ElementRule rule = plane(0.1, 2);
  rule.family = fea::ElementFamily::Shell;
  const fea::ElementMesh mesh = fea::makeNeckMesh(odd, 0.02, rule);
  for (std::size_t end = 0; end < 4; ++end) EXPECT_FALSE(mesh.ends.faces[end].empty()) << end;
}

/// The facets of an ASCII STL.
std::vector<std::array<Vector3, 3>> facetsOf(const std::string& text) {
  std::vector<std::array<Vector3, 3>> facets;
  std::istringstream words(text);
  std::array<Vector3, 3> facet;
  int corner = 0;
  for (std::string word; words >> word;) {
    if (word != "vertex") continue;
    words >> facet[corner].x() >> facet[corner].y() >> facet[corner].z();
    corner = (corner + 1) % 3;
    if (corner == 0) facets.push_back(facet);
  }
  return facets;
}

TEST(NeckSolid, IsClosedAndHasTheVolumeOfItsOutline) {
  // By hand, as in NeckMesh: squares lose half a kerf along each edge.
  const writers::NeckShape shut{.width = 0.1};
  const writers::NeckShape open{.width = 0.05, .length = 0.2, .kerf = 0.01};
  const double area = 9 * 0.99 * 0.99 + 12 * (0.01 * 0.05 - (0.2 - 0.01) * 0.05);
  for (const double degrees : {0.0, 1.0}) {
    const model::Model model = turned(generate::makeTessellation(test::squares(3, 3, 0)), degrees);
    for (const auto& [neck, expectedArea] : {std::pair{shut, 9.0}, {open, area}}) {
      double volume = 0;
      std::map<std::array<double, 6>, int> edges;
      for (const auto& facet : facetsOf(fea::neckSheetStl(model, neck, 0.02, {}))) {
        volume += facet[0].cross(facet[1]).dot(facet[2]) / 6;
        for (int k = 0; k < 3; ++k) {
          const Vector3 &a = facet[k], &b = facet[(k + 1) % 3];
          ++edges[{a.x(), a.y(), a.z(), b.x(), b.y(), b.z()}];
        }
      }
      // Banks of closed slits are 2e-7 of the size apart. Open ones are exact.
      EXPECT_NEAR(volume / (0.02 * expectedArea), 1, neck.kerf > 0 ? 1e-12 : 1e-6);
      for (const auto& [edge, count] : edges) {
        const auto back = edges.find({edge[3], edge[4], edge[5], edge[0], edge[1], edge[2]});
        EXPECT_EQ(count, 1);
        EXPECT_NE(back, edges.end());
      }
    }
  }
}

std::size_t countOf(const std::string& text, const std::string& word) {
  std::size_t count = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    ++count;
  }
  return count;
}

TEST(NeckSolid, SlitsAroundReflexCornersAreApart) {
  // Corners of crosses and stars lie in reflex corners of their neighbours.
  for (const char* name : {"crosses", "stars", "islamic", "trefoils"}) {
    std::vector<std::string> notes;
    const model::Model model =
        formats::readModel(std::string(KIRIREEL_SOURCE_DIR "/data/") + name, std::nullopt, notes);
    std::map<std::array<double, 6>, int> edges;
    double volume = 0;
    for (const auto& facet : facetsOf(fea::neckSheetStl(model, {.width = 0.02}, 0.02, {}))) {
      volume += facet[0].cross(facet[1]).dot(facet[2]) / 6;
      for (int k = 0; k < 3; ++k) {
        const Vector3 &a = facet[k], &b = facet[(k + 1) % 3];
        // Printers use single precision.
        std::array<double, 6> edge = {a.x(), a.y(), a.z(), b.x(), b.y(), b.z()};
        for (double& number : edge) number = static_cast<float>(number);
        ++edges[edge];
      }
    }
    for (const auto& [edge, count] : edges) ASSERT_EQ(count, 1) << name;
    double area = 0;
    for (const model::Tile& tile : model.tiles) {
      for (std::size_t k = 1; k + 1 < tile.vertices.size(); ++k) {
        area += 0.5 * (tile.vertices[k] - tile.vertices[0])
                          .cross(tile.vertices[k + 1] - tile.vertices[0])
                          .z();
      }
    }
    EXPECT_NEAR(volume / (0.02 * area), 1, 5e-6) << name;  // measured: 1.4e-6 to 3.0e-6
    if (!test::hasProgram("gmsh")) continue;
    EXPECT_EQ(countOf(fea::neckSheetStep(model, {.width = 0.02}, 0.02), "MANIFOLD_SOLID_BREP"), 1U)
        << name;
  }
}

/// The volume of the only solid in a STEP file, cubic millimetres, by Gmsh.
double volumeByGmsh(const std::string& step) {
  const test::TemporaryFolder folder;
  writeTextFile(folder / "x.step", step);
  writeTextFile(folder / "x.geo",
                "SetFactory(\"OpenCASCADE\");\nv[] = ShapeFromFile(\"x.step\");\n"
                "Printf(\"VOLUME %.16g\", Mass Volume{v[0]});\n");
  const std::string printed =
      test::outputOf("cd '" + folder.path().string() + "' && gmsh x.geo -parse_and_exit -v 4 2>&1");
  const std::size_t at = printed.find("VOLUME ");
  return at == std::string::npos ? 0 : std::atof(printed.c_str() + at + 7);
}

TEST(NeckSolid, IsOneSolidOfCadPrograms) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to write STEP files";
  const model::Model model = generate::makeTessellation(test::squares(3, 3, 0));
  for (const writers::NeckShape& neck :
       {writers::NeckShape{.width = 0.1}, {.width = 0.05, .length = 0.2, .kerf = 0.01}}) {
    const std::string step = fea::neckSheetStep(model, neck, 0.02);
    EXPECT_EQ(countOf(step, "MANIFOLD_SOLID_BREP"), 1U);
    EXPECT_THAT(step, HasSubstr("SI_UNIT(.MILLI.,.METRE.)"));
    EXPECT_EQ(step, fea::neckSheetStep(model, neck, 0.02));  // to the byte
    // The area as in IsClosedAndHasTheVolumeOfItsOutline. Banks of closed slits are separate.
    const double area =
        neck.kerf > 0 ? 9 * 0.99 * 0.99 + 12 * (0.01 * 0.05 - (0.2 - 0.01) * 0.05) : 9;
    EXPECT_NEAR(volumeByGmsh(step) / (0.02e9 * area), 1, neck.kerf > 0 ? 1e-12 : 2e-6);
    // Each edge bounds two faces, in both directions.
    EXPECT_EQ(2 * countOf(step, "= EDGE_CURVE"), countOf(step, "= ORIENTED_EDGE"));
  }
  const test::Layout layout = test::hingedSquares();
  const std::string bricks = fea::brickStep(layout.bricks, layout.poses);
  EXPECT_EQ(countOf(bricks, "MANIFOLD_SOLID_BREP"), 4U);
  EXPECT_EQ(countOf(bricks, "ADVANCED_FACE"), 4U * 6U);
}

TEST(NeckSolid, GmshMeshesNameTheirSides) {
  if (!test::hasProgram("gmsh")) GTEST_SKIP() << "install gmsh to mesh sheets with necks";
  const model::Model model = turned(generate::makeTessellation(test::squares(3, 3, 0)), 1);
  for (const fea::ElementFamily family : {fea::ElementFamily::Plane, fea::ElementFamily::Solid}) {
    fea::ElementRule rule = plane(0.1, 2);
    rule.family = family;
    const std::string text = fea::gmshMesh(fea::makeNeckMesh(model, 0.02, rule));
    const int dimension = family == fea::ElementFamily::Plane ? 1 : 2;
    for (const char* name : {"XMIN", "XMAX", "YMIN", "YMAX", "SLITS"}) {
      EXPECT_EQ(countOf(text, fmt::format("\"{}\"", name)), 1U) << name;
    }
    EXPECT_THAT(text, HasSubstr(fmt::format("\n{} ", dimension)));
  }
}

}  // namespace
}  // namespace kirireel
