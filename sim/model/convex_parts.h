/// Parts of tiles: convex parts of concave tiles, rigid parts of tiles that bend.
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
// Divides concave polygons into convex parts, for all code that needs convex shapes: contacts,
// overlap depths, painting, element meshes.
//
// 1. *Ear clipping* (Meisters, "Polygons have ears", 1975): an ear is a convex corner whose
//    triangle with its two neighbours contains no other corner. A simple polygon always has one.
//    The ear with the largest minimum sine is cut off first, which avoids unnecessarily thin
//    triangles. n corners give n - 2 triangles in O(n^3), n <= 300.
// 2. *Merging* (Hertel and Mehlhorn 1983): a diagonal is removed if both its ends stay convex. The
//    result has at most four times the minimum number of parts.
//
// All corners are kept, including those within a straight side, since joints may use them.

/// Corner numbers of a part, anticlockwise.
using PolygonPart = std::vector<int>;

/// Whether a polygon that is anticlockwise seen from `normal` counts as convex: its inward turns
/// are within the range of optimised designs (a sine of at most 0.03 each, 0.06 in total).
bool isConvexPolygon(std::span<const Vector3> corners, const Vector3& normal);

/// Two sides of a polygon that cross or touch, by the numbers of their first corners. Absent if the
/// polygon is simple. Seen along `normal`. Consecutive sides may only share their corner.
/// `tolerance` in metres: nearer sides touch.
std::optional<std::pair<int, int>> crossingSides(std::span<const Vector3> corners,
                                                 const Vector3& normal, double tolerance);

/// The triangles of a simple polygon, anticlockwise seen from `normal`. A convex polygon gives a
/// fan from corner 0. A polygon with crossing sides gives overlapping triangles; check
/// crossingSides() first.
std::vector<std::array<int, 3>> trianglesOf(std::span<const Vector3> corners,
                                            const Vector3& normal);

/// The convex parts of a simple polygon. A convex polygon gives one part with all corners. Each
/// remaining diagonal is a side of two parts, in opposite directions.
std::vector<PolygonPart> convexParts(std::span<const Vector3> corners, const Vector3& normal);

/// The corners of the convex hull of points in the plane, anticlockwise, without corners that are
/// `flatness` or less beyond the line between their neighbours; < 0 keeps corners on straight
/// sides. Empty for one point or none. Andrew's monotone chain (Information Processing Letters 9,
/// 1979), O(n log n).
std::vector<Eigen::Vector2d> convexOutline(std::vector<Eigen::Vector2d> points,
                                           double flatness = 0);

/// One corner per vertex of the convex hull of all vertices in the xy plane, anticlockwise from the
/// leftmost (the lowest of several). The first of several corners at one point counts. Requires at
/// least one tile. Costs O(n log n) for n vertices.
std::vector<Corner> outlineCorners(const std::vector<Tile>& tiles);

// ------------------------------------------------------------------------------------------------
// Tiles that bend: rigid parts with hinges along their common edges.

/// The triangles of a split tile, with anticlockwise corner numbers. Cuts along the diagonals from
/// the corner with the shortest diagonals. Concave tiles are cut into ears.
std::vector<std::array<int, 3>> tileTriangles(const Tile& tile);

/// The model with these tiles (numbers of its file; empty: all) split into triangles as in
/// tileTriangles(). Triangles stay whole. Parts are joined at both ends of a common diagonal on the
/// bottom face, which is a hinge. The first part keeps the tile's number, the others follow after
/// the last tile. Joints hold the first part with their corner. Targets are split in the same
/// manner. All parts of a pulled tile are pulled. Throws InputError for a tile that does not exist.
Model splitTiles(const Model& model, const std::vector<int>& tiles);

}  // namespace kirireel::model
