/// States as VTK files, for ParaView.
///
/// Both formats are XML of VTK. ParaView opens the collection and plays the states in order of time.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "sim/trajectory/trajectory.h"

namespace kirireel::writers {

/// The text of an unstructured grid (.vtu). Each brick is one solid cell: a wedge for three
/// vertices, a hexahedron for four, else a polyhedron. A concave brick has one wedge for each of
/// its triangles. Lengths in `unit`, bitwise exact; arrays are compressed by zlib. Fields:
/// - of cells: `tile` (its number), `joint_gap` (the largest at the tile), `turn` (the angle from
///   the start, radians);
/// - of points: `displacement` from the start and, with a target, `target_distance` (of the tile's
///   vertex, the same at bottom and top);
/// - of the state: `TimeValue` (seconds) and the sample's measures.
///
/// Displacements are relative to the poses `start`.
std::string vtuText(const trajectory::Subject& subject, const Poses& start,
                    const trajectory::Sample& sample, const LengthUnit& unit = {});

/// The text of a collection (.pvd) of files with their times. Names are relative to the collection;
/// times are ascending, seconds.
std::string pvdText(const std::vector<std::pair<double, std::string>>& files);

}  // namespace kirireel::writers
