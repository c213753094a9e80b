// FOLD files of other programs, and their content after writing.
//
// Oracles: a written file has the same vertices, edges, letters and angles; faces found from the
// edges of a random drawing are those that it was made of; letters give the angles of the same file
// with angles; folded sheets are rotations about their edges.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/base/files.h"
#include "sim/formats/faces.h"
#include "sim/formats/model_formats.h"
#include "sim/formats/read_model.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/shared_corners.h"
#include "sim/generate/lattice.h"
#include "sim/model/sheet_frame.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

using test::TemporaryFolder;
namespace fs = std::filesystem;
using nlohmann::json;

struct ReadSheet {
  model::Model model;
  std::string messages;  ///< warnings, or the error, the folder's name replaced by "@"
};

ReadSheet readText(const std::string& text, const formats::ReadSettings& settings = {},
                   const std::string& name = "a.fold") {
  const TemporaryFolder folder;
  folder.write(name, text);
  ReadSheet sheet;
  std::vector<std::string> warnings;
  try {
    sheet.model = formats::readModel(folder.path() / name, std::nullopt, warnings, settings);
    for (const std::string& warning : warnings) sheet.messages += warning;
  } catch (const InputError& error) {
    sheet.messages = error.what();
  }
  const std::string place = folder.path().string();
  for (std::size_t at = sheet.messages.find(place); at != sheet.messages.npos;
       at = sheet.messages.find(place)) {
    sheet.messages.replace(at, place.size(), "@");
  }
  return sheet;
}

/// Two unit squares side by side; the edge between them is number 1, from (1, 0) to (1, 1).
json twoSquares() {
  return json::parse(R"({"file_spec": 1.1, "vertices_coords": [[0,0],[1,0],[2,0],[2,1],[1,1],[0,1]],
      "faces_vertices": [[0,1,4,5],[1,2,3,4]],
      "edges_vertices": [[0,1],[1,4],[4,5],[5,0],[1,2],[2,3],[3,4]],
      "edges_assignment": ["B","V","B","B","B","B","B"]})");
}

json edited(json file, const json& changes) {
  file.update(changes);
  return file;
}

Vector3 cornerOf(const std::vector<model::Tile>& tiles, int tile, int vertex) {
  return tiles[static_cast<std::size_t>(tile)].vertices[static_cast<std::size_t>(vertex)];
}

/// A file whose faces have their own vertices, and their own edges with the letters of the file.
json withOwnVertices(const json& file) {
  json own = file;
  for (const char* key :
       {"vertices_coords", "faces_vertices", "edges_vertices", "edges_assignment"})
    own[key] = json::array();
  std::map<std::set<int>, json> letters;
  for (std::size_t k = 0; k < file["edges_vertices"].size(); ++k) {
    const json& edge = file["edges_vertices"][k];
    letters[{edge[0], edge[1]}] = file["edges_assignment"][k];
  }
  for (const json& face : file["faces_vertices"]) {
    const std::size_t first = own["vertices_coords"].size(), count = face.size();
    json outline;
    for (std::size_t k = 0; k < count; ++k) {
      own["vertices_coords"].push_back(file["vertices_coords"][face[k].get<std::size_t>()]);
      outline.push_back(first + k);
      own["edges_vertices"].push_back({first + k, first + (k + 1) % count});
      own["edges_assignment"].push_back(letters.at({face[k], face[(k + 1) % count]}));
    }
    own["faces_vertices"].push_back(outline);
  }
  return own;
}

/// Whether two corners are joined, directly or through others.
DisjointSets joinedCorners(const model::Model& model) {
  std::vector<int> first = {0};
  for (const model::Tile& tile : model.tiles) {
    first.push_back(first.back() + static_cast<int>(tile.vertices.size()));
  }
  DisjointSets sets(static_cast<std::size_t>(first.back()));
  for (const model::Joint& joint : model.joints) {
    sets.unite(first[static_cast<std::size_t>(joint.a.tile)] + joint.a.vertex,
               first[static_cast<std::size_t>(joint.b.tile)] + joint.b.vertex);
  }
  return sets;
}

// With faces and without: the same joints and folds as with common vertices.
TEST(FoldFile, FacesMayHaveTheirOwnVertices) {
  const auto without = [](json file, const char* key) {
    file.erase(key);
    return file;
  };
  const json file = json::parse(
      R"({"file_spec": 1.1, "vertices_coords": [[0,0],[1,0],[2,0],[0,1],[1,1],[2,1],[0,2],[1,2],[2,2]],
      "faces_vertices": [[0,1,4,3],[1,2,5,4],[3,4,7,6],[4,5,8,7]],
      "edges_vertices": [[0,1],[1,2],[2,5],[5,8],[8,7],[7,6],[6,3],[3,0],[1,4],[4,7],[3,4],[4,5]],
      "edges_assignment": ["B","B","B","B","B","B","B","B","V","C","V","M"]})");
  const model::Model whole = readText(file.dump()).model;
  ASSERT_EQ(whole.foldAngles.size(), 6u);
  for (const json& own : {withOwnVertices(file), without(withOwnVertices(file), "faces_vertices"),
                          without(file, "faces_vertices")}) {
    const ReadSheet sheet = readText(own.dump());
    // Faces that are found have their own order.
    const auto signs = [](const model::Model& model) {
      std::multiset<double> angles;
      for (const auto& [pair, angle] : model.foldAngles) angles.insert(angle);
      return angles;
    };
    EXPECT_EQ(signs(sheet.model), signs(whole)) << sheet.messages;
    EXPECT_EQ(std::ranges::max(joinedCorners(sheet.model).numbers()),
              std::ranges::max(joinedCorners(whole).numbers()))
        << sheet.messages;
    EXPECT_EQ(sheet.messages.find("not read"), sheet.messages.npos) << sheet.messages;
  }
}

TEST(FoldFile, FramesMayHaveTheirOwnUnits) {
  json file = edited(twoSquares(), {{"frame_unit", "mm"}});
  json places = file["vertices_coords"];
  for (json& place : places)
    place = {place[0].get<double>() / 10, place[1].get<double>() / 10, 0.01};
  file["file_frames"] = {{{"frame_parent", 0},
                          {"frame_inherit", true},
                          {"frame_unit", "cm"},
                          {"vertices_coords", places}}};
  const model::Model model = readText(file.dump()).model;
  ASSERT_TRUE(model.target);
  EXPECT_NEAR((cornerOf(*model.target, 1, 1) - Vector3(2e-3, 0, 1e-4)).norm(), 0, 1e-15);
  EXPECT_NE(readText(edited(twoSquares(), {{"frame_unit", "inch"}}).dump())
                .messages.find("frame_unit \"inch\" is not known"),
            std::string::npos);
}

TEST(FoldFile, RefusesBoundariesInsideASheetWithoutFaces) {
  json file = edited(twoSquares(), {{"edges_assignment", {"B", "B", "B", "B", "B", "B", "B"}}});
  file.erase("faces_vertices");
  EXPECT_EQ(readText(file.dump()).messages,
            "@/a.fold: error: boundary edges (B) near vertex 1 have the sheet on both sides. Give "
            "cuts the letter C, or add faces_vertices");
}

// Lengths are in the file's unit, and converting keeps it.
TEST(FoldUnits, AreThoseOfTheFile) {
  const TemporaryFolder folder;
  folder.write("sheet.fold", R"({"file_spec": 1.2, "frame_unit": "in",
    "vertices_coords": [[0, 0], [2.5, 0], [2.5, 1], [0, 1]], "faces_vertices": [[0, 1, 2, 3]]})");
  const fs::path file = folder.path() / "sheet.fold", again = folder.path() / "again.fold";
  std::vector<std::string> warnings;
  const model::Model model = formats::readModel(file, {}, warnings);
  EXPECT_EQ(model.unit.name, "in");
  EXPECT_DOUBLE_EQ(model.tiles[0].vertices[1].x(), 2.5 * 0.0254);
  EXPECT_DOUBLE_EQ(model.drawing->vertices[1].x(), 2.5 * 0.0254);
  formats::writeModel(model, again);
  const std::string text = readTextFile(again, "");
  EXPECT_NE(text.find("\"frame_unit\":\"in\""), std::string::npos);
  EXPECT_NE(text.find("2.5"), std::string::npos);
  // A FOLD file without a unit gets none. A model of another format is in metres.
  model::Model plain = readText(twoSquares().dump()).model;
  EXPECT_FALSE(json::parse(formats::foldText(plain)).contains("frame_unit"));
  EXPECT_EQ(json::parse(formats::foldText(plain, {{"t = 0 s", plain.tiles}}))["frame_unit"], "m");
  plain.drawing.reset();
  EXPECT_EQ(json::parse(formats::foldText(plain))["frame_unit"], "m");
}

// One square of 2 inches in every format that can declare a unit, and in none. A declared unit
// counts, and `unit` is only that of options and written files.
TEST(DeclaredUnits, CountInEveryFormat) {
  const std::string text = "0 0 0 2 0 0 2 2 0 0 2 0\n";
  const std::string obj = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\n";
  const std::string ply =
      "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n4 0 1 2 3\n";
  const std::string fold =
      "\"vertices_coords\": [[0,0],[2,0],[2,2],[0,2]], \"faces_vertices\": [[0,1,2,3]]}";
  const std::string rect = "viewBox='0 0 4 4'><rect x='1' y='1' width='2' height='2'/></svg>";
  const std::string dxf =
      "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n70\n1\n10\n0\n20\n0\n10\n2"
      "\n20\n0\n10\n2\n20\n2\n10\n0\n20\n2\n0\nENDSEC\n0\nEOF\n";
  struct Case {
    const char* name;
    std::string declared, undeclared;
    double otherwise;  ///< metres per unit without any unit
  };
  for (const Case& one :
       {Case{"a/vertices.txt", "# unit in\n" + text, text, 1},
        Case{"a_vertices.txt", "# unit in\n0 0 2 0 2 2 0 2\n", "0 0 2 0 2 2 0 2\n", 1},
        Case{"a.obj", "# unit in\n" + obj, obj, 1},
        Case{"a.ply", "ply\nformat ascii 1.0\ncomment unit in\n" + ply,
             "ply\nformat ascii 1.0\n" + ply, 1},
        Case{"a.fold", "{\"frame_unit\": \"in\", " + fold, "{" + fold, 1},
        Case{"a.svg", "<svg width='4in' height='4in' " + rect, "<svg " + rect, 0.0254 / 96},
        Case{"a.dxf", "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n1\n0\nENDSEC\n" + dxf, dxf,
             1e-3}}) {
    const TemporaryFolder folder;
    fs::create_directory(folder / "a");
    folder.write("a/constraints.txt", "# no joints\n");
    folder.write("a_constraints.txt", "# no joints\n");
    const auto read = [&](const std::string& content, std::optional<LengthUnit> unit) {
      folder.write(one.name, content);
      const fs::path file = folder / one.name;
      std::vector<std::string> warnings;
      return formats::readModel(file.filename() == "vertices.txt" ? file.parent_path() : file, {},
                                warnings, {.unit = unit});
    };
    const auto mm = findLengthUnit("mm");
    const auto edge = [](const model::Model& model) { return model::tileSize(model); };
    // Measured: 1.1e-16 relative.
    EXPECT_NEAR(edge(read(one.declared, {})), 2 * 0.0254, 1e-15) << one.name;
    EXPECT_EQ(read(one.declared, {}).unit.name, "in") << one.name;
    EXPECT_NEAR(edge(read(one.declared, mm)), 2 * 0.0254, 1e-15) << one.name;
    EXPECT_EQ(read(one.declared, mm).unit.name, "mm") << one.name;
    EXPECT_NEAR(edge(read(one.undeclared, mm)), 2e-3, 1e-15) << one.name;
    EXPECT_NEAR(edge(read(one.undeclared, {})), 2 * one.otherwise, 1e-15) << one.name;
  }
}

TEST(FoldFile, ReadsTextOfAnySystem) {
  const std::string plain = twoSquares().dump(1);
  std::string windows = "\xFF\xFE";
  for (const char letter : plain) windows += {letter, '\0'};
  for (const std::string& text : {"\xEF\xBB\xBF" + plain, windows}) {
    EXPECT_EQ(readText(text).model.tiles.size(), 2U);
  }
}

TEST(FoldFile, TakesBothNamesOfAngles) {
  const json angles = {0, 90, 0, 0, 0, 0, 0};
  for (const char* name : {"edges_foldAngles", "edges_foldAngle"}) {
    const ReadSheet sheet = readText(edited(twoSquares(), {{name, angles}}).dump());
    EXPECT_EQ(sheet.messages, "");
    ASSERT_TRUE(sheet.model.target) << name;
    EXPECT_LT((cornerOf(*sheet.model.target, 1, 1) - Vector3(1, 0, 1)).norm(), 1e-15);
  }
  EXPECT_EQ(readText(edited(twoSquares(), {{"edges_foldAngles", {1}}}).dump()).messages,
            "@/a.fold: error: edges_foldAngles is [1], but 7 edges need as many angles. Correct or "
            "delete it");
}

TEST(FoldFile, LettersGiveTheSign) {
  // Folded by 180 degrees, the square lies on the other one; by 90 degrees it is upright.
  const ReadSheet flat = readText(twoSquares().dump());
  EXPECT_EQ(flat.messages,
            "@/a.fold: warning: 1 edge has a letter (M or V) but no angle and folds by 180 "
            "degrees. `fold = FRACTION` sets another fraction of 180");
  ASSERT_TRUE(flat.model.target);
  EXPECT_LT((cornerOf(*flat.model.target, 1, 1) - Vector3(0, 0, 0)).norm(), 1e-15);
  json mountain = twoSquares();
  mountain["edges_assignment"][1] = "M";
  formats::ReadSettings half;
  half.fold = 0.5;
  const ReadSheet upright = readText(mountain.dump(), half);
  ASSERT_TRUE(upright.model.target);
  EXPECT_LT((cornerOf(*upright.model.target, 1, 1) - Vector3(1, 0, -1)).norm(), 1e-15);
  EXPECT_DOUBLE_EQ(upright.model.foldAngles.at({0, 1}), -90 * kDegree);
  // Given angles count. Letters of a folded form do not define its folds.
  const json zero = {{"edges_foldAngle", {0, 0, 0, 0, 0, 0, 0}}};
  EXPECT_EQ(readText(edited(twoSquares(), zero).dump()).messages,
            "@/a.fold: warning: 1 edge has a letter (M or V) and the angle 0, so nothing folds; "
            "remove edges_foldAngle to fold by the letters");
  EXPECT_EQ(readText(edited(twoSquares(), zero).dump(), half).messages,
            "@/a.fold: error: `fold` is given, but no edge has a letter (M or V) without an angle; "
            "remove `fold`, or the angles from the file");
  const json folded = edited(twoSquares(), {{"frame_classes", {"foldedForm"}}});
  EXPECT_FALSE(readText(folded.dump()).model.target);
  EXPECT_TRUE(readText(folded.dump()).model.foldAngles.empty());
}

/// Moved in space: corners and folds.
json turned(json file, const Matrix3& turn) {
  for (json& place : file["vertices_coords"]) {
    const Vector3 point = turn * Vector3(place[0].get<double>(), place[1].get<double>(),
                                         place.size() > 2 ? place[2].get<double>() : 0.0);
    place = {point.x(), point.y(), point.z()};
  }
  return file;
}

TEST(FoldFile, FoldsSheetsInAnyPlane) {
  json file = edited(twoSquares(), {{"edges_foldAngle", {0, 70, 0, 0, 0, 0, 0}}});
  // With clockwise faces the upper side is below, and so is the valley.
  json clockwise = file;
  for (json& face : clockwise["faces_vertices"]) std::reverse(face.begin(), face.end());
  const Matrix3 upright = (Matrix3() << 1, 0, 0, 0, 0, 1, 0, -1, 0).finished();
  const Matrix3 below = (Matrix3() << 1, 0, 0, 0, -1, 0, 0, 0, -1).finished();
  for (const json& sheet : {file, clockwise}) {
    const model::Model flat = readText(sheet.dump()).model;
    EXPECT_GT(cornerOf(*flat.target, 1, 1).z() * (sheet == file ? 1 : -1), 0.9);
    const Matrix3 tilted = rotationFromVector(Vector3(0.3, 2, -1)).toRotationMatrix();
    for (const Matrix3& turn : {upright, below, tilted}) {
      const ReadSheet read = readText(turned(sheet, turn).dump());
      ASSERT_TRUE(read.model.target) << read.messages;
      const model::Model inOrder = model::inFileOrder(read.model);
      const model::Model flatInOrder = model::inFileOrder(flat);
      for (int tile = 0; tile < 2; ++tile) {
        for (int k = 0; k < 4; ++k) {
          const Vector3 expected = turn * cornerOf(*flatInOrder.target, tile, k);
          EXPECT_LT((cornerOf(*inOrder.target, tile, k) - expected).norm(), 1e-14);
        }
      }
      EXPECT_EQ(json::parse(formats::foldText(read.model))["frame_classes"][0], "creasePattern");
      // Without its own edges the file gets the same angle. With other angles, corners differ in
      // the last bit and are not one vertex.
      if (turn == tilted) continue;
      model::Model bare = read.model;
      bare.drawing.reset();
      bare.foldAngles.clear();
      const json written = json::parse(formats::foldText(bare));
      const auto letter = std::ranges::find(written["edges_assignment"], json("V"));
      ASSERT_NE(letter, written["edges_assignment"].end());
      EXPECT_NEAR(
          written["edges_foldAngle"][letter - written["edges_assignment"].begin()].get<double>(),
          70, 1e-12);
    }
  }
}

TEST(FoldFile, TakesFlatFoldedFormsAsTheyAre) {
  // The second square lies on the first.
  const json file = edited(
      twoSquares(), {{"vertices_coords", json::parse("[[0,0],[1,0],[0,0],[0,1],[1,1],[0,1]]")},
                     {"frame_classes", {"foldedForm"}},
                     {"edges_foldAngle", {0, 180, 0, 0, 0, 0, 0}}});
  const ReadSheet sheet = readText(file.dump());
  EXPECT_FALSE(sheet.model.target);
  const json again = json::parse(formats::foldText(sheet.model));
  EXPECT_EQ(again["frame_classes"][0], "foldedForm");
  EXPECT_EQ(again["edges_foldAngle"][1], 180);
}

// As in a published example: angles of 90 degrees cannot describe a flat sheet.
TEST(FoldFile, TakesFlatFoldedFormsWithOtherAnglesAsPatterns) {
  const json file = edited(twoSquares(), {{"frame_classes", {"foldedForm"}},
                                          {"edges_foldAngle", {0, 90, 0, 0, 0, 0, 0}}});
  const ReadSheet sheet = readText(file.dump());
  EXPECT_EQ(sheet.messages,
            "@/a.fold: warning: the frame is a foldedForm, but flat and with fold angles; it is "
            "read as a creasePattern");
  ASSERT_TRUE(sheet.model.target);
  EXPECT_LT((cornerOf(*sheet.model.target, 1, 1) - Vector3(1, 0, 1)).norm(), 1e-15);
}

TEST(FoldFile, StatesOfOneSheetAreTargetsInTurn) {
  json file = twoSquares();
  const auto state = [](double x, double z) {
    return json{{"frame_inherit", true},
                {"frame_parent", 0},
                {"vertices_coords",
                 {{0, 0, 0}, {1, 0, 0}, {1 + x, 0, z}, {1 + x, 1, z}, {1, 1, 0}, {0, 1, 0}}}};
  };
  file["file_frames"] = {state(0.6, 0.8), state(0, 1), state(0.8, 0.6)};
  const ReadSheet sheet = readText(file.dump());
  EXPECT_EQ(
      sheet.messages,
      "@/a.fold: warning: of frames 0-3, frame 0 is the start, frames 1, 2, 3 are targets one "
      "after the other; `frame = N` reads frame N only");
  ASSERT_EQ(sheet.model.waypoints.size(), 2U);
  EXPECT_EQ(cornerOf(sheet.model.waypoints[0], 1, 1), Vector3(1.6, 0, 0.8));
  EXPECT_EQ(cornerOf(sheet.model.waypoints[1], 1, 1), Vector3(1, 0, 1));
  EXPECT_EQ(cornerOf(*sheet.model.target, 1, 1), Vector3(1.8, 0, 0.6));
  // Written again, they are the same.
  const ReadSheet again = readText(formats::foldText(sheet.model));
  ASSERT_EQ(again.model.waypoints.size(), 2U);
  EXPECT_EQ(cornerOf(again.model.waypoints[1], 1, 1), Vector3(1, 0, 1));
  formats::ReadSettings one;
  one.frame = 2;
  const ReadSheet second = readText(file.dump(), one);
  EXPECT_EQ(cornerOf(second.model.tiles, 1, 1), Vector3(1, 0, 1));
  EXPECT_FALSE(second.model.target);
  one.frame = 4;
  EXPECT_EQ(readText(file.dump(), one).messages,
            "@/a.fold: error: there are frames 0-3, not frame 4; correct `frame`");
}

/// A frame that folds the sheet of frame 0 by angles.
json foldedBy(const json& angles, const char* key = "edges_foldAngle") {
  return {{"frame_inherit", true}, {"frame_parent", 0}, {key, angles}};
}

// The second square at 60, 120 and -90 degrees. The oracle is its rotation about the edge.
TEST(FoldFile, FramesWithAnglesAreTargetsInTurn) {
  const auto expectFolded = [](const std::vector<model::Tile>& tiles, double degrees) {
    const Vector3 expected(1 + std::cos(degrees * kDegree), 0, std::sin(degrees * kDegree));
    EXPECT_LT((cornerOf(tiles, 1, 1) - expected).norm(), 1e-15) << degrees;  // measured 2.5e-16
    EXPECT_LT((cornerOf(tiles, 0, 1) - Vector3(1, 0, 0)).norm(), 1e-15);
  };
  json file = twoSquares();
  file["file_frames"] = {foldedBy({0, 60, 0, 0, 0, 0, 0}),
                         foldedBy({nullptr, 120, 0, 0, 0, 0, 0}, "edges_foldAngles"),
                         foldedBy({0, -90, 0, 0, 0, 0, 0})};
  const ReadSheet sheet = readText(file.dump());
  EXPECT_EQ(
      sheet.messages,
      "@/a.fold: warning: of frames 0-3, frame 0 is the start, frames 1, 2, 3 are targets one "
      "after the other; `frame = N` reads frame N only");
  ASSERT_EQ(sheet.model.waypoints.size(), 2U);
  expectFolded(sheet.model.waypoints[0], 60);
  expectFolded(sheet.model.waypoints[1], 120);
  expectFolded(*sheet.model.target, -90);
  // Written again, the frames have the same angles and no coordinates.
  const json again = json::parse(formats::foldText(sheet.model));
  ASSERT_EQ(again["file_frames"].size(), 3U);
  EXPECT_FALSE(again.contains("edges_foldAngle"));
  for (std::size_t k = 0; k < 3; ++k) {
    const json& frame = again["file_frames"][k];
    EXPECT_FALSE(frame.contains("vertices_coords"));
    EXPECT_EQ(frame["edges_foldAngle"],
              file["file_frames"][k].value("edges_foldAngle", json{nullptr, 120, 0, 0, 0, 0, 0}));
  }
  EXPECT_EQ(json::parse(formats::foldText(readText(again.dump()).model)), again);
  // The angles of frame 0 fold it before the others, unless they are 0. States with coordinates may
  // be among them.
  file["edges_foldAngle"] = {0, 30, 0, 0, 0, 0, 0};
  file["file_frames"][1] = {
      {"frame_inherit", true},
      {"vertices_coords", {{0, 0, 0}, {1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}, {0, 1, 0}}}};
  const ReadSheet mixed = readText(file.dump());
  ASSERT_EQ(mixed.model.waypoints.size(), 3U);
  for (const auto& [state, degrees] : {std::pair{0, 30.0}, {1, 60.0}, {2, 90.0}}) {
    expectFolded(mixed.model.waypoints[static_cast<std::size_t>(state)], degrees);
  }
  expectFolded(*mixed.model.target, -90);
  const json kept = json::parse(formats::foldText(mixed.model));
  ASSERT_EQ(kept["file_frames"].size(), 3U);
  EXPECT_EQ(kept["edges_foldAngle"], file["edges_foldAngle"]);
  EXPECT_EQ(readText(kept.dump()).model.waypoints.size(), 3U);
}

TEST(FoldFile, FramesWithAnglesNeedAFlatStartAndAnglesThatFit) {
  json file = twoSquares();
  file["vertices_coords"] = json::parse("[[0,0],[1,0],[1,0,1],[1,1,1],[1,1],[0,1]]");
  file["file_frames"] = {foldedBy({0, 60, 0, 0, 0, 0, 0})};
  EXPECT_EQ(readText(file.dump()).messages,
            "@/a.fold: warning: 1 frame is not read, because fold angles need a flat start");
  file["file_frames"] = {foldedBy({0, 60})};
  EXPECT_EQ(readText(file.dump()).messages,
            "@/a.fold: error: edges_foldAngle is [0,60], but 7 edges need as many angles. Correct "
            "or delete it");
}

// One line per kind, for any number of frames.
TEST(FoldFile, ChainsHaveOneWarningOfEachKind) {
  json file =
      json::parse(R"({"vertices_coords": [[0,0],[1,0],[2,0],[0,1],[1,1],[2,1],[0,2],[1,2],[2,2]],
      "faces_vertices": [[0,1,4,3],[1,2,5,4],[3,4,7,6],[4,5,8,7]],
      "edges_vertices": [[1,4],[4,7],[3,4],[4,5]], "edges_assignment": ["V","V","V","V"]})");
  const auto messagesWith = [&](const json& frames) {
    file["file_frames"] = frames;
    const std::string messages = readText(file.dump()).messages;
    return messages.substr(messages.rfind("@/"));  // after the line about frames
  };
  json frames = {foldedBy({10, 10, 0, 0}), foldedBy({90, 0, 0, 0}), foldedBy({0, 60, 0, 0})};
  EXPECT_THAT(messagesWith(frames),
              testing::MatchesRegex("@/a.fold: warning: the fold angles of 2 frames \\(first: 2\\) "
                                    "would open joints by up to .* \\(the file's unit\\). These "
                                    "frames are not read"));
  frames.erase(2);
  EXPECT_THAT(messagesWith(frames),
              testing::HasSubstr("the fold angles of frame 2 would open joints"));
  file["file_frames"] = json(9, foldedBy({10, 10, 0, 0}));
  EXPECT_THAT(readText(file.dump()).messages, testing::HasSubstr("frames 1-9 are targets"));
  json stretched = json::array();
  for (const double length : {1.0, 1.001, 1.002}) {
    json places = file["vertices_coords"];
    for (const int corner : {2, 5, 8}) places[corner][0] = 1 + length;
    stretched.push_back({{"frame_inherit", true}, {"vertices_coords", places}});
  }
  EXPECT_EQ(messagesWith(stretched),
            "@/a.fold: warning: 4 target tiles have slightly different shapes in 2 of 3 targets. "
            "Here a length differs most, by 0.002. Rigid tiles can only come near these targets");
}

// Four squares around a vertex, cut from the side to the middle: the sides of the cut are one edge
// in the file and separate when the sheet folds.
TEST(FoldFile, SidesOfOpenCutsGetTheirOwnVertices) {
  const json file = json::parse(
      R"({"file_spec": 1.1, "vertices_coords": [[0,0],[1,0],[2,0],[0,1],[1,1],[2,1],[0,2],[1,2],[2,2]],
      "faces_vertices": [[0,1,4,3],[1,2,5,4],[3,4,7,6],[4,5,8,7]],
      "edges_vertices": [[1,4],[0,1],[1,2],[2,5],[5,8],[8,7],[7,6],[6,3],[3,0],[4,7],[3,4],[4,5]],
      "edges_assignment": ["C","B","B","B","B","B","B","B","B","F","V","F"],
      "edges_foldAngle": [0,0,0,0,0,0,0,0,0,0,90,0]})");
  const model::Model model = readText(file.dump()).model;
  ASSERT_TRUE(model.target);
  // Converting keeps the vertices: the angles give the target.
  const json kept = json::parse(formats::foldText(model));
  for (const char* key : {"edges_vertices", "edges_assignment", "edges_foldAngle"}) {
    EXPECT_EQ(kept[key], file[key]) << key;
  }
  EXPECT_EQ(kept["vertices_coords"].size(), 9U);
  EXPECT_FALSE(kept.contains("file_frames"));
  // A run moves only the first square: vertex 1 gets another vertex, edge 0 another edge.
  const json run =
      json::parse(formats::foldText(model, {{"t = 0 s", {}}, {"t = 1 s", *model.target}}));
  ASSERT_EQ(run["vertices_coords"].size(), 10U);
  ASSERT_EQ(run["edges_vertices"].size(), 13U);
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_EQ(run["edges_assignment"][k], file["edges_assignment"][k]);
    EXPECT_EQ(run["edges_foldAngle"][k], file["edges_foldAngle"][k]);
  }
  EXPECT_EQ(run["edges_vertices"][12], json({9, 4}));
  EXPECT_EQ(run["edges_assignment"][12], "C");
  const model::Model again = readText(run.dump()).model;
  ASSERT_EQ(again.joints.size(), model.joints.size());
  for (int tile = 0; tile < 4; ++tile) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(cornerOf(again.tiles, tile, k), cornerOf(model.tiles, tile, k));
      EXPECT_EQ(cornerOf(*again.target, tile, k), cornerOf(*model.target, tile, k));
    }
  }
}

// A series of Origami Simulator: frame 0 has only data that the others inherit.
TEST(FoldFile, SeriesMayHaveNoCoordinatesInFrame0) {
  json file = twoSquares();
  const json places = file["vertices_coords"];
  file.erase("vertices_coords");
  json folded = places;
  for (std::size_t k : {2, 3}) folded[k] = {1, places[k][1], 1};
  for (const json& state : {places, folded}) {
    file["file_frames"].push_back({{"frame_inherit", true}, {"vertices_coords", state}});
  }
  const ReadSheet sheet = readText(file.dump());
  EXPECT_EQ(sheet.messages, "");
  ASSERT_TRUE(sheet.model.target);
  EXPECT_EQ(cornerOf(*sheet.model.target, 1, 1), Vector3(1, 0, 1));
}

TEST(FoldFile, IndependentFramesAreIndependentModels) {
  json file = edited(twoSquares(), {{"edges_foldAngle", {0, 90, 0, 0, 0, 0, 0}}});
  file["file_frames"] = json::parse(R"([
      {"frame_classes": ["graph"], "vertices_coords": [[5,5],[6,5]], "edges_vertices": [[0,1]]},
      {"vertices_coords": [[0,0],[1,0],[0,1]], "faces_vertices": [[0,1,2]]},
      {"frame_inherit": true, "frame_parent": 2, "frame_title": "the same triangle"}])");
  const ReadSheet sheet = readText(file.dump());
  EXPECT_EQ(sheet.messages,
            "@/a.fold: warning: of frames 0-3, frame 0 is the start, and 3 others are not read; "
            "`frame = N` reads frame N only");
  EXPECT_EQ(sheet.model.tiles.size(), 2U);
  EXPECT_TRUE(sheet.model.target);
  formats::ReadSettings settings;
  for (const int frame : {2, 3}) {
    settings.frame = frame;
    EXPECT_EQ(readText(file.dump(), settings).model.tiles.size(), 1U) << frame;
  }
  settings.frame = 1;
  EXPECT_EQ(readText(file.dump(), settings).messages,
            "@/a.fold: error: the edges enclose no face. Close the outline of the sheet, or add "
            "faces_vertices");
  file["file_frames"][2]["frame_parent"] = 3;
  EXPECT_EQ(readText(file.dump()).messages,
            "@/a.fold: error: frame 3 inherits from itself. Correct frame_parent");
  file["file_frames"][2]["frame_parent"] = 9;
  EXPECT_EQ(
      readText(file.dump()).messages,
      "@/a.fold: error: frame 3 has the frame_parent 9, but there are frames 0-3; correct it");
}

TEST(FoldFile, SlitsAndRepeatedVerticesMoveNothing) {
  // A slit from the middle of a side to the middle of the square, and a corner listed twice.
  const ReadSheet slit = readText(R"({"vertices_coords": [[0,0],[2,0],[2,2],[1,2],[0,2],[1,1]],
      "faces_vertices": [[0,1,1,2,3,5,3,4]]})");
  EXPECT_EQ(slit.messages, "");
  ASSERT_EQ(slit.model.tiles.size(), 1U);
  EXPECT_EQ(slit.model.tiles[0].vertices.size(), 5U);
  // A slit with a bend, and a branch.
  EXPECT_EQ(formats::faceOutline({0, 1, 2, 7, 8, 7, 9, 7, 2, 3}), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(formats::faceOutline({7, 0, 1, 2, 3, 0}), (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(formats::faceOutline({0, 1, 2, 0}), (std::vector<int>{0, 1, 2}));
}

/// A grid of quads with moved corners, some cut to two triangles.
struct RandomDrawing {
  std::vector<Vector3> points;
  formats::CornerNumbers faces;
  std::vector<model::Crease> edges;
};

RandomDrawing randomDrawing(unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&](double most) { return most * (random() / 4294967296.0); };
  RandomDrawing drawing;
  const int columns = 2 + static_cast<int>(number(5)), rows = 2 + static_cast<int>(number(5));
  const Vector3 turn(number(3), number(3), number(3));
  // Some are flat, some are rotated in space. The side from which faces are anticlockwise is known.
  const bool isTurned = seed % 2 == 1;
  for (int y = 0; y <= rows; ++y) {
    for (int x = 0; x <= columns; ++x) {
      const Vector3 place(x + number(0.3), y + number(0.3), 0);
      drawing.points.push_back(isTurned ? rotationFromVector(turn) * place : place);
    }
  }
  std::set<std::pair<int, int>> edges;
  const auto add = [&](const std::vector<int>& face) {
    drawing.faces.push_back(face);
    for (std::size_t k = 0; k < face.size(); ++k) {
      edges.insert(std::minmax(face[k], face[(k + 1) % face.size()]));
    }
  };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const int a = y * (columns + 1) + x, b = a + 1, c = b + columns + 1, d = c - 1;
      if (number(1) < 0.5) {
        add({a, b, c, d});
      } else {
        add({a, b, c});
        add({a, c, d});
      }
    }
  }
  for (const auto& [from, to] : edges) drawing.edges.push_back({from, to});
  std::shuffle(drawing.edges.begin(), drawing.edges.end(), random);
  return drawing;
}

/// Each face from its lowest vertex, all sorted.
std::set<std::vector<int>> cyclesOf(const formats::CornerNumbers& faces, bool isReversed) {
  std::set<std::vector<int>> cycles;
  for (std::vector<int> face : faces) {
    if (isReversed) std::ranges::reverse(face);
    std::ranges::rotate(face, std::ranges::min_element(face));
    cycles.insert(face);
  }
  return cycles;
}

TEST(FoldFile, FindsTheFacesOfDrawings) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const RandomDrawing drawing = randomDrawing(seed);
    const formats::CornerNumbers found =
        formats::planarFaces(drawing.points, drawing.edges, "a.fold");
    const auto cycles = cyclesOf(found, false);
    EXPECT_EQ(found.size(), drawing.faces.size()) << seed;
    // A sheet that faces down is seen from its other side.
    EXPECT_TRUE(cycles == cyclesOf(drawing.faces, false) ||
                (seed % 2 == 1 && cycles == cyclesOf(drawing.faces, true)))
        << seed;
  }
}

TEST(FoldFile, FindsHolesByBoundaries) {
  // A square ring of four quads; its inside is a hole if its edges are boundaries.
  json ring = json::parse(R"({"vertices_coords": [[0,0],[3,0],[3,3],[0,3],[1,1],[2,1],[2,2],[1,2]],
      "edges_vertices": [[0,1],[1,2],[2,3],[3,0],[4,5],[5,6],[6,7],[7,4],[0,4],[1,5],[2,6],[3,7]],
      "edges_assignment": ["B","B","B","B","B","B","B","B","F","F","F","F"]})");
  EXPECT_EQ(readText(ring.dump()).model.tiles.size(), 4U);
  for (int k = 4; k < 8; ++k) ring["edges_assignment"][k] = "C";
  EXPECT_EQ(readText(ring.dump()).model.tiles.size(), 5U);
  ring.erase("edges_assignment");
  EXPECT_EQ(readText(ring.dump()).model.tiles.size(), 5U);
  // Unconnected, the inner square would make a hole in a tile.
  for (int k = 0; k < 4; ++k) ring["edges_vertices"].erase(8);
  EXPECT_EQ(readText(ring.dump()).messages,
            "@/a.fold: error: the face at vertex 0 has a separate drawing inside, at vertex 4. "
            "Tiles cannot have holes. Connect the two by an edge, or add faces_vertices");
  ring["edges_vertices"] = json::parse("[[0,1],[1,2],[2,3],[3,0],[0,2],[1,3]]");
  EXPECT_EQ(readText(ring.dump()).messages,
            "@/a.fold: error: edges 4 and 5 cross without a common vertex, and faces_vertices is "
            "missing. Split the edges at a common vertex");
  ring["vertices_coords"][4] = {1.5, 0};
  ring["edges_vertices"] = json::parse("[[0,1],[1,2],[2,3],[3,0],[4,2]]");
  EXPECT_EQ(readText(ring.dump()).messages,
            "@/a.fold: error: edges 0 and 4 touch without a common vertex, and faces_vertices is "
            "missing. Split the edges at a common vertex");
}

TEST(FoldFile, TakesFacesAndEdgesInOtherWords) {
  json file = twoSquares();
  file.erase("faces_vertices");
  const ReadSheet found = readText(file.dump());
  EXPECT_EQ(found.model.tiles.size(), 2U);
  EXPECT_EQ(found.model.joints.size(), 2U);
  file["faces_edges"] = json::parse("[[0,1,2,3],[4,5,6,1]]");
  EXPECT_EQ(readText(file.dump()).model.tiles.size(), 2U);
  file["faces_edges"] = json::parse("[[0,5,2,3]]");
  EXPECT_EQ(readText(file.dump()).messages,
            "@/a.fold: error: face 0 has the consecutive edges 0 and 5, which have no common "
            "vertex. Correct faces_edges, or write faces_vertices");
  for (const char* key : {"faces_edges", "edges_vertices", "edges_assignment"}) file.erase(key);
  file["vertices_vertices"] = json::parse("[[1,5],[0,2,4],[1,3],[2,4],[1,3,5],[0,4]]");
  EXPECT_EQ(readText(file.dump()).model.tiles.size(), 2U);
}

TEST(FoldFile, CountsWhatIsNotRead) {
  const json file = edited(twoSquares(), {{"edges_foldAngle", {0, 90, 0, 0, 0, 0, 0}},
                                          {"faceOrders", {{0, 1, 1}}},
                                          {"other:key", 3},
                                          {"faces_colors", {1, 2}},
                                          {"edges_length", {1, 1, 1, 1, 1, 1, 1}}});
  EXPECT_EQ(
      readText(file.dump()).messages,
      "@/a.fold: warning: not read: the order of layers in faceOrders, 2 keys of other programs "
      "(faces_colors, other:key)");
}

TEST(FoldFile, CountsEdgesOfNoFace) {
  // One edge inside a face, and one that leaves the sheet.
  json file = json::parse(R"({"vertices_coords": [[0,0],[1,0],[1,1],[0,1],[2,2]],
      "edges_vertices": [[0,1],[1,2],[2,3],[3,0],[0,2],[2,4]],
      "edges_assignment": ["B","B","B","B","F","F"], "edges_foldAngle": [0,0,0,0,0,0],
      "faces_vertices": [[0,1,2,3]]})");
  const ReadSheet read = readText(file.dump());
  EXPECT_EQ(read.messages,
            "@/a.fold: warning: 2 edges are sides of no face and are not read, edge 4 is the "
            "first; split the faces there, or delete the edges");
  EXPECT_EQ(read.model.tiles.size(), 1U);
  // A fold within a face moves nothing.
  json folded = file;
  folded["edges_assignment"][4] = "V";
  folded["edges_foldAngle"][4] = 90;
  EXPECT_FALSE(readText(folded.dump()).model.target);
  for (const char* key : {"edges_vertices", "edges_assignment", "edges_foldAngle"}) {
    file[key].erase(5);
  }
  file["faces_vertices"] = json::parse("[[0,1,2],[0,2,3]]");
  EXPECT_EQ(readText(file.dump()).messages, "");
}

TEST(FoldFile, CountsFoldsAtTheBorderAndLettersAgainstAngles) {
  json file = twoSquares();
  file["edges_assignment"][4] = "M";
  file["edges_foldAngle"] = {0, -90, 0, 0, 0, 0, 0};
  const std::string messages = readText(file.dump()).messages;
  EXPECT_THAT(messages,
              testing::HasSubstr("@/a.fold: warning: 1 fold (M or V) has a face on one side "
                                 "only and does not fold, edge 4 is the first; draw the border of "
                                 "the sheet (B) around them"));
  EXPECT_THAT(messages,
              testing::HasSubstr("@/a.fold: warning: 1 edge has a letter (M or V) against the sign "
                                 "of its angle, which decides, edge 1 is the first; a mountain has "
                                 "an angle < 0, a valley > 0"));
  file = edited(twoSquares(), {{"edges_foldAngle", {0, 90, 0, 0, 0, 0, 0}}});
  EXPECT_EQ(readText(file.dump()).messages, "");
}

TEST(FoldFile, KeepsTitlesAuthorAndDescriptions) {
  const json texts = {{"file_title", "Miura"},
                      {"file_author", "A. B."},
                      {"file_description", "two\nlines"},
                      {"frame_title", "flat"},
                      {"frame_description", "\u00fc"}};
  const TemporaryFolder folder;
  folder.write("a.fold", edited(twoSquares(), texts).dump());
  std::vector<std::string> warnings;
  formats::writeModel(formats::readModel(folder.path() / "a.fold", {}, warnings),
                      folder.path() / "b.fold");
  const json written = json::parse(readTextFile(folder.path() / "b.fold", ""));
  for (const auto& [key, text] : texts.items()) EXPECT_EQ(written.value(key, json()), text) << key;
}

TEST(FoldFile, KeepsVerticesEdgesLettersAndAngles) {
  json slit = json::parse(R"({"vertices_coords": [[0,0],[2,0],[2,2],[1,2],[0,2],[1,1],[9,9]],
      "faces_vertices": [[0,1,2,3,5,3,4]], "edges_vertices": [[2,1],[0,1],[2,3],[3,5],[3,4],[4,0]],
      "edges_assignment": ["B","B","B","C","B","B"]})");
  json joined = twoSquares();
  joined["edges_assignment"][1] = "J";
  json angles = edited(twoSquares(), {{"edges_foldAngle", {nullptr, 33.3, 0, 0, 0, 0, 0}}});
  json turned = angles;
  turned["faces_vertices"] = json::parse("[[5,4,1,0],[1,2,3,4]]");
  json edges = angles;
  edges.erase("faces_vertices");
  for (const json& file : {slit, joined, twoSquares(), angles, turned, edges}) {
    const model::Model model = readText(file.dump()).model;
    const json again = json::parse(formats::foldText(model));
    ASSERT_EQ(again["vertices_coords"].size(), file["vertices_coords"].size());
    for (std::size_t k = 0; k < file["vertices_coords"].size(); ++k) {
      for (std::size_t axis = 0; axis < 2; ++axis) {
        EXPECT_EQ(again["vertices_coords"][k][axis].get<double>(),
                  file["vertices_coords"][k][axis].get<double>());
      }
    }
    for (const char* key :
         {"edges_vertices", "edges_assignment", "edges_foldAngle", "faces_vertices"}) {
      if (file.contains(key) || again.contains(key) != (std::string(key) == "faces_vertices")) {
        EXPECT_EQ(again.value(key, json()), file.value(key, json())) << key;
      }
    }
    const model::Model second = readText(again.dump()).model;
    EXPECT_EQ(second.tiles.size(), model.tiles.size());
    EXPECT_EQ(second.joints.size(), model.joints.size());
    EXPECT_EQ(second.target.has_value(), model.target.has_value());
    EXPECT_EQ(second.foldAngles, model.foldAngles);
  }
}

TEST(FoldFile, TargetsGiveLettersTheirAngles) {
  json file = twoSquares();
  file["edges_assignment"][1] = "M";
  file["file_frames"] = {
      {{"frame_inherit", true},
       {"vertices_coords", {{0, 0, 0}, {1, 0, 0}, {1, 0, -1}, {1, 1, -1}, {1, 1, 0}, {0, 1, 0}}}}};
  const model::Model model = readText(file.dump()).model;
  EXPECT_DOUBLE_EQ(model.foldAngles.at({0, 1}), -90 * kDegree);
  const json again = json::parse(formats::foldText(model));
  EXPECT_EQ(again["edges_assignment"], file["edges_assignment"]);
  // The file has no angles, but its target has.
  EXPECT_DOUBLE_EQ(again["edges_foldAngle"][1].get<double>(), -90);
  EXPECT_EQ(readText(again.dump()).model.foldAngles, model.foldAngles);
  // An option that chooses an angle writes it.
  file.erase("file_frames");
  formats::ReadSettings half;
  half.fold = 0.25;
  EXPECT_EQ(json::parse(formats::foldText(readText(file.dump(), half).model))["edges_foldAngle"][1],
            -45);
}

TEST(FoldFile, StatesOfARunKeepTheModel) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 2;
  model::Model model = generate::makeTessellation(shape);
  const std::vector<model::Tile> open = generate::tessellationTiles(shape, 0.9);
  model.joints.push_back(model::makeLink(model.tiles, {0, 0}, {3, 2}));
  model.joints.push_back(model::makeFixedJoint(model.tiles, 0, 1));
  model.pulledTiles = std::vector<int>{1};
  model.foldAngles = {{{0, 1}, 0.5}, {{1, 0}, 0.5}};
  const std::string text = formats::foldText(model, {{"t = 0 s", {}}, {"t = 1.5 s", open}});
  const json fold = json::parse(text);
  // Sixteen corners, four joints.
  EXPECT_EQ(fold["vertices_coords"].size(), 12U);
  EXPECT_EQ(fold["edges_vertices"].size(), 16U);
  ASSERT_EQ(fold["file_frames"].size(), 1U);
  EXPECT_EQ(fold["file_frames"][0]["frame_title"], "t = 1.5 s");
  for (std::size_t t = 0; t < 4; ++t) {
    for (std::size_t k = 0; k < 4; ++k) {
      const int vertex = fold["faces_vertices"][t][k].get<int>();
      const std::vector<double> at = fold["file_frames"][0]["vertices_coords"][vertex];
      // Measured: 2e-16.
      EXPECT_LT((Vector3(at[0], at[1], at[2]) - open[t].vertices[k]).norm(), 1e-14);
    }
  }
  const model::Model again = readText(text).model;
  ASSERT_EQ(again.target.has_value(), model.target.has_value());
  for (std::size_t t = 0; t < 4; ++t) {
    EXPECT_EQ(again.tiles[t].vertices, model.tiles[t].vertices);
    ASSERT_TRUE(model.target);
    EXPECT_EQ((*again.target)[t].vertices, (*model.target)[t].vertices);
  }
  ASSERT_EQ(again.joints.size(), model.joints.size());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    EXPECT_EQ(again.joints[k].kind, model.joints[k].kind);
    EXPECT_EQ(again.joints[k].a, model.joints[k].a);
    EXPECT_EQ(again.joints[k].face, model.joints[k].face);
  }
  EXPECT_EQ(again.pulledTiles, model.pulledTiles);
}

// ------------------------------------------------------------------------------------------------
// Meshes as people write them.

std::string twoTriangles(const std::string& faces) {
  return "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n" + faces;
}

TEST(MeshFile, TakesObjAsPeopleWriteIt) {
  for (const char* faces :
       {"f 1 2 3 4\nf 2 5 6 3\n", "f 1 2 \\\n 3 4\nf 2 5\\\n\\\n 6 3\n",
        "f 1 2 3 4 # tile\nf 2 5 6 3# tile\n", "f 1/1 2/2 3/3 4/4\r\nf 2//1 5//1 6//1 3//1\r\n",
        "f 1 2 3 4 1\nf 2 5 6 3 NaN\n", "f 1 2 3 4 4 4\nf 2 2 5 6 3 nan NaN\n",
        "# a comment \\\nf 1 2 3 4\nfo 2 5 6 3\n"}) {
    const ReadSheet sheet = readText(twoTriangles(faces), {}, "a.obj");
    ASSERT_EQ(sheet.model.tiles.size(), 2U) << faces << sheet.messages;
    EXPECT_EQ(sheet.model.tiles[1].vertices.size(), 4U) << faces;
    EXPECT_EQ(sheet.model.joints.size(), 2U) << faces;
  }
  const ReadSheet fortran = readText(
      "v 0.0D+00 0 0\nv +1.0D+00 0 0\nv 1.0d0 10.0D-01 0\nv NaN NaN NaN\nf 1 2 3 4\n", {}, "a.obj");
  ASSERT_EQ(fortran.model.tiles.size(), 1U) << fortran.messages;
  EXPECT_EQ(fortran.model.tiles[0].vertices[2], Vector3(1, 1, 0));
  EXPECT_EQ(
      fortran.messages,
      "@/a.obj:5: repaired: in 1 of 1 tiles a vertex is listed again, or NaN in place of one; "
      "removed as padding");
}

// Tiles in objects, as a program writes that numbers the vertices of each object again. Corners of
// an open tessellation coincide only where they are joined.
TEST(MeshFile, JoinsObjectsAtCommonCorners) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 4;
  shape.startAngle = 0.6;
  model::Model sheet = generate::makeTessellation(shape);
  sheet.target.reset();
  std::mt19937 draw(3);
  for (const int objects : {1, 2, 5, 16}) {
    std::string text;
    int count = 0;
    std::vector<std::map<std::array<double, 3>, int>> known(static_cast<std::size_t>(objects));
    for (std::size_t tile = 0; tile < sheet.tiles.size(); ++tile) {
      // 16: one object per tile.
      const std::size_t object = objects == 16 ? tile : draw() % static_cast<unsigned>(objects);
      std::string face = "f";
      for (const Vector3& p : sheet.tiles[tile].vertices) {
        const std::array<double, 3> key = {std::round(1e6 * p.x()), std::round(1e6 * p.y()), 0};
        const auto [at, isNew] = known[object].emplace(key, count + 1);
        if (isNew) ++count;
        if (isNew) text += fmt::format("v {:.9f} {:.9f} 0\n", p.x(), p.y());
        face += fmt::format(" {}", at->second);
      }
      text += face + "\n";
    }
    const ReadSheet read = readText(text, {}, "a.obj");
    EXPECT_EQ(joinedCorners(read.model).numbers(), joinedCorners(sheet).numbers()) << read.messages;
  }
}

// Every format that convert writes.
TEST(RoundTrips, KeepTheUnit) {
  model::Model sheet = generate::makeTessellation({});
  sheet.unit = *findLengthUnit("mm");
  const TemporaryFolder folder;
  for (const char* name : {"sheet", "sheet.obj", "sheet.fold", "sheet_vertices.txt"}) {
    formats::writeModel(sheet, folder / name);
    std::vector<std::string> warnings;
    const model::Model again = formats::readModel(folder / name, std::nullopt, warnings);
    EXPECT_EQ(again.unit, sheet.unit) << name;
    EXPECT_NEAR(model::modelSize(again) / model::modelSize(sheet), 1, 1e-12) << name;
  }
}

TEST(MeshFile, ReportsOtherContentOfObj) {
  EXPECT_EQ(
      readText(twoTriangles("f 1 2 3 4\nl 1 2\nl 2 3\np 1\ng a\nusemtl b\n"), {}, "a.obj").messages,
      "@/a.obj: warning: ignored statements: l (2), p (1)");
  EXPECT_EQ(readText(twoTriangles("f 1 2 \\\n 3 9\n"), {}, "a.obj").messages,
            "@/a.obj:8:4: error: there are only vertices 1-6 before this line, not 9; correct this "
            "number, or move the face below its vertices");
  // Keywords may be capitals.
  EXPECT_EQ(readText("V 0 0 0\nV 1 0 0\nV 1 1 0\nF 1 2 3\n", {}, "a.obj").model.tiles.size(), 1U);
  EXPECT_EQ(readText(twoTriangles("f 1 2 2 1 NaN\n"), {}, "a.obj").messages,
            "@/a.obj:7: error: face 0 has 2 vertices; a tile has at least 3: complete it or delete "
            "the line");
}

TEST(MeshFile, NamesTilesByGroupsAndMaterials) {
  const ReadSheet sheet =
      readText(twoTriangles("f 1 2 3\ng left side\nf 1 3 4\nusemtl steel\nf 2 5 3\ng\nf 5 6 3\n"),
               {}, "a.obj");
  EXPECT_EQ(sheet.model.tileNames,
            (std::vector<std::string>{"", "left side", "left side steel", "steel"}));
  const TemporaryFolder folder;
  formats::writeModel(sheet.model, folder.path() / "b.obj");
  std::vector<std::string> warnings;
  EXPECT_EQ(formats::readModel(folder.path() / "b.obj", std::nullopt, warnings).tileNames,
            sheet.model.tileNames);
}

TEST(MeshFile, JoinsTrianglesOfOneTile) {
  // Two squares that share a corner, of two triangles each: with shared vertices, and with none.
  const std::string shared =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n"
      "f 1 2 3\nf 1 3 4\nf 3 5 6\nf 3 6 7\n";
  std::string own, faces;
  int count = 0;
  for (const auto& triangle : {std::array{"0 0 0", "1 0 0", "1 1 0"},
                               {"0 0 0", "1 1 0", "0 1 0"},
                               {"1 1 0", "2 1 0", "2 2 0"},
                               {"1 1 0", "2 2 0", "1 2 0"}}) {
    for (const char* place : triangle) own += std::string("v ") + place + "\n";
    faces += "f " + std::to_string(count + 1) + " " + std::to_string(count + 2) + " " +
             std::to_string(count + 3) + "\n";
    count += 3;
  }
  formats::ReadSettings join;
  join.joinCoplanar = true;
  for (const std::string& text : {shared, own + faces}) {
    const ReadSheet apart = readText(text, {}, "a.obj");
    EXPECT_EQ(apart.model.tiles.size(), 4U);
    EXPECT_EQ(apart.messages,
              "@/a.obj: warning: 4 faces are probably 2 tiles cut to triangles. `join_coplanar` "
              "joins coplanar faces with a common edge");
    const ReadSheet joined = readText(text, join, "a.obj");
    EXPECT_EQ(joined.messages, "");
    ASSERT_EQ(joined.model.tiles.size(), 2U);
    EXPECT_EQ(joined.model.tiles[0].vertices.size(), 4U);
    EXPECT_EQ(joined.model.joints.size(), 1U);
  }
  EXPECT_EQ(readText(shared + "# joint 0 0 1 0 1\n", join, "a.obj").messages,
            "@/a.obj:12: error: this comment names a joint of two faces, but `join_coplanar` "
            "changes faces. Remove `join_coplanar` or these comments");
  EXPECT_EQ(readText(twoSquares().dump(), join).messages,
            "@/a.fold: error: `join_coplanar` is only for OBJ and PLY meshes. Remove it");
}

TEST(MeshFile, TakesPaddedPly) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n2.0D0 0 0\nnan nan nan\n";
  for (const char* faces :
       {"3 0 1 2\n3 1 3 2\n", "4 0 1 2 2\n4 1 3 2 -1\n", "4 0 1 2 0\n4 1 3 2 4\n"}) {
    const ReadSheet sheet = readText(head + faces, {}, "a.ply");
    ASSERT_EQ(sheet.model.tiles.size(), 2U) << faces << sheet.messages;
    EXPECT_EQ(sheet.model.tiles[1].vertices.size(), 3U);
    EXPECT_EQ(sheet.model.joints.size(), 2U);
  }
}

TEST(MeshFile, TakesPaddedFolders) {
  for (const char* padding : {"", " NaN NaN NaN", " 1.5 2 0", " 1 1 0", " 1.5 2.0 0 NaN NaN NaN"}) {
    const TemporaryFolder folder;
    folder.write("vertices.txt",
                 std::string("0 0 0 1 0 0 1 1 0 0 1 0\n1 1 0 2 1 0 1.5 2 0") + padding + "\n");
    folder.write("constraints.txt", "0 2 1 0 3\n");
    std::vector<std::string> warnings;
    const model::Model model = formats::readModel(folder.path(), std::nullopt, warnings);
    ASSERT_EQ(model.tiles.size(), 2U);
    EXPECT_EQ(model.tiles[1].vertices.size(), 3U) << padding;
    EXPECT_EQ(warnings.size(), *padding == 0 ? 0U : 1U);
  }
}

}  // namespace
}  // namespace kirireel
