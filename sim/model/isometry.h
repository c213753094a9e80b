/// Rigid motions of point sets: best fits, and the symmetries of a model.
#pragma once

#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Best rigid fits between point sets (Kabsch 1976), and turning a model's start into its target's
// axes.

/// A proper rigid motion x -> rotation * x + translation.
struct RigidMotion {
  Matrix3 rotation = Matrix3::Identity();  ///< proper
  Vector3 translation = Vector3::Zero();   ///< after the rotation, metres

  /// Where a point goes, metres.
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

// ------------------------------------------------------------------------------------------------
// The symmetries of a model, and states that have them.

/// An isometry about the common centre of the tiles that maps a model onto itself.
struct Symmetry {
  Matrix3 turn = Matrix3::Identity();  ///< orthogonal: a turn, or a turn with a reflection
  std::vector<int> images;             ///< the tile that each tile is mapped to
};

/// The group of all isometries that map the start onto itself, and with the same permutation of the
/// tiles the target, the tiles' normals, joints and pulled tiles; the identity first. Start and
/// target are to be aligned: an isometry maps both by the same turn, each about its own centre.
/// Places are the same up to 1e-9 of a tile. Tiles with one place in both states count as
/// one: a model that has such tiles has the identity alone.
std::vector<Symmetry> symmetriesOf(const Model& model);

/// Moves the vertices of start and target to the means of their images under the model's
/// symmetries: a model that has them within symmetriesOf()'s tolerance has them to rounding then.
/// One that has them to rounding already, and one whose tiles were rounded, stays as it is.
void symmetrise(Model& model);

/// How far a state's images under the symmetries are from it, the farthest centre of mass, metres,
/// or turn times `radius`.
double asymmetry(const Poses& poses, std::span<const Symmetry> group, double radius);

/// The mean of a state's images under a group of symmetries, about the state's own centre: it has
/// them all to rounding. Near the state where that nearly has them.
Poses symmetricMean(const Poses& poses, std::span<const Symmetry> group);

/// The same for velocities, one a tile.
std::vector<Velocity> symmetricMean(const std::vector<Velocity>& velocities,
                                    std::span<const Symmetry> group);

}  // namespace kirireel::model
