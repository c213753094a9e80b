/// Tiles in parts: convex parts of concave tiles, rigid parts of tiles that bend.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Concave polygons as convex parts, for all that needs convex shapes: contacts, depths, painting,
// meshes of elements.
//
// 1. *Ear clipping* (Meisters, "Polygons have ears", 1975): a corner that turns left and whose
//    triangle with its two neighbours holds no other corner is cut off; a simple polygon always
//    has one. Of all ears the one with the largest least sine goes first, so that triangles are
//    not thinner than need be. n corners give n - 2 triangles in O(n^3), n is 300 at most.
// 2. *Merging* (Hertel and Mehlhorn 1983): a diagonal goes where both its ends stay convex without
//    it. What is left has at most four times the least number of parts.
//
// All corners stay, also those in the middle of a straight side, since joints may hold them.

/// Corner numbers of a part, anticlockwise.
using PolygonPart = std::vector<int>;

/// Whether a polygon that is anticlockwise seen from `normal` counts as convex: corners turn
/// inwards by no more than what optimised designs carry (a sine of 0.03 each, 0.06 in all).
bool isConvexPolygon(std::span<const Vector3> corners, const Vector3& normal);

/// Two sides of a polygon that meet where they must not, by the numbers of their first corners;
/// none where the polygon is simple. Seen along `normal`. Sides that follow each other may only
/// share their corner. `tolerance` in metres: sides nearer than that touch.
std::optional<std::pair<int, int>> crossingSides(std::span<const Vector3> corners,
                                                 const Vector3& normal, double tolerance);

/// The triangles of a simple polygon, anticlockwise seen from `normal`; a fan from corner 0 where
/// it is convex.
/// A polygon whose sides cross gives triangles that overlap; crossingSides() is to be asked first.
std::vector<std::array<int, 3>> trianglesOf(std::span<const Vector3> corners,
                                            const Vector3& normal);

/// The convex parts of a simple polygon; one with all corners where it is convex.
/// Each diagonal that is left is a side of two parts, in opposite directions.
std::vector<PolygonPart> convexParts(std::span<const Vector3> corners, const Vector3& normal);

/// The corners of the convex outline of points in the plane, anticlockwise, none in the middle of a
/// side; no points have none. Andrew's monotone chain (Information Processing Letters 9, 1979),
/// O(n log n).
std::vector<Eigen::Vector2d> convexOutline(std::vector<Eigen::Vector2d> points);

// ------------------------------------------------------------------------------------------------
// Tiles that bend: rigid parts hinged along their common edges.

/// The triangles that a tile is split into, its corner numbers anticlockwise: by the diagonals from
/// the corner whose diagonals are shortest, concave tiles into ears.
std::vector<std::array<int, 3>> tileTriangles(const Tile& tile);

/// The model with the given tiles, in the numbers of its file, (all, when empty) split into
/// triangles by the diagonals from the corner whose diagonals are shortest, concave ones into ears;
/// triangles stay whole. Parts are joined at both ends of a common diagonal on the bottom face, a
/// hinge. The first part keeps the tile's number, the others follow after the last tile; joints
/// hold the first part that has their corner, targets are split alike, and all parts of a pulled
/// tile are pulled. Throws InputError for a tile that does not exist.
Model splitTiles(const Model& model, const std::vector<int>& tiles);

}  // namespace kirireel::model
