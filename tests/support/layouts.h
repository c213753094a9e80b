/// Bricks to divide into elements.
#pragma once

#include <numbers>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/generate/lattice.h"

namespace kirireel::test {

struct Layout {
  std::vector<brick::Brick> bricks;
  std::vector<model::Joint> joints;
  Poses poses;
};

inline Layout layoutOf(const std::vector<model::Tile>& tiles,
                       const std::vector<model::Joint>& joints, double thickness = 0.02) {
  Layout layout;
  layout.bricks = brick::makeBricks(tiles, {.thickness = thickness});
  layout.joints = joints;
  layout.poses = brick::startPoses(tiles, layout.bricks);
  return layout;
}

inline generate::TessellationShape squares(int columns, int rows, double angle) {
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.startAngle = angle;
  return shape;
}

/// The model's start, rotated about z.
inline model::Model turned(model::Model model, double degrees) {
  const Quaternion turn = rotationFromVector({0, 0, degrees * kDegree});
  for (model::Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = turn * vertex;
  }
  return model;
}

/// Four squares in a ring of hinges: one degree of freedom.
inline Layout hingedSquares(double angle = 0.7) {
  const model::Model model = generate::makeTessellation(squares(2, 2, angle));
  return layoutOf(model.tiles, model.joints);
}

/// A triangle, a square and a pentagon of radius 1, side by side, not joined.
inline Layout polygons() {
  std::vector<model::Tile> tiles(3);
  for (int k = 0; k < 3; ++k) {
    for (int corner = 0; corner < 3 + k; ++corner) {
      const double angle = 2 * std::numbers::pi * corner / (3 + k);
      tiles[k].vertices.emplace_back(std::cos(angle) + 2.5 * k, std::sin(angle), 0);
    }
  }
  return layoutOf(tiles, {});
}

}  // namespace kirireel::test
