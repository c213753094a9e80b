/// A trajectory for tests without a deployment.
#pragma once

#include "sim/generate/lattice.h"
#include "sim/trajectory/trajectory.h"
#include "tests/support/layouts.h"

namespace kirireel::test {

/// Four hinged squares that open from 0 to 1 radian in a second, eleven samples.
inline trajectory::Trajectory openingSquares() {
  trajectory::Trajectory run;
  run.model = generate::makeTessellation(squares(2, 2, 0));
  run.bricks = brick::makeBricks(run.model.tiles, run.brickRule);
  for (int k = 0; k <= 10; ++k) {
    const std::vector<model::Tile> tiles = generate::tessellationTiles(squares(2, 2, 0), 0.1 * k);
    trajectory::Sample sample;
    sample.time = 0.1 * k;
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      Pose pose;
      pose.position = model::tileCentroid(tiles[t]) + Vector3(0, 0, 0.01);
      // Tiles 0 and 3 are even.
      const double turn = (t == 0 || t == 3 ? -0.05 : 0.05) * k;
      pose.rotation = rotationFromVector({0, 0, turn});
      sample.poses.push_back(pose);
    }
    run.samples.push_back(sample);
  }
  return run;
}

}  // namespace kirireel::test
