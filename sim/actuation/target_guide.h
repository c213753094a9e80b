/// A way for every tile from its start to its target.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel {

/// Leads every tile along its own rigid motion: its middle goes straight, the tile turns evenly
/// about one axis, and what its target differs from it in shape is faded in. Neighbours part on
/// the way, as far as their motions differ; the joints make them find a way together.
class TargetGuide {
 public:
  /// The same tiles, vertex by vertex, in both states.
  TargetGuide(const std::vector<Tile>& start, const std::vector<Tile>& target);

  /// Where the tiles are led at a progress from 0 (the start) to 1 (the target).
  /// Costs O(vertices).
  std::vector<Tile> at(double progress) const;

 private:
  /// The motion of one tile.
  struct Way {
    Vector3 startMean;
    Vector3 targetMean;
    Vector3 turn;                   ///< rotation vector of the best fit
    std::vector<Vector3> vertices;  ///< of the start, relative to its mean
    std::vector<Vector3> unfit;     ///< what the best fit leaves over, in the start's axes
  };

  std::vector<Way> ways_;
};

/// The bricks' poses that fit the target best, each brick by itself.
/// `target` has one tile a brick. The fit is that of the bottoms, in the sum of squares.
Poses bestFitPoses(const std::vector<Brick>& bricks, const std::vector<Tile>& target);

}  // namespace kirireel
