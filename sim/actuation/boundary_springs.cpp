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
