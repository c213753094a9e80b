/// What FOLD says of edges: which faces they hinge, fix or cut apart, and by how much they fold.
///
/// Assignments (FOLD 1.2): B boundary, M mountain, V valley, F flat, U unassigned: hinges where two
/// faces share the edge; C cut: no hinge, and at its inner ends the two sides part; J join: the two
/// faces are one rigid piece. Fold angles are signed dihedral angles in degrees, 0 flat, positive
/// where the two faces turn towards their upper side (valley).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/model/shared_corners.h"

namespace kirireel {

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

/// The edges of all faces, each once: boundary where one face has it, else mountain, valley or flat
/// with the angle by which `state`, the folded faces, turns about it.
/// Edges come in the order of their vertex numbers. Where more than two faces share one, the angle
/// is that between the first two.
std::vector<Crease> creasesOf(const CornerNumbers& faces, const std::vector<Tile>& state);

}  // namespace kirireel
