/// Arrays of numbers as text within a page.
///
/// An array is stored little-endian in planes (the first bytes of all entries, then the second
/// bytes, ...), compressed by zlib, in base 64. In planes, numbers that are alike give long runs of
/// equal bytes, so they shrink further.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <nlohmann/json.hpp>

#include "sim/base/geometry.h"

namespace kirireel {

using Json = nlohmann::ordered_json;

/// [x, y, z].
Json vectorJson(const Vector3& vector);

/// {"type": "f32" | "f64" | "i32" | "u16" | "u8", "count": entries, "data": text}, which packed.js
/// unpacks.
Json packedArray(std::span<const float> entries);
Json packedArray(std::span<const double> entries);
Json packedArray(std::span<const std::int32_t> entries);
Json packedArray(std::span<const std::uint16_t> entries);
Json packedArray(std::span<const std::uint8_t> entries);

/// How finely poses are told.
struct PoseSteps {
  Vector3 origin = Vector3::Zero();  ///< that positions are counted from, metres
  double position = 1;               ///< step of positions, metres; above 0
  double rotation = 1;               ///< step of the quaternions' parts; above 0
};

/// Steps that move no corner of bricks by more than 1/18,000 of what is in sight: a ninth of a
/// pixel where that fills 2000 pixels. `size`: its diagonal; `radius`: the largest distance of a
/// corner from its brick's centre of mass; both metres, above 0.
PoseSteps finePoseSteps(const Vector3& origin, double size, double radius);

/// Packs the poses of one run's samples, one after the other: x, y, z, then the quaternion's w, x,
/// y, z, each for all bricks.
///
/// Rounded to the steps, entries follow their samples so smoothly that of an entry only the
/// difference d = e(k) - 2 e(k-1) + e(k-2) from the straight continuation is stored (entries before
/// the first are zero), as 2 d or, below zero, -2 d - 1, so that small ones have empty upper bytes.
class PosePacker {
 public:
  /// Rounded to these steps; exact doubles without them.
  explicit PosePacker(std::optional<PoseSteps> steps) : steps_(std::move(steps)) {}

  /// As many bricks each time.
  void add(const Poses& poses);

  /// {"exact": bool, "origin": [x, y, z], "position_step", "rotation_step", "entries": array} May
  /// be called once all samples are added.
  Json packed() const;

 private:
  void addRounded(const std::vector<double>& entries);
  Json packedDifferences() const;

  std::optional<PoseSteps> steps_;
  Poses before_;  ///< of the last sample, its quaternions' signs chosen to follow each other
  std::vector<double> exact_;
  std::vector<std::int32_t> differences_;
  std::vector<std::int64_t> last_, lastButOne_;  ///< rounded entries
};

/// Values from 0 on, in 255 steps of equal ratios between the least above 0 and the largest: what
/// matters of gaps and errors is how large they are. Code 0 is 0.
/// {"least", "most", "codes": array} Values must not be negative; NaN counts as 0.
Json packedMagnitudes(std::span<const double> values);

}  // namespace kirireel
