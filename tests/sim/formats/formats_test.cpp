// Models in formats other than folders: round trips, published files, and every message.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <tuple>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "tests/support/files.h"
#include "tests/support/same_model.h"

namespace kirireel {
namespace {

using test::expectSameModel;
using test::expectSameTiles;
using test::read;
using test::TemporaryFolder;
namespace fs = std::filesystem;

const fs::path kPairs = fs::path(KIRIREEL_SOURCE_DIR) / "../shared/models/obj-pairs";

/// A model with all properties that formats can lose: odd digits, all faces, its own order.
model::Model awkwardModel() {
  generate::TessellationShape shape;
  shape.length = 1.0 / 3;
  shape.startAngle = 0.1;
  model::Model model = generate::makeTessellation(shape);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    model.joints[k].face = static_cast<model::JointFace>(1 + k % 3);
  }
  std::reverse(model.joints.begin(), model.joints.end());
  std::swap(model.joints[2].a, model.joints[2].b);
  model.tiles[5].vertices[2].x() += 1e-9;  // a joint that is not quite closed
  model.pulledTiles = std::vector<int>{7, 0};
  return model;
}

TEST(Formats, FoldKeepsEverything) {
  model::Model model = awkwardModel();
  model.joints.push_back(model::makeLink(model.tiles, {0, 0}, {15, 2}));
  model.joints.push_back(model::makeFixedJoint(model.tiles, 3, 4));
  const TemporaryFolder folder;
  formats::writeModel(model, folder.path() / "sheet.fold");
  const model::Model again = read(folder.path() / "sheet.fold");
  EXPECT_EQ(again.name, "sheet");
  expectSameModel(again, model);
}

TEST(Formats, ObjPairKeepsEverythingButLinks) {
  const model::Model model = awkwardModel();
  const TemporaryFolder folder;
  formats::writeModel(model, folder.path() / "sheet_contracted.obj");
  EXPECT_TRUE(fs::exists(folder.path() / "sheet_deployed.obj"));
  const model::Model again = read(folder.path() / "sheet_contracted.obj");
  EXPECT_EQ(again.name, "sheet");
  expectSameModel(again, model);
}

TEST(Formats, SharedNumbersAreJoints) {
  const TemporaryFolder folder;
  folder.write("a.obj",
               "# two\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 2 0 0\nf 1/9 2 3/1/1\nf 2// 4// 3//\n");
  const model::Model model = read(folder.path() / "a.obj");
  ASSERT_EQ(model.joints.size(), 2U);  // a shared edge is a hinge
  EXPECT_EQ(model.joints[0].a, (model::Corner{0, 1}));
  EXPECT_EQ(model.joints[0].b, (model::Corner{1, 0}));
  EXPECT_EQ(model.joints[1].a, (model::Corner{0, 2}));
  EXPECT_EQ(model.joints[1].b, (model::Corner{1, 2}));
}

TEST(Formats, CornersThatStayTogetherAreJoints) {
  // The tiles touch along an edge at the start, in one corner at the target.
  const TemporaryFolder folder;
  const std::string faces = "f 1 2 3 4\nf 5 6 7 8\n";
  folder.write("a_contracted.obj",
               "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\n" + faces);
  folder.write(
      "a_deployed.obj",
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 1 -1 0\nv 2 -1 0\nv 2 0 0\n" + faces);
  const model::Model model = read(folder.path() / "a_contracted.obj");
  ASSERT_EQ(model.joints.size(), 1U);
  EXPECT_EQ(model.joints[0].a, (model::Corner{0, 1}));
  EXPECT_EQ(model.joints[0].b, (model::Corner{1, 0}));
  std::vector<std::string> warnings;
  EXPECT_EQ(formats::readObjPair(folder.path() / "a_contracted.obj", std::nullopt, warnings)
                .joints.size(),
            2U);
}

TEST(Formats, ManyCornersThatCoincideAreJoinedOnce) {
  // Triangles like the pages of a book in the plane x = 0: all share one corner.
  const int pages = 20000;
  const auto edge = [](int k) {
    const double angle = k * M_PI / 20000;
    return "v 0 " + std::to_string(1000 * std::cos(angle)) + " " +
           std::to_string(1000 * std::sin(angle)) + "\n";
  };
  std::string text;
  for (int k = 0; k < pages; ++k) text += "v 0 0 0\n" + edge(k) + edge(k + 1);
  for (int k = 0; k < pages; ++k) {
    text += "f " + std::to_string(3 * k + 1) + " " + std::to_string(3 * k + 2) + " " +
            std::to_string(3 * k + 3) + "\n";
  }
  const TemporaryFolder folder;
  folder.write("a.obj", text);
  EXPECT_EQ(read(folder.path() / "a.obj").joints.size(), 2U * (pages - 1));
}

TEST(Formats, ReadsFoldOfOtherPrograms) {
  const TemporaryFolder folder;
  folder.write("fan.fold", R"({"file_spec": 1, "vertices_coords": [[0,0],[1,0],[1,1],[2,0]],
    "edges_vertices": [[1,2]], "edges_assignment": ["M"], "faces_vertices": [[0,1,2],[1,3,2]],
    "file_frames": [{"frame_title": "half"},
                    {"vertices_coords": [[0,0,0],[1,0,0],[1,1,0],[1,0,1]]}]})");
  const model::Model model = read(folder.path() / "fan.fold");
  EXPECT_EQ(model.tiles.size(), 2U);
  EXPECT_EQ(model.joints.size(), 2U);
  ASSERT_TRUE(model.target);
  EXPECT_EQ((*model.target)[1].vertices[1], Vector3(1, 0, 1));
}

TEST(Formats, ReadsPlanarFiles) {
  // Clockwise, from 1; the first joint closed, the second a link of length 1.
  const TemporaryFolder folder;
  folder.write("vertices.txt", "0 0 0 1 1 1 1 0\n1 0 1 1 2 1 2 0\n3 0 3 1 4 1\n");
  folder.write("constraints.txt", "1 4 2 1\n2 4 3 1\n");
  const model::Model model = read(folder.path());
  ASSERT_EQ(model.tiles.size(), 3U);
  for (const model::Tile& tile : model.tiles) EXPECT_GT(model::tileNormal(tile).z(), 0);
  EXPECT_EQ(model.joints[0].kind, model::JointKind::Pivot);
  EXPECT_EQ(model.joints[0].face, model::JointFace::Both);
  EXPECT_EQ(model.joints[0].a, (model::Corner{0, 0}));
  EXPECT_EQ(model.joints[0].b, (model::Corner{1, 3}));
  EXPECT_EQ(model.joints[1].kind, model::JointKind::Link);
  EXPECT_EQ(model.joints[1].apart.norm(), 1);
}

/// A number's bytes, the most significant first if the order is big.
template <typename T>
std::string bytesOf(T value, bool isBig) {
  std::string bytes(sizeof value, 0);
  std::memcpy(bytes.data(), &value, sizeof value);
  if (isBig) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// Two unit squares side by side, the edge between them from (1, 0) to (1, 1).
std::string twoSquares(const std::string& more) {
  return R"({"file_spec": 1.2, "vertices_coords": [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1]],
             "faces_vertices": [[0,1,4,5],[1,2,3,4]],
             "edges_vertices": [[0,1],[1,4],[4,5],[5,0],[1,2],[2,3],[3,4]], )" +
         more + "}";
}

TEST(Formats, FoldAnglesMakeTheTarget) {
  const TemporaryFolder folder;
  folder.write("a.fold", twoSquares(R"("edges_assignment": ["B","V","B","B","B","B","B"],
      "edges_foldAngle": [null,90,null,null,null,null,null])"));
  const model::Model valley = read(folder.path() / "a.fold");
  EXPECT_EQ(valley.joints.size(), 2U);
  ASSERT_TRUE(valley.target);
  // A valley folds the other square up, to the side from which the faces are anticlockwise.
  EXPECT_LT(((*valley.target)[1].vertices[1] - Vector3(1, 0, 1)).norm(), 1e-15);
  folder.write("b.fold", twoSquares(R"("edges_assignment": ["B","M","B","B","B","B","B"],
      "edges_foldAngle": [null,-90,null,null,null,null,null])"));
  const model::Model mountain = read(folder.path() / "b.fold");
  EXPECT_LT(((*mountain.target)[1].vertices[1] - Vector3(1, 0, -1)).norm(), 1e-15);
  // Written again, the crease has its angle.
  formats::writeModel(valley, folder.path() / "c.fold");
  const std::string text = test::bytesOf(folder.path() / "c.fold");
  EXPECT_NE(text.find("\"V\""), text.npos);
  EXPECT_NE(text.find("90.0"), text.npos);
}

using FoldAngles = std::map<std::pair<int, int>, double>;

/// Two unit squares like these in a file, folded up by 90 degrees.
std::string uprightSquares(const std::string& more) {
  return R"({"file_spec": 1.2, "vertices_coords": [[0,0,0],[1,0,0],[1,0,1],[1,1,1],[1,1,0],[0,1,0]],
             "faces_vertices": [[0,1,4,5],[1,2,3,4]], "edges_vertices": [[0,1],[1,4],[4,3]], )" +
         more + "}";
}

TEST(Formats, FoldAnglesAreKeptForSprings) {
  const TemporaryFolder folder;
  folder.write("a.fold", twoSquares(R"("edges_assignment": ["B","V","B","B","B","B","B"],
      "edges_foldAngle": [null,90,null,null,null,null,null])"));
  const FoldAngles valley = {{{0, 1}, 90 * kDegree}, {{1, 0}, 90 * kDegree}};
  EXPECT_EQ(read(folder.path() / "a.fold").foldAngles, valley);
  // For any fold of the start.
  folder.write("b.fold", uprightSquares(R"("edges_assignment": ["B","M","B"],
      "edges_foldAngle": [null,-30,null])"));
  const model::Model upright = read(folder.path() / "b.fold");
  EXPECT_FALSE(upright.target);
  const FoldAngles mountain = {{{0, 1}, -30 * kDegree}, {{1, 0}, -30 * kDegree}};
  EXPECT_EQ(upright.foldAngles, mountain);
  // Written again too.
  formats::writeModel(upright, folder.path() / "c.fold");
  EXPECT_NEAR(read(folder.path() / "c.fold").foldAngles.at({0, 1}), -30 * kDegree, 1e-15);
  EXPECT_NE(test::bytesOf(folder.path() / "c.fold").find("\"M\""), std::string::npos);
  for (const char* unfolded :
       {R"("edges_foldAngle": [null,null,null])",
        R"("edges_assignment": ["B","C","B"], "edges_foldAngle": [0,90,0])",
        R"("edges_assignment": ["B","J","B"], "edges_foldAngle": [0,90,0])"}) {
    folder.write("d.fold", uprightSquares(unfolded));
    EXPECT_TRUE(read(folder.path() / "d.fold").foldAngles.empty()) << unfolded;
  }
}

// Two squares with a vertex in the middle of their common edge.
TEST(FormatErrors, FoldsByTwoAnglesAboutOneLine) {
  const TemporaryFolder folder;
  folder.write("a.fold", R"({"vertices_coords": [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1],[1,0.5]],
      "faces_vertices": [[0,1,6,4,5],[1,2,3,4,6]], "edges_vertices": [[1,6],[4,6]],
      "edges_foldAngle": [90,45]})");
  try {
    read(folder.path() / "a.fold");
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              (folder.path() / "a.fold").string() +
                  ": error: two edges of the tiles 0 and 1 fold by 90 and 45 degrees, but two "
                  "tiles have one angle. Correct the angle or the letter of one edge");
  }
}

TEST(Formats, FoldCutsSeparateAndJoinsFix) {
  const TemporaryFolder folder;
  folder.write("a.fold", twoSquares(R"("edges_assignment": ["B","C","B","B","B","B","B"])"));
  EXPECT_TRUE(read(folder.path() / "a.fold").joints.empty());
  folder.write("b.fold", twoSquares(R"("edges_assignment": ["B","J","B","B","B","B","B"])"));
  const model::Model joined = read(folder.path() / "b.fold");
  ASSERT_EQ(joined.tiles.size(), 1U);
  EXPECT_EQ(joined.tiles[0].vertices.size(), 6U);
  EXPECT_TRUE(joined.joints.empty());
  // Four squares round a hole have no outline that is one polygon: they are fixed to each other.
  folder.write("c.fold", R"({"vertices_coords": [[0,0],[3,0],[3,3],[0,3],[1,1],[2,1],[2,2],[1,2]],
      "faces_vertices": [[0,1,5,4],[1,2,6,5],[2,3,7,6],[3,0,4,7]],
      "edges_vertices": [[0,4],[1,5],[2,6],[3,7]], "edges_assignment": ["J","J","J","J"]})");
  const model::Model ring = read(folder.path() / "c.fold");
  EXPECT_EQ(ring.tiles.size(), 4U);
  ASSERT_EQ(ring.joints.size(), 4U);
  for (const model::Joint& joint : ring.joints) EXPECT_EQ(joint.kind, model::JointKind::Fixed);
}

TEST(Formats, ReadsPlyOfAllThreeKinds) {
  const std::string elements =
      "comment two triangles\nelement vertex 4\nproperty float x\nproperty double y\n"
      "property uchar red\nproperty float z\nelement face 2\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  std::string ascii = "ply\nformat ascii 1.0\n" + elements;
  ascii += "0 0 7 0\n1 0 7 0\n1 1 7 0\n2 0 7 0.5\n3 0 1 2\n3 1 3 2\n";
  const auto binary = [&](bool isBig) {
    std::string text = fmt::format("ply\nformat binary_{}_endian 1.0\n", isBig ? "big" : "little");
    text += elements;
    for (const auto& [x, y, z] :
         {std::tuple{0.f, 0., 0.f}, {1.f, 0., 0.f}, {1.f, 1., 0.f}, {2.f, 0., 0.5f}}) {
      text += bytesOf(x, isBig) + bytesOf(y, isBig) + '\7' + bytesOf(z, isBig);
    }
    for (const auto& face : {std::array{0, 1, 2}, {1, 3, 2}}) {
      text += '\3';
      for (const int corner : face) text += bytesOf(corner, isBig);
    }
    return text;
  };
  // Line ends of old Macintosh programs.
  std::string macintosh = ascii;
  std::ranges::replace(macintosh, '\n', '\r');
  const TemporaryFolder folder;
  for (const std::string& text :
       {ascii, macintosh, "\xEF\xBB\xBF" + ascii, binary(false), binary(true)}) {
    folder.write("a.ply", text);
    const model::Model model = read(folder.path() / "a.ply");
    ASSERT_EQ(model.tiles.size(), 2U);
    EXPECT_EQ(model.tiles[1].vertices[1], Vector3(2, 0, 0.5));
    ASSERT_EQ(model.joints.size(), 2U);  // a shared edge is a hinge
    EXPECT_EQ(model.joints[0].a, (model::Corner{0, 1}));
    EXPECT_EQ(model.joints[1].b, (model::Corner{1, 2}));
  }
}

TEST(Formats, AnotherModelCanBeTheTarget) {
  const TemporaryFolder folder;
  generate::TessellationShape shape;
  formats::writeModel(generate::makeTessellation(shape), folder.path() / "start");
  shape.startAngle = 0.5;
  const model::Model open = generate::makeTessellation(shape);
  formats::writeModel(open, folder.path() / "open.fold");
  std::vector<std::string> warnings;
  const model::Model model =
      formats::readModel(folder.path() / "start", folder.path() / "open.fold", warnings);
  expectSameTiles(*model.target, open.tiles);
}

TEST(Formats, ReadsThePublishedPairs) {
  if (!fs::exists(kPairs)) GTEST_SKIP() << kPairs << " is not there";
  const std::map<std::string, std::pair<std::size_t, std::size_t>> published = {
      {"hexagon_shear_w4_h2_i4_f0", {36, 46}},
      {"quad_circle_w3_h3_i3_f1_r1", {36, 60}},
      {"quad_sphere_w4_h4_i3_f0_r0", {64, 112}},
      {"triangle_circle_w3_h3_i3_f1_r1", {72, 96}},
      {"triangle_sphere_w3_h4_i3_f0_r0", {96, 130}}};
  for (const auto& [name, counts] : published) {
    const model::Model model = read(kPairs / (name + "_contracted.obj"));
    EXPECT_EQ(model.name, name);
    EXPECT_EQ(model.tiles.size(), counts.first) << name;
    EXPECT_EQ(model.joints.size(), counts.second) << name;
    EXPECT_TRUE(model.target) << name;
  }
}

/// The message about a file, the folder's name replaced by "@".
std::string messageFor(const std::map<std::string, std::string>& files, const std::string& name,
                       const std::string& target = "") {
  const TemporaryFolder folder;
  for (const auto& [file, text] : files) folder.write(file, text);
  std::string message;
  std::vector<std::string> warnings;
  try {
    std::optional<fs::path> other;
    if (!target.empty()) other = folder.path() / target;
    formats::readModel(folder.path() / name, other, warnings);
    for (const std::string& warning : warnings) message += warning;
  } catch (const InputError& error) {
    message = error.what();
  }
  const std::string place = folder.path().string();
  for (std::size_t at = message.find(place); at != message.npos; at = message.find(place)) {
    message.replace(at, place.size(), "@");
  }
  return message;
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";

TEST(FormatErrors, Obj) {
  EXPECT_EQ(messageFor({{"a.obj", kTriangle + "f 0 1 2\n"}}, "a.obj"),
            "@/a.obj:4:3: error: there are only vertices 1-3 before this line, not 0; OBJ counts "
            "from 1: add 1 to all vertex numbers");
  EXPECT_EQ(messageFor({{"a.obj", kTriangle + "f 1 2 4\n"}}, "a.obj"),
            "@/a.obj:4:7: error: there are only vertices 1-3 before this line, not 4; correct this "
            "number, or move the face below its vertices");
  EXPECT_EQ(messageFor({{"a.obj", "f 1 2 3\n" + kTriangle}}, "a.obj"),
            "@/a.obj:1:3: error: there are no vertices (v) before this line, not 1; correct this "
            "number, or move the face below its vertices");
  EXPECT_EQ(messageFor({{"a.obj", kTriangle + "f 1 2\n"}}, "a.obj"),
            "@/a.obj:4: error: face 0 has 2 vertices; a tile has at least 3: complete it or delete "
            "the line");
  EXPECT_EQ(messageFor({{"a.obj", "v 1 2\n"}}, "a.obj"),
            "@/a.obj:1: error: a vertex has x, y and z, not 2 numbers; complete it");
  EXPECT_EQ(
      messageFor({{"a.obj", kTriangle}}, "a.obj"),
      "@/a.obj: error: the file has no face; give a Wavefront OBJ file with one face per tile");
}

TEST(FormatErrors, PairsWhoseFacesDiffer) {
  const std::string four = kTriangle + "v 2 0 0\n";
  EXPECT_EQ(messageFor({{"a_contracted.obj", four + "f 1 2 3\nf 2 4 3\n"},
                        {"a_deployed.obj", four + "f 1 2 3\n"}},
                       "a_contracted.obj"),
            "@/a_deployed.obj: error: the target has 1 tile, a_contracted.obj has 2; write one "
            "target tile for each tile, in the same order");
  EXPECT_EQ(messageFor({{"a_contracted.obj", four + "f 1 2 3\nf 2 4 3\n"},
                        {"a_deployed.obj", four + "v 1 0 0\nf 1 2 3\nf 5 4 3\n"}},
                       "a_contracted.obj"),
            "@/a_deployed.obj:7: error: face 1 has other vertex numbers than at "
            "a_contracted.obj:6; write the same faces in the same order in both files");
}

TEST(FormatErrors, Orientation) {
  const std::string four = kTriangle + "v 2 0 0\n";
  EXPECT_EQ(messageFor({{"a.obj", four + "f 1 2 3\nf 3 4 2\n"}}, "a.obj"),
            "@/a.obj:6: repaired: 1 of 2 tiles runs clockwise seen from above; reversed, and "
            "written in the file's own order");
  EXPECT_EQ(messageFor({{"a.obj", four + "f 3 2 1\nf 3 4 2\n"}}, "a.obj"),
            "@/a.obj:5: repaired: 2 of 2 tiles run clockwise seen from above; reversed, and "
            "written in the file's own order");
  // The faces of joints depend on the sense of the folds.
  EXPECT_EQ(messageFor({{"a_contracted.obj", four + "f 3 2 1\nf 3 4 2\n"},
                        {"a_deployed.obj", kTriangle + "v 1 0 1\nf 3 2 1\nf 3 4 2\n"}},
                       "a_contracted.obj"),
            "@/a_contracted.obj: warning: all tiles run clockwise seen from above, so bricks "
            "extend downwards. List their vertices anticlockwise to extend bricks upwards");
}

TEST(FormatErrors, Fold) {
  EXPECT_EQ(messageFor({{"a.fold", R"({"vertices_coords": [[0,0]]})"}}, "a.fold"),
            "@/a.fold: error: faces_vertices and edges_vertices are missing. Add the faces or the "
            "edges of the sheet");
  EXPECT_EQ(messageFor({{"a.fold", R"({"faces_vertices": [[0,1,2]]})"}}, "a.fold"),
            "@/a.fold: error: vertices_coords is missing. Add the coordinates of the vertices");
  EXPECT_EQ(
      messageFor(
          {{"a.fold", R"({"vertices_coords": [[0,0],[1,0],[1,1]], "faces_vertices": [[1,2,3]]})"}},
          "a.fold"),
      "@/a.fold: error: face 0 has the vertex 3, but there are vertices 0-2; correct it: FOLD "
      "counts from 0");
  EXPECT_EQ(
      messageFor({{"a.fold", R"({"vertices_coords": [[0,"x"]], "faces_vertices": [[0,0,0]]})"}},
                 "a.fold"),
      "@/a.fold: error: vertex 0 is [0,\"x\"], not two or three coordinates within 1e+15; correct "
      "it");
  EXPECT_EQ(
      messageFor({{"a.fold", R"({"vertices_coords": [[0,0]], "faces_vertices": [0]})"}}, "a.fold"),
      "@/a.fold: error: entry 0 is 0, not a list of whole numbers. Write vertex numbers >= 0");
  EXPECT_TRUE(messageFor({{"a.fold", "{\"x\": "}}, "a.fold")
                  .starts_with("@/a.fold: error: this is not JSON ("));
  EXPECT_EQ(messageFor({{"a.fold", "3"}}, "a.fold"),
            "@/a.fold: error: the file is 3, not a JSON object. Give a FOLD file");
}

/// The message about a sheet of one triangle with more keys.
std::string messageForFold(const std::string& faces, const std::string& more = "") {
  return messageFor({{"a.fold", R"({"vertices_coords": [[0,0],[1,0],[1,1]], "faces_vertices": )" +
                                    faces + more + "}"}},
                    "a.fold");
}

TEST(FormatErrors, FacesWithHoles) {
  // A square with a square hole, connected to the outline by a line in both directions.
  const std::string places = "[[0,0],[4,0],[4,4],[0,4],[1,1],[1,3],[3,3],[3,1]]";
  EXPECT_EQ(messageFor({{"a.fold", R"({"vertices_coords": )" + places +
                                       R"(, "faces_vertices": [[0,1,2,3,0,4,5,6,7,4]]})"}},
                       "a.fold"),
            "@/a.fold: error: tile 0 has a hole, connected to its outline at vertices 0 and 4. "
            "Tiles cannot have holes. Divide it into tiles without holes and join them");
}

TEST(FormatErrors, FoldEdgesAndFramesThatAreBroken) {
  const std::string one = "[[0,1,2]]";
  for (const char* ends : {"[0,99]", "[-1,0]", "[0]", "[0,1,2]"}) {
    EXPECT_EQ(
        messageForFold(one, std::string(R"(,"edges_vertices": [[0,1],)") + ends + "]"),
        std::string("@/a.fold: error: edge 1 is ") + ends +
            ", but an edge joins two of the vertices 0-2; correct it, or delete edges_vertices");
  }
  EXPECT_EQ(messageForFold(one, R"(,"edges_vertices": 7)"),
            "@/a.fold: error: edges_vertices is 7, not a list of edges. Correct or delete it");
  const std::string edges = R"(,"edges_vertices": [[0,1],[1,2],[2,0]], "edges_assignment": )";
  for (const char* assignment : {"[\"B\"]", "3"}) {
    EXPECT_EQ(messageForFold(one, edges + assignment),
              std::string("@/a.fold: error: edges_assignment is ") + assignment +
                  ", but 3 edges need as many letters. Correct or delete it");
  }
  EXPECT_EQ(messageForFold(one, edges + R"(["B","X","M"])"),
            "@/a.fold: error: edge 1 has the assignment \"X\". Write one of B, M, V, F, U, C, J");
  const std::string angles = R"(,"edges_vertices": [[0,1],[1,2]], "edges_foldAngle": )";
  EXPECT_EQ(messageForFold(one, angles + "[null]"),
            "@/a.fold: error: edges_foldAngle is [null], but 2 edges need as many angles. Correct "
            "or delete it");
  EXPECT_EQ(messageForFold(one, angles + "[null, 270]"),
            "@/a.fold: error: edge 1 has the fold angle 270, which is neither null nor in "
            "[-180, 180] degrees. Correct it");
  EXPECT_EQ(messageForFold(one, R"(,"file_frames": {"frame_title": "a"})"),
            "@/a.fold: error: file_frames is {\"frame_title\":\"a\"}, not a list of frames. "
            "Correct or delete it");
  EXPECT_EQ(
      messageForFold(one, R"(,"file_frames": [{}, 3])"),
      "@/a.fold: error: entry 1 of file_frames is 3, not a JSON object. Correct or delete it");
  // The content of a frame that is not read does not matter.
  EXPECT_EQ(
      messageForFold(one, R"(,"file_frames": [{"edges_vertices": [[0,3]]}])"),
      "@/a.fold: warning: of frames 0-1, frame 0 is the start, and 1 other is not read; `frame = "
      "N` reads frame N only");
}

TEST(FormatErrors, FoldNumbersThatDoNotExist) {
  EXPECT_EQ(messageForFold("[[0,1,2],[]]"),
            "@/a.fold: error: face 1 has 0 vertices; a tile has at least 3: complete it or delete "
            "it");
  EXPECT_EQ(messageForFold("[[0,1,4294967298]]"),
            "@/a.fold: error: entry 0 is [0,1,4294967298], not a list of whole numbers. Write "
            "vertex numbers >= 0");
  EXPECT_EQ(messageForFold("[[0,1,2]]", R"(,"kirireel:pulled_tiles": [0, 1])"),
            "@/a.fold: error: kirireel:pulled_tiles names tile 1, but the file has tiles 0-0. "
            "Correct the number");
  const std::string two = "[[0,1,2],[0,1,2]]";
  EXPECT_EQ(messageForFold(two, R"(,"kirireel:joints": [[0,0,1,0,1,3]])"),
            "@/a.fold: error: joint 0 has the kind 3; write one of 0 (pivot), 1 (link), 2 (fixed)");
  EXPECT_EQ(messageForFold(two, R"(,"kirireel:joints": [[0,0,1,0,1,1]])"),
            "@/a.fold: error: the link between tiles 0 and 1 has no length. Remove its kind to "
            "join the corners");
}

TEST(FormatErrors, FoldNestedWithoutEnd) {
  const std::string open(200000, '['), closed(200000, ']');
  const std::string message =
      "@/a.fold: error: values are nested more than 64 deep, but a FOLD file has 5 levels. Give a "
      "FOLD file";
  EXPECT_EQ(messageForFold("[[0,1,2]]", ",\"x\": " + open + closed), message);
  EXPECT_EQ(messageForFold("[[0,1,2]]", ",\"file_frames\": " + open + closed), message);
  EXPECT_EQ(messageForFold(open + closed), message);
  const std::string fewOpen(40, '['), fewClosed(40, ']');
  EXPECT_EQ(messageForFold("[[0,1,2]]", ",\"file_x\": " + fewOpen + fewClosed), "");
}

TEST(FormatErrors, JsonWithTextThatIsLong) {
  const std::string message =
      messageFor({{"a.fold", "\"\x1b" + std::string(5000, 'a') + "\""}}, "a.fold");
  EXPECT_LT(message.size(), 300U);
  EXPECT_EQ(message.find('\x1b'), message.npos);
}

TEST(FormatErrors, Ply) {
  const auto message = [](const std::string& text) {
    return messageFor({{"a.ply", text}}, "a.ply");
  };
  const std::string end = "; give a PLY mesh with one face per tile";
  EXPECT_EQ(message("solid"), "@/a.ply:1: error: the file does not begin with \"ply\"" + end);
  EXPECT_EQ(message("ply\n"), "@/a.ply: error: the header has no end" + end);
  EXPECT_EQ(message("ply\nend_header\n"), "@/a.ply: error: the header has no format" + end);
  EXPECT_EQ(message("ply\nformat cuneiform 1.0\n"),
            "@/a.ply:2: error: there is no format 'cuneiform'" + end);
  EXPECT_EQ(message("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n"),
            "@/a.ply: error: the header has no element face" + end);
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty "
      "float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  EXPECT_EQ(message(header + "0 0 0 1 0 0 1 1"), "@/a.ply: error: the file ends early" + end);
  EXPECT_EQ(message(header + "0 0 0 1 0 0 1 1 0 3 0 1 9"),
            "@/a.ply: error: face 0 has the vertex 9, but there are vertices 0-2: PLY counts from "
            "0" +
                end);
  EXPECT_EQ(message(header + "0 0 0 1 0 0 1 1 0 2 0 1"),
            "@/a.ply: error: face 0 has 2 vertices, a tile has at least 3" + end);
  EXPECT_EQ(message(header + "0 0 0\n1 0 x\n1 1 0\n3 0 1 2\n"),
            "@/a.ply:11: error: 'x' is not a number" + end);
  EXPECT_EQ(message(header + "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n3 2 1 0\n"),
            "@/a.ply:14: error: there is more data than the header counts (vertex 3, face 1). "
            "Correct the counts" +
                end);
}

TEST(FormatErrors, TilesOfTooManyVertices) {
  std::string text, face = "f";
  for (int k = 0; k < 301; ++k) {
    const double angle = 2 * M_PI * k / 301;
    text += "v " + std::to_string(std::cos(angle)) + " " + std::to_string(std::sin(angle)) + " 0\n";
    face += " " + std::to_string(k + 1);
  }
  EXPECT_EQ(messageFor({{"a.obj", text + face + "\n"}}, "a.obj"),
            "@/a.obj:302: error: tile 0 has 301 vertices, at most 300 are allowed; split it into "
            "convex tiles");
}

TEST(FormatErrors, ObjPullsOfNoFace) {
  EXPECT_EQ(messageFor({{"a.obj", "# pull 1\n" + kTriangle + "f 1 2 3\n"}}, "a.obj"),
            "@/a.obj:1:8: error: there are faces 0-0, not 1; correct this number");
}

TEST(FormatErrors, ObjCornersThatCannotBeDistinguished) {
  // A sheet of size 1e3 with a tile of size 1e-4.
  EXPECT_EQ(messageFor({{"a.obj",
                         "v 0 0 0\nv 1000 0 0\nv 0 1000 0\n"
                         "v 0 0 0\nv 0.0001 0 0\nv 0 0.0001 0\nf 1 2 3\nf 4 5 6\n"}},
                       "a.obj"),
            "@/a.obj: error: corners at tile 1 are within 0.0014, below the precision of their "
            "digits, but are different vertices. Give joined corners the same vertex number");
}

TEST(FormatErrors, PlanarFiles) {
  const std::string inSpace =
      "Put files with x, y and z, and joints with a face, into a folder as vertices.txt and "
      "constraints.txt";
  const std::string squares = "0 0 0 1 1 1 1 0\n1 0 1 1 2 1 2 0\n";
  const std::string turned =
      "@/./vertices.txt:1: repaired: 2 of 2 tiles run clockwise seen from above; reversed, and "
      "written in the file's own order";
  EXPECT_EQ(messageFor({{"vertices.txt", squares}, {"constraints.txt", "0 3 1 0\n"}}, "."),
            "@/./constraints.txt: repaired: tiles and vertices count from 0, not from 1; "
            "they are read as counted from 0" +
                turned);
  EXPECT_EQ(
      messageFor({{"vertices.txt", squares}, {"constraints.txt", "1 -2147483648 2 1\n"}}, "."),
      "@/./constraints.txt:1:3: error: tile 1 has vertices 1-4, not -2147483646; correct this "
      "column");
  EXPECT_EQ(messageFor({{"vertices.txt", squares}, {"constraints.txt", "1 4 2\n"}}, "."),
            "@/./constraints.txt:1: error: a joint does not have 3 numbers; write one joint per "
            "line, \"tile vertex tile vertex\", from 1. " +
                inSpace);
  EXPECT_EQ(
      messageFor({{"a_vertices.txt", "0 0 1 1 0 1 1 1 1 0 1 1\n"}, {"a_constraints.txt", ""}},
                 "a_vertices.txt"),
      "@/a_vertices.txt: error: every third number is 1: vertices have x, y and z. " + inSpace);
  EXPECT_EQ(
      messageFor({{"a_vertices.txt", "0 0 0 1\n"}, {"a_constraints.txt", ""}}, "a_vertices.txt"),
      "@/a_vertices.txt:1: error: tile 1 has 4 numbers; write x and y for each of at least 3 "
      "vertices. " +
          inSpace);
}

// The same files under another name of the model are the same model.
TEST(PlanarNames, NeverChangeTheMeaningOfFiles) {
  const std::string squares = "0 0 1 0 1 1 0 1\n1 1 2 1 2 2 1 2\n";
  for (const std::string name :
       {"sheet", "hull", "tiles", "rotating_tiles", "constraints_v2", "vertices", "hull_tiles",
        "a b", "süß", "hull_vertices_constraints"}) {
    SCOPED_TRACE(name);
    for (const std::string ending : {".txt", ".TXT"}) {
      const TemporaryFolder folder;
      folder.write(name + "_vertices" + ending, squares);
      folder.write(name + "_constraints" + ending, "1 3 2 1\n");
      folder.write(name + "_hull" + ending, "0 0\n0 1\n1 2\n");
      folder.write(name + "_hull_tiles" + ending, "0\n1\n");
      for (const std::string part : {"_vertices", "_constraints", "_hull"}) {
        std::vector<std::string> warnings;
        const model::Model model =
            formats::readModel(folder.path() / (name + part + ending), {}, warnings);
        EXPECT_EQ(model.name, name);
        ASSERT_EQ(model.joints.size(), 1U);
        ASSERT_TRUE(model.hull.has_value());
        EXPECT_EQ(model.hull->size(), 3U);
        EXPECT_THAT(warnings, testing::IsEmpty());
      }
    }
  }
}

TEST(FileEndings, MayHaveCapitals) {
  const TemporaryFolder folder;
  std::vector<std::string> warnings;
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  folder.write("a_contracted.OBJ", obj);
  folder.write("a_deployed.OBJ", obj);
  EXPECT_TRUE(formats::readModel(folder.path() / "a_contracted.OBJ", {}, warnings).target);
  folder.write("b_contracted.Obj", obj);
  folder.write("b_deployed.obj", obj);
  EXPECT_TRUE(formats::readModel(folder.path() / "b_contracted.Obj", {}, warnings).target);
  // Read as the format that its ending names.
  folder.write("c.Svg", "<svg></svg>");
  EXPECT_THAT([&] { formats::readModel(folder.path() / "c.Svg", {}, warnings); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("no lines of a sheet")));
}

TEST(FormatErrors, UnknownEndingsAndOtherTargets) {
  EXPECT_EQ(
      messageFor({{"a.stl", ""}}, "a.stl"),
      "@/a.stl: error: '.stl' is not the ending of a model. Give a folder with vertices.txt, a "
      "planar NAME_vertices.txt, a .fold, .obj or .ply file, or a cut pattern (.svg, .dxf)");
  EXPECT_EQ(messageFor(
                {{"a.obj", kTriangle + "f 1 2 3\n"}, {"b.obj", kTriangle + "v 0 1 0\nf 1 2 3 4\n"}},
                "a.obj", "b.obj"),
            "@/b.obj: error: the target has 1 tile, the model 1, with different numbers of "
            "vertices. Give the same tiles in the same order");
  try {
    formats::writeModel(generate::makeTessellation({}), "/tmp/sheet.stl");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(),
                 "/tmp/sheet.stl: error: there is no format '.stl'. Give an ending .fold or .obj, "
                 "a name that ends with vertices.txt for planar files, or no ending for a folder");
  }
  model::Model linked = generate::makeTessellation({});
  linked.joints = {model::makeLink(linked.tiles, {0, 0}, {5, 2})};
  try {
    formats::writeModel(linked, "/tmp/sheet.obj");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(
        error.what(),
        "/tmp/sheet.obj: error: OBJ supports only joints at shared vertices, not the joint "
        "(link) between tiles 0 and 5. Convert to a .fold file");
  }
}

TEST(FormatErrors, WritersNumberTilesAsTheModelsFileDoes) {
  const auto refusal = [](model::Model model, const char* file) -> std::string {
    model.fileOrder.countsFrom = 1;
    try {
      formats::writeModel(model, file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "written";
  };
  model::Model model = generate::makeTessellation({});
  model.joints = {model::makeLink(model.tiles, {0, 0}, {5, 2})};
  EXPECT_EQ(refusal(model, "/tmp/sheet.obj"),
            "/tmp/sheet.obj: error: OBJ supports only joints at shared vertices, not the joint "
            "(link) between tiles 1 and 6. Convert to a .fold file");
  EXPECT_EQ(refusal(model, "/tmp/sheet"),
            "/tmp/sheet: error: constraints.txt supports only joints at corners, not the joint "
            "(link) between tiles 1 and 6. Convert to a .fold file");
  model.joints = {model::makeFixedJoint(model.tiles, 0, 5)};
  EXPECT_EQ(refusal(model, "/tmp/sheet_vertices.txt"),
            "/tmp/sheet_vertices.txt: error: planar files support only joints at corners, not the "
            "joint (fixed) between tiles 1 and 6. Convert to a .fold file");
}

}  // namespace
}  // namespace kirireel
