// Checks meshes with other programs. Skipped if they are not installed.
#include <gtest/gtest.h>

#include "render/writers/mesh.h"
#include "sim/base/files.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/program.h"

namespace kirireel {
namespace {

/// The integer after a label in a program's output; -1 without it.
int numberAfter(const std::string& output, const std::string& label) {
  const std::size_t place = output.find(label);
  return place == std::string::npos ? -1 : std::stoi(output.substr(place + label.size()));
}

/// The output of a program for a mesh of four hinged squares.
std::string reportOf(const std::string& command, const std::string& name) {
  const test::Layout layout = test::hingedSquares();
  const test::TemporaryFolder folder;
  writers::writeMesh(folder / name, layout.bricks, layout.poses);
  return test::outputOf(command + " '" + (folder / name).string() + "'");
}

TEST(MeshTools, AssimpCountsMeshesAndFaces) {
  if (!test::hasProgram("assimp")) GTEST_SKIP() << "install assimp-utils to check meshes with it";
  const std::string obj = reportOf("assimp info", "state.obj");
  EXPECT_EQ(numberAfter(obj, "Meshes:"), 4);
  EXPECT_EQ(numberAfter(obj, "Faces:"), 48);
  const std::string ply = reportOf("assimp info", "state.ply");
  EXPECT_EQ(numberAfter(ply, "Meshes:"), 1);
  EXPECT_EQ(numberAfter(ply, "Faces:"), 48);
}

TEST(MeshTools, AdmeshFindsFourValidParts) {
  if (!test::hasProgram("admesh")) GTEST_SKIP() << "install admesh to check STL files with it";
  const std::string report = reportOf("admesh", "state.stl");
  EXPECT_EQ(numberAfter(report, "Number of parts       :"), 4) << report;
  EXPECT_EQ(numberAfter(report, "Number of facets                 :"), 48);
  EXPECT_EQ(numberAfter(report, "Facets reversed       :"), 0);
  EXPECT_EQ(numberAfter(report, "Normals fixed         :"), 0);
}

TEST(MeshTools, GltfValidatorFindsNothingInTheAnimation) {
  const std::string node = "NODE_PATH=$(npm root -g) node -e \"const v=require('gltf-validator');";
  if (test::outputOf(node + "console.log(1)\"").empty()) {
    GTEST_SKIP() << "install gltf-validator (npm install -g gltf-validator) to check animations";
  }
  const model::Model model = generate::makeTessellation(test::squares(10, 10, 0.5));
  const test::Layout layout = test::layoutOf(model.tiles, model.joints);
  const test::TemporaryFolder folder;
  const std::string bytes = writers::animationBytes(layout.bricks, 121, [&layout](std::size_t k) {
    writers::AnimationKey key{static_cast<double>(k) / 60, layout.poses};
    for (Pose& pose : key.poses) pose.rotation = rotationFromVector({0.1, 0, 0.05 * double(k)});
    return key;
  });
  writeTextFile(folder / "x.glb", bytes);
  const std::string counts = test::outputOf(
      node + "v.validateBytes(new Uint8Array(require('fs').readFileSync('" +
      (folder / "x.glb").string() +
      "'))).then(r=>console.log(r.issues.numErrors,r.issues.numWarnings,r.info.drawCallCount))\"");
  EXPECT_EQ(counts, "0 0 100\n");
}

}  // namespace
}  // namespace kirireel
