/// Additions of a run to the model that was read: other targets, pins, links, fixed joints.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Requested additions; their numbers are not checked yet.
struct SceneParts {
  std::vector<std::filesystem::path> targets;  ///< a chain, each reached before the next; the last
                                               ///< replaces the model's target
  std::vector<int> pinned;                     ///< tiles fixed to the world from the start
  std::vector<std::array<int, 2>> fixed;       ///< pairs of tiles that move as one
  std::vector<std::array<int, 4>> links;       ///< tile, vertex, tile, vertex
};

/// Completes a scene with a newly read model. Reads targets. Moves targets onto the start unless
/// scene.alignment is off, by the initially pinned tiles or, without these, by all tiles. Records
/// this motion. Adds joints and pins, reads the targets of the timeline and the file of hinges.
/// Checks the grips and the timeline against the model. Adds warnings for targets that are not
/// quite congruent. Throws InputError for files without a target of this model and for invalid tile
/// or vertex numbers.
void completeScene(const SceneParts& parts, Scene& scene, std::vector<std::string>& warnings);

/// Splits tiles of a completed scene, as splitTiles() of a model does. Numbers are those of the
/// model's file; empty: all tiles. Pins and speeds of a tile apply to all its parts. Throws
/// InputError for a tile that does not exist, and if drags, other targets, grips or a file of
/// hinges refer to tiles and their corners.
void splitTiles(const std::vector<int>& tiles, Scene& scene);

// ------------------------------------------------------------------------------------------------
// Torsional springs at hinges: those of a file and those of a scene.

/// Reads a file of springs, one hinge per line:
///
///     tile tile [stiffness [rest [damping]]]
///
/// in N m/rad, degrees and N m s/rad. Tile numbers are those of the model's file. A missing value
/// or - means the value of all hinges. Throws InputError with file:line:column for words, negative
/// numbers, tiles that do not exist, and a hinge that is listed twice.
std::vector<OwnHingeSpring> readHingeSprings(const std::filesystem::path& file,
                                             const model::Model& model);

/// The springs of a scene's hinges with a stiffness or a damping, in the order of findHinges().
/// Folds between tiles whose common corners are joined through others follow. If scene.hinges has
/// panels, parts of one tile have the stiffness bendStiffness() and rest at their current angle.
/// Folds without a given stiffness have foldStiffness() of their common edges. The rest angle
/// comes from the line, else from the setting of all hinges, else from the model's file for folds
/// (Model::foldAngles). Otherwise it is the angle at the start. `bricks` are the scene's. Throws
/// InputError if springs are requested but nothing has an axis, if a line of the file fits no
/// hinge, and if bricks overlap at the rest angle. Empty if scene.hinges requests nothing. Costs
/// about O(joints log joints).
std::vector<brick::HingeSpring> hingeSprings(const Scene& scene,
                                             const std::vector<brick::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// Connections between the tiles of a sheet whose joints can be necks of material.

/// Exact joints, and the forces between pairs of bricks: ligaments that replace other joints, and
/// all other pair forces.
struct Ties {
  std::vector<brick::Pivot> pivots;  ///< exact joints
  brick::PairForces pairForces;      ///< between pairs of bricks
};

/// The ties of a scene's run, for loading by grips or for dynamics. Throws InputError.
Ties tiesOf(const Scene& scene, const std::vector<brick::Brick>& bricks);

/// The ties of a planar scene under grips. A joint at a hinge with a spring is a neck if the scene
/// has necks. If tiles bend, there are no pivots, because corners are nodes. Throws InputError for
/// ligaments without stretch or shear, and like hingeSprings().
Ties loadedTies(const Scene& scene, const std::vector<brick::Brick>& bricks);

/// The ties of a dynamic scene. If it requests ligaments, as loadedTies(), only for planar scenes.
/// Otherwise its joints are exact and at the tiles' corners. Throws InputError.
Ties dynamicTies(const Scene& scene, const std::vector<brick::Brick>& bricks);

/// A kind of force between pairs of bricks. A new kind needs its class and a row here.
struct PairForceKind {
  const brick::PairForceName& name;  ///< constant of its class
  /// The scene's force of this kind between its bricks; null or without pairs if there is none.
  /// Throws InputError. Null for ligaments, which replace joints in the ties.
  std::shared_ptr<const brick::PairForce> (*make)(const Scene& scene,
                                                  const std::vector<brick::Brick>& bricks);
  /// The force from a file. Throws InputError.
  std::shared_ptr<const brick::PairForce> (*read)(const brick::PairReader& file);
};

/// All kinds, in the order of the summaries.
const std::vector<PairForceKind>& pairForceKinds();

}  // namespace kirireel::scene
