/// Hidden surfaces for drawings that can only paint one thing over another: vector graphics, and
/// translucent bricks in pixels.
#pragma once

#include <vector>

#include "render/picture/camera.h"
#include "render/picture/picture_geometry.h"
#include "sim/base/geometry.h"

namespace kirireel {

/// A convex polygon that remembers which of its sides came from cutting. `isCut` has an entry for
/// each corner. Sides from cutting get no outline.
struct CutPolygon {
  std::vector<Vector3> corners;  ///< anticlockwise in the picture
  std::vector<char> isCut;       ///< for the side from corner k to corner k + 1
};

/// A facet or a part of one. Pieces of one facet share its plane, so that cutting never moves a
/// face.
struct Piece {
  CutPolygon outer;       ///< with its outline
  bool outlined = false;  ///< whether its sides that are not cut are the outline of a face
  bool pale = false;      ///< whether that is the pale one
  Colour colour;          ///< of the facet, lit
  FacetPart part = FacetPart::Whole;  ///< which part of a brick it is of
  Vector3 normal;                     ///< of the facet's plane, unit, towards the camera's side
  double offset = 0;                  ///< normal . point for the points of the plane
};

/// The pieces of a layer of facets, in the order in which they stand. Parts nearer to the camera
/// than its near plane are cut away. In order of the facets, not sorted.
std::vector<Piece> makePieces(const PictureGeometry& geometry, const std::vector<Facet>& facets,
                              const Camera& camera);

/// The lines of a facet's outline that nothing hides, each through two points or more, world axes;
/// a closed line ends where it began.
struct SeenOutline {
  std::vector<std::vector<Vector3>> lines;  ///< each two points or more, metres
  bool pale = false;                        ///< drawn in the pale outline colour, as on dark bricks
  double opacity = 1;                       ///< of its facet
};

/// What shows of the outlines of whole facets, as makePieces() gives them, in their order. A side
/// is hidden where it lies behind the plane of another, opaque facet and within that facet's
/// outline as the camera sees it. Drawn over all faces they stay whole: drawn face by face, the
/// half of a line that lies beyond its face would be covered by the neighbour, and lines along a
/// cut by the seam that closes it.
std::vector<SeenOutline> seenOutlines(const std::vector<Piece>& pieces, const Camera& camera);

/// Puts facets that all look at the camera into an order in which each hides those before it, by
/// cutting those that lie on both sides of another's plane (binary space partition; Fuchs, Kedem
/// and Naylor 1980). Right for facets that cross, too. A facet's plane has the camera on its front,
/// so that what lies behind the plane comes first. Cutting may give more pieces than there were.
/// Throws Interrupted when the user ends the program.
std::vector<Piece> farthestFirst(std::vector<Piece> pieces);

}  // namespace kirireel
