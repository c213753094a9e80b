/// Rigid motions of point sets: best fits, and the symmetries of a model.
#pragma once

#include <span>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/model.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// Best rigid fits between point sets (Kabsch 1976), and the alignment of a model's start to its
// target.

/// A proper rigid motion x -> rotation * x + translation.
struct RigidMotion {
  Matrix3 rotation = Matrix3::Identity();  ///< proper
  Vector3 translation = Vector3::Zero();   ///< after the rotation, metres

  /// The image of a point, metres.
  Vector3 apply(const Vector3& point) const { return rotation * point + translation; }
};

/// The rigid motion of `from` nearest to `to` in the sum of squares; never a reflection. Both have
/// the same length, at least one point.
RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to);

/// The same with weights, one per point, >= 0 and not all 0. Not checked: the result is undefined
/// for other lengths or a weight sum of 0.
RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to,
                            std::span<const double> weights);

/// The vertices of all tiles in their order, metres.
std::vector<Vector3> allVertices(const std::vector<Tile>& tiles);

/// The tiles after the rigid motion that fits their vertices best to those of `onto`, the same
/// tiles in another state.
std::vector<Tile> bestFitted(std::vector<Tile> tiles, const std::vector<Tile>& onto);

/// Moves a model's start onto its target by the best rigid motion of all vertices together, as
/// PyKirigami does. If some tiles are held at their position, only vertices of these `held` tiles
/// count. If start and target lie in parallel planes, the rotation is only about their normal,
/// without turning over. Returns the motion; identity without a target.
RigidMotion alignStartToTarget(Model& model, std::span<const int> held = {});

/// Moves a target state onto the model's start like alignStartToTarget(), and returns the motion. A
/// flat state that lies upside down as a whole is turned over. `state` has the model's tiles.
RigidMotion alignToStart(const Model& model, std::vector<Tile>& state,
                         std::span<const int> held = {});

// ------------------------------------------------------------------------------------------------
// The symmetries of a model, and symmetric states.

/// An isometry about the common centre of the tiles that maps a model onto itself.
struct Symmetry {
  Matrix3 turn = Matrix3::Identity();  ///< orthogonal: a rotation, possibly with a reflection
  std::vector<int> images;             ///< image of each tile
};

/// The group of all isometries that map the start to itself, and with the same permutation of tiles
/// also the target, the normals, joints and pulled tiles. The identity is first. Start and target
/// must be aligned: an isometry rotates both equally, each about its own centre. Positions are
/// equal up to 1e-9 of a tile. Tiles that coincide in both states are indistinguishable. A model
/// with such tiles has only the identity.
std::vector<Symmetry> symmetriesOf(const Model& model);

/// Moves the vertices of start and target to the means of their images under the model's
/// symmetries. Symmetries within symmetriesOf()'s tolerance then hold up to rounding. Does not
/// change a model that is already symmetric up to rounding, or whose tiles were rounded.
void symmetrise(Model& model);

/// A few symmetries whose products are the whole group.
std::vector<Symmetry> generatorsOf(std::span<const Symmetry> group);

/// The deviation of a state's images under the symmetries: the largest distance of a centre of
/// mass, metres, or rotation angle times `radius`.
double asymmetry(const Poses& poses, std::span<const Symmetry> group, double radius);

/// The mean of a state's images under a group of symmetries, about the state's own centre. It is
/// symmetric up to rounding, and near the state if that is nearly symmetric.
Poses symmetricMean(const Poses& poses, std::span<const Symmetry> group);

/// The same for velocities, one per tile.
std::vector<Velocity> symmetricMean(const std::vector<Velocity>& velocities,
                                    std::span<const Symmetry> group);

}  // namespace kirireel::model
