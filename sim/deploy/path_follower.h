/// Leads the tiles of a deployment to their target.
#pragma once

#include "sim/actuation/target_guide.h"
#include "sim/actuation/target_springs.h"
#include "sim/deploy/dynamics.h"

namespace kirireel {

/// The first part of a led deployment: springs pull every tile after a target that moves along the
/// tile's own rigid motion, by the turn more than by the place (a mechanism that turns has to
/// swing out on its way, which straight lines do not know). Joints may give meanwhile; at the end
/// they stiffen until hardly anything of their openings is left.
class PathFollower {
 public:
  /// `bricks` must outlive this. `start`: where the path begins, joints closed unless they give;
  /// `beginTime`: when, seconds. `target`: where it leads, one tile a brick. The scene has
  /// PathKind::Led.
  PathFollower(const Scene& scene, const std::vector<Brick>& bricks, const Poses& start,
               const std::vector<Tile>& target, double beginTime);

  /// Sets the moving target and the joints' stiffness for the step that ends at `time` (seconds
  /// of the run). Returns false when the path is done: the joints are as stiff as they get, ready
  /// to be closed and held exactly, and the scene's own springs take over.
  bool prepareStep(double time, Dynamics& dynamics);

  /// The springs that lead.
  const TargetSprings& springs() const { return springs_; }

 private:
  PathSettings path_;
  double beginTime_;
  TargetGuide guide_;
  TargetSprings springs_;
};

}  // namespace kirireel
