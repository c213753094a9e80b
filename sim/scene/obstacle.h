/// Things that do not move and that bricks run into.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"

namespace kirireel {

/// One thing that stays where it is. Joints, forces and drags do not move it.
struct Obstacle {
  enum class Shape {
    Box,
    Sphere,
    Mesh,  ///< a surface without thickness, met from both sides
  };
  Shape shape = Shape::Box;
  Vector3 size = Vector3::Ones();  ///< of a box, along its own axes, metres, above 0
  double radius = 1;               ///< of a sphere, metres, above 0
  std::vector<Tile> mesh;          ///< flat convex faces of a mesh, in its own axes
  Pose pose;                       ///< of the middle of a box or sphere, of a mesh's axes
  double friction = 0.5;           ///< Coulomb coefficient, from 0
};

/// The surface of an obstacle as outward anticlockwise polygons (a mesh's as they are), world axes.
/// A sphere's are the faces of a fine polyhedron with its corners on the sphere, for pictures.
std::vector<Tile> obstacleFaces(const Obstacle& obstacle);

/// The same for all obstacles, one after the other.
std::vector<Tile> obstacleFaces(const std::vector<Obstacle>& obstacles);

/// The lower face of an upright box about an obstacle's origin, turned and placed with it, and
/// anticlockwise seen from within: thickened by size.z it is the box.
Tile boxFloor(const Obstacle& obstacle, const Vector3& size);

}  // namespace kirireel
