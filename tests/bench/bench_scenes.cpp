#include "tests/bench/bench_scenes.h"

#include <algorithm>

#include "sim/formats/read_model.h"
#include "sim/model/isometry.h"
#include "sim/study/exact_sheet.h"

namespace kirireel::bench {
namespace {

/// The flags that PyKirigami's pages give for its models.
void applyAuthorsSettings(const std::string& name, scene::Scene& scene) {
  scene.springs = scene::paperSprings();
  if (name == "square2disk") {
    scene.springs.springStiffness = 25;
    scene.environment.gravity = {0, 0, -10};
    scene.environment.ground = scene::Ground{scene::lowestPoint(scene.model), 0.5};
  } else if (name == "tess_m10_n10" || name == "demo_nonrigid") {
    scene.environment.ground = scene::Ground{scene::lowestPoint(scene.model), 0.5};
  } else if (name == "cylinder") {
    scene.springs.forceDamping = 80;
  } else if (name == "mobius") {
    scene.springs.springStiffness = 25;
    scene.brick.thickness = 0.005;
  } else if (name == "sphere-to-saddle") {
    scene.brick.thickness = 0.001;
  }
}

}  // namespace

std::vector<NamedScene> modelScenes(const std::filesystem::path& folder) {
  std::vector<NamedScene> scenes;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!exists(entry.path() / "vertices.txt")) continue;
    NamedScene named{entry.path().filename(), {}};
    std::vector<std::string> warnings;
    named.scene.model = formats::readModelFolder(entry.path(), warnings);
    model::alignStartToTarget(named.scene.model);
    named.scene.environment.contacts = scene::ContactFilter::All;
    applyAuthorsSettings(named.name, named.scene);
    scenes.push_back(std::move(named));
  }
  std::sort(scenes.begin(), scenes.end(),
            [](const NamedScene& a, const NamedScene& b) { return a.name < b.name; });
  return scenes;
}

scene::Scene sheetScene(int side, bool planar, scene::SolverKind kind, model::JointFace face) {
  scene::Scene scene = kirireel::study::sheetScene(side, planar, face);
  scene.solver.kind = kind;
  return scene;
}

double millisecondsPerStep(const scene::Scene& scene, int steps) {
  study::SteppedScene run(scene);
  const bool bullet = scene.solver.kind == scene::SolverKind::Bullet;
  int done = 0;
  while (done < steps && !(bullet && done >= 3 && run.seconds() > 0.5)) {
    run.advance();
    ++done;
  }
  return 1e3 * run.seconds() / done;
}

MotionError motionError(const scene::Scene& scene, int side, double seconds) {
  study::SteppedScene run(scene);
  MotionError error;
  const long steps = std::lround(seconds / scene.solver.timestep);
  for (long step = 0; step < steps; ++step) {
    run.advance();
    error.lastAngle = study::openingAngle(run.motion().poses);
    error.gap = std::max(error.gap, run.gap());
    const bool compact = error.lastAngle < 0.04;
    error.compactSamples += compact ? 1 : 0;
    double& largest = compact ? error.compact : error.open;
    largest = std::max(largest, study::sheetError(side, error.lastAngle, run.tiles()).largest);
  }
  return error;
}

}  // namespace kirireel::bench
