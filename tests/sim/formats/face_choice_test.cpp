#include <algorithm>

#include <gtest/gtest.h>

#include "sim/formats/joint_faces.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

/// Two unit squares that share an edge and are folded about it: up (a valley) for positive heights.
model::Model foldedPair(double height) {
  model::Model model;
  model.tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                 {{{1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}}}};
  model.joints = {{{0, 1}, {1, 0}}};
  model.target = model.tiles;
  (*model.target)[1].vertices[1] = Vector3(1 + std::sqrt(1 - height * height), 0, height);
  (*model.target)[1].vertices[2] = Vector3(1 + std::sqrt(1 - height * height), 1, height);
  return model;
}

model::JointFace chosenFace(model::Model model, formats::FaceRule rule = formats::FaceRule::Fold) {
  formats::chooseJointFaces(model, rule);
  return model.joints.front().face;
}

/// The same with tiles and vertices renumbered.
model::Model renumbered(model::Model model) {
  for (std::vector<model::Tile>* tiles : {&model.tiles, &*model.target}) {
    std::swap((*tiles)[0], (*tiles)[1]);
    for (model::Tile& tile : *tiles)
      std::rotate(tile.vertices.begin(), tile.vertices.begin() + 1, tile.vertices.end());
  }
  model.joints = {{{1, 0}, {0, 3}}};
  return model;
}

TEST(FaceChoice, ValleyIsJoinedAtTheTop) {
  EXPECT_EQ(chosenFace(foldedPair(0.3)), model::JointFace::Top);
  EXPECT_EQ(chosenFace(foldedPair(-0.3)), model::JointFace::Bottom);
}

TEST(FaceChoice, DoesNotDependOnNumbers) {
  EXPECT_EQ(chosenFace(renumbered(foldedPair(0.3))), model::JointFace::Top);
  EXPECT_EQ(chosenFace(renumbered(foldedPair(-0.3))), model::JointFace::Bottom);
}

TEST(FaceChoice, SingleVertexIsClassifiedByItsNormals) {
  model::Model model = foldedPair(0.3);
  // Turned in its own plane about the joint, the second tile shares only the vertex.
  for (Vector3& vertex : (*model.target)[1].vertices) {
    const Vector3 normal = model::tileNormal((*foldedPair(0.3).target)[1]);
    vertex = Vector3(1, 0, 0) + Eigen::AngleAxisd(-0.5, normal) * (vertex - Vector3(1, 0, 0));
  }
  EXPECT_EQ(chosenFace(model), model::JointFace::Top);
}

TEST(FaceChoice, FlatSheetsAreJoinedOnBothFaces) {
  generate::TessellationShape shape;
  shape.face = model::JointFace::Bottom;
  EXPECT_EQ(chosenFace(generate::makeTessellation(shape)), model::JointFace::Both);
}

TEST(FaceChoice, SheetWithoutTargetIsClassifiedAtTheStart) {
  model::Model model = foldedPair(0.3);
  model.tiles = *model.target;
  model.target.reset();
  EXPECT_EQ(chosenFace(model), model::JointFace::Top);
}

/// Joints at the top of the published sphere to saddle, or -1 if the file is missing.
std::ptrdiff_t topsOfPublishedSaddle(formats::FaceRule rule) {
  const auto folder =
      std::filesystem::path(KIRIREEL_SOURCE_DIR) / "../shared/models/sphere-to-saddle";
  if (!std::filesystem::exists(folder)) return -1;
  std::vector<std::string> warnings;
  model::Model model = formats::readModelFolder(folder, warnings);
  formats::chooseJointFaces(model, rule);
  EXPECT_EQ(model.joints.size(), 180U);
  return std::count_if(model.joints.begin(), model.joints.end(), [](const model::Joint& joint) {
    return joint.face == model::JointFace::Top;
  });
}

TEST(FaceChoice, PublishedSaddleHasNinetyValleys) {
  const std::ptrdiff_t tops = topsOfPublishedSaddle(formats::FaceRule::Fold);
  if (tops < 0) GTEST_SKIP() << "../shared/models/sphere-to-saddle is not there";
  EXPECT_EQ(tops, 90);
}

TEST(FaceChoice, PublishedSaddleIsJoinedAsByPyKirigami) {
  const std::ptrdiff_t tops = topsOfPublishedSaddle(formats::FaceRule::PyKirigami);
  if (tops < 0) GTEST_SKIP() << "../shared/models/sphere-to-saddle is not there";
  EXPECT_EQ(tops, 45);
}

}  // namespace
}  // namespace kirireel
