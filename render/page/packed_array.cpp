// How poses become text. Positions are counted in steps of s = size / 32768 (metres) from an
// origin, parts of quaternions in steps of r = s / (2 radius). A corner at the distance `radius`
// from its brick's centre then moves by at most
//
//     sqrt(3) s / 2              by rounding the position,
//     2 radius (2 r / 2) = s     by rounding the four parts of the quaternion, half a step each,
//
// together below 1.9 s.
//
// Rounded entries e(k) of one number over the samples k are stored as second differences d(k) =
// e(k) - 2 e(k-1) + e(k-2), exactly invertible in whole numbers. Motion is smooth, so d is a few
// steps, fits into 16 bits and compresses well. Zigzag coding maps 0, -1, 1, -2, ... to 0, 1, 2, 3,
// ..., so that the upper bytes of small numbers are zero whatever their sign.
//
// The text is base 64 of zlib (RFC 1950) of planes of bytes. Browsers have a decompressor but no
// HDF5, and JSON numbers would take several times as much.
#include "render/page/packed_array.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/compression.h"

namespace kirireel {
namespace {

/// Parts of what is in sight that a step of positions is.
constexpr double kPositionSteps = 32768;

template <typename Number>
/// Any number of entries, none too.
Json packedAs(const char* type, std::span<const Number> entries) {
  const std::span<const std::byte> bytes = std::as_bytes(entries);
  std::vector<std::byte> planes;
  planes.reserve(bytes.size());
  // Byte `plane` of every entry; little-endian, so the last plane is the highest.
  for (std::size_t plane = 0; plane < sizeof(Number); ++plane) {
    for (std::size_t k = plane; k < bytes.size(); k += sizeof(Number)) planes.push_back(bytes[k]);
  }
  const std::string small = compressed(planes);
  return {
      {"type", type}, {"count", entries.size()}, {"data", base64(std::as_bytes(std::span(small)))}};
}

/// Quaternions q and -q are one rotation: the one that is nearer to that of the sample before.
/// Chosen by the sign of the dot product.
Quaternion following(const Quaternion& rotation, const Quaternion& before) {
  return rotation.dot(before) < 0 ? Quaternion(-rotation.coeffs()) : rotation;
}

/// Differences wrap around as 32-bit numbers do, here and in the page.
std::int32_t zigzag(std::int64_t difference) {
  const auto wrapped = static_cast<std::int32_t>(static_cast<std::uint32_t>(difference));
  // 2 d for d >= 0, -2 d - 1 below; the arithmetic shift gives all ones for negative numbers.
  return static_cast<std::int32_t>((static_cast<std::uint32_t>(wrapped) << 1) ^
                                   static_cast<std::uint32_t>(wrapped >> 31));
}

}  // namespace

Json vectorJson(const Vector3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

Json packedArray(std::span<const float> entries) {
  return packedAs("f32", entries);
}
Json packedArray(std::span<const double> entries) {
  return packedAs("f64", entries);
}
Json packedArray(std::span<const std::int32_t> entries) {
  return packedAs("i32", entries);
}
Json packedArray(std::span<const std::uint16_t> entries) {
  return packedAs("u16", entries);
}
Json packedArray(std::span<const std::uint8_t> entries) {
  return packedAs("u8", entries);
}

PoseSteps finePoseSteps(const Vector3& origin, double size, double radius) {
  const double step = size / kPositionSteps;
  // Half a step in each of four parts turns by at most two steps.
  return {origin, step, 0.5 * step / radius};
}

void PosePacker::add(const Poses& poses) {
  // The first sample follows itself.
  if (before_.empty()) before_ = poses;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    before_[i] = {poses[i].position, following(poses[i].rotation, before_[i].rotation)};
  }
  const PoseSteps steps = steps_.value_or(PoseSteps{});
  std::vector<double> entries;
  entries.reserve(7 * poses.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (const Pose& pose : before_) {
      entries.push_back((pose.position[axis] - steps.origin[axis]) / steps.position);
    }
  }
  for (const int part : {3, 0, 1, 2}) {  // Eigen keeps x, y, z, w
    for (const Pose& pose : before_) {
      entries.push_back(pose.rotation.coeffs()[part] / steps.rotation);
    }
  }
  if (steps_) {
    addRounded(entries);
  } else {
    exact_.insert(exact_.end(), entries.begin(), entries.end());
  }
}

void PosePacker::addRounded(const std::vector<double>& entries) {
  // What flies away is shown no farther than numbers go.
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  last_.resize(entries.size());
  lastButOne_.resize(entries.size());
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const std::int64_t entry = std::llround(std::clamp(entries[k], -kMost, kMost));
    // last_ and lastButOne_ are zero before the first sample.
    differences_.push_back(zigzag(entry - 2 * last_[k] + lastButOne_[k]));
    lastButOne_[k] = last_[k];
    last_[k] = entry;
  }
}

/// In 16 bits where all of them have room there, which is quicker to unpack.
Json PosePacker::packedDifferences() const {
  const bool areSmall = std::ranges::all_of(differences_, [](std::int32_t difference) {
    return difference >= 0 && difference <= std::numeric_limits<std::uint16_t>::max();
  });
  if (!areSmall) return packedArray(std::span<const std::int32_t>(differences_));
  const std::vector<std::uint16_t> small(differences_.begin(), differences_.end());
  return packedArray(std::span<const std::uint16_t>(small));
}

Json PosePacker::packed() const {
  const PoseSteps steps = steps_.value_or(PoseSteps{});
  return {{"exact", !steps_.has_value()},
          {"origin", vectorJson(steps.origin)},
          {"position_step", steps.position},
          {"rotation_step", steps.rotation},
          {"entries", steps_ ? packedDifferences() : packedArray(std::span<const double>(exact_))}};
}

Json packedMagnitudes(std::span<const double> values) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const double value : values) {
    most = std::max(most, value);
    if (value > 0) least = std::min(least, value);
  }
  if (most == 0) least = most = 1;
  // Where all values are equal the range is 0; any small number does then.
  const double range = std::max(std::log(most / least), 1e-12);
  std::vector<std::uint8_t> codes;
  codes.reserve(values.size());
  for (const double value : values) {
    const double share = value > 0 ? std::log(value / least) / range : 0;
    // 1 for the least, 255 for the largest.
    codes.push_back(value > 0 ? static_cast<std::uint8_t>(1 + std::lround(254 * share)) : 0);
  }
  return {{"least", least},
          {"most", most},
          {"codes", packedArray(std::span<const std::uint8_t>(codes))}};
}

}  // namespace kirireel
