#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

#include "render/page/page.h"

namespace kirireel {
namespace {

/// Base 64 by its definition: six bits a letter.
std::string bytesOf(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char letter : text) {
    if (letter == '=') break;
    bits = bits << 6 | static_cast<unsigned>(letters.find(letter));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255);
  }
  return bytes;
}

/// A packed array as unpacked by packed.js, with zlib's own reader.
template <typename Number>
std::vector<Number> unpacked(const Json& packed) {
  const std::size_t count = packed.at("count");
  const std::string small = bytesOf(packed.at("data"));
  std::string planes(count * sizeof(Number), '\0');
  uLongf size = planes.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(planes.data()), &size,
                       reinterpret_cast<const Bytef*>(small.data()), small.size()),
            Z_OK);
  EXPECT_EQ(size, planes.size());
  std::string bytes(planes.size(), '\0');
  for (std::size_t plane = 0; plane < sizeof(Number); ++plane) {
    for (std::size_t k = 0; k < count; ++k) {
      bytes[k * sizeof(Number) + plane] = planes[plane * count + k];
    }
  }
  std::vector<Number> entries(count);
  std::memcpy(entries.data(), bytes.data(), bytes.size());
  return entries;
}

/// Three bricks that move and turn fast, one of them by more than a full turn, k of 40.
Poses stateOf(int k) {
  Poses poses(3);
  for (int i = 0; i < 3; ++i) {
    poses[i].position = Vector3(std::sin(0.1 * k + i), 2 - 0.05 * k * i, 0.3 * i * i);
    poses[i].rotation = rotationFromVector((0.2 * k * i) * Vector3(1, 2, 2).normalized());
  }
  return poses;
}

TEST(PackedArrays, ComeBackToTheLastBit) {
  std::vector<double> entries;
  for (int k = -500; k < 500; ++k) entries.push_back(std::exp(0.1 * k) * (k % 2 == 0 ? 1 : -1));
  const Json packed = page::packedArray(std::span<const double>(entries));
  EXPECT_EQ(packed.at("type"), "f64");
  EXPECT_EQ(unpacked<double>(packed), entries);
  const std::vector<std::uint8_t> bytes = {0, 255, 3};
  EXPECT_EQ(unpacked<std::uint8_t>(page::packedArray(std::span<const std::uint8_t>(bytes))), bytes);
  EXPECT_EQ(unpacked<float>(page::packedArray(std::span<const float>())), std::vector<float>());
}

// The page's own arithmetic: sums of differences in 32 bits.
TEST(PosePacker, MovesNoCornerBeyondItsSteps) {
  constexpr double kSize = 5, kRadius = 0.8;
  const page::PoseSteps steps = page::finePoseSteps({0.1, 0.2, 0.3}, kSize, kRadius);
  page::PosePacker packer(steps);
  for (int k = 0; k < 40; ++k) packer.add(stateOf(k));
  const Json packed = packer.packed();
  EXPECT_FALSE(packed.at("exact"));
  ASSERT_EQ(packed.at("entries").at("type"), "u16");
  const std::vector<std::uint16_t> stored = unpacked<std::uint16_t>(packed.at("entries"));
  std::vector<std::int32_t> entries(stored.begin(), stored.end());
  ASSERT_EQ(entries.size(), 40U * 7 * 3);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const auto code = static_cast<std::uint32_t>(entries[k]);
    entries[k] = static_cast<std::int32_t>(code >> 1) ^ -static_cast<std::int32_t>(code & 1);
    if (k >= 21) entries[k] += 2 * entries[k - 21];
    if (k >= 42) entries[k] -= entries[k - 42];
  }
  double farthest = 0;
  for (int k = 0; k < 40; ++k) {
    const Poses exact = stateOf(k);
    for (int i = 0; i < 3; ++i) {
      const auto entry = [&](int part) { return entries[21 * k + 3 * part + i]; };
      Pose pose;
      pose.position = steps.origin + steps.position * Vector3(entry(0), entry(1), entry(2));
      pose.rotation = Quaternion(entry(3), entry(4), entry(5), entry(6)).normalized();
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3 corner = kRadius * Vector3::Unit(axis);
        farthest = std::max(farthest, (pose.apply(corner) - exact[i].apply(corner)).norm());
      }
    }
  }
  EXPECT_LT(farthest, kSize / 18000);  // measured 1.7e-4 of 2.8e-4
}

TEST(PosePacker, StoresBricksThatFlyAway) {
  page::PosePacker packer(page::finePoseSteps({0, 0, 0}, 1, 1));
  packer.add(stateOf(0));
  Poses away = stateOf(1);
  away[1].position.x() = 20;
  packer.add(away);
  EXPECT_EQ(packer.packed().at("entries").at("type"), "i32");
}

TEST(PosePacker, KeepsExactPosesToTheLastBit) {
  page::PosePacker packer(std::nullopt);
  packer.add(stateOf(7));
  const Json packed = packer.packed();
  EXPECT_TRUE(packed.at("exact"));
  const std::vector<double> entries = unpacked<double>(packed.at("entries"));
  const Poses exact = stateOf(7);
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(entries[3 * axis + i], exact[i].position[axis]);
    EXPECT_EQ(entries[9 + i], exact[i].rotation.w());
    EXPECT_EQ(entries[18 + i], exact[i].rotation.z());
  }
}

TEST(PackedMagnitudes, AreWithinHalfAStep) {
  const std::vector<double> values = {0, 1e-13, 3e-13, 2e-9, 5e-4};
  const Json packed = page::packedMagnitudes(values);
  const std::vector<std::uint8_t> codes = unpacked<std::uint8_t>(packed.at("codes"));
  EXPECT_EQ(codes[0], 0);
  EXPECT_EQ(codes[1], 1);
  EXPECT_EQ(codes[4], 255);
  const double least = packed.at("least"), most = packed.at("most");
  for (std::size_t k = 1; k < values.size(); ++k) {
    const double decoded = least * std::pow(most / least, (codes[k] - 1) / 254.0);
    EXPECT_NEAR(std::log(decoded / values[k]), 0, 0.5 / 254 * std::log(most / least) + 1e-12);
  }
}

TEST(PackedMagnitudes, OfNothingButZerosAreZeros) {
  const Json packed = page::packedMagnitudes(std::vector<double>{0, 0});
  EXPECT_EQ(unpacked<std::uint8_t>(packed.at("codes")), (std::vector<std::uint8_t>{0, 0}));
}

}  // namespace
}  // namespace kirireel
