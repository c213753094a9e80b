/// The plane of a flat sheet and its upper side. "Flat", "clockwise" and "from above" refer to
/// them. Only gravity, the ground and the screen use z instead.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "sim/model/model.h"

namespace kirireel::model {

/// Right-handed axes of a flat sheet. The default is the plane z = 0 seen from above.
struct SheetFrame {
  Vector3 origin = Vector3::Zero();   ///< a point of the plane, metres
  Vector3 x = Vector3::UnitX();       ///< unit, in the plane
  Vector3 y = Vector3::UnitY();       ///< unit, in the plane
  Vector3 normal = Vector3::UnitZ();  ///< unit, to the upper side

  /// The coordinates of a point in these axes: two in the plane and its height above it, metres.
  Vector3 toFrame(const Vector3& point) const {
    const Vector3 arm = point - origin;
    return {x.dot(arm), y.dot(arm), normal.dot(arm)};
  }
  /// The point with these coordinates.
  Vector3 toWorld(const Vector3& point) const {
    return origin + point.x() * x + point.y() * y + point.z() * normal;
  }
  /// The axes as columns. Rotates a direction from these axes to world axes.
  Matrix3 axes() const {
    Matrix3 columns;
    columns << x, y, normal;
    return columns;
  }
  /// Converts a pose from these axes to world axes. The bricks' own axes are parallel to the same
  /// axes at the start. A rotation q = (w, v) becomes (w, axes v).
  Pose toWorld(const Pose& pose) const {
    const Quaternion& q = pose.rotation;
    Pose found{toWorld(pose.position)};
    found.rotation.w() = q.w();
    found.rotation.vec() = axes() * q.vec();
    return found;
  }
  /// The inverse of toWorld().
  Pose toFrame(const Pose& pose) const {
    const Quaternion& q = pose.rotation;
    Pose found{toFrame(pose.position)};
    found.rotation.w() = q.w();
    found.rotation.vec() = axes().transpose() * q.vec();
    return found;
  }
  /// Whether this is a horizontal plane seen from above.
  bool isHorizontal() const { return normal == Vector3::UnitZ(); }
};

/// The frame of a plane with this unit normal. The axes in the plane are x and y after the shortest
/// rotation of z onto the normal.
SheetFrame frameAlong(const Vector3& normal, const Vector3& origin);

/// The frame of tiles whose vertices lie in one plane, to the tolerance in metres; nullopt if they
/// do not. The upper side of a horizontal sheet is the side of +z. For any other sheet it is the
/// side from which most of the area has anticlockwise vertices; if both are equal, the first tile
/// decides. So the side rotates with the sheet. Coordinates x and y of a horizontal sheet are
/// unchanged. Needs at least one tile, and each tile needs an area.
std::optional<SheetFrame> sheetFrame(const std::vector<Tile>& tiles, double tolerance);

/// The same for the start of a model, to flatTolerance(). Parallel layers across an axis are not
/// flat, even if the file has few digits.
std::optional<SheetFrame> sheetFrame(const Model& model);

/// The frame in which the start of a model is seen from above, also if it is not flat: then along
/// the principal axis of its vertices that differs most from the other two, for example the axis of
/// a tube or of a cap. Along z if all three are equal, as in a cube.
SheetFrame viewFrame(const Model& model);

/// Tolerance of flatness: largest distance of a vertex from the plane, metres. Rounded coordinates
/// of a tilted sheet deviate by their last digit.
double flatTolerance(const Model& model);
/// The same for a model of this size and rounding, metres.
double flatTolerance(double size, double rounding);

/// The unit normal of tiles near one plane. It points to the side from which most of their area has
/// anticlockwise vertices, or to the side of `ifEven` if both are equal. Needs at least one tile.
Vector3 meanNormal(const std::vector<Tile>& tiles, const Vector3& ifEven);

/// The angle from the axes to the sides of the smallest rectangle around points in the plane,
/// radians, in (-pi/4, pi/4]. 0 unless this saves more than the fraction `gain`, in [0, 1), of the
/// area of the rectangle along the axes. Of equal rectangles, the one whose longer side has the
/// largest `weight`, if there is one: a function of its direction, a unit vector, with the same
/// value for the opposite direction. Then the one with the smallest rotation, anticlockwise if
/// there are two. Tries each side of the convex hull as a side of the rectangle (H. Freeman, R.
/// Shapira, Determining the minimum-area encasing rectangle for an arbitrary closed curve, Commun.
/// ACM 18, 1975).
double smallestRectangleAngle(std::vector<Eigen::Vector2d> points, double gain,
                              const std::function<double(const Eigen::Vector2d&)>& weight = {});

/// Whether all vertices lie in one plane parallel to the frame's, to the tolerance in metres.
bool isParallel(const SheetFrame& frame, const std::vector<Tile>& tiles, double tolerance);

/// The tiles in the frame's coordinates.
std::vector<Tile> toFrame(const SheetFrame& frame, std::vector<Tile> tiles);
/// The poses in the frame's axes; see SheetFrame::toFrame().
Poses toFrame(const SheetFrame& frame, Poses poses);
/// The inverse: poses in world axes.
Poses toWorld(const SheetFrame& frame, Poses poses);

}  // namespace kirireel::model
