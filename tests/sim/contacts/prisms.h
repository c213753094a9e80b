/// Bricks and poses for tests of separation and contacts.
#pragma once

#include <numbers>
#include <random>

#include "sim/brick/brick.h"

namespace kirireel::test {

/// A prism over a regular polygon.
inline brick::Brick prism(int corners, double radius, double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  model::Tile tile;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    tile.vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return brick::makeBrick(tile, rule);
}

/// A square plate of side 1 about its centre, its sides along the axes.
inline brick::Brick plate(double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  return brick::makeBrick({{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}}, rule);
}

/// Random numbers, the same on every machine.
class Chance {
 public:
  explicit Chance(unsigned seed) : generator_(seed) {}

  /// Uniform in [-1, 1].
  double next() { return static_cast<double>(generator_()) / 2147483647.5 - 1; }

  /// One of 0 .. count - 1.
  int below(int count) { return static_cast<int>(generator_() % static_cast<unsigned>(count)); }

  Vector3 vector() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }

  Pose pose(double distance) { return {distance * vector(), rotationFromVector(3 * vector())}; }

  Pose planarPose(double distance) {
    Vector3 position = distance * vector();
    position.z() = 0;
    return {position, rotationFromVector({0, 0, 3 * next()})};
  }

 private:
  std::mt19937 generator_;
};

/// The pose after a rigid motion of the world.
inline Pose moved(const Pose& motion, const Pose& pose) {
  return {motion.apply(pose.position), (motion.rotation * pose.rotation).normalized()};
}

}  // namespace kirireel::test
