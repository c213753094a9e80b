// Models in the forms in which others publish them, made with our generators, read and deployed by
// the real program.
#include <cmath>
#include <random>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/formats/read_model.h"
#include "sim/generate/families.h"
#include "sim/model/isometry.h"
#include "tests/cli/run_program.h"

namespace kirireel {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// Form of a planar file.
struct Writing {
  int decimals = 9;
  double scale = 1;
  bool isClockwise = false;
  std::string joints = "constraints";  ///< the end of the name of the list of joints
  std::string more = {};               ///< lines after the joints
};

class Files : public testing::Test {
 protected:
  /// The start of a family as sheet_vertices.txt and its list of joints.
  void write(const model::Model& model, const Writing& how) {
    std::string vertices, joints;
    for (const model::Tile& tile : model.tiles) {
      const int count = static_cast<int>(tile.vertices.size());
      for (int k = 0; k < count; ++k) {
        const Vector3& v = tile.vertices[how.isClockwise ? count - 1 - k : k];
        vertices += fmt::format("{:.{}f} {:.{}f} ", how.scale * v.x(), how.decimals,
                                how.scale * v.y(), how.decimals);
      }
      vertices += "\n";
    }
    const auto number = [&](const model::Corner& corner) {
      const int count = static_cast<int>(model.tiles[corner.tile].vertices.size());
      return 1 + (how.isClockwise ? count - 1 - corner.vertex : corner.vertex);
    };
    for (const model::Joint& joint : model.joints) {
      joints += fmt::format("{} {} {} {}\n", joint.a.tile + 1, number(joint.a), joint.b.tile + 1,
                            number(joint.b));
    }
    writeText(scratch_ / "sheet_vertices.txt", vertices);
    writeText(scratch_ / ("sheet_" + how.joints + ".txt"), joints + how.more);
  }

  /// Runs `simulate` on a file of the scratch folder.
  ProgramEnd simulate(const std::string& name, std::vector<std::string> options = {}) {
    options.insert(options.begin(),
                   {"simulate", (scratch_ / name).string(), "--out", (scratch_ / "out").string()});
    const ProgramEnd end = runKirireel(options);
    const std::string text = readText(scratch_ / "out/summary.json");
    summary_ = text.empty() ? nlohmann::json() : nlohmann::json::parse(text);
    return end;
  }

  static std::vector<std::string> linesOf(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) lines.push_back(line);
    return lines;
  }

  double jointGap() const { return summary_["accuracy"]["joint_gap_max"].get<double>(); }

  TemporaryFolder scratch_;
  nlohmann::json summary_;
};

model::Model family(const std::string& name, const std::map<std::string, double>& given = {}) {
  return generate::generateModel(generate::familyNamed(name), given);
}

model::Model openSquares() {
  return family("tessellation", {{"columns", 3}, {"rows", 3}, {"start-angle", 40}});
}

TEST_F(Files, ConcaveTilesDeploy) {
  for (const char* name : {"stars", "crosses", "islamic", "trefoils"}) {
    formats::writeModelFolder(family(name), scratch_ / name);
    EXPECT_EQ(simulate(name).exitCode, 0) << name;
    EXPECT_TRUE(summary_["at_target"].get<bool>()) << name;
  }
}

TEST_F(Files, ListsOfJointsHaveManyNames) {
  write(family("penrose-chain"), {.joints = "hamiltonian_constraints"});
  EXPECT_EQ(simulate("sheet_vertices.txt").exitCode, 0);
  EXPECT_EQ(simulate("sheet_hamiltonian_constraints.txt").exitCode, 0);
  writeText(scratch_ / "sheet_expansion_constraints.txt", "1 1 2 1\n");
  const ProgramEnd several = simulate("sheet_vertices.txt");
  EXPECT_EQ(several.exitCode, 2);
  EXPECT_THAT(several.err, HasSubstr("Select one with --joints-file"));
  EXPECT_EQ(simulate("sheet_vertices.txt", {"--joints-file", "sheet_hamiltonian_constraints.txt"})
                .exitCode,
            0);
}

TEST_F(Files, HullsFeedTheBoundary) {
  // The four outer corners of the sheet, in the numbers of its clockwise file.
  const model::Model model = openSquares();
  write(model, {.isClockwise = true, .joints = "expansion_constraints"});
  EXPECT_EQ(simulate("sheet_vertices.txt", {"--actuation", "boundary", "--duration", "1"}).exitCode,
            0);
  const std::string byOutline = readText(scratch_ / "out/final_vertices.txt");
  writeText(scratch_ / "sheet_expansion_hull.txt", "0 3\n6 2\n8 1\n2 0\n");
  EXPECT_EQ(simulate("sheet_vertices.txt", {"--actuation", "boundary", "--duration", "1"}).exitCode,
            0);
  EXPECT_NE(readText(scratch_ / "out/final_vertices.txt"), byOutline);
}

TEST_F(Files, WrongHullsAreRefusedIfTheyAreNeeded) {
  write(openSquares(), {});
  writeText(scratch_ / "sheet_hull.txt", "0 0\n99 1\n2 2\n");
  const ProgramEnd unused = simulate("sheet_vertices.txt");
  EXPECT_EQ(unused.exitCode, 0);
  EXPECT_THAT(unused.err, HasSubstr("This hull is ignored"));
  const ProgramEnd needed = simulate("sheet_vertices.txt", {"--actuation", "boundary"});
  EXPECT_EQ(needed.exitCode, 2);
  EXPECT_THAT(needed.err,
              HasSubstr("sheet_hull.txt: error: its 3 rows name missing corners, or too few; write "
                        "one corner of the sheet's outline per line, \"tile vertex\", from 0, at "
                        "least 3. Or remove the file to pull the convex outline"));
  EXPECT_EQ(simulate("sheet_vertices.txt", {"--strict"}).exitCode, 2);
}

TEST_F(Files, TilesAreNamedAsTheFileCountsThem) {
  write(openSquares(), {});
  const std::vector<std::string> brief = {"--duration", "0.1", "--pin"};
  const auto pinned = [&](const std::string& tiles) {
    std::vector<std::string> options = brief;
    options.push_back(tiles);
    return simulate("sheet_vertices.txt", options);
  };
  EXPECT_THAT(pinned("0").err, HasSubstr("the model has tiles 1-9, not 0"));
  EXPECT_THAT(pinned("10").err, HasSubstr("the model has tiles 1-9, not 10"));
  EXPECT_EQ(pinned("9").exitCode, 0);
  EXPECT_EQ(summary_["events"][0]["what"].get<std::string>(), "pin tiles 9");
  const std::vector<std::string> start = linesOf(readText(scratch_ / "sheet_vertices.txt"));
  const std::vector<std::string> end = linesOf(readText(scratch_ / "out/final_vertices.txt"));
  EXPECT_NEAR(std::stod(start[8]), std::stod(end[8]), 1e-9);
  EXPECT_GT(std::abs(std::stod(start[0]) - std::stod(end[0])), 1e-6);
  EXPECT_THAT(simulate("sheet_vertices.txt", {"--split-tiles", "0"}).err,
              HasSubstr("there are tiles 1-9 to split, not 0"));
  EXPECT_THAT(simulate("sheet_vertices.txt", {"--link", "1,1,2,5"}).err,
              HasSubstr("tile 2 has vertices 1-4, not 5"));
}

// Four quads without a path of closed joints to their target: joints open by at least 1.7e-2 m.
TEST_F(Files, DesignsWithoutFreedomArriveAndReportOpenings) {
  formats::writeModelFolder(family("nonrigid"), scratch_ / "nonrigid");
  const ProgramEnd end = simulate("nonrigid");
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_THAT(end.out, HasSubstr("\njoints open by up to "));
  EXPECT_THAT(end.out, HasSubstr("tiles)"));
}

// With springs, long chains and thin sheets oscillated about full extension.
TEST_F(Files, LongChainsRestAtFullExtension) {
  write(family("stampfli-chain"), {});
  EXPECT_EQ(simulate("sheet_vertices.txt").exitCode, 0);
  EXPECT_EQ(summary_["outcome"], "settled");
  write(family("tessellation", {{"columns", 2}, {"rows", 60}, {"start-angle", 10}}), {});
  EXPECT_EQ(simulate("sheet_vertices.txt").exitCode, 0);
  EXPECT_EQ(summary_["outcome"], "settled");
}

// Flush quads that bend into a cap, with four decimals as published: exact joints jam.
TEST_F(Files, JammedQuadsInSpaceArrive) {
  model::Model cap = family("cap", {{"half-size", 3}});
  for (std::vector<model::Tile>* tiles : {&cap.tiles, &*cap.target}) {
    for (model::Tile& tile : *tiles) {
      for (Vector3& v : tile.vertices) {
        for (double& x : v) x = std::stod(fmt::format("{:.4f}", x));
      }
    }
  }
  formats::writeModelFolder(cap, scratch_ / "cap");
  EXPECT_EQ(simulate("cap").exitCode, 0);
  EXPECT_TRUE(summary_["at_target"].get<bool>());
  // Openings below 0.02 tile count as equal. Of such paths the smoothest is selected. Measured:
  // 2.6e-3 m (a tile is 1 m) and 1e-5 m.
  EXPECT_LE(jointGap(), 0.02);
  EXPECT_LE(summary_["accuracy"]["penetration_grown_max"].get<double>(), 1e-4);
}

TEST_F(Files, RepeatedJointsCountOnceAndStrictRefuses) {
  const model::Model model = openSquares();
  const model::Joint& joint = model.joints[0];
  write(model, {.more = fmt::format("{} {} {} {}\n", joint.b.tile + 1, joint.b.vertex + 1,
                                    joint.a.tile + 1, joint.a.vertex + 1)});
  const ProgramEnd end = simulate("sheet_vertices.txt");
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_THAT(end.err, HasSubstr("repaired: 1 joint is listed again"));
  EXPECT_EQ(simulate("sheet_vertices.txt", {"--strict"}).exitCode, 2);
}

TEST_F(Files, OneDigitApartStaysAJoint) {
  // Three decimals on a sheet 200 wide. A corner of the middle tile is off by one in the last.
  model::Model model = openSquares();
  for (model::Tile& tile : model.tiles) {
    for (Vector3& v : tile.vertices) v = (v * 60 * 1000).array().round().matrix() / 60000;
  }
  model.tiles[4].vertices[0].x() += 0.001 / 60;
  write(model, {.decimals = 3, .scale = 60});
  const ProgramEnd end = simulate("sheet_vertices.txt");
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_THAT(end.err, HasSubstr("by rounding to 0.001;"));
  EXPECT_THAT(end.err, Not(HasSubstr("a rod")));
  EXPECT_LE(jointGap(), 2.1e-3);
}

TEST_F(Files, ClockwiseTilesComeBackInTheirOwnOrder) {
  write(openSquares(), {.isClockwise = true});
  const ProgramEnd end = simulate("sheet_vertices.txt");
  EXPECT_EQ(end.exitCode, 0);
  EXPECT_THAT(end.err, HasSubstr("repaired: 9 of 9 tiles run clockwise seen from above"));
  std::istringstream starts(readText(scratch_ / "sheet_vertices.txt"));
  for (const model::Tile& tile : formats::readTileFile(scratch_ / "out/final_vertices.txt")) {
    EXPECT_LT(model::tileNormal(tile).z(), 0);
    std::vector<Vector3> corners;
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) {
      Vector3& corner = corners.emplace_back(Vector3::Zero());
      starts >> corner.x() >> corner.y();
    }
    for (std::size_t a = 0; a < corners.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        EXPECT_NEAR((tile.vertices[a] - tile.vertices[b]).norm(), (corners[a] - corners[b]).norm(),
                    1e-8);
      }
    }
  }
}

TEST_F(Files, MixedAndShuffledFilesMapBackByIndex) {
  std::mt19937 random(11);
  for (int round = 0; round < 6; ++round) {
    // A folder of tiles in another order, some of them clockwise, with their target.
    model::Model model = family(round % 2 == 0 ? "stars" : "quads");
    std::vector<int> place(model.tiles.size());
    for (std::size_t i = 0; i < place.size(); ++i) place[i] = static_cast<int>(i);
    std::shuffle(place.begin(), place.end(), random);
    model::Model mixed = model;
    for (std::size_t i = 0; i < place.size(); ++i) {
      mixed.tiles[place[i]] = model.tiles[i];
      (*mixed.target)[place[i]] = (*model.target)[i];
    }
    for (model::Joint& joint : mixed.joints) {
      joint.a.tile = place[joint.a.tile];
      joint.b.tile = place[joint.b.tile];
    }
    for (std::size_t i = 0; i < place.size(); ++i) {
      mixed.fileOrder.isReversed.push_back(random() % 2 == 0);
    }
    mixed = model::inFileOrder(mixed);
    const std::string name = fmt::format("mixed{}", round);
    formats::writeModelFolder(mixed, scratch_ / name);
    EXPECT_EQ(simulate(name).exitCode, 0);
    const std::vector<model::Tile> end = formats::readTileFile(scratch_ / "out/final_vertices.txt");
    ASSERT_EQ(end.size(), mixed.tiles.size());
    model::alignToStart(mixed, *mixed.target);
    for (std::size_t i = 0; i < end.size(); ++i) {
      ASSERT_EQ(end[i].vertices.size(), mixed.tiles[i].vertices.size());
      for (std::size_t k = 0; k < end[i].vertices.size(); ++k) {
        EXPECT_LE((end[i].vertices[k] - (*mixed.target)[i].vertices[k]).norm(), 1e-6) << i;
      }
    }
  }
}

TEST_F(Files, EmptyListsOfJointsAreLooseTiles) {
  write(openSquares(), {});
  writeText(scratch_ / "sheet_constraints.txt", "");
  const ProgramEnd end = simulate("sheet_vertices.txt", {"--actuation", "none"});
  EXPECT_THAT(end.err, HasSubstr("repaired: the file is empty; the tiles are read as loose"));
  EXPECT_NE(end.exitCode, 2);
}

TEST_F(Files, PairsInAFolderArePlanar) {
  write(family("triangles", {{"start-angle", 200}}), {});
  std::filesystem::create_directory(scratch_ / "pairs");
  std::filesystem::rename(scratch_ / "sheet_vertices.txt", scratch_ / "pairs/vertices.txt");
  std::filesystem::rename(scratch_ / "sheet_constraints.txt", scratch_ / "pairs/constraints.txt");
  const ProgramEnd end = simulate("pairs");
  EXPECT_EQ(end.exitCode, 0) << end.err;
  EXPECT_EQ(summary_["model"]["joints"], 40);
}

TEST_F(Files, PixelsAreAsGoodAsMetres) {
  write(openSquares(), {.decimals = 6, .scale = 80});
  EXPECT_EQ(simulate("sheet_vertices.txt").exitCode, 0);
  EXPECT_LE(jointGap(), 1e-6 * 80);
}

TEST_F(Files, PatternsDeployAgain) {
  formats::writeModelFolder(family("stars"), scratch_ / "stars");
  ASSERT_EQ(simulate("stars", {"--export", "svg,dxf"}).exitCode, 0);
  for (const char* pattern : {"cut_pattern.svg", "cut_pattern.dxf"}) {
    std::filesystem::copy_file(scratch_ / "out" / pattern, scratch_ / pattern);
  }
  for (const char* pattern : {"cut_pattern.svg", "cut_pattern.dxf"}) {
    EXPECT_EQ(simulate(pattern).exitCode, 0) << pattern;
    EXPECT_EQ(summary_["outcome"], "settled") << pattern;
  }
}

TEST_F(Files, CrossedTilesAreDrawn) {
  writeText(scratch_ / "x_vertices.txt", "0 0 3 0 3 2 1 -1 0 2\n");
  writeText(scratch_ / "x_constraints.txt", "# none\n");
  const ProgramEnd end = runKirireel({"inspect", (scratch_ / "x_vertices.txt").string(),
                                      "--picture", (scratch_ / "x.png").string()});
  EXPECT_EQ(end.exitCode, 2);
  EXPECT_THAT(end.err, HasSubstr("x_vertices.txt:1:9: error: tile 1 crosses or touches itself"));
  EXPECT_THAT(readText(scratch_ / "x.png").substr(1, 3), "PNG");
}

}  // namespace
}  // namespace kirireel
