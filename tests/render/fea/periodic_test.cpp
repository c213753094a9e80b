// Cells of infinite sheets, and the ends of sheets: which corners, nodes and faces.
#include "render/fea/periodic.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "render/fea/deck.h"
#include "render/fea/job.h"
#include "render/fea/sheet_ends.h"
#include "sim/base/error.h"
#include "sim/generate/families.h"
#include "tests/support/layouts.h"
#include "tests/support/refusal.h"

namespace kirireel {
namespace {

using test::turned;
using ::testing::HasSubstr;

fea::SheetLattice latticeOf(const model::Model& model) {
  std::vector<std::vector<Vector3>> tiles;
  for (const model::Tile& tile : model.tiles) tiles.push_back(tile.vertices);
  return fea::findSheetLattice(tiles, model.joints, 0);
}

std::string refusalOf(const model::Model& model) {
  return test::refusalOf([&] { latticeOf(model); });
}

TEST(SheetLattice, JoinsEveryCornerOfRotatingSquaresOnce) {
  for (const auto& [columns, rows] : {std::pair{2, 2}, {4, 4}, {2, 4}}) {
    for (const double opening : {0.0, 0.7}) {
      for (const double degrees : {0.0, 37.0}) {
        SCOPED_TRACE(testing::Message()
                     << columns << " x " << rows << " " << opening << " " << degrees);
        const model::Model model =
            turned(generate::makeTessellation(test::squares(columns, rows, opening)), degrees);
        const fea::SheetLattice lattice = latticeOf(model);
        std::map<std::pair<int, int>, int> uses;
        for (const model::Joint& joint : model.joints) {
          ++uses[{joint.a.tile, joint.a.vertex}];
          ++uses[{joint.b.tile, joint.b.vertex}];
        }
        for (const fea::BorderJoint& border : lattice.joints) {
          const model::Corner &a = border.joint.a, &b = border.joint.b;
          ++uses[{a.tile, a.vertex}];
          ++uses[{b.tile, b.vertex}];
          const Vector3 gap =
              model.tiles[a.tile].vertices[a.vertex] - model.tiles[b.tile].vertices[b.vertex] -
              border.cell[0] * lattice.periods[0] - border.cell[1] * lattice.periods[1];
          EXPECT_LT(gap.norm(), 1e-9);
        }
        // Each tile of the infinite sheet has four joints, one at each corner.
        EXPECT_EQ(uses.size(), 4 * model.tiles.size());
        for (const auto& [corner, count] : uses) EXPECT_EQ(count, 1);
        // A tile of 1 m and its share of the voids, by hand: the sheet's own axes.
        const double side = std::cos(opening / 2) + std::sin(opening / 2);
        EXPECT_NEAR(lattice.lengths[0] * lattice.lengths[1], columns * rows * side * side, 1e-9);
        const Vector3 along(std::cos(degrees * kDegree), std::sin(degrees * kDegree), 0);
        EXPECT_NEAR(lattice.axes.col(0).dot(along), 1, 1e-9);
      }
    }
  }
}

// Skewed tiles in cells of any outline: x is parallel to sides of the tiles. The two sides of
// rhombi are mirror images of each other. Of parallelograms in other rotations, y may be parallel
// to the longer side, but for all cells alike.
TEST(SheetLattice, StrainsEveryCellAlongTheSameAxes) {
  for (const double skew : {17.0, 30.0, -30.0, 45.0}) {
    for (const double length : {1.0, 1.5}) {
      for (const double degrees : {0.0, 20.0, 35.0, 50.0, 137.0}) {
        std::optional<Vector3> first;
        for (const auto& [columns, rows] : {std::pair{2, 2}, {2, 4}, {4, 2}, {4, 4}, {6, 2}}) {
          SCOPED_TRACE(testing::Message() << skew << " " << length << " " << degrees << " "
                                          << columns << " x " << rows);
          generate::TessellationShape shape = test::squares(columns, rows, 0);
          shape.length = length;
          shape.skew = skew * kDegree;
          const model::Model model = turned(generate::makeTessellation(shape), degrees);
          const Vector3 x = latticeOf(model).axes.col(0);
          const auto side = [&](int edge) {
            const std::vector<Vector3>& tile = model.tiles[0].vertices;
            return std::abs((tile[edge + 1] - tile[edge]).normalized().dot(x));
          };
          if (length == 1) {
            EXPECT_NEAR(std::max(side(0), side(1)), 1, 1e-9);
            continue;
          }
          EXPECT_NEAR(std::abs(side(0) - 0.5), 0.5, 1e-9);
          if (!first) first = x;
          EXPECT_LT((x - *first).norm(), 1e-9);
        }
      }
    }
  }
}

TEST(SheetLattice, NamesTheEdgeAtWhichASheetDoesNotRepeat) {
  const std::string odd = refusalOf(generate::makeTessellation(test::squares(3, 3, 0)));
  EXPECT_THAT(odd, HasSubstr("joints beyond edge 1 of tile 6 at XMAX are at other corners"));
  EXPECT_THAT(odd, HasSubstr("choose a state or a number of tiles in which the sheet repeats"));
  EXPECT_THAT(refusalOf(generate::makeTessellation(test::squares(4, 3, 0))), HasSubstr("at YMAX"));
  model::Model skewed = generate::makeTessellation(test::squares(4, 4, 0));
  for (model::Tile& tile : skewed.tiles) {
    for (Vector3& vertex : tile.vertices) vertex.y() *= 1 + 0.1 * vertex.x();
  }
  EXPECT_THAT(refusalOf(skewed), HasSubstr("meets no edge at"));
}

/// The faces' area and their middle along y.
std::pair<double, double> endOf(const fea::ElementMesh& mesh, int end) {
  double sum = 0, middle = 0;
  for (const fea::NodeShare& one : fea::endShares(mesh, end)) {
    sum += one.share;
    middle += one.share * mesh.ends.axes.col(1).dot(mesh.nodes[one.node]);
  }
  return {sum, middle};
}

TEST(SheetEnds, AreTheSameInAnyRotation) {
  for (const double opening : {0.0, 0.4}) {
    std::vector<std::size_t> faces;
    for (const double degrees : {0.0, 1.0, -20.0, 44.0}) {
      const model::Model model =
          turned(generate::makeTessellation(test::squares(5, 3, opening)), degrees);
      const test::Layout layout = test::layoutOf(model.tiles, model.joints);
      const fea::ElementMesh mesh =
          fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {.perEdge = 2});
      EXPECT_EQ(mesh.ends.longest, 0);
      for (std::size_t end = 0; end < 4; ++end) {
        if (degrees == 0) faces.push_back(mesh.ends.faces[end].size());
        EXPECT_EQ(mesh.ends.faces[end].size(), faces[end]) << degrees << " " << end;
      }
      for (const int end : {0, 1}) {
        const auto [sum, middle] = endOf(mesh, end);
        EXPECT_NEAR(sum, 1, 1e-12);
        // A closed sheet is centred, so the traction is uniform.
        if (opening == 0) {
          EXPECT_NEAR(middle, 0, 1e-9);
        }
      }
    }
    // Closed: three edges of two elements, two layers each.
    if (opening == 0) {
      EXPECT_EQ(faces[0], 3U * 2U * 2U);
    }
  }
}

/// Sheets whose smallest rectangle is one of two, or a square.
std::vector<model::Model> rhombi() {
  generate::TessellationShape skewed = test::squares(3, 3, 0);
  skewed.skew = 30 * kDegree;
  return {generate::makeTessellation(skewed),
          generate::makeHexagonsAndTriangles({.columns = 3, .rows = 3}),
          generate::makeTessellation(test::squares(3, 5, 0))};
}

/// The sheet after a linear map; a mirror image has reversed tiles and tiles in reverse order.
model::Model mapped(model::Model model, const Matrix3& map) {
  for (model::Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = map * vertex;
  }
  if (map.determinant() > 0) return model;
  const int tiles = static_cast<int>(model.tiles.size());
  for (model::Joint& joint : model.joints) {
    for (model::Corner* corner : {&joint.a, &joint.b}) {
      const int count = static_cast<int>(model.tiles[corner->tile].vertices.size());
      *corner = {tiles - 1 - corner->tile, count - 1 - corner->vertex};
    }
  }
  for (model::Tile& tile : model.tiles) std::ranges::reverse(tile.vertices);
  std::ranges::reverse(model.tiles);
  return model;
}

std::vector<Matrix3> rotationsAndMirrors() {
  std::vector<Matrix3> maps;
  for (const double degrees : {0.0, 10.0, 30.0, 90.0, 137.0, 200.0}) {
    maps.push_back(rotationFromVector({0, 0, degrees * kDegree}).toRotationMatrix());
    maps.push_back(maps.back() * Vector3(-1, 1, 1).asDiagonal());
  }
  // Upright, upside down, and in any plane.
  for (const Vector3& turn :
       {Vector3(0.5 * std::numbers::pi, 0, 0), Vector3(0, 0.5 * std::numbers::pi, 0),
        Vector3(std::numbers::pi, 0, 0), Vector3(0.3, -0.8, 1.7)}) {
    maps.push_back(rotationFromVector(turn).toRotationMatrix());
  }
  return maps;
}

TEST(SheetEnds, AndCellsFollowTheSheetInAnyPlane) {
  for (const model::Model& model : rhombi()) {
    std::vector<Vector3> expected;
    for (const Matrix3& map : rotationsAndMirrors()) {
      const model::Model own = mapped(model, map);
      const test::Layout layout = test::layoutOf(own.tiles, own.joints);
      const fea::ElementMesh mesh =
          fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {.perEdge = 2});
      ASSERT_TRUE(mesh.ends.isFlat);
      // The middles of the pulled ends and the faces of all ends, in the sheet's own position.
      std::vector<Vector3> found;
      std::array<std::size_t, 2> faces{};
      for (int end = 0; end < 4; ++end) {
        faces[end / 2 == mesh.ends.longest ? 0 : 1] += mesh.ends.faces[end].size();
        if (end / 2 != mesh.ends.longest) continue;
        Vector3& middle = found.emplace_back(Vector3::Zero());
        for (const fea::NodeShare& one : fea::endShares(mesh, end)) {
          middle += one.share * map.transpose() * mesh.nodes[one.node];
        }
      }
      std::ranges::sort(found, {}, [](const Vector3& one) { return one.x() + 2 * one.y(); });
      found.emplace_back(faces[0], faces[1], 0);
      if (expected.empty()) expected = found;
      // The thickness lies on the other side of a mirror image.
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_LT((found[k] - expected[k]).head<2>().norm(), 1e-9) << map;  // measured: 7.2e-15
      }
    }
  }
  for (const Matrix3& map : rotationsAndMirrors()) {
    const fea::SheetLattice lattice =
        latticeOf(mapped(generate::makeTessellation(test::squares(4, 2, 0)), map));
    std::array<double, 2> lengths = lattice.lengths;
    std::ranges::sort(lengths);
    EXPECT_NEAR(lengths[0], 2, 1e-9) << map;
    EXPECT_NEAR(lengths[1], 4, 1e-9);
    const Vector3 along = map.transpose() * lattice.axes.col(lattice.lengths[0] > 3 ? 0 : 1);
    EXPECT_NEAR(std::abs(along.x()), 1, 1e-9) << map;
  }
}

// Skewed sheets have ends whose middles are not on one line along an axis.
TEST(SheetEnds, ArePulledInBalance) {
  for (const model::Model& model : rhombi()) {
    const test::Layout layout = test::layoutOf(model.tiles, model.joints);
    const fea::ElementMesh mesh =
        fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, {.perEdge = 2});
    const std::string job = fea::staticJob(mesh, {}, {}, "x_mesh.inp").text;
    std::istringstream rows(job.substr(job.find("*CLOAD") + 7));
    Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
    double sum = 0;
    int node = 0, axis = 0;
    char comma = 0;
    for (double value = 0; rows >> node >> comma >> axis >> comma >> value;) {
      const Vector3 one = value * Vector3::Unit(axis - 1);
      force += one;
      moment += mesh.nodes[node - 1].cross(one);
      sum += std::abs(value);
    }
    EXPECT_GE(sum, 2);
    EXPECT_LT(force.norm(), 1e-12);   // N; measured: 3.7e-15
    EXPECT_LT(moment.norm(), 1e-12);  // N m; measured: 1.8e-15
  }
}

TEST(SheetEnds, AreTheEdgesToGrip) {
  // Squares with diagonals along the axes: both edges at each outer corner, no edges inside.
  const model::Model model = generate::makeTessellation(test::squares(2, 1, 0));
  std::vector<std::vector<Vector3>> diamonds;
  for (const double x : {0.0, 2.0}) {
    diamonds.push_back({{x - 1, 0, 0}, {x, -1, 0}, {x + 1, 0, 0}, {x, 1, 0}});
  }
  const fea::EndEdges ends = fea::findEndEdges(diamonds, {}, std::sqrt(2.0));
  EXPECT_EQ(ends.edges[0], (std::vector<fea::PolygonEdge>{{0, 0}, {0, 3}}));
  EXPECT_EQ(ends.edges[1], (std::vector<fea::PolygonEdge>{{1, 1}, {1, 2}}));
  // The banks of the slit between two squares are not ends.
  std::vector<std::vector<Vector3>> squares;
  for (const model::Tile& tile : model.tiles) squares.push_back(tile.vertices);
  const fea::EndEdges shut = fea::findEndEdges(squares, {}, 1);
  EXPECT_EQ(shut.edges[0].size(), 1U);
  EXPECT_EQ(shut.edges[2].size(), 2U);
}

TEST(JoinedTiles, AreOnePart) {
  // Two squares side by side, and a triangle on the second one, joined by their edges.
  const std::vector<model::Tile> tiles = {model::Tile{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                                          model::Tile{{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}}},
                                          model::Tile{{{2, 0, 0}, {2.8, 0.5, 0}, {2, 1, 0}}}};
  const std::vector<model::Joint> joints = {model::makeFixedJoint(tiles, 0, 1),
                                            model::makeFixedJoint(tiles, 1, 2)};
  const test::Layout layout = test::layoutOf(tiles, joints);
  for (const fea::ElementFamily family : {fea::ElementFamily::Solid, fea::ElementFamily::Shell}) {
    const fea::ElementMesh mesh = fea::makeElementMesh(
        layout.bricks, layout.joints, layout.poses, {.perEdge = 3, .through = 1, .family = family});
    for (const int tile : {0, 1}) {
      std::vector<int> common;
      std::ranges::set_intersection(mesh.tiles[tile].nodes, mesh.tiles[tile + 1].nodes,
                                    std::back_inserter(common));
      // Four elements: nine nodes on a line; of solids two such lines and five between them.
      EXPECT_EQ(common.size(), family == fea::ElementFamily::Solid ? 9U + 9U + 5U : 9U);
    }
    // One body: six displacements hold it.
    EXPECT_EQ(fea::minSupports(mesh).size(), 6U);
  }
  // Bricks at an angle touch on one face and have a mitre.
  for (const double angle : {-1.2, -0.4, 0.4, 1.2}) {
    std::vector<model::Tile> folded = tiles;
    for (const int tile : {1, 2}) {
      for (Vector3& vertex : folded[tile].vertices) {
        const double beyond = vertex.x() - 1;
        vertex = {1 + std::cos(angle) * beyond, vertex.y(), std::sin(angle) * beyond};
      }
    }
    const test::Layout bent = test::layoutOf(folded, joints);
    const fea::ElementMesh mesh =
        fea::makeElementMesh(bent.bricks, bent.joints, bent.poses, {.perEdge = 3, .through = 1});
    std::vector<int> common;
    std::ranges::set_intersection(mesh.tiles[0].nodes, mesh.tiles[1].nodes,
                                  std::back_inserter(common));
    EXPECT_EQ(common.size(), 9U + 9U + 5U);
    // The mitre bisects the angle.
    for (const int node : common) {
      EXPECT_NEAR((mesh.nodes[node].x() - 1) * std::cos(angle / 2) +
                      mesh.nodes[node].z() * std::sin(angle / 2),
                  0, 1e-12);
    }
    EXPECT_EQ(fea::minSupports(mesh).size(), 6U);
  }
  std::vector<model::Tile> apart = tiles;
  for (Vector3& vertex : apart[1].vertices) vertex.x() += 0.1;
  const test::Layout far = test::layoutOf(apart, {model::makeFixedJoint(apart, 0, 1)});
  try {
    fea::makeElementMesh(far.bricks, far.joints, far.poses, {});
    ADD_FAILURE() << "tiles apart are joined";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("fixes tiles 0 and 1 to each other, which share no edge"));
  }
}

TEST(ElementMesh, ReportsItsSmallestAngle) {
  for (const double degrees : {20.0, 5.0}) {
    const double width = std::tan(degrees * kDegree);
    const test::Layout layout =
        test::layoutOf({model::Tile{{{0, 0, 0}, {1, 0, 0}, {0, width, 0}}}}, {});
    const fea::ElementMesh mesh = fea::makeElementMesh(layout.bricks, {}, layout.poses, {});
    // The triangle's corner at (1, 0) is a corner of an element.
    EXPECT_NEAR(fea::smallestElementAngle(mesh), degrees, 1e-6);
  }
}

}  // namespace
}  // namespace kirireel
