/// What a picture shows, as flat polygons in space: the same for pixels and for vector graphics.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "render/picture/camera.h"
#include "render/picture/frame.h"
#include "render/picture/style.h"
#include "sim/base/geometry.h"
#include "sim/model/brick.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Ambient occlusion: how much of the light that comes from all sides other bricks keep from a
// face.

/// Bricks as things that keep light away, one state of a run at a time.
class Occluders {
 public:
  /// faces: of each brick, as brickFaces() has them, at their poses in world axes; bricks without
  /// faces keep no light away. Sorts the bricks once.
  explicit Occluders(const std::vector<std::vector<std::vector<Vector3>>>& faces);

  /// The part of the light from all sides, as a face receives it, that other bricks keep away: 0 to
  /// 1, the mean of some points of the face. brick: that the face is of; corners: of the face,
  /// world axes; normal: unit, outward. Looks at the bricks whose centres are within the reach
  /// along x; of these few are near.
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
  double mostRadius_ = 0;
  double reach_ = 0;  ///< from this distance on bricks keep no light away, metres
};

// ------------------------------------------------------------------------------------------------
// What a picture shows, as flat polygons in space: the same for pixels and for vector graphics.

/// A dot is drawn this many of its radii nearer to the eye: the bricks below do not cut into it.
inline constexpr double kDotLift = 3;

/// What the camera is pointed at for one picture. Everything but the poses may be empty. Entries of
/// lists are in the order of bricks.
struct PictureItems {
  Poses poses;  ///< one a brick
  /// One a brick, empty where all have the style's. A brick that is not drawn casts no shadow.
  std::vector<BrickColours> colours;
  std::vector<int> pinned;  ///< bricks drawn in the style's colours of pins, as opaque as they are
  std::vector<Vector3> marks;  ///< points with a dot, for example joints, world axes
  /// Closed polygons whose sides are drawn as lines, dashed where bricks hide them, world axes.
  std::vector<model::Tile> overlay;
  std::vector<model::Tile>
      scenery;  ///< polygons that are no bricks, seen from both sides, world axes
};

/// A convex polygon of one colour that faces the camera. Its corners are stored in a geometry.
struct Facet {
  int first = 0;        ///< of its corners in the geometry's points, anticlockwise in the picture
  int count = 0;        ///< of its corners
  Colour colour;        ///< lit
  bool isPart = false;  ///< of a concave face, which was divided
};

/// The sides of a face that faces the camera, to be drawn as lines.
struct FaceOutline {
  int first = 0;       ///< of its corners in the geometry's points, anticlockwise in the picture
  int count = 0;       ///< of its corners
  bool pale = false;   ///< whether the lines are the pale ones, as on dark bricks
  double opacity = 1;  ///< of its brick
};

/// All that a picture shows, in layers: each hides the ones before it.
struct PictureGeometry {
  std::vector<Vector3> points;  ///< world axes
  std::vector<Facet> ground;    ///< the plate, if it is visible
  std::vector<Facet> shadow;    ///< overlapping, in painting order: from the palest to the full
  std::vector<Facet> solid;     ///< in no order: what is nearer hides what is farther
  /// In no order either: what is farther shows through what is nearer.
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
  /// Copies what it needs of the bricks.
  GeometryBuilder(const std::vector<model::Brick>& bricks, const Style& style);

  /// Fills in the geometry of what this camera sees; what it held before is gone. Faces
  /// that face away are left out. Cost is one pass over all faces; with occlusion each face checks
  /// its neighbours. Throws std::out_of_range for a pinned brick that does not exist.
  void draw(const PictureItems& items, const Camera& camera, PictureGeometry& geometry) const;

 private:
  /// A face in brick axes.
  struct Face {
    std::vector<Vector3> corners;
    std::vector<std::array<int, 3>> triangles;  ///< of a concave face; none: it is convex
    Vector3 normal;
  };

  static Face makeFace(const std::vector<Vector3>& corners);

  /// The corners of all bricks' faces in world axes, brick by brick.
  using PlacedFaces = std::vector<std::vector<std::vector<Vector3>>>;

  /// Of each brick, also of those that are not drawn.
  std::vector<BrickColours> coloursOf(const PictureItems& items) const;
  /// None of bricks that are not drawn.
  PlacedFaces place(const Poses& poses, const std::vector<BrickColours>& colours) const;
  /// occluders: absent where no light is kept away.
  void drawBrick(int brick, const Pose& pose, const BrickColours& colours, const Camera& camera,
                 const std::optional<Occluders>& occluders, PictureGeometry& geometry) const;
  /// Points on the plate whose convex outline is the shadow of a brick or a part of one.
  struct CastPoints {
    std::vector<Vector3> points;
    std::vector<double> heights;  ///< of the points that cast them above the plate, metres

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
// Hidden surfaces for drawings that can only paint one thing over another: vector graphics, and
// translucent bricks in pixels.

/// A convex polygon that remembers which of its sides came from cutting. `isCut` has an entry for
/// each corner. Sides from cutting get no outline.
struct CutPolygon {
  std::vector<Vector3> corners;  ///< anticlockwise in the picture
  std::vector<char> isCut;       ///< for the side from corner k to corner k + 1
};

/// A facet or a part of one. Pieces of one facet share its plane: cutting never moves a face.
struct Piece {
  CutPolygon outer;   ///< world axes
  Colour colour;      ///< of the facet, lit
  Vector3 normal;     ///< of the facet's plane, unit, towards the camera's side
  double offset = 0;  ///< normal . point for the points of the plane
};

/// The pieces of a layer of facets, in its order. Parts nearer to the camera
/// than its near plane are cut away. In order of the facets, not sorted.
std::vector<Piece> makePieces(const PictureGeometry& geometry, const std::vector<Facet>& facets,
                              const Camera& camera);

/// The pieces of all bricks, the opaque ones first.
std::vector<Piece> drawnPieces(const PictureGeometry& geometry, const Camera& camera);

/// A part of an outline that nothing hides, through two points or more, world axes. A closed line
/// ends where it began.
struct SeenLine {
  std::vector<Vector3> points;  ///< metres
  bool isSilhouette = false;    ///< on its outer side lies what is farther away, or nothing
};

/// The lines of an outline that nothing hides.
struct SeenOutline {
  std::vector<SeenLine> lines;
  bool pale = false;   ///< see FaceOutline
  double opacity = 1;  ///< of its brick
};

/// What shows of the outlines of a geometry, in their order. pieces: all of its bricks, see
/// drawnPieces(). A side is hidden where it lies behind the plane of an opaque piece and within the
/// piece as the camera sees it. It is a silhouette where no piece continues on its outer side, at
/// half the width of a silhouette (in heights of the picture) and no deeper than that width; with
/// the width 0 none is. Lines are drawn over all faces: drawn face by face, half of a line would be
/// covered by the neighbour. What is nearer than the camera's near plane is cut away.
std::vector<SeenOutline> seenOutlines(const PictureGeometry& geometry,
                                      const std::vector<Piece>& pieces, const Camera& camera,
                                      double silhouetteWidth);

/// Puts facets that all look at the camera into an order in which each hides those before it, by
/// cutting those that lie on both sides of another's plane (binary space partition; Fuchs, Kedem
/// and Naylor 1980). Right for facets that cross, too. A facet's plane has the camera on its front,
/// and what lies behind the plane comes first. Cutting may give more pieces than there were.
/// Throws Interrupted when the user ends the program.
std::vector<Piece> farthestFirst(std::vector<Piece> pieces);

}  // namespace kirireel::picture
