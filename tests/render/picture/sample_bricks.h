/// Bricks for tests of pictures.
#pragma once

#include <vector>

#include "sim/brick/brick.h"

namespace kirireel {

/// A box of the given sides with its lower left corner at (x, y, 0).
inline model::Tile rectangleTile(double x, double y, double width, double depth) {
  return {{Vector3(x, y, 0), Vector3(x + width, y, 0), Vector3(x + width, y + depth, 0),
           Vector3(x, y + depth, 0)}};
}

/// Bricks and their poses.
struct SampleBricks {
  std::vector<brick::Brick> bricks;
  Poses poses;
};

inline SampleBricks sampleBricks(const std::vector<model::Tile>& tiles, double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  SampleBricks sample{brick::makeBricks(tiles, rule), {}};
  sample.poses = brick::startPoses(tiles, sample.bricks);
  return sample;
}

/// Twelve bricks, each with another rotation: every kind of face and overlap is visible.
inline SampleBricks tumbledBricks() {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 12; ++k) tiles.push_back(rectangleTile(1.2 * (k % 4), 1.2 * (k / 4), 1, 1));
  SampleBricks sample = sampleBricks(tiles, 0.2);
  for (int k = 0; k < 12; ++k) {
    sample.poses[k].rotation = rotationFromVector(Vector3(0.5 * k, 0.3 * k - 1, 0.7));
  }
  return sample;
}

}  // namespace kirireel
