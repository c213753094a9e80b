// The needs of a scene: decided from the scene only, before anything moves, each with the reason
// that the summary states.
//
// *Planar* scenes have three degrees of freedom a tile in place of six, which makes a step about
// three times as cheap. A scene is planar where nothing can push a brick out of its plane: start
// and all targets are flat and at one height (to 1e-9 of the model's size), no tile is turned over
// on the way, no speed, drag, obstacle or gravity points out of the plane, unless the ground
// carries gravity's part. *Quasi-static* scenes need no dynamics: only geometry decides where the
// sheet goes. Its mechanism can be followed without masses and time. Everything that a user gives
// beyond the model and the numbers of the output (a drive, a timeline, springs, friction, ...)
// speaks of dynamics.
#include "sim/scene/scene_needs.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include "sim/model/sheet_frame.h"
#include "sim/scene/settings.h"

namespace kirireel::scene {
namespace {

double height(const std::vector<model::Tile>& tiles) {
  return tiles.front().vertices.front().z();
}

bool isVertical(const Vector3& vector) {
  return vector.x() == 0 && vector.y() == 0;
}

/// All targets that the bricks may be pulled to.
std::vector<const std::vector<model::Tile>*> targets(const Scene& scene) {
  std::vector<const std::vector<model::Tile>*> found;
  // Other drives ignore the targets.
  if (scene.actuation.drive != Drive::Target) return found;
  if (scene.model.target) found.push_back(&*scene.model.target);
  for (const TimelineEntry& entry : scene.timeline) {
    const auto* goTo = std::get_if<timeline::GoTo>(&entry.action);
    if (goTo && !goTo->tiles.empty()) found.push_back(&goTo->tiles);
  }
  return found;
}

/// Whether a drag leaves the heights of the sheet's bricks.
bool dragsOutOfPlane(const Scene& scene, double tolerance) {
  const double bottom = height(scene.model.tiles) - tolerance;
  // A drag within the thickness of the bricks is taken as one in their plane.
  const double top = bottom + scene.brick.thickness + 2 * tolerance;
  for (const TimelineEntry& entry : scene.timeline) {
    const auto* drag = std::get_if<timeline::Drag>(&entry.action);
    if (!drag) continue;
    for (const Vector3& point : drag->path) {
      if (point.z() < bottom || point.z() > top) return true;
    }
  }
  return false;
}

bool leavesPlane(const InitialVelocity& velocity) {
  return velocity.linear.z() != 0 || !velocity.angular.head<2>().isZero(0);
}

/// Whether springs at folds rest out of the plane: where the model's file folds them, or by an
/// angle of their own to the same side.
bool foldsOutOfPlane(const Scene& scene) {
  constexpr double kFlatFoldAngle = 1e-6 * kDegree;
  const bool isFlat = scene.hinges.rest && std::abs(*scene.hinges.rest) <= kFlatFoldAngle;
  return scene.hinges.areOn() && !isFlat &&
         std::ranges::any_of(scene.model.foldAngles, [](const auto& fold) {
           return std::abs(fold.second) > kFlatFoldAngle;
         });
}

// Reports the first reason found. The order is from the most to the least basic.
Need planarNeed(const Scene& scene) {
  // A user's choice is final.
  if (scene.solver.planar) return {*scene.solver.planar, "asked for"};
  if (!scene.spaceReason.empty()) return {false, scene.spaceReason};
  if (const std::string why = whySpace(scene); !why.empty()) return {false, why};
  const double tolerance = model::flatTolerance(scene.model);
  if (!model::liesFlat(scene.model.tiles, tolerance)) {
    return {false, model::sheetFrame(scene.model.tiles, tolerance)
                       ? "the start does not lie in a horizontal plane"
                       : "the start is not flat"};
  }
  for (const std::vector<model::Tile>* target : targets(scene)) {
    if (!model::liesFlat(*target, tolerance)) return {false, "the target is not flat"};
    if (std::abs(height(*target) - height(scene.model.tiles)) > tolerance) {
      return {false, "start and target lie at different heights"};
    }
    // A tile can only be turned over through space.
    if (model::countTurnedOver(scene.model.tiles, *target) > 0) {
      return {false, "tiles are turned over at the target"};
    }
  }
  if (std::ranges::any_of(scene.velocities, leavesPlane)) {
    return {false, "tiles begin with a speed out of the plane"};
  }
  if (foldsOutOfPlane(scene)) return {false, "springs fold the sheet as its file says"};
  if (dragsOutOfPlane(scene, tolerance)) return {false, "a tile is dragged out of the plane"};
  if (!scene.environment.obstacles.empty()) return {false, "obstacles push out of the plane"};
  const Vector3& gravity = scene.environment.gravity;
  if (!isVertical(gravity)) return {false, "gravity is not vertical"};
  const std::optional<Ground>& ground = scene.environment.ground;
  // Gravity down onto the ground is a normal force; anything else lifts or drops the sheet.
  if (gravity.z() > 0 || (gravity.z() < 0 && !ground)) {
    return {false, "gravity pulls out of the plane"};
  }
  if (gravity.z() < 0 && std::abs(ground->height - height(scene.model.tiles)) > tolerance) {
    return {false, "the sheet does not lie on the ground"};
  }
  return {true, !targets(scene).empty() ? "start and target lie in horizontal planes"
                                        : "the start lies in a horizontal plane"};
}

Need contactNeed(const Scene& scene) {
  switch (scene.environment.contacts) {
    case ContactFilter::Auto:
      return {false, "unless bricks meet on the way"};
    case ContactFilter::None:
      return {false, "not asked for"};
    case ContactFilter::Unjoined:
      return {true, "unjoined bricks may touch"};
    case ContactFilter::All:
      break;
  }
  return {true, "all bricks may touch"};
}

Need groundNeed(const Scene& scene, bool planar) {
  if (!scene.environment.ground) return {false, "no ground"};
  if (planar) return {false, "planar: gravity is the normal load, only friction is modelled"};
  return {true, "bricks may touch the ground"};
}

Need obstacleNeed(const Scene& scene) {
  if (scene.environment.obstacles.empty()) return {false, "none"};
  return {true, "bricks may touch them"};
}

/// --pin is an entry of the timeline, too.
const char* timelineReason(const Timeline& timeline) {
  const auto pins = [](const TimelineEntry& entry) {
    return std::holds_alternative<timeline::Pin>(entry.action);
  };
  return std::ranges::all_of(timeline, pins) ? "tiles are pinned" : "there is a timeline";
}

}  // namespace

bool isQuasiStatic(const Scene& scene, std::string& reason) {
  // Full extension has no end where a part is held by nothing.
  reason = scene.actuation.drive != defaultDrive(scene.model) ? "the actuation was given"
           : !scene.timeline.empty()                          ? timelineReason(scene.timeline)
           : !scene.velocities.empty()                        ? "tiles begin with a speed"
           : !scene.environment.obstacles.empty()             ? "there is ground or an obstacle"
           : scene.hinges.panels                              ? "tiles bend"
           : scene.hinges.areOn()                             ? "hinges have springs"
                                                              : whyDynamics(scene);
  return reason.empty();
}

Needs sceneNeeds(const Scene& scene) {
  Needs needs;
  needs.planar = planarNeed(scene);
  needs.contacts = contactNeed(scene);
  needs.ground = groundNeed(scene, needs.planar.on);
  needs.obstacles = obstacleNeed(scene);
  if (scene.model.tiles.size() < 2) needs.contacts = {false, "a single brick"};
  return needs;
}

}  // namespace kirireel::scene
