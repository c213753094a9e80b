// Springs from the hull's corners to an ellipse. With the middle m of the hull's corners and the
// half axes a (along x) and b (along y), the ray from m through a corner leaves the ellipse at
//   m + (x, y) / sqrt((x / a)^2 + (y / b)^2),      (x, y) = corner - m
// which is the corner's anchor, at the corner's own height. b is the wanted size times the radius
// of the smallest circle about m that holds all corners, a is b times the aspect. Anchors stay
// where they are: the sheet grows towards them.
#include "sim/actuation/boundary_springs.h"

#include <algorithm>
#include <cmath>

#include "sim/base/error.h"
#include "sim/model/hull.h"

namespace kirireel {
namespace {

/// Where the ray from the middle of an ellipse through a point leaves it; the height stays.
Vector3 ellipsePoint(const Vector3& middle, double halfLength, double halfWidth,
                     const Vector3& point) {
  const double x = point.x() - middle.x();
  const double y = point.y() - middle.y();
  const double scale = 1 / std::hypot(x / halfLength, y / halfWidth);
  return {middle.x() + scale * x, middle.y() + scale * y, point.z()};
}

}  // namespace

BoundarySprings::BoundarySprings(const Model& model, const std::vector<Brick>& bricks,
                                 const TargetSpringSettings& settings, const BoundaryCurve& curve)
    : settings_(settings), springs_(bricks.size()) {
  // The model named a hull that could not be read. Only this drive needs one, so that only it
  // refuses.
  if (!model.hullFault.empty()) {
    throw InputError(model.hullFault + "; or remove it, and the convex outline is pulled instead");
  }
  const std::vector<Corner> hull = model.hull ? *model.hull : outlineCorners(model.tiles);
  std::vector<Vector3> corners;
  for (const Corner& corner : hull) {
    corners.push_back(model.tiles[corner.tile].vertices[corner.vertex]);
  }
  const Vector3 middle = meanPoint(corners);
  double radius = 0;
  for (const Vector3& corner : corners) {
    radius = std::max(radius, (corner - middle).head<2>().norm());
  }
  const double halfWidth = curve.size * radius;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    anchors_.push_back(ellipsePoint(middle, curve.aspect * halfWidth, halfWidth, corners[k]));
    const int tile = hull[k].tile;
    springs_[tile].push_back(
        {bricks[tile].bottom[hull[k].vertex], anchors_.back(), settings.springStiffness, 0});
  }
}

void BoundarySprings::addLoads(const Poses& poses, std::vector<Load>& loads) const {
  Vector6 damping;
  damping << Vector3::Constant(settings_.forceDamping), Vector3::Constant(settings_.torqueDamping);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    // Every brick is damped, also those without a spring.
    loads[i].damping.diagonal() += damping;
    for (const PointSpring& spring : springs_[i]) addPointSpring(spring, poses[i], loads[i]);
  }
}

double BoundarySprings::energy(const Poses& poses) const {
  double sum = 0;
  for (std::size_t i = 0; i < springs_.size(); ++i) {
    for (const PointSpring& spring : springs_[i]) sum += pointSpringEnergy(spring, poses[i]);
  }
  return sum;
}

}  // namespace kirireel
