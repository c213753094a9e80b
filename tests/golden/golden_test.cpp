/// Compares pictures with those in the repository. To make them anew after a wanted change:
///   KIRIREEL_GOLDEN=update build/dev/tests/golden/golden_test
/// and judge the changed files by eye before they are committed.
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "render/grid/grid.h"
#include "render/png/png.h"
#include "render/record/record.h"
#include "sim/model/alignment.h"
#include "sim/model/folder.h"
#include "tests/golden/golden_scenes.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr FrameSize kCell = {240, 180};
constexpr GridShape kSheet = {4, 5};

/// On the machine that made them the pictures are equal byte by byte. Elsewhere borders may fall on
/// other samples and letters come from another FreeType: mean difference in levels, and the part of
/// the pixels that differ by more than 40.
constexpr double kMeanTolerance = 0.3;
constexpr double kShareTolerance = 0.003;

fs::path inRepository(const std::string& file) {
  return fs::path(KIRIREEL_SOURCE_DIR) / file;
}

struct Difference {
  double mean = 0;
  double share = 0;
};

Difference difference(const Frame& a, const Frame& b) {
  Difference result;
  const double pixels = static_cast<double>(a.pixels.size()) / 4;
  for (std::size_t pixel = 0; pixel < a.pixels.size(); pixel += 4) {
    int most = 0;
    for (int k = 0; k < 4; ++k) {
      const int levels = std::abs(a.pixels[pixel + k] - b.pixels[pixel + k]);
      most = std::max(most, levels);
      result.mean += levels / (4 * pixels);
    }
    result.share += most > 40 ? 1 / pixels : 0;
  }
  return result;
}

/// Compares with the picture in the repository, or takes its place when told to update. A picture
/// that differs is left beside the test's other files.
void expectGolden(const Frame& frame, const std::string& file) {
  const fs::path golden = inRepository(file);
  const char* wish = std::getenv("KIRIREEL_GOLDEN");
  if (wish != nullptr && std::string(wish) == "update") {
    writePng(frame, golden, {.compressionLevel = 9});
    return;
  }
  const Frame expected = readPng(golden);
  bool alike = expected.size == frame.size;
  if (alike) {
    const Difference levels = difference(expected, frame);
    EXPECT_LT(levels.mean, kMeanTolerance) << file;
    EXPECT_LT(levels.share, kShareTolerance) << file;
    alike = levels.mean < kMeanTolerance && levels.share < kShareTolerance;
  }
  if (alike) return;
  const fs::path left = fs::path(testing::TempDir()) / golden.filename();
  writePng(frame, left);
  ADD_FAILURE() << "compare " << left << " with " << golden;
}

GridPicture picture(const test::GoldenScene& scene, const test::GoldenLook& look) {
  Studio studio(kCell, look.look, scene.motif);
  return {studio.take({0.5, scene.poses, look.pinned}, Studio::Scales::Drawn), look.name};
}

class GoldenSheet : public testing::TestWithParam<int> {};

TEST_P(GoldenSheet, ShowsEveryLookAsBefore) {
  test::GoldenScene scene = test::goldenScenes()[GetParam()];
  scene.motif.endTime = 1;
  std::vector<GridPicture> pictures;
  for (const test::GoldenLook& look : test::goldenLooks()) {
    pictures.push_back(picture(scene, look));
  }
  expectGolden(composeGrid(pictures, kSheet), "tests/golden/" + scene.name + ".png");
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenSheet, testing::Range(0, 6));

/// The pictures on the front page are what the program makes.
TEST(ReadmePictures, AreWhatTheProgramMakes) {
  const test::TemporaryFolder folder;
  Scene scene;
  std::vector<std::string> warnings;
  scene.model = readModelFolder(inRepository("data/tessellation_4x4"), warnings);
  alignStartToTarget(scene.model);
  RecordSettings settings;
  settings.folder = folder.path();
  settings.size = {640, 480};
  settings.grid = {1, 4};
  settings.look.camera.view = kObliqueView;
  settings.look.ground = GroundLook::Shadow;
  settings.video = settings.meshes = false;
  scene.brick.thickness = 0.12;
  record(scene, settings, [](const Progress&) { return true; });
  expectGolden(readPng(folder / "snapshots.png"), "data/pictures/tessellation_4x4.png");
}

}  // namespace
}  // namespace kirireel
