// The needs of a scene: determined only from the scene before a run, each with its reason for the
// summary.
//
// *Planar* scenes have three degrees of freedom per tile instead of six. A step is then about three
// times faster. A scene is planar if nothing can push a brick out of its plane: start and all
// targets lie in the plane of the sheet frame (to 1e-9 of the model's size), no tile is turned
// over, and no speed, drag, obstacle or gravity points out of the plane, unless the ground balances
// gravity. Gravity along the plane is planar for ligaments only. *Quasi-static* scenes need no
// dynamics: geometry determines the path of the sheet, and its mechanism can be followed without
// masses and time. All user settings in addition to the model and the output (a drive, a timeline,
// springs, friction, ...) require dynamics.
#include "sim/scene/scene_needs.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include "sim/scene/settings.h"

namespace kirireel::scene {
namespace {

// Relative to a vector's length: a smaller out-of-plane part is rounding in its file.
constexpr double kRounding = 1e-12;

double height(const model::SheetFrame& frame, const std::vector<model::Tile>& tiles) {
  return frame.toFrame(tiles.front().vertices.front()).z();
}

bool isInPlane(const model::SheetFrame& frame, const Vector3& vector) {
  return std::abs(frame.normal.dot(vector)) <= kRounding * vector.norm();
}

/// All targets of the springs.
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

/// Whether a drag leaves the height range of the sheet's bricks.
bool dragsOutOfPlane(const Scene& scene, const model::SheetFrame& frame, double tolerance) {
  const double bottom = height(frame, scene.model.tiles) - tolerance;
  // A drag within the thickness of the bricks counts as in-plane.
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
  return !isInPlane(frame, velocity.linear) || along.norm() > kRounding * velocity.angular.norm();
}

/// Why gravity and the ground cause spatial motion of a flat sheet; empty if they do not. Gravity
/// along the plane acts at the mass centres. Joints on one face are half a thickness off, so it can
/// tilt tiles. Ligaments have no such offset.
std::string whyGravityLifts(const Scene& scene, const model::SheetFrame& frame, double tolerance) {
  const Vector3& gravity = scene.environment.gravity;
  const std::optional<Ground>& ground = scene.environment.ground;
  const bool isAlong = scene.hinges.hasLigaments() && isInPlane(frame, gravity);
  if (!frame.isHorizontal()) {
    if (ground) return "the sheet does not lie on the ground";
    return gravity.isZero(0) || isAlong ? "" : "there is gravity and the sheet is not horizontal";
  }
  if (!(gravity.x() == 0 && gravity.y() == 0) && !isAlong) return "gravity is not vertical";
  // Gravity towards the ground is balanced by a normal force. Otherwise the sheet rises or falls.
  if (gravity.z() > 0 || (gravity.z() < 0 && !ground)) return "gravity pulls out of the plane";
  const double level = frame.origin.z();
  if (gravity.z() < 0 && std::abs(ground->height - level) > tolerance) {
    return "the sheet does not lie on the ground";
  }
  return "";
}

/// Whether springs at folds rest out of the plane: by the model's file, or by their own angle to
/// one side.
bool foldsOutOfPlane(const Scene& scene) {
  constexpr double kFlatFoldAngle = 1e-6 * kDegree;
  const bool isFlat = scene.hinges.rest && std::abs(*scene.hinges.rest) <= kFlatFoldAngle;
  return scene.hinges.areOn() && !isFlat &&
         std::ranges::any_of(scene.model.foldAngles, [](const auto& fold) {
           return std::abs(fold.second) > kFlatFoldAngle;
         });
}

// Reports the first reason, ordered from basic to special.
Need planarNeed(const Scene& scene) {
  // The user's choice has priority.
  if (scene.solver.planar) return {*scene.solver.planar, "requested"};
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
    return {false, "tiles have initial velocities out of the plane"};
  }
  if (foldsOutOfPlane(scene)) return {false, "springs fold the sheet to the angles of its file"};
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
      return {false, "unless bricks touch on the path"};
    case ContactFilter::None:
      return {false, "not requested"};
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

/// --pin is also an entry of the timeline.
const char* timelineReason(const Timeline& timeline) {
  const auto pins = [](const TimelineEntry& entry) {
    return std::holds_alternative<timeline::Pin>(entry.action);
  };
  return std::ranges::all_of(timeline, pins) ? "tiles are pinned" : "there is a timeline";
}

}  // namespace

bool isQuasiStatic(const Scene& scene, std::string& reason) {
  // Full extension has no end state if a part is unconnected.
  reason = scene.actuation.drive != defaultDrive(scene.model) ? "`actuation` is set"
           : !scene.timeline.empty()                          ? timelineReason(scene.timeline)
           : !scene.velocities.empty()                        ? "tiles have initial velocities"
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
// Planar scenes in the axes of their sheet.

std::optional<model::SheetFrame> ownAxes(const Scene& scene) {
  if (scene.model.tiles.empty()) return std::nullopt;
  std::optional<model::SheetFrame> frame = model::sheetFrame(scene.model);
  if (!frame || frame->isHorizontal() || !sceneNeeds(scene).planar.on) return std::nullopt;
  if (!scene.environment.ground) return frame;
  throw InputError(
      "error: `planar = on` with a ground needs a horizontal sheet. Remove one of them");
}

Scene withoutEnvironment(Scene scene) {
  scene.environment = Environment{};
  return scene;
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
