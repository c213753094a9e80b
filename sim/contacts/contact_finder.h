/// Collision detection: finds the contacts of a step among all pairs of bricks.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/scene/conditions.h"
#include "sim/scene/scene.h"

namespace kirireel::contacts {

// ------------------------------------------------------------------------------------------------
// Which bricks may come near each other: the broad phase. No Bullet header is needed to use it.

/// Upper bound on the displacement of points within `radius` of the origin by a change of pose,
/// metres. At most twice too large for small rotations.
double motionBound(const Pose& from, const Pose& to, double radius);

/// The distance of a brick's farthest point from its centre of mass, metres.
double outerRadius(const brick::Brick& brick);

/// Bullet's dynamic tree of boxes that are wider than their bricks by a margin. A box changes only
/// after its brick has moved by the margin.
class NearPairs {
 public:
  /// `bricks` must outlive this.
  explicit NearPairs(const std::vector<brick::Brick>& bricks);
  ~NearPairs();

  /// Updates the boxes after a move. Returns whether the pairs were found again. O(bricks) if the
  /// boxes still hold, else O(bricks log bricks).
  bool update(const Poses& start, const Poses& end);

  /// The pairs whose boxes overlap, smaller number first, sorted. A box holds its brick at the
  /// start and the end of the last move.
  const std::vector<std::pair<int, int>>& pairs() const;

  /// Positions of the boxes, which determine the pairs.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

// ------------------------------------------------------------------------------------------------
// Finds collisions. Bullet's broad phase lists pairs, and separating planes of the exact bricks
// decide. No Bullet header is needed to use it.

/// A brick that overlaps an obstacle.
struct ObstacleOverlap {
  int brick = 0;     ///< its number, >= 0
  int obstacle = 0;  ///< >= 0
  double depth = 0;  ///< metres
};

/// The extent of a contact of two faces.
enum class FaceContact {
  Region,  ///< the polygon in which the faces overlap
  Plane,   ///< the whole plane of a face, without a border
  Planes,  ///< as Plane; if planes are equally good, all of them
};

/// Checks a step's start and end together. If one plane (a face of either brick, or spanned by an
/// edge of each) separates a pair at both, the two neither overlap nor have passed through each
/// other, for any thickness. During the step one plane may also replace another while both hold.
/// Otherwise the pair gets contacts on the plane that held at the start and is violated least at
/// the end. Bricks that share a pivot may use planes through it, so joined bricks rotate freely
/// until they collide.
///
/// There are no margins: contacts are exact to `tolerance`. Bricks that overlap in the model may
/// keep that overlap, but it must not grow.
class ContactFinder : public brick::ContactSource {
 public:
  /// `tolerance`: overlap in metres that is ignored. `planar`: only outlines collide. `pivots`
  /// lists the joined bricks. `bricks` are copied. One pose per brick; obstacles are the
  /// environment's.
  ContactFinder(const std::vector<brick::Brick>& bricks, const Poses& start,
                std::span<const brick::Pivot> pivots, const scene::Environment& environment,
                bool planar, double tolerance, FaceContact faces = FaceContact::Region);
  ~ContactFinder() override;

  void startStep(const Poses& start) override;
  double appendViolated(const Poses& end, std::vector<brick::Contact>& contacts) override;
  bool isCurrent(const brick::Contact& contact) const override;
  void appendRegion(const brick::Contact& contact, std::vector<brick::Contact>& contacts) override;
  double pairsExamined() const override;

  /// Distance of a region's corner from the borders of both bricks at these poses, metres; > 0
  /// inside. Infinity for other contacts.
  double insideBorders(const brick::Contact& contact, const Poses& ofBricks) const;

  /// A brick that overlaps an obstacle at these start poses: it could not be removed without a
  /// discontinuity. Call it before the first step.
  std::optional<ObstacleOverlap> overlapWithObstacle(const Poses& start) const;

  /// State that the next step needs from earlier steps: for each pair of bricks the separating
  /// features, and the overlap that it may keep.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

// ------------------------------------------------------------------------------------------------
// Separating planes of two bricks, by their faces and edges.

/// A brick as the points, outward face normals and edges of a convex body, in brick axes. In a
/// planar scene only the outline counts: the bottom's vertices and the side faces.
struct Outline {
  std::vector<Vector3> points;   ///< corners, metres
  std::vector<Vector3> normals;  ///< one per face, unit
  std::vector<int> facePoints;   ///< a point on each face, as an index into points
  /// The corners of each face, as indices into points, anticlockwise seen from outside.
  std::vector<std::vector<int>> faces;
  std::vector<Vector3> directions;  ///< of edges, unit, parallel ones once
};

/// `brick` is convex. O(n^2) in its corners, for the directions of its edges.
Outline makeOutline(const brick::Brick& brick, bool planar);

/// An outline at a pose, in world axes.
struct PlacedOutline {
  const Outline* outline = nullptr;  ///< in brick axes; it must outlive this
  Pose pose;                         ///< of the brick
  std::vector<Vector3> points;       ///< corners, metres
  std::vector<Vector3> normals;      ///< one per face, unit
  std::vector<Vector3> directions;   ///< of edges, unit
};

/// Replaces `placed` by the outline at a pose.
void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed);

/// A direction that may separate two bricks A and B. It is defined by their features, so it can be
/// followed from pose to pose.
struct SeparatingPlane {
  /// Which features define it.
  enum class Kind { FaceOfA, FaceOfB, Edges };
  Kind kind = Kind::FaceOfB;  ///< which features
  int a = 0;                  ///< face or edge direction of A
  int b = 0;                  ///< face or edge direction of B
  double sign = 1;            ///< of the product of edge directions

  bool operator==(const SeparatingPlane&) const = default;

  static constexpr auto fields() {
    return describeFields<SeparatingPlane>(
        field("kind", &SeparatingPlane::kind), field("a", &SeparatingPlane::a),
        field("b", &SeparatingPlane::b), field("sign", &SeparatingPlane::sign));
  }
};

/// All candidate planes of a pair: the faces of both, and in space the products of their edges.
std::vector<SeparatingPlane> separatingPlanes(const Outline& a, const Outline& b);

/// The unit normal of a plane from B towards A, world axes; zero if two edges are parallel.
Vector3 planeNormal(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Distance between A and B along a plane's normal, metres: negative if they overlap along it,
/// minus infinity if the plane does not exist. O(points of A and B).
double separation(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Whether contacts may hold A and B on their sides of a plane. False for nearly parallel edges,
/// because their plane rotates too fast.
bool isSteady(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// The contacts that keep A and B (brick numbers as given) on their sides of a plane: every point
/// of one against a face of the other, or every point of either against the other's farthest point
/// along the normal of two edges.
void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& a, const PlacedOutline& b,
                         std::vector<brick::Contact>& contacts);

/// The contacts at the corners of the polygon in which a face of A overlaps one of B, both nearly
/// across `normal`, a unit vector from B towards A. Without such faces, if `edges` is not null, the
/// crossing of these two edges, if they cross. Appends nothing if there is no such region. O(n m)
/// for faces of n and m corners.
void appendRegionContacts(const Vector3& normal, const SeparatingPlane* edges, int brickA,
                          int brickB, const PlacedOutline& a, const PlacedOutline& b,
                          std::vector<brick::Contact>& contacts);

/// See ContactFinder::insideBorders(). `a` and `b` are the contact's own bricks.
double insideBorders(const brick::Contact& contact, const PlacedOutline& a, const PlacedOutline& b);

// ------------------------------------------------------------------------------------------------
// A pair of bricks that may touch: its separating plane from step to step, and its contacts.

/// The poses of B in A's axes at the start and the end of a step.
struct PairMove {
  Pose start;  ///< at the start of the step
  Pose end;    ///< at its end
};

/// The pose of a brick in the axes of another.
Pose seenFrom(const Pose& seer, const Pose& seen);

/// The outline of a convex piece of a brick, in the brick's own axes.
struct PieceShape {
  /// Costs one copy of the outline.
  explicit PieceShape(Outline ofPiece);
  PieceShape(const PieceShape&) = delete;
  PieceShape& operator=(const PieceShape&) = delete;

  const Outline outline;
  PlacedOutline placed;  ///< the same, if the brick's axes are the world's
};

/// A convex piece of a brick, for its pairs.
struct OutlinedPiece {
  int brick = 0;                            ///< that it belongs to
  int part = 0;                             ///< its number within the brick
  std::shared_ptr<const PieceShape> shape;  ///< shared by the pairs of the piece
};

/// Working memory for the poses of brick B, shared by all pairs.
struct PairScratch {
  PlacedOutline startB;  ///< at the start of the step
  PlacedOutline endB;    ///< at its end
};

/// Pairs are computed in the axes of brick A.
class BrickPair {
 public:
  /// A piece of each brick, and separatingPlanes() of the two. `tolerance`: overlap in metres that
  /// is ignored. Planes and scratch must outlive this. The scratch has no state between calls.
  BrickPair(OutlinedPiece a, OutlinedPiece b, const std::vector<SeparatingPlane>& planes,
            double tolerance, FaceContact faces, PairScratch& scratch);
  BrickPair(const BrickPair&) = delete;
  BrickPair& operator=(const BrickPair&) = delete;

  /// The number of brick A.
  int a() const { return a_.brick; }
  /// The number of brick B.
  int b() const { return b_.brick; }
  /// Overlap that the pair may keep, metres.
  double slack() const { return slack_; }

  /// Stores the overlap of the pair at the start of the run, which it may keep.
  void keepOverlap(const Pose& startOfB);
  /// Reduces the allowed overlap to the current one.
  void shrinkOverlap(const Pose& startOfB);

  /// Appends the contacts of the plane that the move violates. Returns the overlap at the end of
  /// the move, metres. `step` numbers the step: a plane's contacts are appended once per step.
  /// Costs a bound on the motion for pairs that are far apart, one plane for most others, all
  /// planes (some dozens of products) else.
  double appendViolated(const PairMove& move, long step, std::vector<brick::Contact>& contacts);

  /// Whether a contact of this pair still holds at the start of a step: its point touches the other
  /// brick's face, or no other face separates the two.
  bool isCurrent(const brick::Contact& contact, const Pose& startOfB) const;
  /// See ContactSource::appendRegion().
  void appendRegion(const brick::Contact& contact, const Pose& startOfB,
                    std::vector<brick::Contact>& contacts) const;
  /// See ContactFinder::insideBorders().
  double insideBorders(const brick::Contact& contact, const Pose& poseOfB) const;

  /// State that the next step needs from earlier steps.
  void transfer(StateTape& tape) { tape.transfer(slack_, last_, checkedPose_, clearance_); }

 private:
  const Outline& outlineB() const { return b_.shape->outline; }
  const PlacedOutline& placedA() const { return a_.shape->placed; }
  bool touches(const brick::Contact& contact, const PlacedOutline& placedB) const;
  bool isApartOtherwise(const brick::Contact& contact, const PlacedOutline& placedB) const;
  bool isSurelyApart(const PairMove& move) const;
  bool lastPlaneHolds();
  double separationAtStart(const SeparatingPlane& plane) const;
  double separationAtEnd(const SeparatingPlane& plane) const;
  double bestSeparationAtStart() const;
  bool isSeparatedInTurn(const PairMove& move) const;
  Vector3 normalOf(const brick::Contact& contact, const PlacedOutline& placedB) const;
  void finishContacts(std::vector<brick::Contact>& contacts) const;
  void keepNew(std::vector<brick::Contact>& contacts) const;
  bool canGive(const SeparatingPlane& plane, long step);
  std::vector<const SeparatingPlane*> planesToGive(long step);
  void givePlane(const SeparatingPlane& plane, std::vector<brick::Contact>& contacts);

  OutlinedPiece a_, b_;
  PairScratch& scratch_;
  double radiusB_;
  double touching_;  // a point at most this far outside a face touches it, metres
  double tolerance_;
  FaceContact faceContact_;
  double slack_ = 0;
  const std::vector<SeparatingPlane>& planes_;
  SeparatingPlane last_;                 // that separated the pair at the last check
  Pose checkedPose_;                     // B's pose at that check
  double clearance_;                     // the separation at that check
  std::vector<SeparatingPlane> given_;   // whose contacts were appended in this step
  std::vector<brick::Contact> corners_;  // of regions, appended in this step
  long givenStep_ = -1;
};

// ------------------------------------------------------------------------------------------------
// Contact of a brick with a fixed sphere.

/// The point of a brick's surface that is nearest to another point.
struct NearestPoint {
  Vector3 point;         ///< in brick axes
  Vector3 away;          ///< unit, from there to the other point; a face's normal on a face
  double distance = 0;   ///< metres, negative within the brick
  bool isOnFace = true;  ///< else on an edge or a corner
};

/// `faces`: of a convex brick, outward, see brickFaces. `to`: in brick axes. O(corners).
NearestPoint nearestPoint(const std::vector<std::vector<Vector3>>& faces, const Vector3& to);

/// Finds contacts at the nearest points of the surfaces: the sphere's point against a face of the
/// brick, or a corner or a point of an edge against the sphere's tangent plane. They rotate with
/// the bricks, so every step finds them again.
class SpherePair {
 public:
  /// Numbers of the brick and of the sphere's body, whose origin is the centre. `tolerance`:
  /// overlap in metres that is ignored.
  SpherePair(int brick, int sphere, const brick::Brick& shape, double radius, double tolerance);

  /// The number of the brick.
  int brick() const { return brick_; }
  /// The number of the sphere's body.
  int sphere() const { return sphere_; }

  /// Depth of the sphere in the brick at this pose, metres, >= 0.
  double overlap(const Pose& brick, const Vector3& centre) const;

  /// Appends the contact of the feature that is nearest at the start of the step. The second call
  /// in a step appends that of the feature that is nearest at the end. Returns the overlap at the
  /// end.
  double appendViolated(const Pose& start, const Pose& end, const Vector3& centre, long step,
                        std::vector<brick::Contact>& contacts);

 private:
  NearestPoint nearest(const Pose& brick, const Vector3& centre) const;
  brick::Contact contactAt(const Pose& brick, const Vector3& centre) const;

  int brick_, sphere_;
  std::vector<std::vector<Vector3>> faces_;
  double radius_;
  double tolerance_;
  std::vector<brick::Contact> given_;  // in this step
  long givenStep_ = -1;
};

}  // namespace kirireel::contacts
