/// Best rigid fits between point sets (Kabsch 1976), and turning a model's start into its target's
/// axes.
#pragma once

#include <span>

#include "sim/model/model.h"

namespace kirireel {

/// A proper rigid motion x -> rotation * x + translation.
struct RigidMotion {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();

  Vector3 apply(const Vector3& point) const { return rotation * point + translation; }
};

/// The rigid motion that brings `from` nearest to `to` in the sum of squares; never a reflection.
/// Same length, at least one point.
RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to);

/// The same with squares that count by weights, one a point, from 0 and not all 0.
/// Nothing is checked here: with other lengths or with weights of sum 0 the result is not defined.
RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to,
                            std::span<const double> weights);

/// Moves the start tiles of a model with a target onto the target by the best rigid motion of all
/// vertices together, as PyKirigami does, or, where some tiles will be held where they are, of the
/// vertices of these `held` tiles alone. A start and target that each lie in a horizontal plane are
/// turned about the vertical alone (never flipped over). Returns the motion applied; identity
/// without target.
RigidMotion alignStartToTarget(Model& model, std::span<const int> held = {});

}  // namespace kirireel
