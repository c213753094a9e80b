/// Collision detection: from all pairs of bricks to the contacts of a step.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/model/brick.h"
#include "sim/model/contact.h"
#include "sim/scene/conditions.h"
#include "sim/scene/scene.h"

namespace kirireel::contacts {

// ------------------------------------------------------------------------------------------------
// Which bricks may come near each other: the broad phase. No Bullet header is needed to use it.

/// How far any point within `radius` of the origin is displaced by a change of pose, at most.
/// Metres. Never too small; at most twice too large for small turns.
double motionBound(const Pose& from, const Pose& to, double radius);

/// The distance of a brick's farthest point from its centre of mass, metres.
double outerRadius(const model::Brick& brick);

/// Bullet's dynamic box tree over boxes that are wider than the bricks in them: a box is set again
/// only when its brick has moved by the margin.
class NearPairs {
 public:
  /// `bricks` must outlive this.
  explicit NearPairs(const std::vector<model::Brick>& bricks);
  ~NearPairs();

  /// Updates the boxes after a move. Returns whether the pairs were found again.
  /// O(bricks) if the boxes still hold, else O(bricks log bricks).
  bool update(const Poses& start, const Poses& end);

  /// The pairs whose boxes overlap, smaller number first, sorted. A box holds its brick at the
  /// start and the end of the last move.
  const std::vector<std::pair<int, int>>& pairs() const;

  /// Where the boxes are, which decides the pairs.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

// ------------------------------------------------------------------------------------------------
// Finds what bricks run into: Bullet's broad phase picks the pairs, separating planes of the exact
// bricks decide. No Bullet header is needed to use it.

/// A brick that reaches into an obstacle.
struct ObstacleOverlap {
  int brick = 0;     ///< its number, >= 0
  int obstacle = 0;  ///< from 0
  double depth = 0;  ///< metres
};

/// How far a contact of two faces reaches.
enum class FaceContact {
  Region,  ///< the polygon in which the faces overlap: support ends where a brick ends
  Plane,   ///< the whole plane of a face, without a border
};

/// Looks at a step's start and end together. A pair is fine when one plane (a face of either brick,
/// or spanned by an edge of each) keeps the two apart at both: then they neither overlap nor have
/// passed through each other, however thin they are. One plane may also take over from another on
/// the way, while both hold. Otherwise the plane that held at the start and is violated least at
/// the end gives the contacts. Where bricks share a pivot, planes through the pivot count like any
/// other, so joined bricks are free to turn until they collide.
///
/// No margins are used: contacts are exact to `tolerance`, and bricks that overlap in the model may
/// keep that overlap but not deepen it.
class ContactFinder : public model::ContactSource {
 public:
  /// `tolerance`: overlap in metres that is ignored. `planar`: only outlines collide. `pivots`
  /// lists the joined bricks. `bricks` are copied. One pose per brick; obstacles are the
  /// environment's.
  ContactFinder(const std::vector<model::Brick>& bricks, const Poses& start,
                std::span<const model::Pivot> pivots, const scene::Environment& environment,
                bool planar, double tolerance, FaceContact faces = FaceContact::Region);
  ~ContactFinder() override;

  void startStep(const Poses& start) override;
  double appendViolated(const Poses& end, std::vector<model::Contact>& contacts) override;
  bool isCurrent(const model::Contact& contact) const override;
  void appendRegion(const model::Contact& contact, std::vector<model::Contact>& contacts) override;
  double pairsExamined() const override;

  /// How far within the borders of both bricks a corner of a region is at these poses, metres;
  /// below 0 outside. Infinity for other contacts.
  double insideBorders(const model::Contact& contact, const Poses& ofBricks) const;

  /// A brick that overlaps an obstacle at the start, whose poses these are: it could not be got out
  /// without a discontinuity. Call it before the first step.
  std::optional<ObstacleOverlap> overlapWithObstacle(const Poses& start) const;

  /// What the next step takes from those before: what keeps each pair of bricks apart, and the
  /// overlap that it may keep.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

// ------------------------------------------------------------------------------------------------
// Planes between two bricks: which of their faces and edges keep them apart.

/// A brick as the points, outward face normals and edges of a convex body, in brick axes. In a
/// planar scene only the outline counts: the bottom's vertices and the side faces.
struct Outline {
  std::vector<Vector3> points;      ///< corners, metres
  std::vector<Vector3> normals;     ///< one a face, unit
  std::vector<int> facePoints;      ///< a point on each face, as an index into points
  /// The corners of each face, as indices into points, anticlockwise seen from outside.
  std::vector<std::vector<int>> faces;
  std::vector<Vector3> directions;  ///< of edges, unit, parallel ones once
};

/// `brick` is convex. O(n^2) in its corners, for the directions of its edges.
Outline makeOutline(const model::Brick& brick, bool planar);

/// An outline at a pose, in world axes.
struct PlacedOutline {
  const Outline* outline = nullptr;  ///< in brick axes; it must outlive this
  Pose pose;                         ///< of the brick
  std::vector<Vector3> points;       ///< corners, metres
  std::vector<Vector3> normals;      ///< one a face, unit
  std::vector<Vector3> directions;   ///< of edges, unit
};

/// Replaces `placed` by the outline at a pose.
void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed);

/// A direction that may separate two bricks A and B, defined by their features: it can be followed
/// from pose to pose.
struct SeparatingPlane {
  /// Whose features it is of.
  enum class Kind { FaceOfA, FaceOfB, Edges };
  Kind kind = Kind::FaceOfB;  ///< of what features
  int a = 0;                  ///< face or edge direction of A
  int b = 0;                  ///< face or edge direction of B
  double sign = 1;            ///< of the product of edge directions

  bool operator==(const SeparatingPlane&) const = default;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<SeparatingPlane>(
        field("kind", &SeparatingPlane::kind), field("a", &SeparatingPlane::a),
        field("b", &SeparatingPlane::b), field("sign", &SeparatingPlane::sign));
  }
};

/// All planes to be tried for a pair: the faces of both, and in space the products of their edges.
std::vector<SeparatingPlane> separatingPlanes(const Outline& a, const Outline& b);

/// The unit normal of a plane from B towards A, world axes; zero where two edges are parallel.
Vector3 planeNormal(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Distance between A and B along a plane's normal, metres: negative where they overlap along it,
/// minus infinity where the plane does not exist.
/// O(points of A and B).
double separation(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Whether contacts should hold A and B on their sides of a plane: not where two edges are nearly
/// parallel, since their plane turns too fast.
bool isSteady(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// The contacts that keep A and B (brick numbers as given) on their sides of a plane: every point
/// of one against a face of the other, or every point of either against the other's farthest point
/// along the normal of two edges.
void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& a, const PlacedOutline& b,
                         std::vector<model::Contact>& contacts);

/// The contacts at the corners of the polygon in which a face of A overlaps one of B, both nearly
/// across `normal`, a unit vector from B towards A. Where no faces are and `edges` is not null, the
/// crossing of these two edges, if they do cross. Appends none where there is no such region.
/// O(n m) for faces of n and m corners.
void appendRegionContacts(const Vector3& normal, const SeparatingPlane* edges, int brickA,
                          int brickB, const PlacedOutline& a, const PlacedOutline& b,
                          std::vector<model::Contact>& contacts);

/// See ContactFinder::insideBorders(). `a` and `b` are the contact's own bricks.
double insideBorders(const model::Contact& contact, const PlacedOutline& a, const PlacedOutline& b);

// ------------------------------------------------------------------------------------------------
// Two bricks that may touch: what keeps them apart from step to step, and what they run into.

/// The poses of B in A's axes where a step starts and ends.
struct PairMove {
  Pose start;  ///< where the step starts
  Pose end;    ///< where it ends
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
  PlacedOutline placed;  ///< the same where the brick's axes are the world's
};

/// A convex piece of a brick, for its pairs.
struct OutlinedPiece {
  int brick = 0;                            ///< that it is of
  int part = 0;                             ///< its number within the brick
  std::shared_ptr<const PieceShape> shape;  ///< shared by the pairs of the piece
};

/// Working poses of brick B, reused by one pair after the other.
struct PairScratch {
  PlacedOutline startB;  ///< where the step starts
  PlacedOutline endB;    ///< where it ends
};

/// Pairs are computed in the axes of brick A.
class BrickPair {
 public:
  /// A piece of each brick, and separatingPlanes() of the two. `tolerance`: overlap in metres that
  /// counts as none. Planes and scratch must outlive this; what the scratch holds means nothing
  /// between calls.
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

  /// Notes how far the pair overlaps where the run begins: it may keep that.
  void keepOverlap(const Pose& startOfB);
  /// Lets the pair keep no more of that overlap than it still has.
  void shrinkOverlap(const Pose& startOfB);

  /// Appends the contacts of the plane that the move violates, unless they were given in this step
  /// already. Returns the overlap at the end of the move, metres.
  /// `step` numbers the step: planes whose contacts were given in the same step are not given
  /// again. Costs a bound on the motion for pairs that are far apart, one plane for most others,
  /// all planes (some dozens of products) else.
  double appendViolated(const PairMove& move, long step, std::vector<model::Contact>& contacts);

  /// Whether a contact of this pair still is in force at the start of a step: its point touches the
  /// other brick's face, or no other face keeps the two apart.
  bool isCurrent(const model::Contact& contact, const Pose& startOfB) const;
  /// See ContactSource::appendRegion().
  void appendRegion(const model::Contact& contact, const Pose& startOfB,
                    std::vector<model::Contact>& contacts) const;
  /// See ContactFinder::insideBorders().
  double insideBorders(const model::Contact& contact, const Pose& poseOfB) const;

  /// What the next step takes from those before.
  void transfer(StateTape& tape) { tape.transfer(slack_, last_, lookedAt_, clearance_); }

 private:
  const Outline& outlineB() const { return b_.shape->outline; }
  const PlacedOutline& placedA() const { return a_.shape->placed; }
  bool touches(const model::Contact& contact, const PlacedOutline& placedB) const;
  bool isApartOtherwise(const model::Contact& contact, const PlacedOutline& placedB) const;
  bool isSurelyApart(const PairMove& move) const;
  bool lastPlaneHolds();
  double separationAtStart(const SeparatingPlane& plane) const;
  double separationAtEnd(const SeparatingPlane& plane) const;
  double bestSeparationAtStart() const;
  bool keptApartInTurn(const PairMove& move) const;
  Vector3 normalOf(const model::Contact& contact, const PlacedOutline& placedB) const;
  void finishContacts(std::vector<model::Contact>& contacts) const;
  void keepNew(std::vector<model::Contact>& contacts) const;
  bool canGive(const SeparatingPlane& plane, long step);
  const SeparatingPlane* planeToGive(long step);
  void givePlane(const SeparatingPlane& plane, std::vector<model::Contact>& contacts);

  OutlinedPiece a_, b_;
  PairScratch& scratch_;
  double radiusB_;
  double tolerance_;
  FaceContact faceContact_;
  double slack_ = 0;
  const std::vector<SeparatingPlane>& planes_;
  SeparatingPlane last_;                // that separated the pair at the last check
  Pose lookedAt_;                       // B's pose then
  double clearance_;                    // the separation then
  std::vector<SeparatingPlane> given_;  // whose contacts were given in this step
  std::vector<model::Contact> corners_;  // of regions that were given in this step
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

/// Finds contacts at the surface's nearest points: a face of the brick keeps off the sphere's point
/// there, a corner or a point of an edge off the plane that touches the sphere there. They turn
/// with the bricks, so every step finds them again.
class SpherePair {
 public:
  /// Numbers of the brick and of the sphere's body, whose origin is the centre.
  /// `tolerance`: overlap in metres that counts as none.
  SpherePair(int brick, int sphere, const model::Brick& shape, double radius, double tolerance);

  /// The number of the brick.
  int brick() const { return brick_; }
  /// The number of the sphere's body.
  int sphere() const { return sphere_; }

  /// How deep the sphere reaches into the brick at this pose, metres, >= 0.
  double overlap(const Pose& brick, const Vector3& centre) const;

  /// Appends the contact of the feature that was nearest at the start, then, when asked again in
  /// the same step, of the one that is nearest at the end. Returns the overlap at the end.
  double appendViolated(const Pose& start, const Pose& end, const Vector3& centre, long step,
                        std::vector<model::Contact>& contacts);

 private:
  NearestPoint nearest(const Pose& brick, const Vector3& centre) const;
  model::Contact contactAt(const Pose& brick, const Vector3& centre) const;

  int brick_, sphere_;
  std::vector<std::vector<Vector3>> faces_;
  double radius_;
  double tolerance_;
  std::vector<model::Contact> given_;  // in this step
  long givenStep_ = -1;
};

}  // namespace kirireel::contacts
