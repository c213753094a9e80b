// The needs of a scene: decided from the scene only, before anything moves, each with the reason
// that the summary states.
//
// *Planar* scenes have three degrees of freedom a tile in place of six, which makes a step about
// three times as cheap. A scene is planar where nothing can push a brick out of its plane: start
// and all targets lie in the plane of the sheet frame (to 1e-9 of the model's size), no tile is
// turned over on the way, no speed, drag, obstacle or gravity points out of the plane, unless the
// ground carries gravity's part. *Quasi-static* scenes need no dynamics: only geometry decides where the
// sheet goes. Its mechanism can be followed without masses and time. Everything that a user gives
// beyond the model and the numbers of the output (a drive, a timeline, springs, friction, ...)
// speaks of dynamics.
#include "sim/scene/scene_needs.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "sim/scene/settings.h"

namespace kirireel::scene {
namespace {

// Of a vector's length: a part out of the plane that is rounding of its file.
constexpr double kRounding = 1e-12;

double height(const model::SheetFrame& frame, const std::vector<model::Tile>& tiles) {
  return frame.toFrame(tiles.front().vertices.front()).z();
}

bool isVertical(const Vector3& vector) {
  return vector.x() == 0 && vector.y() == 0;
}

bool isInPlane(const model::SheetFrame& frame, const Vector3& vector) {
  return std::abs(frame.normal.dot(vector)) <= kRounding * vector.norm();
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
bool dragsOutOfPlane(const Scene& scene, const model::SheetFrame& frame, double tolerance) {
  const double bottom = height(frame, scene.model.tiles) - tolerance;
  // A drag within the thickness of the bricks is taken as one in their plane.
  const double top = bottom + scene.brick.thickness + 2 * tolerance;
  for (const TimelineEntry& entry : scene.timeline) {
    const auto* drag = std::get_if<timeline::Drag>(&entry.action);
    if (!drag) continue;
    for (const Vector3& point : drag->path) {
      const double z = frame.toFrame(point).z();
      if (z < bottom || z > top) return true;
    }
  }
  return false;
}

bool leavesPlane(const model::SheetFrame& frame, const InitialVelocity& velocity) {
  const Vector3 along = velocity.angular - frame.normal.dot(velocity.angular) * frame.normal;
  return !isInPlane(frame, velocity.linear) ||
         along.norm() > kRounding * velocity.angular.norm();
}

/// Why gravity and the ground move a flat sheet in space; empty if they do not.
std::string whyGravityLifts(const Scene& scene, const model::SheetFrame& frame, double tolerance) {
  const Vector3& gravity = scene.environment.gravity;
  const std::optional<Ground>& ground = scene.environment.ground;
  if (!frame.isHorizontal()) {
    if (ground) return "the sheet does not lie on the ground";
    return gravity.isZero(0) ? "" : "gravity pulls at a sheet that is not horizontal";
  }
  if (!isVertical(gravity)) return "gravity is not vertical";
  // Gravity down onto the ground is a normal force; anything else lifts or drops the sheet.
  if (gravity.z() > 0 || (gravity.z() < 0 && !ground)) return "gravity pulls out of the plane";
  const double level = frame.origin.z();
  if (gravity.z() < 0 && std::abs(ground->height - level) > tolerance) {
    return "the sheet does not lie on the ground";
  }
  return "";
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
  const std::optional<model::SheetFrame> frame = model::sheetFrame(scene.model);
  if (!frame) return {false, "the start is not flat"};
  for (const std::vector<model::Tile>* target : targets(scene)) {
    if (!model::isParallel(*frame, *target, tolerance)) {
      return {false, model::sheetFrame(*target, tolerance)
                         ? "start and target lie in different planes"
                         : "the target is not flat"};
    }
    if (std::abs(height(*frame, *target) - height(*frame, scene.model.tiles)) > tolerance) {
      return {false, "start and target lie at different heights"};
    }
    // A tile can only be turned over through space.
    if (model::countTurnedOver(scene.model.tiles, *target) > 0) {
      return {false, "tiles are turned over at the target"};
    }
  }
  const auto leaves = [&](const InitialVelocity& velocity) {
    return leavesPlane(*frame, velocity);
  };
  if (std::ranges::any_of(scene.velocities, leaves)) {
    return {false, "tiles begin with a speed out of the plane"};
  }
  if (foldsOutOfPlane(scene)) return {false, "springs fold the sheet as its file says"};
  if (dragsOutOfPlane(scene, *frame, tolerance)) {
    return {false, "a tile is dragged out of the plane"};
  }
  if (!scene.environment.obstacles.empty()) return {false, "obstacles push out of the plane"};
  if (const std::string why = whyGravityLifts(scene, *frame, tolerance); !why.empty()) {
    return {false, why};
  }
  if (!frame->isHorizontal()) {
    return {true, targets(scene).empty() ? "the start lies in one plane"
                                         : "start and target lie in one plane"};
  }
  return {true, targets(scene).empty() ? "the start lies in a horizontal plane"
                                       : "start and target lie in horizontal planes"};
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

// ------------------------------------------------------------------------------------------------
// A planar scene in the axes of its sheet.

std::optional<model::SheetFrame> ownAxes(const Scene& scene) {
  if (scene.model.tiles.empty()) return std::nullopt;
  std::optional<model::SheetFrame> frame = model::sheetFrame(scene.model);
  if (!frame || frame->isHorizontal() || !sceneNeeds(scene).planar.on) return std::nullopt;
  if (!scene.environment.ground) return frame;
  throw InputError(
      "error: `planar = on` keeps tiles in the plane of the sheet, which is not horizontal, but "
      "there is a ground; remove one of the two");
}

Scene inAxes(const model::SheetFrame& frame, Scene scene) {
  const Matrix3 toFrame = frame.axes().transpose();
  const auto turn = [&](std::vector<model::Tile>& tiles) {
    tiles = model::toFrame(frame, std::move(tiles));
  };
  turn(scene.model.tiles);
  if (scene.model.target) turn(*scene.model.target);
  for (std::vector<model::Tile>& state : scene.model.waypoints) turn(state);
  for (model::Joint& joint : scene.model.joints) joint.apart = toFrame * joint.apart;
  Vector3& gravity = scene.environment.gravity;
  if (!gravity.isZero(0)) gravity = toFrame * gravity;  // no -0, which is not the default
  for (TimelineEntry& entry : scene.timeline) {
    if (auto* goTo = std::get_if<timeline::GoTo>(&entry.action)) turn(goTo->tiles);
    if (auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
      for (Vector3& point : drag->path) point = frame.toFrame(point);
    }
  }
  for (InitialVelocity& velocity : scene.velocities) {
    velocity.linear = toFrame * velocity.linear;
    velocity.angular = toFrame * velocity.angular;
  }
  for (GripSetting& grip : scene.grips) grip.axes = toFrame * grip.axes;
  return scene;
}

}  // namespace kirireel::scene
