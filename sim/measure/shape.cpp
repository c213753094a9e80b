// Sizes of a whole state. The area within a closed outline p_0 ... p_(n-1) is the shoelace sum 1/2
// sum (x_k y_(k+1) - x_(k+1) y_k), taken about the first corner. Poisson's ratio uses logarithmic
// strains, which add up over successive deformations, so that it does not depend on the state that
// is taken for the start as long as the ratio itself is constant.
#include "sim/measure/shape.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kirireel {
namespace {

/// Parts of the box's diagonal by which flat tiles may leave their plane.
constexpr double kFlat = 1e-6;
/// Strains below this say nothing.
constexpr double kLeastStrain = 1e-3;

using Points = std::vector<Eigen::Vector2d>;

/// Appends one half of the outline of points in order of x: those between which it turns left
/// (Andrew 1979). The last is left out, it begins the other half.
template <typename Iterator>
void appendHalf(Iterator begin, Iterator end, Points& outline) {
  const std::size_t first = outline.size();
  for (Iterator point = begin; point != end; ++point) {
    while (outline.size() > first + 1) {
      const Eigen::Vector2d along = outline.back() - outline[outline.size() - 2];
      const Eigen::Vector2d next = *point - outline.back();
      if (along.x() * next.y() - along.y() * next.x() > 0) break;
      outline.pop_back();
    }
    outline.push_back(*point);
  }
  outline.pop_back();
}

/// The corners of the convex outline seen along z, anticlockwise. (outlineCorners() in hull.h keeps
/// every vertex on it too.)
Points convexOutline(const std::vector<Tile>& tiles) {
  Points points;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) points.emplace_back(vertex.head<2>());
  }
  std::ranges::sort(points, {}, [](const Eigen::Vector2d& p) { return std::tuple(p.x(), p.y()); });
  Points outline;
  if (points.empty()) return outline;
  appendHalf(points.begin(), points.end(), outline);
  appendHalf(points.rbegin(), points.rend(), outline);
  return outline;
}

}  // namespace

Vector3 boxSides(const std::vector<Tile>& tiles) {
  Eigen::AlignedBox3d box;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) box.extend(vertex);
  }
  return box.isEmpty() ? Vector3(Vector3::Zero()) : box.sizes();
}

HullSize hullSize(const std::vector<Tile>& tiles) {
  const Points corners = convexOutline(tiles);
  HullSize size;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    // From the first corner, so that a sheet far from the origin loses no digits.
    const Eigen::Vector2d from = corners[k] - corners[0];
    const Eigen::Vector2d to = corners[(k + 1) % corners.size()] - corners[0];
    size.area += 0.5 * (from.x() * to.y() - from.y() * to.x());
    size.perimeter += (to - from).norm();
  }
  return size;
}

std::optional<double> coveredArea(const std::vector<Tile>& tiles) {
  if (!liesFlat(tiles, kFlat * boxSides(tiles).norm())) return std::nullopt;
  double area = 0;
  for (const Tile& tile : tiles) area += tileArea(tile);
  return area;
}

std::optional<double> poissonsRatio(const Vector3& sidesBefore, const Vector3& sides) {
  if ((sidesBefore.head<2>().array() <= 0).any() || (sides.head<2>().array() <= 0).any()) {
    return std::nullopt;
  }
  const Eigen::Array2d strains = (sides.head<2>().array() / sidesBefore.head<2>().array()).log();
  if (std::abs(strains.x()) < kLeastStrain) return std::nullopt;
  return -strains.y() / strains.x();
}

std::vector<double> openingAngles(const std::vector<Joint>& joints, const Poses& poses) {
  std::vector<double> angles;
  angles.reserve(joints.size());
  for (const Joint& joint : joints) {
    angles.push_back(
        turnBetween(poses[joint.a.tile].rotation, poses[joint.b.tile].rotation).norm());
  }
  return angles;
}

}  // namespace kirireel
