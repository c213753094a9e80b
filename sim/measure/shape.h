/// What a sheet measures as a whole in one state: sizes, areas, openings.
#pragma once

#include <optional>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel {

/// Sides of the box around all vertices, along x, y and z, metres.
Vector3 boxSides(const std::vector<Tile>& tiles);

/// The convex outline of all vertices seen along z.
struct HullSize {
  double area = 0;       ///< square metres
  double perimeter = 0;  ///< metres
};

/// Of one or more tiles.
/// O(n log n) in the vertices. A sheet that is seen from its edge has the area 0.
HullSize hullSize(const std::vector<Tile>& tiles);

/// The tiles' area, square metres, where all of them lie in one horizontal plane (to 1e-6 of the
/// box); none in space, where they hide each other. What tiles overlap counts for each of them.
std::optional<double> coveredArea(const std::vector<Tile>& tiles);

/// Poisson's ratio from one state to another, of logarithmic (Hencky) strains of the box's sides:
///   -log(y / y0) / log(x / x0),
/// so that rotating squares have -1 at any opening. None where x hardly changes, by less than 1e-3
/// of itself, since rounding would decide.
std::optional<double> poissonsRatio(const Vector3& sidesBefore, const Vector3& sides);

/// For each joint the angle by which its tiles are turned against each other since the start, when
/// all rotations are identities: how far it is open. Radians, 0 to pi.
/// `poses` has one pose a tile. In the order of the joints; links and fixed joints count too.
std::vector<double> openingAngles(const std::vector<Joint>& joints, const Poses& poses);

}  // namespace kirireel
