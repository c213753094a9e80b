/// The scenes that benchmarks run, and how their runs are measured.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/study/stepped_scene.h"

namespace kirireel::bench {

/// No run of a table may take more CPU seconds; one that would is cut off and marked.
inline constexpr double kRunBudget = 60;

struct NamedScene {
  std::string name;
  scene::Scene scene;
};

/// All model folders directly inside `folder`, by name, with the settings that their authors give
/// for them where the defaults do not do, all bricks able to touch. Folders without vertices.txt
/// are passed over.
std::vector<NamedScene> modelScenes(const std::filesystem::path& folder);

/// A square sheet that opens from 0 to 90 degrees, without contacts. Joints on both faces are
/// hinges, which are two point joints in Bullet. Joints only on the bottom are one.
scene::Scene sheetScene(int side, bool planar, scene::SolverKind kind,
                        model::JointFace face = model::JointFace::Both);

/// CPU milliseconds a step: `steps` of the direct solver, or of Bullet until half a second of CPU
/// is used.
double millisecondsPerStep(const scene::Scene& scene, int steps);

/// What a sheet's deployment misses of the exact motion at the same opening angle.
struct MotionError {
  double compact = 0;      ///< metres, largest up to 0.04 rad
  double open = 0;         ///< metres, largest beyond
  double gap = 0;          ///< metres, largest
  double lastAngle = 0;    ///< radians
  int compactSamples = 0;  ///< up to 0.04 rad, the start left out
};

/// Deploys with the scene's timestep, every step sampled.
MotionError motionError(const scene::Scene& scene, int side, double seconds);

}  // namespace kirireel::bench
