/// Torsional springs at hinges: the file that lists them, and those of a scene.
#pragma once

#include <filesystem>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Reads a file of springs, a hinge a line:
///
///     tile tile [stiffness [rest [damping]]]
///
/// in N m/rad, degrees and N m s/rad; tiles are numbered as in the model's file, and what a line
/// has as - or leaves out is as for all hinges. Throws InputError with file:line:column for words,
/// numbers below 0, tiles that the model does not have, and a hinge that is listed twice.
std::vector<OwnHingeSpring> readHingeSprings(const std::filesystem::path& file, const Model& model);

/// The springs of a scene's hinges, in the order of findHinges(), and then of the folds between
/// tiles whose common corners are joined by way of others: those with a stiffness or a damping.
/// `bricks` are the scene's. Throws InputError where nothing has an axis to turn about, where a
/// line of the file names no hinge, and where bricks would lie in each other at the rest angle.
/// Empty where scene.hinges asks for nothing. Costs about O(joints log joints).
std::vector<HingeSpring> hingeSprings(const Scene& scene, const std::vector<Brick>& bricks);

/// What the size of tiles beside a neck is told by, metres: the side of a square of the mean area
/// of the two.
double neckSide(const std::vector<Brick>& bricks, int brickA, int brickB);

}  // namespace kirireel
