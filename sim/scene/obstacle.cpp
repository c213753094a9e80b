// Surfaces of obstacles as polygons, for pictures, and the floor that a box is thickened from. A
// sphere's polygons have their corners on the sphere, so that they lie within it by up to about
// one per cent of the radius; collisions use the exact sphere (world/sphere_pair.h).
#include "sim/scene/obstacle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/brick/brick.h"

namespace kirireel {
namespace {

// Of the polyhedron that stands for a sphere in pictures: bands from pole to pole, and twice as
// many round it.
constexpr int kBands = 16;

// A polygon in an obstacle's axes as one in the world's.
Tile placed(const Pose& pose, Tile tile) {
  for (Vector3& vertex : tile.vertices) vertex = pose.apply(vertex);
  return tile;
}

// The corner at a band's border (0 is the upper pole, kBands the lower one) and a sector's, metres.
Vector3 onSphere(const Obstacle& sphere, int band, int sector) {
  const double polar = std::numbers::pi * band / kBands;
  const double around = std::numbers::pi * sector / kBands;
  return sphere.pose.position + sphere.radius * Vector3(std::sin(polar) * std::cos(around),
                                                        std::sin(polar) * std::sin(around),
                                                        std::cos(polar));
}

// Corners go round each face counter-clockwise as seen from outside: down, along, up, back.
std::vector<Tile> sphereFaces(const Obstacle& sphere) {
  std::vector<Tile> faces;
  for (int band = 0; band < kBands; ++band) {
    for (int sector = 0; sector < 2 * kBands; ++sector) {
      Tile& face = faces.emplace_back();
      face.vertices = {onSphere(sphere, band, sector), onSphere(sphere, band + 1, sector)};
      // At a pole the two corners of a band's border coincide, so that one of them is left out.
      // Triangles at the poles.
      if (band + 1 < kBands) face.vertices.push_back(onSphere(sphere, band + 1, sector + 1));
      if (band > 0) face.vertices.push_back(onSphere(sphere, band, sector + 1));
    }
  }
  return faces;
}

// Floor and walls of a box in the world's axes.
std::vector<Tile> boxFaces(const Obstacle& box) {
  const Tile floor = boxFloor(box, box.size);
  // The brick of the floor is the box, so that pictures and contacts have the same faces.
  const Brick brick = makeBrick(floor, {.thickness = box.size.z()});
  std::vector<Tile> faces;
  for (std::vector<Vector3>& corners : brickFaces(brick)) {
    faces.push_back(placed({box.pose.position, Quaternion::Identity()}, {std::move(corners)}));
  }
  return faces;
}

}  // namespace

// The lower side of a box of that size, with its corners counter-clockwise from above in the box's
// own axes. `size` may differ from the obstacle's.
Tile boxFloor(const Obstacle& obstacle, const Vector3& size) {
  const Vector3 half = 0.5 * size;
  return placed(obstacle.pose, {{{-half.x(), -half.y(), -half.z()},
                                 {half.x(), -half.y(), -half.z()},
                                 {half.x(), half.y(), -half.z()},
                                 {-half.x(), half.y(), -half.z()}}});
}

std::vector<Tile> obstacleFaces(const Obstacle& obstacle) {
  switch (obstacle.shape) {
    case Obstacle::Shape::Box:
      return boxFaces(obstacle);
    case Obstacle::Shape::Sphere:
      return sphereFaces(obstacle);
    case Obstacle::Shape::Mesh:
      break;
  }
  std::vector<Tile> faces;
  for (const Tile& face : obstacle.mesh) faces.push_back(placed(obstacle.pose, face));
  return faces;
}

std::vector<Tile> obstacleFaces(const std::vector<Obstacle>& obstacles) {
  std::vector<Tile> all;
  for (const Obstacle& obstacle : obstacles) {
    for (Tile& face : obstacleFaces(obstacle)) all.push_back(std::move(face));
  }
  return all;
}

}  // namespace kirireel
