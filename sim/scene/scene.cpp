#include "sim/scene/scene.h"

#include <algorithm>
#include <variant>

#include <fmt/format.h>

namespace kirireel::scene {
namespace {

double lowestPoint(const std::vector<model::Tile>& tiles, const brick::BrickRule& rule) {
  const std::vector<brick::Brick> bricks = brick::makeBricks(tiles, rule);
  const Poses poses = brick::startPoses(tiles, bricks);
  double lowest = std::numeric_limits<double>::max();
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    for (const Vector3& point : bricks[i].bottom)
      lowest = std::min(lowest, poses[i].apply(point).z());
    for (const Vector3& point : bricks[i].top) lowest = std::min(lowest, poses[i].apply(point).z());
  }
  return lowest;
}

}  // namespace

std::string describe(const StartAlignment& alignment, const LengthUnit& unit) {
  return fmt::format(
      "the {} was moved by up to {} and rotated by {:.3g} degrees to match the {}{} (`align = "
      "false` keeps its position)",
      alignment.movesStart ? "start" : "target", lengthText(alignment.moved, unit),
      alignment.turned / kDegree, alignment.movesStart ? "target" : "start",
      alignment.byHeld ? ", aligned at its pinned tiles" : "");
}

TargetSpringSettings paperSprings() {
  TargetSpringSettings springs;
  springs.springStiffness = springs.torqueStiffness = 100;
  springs.forceDamping = 50;
  springs.torqueDamping = 2;
  return springs;
}

Scene openScene() {
  Scene scene;
  scene.brick.thickness = 0;
  scene.actuation.drive = Drive::Auto;
  scene.environment.contacts = ContactFilter::Auto;
  scene.path.kind = PathKind::Auto;
  scene.solver.tolerance = kDefaultTolerance;
  return scene;
}

Drive defaultDrive(const model::Model& model) {
  return model.target ? Drive::Target : Drive::Expansion;
}

void scaleLengths(Scene& scene, double factor) {
  scene.brick.thickness *= factor;
  if (scene.environment.ground) scene.environment.ground->height *= factor;
  for (Obstacle& obstacle : scene.environment.obstacles) {
    obstacle.size *= factor;
    obstacle.radius *= factor;
    obstacle.pose.position *= factor;
    const double meshFactor = obstacle.meshUnit ? obstacle.meshUnit->metres : factor;
    for (model::Tile& face : obstacle.mesh) {
      for (Vector3& vertex : face.vertices) vertex *= meshFactor;
    }
  }
  if (scene.hinges.neck) {
    scene.hinges.neck->width *= factor;
    scene.hinges.neck->length *= factor;
  }
  if (scene.hinges.ligament) scene.hinges.ligament->length *= factor;
  if (scene.hinges.panels) scene.hinges.panels->foldLength *= factor;
  for (TimelineEntry& entry : scene.timeline) {
    if (entry.when.kind == Trigger::Kind::ErrorBelow) entry.when.value *= factor;
    if (auto* drag = std::get_if<timeline::Drag>(&entry.action)) {
      for (Vector3& point : drag->path) point *= factor;
    }
  }
  for (InitialVelocity& velocity : scene.velocities) velocity.linear *= factor;
  for (GripSetting& grip : scene.grips) {
    if (grip.isForce) continue;
    for (std::optional<double>* move : {&grip.x, &grip.y, &grip.z}) {
      if (*move) **move *= factor;
    }
  }
}

void fillFromModel(Scene& scene) {
  if (scene.actuation.drive == Drive::Auto) scene.actuation.drive = defaultDrive(scene.model);
  if (scene.brick.thickness == 0)
    scene.brick.thickness = brick::kDefaultThickness * model::tileSize(scene.model);
}

double lowestPoint(const Scene& scene) {
  const double start = lowestPoint(scene.model.tiles, scene.brick);
  if (!scene.model.target) return start;
  return std::min(start, lowestPoint(*scene.model.target, scene.brick));
}

double lowestPoint(const model::Model& model) {
  double lowest = std::numeric_limits<double>::infinity();
  const auto lower = [&](const std::vector<model::Tile>& tiles) {
    for (const model::Tile& tile : tiles) {
      for (const Vector3& vertex : tile.vertices) lowest = std::min(lowest, vertex.z());
    }
  };
  lower(model.tiles);
  if (model.target) lower(*model.target);
  return lowest;
}

}  // namespace kirireel::scene
