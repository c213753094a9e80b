/// Bricks in motion, without a deployment.
#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <vector>

#include "sim/run/dynamics.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel::test {

/// A rectangle with its first corner at a point, sides along the axes.
inline model::Tile rectangle(const Vector3& corner, double length, double width) {
  return {{corner, corner + Vector3(length, 0, 0), corner + Vector3(length, width, 0),
           corner + Vector3(0, width, 0)}};
}

/// A scene of loose bricks in motion.
struct Moving {
  explicit Moving(const scene::Scene& start)
      : scene(start),
        bricks(brick::makeBricks(scene.model.tiles, scene.brick)),
        motion{brick::startPoses(scene.model.tiles, bricks), std::vector<Velocity>(bricks.size())},
        dynamics(run::makeDynamics(scene, scene::sceneNeeds(scene), bricks, motion.poses)) {}
  Moving(const Moving&) = delete;
  Moving& operator=(const Moving&) = delete;

  /// Takes steps under the scene's gravity and a constant force on every brick.
  void advance(int steps, const Vector3& force = Vector3::Zero()) {
    const mechanics::LoadSource loads = [&](const Poses&, std::vector<brick::Load>& out) {
      for (brick::Load& load : out) {
        load = {};
        load.force.head<3>() = force;
      }
    };
    for (int step = 0; step < steps; ++step) {
      const StepReport report = dynamics->advance(motion, scene.solver.timestep, loads);
      unconverged += report.unconverged;
      deepest = std::max(deepest, trajectory::deepestPenetration(bricks, motion.poses).depth);
      lowest = std::min(lowest, lowestVertex());
    }
  }

  double lowestVertex() const {
    double low = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < bricks.size(); ++i) {
      for (const auto* points : {&bricks[i].bottom, &bricks[i].top}) {
        for (const Vector3& point : *points) low = std::min(low, motion.poses[i].apply(point).z());
      }
    }
    return low;
  }

  scene::Scene scene;
  std::vector<brick::Brick> bricks;
  Motion motion;
  std::unique_ptr<run::Dynamics> dynamics;
  int unconverged = 0;
  double deepest = 0;                                       ///< overlap of bricks so far
  double lowest = std::numeric_limits<double>::infinity();  ///< z of any vertex so far
};

}  // namespace kirireel::test
