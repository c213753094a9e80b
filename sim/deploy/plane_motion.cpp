// Mobility of flat sheets in the plane and in space: the rank of the joints' Jacobian at the start.
// If tiles do not quite fit each other, the rank may be uncertain. Motions are then not counted.
#include "sim/deploy/plane_motion.h"

#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/sheet.h"

namespace kirireel::deploy {
namespace {

/// Motions other than rigid motions of the whole sheet; -1 if they cannot be counted.
int motions(const scene::Scene& scene, trajectory::Freedom freedom) {
  const trajectory::Mobility found =
      trajectory::mobility(scene.model, scene.model.tiles, freedom, scene.brick.thickness);
  return found.isCertain() ? found.freedoms : -1;
}

}  // namespace

int motionsOutOfPlane(const scene::Scene& scene) {
  if (scene.solver.planar || !scene::sceneNeeds(scene).planar.on) return 0;
  if (motions(scene, trajectory::Freedom::Plane) != 0) return 0;
  return std::max(0, motions(scene, trajectory::Freedom::Space));
}

void requireDriveOutOfPlane(const scene::Scene& scene) {
  const int count = motionsOutOfPlane(scene);
  if (count == 0) return;
  throw InputError(fmt::format(
      "error: this sheet has no motion in its plane, but {} out of it. Set a target, "
      "a load or springs at folds (`target`, `gravity`, `hinge_stiffness`, [[timeline]] "
      "or [[velocity]] in scene.toml)",
      count));
}

void leaveLockedPlane(scene::Scene& scene) {
  if (scene.model.target) return;
  std::string reason;
  const scene::PathKind kind = scene.path.kind;
  const bool isGeometry = kind == scene::PathKind::Auto || kind == scene::PathKind::Continuation;
  const bool isDriven = !scene::isQuasiStatic(scene, reason);
  if (isGeometry && !isDriven) return;
  if (!isDriven) return requireDriveOutOfPlane(scene);
  if (const int count = motionsOutOfPlane(scene); count > 0) {
    scene.spaceReason = fmt::format("no motion in its plane, {} out of it", count);
  }
}

}  // namespace kirireel::deploy
