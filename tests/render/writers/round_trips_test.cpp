// Every model of data/ and 50 random ones through each format that can store them.
//
// Oracle: the written model. FOLD, OBJ and folders keep every bit, planar files all distances,
// drawings all positions. Mobility is computed again for each model.
#include <map>
#include <optional>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "render/writers/flat_sheet.h"
#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/formats/written_digits.h"
#include "sim/generate/families.h"
#include "sim/model/sheet_frame.h"
#include "sim/trajectory/sheet.h"
#include "tests/render/writers/same_sheet.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

namespace fs = std::filesystem;

int freedomsOf(const model::Model& model, trajectory::Freedom freedom) {
  return trajectory::mobility(model, model.tiles, freedom, 0.02 * model::tileSize(model)).freedoms;
}

model::Model readBack(const fs::path& file) {
  std::vector<std::string> warnings;
  return formats::readModel(file, std::nullopt, warnings);
}

void expectSameBits(const model::Model& read, const model::Model& written,
                    const std::string& name) {
  ASSERT_EQ(read.tiles.size(), written.tiles.size()) << name;
  ASSERT_EQ(read.target.has_value(), written.target.has_value()) << name;
  for (std::size_t i = 0; i < read.tiles.size(); ++i) {
    EXPECT_EQ(read.tiles[i].vertices, written.tiles[i].vertices) << name;
    if (!read.target) continue;
    EXPECT_EQ((*read.target)[i].vertices, (*written.target)[i].vertices) << name;
  }
  ASSERT_EQ(read.joints.size(), written.joints.size()) << name;
  for (std::size_t k = 0; k < read.joints.size(); ++k) {
    EXPECT_EQ(read.joints[k].a, written.joints[k].a) << name;
    EXPECT_EQ(read.joints[k].b, written.joints[k].b) << name;
    EXPECT_EQ(read.joints[k].face, written.joints[k].face) << name;
    EXPECT_EQ(read.joints[k].kind, written.joints[k].kind) << name;
  }
}

/// Planar files have neither target nor faces, and lie in the plane z = 0.
void expectSameDistances(const model::Model& read, const model::Model& written,
                         const std::string& name) {
  ASSERT_EQ(read.tiles.size(), written.tiles.size()) << name;
  for (std::size_t i = 0; i < read.tiles.size(); ++i) {
    ASSERT_EQ(read.tiles[i].vertices.size(), written.tiles[i].vertices.size()) << name;
    for (std::size_t k = 0; k < read.tiles[i].vertices.size(); ++k) {
      for (const std::size_t corner : {std::size_t{0}, std::size_t{1}}) {
        EXPECT_NEAR((read.tiles[i].vertices[k] - read.tiles[0].vertices[corner]).norm(),
                    (written.tiles[i].vertices[k] - written.tiles[0].vertices[corner]).norm(),
                    1e-12 * model::modelSize(written))
            << name;
      }
    }
  }
  ASSERT_EQ(read.joints.size(), written.joints.size()) << name;
  for (std::size_t k = 0; k < read.joints.size(); ++k) {
    EXPECT_EQ(read.joints[k].a, written.joints[k].a) << name;
    EXPECT_EQ(read.joints[k].b, written.joints[k].b) << name;
  }
}

/// Through FOLD, a pair of OBJ files and a folder.
void expectSpatialFormatsKeep(const model::Model& model, const std::string& name) {
  const test::TemporaryFolder folder;
  // Equal bits have equal ranks, so large sheets are not counted again.
  const bool isSmall = model.tiles.size() <= 50;
  const int freedoms = isSmall ? freedomsOf(model, trajectory::Freedom::Space) : 0;
  for (const char* file : {"a.fold", "a_contracted.obj", "a"}) {
    formats::writeModel(model, folder / file);
    const model::Model read = readBack(folder / file);
    expectSameBits(read, model, name + file);
    if (!isSmall) continue;
    EXPECT_EQ(freedomsOf(read, trajectory::Freedom::Space), freedoms) << name << file;
  }
}

/// Through planar files. The start is flat and horizontal.
void expectPlanarFilesKeep(const model::Model& model, const std::string& name) {
  const test::TemporaryFolder folder;
  formats::writeModel(model, folder / "a_vertices.txt");
  const model::Model read = readBack(folder / "a_vertices.txt");
  expectSameDistances(read, model, name + "planar");
  EXPECT_EQ(freedomsOf(read, trajectory::Freedom::Plane),
            freedomsOf(model, trajectory::Freedom::Plane))
      << name;
}

/// Through drawings. The start is flat and horizontal.
void expectDrawingsKeep(const model::Model& model, const std::string& name,
                        std::optional<double> hingeWidth) {
  const test::TemporaryFolder folder;
  const auto lines = writers::cutPattern(model, hingeWidth);
  folder.write("a.svg", writers::patternSvg(lines));
  folder.write("a.dxf", writers::patternDxf(lines));
  for (const char* file : {"a.svg", "a.dxf"}) {
    const model::Model read = readBack(folder / file);
    test::expectSameSheet(read, model, name + file);
    EXPECT_EQ(freedomsOf(read, trajectory::Freedom::Plane),
              freedomsOf(model, trajectory::Freedom::Plane))
        << name << file;
  }
}

/// The length of the shortest edge. Absent if edges of two tiles differ by less than a millionth of
/// the sheet but are not equal: readers join them.
std::optional<double> minDrawnEdge(const model::Model& model) {
  const double tile = model::tileSize(model);
  std::vector<std::pair<Vector3, Vector3>> edges;
  for (const model::Tile& one : model.tiles) {
    for (std::size_t k = 0; k < one.vertices.size(); ++k) {
      edges.emplace_back(one.vertices[k], one.vertices[(k + 1) % one.vertices.size()]);
    }
  }
  double least = tile;
  for (const auto& [from, to] : edges) {
    least = std::min(least, (to - from).norm());
    for (const auto& [otherFrom, otherTo] : edges) {
      const double apart = std::max((from - otherTo).norm(), (to - otherFrom).norm());
      if (apart > 1e-9 * tile && apart < formats::kSamePlace * model::modelSize(model))
        return std::nullopt;
    }
  }
  return least;
}

bool isHorizontal(const model::Model& model) {
  const auto frame = model::sheetFrame(model.tiles, 1e-9 * model::modelSize(model));
  return frame && frame->isHorizontal();
}

TEST(RoundTrips, KeepTheModelsOfData) {
  int count = 0, planar = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(KIRIREEL_SOURCE_DIR) / "data")) {
    if (!fs::is_directory(entry.path()) || entry.path().filename() == "pictures" ||
        entry.path().filename() == "scenes") {
      continue;
    }
    const std::string name = entry.path().filename().string() + " ";
    const model::Model model = readBack(entry.path());
    expectSpatialFormatsKeep(model, name);
    ++count;
    if (!isHorizontal(model)) continue;
    expectPlanarFilesKeep(model, name);
    expectDrawingsKeep(model, name, std::nullopt);
    ++planar;
  }
  EXPECT_GE(count, 27);
  EXPECT_GE(planar, 20);
}

class RandomModels {
 public:
  /// A model of a random family with random parameters; absent if these contradict each other.
  std::optional<model::Model> draw() {
    const std::vector<generate::Family>& families = generate::families();
    return draw(families[random_() % families.size()]);
  }
  std::optional<model::Model> draw(const generate::Family& family) {
    std::map<std::string, double> given;
    for (const generate::FamilyParameter& parameter : family.parameters) {
      // At most twice the default, so the sheets stay small.
      const double most = std::min(parameter.most, 2 * std::abs(parameter.defaultValue) + 0.1);
      double value = parameter.least + share() * (most - parameter.least);
      if (parameter.whole) value = std::floor(value + 0.5);
      given[parameter.name] = std::clamp(value, parameter.least, parameter.most);
    }
    try {
      return generate::generateModel(family, given);
    } catch (const InputError&) {
      return std::nullopt;
    }
  }

  /// The same model in another position in space with random faces.
  model::Model turned(model::Model model) {
    const Matrix3 turn =
        rotationFromVector(Vector3(share(), share(), 3 * share())).toRotationMatrix();
    const auto move = [&](std::vector<model::Tile>& tiles) {
      for (model::Tile& tile : tiles) {
        for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
      }
    };
    move(model.tiles);
    if (model.target) move(*model.target);
    for (model::Joint& joint : model.joints) {
      joint.face = static_cast<model::JointFace>(1 + random_() % 3);
    }
    return model;
  }

 private:
  double share() { return random_() / 4294967296.0; }

  std::mt19937 random_{1};
};

TEST(RoundTrips, KeepRandomModels) {
  RandomModels random;
  std::map<std::string, int> drawn;
  int planar = 0, inDrawings = 0;
  for (int k = 0; k < 50;) {
    const std::optional<model::Model> model = random.draw();
    if (!model) continue;
    ++drawn[model->name];
    const std::string name = fmt::format("{} {} ", k++, model->name);
    expectSpatialFormatsKeep(random.turned(*model), name);
    if (!isHorizontal(*model)) continue;
    expectPlanarFilesKeep(*model, name);
    ++planar;
    const std::optional<double> edge = minDrawnEdge(*model);
    if (!edge) continue;
    expectDrawingsKeep(*model, name, 0.1 * *edge);
    ++inDrawings;
  }
  EXPECT_GE(drawn.size(), 15U);
  EXPECT_GE(planar, 25);
  EXPECT_GE(inDrawings, 20);
}

// Starts of these are open, with gaps of any angle.
TEST(RoundTrips, KeepRandomFansAndCrossesInDrawings) {
  RandomModels random;
  for (const char* family : {"fan", "crosses"}) {
    int count = 0;
    for (int k = 0; k < 30; ++k) {
      const std::optional<model::Model> model = random.draw(generate::familyNamed(family));
      const std::optional<double> edge = model ? minDrawnEdge(*model) : std::nullopt;
      if (!edge) continue;
      expectDrawingsKeep(*model, fmt::format("{} {} ", family, k), 0.4 * *edge);
      ++count;
    }
    EXPECT_GE(count, 5) << family;
  }
}

}  // namespace
}  // namespace kirireel
