/// What pushes a brick, in the form that both an explicit and an implicit solver can use.
#pragma once

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"

namespace kirireel {

/// Force and torque on one brick about its centre of mass, world axes, with their derivatives:
///   load(q + dq, u) = force - stiffness dq - damping u,
/// where dq and u stack a translation and a rotation vector. Stiffness and damping are symmetric
/// and positive semidefinite, so that an implicit step never diverges.
/// Loads of several sources add up, field by field.
struct Load {
  Vector6 force = Vector6::Zero();      ///< (N, N m) at zero velocity
  Matrix6 stiffness = Matrix6::Zero();  ///< minus the derivative by position, indefinite part cut
  Matrix6 damping = Matrix6::Zero();    ///< minus the derivative by velocity

  void transfer(StateTape& tape) { tape.transfer(force, stiffness, damping); }
};

}  // namespace kirireel
