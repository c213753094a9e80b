#include "tests/golden/golden_scenes.h"

#include <cmath>

#include "sim/generate/lattice.h"
#include "tests/render/picture/sample_bricks.h"

namespace kirireel::test {
namespace {

brick::BrickRule thick(double thickness) {
  brick::BrickRule rule;
  rule.thickness = thickness;
  return rule;
}

/// Rotates bricks about z as the exact motion of a tessellation does.
GoldenScene openingScene(const std::string& name, const generate::TessellationShape& shape,
                         double angle) {
  const brick::BrickRule rule = thick(0.15);
  GoldenScene scene{
      name, picture::makeContent(generate::makeTessellation(shape), rule, std::nullopt), {}};
  const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, angle);
  scene.poses = brick::startPoses(tiles, brick::makeBricks(tiles, rule));
  for (std::size_t k = 0; k < scene.poses.size(); ++k) {
    // The rotation of the tile's first side since the start.
    const Vector3 now = tiles[k].vertices[1] - tiles[k].vertices[0];
    const Vector3 start = scene.content.bricks[k].bottom[1] - scene.content.bricks[k].bottom[0];
    const double turn = std::atan2(now.y(), now.x()) - std::atan2(start.y(), start.x());
    scene.poses[k].rotation = rotationFromVector(Vector3(0, 0, turn));
  }
  picture::keepInView(scene.content, scene.poses);
  return scene;
}

/// Bricks between a flat start and a target farther out.
GoldenScene brickScene(const std::string& name, const SampleBricks& sample, const Poses& start) {
  GoldenScene scene{name, {}, sample.poses};
  scene.content.bricks = sample.bricks;
  scene.content.start = start;
  for (int k = 0; k + 1 < static_cast<int>(sample.bricks.size()); ++k) {
    scene.content.pivots.push_back(
        {k, k + 1, sample.bricks[k].top[2], sample.bricks[k + 1].top[0], k});
  }
  Poses target = sample.poses;
  for (Pose& pose : target) pose.position *= 1.15;
  scene.content.target = brick::bottomTiles(sample.bricks, target);
  picture::keepInView(scene.content, sample.poses);
  return scene;
}

/// Bricks in many rotations, at these fractions of their distances.
GoldenScene turnedScene(const std::string& name, double share) {
  SampleBricks sample = tumbledBricks();
  for (Pose& pose : sample.poses) pose.position *= share;
  Poses start = sample.poses;
  for (Pose& pose : start) pose.rotation = Quaternion::Identity();
  return brickScene(name, sample, start);
}

/// A sheet of 8 x 6 squares whose bricks lie on a surface, which is a function of the position and
/// rotation of each.
template <typename Surface>
GoldenScene bentScene(const std::string& name, const Surface& surface) {
  std::vector<model::Tile> tiles;
  for (int k = 0; k < 48; ++k) tiles.push_back(rectangleTile(k % 8 - 4, k / 8 - 3, 1, 1));
  SampleBricks sample = sampleBricks(tiles, 0.12);
  const Poses flat = sample.poses;
  for (Pose& pose : sample.poses) pose = surface(pose.position.x(), pose.position.y());
  return brickScene(name, sample, flat);
}

Pose onCylinder(double x, double y) {
  const Quaternion turn = rotationFromVector(Vector3(0, x / 3, 0));
  return {turn * Vector3(0, 0, 3) + Vector3(0, y, 0), turn};
}

Pose onCap(double x, double y) {
  const Quaternion turn = rotationFromVector(Vector3(-y / 5, x / 5, 0));
  return {turn * Vector3(0, 0, 5), turn};
}

picture::Appearance coloured(picture::Colouring colouring,
                             picture::ColourMap map = picture::ColourMap::Viridis) {
  picture::Appearance appearance;
  appearance.colouring = colouring;
  appearance.map = map;
  return appearance;
}

picture::Appearance seen(const picture::ViewAngles& view,
                         std::optional<bool> orthographic = std::nullopt) {
  picture::Appearance appearance;
  appearance.camera.view = view;
  appearance.camera.orthographic = orthographic;
  return appearance;
}

/// An appearance with one field changed.
template <typename Value>
picture::Appearance with(Value picture::Appearance::*field, Value value) {
  picture::Appearance appearance;
  appearance.*field = value;
  return appearance;
}

}  // namespace

std::vector<GoldenScene> goldenScenes() {
  generate::TessellationShape rectangles;
  rectangles.columns = 6;
  rectangles.rows = 4;
  rectangles.length = 1.5;
  rectangles.width = 0.8;
  std::vector<GoldenScene> scenes;
  scenes.push_back(openingScene("squares", {}, 0.7));
  scenes.push_back(openingScene("rectangles", rectangles, 1.1));
  scenes.push_back(turnedScene("turned", 1));
  scenes.push_back(turnedScene("crossing", 0.5));
  scenes.push_back(bentScene("cylinder", onCylinder));
  scenes.push_back(bentScene("cap", onCap));
  return scenes;
}

std::vector<GoldenLook> goldenLooks() {
  picture::Appearance moving;
  moving.camera.orbit = 2;
  moving.camera.zoom = 1.3;
  return {
      {"plain", {}, {}},
      {"dark", with(&picture::Appearance::theme, picture::Theme::Dark), {}},
      {"transparent", with(&picture::Appearance::transparent, true), {}},
      {"plate", with(&picture::Appearance::ground, picture::GroundLook::Plate), {}},
      {"shadow", with(&picture::Appearance::ground, picture::GroundLook::Shadow), {}},
      {"without outlines", with(&picture::Appearance::outlines, false), {}},
      {"brick colour",
       with(&picture::Appearance::brickColour, std::optional(picture::Colour{190, 120, 150})),
       {}},
      {"pinned", {}, {0, 5}},
      {"joints", with(&picture::Appearance::jointMarks, true), {}},
      {"target lines", with(&picture::Appearance::targetLines, true), {}},
      {"shape", coloured(picture::Colouring::Shape), {}},
      {"state", coloured(picture::Colouring::State), {}},
      {"error", coloured(picture::Colouring::TargetError), {}},
      {"displacement", coloured(picture::Colouring::Displacement, picture::ColourMap::Cividis), {}},
      {"rotation", coloured(picture::Colouring::Rotation), {}},
      {"gap", coloured(picture::Colouring::JointGap), {}},
      {"top", seen(picture::kTopView), {}},
      {"parallel", seen(picture::kIsometricView, true), {}},
      {"yaw and pitch", seen(picture::viewFromYawPitch(0.9, -0.4)), {}},
      {"orbit", moving, {}}};
}

}  // namespace kirireel::test
