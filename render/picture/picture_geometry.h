/// The contents of a picture as flat polygons in space, for pixels and for vector graphics.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "render/picture/style.h"
#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Ambient occlusion: the fraction of ambient light on a face that other bricks block.

/// Bricks that block light, in one state of a run.
class Occluders {
 public:
  /// faces: of each brick, as from brickFaces(), at their poses in world axes. Bricks without faces
  /// block no light. Sorts the bricks once.
  explicit Occluders(const std::vector<std::vector<std::vector<Vector3>>>& faces);

  /// The fraction of a face's ambient light that other bricks block, [0, 1], averaged over some
  /// points of the face. brick: its brick; corners: its corners, world axes; normal: unit, outward.
  /// Checks the bricks whose centres are within the reach along x, of which few are near.
  double occlusion(int brick, std::span<const Vector3> corners, const Vector3& normal) const;

 private:
  /// A polygon that faces away from its brick.
  struct Wall {
    std::vector<Vector3> corners;
    Vector3 normal;
    double offset = 0;  ///< normal . point for the points of its plane
  };
  /// A brick and the sphere around it.
  struct Occluder {
    int brick = 0;
    Vector3 centre;
    double radius = 0;
    std::vector<Wall> walls;
  };

  double occlusionAt(int brick, const Vector3& point, const Vector3& normal) const;

  std::vector<Occluder> occluders_;  ///< by the x of their centres
  double maxRadius_ = 0;
  double reach_ = 0;  ///< bricks at larger distances block no light, metres
};

// ------------------------------------------------------------------------------------------------
// The contents of a picture as flat polygons in space.

/// A dot is drawn this many radii nearer to the eye, so bricks below do not cut into it.
inline constexpr double kDotLift = 3;

/// Opacity of ghosts.
inline constexpr double kGhostOpacity = 0.15;

/// Ghosts are drawn this much farther away, in heights of the picture. Bricks at the same place
/// hide them, and silhouettes of bricks in front of them stay silhouettes.
inline constexpr double kGhostSetback = 0.005;

/// Mixes faces with the background's colour, linearly in the distance of their centre from the eye
/// along the view.
struct DepthCue {
  double share = 0;     ///< of the background at the farthest distance, [0, 1]; 0: not mixed
  double nearest = 0;   ///< distance at which nothing is mixed, metres
  double farthest = 0;  ///< metres
};

/// The items of one picture. All lists except the poses may be empty. Lists are in the order of
/// bricks.
struct PictureItems {
  Poses poses;  ///< one per brick
  /// One per brick, or empty: the style's. A brick that is not drawn casts no shadow.
  std::vector<BrickColours> colours;
  std::vector<int> pinned;     ///< bricks in the style's colours of pins, with their opacity
  std::vector<Vector3> marks;  ///< points with a dot, for example joints, world axes
  /// Closed polygons, drawn as lines, dashed if bricks hide them, world axes.
  std::vector<model::Tile> overlay;
  /// Open lines through these points, hidden by bricks in front of them, world axes.
  std::vector<std::vector<Vector3>> trails;
  std::vector<model::Tile>
      scenery;  ///< polygons that are not bricks, seen from both sides, world axes
  /// Faces of pale bricks without shadow, as from brick::brickFaces(), world axes.
  std::vector<std::vector<std::vector<Vector3>>> ghosts;
  DepthCue depthCue;
};

/// A convex polygon of one colour that faces the camera. A geometry stores its corners.
struct Facet {
  int first = 0;        ///< of its corners in the geometry's points, anticlockwise in the picture
  int count = 0;        ///< of its corners
  Colour colour;        ///< lit
  bool isPart = false;  ///< of a divided concave face
};

/// The sides of a face that faces the camera, drawn as lines.
struct FaceOutline {
  int first = 0;       ///< of its corners in the geometry's points, anticlockwise in the picture
  int count = 0;       ///< of its corners
  double opacity = 1;  ///< of its brick
};

/// All layers of a picture. Each hides the previous layers.
struct PictureGeometry {
  std::vector<Vector3> points;  ///< world axes
  std::vector<Facet> ground;    ///< the plate, if it is visible
  std::vector<Facet> shadow;    ///< overlapping, in painting order: from the palest to the full
  std::vector<Facet> solid;     ///< unordered: nearer facets hide farther ones
  /// Also unordered: farther facets are visible through nearer ones.
  std::vector<Facet> translucent;
  std::vector<FaceOutline> outlines;  ///< of bricks, in the order of their facets
  std::vector<Facet> overlay;         ///< lines, in painting order

  /// A facet's corners, in their order, world axes.
  std::span<const Vector3> corners(const Facet& facet) const {
    return std::span(points).subspan(facet.first, facet.count);
  }
};

/// Makes the geometries of one run.
class GeometryBuilder {
 public:
  /// Copies the required data of the bricks.
  GeometryBuilder(const std::vector<brick::Brick>& bricks, const Style& style);

  /// Replaces the geometry by what this camera sees. Faces that face away are left out. The cost is
  /// one pass over all faces; with occlusion each face checks its neighbours. Throws
  /// std::out_of_range for a pinned brick that does not exist.
  void draw(const PictureItems& items, const Camera& camera, PictureGeometry& geometry) const;

 private:
  /// A face in brick axes.
  struct Face {
    std::vector<Vector3> corners;
    std::vector<std::array<int, 3>> triangles;  ///< of a concave face; empty: it is convex
    Vector3 normal;
  };

  static Face makeFace(const std::vector<Vector3>& corners);

  /// The corners of all bricks' faces in world axes, brick by brick.
  using PlacedFaces = std::vector<std::vector<std::vector<Vector3>>>;

  /// Colours of each brick, including those that are not drawn.
  std::vector<BrickColours> coloursOf(const PictureItems& items) const;
  /// Without bricks that are not drawn.
  PlacedFaces place(const Poses& poses, const std::vector<BrickColours>& colours) const;
  /// The fraction of light that other bricks block, from the corners and the normal of a face.
  using Occluded = std::function<double(std::span<const Vector3>, const Vector3&)>;
  /// occluded: empty without occlusion.
  void drawBrick(const std::vector<Face>& faces, const Pose& pose, const BrickColours& colours,
                 const Camera& camera, const DepthCue& depthCue, const Occluded& occluded,
                 PictureGeometry& geometry) const;
  void drawGhosts(const PictureItems& items, const Camera& camera, PictureGeometry& geometry) const;
  /// Points on the plate whose convex hull is the shadow of a brick or a part of one.
  struct CastPoints {
    std::vector<Vector3> points;
    std::vector<double> heights;  ///< heights above the plate of the points that cast them, metres

    void add(const Vector3& point, const Style& style);
  };

  void appendCast(const std::vector<Face>& faces, const Pose& pose,
                  std::vector<CastPoints>& cast) const;
  /// pictureHeight: at the camera's centre, metres.
  void drawShadow(const Poses& poses, const std::vector<BrickColours>& colours,
                  double pictureHeight, PictureGeometry& geometry) const;

  Style style_;
  std::vector<std::vector<Face>> faces_;  ///< by brick: bottom, top, sides
};

// ------------------------------------------------------------------------------------------------
// Hidden surface removal for drawings that only paint one item over another: vector graphics, and
// translucent bricks in pixels.

/// A convex polygon with marks for sides that come from cutting. `isCut` has an entry for each
/// corner. Sides from cutting get no outline.
struct CutPolygon {
  std::vector<Vector3> corners;  ///< anticlockwise in the picture
  std::vector<char> isCut;       ///< for the side from corner k to corner k + 1
};

/// A facet or a part of one. Pieces of a facet share its plane: cutting never moves a face.
struct Piece {
  CutPolygon outer;   ///< world axes
  Colour colour;      ///< of the facet, lit
  Vector3 normal;     ///< of the facet's plane, unit, towards the camera's side
  double offset = 0;  ///< normal . point for the points of the plane
};

/// The pieces of a layer of facets, in the order of the facets, not sorted. Parts nearer than the
/// camera's near plane are removed.
std::vector<Piece> makePieces(const PictureGeometry& geometry, const std::vector<Facet>& facets,
                              const Camera& camera);

/// The pieces of all bricks, opaque ones first.
std::vector<Piece> drawnPieces(const PictureGeometry& geometry, const Camera& camera);

/// A visible part of an outline through two or more points, world axes. A closed line ends at its
/// start.
struct VisibleLine {
  std::vector<Vector3> points;  ///< metres
  bool isSilhouette = false;    ///< its outer side shows something farther away or nothing
};

/// The visible lines of an outline.
struct VisibleOutline {
  std::vector<VisibleLine> lines;
  double opacity = 1;  ///< of its brick
};

/// The visible parts of a geometry's outlines, in their order. pieces: all of its bricks, see
/// drawnPieces(). A side is hidden if it lies behind the plane of an opaque piece and, in the
/// picture, within the piece. It is a silhouette if no piece continues on its outer side, at half
/// the width of a silhouette (in heights of the picture) and within that depth. With width 0 there
/// are no silhouettes. Lines are drawn over all faces: otherwise a neighbouring face would cover
/// half of a line. Parts nearer than the camera's near plane are removed.
std::vector<VisibleOutline> visibleOutlines(const PictureGeometry& geometry,
                                            const std::vector<Piece>& pieces, const Camera& camera,
                                            double silhouetteWidth);

/// Sorts facets that face the camera, so each may hide only previous ones. Facets on both sides of
/// another's plane are cut (binary space partition; Fuchs, Kedem and Naylor 1980). It is also
/// correct for crossing facets. The camera is in front of a facet's plane, and everything behind
/// the plane comes first. Cutting may increase the number of pieces. Throws Interrupted if the user
/// ends the program.
std::vector<Piece> farthestFirst(std::vector<Piece> pieces);

}  // namespace kirireel::picture
