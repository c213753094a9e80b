#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "render/writers/mesh.h"
#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

using nlohmann::json;

/// A square tessellation that rotates while it moves up.
struct Turning {
  std::vector<brick::Brick> bricks;
  Poses start;

  explicit Turning(int side) {
    generate::TessellationShape shape;
    shape.columns = side;
    shape.rows = side;
    const model::Model model = generate::makeTessellation(shape);
    bricks = brick::makeBricks(model.tiles, brick::BrickRule{});
    start = brick::startPoses(model.tiles, bricks);
  }

  writers::AnimationKey at(std::size_t k) const {
    writers::AnimationKey key{static_cast<double>(k) / 60, start};
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double angle = (i % 2 == 0 ? 0.07 : -0.07) * static_cast<double>(k);
      key.poses[i].rotation = rotationFromVector({0.2 * angle, 0, angle});
      key.poses[i].position.z() += 0.01 * static_cast<double>(k);
      // The same rotation with the other sign, which solvers may give.
      if (k % 3 == 0) key.poses[i].rotation.coeffs() = -key.poses[i].rotation.coeffs();
    }
    return key;
  }

  std::string bytes(std::size_t keys) const {
    return writers::animationBytes(bricks, keys, [this](std::size_t k) { return at(k); });
  }
};

/// A .glb taken apart again.
struct Glb {
  json text;
  std::string binary;

  explicit Glb(const std::string& bytes) {
    const auto number = [&](std::size_t place) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + place, sizeof value);
      return value;
    };
    EXPECT_EQ(bytes.substr(0, 4), "glTF");
    EXPECT_EQ(number(4), 2U);
    EXPECT_EQ(number(8), bytes.size());
    const std::uint32_t length = number(12);
    text = json::parse(bytes.substr(20, length));
    binary = bytes.substr(20 + length + 8, number(20 + length));
  }

  /// The values of an accessor, one after the other.
  std::vector<float> values(int accessor, std::size_t components) const {
    const json& found = text["accessors"][accessor];
    const json& view = text["bufferViews"][found["bufferView"].get<int>()];
    const std::size_t place =
        view["byteOffset"].get<std::size_t>() + found["byteOffset"].get<std::size_t>();
    std::vector<float> numbers(found["count"].get<std::size_t>() * components);
    std::memcpy(numbers.data(), binary.data() + place, numbers.size() * sizeof(float));
    return numbers;
  }
};

TEST(Animation, HoldsTheTrajectoryToFloatPrecision) {
  const Turning sheet(3);
  const std::size_t keys = 30;
  const Glb glb(sheet.bytes(keys));
  const json& animation = glb.text["animations"][0];
  ASSERT_EQ(animation["channels"].size(), 18U);
  for (const json& channel : animation["channels"]) {
    const json& sampler = animation["samplers"][channel["sampler"].get<int>()];
    const std::size_t brick = channel["target"]["node"].get<std::size_t>() - 1;
    const std::vector<float> times = glb.values(sampler["input"], 1);
    const bool isMove = channel["target"]["path"] == "translation";
    const std::vector<float> values = glb.values(sampler["output"], isMove ? 3 : 4);
    for (std::size_t k = 0; k < keys; ++k) {
      const writers::AnimationKey key = sheet.at(k);
      EXPECT_FLOAT_EQ(times[k], static_cast<float>(key.time));
      if (isMove) {
        const Vector3 read(values[3 * k], values[3 * k + 1], values[3 * k + 2]);
        EXPECT_LT((read - key.poses[brick].position).norm(), 3e-7);  // measured: 1.2e-7
      } else {
        const float* q = &values[4 * k];
        const Quaternion read(q[3], q[0], q[1], q[2]);
        EXPECT_LT(read.angularDistance(key.poses[brick].rotation), 1e-6);  // measured: 2e-7
        if (k == 0) continue;
        const Quaternion before(q[-1], q[-4], q[-3], q[-2]);
        EXPECT_GT(read.dot(before), 0);
      }
    }
  }
}

TEST(Animation, NamesTilesAndTurnsZUp) {
  const Glb glb(Turning(2).bytes(2));
  const json& nodes = glb.text["nodes"];
  EXPECT_EQ(nodes[0]["name"], "kirigami");
  EXPECT_EQ(nodes[0]["children"], json({1, 2, 3, 4}));
  const std::vector<double> q = nodes[0]["rotation"];
  const Vector3 up = Quaternion(q[3], q[0], q[1], q[2]) * Vector3::UnitZ();
  EXPECT_LT((up - Vector3::UnitY()).norm(), 1e-15);  // measured: 3e-16
  EXPECT_EQ(nodes[1]["name"], "TILE_00000");
  EXPECT_EQ(nodes[4]["name"], "TILE_00003");
  EXPECT_EQ(glb.text["meshes"].size(), 4U);
}

TEST(Animation, HoldsFlatOutwardFaces) {
  const Turning sheet(1);
  const Glb glb(sheet.bytes(1));
  const json& attributes = glb.text["meshes"][0]["primitives"][0]["attributes"];
  const std::vector<float> points = glb.values(attributes["POSITION"], 3);
  const std::vector<float> normals = glb.values(attributes["NORMAL"], 3);
  ASSERT_EQ(points.size(), 72U);
  for (std::size_t k = 0; k < points.size(); k += 3) {
    const Vector3 point(points[k], points[k + 1], points[k + 2]);
    const Vector3 normal(normals[k], normals[k + 1], normals[k + 2]);
    EXPECT_GT(point.dot(normal), 0);  // brick axes begin inside
    EXPECT_NEAR(normal.norm(), 1, 1e-6);
  }
}

TEST(Animation, HasTheSameBytesTwice) {
  EXPECT_EQ(Turning(2).bytes(5), Turning(2).bytes(5));
}

}  // namespace
}  // namespace kirireel
