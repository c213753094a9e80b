/// What a run adds to the model that was read: other targets, pins, links, fixed joints.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/model/hinge.h"
#include "sim/scene/scene.h"

namespace kirireel::scene {

/// Additions as they were asked for; the numbers are not checked yet.
struct SceneParts {
  std::vector<std::filesystem::path> targets;  ///< a chain: each is reached before the next; the
                                               ///< last takes the place of the model's target
  std::vector<int> pinned;                     ///< tiles fixed to the world from the start
  std::vector<std::array<int, 2>> fixed;       ///< pairs of tiles that move as one
  std::vector<std::array<int, 4>> links;       ///< tile, vertex, tile, vertex
};

/// Completes a scene whose model was just read: reads targets, moves the start onto the target
/// unless scene.alignment is off (by the tiles that are pinned from the start on, where some are,
/// else by all) and notes by how much, adds joints and pins, reads the targets that the timeline
/// names and the file of hinges, checks the grips, and checks the timeline against the model.
/// Warnings about targets that are not quite congruent are appended. Throws InputError for files
/// that hold no target of this model and for numbers that name no tile or vertex.
void completeScene(const SceneParts& parts, Scene& scene, std::vector<std::string>& warnings);

/// Splits tiles of a completed scene, in the numbers of the model's file, all when empty: see
/// splitTiles() of a model. Pins and speeds of a tile are those of all its parts. Throws InputError
/// for a tile that does not exist, and where drags, other targets, grips or a file of hinges name
/// tiles and their corners.
void splitTiles(const std::vector<int>& tiles, Scene& scene);

// ------------------------------------------------------------------------------------------------
// Torsional springs at hinges: the file that lists them, and those of a scene.

/// Reads a file of springs, a hinge a line:
///
///     tile tile [stiffness [rest [damping]]]
///
/// in N m/rad, degrees and N m s/rad; tiles are numbered as in the model's file, and what a line
/// gives as - or omits is as for all hinges. Throws InputError with file:line:column for words,
/// numbers below 0, tiles that the model does not have, and a hinge that is listed twice.
std::vector<OwnHingeSpring> readHingeSprings(const std::filesystem::path& file,
                                             const model::Model& model);

/// The springs of a scene's hinges, in the order of findHinges(), and then of the folds between
/// tiles whose common corners are joined by way of others: those with a stiffness or a damping.
/// Where scene.hinges has panels, the stiffness between parts of one tile is bendStiffness(), at
/// rest in their present angle, and that of folds, unless given, foldStiffness() of their common
/// edges. Their rest angle is that of the line, else that of all hinges, else at a fold that of the
/// model's file (Model::foldAngles), else the angle at the start. `bricks` are the scene's. Throws
/// InputError where springs of hinges are asked for and nothing has an axis, where a line of the
/// file names no hinge, and where bricks would lie in each other at the rest angle. Empty where
/// scene.hinges asks for nothing. Costs about O(joints log joints).
std::vector<model::HingeSpring> hingeSprings(const Scene& scene,
                                             const std::vector<model::Brick>& bricks);

// ------------------------------------------------------------------------------------------------
// What holds the tiles of a sheet together where its joints are necks of material.

/// Joints that are exact, and the forces between pairs of bricks: ligaments in the place of other
/// joints, and what else acts between two bricks.
struct Ties {
  std::vector<model::Pivot> pivots;  ///< that are exact
  model::PairForces pairForces;      ///< between pairs of bricks
};

/// The ties of a scene's run, whether grips load it or masses move. Throws InputError.
Ties tiesOf(const Scene& scene, const std::vector<model::Brick>& bricks);

/// The ties of a planar scene under grips: a joint at a hinge with a spring is a neck where the
/// scene has necks. No pivots where tiles bend, whose corners are nodes. Throws InputError for
/// ligaments that could neither stretch nor shear, and as hingeSprings() does.
Ties loadedTies(const Scene& scene, const std::vector<model::Brick>& bricks);

/// The ties of a scene that moves masses: as loadedTies() where it asks for ligaments, which needs
/// a planar one; else its joints are exact, and turn about the tiles' corners. Throws InputError.
Ties dynamicTies(const Scene& scene, const std::vector<model::Brick>& bricks);

/// A kind of force between pairs of bricks: a new one is its class, and its row here.
struct PairForceKind {
  const model::PairForceName& name;  ///< its own constant
  /// The scene's force of this kind between its bricks, null or without pairs where it has none.
  /// Throws InputError. Null for ligaments, which come with the ties, in the place of joints.
  std::shared_ptr<const model::PairForce> (*make)(const Scene& scene,
                                                  const std::vector<model::Brick>& bricks);
  /// The force from a file. Throws InputError.
  std::shared_ptr<const model::PairForce> (*read)(const model::PairReader& file);
};

/// All kinds, in the order of the summaries.
const std::vector<PairForceKind>& pairForceKinds();

}  // namespace kirireel::scene
