// Paths to flat-folded targets: on the path, mountains and valleys fold to their sides, which the
// poses of the target do not define.

#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/formats/read_model.h"
#include "sim/model/isometry.h"
#include "sim/scene/scene_needs.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

/// A crease between two faces, from one vertex to another as in the first face.
struct Fold {
  int from, to, faceA, faceB;
  char letter;
};

/// A flat crease pattern whose folds have letters only.
struct LetteredSheet {
  std::vector<Vector3> vertices;
  std::vector<std::vector<int>> faces;
  std::vector<Fold> folds;

  /// The text of a FOLD file, its points moved by a rigid motion.
  std::string text(const Quaternion& turn) const {
    std::vector<std::string> points, outlines, ends, letters;
    for (const Vector3& vertex : vertices) {
      const Vector3 p = turn * vertex + Vector3(3, -1, 2);
      points.push_back(fmt::format("[{},{},{}]", p.x(), p.y(), p.z()));
    }
    for (const std::vector<int>& face : faces) {
      outlines.push_back(fmt::format("[{}]", fmt::join(face, ",")));
    }
    for (const Fold& fold : folds) {
      ends.push_back(fmt::format("[{},{}]", fold.from, fold.to));
      letters.push_back(fmt::format("\"{}\"", fold.letter));
    }
    return fmt::format(R"({{"file_spec":1.1,"vertices_coords":[{}],"faces_vertices":[{}],)"
                       R"("edges_vertices":[{}],"edges_assignment":[{}]}})",
                       fmt::join(points, ","), fmt::join(outlines, ","), fmt::join(ends, ","),
                       fmt::join(letters, ","));
  }
};

/// Unit squares in a row, with a fold between each two.
LetteredSheet strip(const std::string& letters) {
  LetteredSheet sheet;
  const int count = static_cast<int>(letters.size()) + 1;
  for (int k = 0; k <= count; ++k) {
    sheet.vertices.emplace_back(k, 0, 0);
    sheet.vertices.emplace_back(k, 1, 0);
  }
  for (int k = 0; k < count; ++k) sheet.faces.push_back({2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1});
  for (int k = 1; k < count; ++k) {
    sheet.folds.push_back({2 * k, 2 * k + 1, k - 1, k, letters[static_cast<std::size_t>(k - 1)]});
  }
  return sheet;
}

/// Miura's pattern of columns x rows parallelograms. Zigzag lines have one letter each, in turn.
LetteredSheet miura(int columns, int rows, double slant) {
  LetteredSheet sheet;
  const auto at = [&](int i, int j) { return i * (rows + 1) + j; };
  for (int i = 0; i <= columns; ++i) {
    for (int j = 0; j <= rows; ++j) sheet.vertices.emplace_back(i, j + (i % 2) * slant, 0);
  }
  const auto faceAt = [&](int i, int j) { return i * rows + j; };
  const auto letter = [](bool isMountain) { return isMountain ? 'M' : 'V'; };
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      sheet.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      if (j > 0) {
        sheet.folds.push_back(
            {at(i + 1, j), at(i, j), faceAt(i, j - 1), faceAt(i, j), letter(j % 2 == 0)});
      }
      if (i > 0) {
        sheet.folds.push_back(
            {at(i, j), at(i, j + 1), faceAt(i - 1, j), faceAt(i, j), letter((i + j) % 2 == 1)});
      }
    }
  }
  return sheet;
}

/// The fold's angle after both faces have turned, positive for a valley, by the faces' normals.
double foldAngle(const LetteredSheet& sheet, const Fold& fold, const Quaternion& turn,
                 const Poses& poses) {
  const Vector3 normal = turn * Vector3::UnitZ();
  const Vector3 edge = turn * (sheet.vertices[fold.to] - sheet.vertices[fold.from]);
  const Quaternion &a = poses[fold.faceA].rotation, &b = poses[fold.faceB].rotation;
  const Vector3 normalA = a * normal, normalB = b * normal;
  return std::atan2(-normalA.cross(normalB).dot(a * edge.normalized()), normalA.dot(normalB));
}

void expectFoldsOnTheirSides(const LetteredSheet& sheet, const Quaternion& turn) {
  const test::TemporaryFolder folder;
  folder.write("sheet.fold", sheet.text(turn));
  scene::Scene scene = scene::openScene();
  std::vector<std::string> warnings;
  scene.model = formats::readModel(folder / "sheet.fold", std::nullopt, warnings);
  ASSERT_TRUE(scene.model.target);
  const model::RigidMotion aligned = model::alignStartToTarget(scene.model);
  scene::fillFromModel(scene);
  const run::DeploymentResult run = deploy::deploy(scene, 0.1, nullptr);
  const double tile = model::tileSize(scene.model);
  EXPECT_LE(run.accuracy.targetErrorEnd, 1e-6 * tile) << sheet.text(turn);  // measured 3e-13
  const std::vector<trajectory::Sample>& samples = run.trajectory.samples;
  // From a quarter to three quarters of the time, where folds are clearly open.
  for (std::size_t k = samples.size() / 4; k <= 3 * samples.size() / 4; ++k) {
    for (const Fold& fold : sheet.folds) {
      const double angle =
          foldAngle(sheet, fold, Quaternion(aligned.rotation) * turn, samples[k].poses);
      EXPECT_GT(fold.letter == 'V' ? angle : -angle, 0.1) << k << ' ' << sheet.text(turn);
    }
  }
}

Quaternion drawnTurn(unsigned seed) {
  std::mt19937 draw(seed);
  std::normal_distribution<double> normal;
  return Quaternion(normal(draw), normal(draw), normal(draw), normal(draw)).normalized();
}

TEST(FoldsOfHalfATurn, KeepTheirSidesOnStrips) {
  unsigned seed = 0;
  for (const char* letters : {"V", "M", "VM", "MV", "VV", "VMM", "VVM", "VMVMV", "MVVMM"}) {
    expectFoldsOnTheirSides(strip(letters), Quaternion::Identity());
    expectFoldsOnTheirSides(strip(letters), drawnTurn(++seed));
  }
}

TEST(FoldsOfHalfATurn, KeepTheirSidesAroundVertices) {
  expectFoldsOnTheirSides(miura(3, 3, 0.5), Quaternion::Identity());
  expectFoldsOnTheirSides(miura(4, 3, 0.8), drawnTurn(20));
}

}  // namespace
}  // namespace kirireel
