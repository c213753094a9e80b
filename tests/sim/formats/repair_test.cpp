// Files with clear errors: each is repaired with one line of report, and refused by --strict.
#include <cmath>
#include <functional>
#include <map>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/written_digits.h"
#include "sim/generate/lattice.h"
#include "sim/model/sheet_frame.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using Files = std::map<std::string, std::string>;

std::string withoutPlace(std::string text, const std::string& place) {
  for (std::size_t at = text.find(place); at != text.npos; at = text.find(place)) {
    text.replace(at, place.size(), "@");
  }
  return text;
}

struct Reading {
  model::Model model;
  std::vector<std::string> warnings;
  std::string error;  ///< if the file was refused
};

/// Files of a folder, read by the name of one of them.
Reading readFiles(const Files& files, const std::string& named,
                  const formats::ReadSettings& settings = {}) {
  const TemporaryFolder folder;
  for (const auto& [name, text] : files) folder.write(name, text);
  Reading reading;
  const fs::path path = named.empty() ? folder.path() : folder.path() / named;
  try {
    reading.model = formats::readModel(path, std::nullopt, reading.warnings, settings);
  } catch (const InputError& error) {
    reading.error = withoutPlace(error.what(), folder.path().string());
  }
  for (std::string& warning : reading.warnings) {
    warning = withoutPlace(warning, folder.path().string());
  }
  return reading;
}

std::string decimals(double value, int count) {
  return fmt::format("{:.{}f}", value, count);
}

/// A planar model's files: "x y" with so many decimals, joints from 1.
Files planarFiles(const model::Model& model, int places, const std::string& name = "sheet") {
  std::string vertices, joints;
  for (const model::Tile& tile : model.tiles) {
    for (const Vector3& v : tile.vertices) {
      vertices += decimals(v.x(), places) + " " + decimals(v.y(), places) + " ";
    }
    vertices += "\n";
  }
  for (const model::Joint& joint : model.joints) {
    joints += fmt::format("{} {} {} {}\n", joint.a.tile + 1, joint.a.vertex + 1, joint.b.tile + 1,
                          joint.b.vertex + 1);
  }
  return {{name + "_vertices.txt", vertices}, {name + "_constraints.txt", joints}};
}

/// An open sheet with coordinates that no short decimals hold.
model::Model openSheet(double length = 1) {
  generate::TessellationShape shape;
  shape.length = shape.width = length;
  shape.startAngle = 0.7;
  model::Model model = generate::makeTessellation(shape);
  model.target.reset();
  return model;
}

const std::string kTwoSquares =
    "0 0 0 1 0 0 1 1 0 0 1 0\n"
    "1 0 0 2 0 0 2 1 0 1 1 0\n";

TEST(Repair, RepeatedJointsCountOnce) {
  const Reading read = readFiles(
      {{"vertices.txt", kTwoSquares}, {"constraints.txt", "0 1 1 0 3\n1 0 0 1 3\n0 1 1 0 1\n"}},
      "");
  ASSERT_EQ(read.model.joints.size(), 1U);
  EXPECT_EQ(read.model.joints[0].face, model::JointFace::Both);
  EXPECT_THAT(read.warnings,
              ElementsAre("@/constraints.txt:2: repaired: 2 joints are listed again, first in line "
                          "1; repeated joints are removed, regardless of the order of their ends"));
  ASSERT_EQ(read.model.repairs.size(), 1U);
  EXPECT_EQ(read.model.repairs[0].corners.size(), 2U);
}

TEST(Repair, ARepeatedJointKeepsItsNewFace) {
  const Reading read =
      readFiles({{"vertices.txt", kTwoSquares}, {"constraints.txt", "0 1 1 0 1\n1 0 0 1 3\n"}}, "");
  ASSERT_EQ(read.model.joints.size(), 2U);
  EXPECT_EQ(read.model.joints[1].face, model::JointFace::Top);
}

TEST(Repair, StrictRefusesWithAdvice) {
  formats::ReadSettings strict;
  strict.strict = true;
  EXPECT_EQ(readFiles({{"vertices.txt", kTwoSquares}, {"constraints.txt", "0 1 1 0\n1 0 0 1\n"}},
                      "", strict)
                .error,
            "@/constraints.txt:2: error: 1 joint is listed again, first in line 1; delete the "
            "repeated lines, or remove `strict` to have it repaired");
  EXPECT_EQ(readFiles({{"vertices.txt", kTwoSquares}, {"constraints.txt", ""}}, "", strict).error,
            "@/constraints.txt: error: the file is empty; write the line \"# no joints\" if the "
            "tiles are loose, or remove `strict` to have it repaired");
  EXPECT_EQ(readFiles({{"vertices.txt", "0 0 0 0 1 0 1 1 0\n"}, {"constraints.txt", "# none\n"}},
                      "", strict)
                .error,
            "@/vertices.txt:1: error: 1 of 1 tiles runs clockwise seen from above; list their "
            "vertices anticlockwise, or remove `strict` to have it repaired");
  EXPECT_EQ(readFiles({{"vertices.txt", kTwoSquares}, {"constraints.txt", "1 2 2 1\n"}}, "", strict)
                .error,
            "@/constraints.txt: error: tiles and vertices count from 1, not from 0; "
            "subtract 1 from all tile and vertex numbers, or remove `strict` to have it repaired");
  // Files without errors pass.
  EXPECT_EQ(
      readFiles({{"vertices.txt", kTwoSquares}, {"constraints.txt", "0 1 1 0 3\n"}}, "", strict)
          .error,
      "");
}

TEST(Repair, OneDigitApartIsOneCorner) {
  // A sheet 300 wide with three decimals, one corner of one joint off by one in the last.
  model::Model model = openSheet(75);
  const model::Corner moved = model.joints[3].b;
  Files files = planarFiles(model, 3);
  for (model::Tile& tile : model.tiles) {
    for (Vector3& v : tile.vertices) v = (v * 1000).array().round().matrix() / 1000;
  }
  model.tiles[moved.tile].vertices[moved.vertex].x() += 0.001;
  files["sheet_vertices.txt"] = planarFiles(model, 3)["sheet_vertices.txt"];
  const Reading read = readFiles(files, "sheet_vertices.txt");
  for (const model::Joint& joint : read.model.joints)
    EXPECT_EQ(joint.kind, model::JointKind::Pivot);
  ASSERT_EQ(read.warnings.size(), 1U);
  EXPECT_THAT(read.warnings[0],
              HasSubstr("are 0.001 apart, by rounding to 0.001; joined at one corner"));
  EXPECT_NEAR(read.model.rounding, 1e-3, 1e-12);
  formats::ReadSettings strict;
  strict.strict = true;
  EXPECT_THAT(readFiles(files, "sheet_vertices.txt", strict).error,
              HasSubstr("write the same numbers for both corners"));
}

TEST(Repair, RodsAreReportedWithTheirLength) {
  const Files files = {
      {"a_vertices.txt", "0 0 1 0 1 1 0 1\n1 0 2 0 2 1 1 1\n2.125 0 3.125 0 3.125 1 2.125 1\n"},
      {"a_constraints.txt", "1 2 2 1\n2 2 3 1\n"}};
  const Reading read = readFiles(files, "a_vertices.txt");
  EXPECT_EQ(read.model.joints[0].kind, model::JointKind::Pivot);
  EXPECT_EQ(read.model.joints[1].kind, model::JointKind::Link);
  EXPECT_THAT(read.warnings,
              ElementsAre("@/a_constraints.txt:2: note: 1 joint is a rod of constant length, 0.125 "
                          "(corners clearly apart)"));
}

TEST(Repair, DigitsAreFoundInTheNumbers) {
  const std::vector<model::Tile> exact = openSheet().tiles;
  const auto rounded = [&](const std::function<double(double)>& round) {
    std::vector<model::Tile> tiles = exact;
    for (model::Tile& tile : tiles) {
      for (Vector3& v : tile.vertices) v = v.unaryExpr(round);
    }
    return tiles;
  };
  EXPECT_EQ(formats::lastPlace(exact), 0);
  for (const int places : {2, 3, 4, 6}) {
    const auto tiles = rounded([&](double x) { return std::stod(decimals(x, places)); });
    EXPECT_NEAR(formats::lastPlace(tiles) * std::pow(10, places), 1, 1e-12) << places;
  }
  // Significant digits: coordinates reach from 0.05 to 3, so three of them are hundredths.
  const auto tiles = rounded([](double x) { return std::stod(fmt::format("{:.3g}", x)); });
  EXPECT_NEAR(formats::lastPlace(tiles), 1e-2, 1e-14);
  // Texts of floats have as many digits as their writer gives them. The largest is between 2 and 4.
  for (const int digits : {9, 12, 17}) {
    const auto floats = rounded([&](double x) {
      return std::stod(fmt::format("{:.{}g}", static_cast<double>(static_cast<float>(x)), digits));
    });
    EXPECT_EQ(formats::lastPlace(floats), std::ldexp(1, -22)) << digits;
  }
  const auto decimal = rounded([](double x) { return std::stod(fmt::format("{:.9g}", x)); });
  EXPECT_NEAR(formats::lastPlace(decimal), 1e-8, 1e-20);
}

TEST(Repair, SheetsInSinglePrecisionAreFlatInEveryPlane) {
  for (int k = 0; k < 50; ++k) {
    const Quaternion turn = rotationFromVector({0.3 * k, std::sin(k), 1.0});
    model::Model model = openSheet();
    for (model::Tile& tile : model.tiles) {
      for (Vector3& v : tile.vertices)
        v = (turn * v + Vector3(k, 0, 0)).cast<float>().cast<double>();
    }
    model.rounding = formats::roundingOf(model.tiles);
    EXPECT_TRUE(model::sheetFrame(model)) << k;
  }
}

TEST(Repair, NumbersThatAreExactAreNotRounded) {
  generate::TessellationShape shape;  // unit squares
  EXPECT_EQ(formats::roundingOf(generate::makeTessellation(shape).tiles), 0);
  shape.length = 0.25;
  EXPECT_EQ(formats::roundingOf(generate::makeTessellation(shape).tiles), 0);
  // Tiles of one metre written to the decimetre: this was intended.
  shape.length = 1.1;
  EXPECT_EQ(formats::roundingOf(generate::makeTessellation(shape).tiles), 0);
}

TEST(Repair, RegularTilingsThatAreEvenByChanceAreRounded) {
  // 0.866 and 0.5 are both even in the third decimal.
  const model::Tile triangle{{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866, 0}}};
  EXPECT_NEAR(formats::roundingOf({triangle}), 1e-3, 1e-15);
  const model::Tile finer{{{0, 0, 0}, {1, 0, 0}, {0.5, 0.866025, 0}}};
  EXPECT_NEAR(formats::roundingOf({finer}), 1e-6, 1e-18);
}

TEST(Repair, CoincidingCornersOfRoundedMeshesAreJoined) {
  // Two squares of an OBJ file with own vertices each, their common corner rounded differently.
  const Reading read =
      readFiles({{"a.obj",
                  "v 0.123 0.457 0\nv 1.106 0.641 0\nv 0.922 1.624 0\nv -0.061 1.440 0\n"
                  "v 1.107 0.640 0\nv 1.924 0.064 0\nv 2.501 0.881 0\nf 1 2 3 4\nf 5 6 7\n"}},
                "a.obj");
  ASSERT_EQ(read.model.joints.size(), 1U);
  EXPECT_EQ(read.model.joints[0].a, (model::Corner{0, 1}));
}

TEST(Repair, PairsWithJointsOfFourColumnsArePlanar) {
  // Only triangles: six numbers are not a tile in space.
  Reading read = readFiles(
      {{"vertices.txt", "0 0 1 0 0 1\n1 0 2 0 1 1\n"}, {"constraints.txt", "1 2 2 1\n"}}, "");
  ASSERT_EQ(read.model.tiles.size(), 2U);
  EXPECT_EQ(read.model.joints[0].face, model::JointFace::Both);
  // Counted from 0, as in folders.
  read = readFiles(
      {{"vertices.txt", "0 0 1 0 0 1\n1 0 2 0 1 1\n"}, {"constraints.txt", "0 1 1 0\n"}}, "");
  EXPECT_EQ(read.model.joints[0].a, (model::Corner{0, 1}));
  EXPECT_THAT(read.warnings[0], HasSubstr("count from 0, not from 1"));
}

TEST(PlanarNames, OpensFromAnyOfItsFiles) {
  Files files = planarFiles(openSheet(), 6, "penrose10");
  const std::string joints = files["penrose10_constraints.txt"];
  files.erase("penrose10_constraints.txt");
  files["penrose10_expansion_constraints.txt"] = joints;
  files["penrose10_expansion_hull.txt"] = "0 0\n3 1\n15 2\n";
  // A longer name with the same beginning has its own files.
  files["penrose10_big_vertices.txt"] = files["penrose10_vertices.txt"];
  files["penrose10_big_constraints.txt"] = "1 1 2 1\n";
  for (const char* named : {"penrose10_vertices.txt", "penrose10_expansion_constraints.txt",
                            "penrose10_expansion_hull.txt"}) {
    const Reading read = readFiles(files, named);
    EXPECT_EQ(read.error, "") << named;
    EXPECT_EQ(read.model.name, "penrose10");
    EXPECT_EQ(read.model.joints.size(), 24U) << named;
    ASSERT_TRUE(read.model.hull) << named;
    EXPECT_THAT(*read.model.hull,
                ElementsAre(model::Corner{0, 0}, model::Corner{3, 1}, model::Corner{15, 2}));
  }
}

TEST(PlanarNames, SeveralListsAreChosenFrom) {
  Files files = planarFiles(openSheet(), 6, "a");
  files["a_expansion_constraints.txt"] = "1 1 2 1\n";
  files["a_hamiltonian_constraints.txt"] = files["a_constraints.txt"];
  Reading read = readFiles(files, "a_vertices.txt");
  EXPECT_EQ(read.model.joints.size(), 24U);
  EXPECT_THAT(
      read.warnings,
      ElementsAre(
          "@/a_constraints.txt: note: these joints are used. Next to them are "
          "a_expansion_constraints.txt, a_hamiltonian_constraints.txt (see `joints_file`)"));
  files.erase("a_constraints.txt");
  EXPECT_EQ(
      readFiles(files, "a_vertices.txt").error,
      "@/a_vertices.txt: error: there are 2 lists of joints next to it: "
      "a_expansion_constraints.txt, a_hamiltonian_constraints.txt. Select one with `joints_file`");
  formats::ReadSettings settings;
  settings.jointsFile = "a_expansion_constraints.txt";
  read = readFiles(files, "a_vertices.txt", settings);
  EXPECT_EQ(read.model.joints.size(), 1U);
  EXPECT_EQ(readFiles({{"a_vertices.txt", "0 0 1 0 0 1\n"}}, "a_vertices.txt").error,
            "@/a_vertices.txt: error: there is no list of joints next to it. Write "
            "a_constraints.txt, or set `joints_file`");
  EXPECT_EQ(readFiles({{"a_constraints.txt", "1 1 2 1\n"}}, "a_constraints.txt").error,
            "@/a_constraints.txt: error: there is no file of vertices with the same beginning of "
            "its name. Add NAME_vertices.txt");
}

TEST(PlanarNames, FoldersTakeAnotherListToo) {
  formats::ReadSettings settings;
  settings.jointsFile = "other.txt";
  const Files files = {{"vertices.txt", kTwoSquares},
                       {"constraints.txt", "0 1 1 0 3\n0 2 1 3 3\n"},
                       {"other.txt", "0 1 1 0 1\n"}};
  EXPECT_EQ(readFiles(files, "", settings).model.joints.size(), 1U);
  EXPECT_EQ(readFiles({{"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"}}, "a.obj", settings).error,
            "@/a.obj: error: this file contains its joints. Remove `joints_file`, or convert the "
            "model to a folder");
}

TEST(PlanarNames, AWrongHullIsIgnoredWithAWarning) {
  Files files = planarFiles(openSheet(), 6, "a");
  files["a_hull.txt"] = "0 0\n99 1\n2 2\n";
  const Reading read = readFiles(files, "a_vertices.txt");
  EXPECT_FALSE(read.model.hull);
  EXPECT_THAT(read.warnings,
              ElementsAre("@/a_hull.txt: error: its 3 rows name missing corners, or too few; write "
                          "one corner of the sheet's outline per line, \"tile vertex\", from 0, at "
                          "least 3. This hull is ignored"));
}

/// Shuffles the tiles and reverses some of them, with joints, hull and target. Returns a model
/// whose file has this order.
model::Model mixedUp(const model::Model& model, std::mt19937& random) {
  model::Model mixed = model;
  std::vector<int> place(model.tiles.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<int>(i);
  std::shuffle(place.begin(), place.end(), random);
  std::vector<bool> reversed(place.size());
  for (std::size_t i = 0; i < place.size(); ++i) reversed[i] = random() % 2 == 0;
  const auto move = [&](model::Corner& corner) { corner.tile = place[corner.tile]; };
  for (std::size_t i = 0; i < place.size(); ++i) {
    mixed.tiles[place[i]] = model.tiles[i];
    if (model.target) (*mixed.target)[place[i]] = (*model.target)[i];
  }
  for (model::Joint& joint : mixed.joints) {
    move(joint.a);
    move(joint.b);
  }
  mixed.fileOrder.isReversed = reversed;
  return model::inFileOrder(mixed);
}

TEST(FileOrder, ConversionsKeepTheOrderOfTilesAndVertices) {
  std::mt19937 random(7);
  generate::TessellationShape shape;
  shape.startAngle = 0.3;
  for (int seed = 0; seed < 20; ++seed) {
    const model::Model mixed = mixedUp(generate::makeTessellation(shape), random);
    const TemporaryFolder folder;
    formats::writeModelFolder(mixed, folder.path() / "first");
    for (const char* name : {"second", "sheet.fold", "sheet_contracted.obj"}) {
      std::vector<std::string> warnings;
      const model::Model read = formats::readModel(folder.path() / "first", std::nullopt, warnings);
      for (const model::Tile& tile : read.tiles) EXPECT_GT(model::tileNormal(tile).z(), 0);
      formats::writeModel(read, folder.path() / name);
      const model::Model again =
          model::inFileOrder(formats::readModel(folder.path() / name, std::nullopt, warnings));
      ASSERT_EQ(again.tiles.size(), mixed.tiles.size());
      for (std::size_t i = 0; i < mixed.tiles.size(); ++i) {
        EXPECT_EQ(again.tiles[i].vertices, mixed.tiles[i].vertices) << name << " tile " << i;
        EXPECT_EQ((*again.target)[i].vertices, (*mixed.target)[i].vertices) << name;
      }
      for (std::size_t i = 0; i < mixed.joints.size(); ++i) {
        EXPECT_EQ(again.joints[i].a, mixed.joints[i].a) << name;
        EXPECT_EQ(again.joints[i].b, mixed.joints[i].b) << name;
      }
    }
  }
}

TEST(FileOrder, PlanarFilesGoRound) {
  std::mt19937 random(3);
  model::Model mixed = mixedUp(openSheet(), random);
  mixed.hull = std::vector<model::Corner>{{0, 1}, {5, 2}, {12, 3}};
  const TemporaryFolder folder;
  formats::writeModel(mixed, folder.path() / "sheet_vertices.txt");
  std::vector<std::string> warnings;
  const model::Model read =
      formats::readModel(folder.path() / "sheet_hull.txt", std::nullopt, warnings);
  // The corners of the hull do not depend on the sense of their tiles.
  for (std::size_t k = 0; k < 3; ++k) {
    const model::Corner& was = (*mixed.hull)[k];
    const model::Corner& is = (*read.hull)[k];
    EXPECT_EQ(read.tiles[is.tile].vertices[is.vertex], mixed.tiles[was.tile].vertices[was.vertex]);
  }
  formats::writeModel(read, folder.path() / "again_vertices.txt");
  for (const char* part : {"vertices", "constraints", "hull"}) {
    EXPECT_EQ(test::bytesOf(folder.path() / fmt::format("again_{}.txt", part)),
              test::bytesOf(folder.path() / fmt::format("sheet_{}.txt", part)))
        << part;
  }
}

TEST(FileOrder, TargetsAreInTheModelsOwnOrder) {
  std::mt19937 random(5);
  const model::Model mixed = mixedUp(generate::makeTessellation({}), random);
  const TemporaryFolder folder;
  formats::writeModelFolder(mixed, folder.path() / "model");
  std::vector<std::string> warnings;
  const model::Model read = formats::readModel(folder.path() / "model", std::nullopt, warnings);
  formats::writeTiles(*mixed.target, folder.path() / "final_vertices.txt");
  const std::vector<model::Tile> byFile =
      formats::readTarget(folder.path() / "final_vertices.txt", read, warnings);
  const std::vector<model::Tile> byModel =
      formats::readTarget(folder.path() / "model", read, warnings);
  for (std::size_t i = 0; i < read.tiles.size(); ++i) {
    EXPECT_EQ(byFile[i].vertices, (*read.target)[i].vertices);
    EXPECT_EQ(byModel[i].vertices, read.tiles[i].vertices);
  }
}

TEST(FileOrder, MessagesCountAsTheFileDoes) {
  EXPECT_EQ(readFiles({{"a_vertices.txt", "0 0 1 0 1 1\n0 0 1 0 1 1 0 0\n"},
                       {"a_constraints.txt", "# none\n"}},
                      "a_vertices.txt")
                .error,
            "@/a_vertices.txt:2:13: error: vertex 4 of tile 2 is at the position of its vertex 1. "
            "Correct it or delete it");
  EXPECT_EQ(
      readFiles(
          {{"a_vertices.txt", "0 0 1 0 1 1\n1 1 2 1 2 2\n"}, {"a_constraints.txt", "1 3 3 1\n"}},
          "a_vertices.txt")
          .error,
      "@/a_constraints.txt:1:5: error: a_vertices.txt has tiles 1-2, not 3. Correct this column");
}

}  // namespace
}  // namespace kirireel
