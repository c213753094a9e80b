/// Measures of each brick by itself, for colours and tables.
#pragma once

#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/brick/hinge.h"
#include "sim/model/model.h"

namespace kirireel {

/// For each brick the largest distance of its bottom vertices from their targets, metres.
/// `target` has one tile a brick, vertex by vertex.
std::vector<double> brickTargetErrors(const std::vector<Tile>& target,
                                      const std::vector<Brick>& bricks, const Poses& poses);

/// For each brick the distance of its centre of mass from where it started, metres.
std::vector<double> brickDisplacements(const Poses& start, const Poses& poses);

/// For each brick the angle by which it is turned from its start, radians, 0 to pi.
std::vector<double> brickRotations(const Poses& start, const Poses& poses);

/// For each brick the largest gap of its pivots, metres; 0 for a brick without joints.
std::vector<double> brickJointGaps(std::span<const Pivot> pivots, const Poses& poses);

/// For each brick the largest moment of the springs at its hinges, in size, N m; 0 without any.
std::vector<double> brickMoments(std::span<const HingeSpring> springs, const Poses& poses);

/// For each brick what the springs at its hinges hold, joules: each of a spring's two bricks counts
/// one half, so that all bricks together hold what all springs do.
std::vector<double> brickElasticEnergies(std::span<const HingeSpring> springs, const Poses& poses);

}  // namespace kirireel
