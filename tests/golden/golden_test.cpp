/// Compares pictures with those in the repository. To make them again after an intended change:
///   KIRIREEL_GOLDEN=update build/dev/tests/golden/golden_test
/// and check the changed files by eye before they are committed.
#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "render/picture/grid.h"
#include "render/picture/png.h"
#include "render/record/record.h"
#include "sim/formats/read_model.h"
#include "sim/model/isometry.h"
#include "tests/golden/golden_scenes.h"
#include "tests/support/files.h"
#include "tests/support/png.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

constexpr picture::FrameSize kCell = {240, 180};
constexpr picture::GridShape kSheet = {4, 5};

/// On the machine that made them the pictures are equal byte by byte. Elsewhere borders may be on
/// other samples and letters may come from another FreeType. Limits per cell of a sheet: the mean
/// difference in levels, and the fraction of pixels that differ by more than 40.
constexpr double kMeanTolerance = 0.3;
constexpr double kShareTolerance = 0.003;

fs::path inRepository(const std::string& file) {
  return fs::path(KIRIREEL_SOURCE_DIR) / file;
}

/// A part of a picture, pixels, without its right column and lowest row.
struct Part {
  std::string name;
  int left = 0, upper = 0, right = 0, lower = 0;
};

Part whole(const picture::Frame& frame) {
  return {"picture", 0, 0, frame.size.width, frame.size.height};
}

bool alike(const picture::Frame& a, const picture::Frame& b, const Part& part) {
  const double pixels = static_cast<double>(part.right - part.left) * (part.lower - part.upper);
  double mean = 0, share = 0;
  for (int y = part.upper; y < part.lower; ++y) {
    for (int x = part.left; x < part.right; ++x) {
      const picture::Colour p = a.at(x, y), q = b.at(x, y);
      const int levels[] = {std::abs(p.red - q.red), std::abs(p.green - q.green),
                            std::abs(p.blue - q.blue), std::abs(p.alpha - q.alpha)};
      mean += (levels[0] + levels[1] + levels[2] + levels[3]) / (4 * pixels);
      share += *std::max_element(levels, levels + 4) > 40 ? 1 / pixels : 0;
    }
  }
  EXPECT_LT(mean, kMeanTolerance) << part.name;
  EXPECT_LT(share, kShareTolerance) << part.name;
  return mean < kMeanTolerance && share < kShareTolerance;
}

/// Compares with the picture in the repository, or replaces it on request. A different picture is
/// written to the test's output.
void expectGolden(const picture::Frame& frame, const std::string& file,
                  const std::vector<Part>& parts) {
  const fs::path golden = inRepository(file);
  const char* wish = std::getenv("KIRIREEL_GOLDEN");
  if (wish != nullptr && std::string(wish) == "update") {
    picture::writePng(frame, golden, {.compressionLevel = 9});
    return;
  }
  const picture::Frame expected = test::readPng(golden);
  bool same = expected.size == frame.size;
  if (same) {
    for (const Part& part : parts) same &= alike(expected, frame, part);
  }
  if (same) return;
  const fs::path left = fs::path(testing::TempDir()) / golden.filename();
  picture::writePng(frame, left);
  ADD_FAILURE() << "compare " << left << " with " << golden;
}

picture::GridPicture picture(const test::GoldenScene& scene, const test::GoldenLook& appearance) {
  picture::StatePainter painter(kCell, appearance.appearance, scene.content, {.colours = true});
  return {painter.paint({0.5, scene.poses, appearance.pinned, 0.5}), appearance.name};
}

class GoldenSheet : public testing::TestWithParam<int> {};

TEST_P(GoldenSheet, ShowsEveryStyleAsBefore) {
  const test::GoldenScene scene = test::goldenScenes()[GetParam()];
  const picture::GridLayout layout = picture::layOutGrid(kCell, kSheet);
  std::vector<picture::GridPicture> pictures;
  std::vector<Part> parts;
  for (const test::GoldenLook& appearance : test::goldenLooks()) {
    const int cell = static_cast<int>(pictures.size());
    const int left = layout.left(cell % kSheet.columns),
              upper = layout.upper(cell / kSheet.columns);
    parts.push_back({appearance.name, left, upper, left + kCell.width, upper + kCell.height});
    pictures.push_back(picture(scene, appearance));
  }
  expectGolden(picture::composeGrid(pictures, kSheet), "tests/golden/" + scene.name + ".png",
               parts);
}

INSTANTIATE_TEST_SUITE_P(Scenes, GoldenSheet, testing::Range(0, 6));

/// The pictures in the README are those of the program.
TEST(ReadmePictures, AreWhatTheProgramMakes) {
  const test::TemporaryFolder folder;
  scene::Scene scene;
  std::vector<std::string> warnings;
  scene.model = formats::readModelFolder(inRepository("data/tessellation_4x4"), warnings);
  model::alignStartToTarget(scene.model);
  record::RecordSettings settings;
  settings.folder = folder.path();
  settings.size = {640, 480};
  settings.grid = {1, 4};
  settings.appearance.camera.view = picture::kObliqueView;
  settings.appearance.ground = picture::GroundLook::Shadow;
  settings.video = settings.meshes = false;
  scene.brick.thickness = 0.12;
  scene.path.kind = scene::PathKind::Auto;
  record::record(scene, settings, [](const record::Progress&) { return record::Interruption{}; });
  const picture::Frame frame = test::readPng(folder / "snapshots.png");
  expectGolden(frame, "data/pictures/tessellation_4x4.png", {whole(frame)});
}

}  // namespace
}  // namespace kirireel
