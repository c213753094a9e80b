/// Loads and contacts of bricks, and the zones in which joined bricks do not touch.
#pragma once

#include <algorithm>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"

namespace kirireel::brick {

// ------------------------------------------------------------------------------------------------
// Loads on a brick, for explicit and implicit solvers.

/// Force and torque on one brick about its centre of mass, world axes, with their derivatives:
///   load(q + dq, u) = force - stiffness dq - damping u,
/// where dq and u stack a translation and a rotation vector. Stiffness and damping are symmetric
/// and positive semidefinite, which keeps implicit steps stable. Loads of several sources add up,
/// field by field.
struct Load {
  Vector6 force = Vector6::Zero();      ///< (N, N m) at zero velocity
  Matrix6 stiffness = Matrix6::Zero();  ///< minus the derivative by position, semidefinite part
  Matrix6 damping = Matrix6::Zero();    ///< minus the derivative by velocity

  static constexpr auto fields() {
    return describeFields<Load>(field("force", &Load::force), field("stiffness", &Load::stiffness),
                                field("damping", &Load::damping));
  }
};

// ------------------------------------------------------------------------------------------------
// Contacts between a brick and another brick, the ground or an obstacle.

/// The ground's number in fields for a brick's number. Numbers < 0 mean fixed objects. No solver
/// has a body for them.
inline constexpr int kFixed = -1;
/// Number of obstacle 0. Obstacle k has kFirstObstacle - k.
inline constexpr int kFirstObstacle = -2;

/// Whether this is a brick's number.
inline bool isBrick(int number) {
  return number >= 0;
}

/// The pose of a brick, or the identity for fixed objects.
inline const Pose& poseOf(int number, const Poses& poses) {
  static const Pose kWorld;
  return isBrick(number) ? poses[number] : kWorld;
}

/// A point of brick A that must not pass a plane of brick B, or an edge of A that must not pass an
/// edge of B. Points and directions are in the bricks' axes, so the gap is exact at any later pose.
/// The gap in metres between a point p_A and a plane through p_B with the normal n is
///   n . (p_A - p_B) + slack.
/// For two edges, n = e_A x e_B / |e_A x e_B|.
/// The gap must be >= 0.
struct Contact {
  int brickA = 0;       ///< number of a brick or an obstacle
  int brickB = kFixed;  ///< number of a brick, the ground or an obstacle; A or B is a brick
  Vector3 pointA;       ///< on brick A, in its axes; on an obstacle in world axes
  Vector3 pointB;       ///< on the plane or edge of B, axes as for A
  Vector3 normal;       ///< unit normal of the plane to A, or direction of B's edge; in B's axes
  bool isEdge = false;  ///< both sides are edges
  Vector3 edgeA = Vector3::Zero();  ///< direction of A's edge, in A's axes: edgeA x (B's edge)
                                    ///< points from B towards A
  double friction = 0;              ///< Coulomb coefficient of the pair
  double slack = 0;                 ///< overlap that the pair had at the start and may keep, metres
  int partA = 0;                    ///< which convex part of a concave brick A, or of all obstacles
  int partB = 0;                    ///< the same for B
  /// A corner of the polygon in which a face of each brick overlap, or where two edges cross: the
  /// point lies on both bricks. A polygon has corners of A over the face of B, corners of B over
  /// the face of A, and crossings of their edges.
  bool isRegion = false;

  bool operator==(const Contact&) const = default;

  static constexpr auto fields() {
    return describeFields<Contact>(
        field("brick_a", &Contact::brickA), field("brick_b", &Contact::brickB),
        field("point_a", &Contact::pointA, "m"), field("point_b", &Contact::pointB, "m"),
        field("normal", &Contact::normal), field("is_edge", &Contact::isEdge),
        field("edge_a", &Contact::edgeA), field("friction", &Contact::friction),
        field("slack", &Contact::slack, "m"), field("part_a", &Contact::partA),
        field("part_b", &Contact::partB), field("is_region", &Contact::isRegion));
  }
};

/// Whether two contacts hold points of one brick against the same plane of another, points of two
/// bricks along the normal of the same two edges, or corners of the region of the same two bricks.
inline bool onOnePlane(const Contact& x, const Contact& y) {
  if (x.isRegion != y.isRegion) return false;
  const auto side = [](int brick, int part) { return std::pair{brick, part}; };
  if (x.isRegion) {
    return std::minmax({side(x.brickA, x.partA), side(x.brickB, x.partB)}) ==
           std::minmax({side(y.brickA, y.partA), side(y.brickB, y.partB)});
  }
  return x.brickA == y.brickA && x.brickB == y.brickB && x.partA == y.partA && x.partB == y.partB &&
         x.isEdge == y.isEdge && x.normal == y.normal && x.edgeA == y.edgeA;
}

/// The contact's unit normal from B towards A at the given poses, world axes.
inline Vector3 contactNormal(const Contact& contact, const Poses& poses) {
  const Vector3 ofB = poseOf(contact.brickB, poses).rotation * contact.normal;
  if (!contact.isEdge) return ofB;
  return (poseOf(contact.brickA, poses).rotation * contact.edgeA).cross(ofB).normalized();
}

/// Signed distance of the point from the plane, or between the edges, plus the slack, metres.
/// Negative if the contact is violated.
inline double contactGap(const Contact& contact, const Poses& poses) {
  const Vector3 pointA = poseOf(contact.brickA, poses).apply(contact.pointA);
  const Vector3 pointB = poseOf(contact.brickB, poses).apply(contact.pointB);
  return contactNormal(contact, poses).dot(pointA - pointB) + contact.slack;
}

/// Where a contact's force acts, world axes.
struct ContactPoints {
  Vector3 onA;  ///< on brick A
  Vector3 onB;  ///< on brick B, as far from A's point as the gap is wide; of a plane A's point
};

/// The points of a contact at the given poses: where two edges cross, the nearest points of both.
inline ContactPoints contactPoints(const Contact& contact, const Poses& poses) {
  const Pose& poseA = poseOf(contact.brickA, poses);
  const Pose& poseB = poseOf(contact.brickB, poses);
  const Vector3 pointA = poseA.apply(contact.pointA);
  if (!contact.isEdge) return {pointA, pointA};
  const Vector3 pointB = poseB.apply(contact.pointB);
  if (!contact.isRegion) return {pointA, pointB};
  const Vector3 a = poseA.rotation * contact.edgeA;
  const Vector3 b = poseB.rotation * contact.normal;
  const auto [onA, onB] = nearestOnLines(pointA, a, pointB, b);
  return {pointA + onA * a, pointB + onB * b};
}

/// Source of a solver's contacts.
class ContactSource {
 public:
  virtual ~ContactSource() = default;

  /// Sets the poses at the start of a step. The bricks overlap only by rounding, or by their
  /// overlap at the start of the run.
  virtual void startStep(const Poses& start) = 0;

  /// Appends new contacts that the move from the start to `end` violates. New means not yet
  /// returned in this step. Returns the largest overlap at `end`, metres.
  virtual double appendViolated(const Poses& end, std::vector<Contact>& contacts) = 0;

  /// Whether a contact that carried load in the last step still holds at the start of the step. The
  /// step may then begin with it. It holds if its point touches the other brick, or if no other
  /// contact separates the bricks.
  virtual bool isCurrent(const Contact& contact) const = 0;

  /// Appends the corners that the region of a contact has at the start of the step; none if its
  /// faces no longer overlap.
  virtual void appendRegion(const Contact& contact, std::vector<Contact>& contacts) = 0;

  /// Number of pairs of bricks that were checked exactly so far, as a measure of cost.
  virtual double pairsExamined() const { return 0; }
};

// ------------------------------------------------------------------------------------------------
// Shapes of joined bricks for contacts, without their shared corners.

/// The shape of a brick without some of its corners. Each edge at such a corner is shortened by
/// `length` metres, at most by 0.4 of its length. Mass and axes do not change. The brick is convex,
/// or a convex piece of a concave brick.
Brick withoutCorners(const Brick& brick, const std::vector<int>& corners, double length);

/// The same for a piece. `corners` are corners of the whole brick.
Brick withoutCorners(const BrickPiece& piece, const std::vector<int>& corners, double length);

/// The corners that two bricks share, as vertices of their tiles, without repetition.
struct SharedCorners {
  std::vector<int> ofA;  ///< ascending
  std::vector<int> ofB;  ///< ascending
  /// Whether both are parts of one tile that bends between them. Such parts never collide.
  bool areOneTile = false;
};

/// The shared corners of all joined pairs. Linked and fixed pairs have no corners. Keys have the
/// smaller brick number first.
std::map<std::pair<int, int>, SharedCorners> sharedCorners(std::span<const Pivot> pivots);

/// The length cut off each edge at a shared corner, metres. Without the cut, thick bricks joined on
/// one face could not fold towards the other face. `zone`: fraction of both bricks' mean edge, in
/// [0, 0.4].
double cutLength(const Brick& a, const Brick& b, double zone);

}  // namespace kirireel::brick
