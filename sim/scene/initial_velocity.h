/// How fast tiles move when a run begins.
#pragma once

#include <vector>

#include "sim/base/error.h"
#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/model/model.h"

namespace kirireel {

/// Tiles that begin to move as one rigid whole; joints take from that what they do not allow.
struct InitialVelocity {
  std::vector<int> tiles;             ///< empty: all
  Vector3 linear = Vector3::Zero();   ///< of their common centre of mass, m/s
  Vector3 angular = Vector3::Zero();  ///< about that, world axes, rad/s
  FileLocation where;
};

/// Turns numbers of tiles as the model's file counts them into those of the model. Throws
/// InputError for a tile that the model does not have.
void numberAsModel(std::vector<InitialVelocity>& velocities, const Model& model);

/// The velocity of each brick at these poses; where several are given for a brick they add up.
std::vector<Velocity> initialVelocities(const std::vector<InitialVelocity>& given,
                                        const std::vector<Brick>& bricks, const Poses& poses);

}  // namespace kirireel
