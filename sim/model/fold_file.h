/// FOLD files (github.com/edemaine/fold, version 1.2): JSON, a sheet in one frame or several.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/model_checks.h"

namespace kirireel {

/// Reads a sheet: the first frame with coordinates is the start, the last one, if there are more,
/// the target. faces_vertices are tiles; vertices that faces share are joints, so that faces with a
/// common edge are hinged, unless the edge is a cut or joins them to one piece. A flat sheet in one
/// frame goes where its edges_foldAngle fold it, and springs at folds rest at these angles. Keys of
/// Kirireel's own, which writeFold leaves, say more.
///
/// Throws InputError for text that is no JSON, no faces, wrong numbers, tiles that make no bricks,
/// and two edges of the same two faces that fold by different angles.
/// Coordinates count as metres, whatever the file's frame_unit says. Appends to warnings what a run
/// can live with: tiles of a target that are not congruent, angles that do not close.
Model readFold(const std::filesystem::path& file, std::vector<std::string>& warnings);

/// Writes the model with its edges, their assignments and the angles that they fold by, so that
/// origami programs fold it and reading gives it back to the last bit. Throws OutputError.
/// An existing file is replaced.
void writeFold(const Model& model, const std::filesystem::path& file);

// ------------------------------------------------------------------------------------------------
// What FOLD says of edges: which faces they hinge, fix or cut apart, and by how much they fold.
//
// Assignments (FOLD 1.2): B boundary, M mountain, V valley, F flat, U unassigned: hinges where two
// faces share the edge; C cut: no hinge, and at its inner ends the two sides part; J join: the two
// faces are one rigid piece. Fold angles are signed dihedral angles in degrees, 0 flat, positive
// where the two faces turn towards their upper side (valley).

/// One edge.
struct Crease {
  int from = 0;                     ///< vertex number
  int to = 0;                       ///< vertex number
  char assignment = 'U';            ///< one of B M V F U C J
  std::optional<double> foldAngle;  ///< degrees, -180 to 180; none where the file does not say
};

/// The joints of faces that share vertices, as jointsOfSharedNumbers gives them, but for creases
/// that cut or fix. `tiles` has the faces at the start.
/// Edges that `creases` does not list count as unassigned, that is as hinges. Fixed joints come
/// last.
std::vector<Joint> jointsOfCreases(const CornerNumbers& faces, const std::vector<Crease>& creases,
                                   const std::vector<Tile>& tiles);

/// The tiles of a flat start folded along all hinges with an angle: face 0 of each connected piece
/// stays. None where no angle differs from 0.
/// Angles that contradict each other round a loop are not noticed here.
std::optional<std::vector<Tile>> foldedTiles(const CornerNumbers& faces,
                                             const std::vector<Crease>& creases,
                                             const std::vector<Tile>& tiles);

/// The angles of the folds between two faces, as Model::foldAngles has them: of all edges that two
/// faces share and a crease gives an angle, but for cuts and joins. `model` has the faces as tiles;
/// where they lie flat, angles count seen from above as in foldedTiles(), else seen from the face
/// with the lower number as in creasesOf(). Throws InputError, which names the file, where two
/// edges of the same faces have different angles.
std::map<std::pair<int, int>, double> foldAnglesOf(const CornerNumbers& faces,
                                                   const std::vector<Crease>& creases,
                                                   const Model& model,
                                                   const std::filesystem::path& file);

/// The edges of all faces, each once: boundary where one face has it, else mountain, valley or flat
/// with the angle by which `state`, the folded faces, turns about it.
/// Edges come in the order of their vertex numbers. Where more than two faces share one, the angle
/// is that between the first two.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const std::vector<Tile>& state);

/// Those that the model's file is written with: a flat sheet folds to its target, others are as
/// they stand, and Model::foldAngles come before both. `faces` number the corners in the order of
/// the model's own file.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const Model& model);

}  // namespace kirireel
