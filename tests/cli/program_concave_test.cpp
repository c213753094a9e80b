// Concave tiles in the whole program: an L and a star that are joined at one corner.
//
// The star turns about the tip of the L's arm until one of its tips touches the arm. A tip at a
// right angle to the joint's is a side of sqrt(2) away from it, so the joint is then open by 135
// degrees for any motion of the two.
#include <array>
#include <cmath>
#include <numbers>
#include <sstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/picture/png.h"
#include "tests/cli/run_program.h"
#include "tests/support/png.h"
#include "tests/support/polygons.h"

namespace kirireel {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kThickness = 0.05;

/// The star's radius is 1 and its first tip is the L's corner (3, 1); `angle` is from there to its
/// centre.
std::array<model::Tile, 2> layout(double angle) {
  return {test::lShape(),
          test::starShape(4, 1, 0.45, 3 + std::cos(angle), 1 + std::sin(angle), angle + kPi)};
}

std::string textOf(const std::array<model::Tile, 2>& tiles) {
  std::string text;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& v : tile.vertices) text += fmt::format("{} {} {} ", v.x(), v.y(), v.z());
    text += "\n";
  }
  return text;
}

std::array<model::Tile, 2> tilesIn(const std::filesystem::path& file) {
  std::array<model::Tile, 2> tiles;
  std::istringstream lines(readText(file));
  std::string line;
  for (model::Tile& tile : tiles) {
    std::getline(lines, line);
    std::istringstream numbers(line);
    for (Vector3 v; numbers >> v.x() >> v.y() >> v.z();) tile.vertices.push_back(v);
  }
  return tiles;
}

/// Signed volume inside the faces of an OBJ file, by the divergence theorem, fans of triangles.
double volumeIn(const std::filesystem::path& file) {
  std::istringstream lines(readText(file));
  std::vector<Vector3> vertices;
  double volume = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Vector3& v = vertices.emplace_back();
      words >> v.x() >> v.y() >> v.z();
    } else if (word == "f") {
      std::vector<Vector3> face;
      while (words >> word) face.push_back(vertices.at(std::stoul(word) - 1));
      for (std::size_t k = 2; k < face.size(); ++k) {
        volume += face[0].dot(face[k - 1].cross(face[k])) / 6;
      }
    }
  }
  return volume;
}

/// Pixels of one half of a picture without a background that are not transparent.
int paintedIn(const picture::Frame& picture, int half) {
  int painted = 0;
  const int width = picture.size.width / 2;
  for (int y = 0; y < picture.size.height; ++y) {
    for (int x = half * width; x < (half + 1) * width; ++x) painted += picture.at(x, y).alpha > 127;
  }
  return painted;
}

/// The two, recorded towards a target with the star at this angle.
class ConcaveTiles : public testing::Test {
 protected:
  void record(double targetAngle) {
    std::filesystem::create_directory(scratch_ / "model");
    writeText(scratch_ / "model/vertices.txt", textOf(layout(0)));
    writeText(scratch_ / "model/target.txt", textOf(layout(targetAngle)));
    writeText(scratch_ / "model/constraints.txt", "0 2 1 0 3\n");
    end_ = runKirireel({"record",        (scratch_ / "model").string(),
                        "--contacts",    "all",
                        "--thickness",   fmt::format("{}", kThickness),
                        "--no-video",    "--grid",
                        "1x2",           "--size",
                        "300x300",       "--view",
                        "top",           "--transparent",
                        "--captions",    "none",
                        "--ground-look", "none",
                        "--export",      "inp,stl",
                        "--out",         run().string()});
  }

  std::filesystem::path run() const { return scratch_ / "run"; }

  TemporaryFolder scratch_;
  ProgramEnd end_;
};

TEST_F(ConcaveTiles, DeployArePaintedAndExported) {
  record(kPi * 2 / 3);
  ASSERT_EQ(end_.exitCode, 0) << end_.out << end_.err;
  const auto accuracy = nlohmann::json::parse(readText(run() / "summary.json"))["accuracy"];
  EXPECT_LT(accuracy["target_error_end"], 1e-9);

  const double area = model::tileArea(layout(0)[0]) + model::tileArea(layout(0)[1]);
  for (const char* name : {"initial.obj", "final.obj"}) {
    EXPECT_NEAR(volumeIn(run() / name), area * kThickness, 1e-12) << name;
  }
  for (const char* name : {"state_final_mesh.inp", "state_final.stl"}) {
    EXPECT_NE(readText(run() / name), "") << name;
  }

  const picture::Frame picture = test::readPng(run() / "snapshots.png");
  const int start = paintedIn(picture, 0);
  EXPECT_GT(start, 3000);
  EXPECT_NEAR(paintedIn(picture, 1), start, 0.02 * start);
}

TEST_F(ConcaveTiles, TouchAtTheirSides) {
  record(kPi * 17 / 18);
  ASSERT_EQ(end_.exitCode, kEndedShort) << end_.out << end_.err;
  const auto [arm, star] = tilesIn(run() / "final_vertices.txt");
  EXPECT_LT(test::cornerDepth(arm, star), 1e-9);
  // The tip that meets the arm, seen from the joint, against the arm's side.
  const Vector3 joint = arm.vertices[2];
  const double gap = test::distanceToSegment(star.vertices[6], arm.vertices[3], joint);
  EXPECT_LT(gap, 1e-9);
  const Vector3 axis = model::tileCentroid(star) - joint;
  const Vector3 along = joint - arm.vertices[3];
  EXPECT_NEAR(std::atan2(test::cross2(along, axis), along.dot(axis)), 0.75 * kPi, 1e-9);
}

}  // namespace
}  // namespace kirireel
