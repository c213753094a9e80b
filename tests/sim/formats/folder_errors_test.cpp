// The whole text of every message about a model folder ("@" is the folder).
#include <map>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/read_model.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
using Files = std::map<std::string, std::string>;

// Two unit squares side by side, joined at (1, 0).
const std::string kSquares =
    "0 0 0 1 0 0 1 1 0 0 1 0\n"
    "1 0 0 2 0 0 2 1 0 1 1 0\n";
const std::string kJoint = "0 1 1 0 3\n";

std::string withoutFolder(std::string text, const std::string& folder) {
  for (size_t at = text.find(folder); at != text.npos; at = text.find(folder)) {
    text.replace(at, folder.size(), "@");
  }
  return text;
}

/// The error, or the warnings, or "" for a folder without faults.
std::string messageFor(Files files) {
  const TemporaryFolder folder;
  files.try_emplace("vertices.txt", kSquares);
  files.try_emplace("constraints.txt", kJoint);
  for (const auto& [name, text] : files) {
    if (text != "absent") folder.write(name, text);
  }
  std::vector<std::string> warnings;
  std::string message;
  try {
    formats::readModelFolder(folder.path(), warnings);
    for (const std::string& warning : warnings) message += warning;
  } catch (const InputError& error) {
    message = error.what();
  }
  return withoutFolder(message, folder.path().string());
}

std::string forVertices(const std::string& text) {
  return messageFor({{"vertices.txt", text}});
}
std::string forJoints(const std::string& text) {
  return messageFor({{"constraints.txt", text}});
}
std::string forTarget(const std::string& text) {
  return messageFor({{"target.txt", text}});
}

TEST(FolderErrors, GoodFolderHasNone) {
  EXPECT_EQ(messageFor({}), "");
}

// The same two squares and joint in the notations of several programs and people.
TEST(FolderErrors, NumbersAreWrittenInManyWays) {
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    for (size_t at = text.find(from); at != text.npos; at = text.find(from, at + to.size())) {
      text.replace(at, from.size(), to);
    }
    return text;
  };
  for (const char* between : {",", ", ", "\t", ";", " ; ", " ,"}) {
    EXPECT_EQ(messageFor({{"vertices.txt", replaced(kSquares, " ", between)},
                          {"constraints.txt", replaced(kJoint, " ", between)}}),
              "")
        << between;
  }
  for (const char* comment : {" # a tile\n", " % a tile\n", " // a tile\n", "\r\n", "\r"}) {
    EXPECT_EQ(messageFor({{"vertices.txt", replaced(kSquares, "\n", comment)}}), "") << comment;
  }
  EXPECT_EQ(messageFor({{"vertices.txt", "\xEF\xBB\xBF" + kSquares}}), "");
  EXPECT_EQ(messageFor({{"vertices.txt", replaced(kSquares, "1 ", "1.0E+00 ")}}), "");
  EXPECT_EQ(messageFor({{"vertices.txt", replaced(kSquares, "0 ", "1e-400 ")}}), "");
  EXPECT_EQ(messageFor({{"constraints.txt", "0.0000000e+00 1.0 1 0.0 3e0\n"}}), "");
}

/// A text of a Windows program, with the bytes of each character in this order.
std::string asUtf16(const std::string& text, bool isLittle) {
  std::string wide = isLittle ? "\xFF\xFE" : "\xFE\xFF";
  for (const char letter : text) {
    wide += isLittle ? std::string{letter, '\0'} : std::string{'\0', letter};
  }
  return wide;
}

TEST(FolderErrors, TextOfWindowsHasNone) {
  for (const bool isLittle : {true, false}) {
    EXPECT_EQ(messageFor({{"vertices.txt", asUtf16(kSquares, isLittle)}}), "") << isLittle;
  }
}

TEST(FolderErrors, NumbersThatAreAmbiguousAreNot) {
  EXPECT_EQ(messageFor({{"vertices.txt", "0,5 0 0 1,5 0 0 1 1 0\n"}}),
            "@/vertices.txt:1:1: error: '0,5' is not a number; write coordinates, with a "
            "decimal point, separated by blanks");
}

TEST(FolderErrors, MissingFolder) {
  std::vector<std::string> warnings;
  try {
    formats::readModelFolder("/nowhere/model", warnings);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "/nowhere/model: error: there is no such folder; give a folder with vertices.txt "
                 "and constraints.txt");
  }
}

TEST(FolderErrors, FileInsteadOfFolder) {
  const TemporaryFolder folder;
  folder.write("model", "0 0 0\n");
  std::vector<std::string> warnings;
  try {
    formats::readModelFolder(folder.path() / "model", warnings);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(withoutFolder(error.what(), folder.path().string()),
              "@/model: error: this is not a folder; give a folder with vertices.txt and "
              "constraints.txt");
  }
}

TEST(FolderErrors, MissingFile) {
  EXPECT_EQ(forVertices("absent"),
            "@/vertices.txt: error: there is no such file; write one tile per line, \"x y z\" for "
            "each vertex");
  EXPECT_EQ(forJoints("absent"),
            "@/constraints.txt: error: there is no such file; write one joint per line, \"tileA "
            "vertexA tileB vertexB face\", or the line \"# no joints\" if the tiles are loose");
}

TEST(FolderErrors, FolderInsteadOfFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "vertices.txt");
  std::vector<std::string> warnings;
  try {
    formats::readModelFolder(folder.path(), warnings);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(withoutFolder(error.what(), folder.path().string()),
              "@/vertices.txt: error: this is not a text file; write one tile per line, \"x y z\" "
              "for each vertex");
  }
}

TEST(FolderErrors, EmptyFile) {
  EXPECT_EQ(forVertices("\n# nothing\n"),
            "@/vertices.txt: error: the file has no tile; write one tile per line, \"x y z\" for "
            "each vertex");
  EXPECT_EQ(forJoints("\n \n"),
            "@/constraints.txt: repaired: the file is empty; the tiles are read as loose");
  EXPECT_EQ(forTarget(""),
            "@/target.txt: error: the file has no tile; write one tile per line, \"x y z\" for "
            "each vertex");
  EXPECT_EQ(messageFor({{"pull.txt", ""}}),
            "@/pull.txt: error: the file has no tile numbers; list the numbers of the tiles to "
            "pull, or delete the file to pull all");
}

TEST(FolderErrors, FileTooLarge) {
  const TemporaryFolder folder;
  folder.write("vertices.txt", "");
  std::filesystem::resize_file(folder.path() / "vertices.txt", 67108865);  // sparse
  std::vector<std::string> warnings;
  try {
    formats::readModelFolder(folder.path(), warnings);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(withoutFolder(error.what(), folder.path().string()),
              "@/vertices.txt: error: the file has 67108865 bytes, but at most 67108864 are "
              "allowed; write one tile per line, \"x y z\" for each vertex");
  }
}

TEST(FolderErrors, LineTooLong) {
  std::string line;
  for (int k = 0; k < 901; ++k) line += "0 ";
  EXPECT_EQ(forVertices(line),
            "@/vertices.txt:1:1801: error: this line has more than 900 numbers, but a tile has at "
            "most 300 vertices. Break the line if it has several rows, or split the tile");
}

TEST(FolderErrors, UnfinishedVertex) {
  EXPECT_EQ(forVertices("\n0 0 0 1 0 0 1 1 0 0 1\n"),
            "@/vertices.txt:2:19: error: tile 0 has 11 numbers, not three for each vertex; the "
            "vertex that starts here has only 2: complete it or delete it");
}

TEST(FolderErrors, TwoVertices) {
  EXPECT_EQ(forVertices("0 0 0 1 0 0\n"),
            "@/vertices.txt:1: error: tile 0 has 2 vertices; a tile has at least 3: add the "
            "missing ones or delete the line");
}

TEST(FolderErrors, Letters) {
  EXPECT_EQ(forVertices("0 0 0 1 0 0 1 one 0\n"),
            "@/vertices.txt:1:15: error: 'one' is not a number; write coordinates, "
            "separated by blanks");
  EXPECT_EQ(forVertices("0,0,0,1,0,0,1,1,0 0 0 0 0 0 0 0 0\n"),
            "@/vertices.txt:1:1: error: '0,0,0,1,0,0,1,1,0' is not a number; write coordinates, "
            "separated by blanks");
  // Bytes that control a terminal are replaced, and long words are cut.
  EXPECT_EQ(forVertices("\x1b[31m-and-some-more-than-fits 0 0 1 0 0 1 1 0\n"),
            "@/vertices.txt:1:1: error: '?[31m-and-some-more-than...' is not a number; write "
            "coordinates, separated by blanks");
}

TEST(FolderErrors, NotFiniteOrHuge) {
  for (const std::string text : {"nan", "inf", "-inf", "1e16", "1e999", "-1000000000000001"}) {
    EXPECT_EQ(forVertices("0 0 0 1 0 0 1 1 " + text + "\n"),
              "@/vertices.txt:1:17: error: '" + text +
                  "' is not a coordinate in [-1e+15, 1e+15]. Correct it or scale the model");
  }
}

TEST(FolderErrors, RepeatedVertex) {
  EXPECT_EQ(forVertices("0 0 0 1 0 0 1 1 0 1 0 0\n"),
            "@/vertices.txt:1:19: error: vertex 3 of tile 0 is at the position of its vertex 1. "
            "Correct it or delete it");
}

TEST(FolderErrors, TileWithoutArea) {
  EXPECT_EQ(forVertices("0 0 0 1 0 0 2 0 0\n"),
            "@/vertices.txt:1: error: tile 0 has no area. List its vertices in order around the "
            "tile, not all on one line");
}

TEST(FolderErrors, TileNotFlat) {
  EXPECT_EQ(forVertices("0 0 0 1 0 0.2 1 1 0 0 1 0.2\n"),
            "@/vertices.txt:1:1: error: vertex 0 of tile 0 is 0.1 off the tile's plane, at most "
            "0.0141 is allowed; flatten the tile or split it into triangles");
}

TEST(FolderErrors, ConcaveTilesAreFine) {
  EXPECT_EQ(messageFor({{"vertices.txt", "0 0 0 2 0 0 0.5 0.5 0 0 2 0\n"},
                        {"constraints.txt", "# no joints\n"}}),
            "");
}

TEST(FolderErrors, TileThatCrossesItself) {
  EXPECT_EQ(forVertices("0 0 0 3 0 0 3 2 0 1 -1 0 0 2 0\n"),
            "@/vertices.txt:1:13: error: tile 0 crosses or touches itself: its side from vertex 2 "
            "to 3 meets the side from vertex 0 to 1. List its vertices in order around the tile, "
            "and list separate pieces as separate tiles");
  // A corner on a far side: two pieces.
  EXPECT_EQ(forVertices("0 0 0 4 0 0 4 2 0 2 0 0 0 2 0\n"),
            "@/vertices.txt:1:13: error: tile 0 crosses or touches itself: its side from vertex 2 "
            "to 3 meets the side from vertex 0 to 1. List its vertices in order around the tile, "
            "and list separate pieces as separate tiles");
}

TEST(FolderErrors, TileRoundTwice) {
  // A pentagram: every corner turns left, two rounds in all.
  EXPECT_EQ(forVertices("0 1 0 -0.588 -0.809 0 0.951 0.309 0 -0.951 0.309 0 0.588 -0.809 0\n"),
            "@/vertices.txt:1:23: error: tile 0 crosses or touches itself: its side from vertex 2 "
            "to 3 meets the side from vertex 0 to 1. List its vertices in order around the tile, "
            "and list separate pieces as separate tiles");
}

TEST(FolderErrors, JointColumns) {
  EXPECT_EQ(forJoints("0 1 1\n"),
            "@/constraints.txt:1: error: a joint does not have 3 numbers. Write \"tileA vertexA "
            "tileB vertexB\", and optionally a face (1 bottom, 2 top, 3 both)");
  EXPECT_EQ(forJoints("# a comment\n0 1 1 0 3 0\n"),
            "@/constraints.txt:2: error: a joint does not have 6 numbers. Write \"tileA vertexA "
            "tileB vertexB\", and optionally a face (1 bottom, 2 top, 3 both)");
}

TEST(FolderErrors, JointNotWholeNumbers) {
  EXPECT_EQ(forJoints("0 1.5 1 0\n"),
            "@/constraints.txt:1:3: error: '1.5' is not a vertex number; write a whole number, at "
            "most 2147483647");
  EXPECT_EQ(forJoints("0 1 99999999999 0\n"),
            "@/constraints.txt:1:5: error: '99999999999' is not a tile number; write a whole "
            "number, at most 2147483647");
  EXPECT_EQ(forJoints("0 1 1 0 both\n"),
            "@/constraints.txt:1:9: error: 'both' is not a face; write a whole number, at most "
            "2147483647");
}

TEST(FolderErrors, JointTileOutOfRange) {
  EXPECT_EQ(forJoints(kJoint + "0 2 2 3\n"),
            "@/constraints.txt:2:5: error: vertices.txt has tiles 0-1, not 2. Correct this column");
  EXPECT_EQ(
      forJoints("-1 2 1 3\n"),
      "@/constraints.txt:1:1: error: vertices.txt has tiles 0-1, not -1. Correct this column");
}

TEST(FolderErrors, JointVertexOutOfRange) {
  EXPECT_EQ(forJoints("0 1 1 7\n"),
            "@/constraints.txt:1:7: error: tile 1 has vertices 0-3, not 7; correct this column or "
            "add the vertex at vertices.txt:2");
  EXPECT_EQ(forJoints("0 -1 1 0\n"),
            "@/constraints.txt:1:3: error: tile 0 has vertices 0-3, not -1; correct this column");
}

TEST(FolderErrors, JointsThatCountFromOne) {
  EXPECT_EQ(
      forJoints("1 2 2 1\n"),
      "@/constraints.txt: repaired: tiles and vertices count from 1, not from 0; they are read "
      "as counted from 1");
  // Neither base makes all numbers valid.
  EXPECT_EQ(forJoints("1 2 2 1\n0 1 1 0\n"),
            "@/constraints.txt:1:5: error: vertices.txt has tiles 0-1, not 2. Correct this column");
}

TEST(FolderErrors, JointFace) {
  EXPECT_EQ(forJoints("0 1 1 0 4\n"),
            "@/constraints.txt:1:9: error: there is no face 4; write 1 (bottom), 2 (top) or 3 "
            "(both)");
}

TEST(FolderErrors, JointToItself) {
  EXPECT_EQ(forJoints("0 1 0 2\n"),
            "@/constraints.txt:1:5: error: tile 0 is joined to itself; correct this column or "
            "delete this line");
}

TEST(FolderErrors, RepeatedJoint) {
  EXPECT_EQ(forJoints("0 1 1 0\n0 1 1 0 2\n\n1 0 0 1 3\n"),
            "@/constraints.txt:4: repaired: 1 joint is listed again, first in line 1; repeated "
            "joints are removed, regardless of the order of their ends");
  EXPECT_EQ(forJoints("0 1 1 0 3\n0 1 1 0 2\n"),
            "@/constraints.txt:2: repaired: 1 joint is listed again, first in line 1; repeated "
            "joints are removed, regardless of the order of their ends");
  EXPECT_EQ(forJoints("0 1 1 0 1\n0 1 1 0 2\n"), "");
}

TEST(FolderErrors, JointsApart) {
  EXPECT_EQ(forJoints("0 0 1 0\n"),
            "@/constraints.txt:1: error: vertex 0 of tile 0 and vertex 0 of tile 1 are 1 apart "
            "at the start, at most 0.05 is allowed; correct this joint or the vertices at "
            "vertices.txt:1 and vertices.txt:2");
  EXPECT_EQ(
      forVertices("0 0 0 1 0 0 1 1 0 0 1 0\n1.002 0 0 2 0 0 2 1 0 1 1 0\n"),
      "@/constraints.txt:1: warning: 1 joint is open at the start, at most by 0.002 here. The run "
      "closes joints");
}

TEST(FolderErrors, TargetOfOtherTiles) {
  EXPECT_EQ(forTarget("0 0 0 1 0 0 1 1 0 0 1 0\n"),
            "@/target.txt: error: the target has 1 tile, vertices.txt has 2; write one target "
            "tile for each tile, in the same order");
  EXPECT_EQ(forTarget(kSquares + "0 0 0 1 0 0 1 1 0\n"),
            "@/target.txt: error: the target has 3 tiles, vertices.txt has 2; write one target "
            "tile for each tile, in the same order");
  EXPECT_EQ(forTarget("0 0 0 1 0 0 1 1 0 0 1 0\n0 0 0 1 0 0 1 1 0\n"),
            "@/target.txt:2: error: target tile 1 has 3 vertices, the tile at vertices.txt:2 has "
            "4; write the same tiles with the same vertices in the same order");
}

TEST(FolderErrors, TargetOfOtherShape) {
  EXPECT_EQ(forTarget("0 0 0 1 0 0 1 1 0 0 1 0\n1 0 0 2.5 0 0 2 1 0 1 1 0\n"),
            "@/target.txt:2:7: error: vertices 0 and 1 of target tile 1 are 1.5 apart, but at "
            "vertices.txt:2 1. The target must have the same rigid tiles. Correct it, or use this "
            "model's target");
  EXPECT_EQ(forTarget("0 0 0 1 0 0 1 1 0 0 1 0\n1 0 0 2.001 0 0 2 1 0 1 1 0\n"),
            "@/target.txt:2: warning: 1 target tile has a slightly different shape. Here a length "
            "differs most, by 0.001. Rigid tiles can only come near this target");
}

// A target of a planar model, whose tiles count from 1.
TEST(FolderErrors, TargetTilesAreNumberedAsTheModelsAre) {
  const auto refusal = [](const std::string& text) {
    const TemporaryFolder folder;
    const model::Model square = {.name = "sheet",
                                 .tiles = {{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}},
                                 .fileOrder = {.countsFrom = 1}};
    folder.write("target.txt", text);
    std::vector<std::string> warnings;
    try {
      formats::readTargetFile(folder.path() / "target.txt", square, warnings);
    } catch (const InputError& error) {
      return withoutFolder(error.what(), folder.path().string());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal("0 0 0 1 0 0 1 1 0\n"),
            "@/target.txt:1: error: target tile 1 has 3 vertices, the tile at sheet:1 has 4; write "
            "the same tiles with the same vertices in the same order");
  EXPECT_EQ(
      refusal("0 0 0 2.5 0 0 1 1 0 0 1 0\n"),
      "@/target.txt:1:7: error: vertices 1 and 2 of target tile 1 are 2.5 apart, but at sheet:1 "
      "1. The target must have the same rigid tiles. Correct it, or use this model's target");
}

TEST(FolderErrors, PulledTileOutOfRange) {
  EXPECT_EQ(messageFor({{"pull.txt", "0 1\n2\n"}}),
            "@/pull.txt:2:1: error: vertices.txt has tiles 0-1, not 2; correct this number");
  EXPECT_EQ(messageFor({{"pull.txt", "0.5\n"}}),
            "@/pull.txt:1:1: error: '0.5' is not a tile number; write a whole number, at most "
            "2147483647");
}

}  // namespace
}  // namespace kirireel
