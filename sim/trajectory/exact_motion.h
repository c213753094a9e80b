/// The motion of rotating tiles in closed form.
#pragma once

#include <optional>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::trajectory {

/// The motion of a flat sheet whose joined tiles rotate by equal angles in opposite directions, for
/// example rotating squares. All joints have the same opening, and the sheet has no other motion in
/// its plane.
class ExactMotion {
 public:
  /// Absent unless the start is flat, pivots connect all tiles, the joints stay closed in such a
  /// motion (to 1e-9 of the sheet), and it is the only one: see mobility().
  static std::optional<ExactMotion> find(const model::Model& model);

  /// The tiles of one of the two states with this opening since the start (radians, >= 0), moved by
  /// a rigid motion: the nearer ones to a state of the same model.
  std::vector<model::Tile> nearest(double opening, const std::vector<model::Tile>& state) const;

 private:
  std::vector<model::Tile> tilesAt(double opening) const;

  model::SheetFrame frame_;
  std::vector<model::Tile> start_;          ///< in the frame
  std::vector<int> signs_;                  ///< direction of each tile's rotation, 1 or -1
  std::vector<Eigen::Vector2d> positions_;  ///< c of each tile, see the source; metres
};

/// The distances of corresponding vertices, metres.
struct VertexDistance {
  double largest = 0;
  double mean = 0;
};
VertexDistance vertexDistance(const std::vector<model::Tile>& a, const std::vector<model::Tile>& b);

/// The largest distance of a vertex from the mean of all, metres.
double largestRadius(const std::vector<model::Tile>& tiles);

}  // namespace kirireel::trajectory
