/// Scenes of benchmarks, and measures of their runs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/study/stepped_scene.h"

namespace kirireel::bench {

/// Largest CPU time of a run of a table, seconds. Longer runs are cut off and marked.
inline constexpr double kRunBudget = 60;

struct NamedScene {
  std::string name;
  scene::Scene scene;
};

/// All model folders directly inside `folder`, by name. Settings are those of their authors, else
/// the defaults. All bricks may touch. Folders without vertices.txt are ignored.
std::vector<NamedScene> modelScenes(const std::filesystem::path& folder);

/// A square sheet that opens from 0 to 90 degrees, without contacts. Joints on both faces are
/// hinges, which are two point joints in Bullet. Joints only on the bottom are one.
scene::Scene sheetScene(int side, bool planar, scene::SolverKind kind,
                        model::JointFace face = model::JointFace::Both);

/// CPU milliseconds per step, from `steps` of the direct solver, or half a CPU second of Bullet.
double millisecondsPerStep(const scene::Scene& scene, int steps);

/// Errors of a deployment from the exact motion at the same opening angle.
struct MotionError {
  double compact = 0;      ///< metres, largest up to 0.04 rad
  double open = 0;         ///< metres, largest beyond
  double gap = 0;          ///< metres, largest
  double lastAngle = 0;    ///< radians
  int compactSamples = 0;  ///< up to 0.04 rad, without the start
};

/// Deploys with the scene's timestep. Each step is a sample.
MotionError motionError(const scene::Scene& scene, int side, double seconds);

}  // namespace kirireel::bench
