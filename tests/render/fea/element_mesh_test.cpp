#include "render/fea/element_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/support/layouts.h"
#include "tests/support/polygons.h"

namespace kirireel {
namespace {

using test::Layout;

std::string refusal(const Layout& layout, const fea::ElementRule& rule = {}) {
  try {
    fea::makeElementMesh(layout.bricks, layout.joints, layout.poses, rule);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

/// One tile in the plane.
Layout plane(const std::vector<Vector3>& vertices) {
  return test::layoutOf({model::Tile{vertices}}, {});
}

TEST(ElementMesh, CornersAreTheBricksToTheLastBit) {
  Layout layout = test::polygons();
  for (Pose& pose : layout.poses) pose.rotation = rotationFromVector({0.3, -0.8, 1.7});
  for (const bool quadratic : {false, true}) {
    const fea::ElementMesh mesh = fea::makeElementMesh(
        layout.bricks, {}, layout.poses, {.perEdge = 3, .through = 3, .quadratic = quadratic});
    for (std::size_t t = 0; t < layout.bricks.size(); ++t) {
      for (std::size_t k = 0; k < layout.bricks[t].bottom.size(); ++k) {
        const std::vector<int>& edge = mesh.tiles[t].edges[k];
        EXPECT_EQ(mesh.nodes[edge.front()], layout.poses[t].apply(layout.bricks[t].bottom[k]));
        EXPECT_EQ(mesh.nodes[edge.back()], layout.poses[t].apply(layout.bricks[t].top[k]));
      }
    }
  }
}

TEST(ElementMesh, DividesConcaveTiles) {
  // The centre of the dart's area, (1, 0), is its inner corner; the L's lies outside of it.
  EXPECT_EQ(refusal(plane({{0, 0, 0}, {2, -1, 0}, {1, 0, 0}, {2, 1, 0}})), "accepted");
  EXPECT_EQ(refusal(plane({{0, 0, 0}, {2, -1, 0}, {1.5, 0, 0}, {2, 1, 0}})), "accepted");
  EXPECT_EQ(refusal(plane(test::lShape(4, 1).vertices)), "accepted");
  EXPECT_EQ(refusal(plane(test::starShape(7, 2, 0.6).vertices)), "accepted");
}

TEST(ElementMesh, FansFourCornersOfWhichOneIsStraight) {
  const Layout layout = plane({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {1, 1, 0}});
  const fea::ElementMesh mesh =
      fea::makeElementMesh(layout.bricks, {}, layout.poses, {.perEdge = 2, .through = 1});
  EXPECT_EQ(mesh.elements.size(), 4U * 3U);
}

TEST(ElementMesh, RefusesBricksTooThinForTheElements) {
  Layout layout = plane({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  layout = test::layoutOf({brick::bottomTiles(layout.bricks, layout.poses)}, {}, 0.0009);
  EXPECT_EQ(refusal(layout, {.perEdge = 2, .through = 1}),
            "error: tile 0 is too thin for its elements, 0.5 m long and 0.0009 m high; at most 500 "
            "times as long as high are allowed: use more elements per edge, fewer through the "
            "thickness, or thicker bricks");
  EXPECT_EQ(refusal(layout, {.perEdge = 3, .through = 1}), "accepted");
}

TEST(ElementMesh, RefusesImpossibleRules) {
  const Layout layout = test::polygons();
  EXPECT_EQ(refusal(layout, {.perEdge = -1}),
            "error: -1 elements per edge are not possible; choose 1 to 64");
  EXPECT_EQ(refusal(layout, {.through = 65}),
            "error: 65 elements through the thickness are not possible; choose 1 to 64");
  EXPECT_EQ(refusal(layout, {.perEdge = 4, .size = 0.1}),
            "error: 4 elements per edge and elements of 0.1 m contradict each other; give only one "
            "of them");
  EXPECT_EQ(refusal(layout, {.patchRadius = -1}),
            "error: elements of 0 m and patches of radius -1 m are not possible; give positive "
            "lengths");
  EXPECT_EQ(refusal(layout, {.family = fea::ElementFamily::Plane}),
            "error: plane elements need one sheet with necks; add --joints neck and --neck-width, "
            "or remove --plane-stress");
  EXPECT_EQ(
      refusal(layout, {.joints = fea::JointStyle::Patch, .family = fea::ElementFamily::Shell}),
      "error: shells of hinged tiles share nodes or have equations depending on the joint; remove "
      "--joints, or choose neck");
  test::Layout mixed = test::hingedSquares();
  mixed.joints[0].face = model::JointFace::Top;
  EXPECT_EQ(refusal(mixed, {.family = fea::ElementFamily::Shell}),
            "error: tile 0 has joints on different faces, but a shell has nodes on one face; "
            "remove --shells");
}

TEST(ElementMesh, RefusesMoreElementsThanFit) {
  const model::Model model = generate::makeTessellation(test::squares(20, 20, 0));
  EXPECT_EQ(
      refusal(test::layoutOf(model.tiles, {}), {.perEdge = 64, .through = 3}),
      "error: 4915200 elements would be made, at most 4000000 are allowed; use fewer per edge "
      "or through the thickness");
}

TEST(ElementMesh, RefusesPatchesThatAreTooSmallOrTooLarge) {
  const Layout layout = test::hingedSquares();
  EXPECT_EQ(refusal(layout, {.perEdge = 4, .joints = fea::JointStyle::Patch, .patchRadius = 0.1}),
            "error: a joint patch of radius 0.1 m has 1 nodes of tile 0, at least 3 are needed; "
            "use 5 elements per edge or a larger radius");
  EXPECT_EQ(refusal(layout, {.perEdge = 5, .joints = fea::JointStyle::Patch, .patchRadius = 0.1}),
            "accepted");
  EXPECT_EQ(refusal(layout, {.perEdge = 8, .joints = fea::JointStyle::Patch, .patchRadius = 0.8}),
            "error: joint patches of radius 0.8 m overlap on tile 0; choose one below 0.5 m, half "
            "the distance of its nearest corners");
}

TEST(ElementMesh, RefusesJointsWithoutCommonCorners) {
  Layout layout = test::hingedSquares();
  layout.joints[2].kind = model::JointKind::Link;
  EXPECT_EQ(refusal(layout),
            "error: joint 2 does not join two corners; a mesh can join only pivots");
  EXPECT_EQ(refusal(layout, {.countsFrom = 1}),
            "error: joint 3 does not join two corners; a mesh can join only pivots");
}

TEST(ElementMesh, RefusesToTieATileToItself) {
  Layout layout = test::hingedSquares();
  layout.joints = {{{0, 0}, {1, 0}}, {{1, 0}, {0, 1}}};
  EXPECT_THAT(refusal(layout), testing::HasSubstr("tie two corners of tile 0 together"));
}

}  // namespace
}  // namespace kirireel
