/// What pushes bricks: loads, contacts, and where joined bricks do not touch.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/model/brick.h"

namespace kirireel::model {

// ------------------------------------------------------------------------------------------------
// What pushes a brick, in the form that both an explicit and an implicit solver can use.

/// Force and torque on one brick about its centre of mass, world axes, with their derivatives:
///   load(q + dq, u) = force - stiffness dq - damping u,
/// where dq and u stack a translation and a rotation vector. Stiffness and damping are symmetric
/// and positive semidefinite, so that an implicit step never diverges.
/// Loads of several sources add up, field by field.
struct Load {
  Vector6 force = Vector6::Zero();      ///< (N, N m) at zero velocity
  Matrix6 stiffness = Matrix6::Zero();  ///< minus the derivative by position, indefinite part cut
  Matrix6 damping = Matrix6::Zero();    ///< minus the derivative by velocity

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Load>(field("force", &Load::force), field("stiffness", &Load::stiffness),
                                field("damping", &Load::damping));
  }
};

// ------------------------------------------------------------------------------------------------
// A place where a brick may touch another brick or something that does not move.

/// The ground's number where a brick's could stand. Numbers below 0 are of what does not move: no
/// solver has a body for it.
inline constexpr int kFixed = -1;
/// Obstacle 0's number; that of obstacle k is kFirstObstacle - k.
inline constexpr int kFirstObstacle = -2;

/// Whether a number is a brick's.
inline bool isBrick(int number) {
  return number >= 0;
}

/// The pose of a brick, or the world's own axes for what does not move.
inline const Pose& poseOf(int number, const Poses& poses) {
  static const Pose kWorld;
  return isBrick(number) ? poses[number] : kWorld;
}

/// A point of brick A that may not pass a plane of brick B, or an edge of A that may not pass an
/// edge of B. All is kept in the bricks' axes, so that the gap is exact at any later pose, not only
/// where the contact was found.
/// The gap (metres) of a point p_A against a plane through p_B with the normal n is n . (p_A - p_B)
/// + slack, and that of two edges the same with n = e_A x e_B / |e_A x e_B|. It may not become
/// negative.
struct Contact {
  int brickA = 0;       ///< its number, from 0, or an obstacle's
  int brickB = kFixed;  ///< its number, or the ground's or an obstacle's; one of the two is a brick
  Vector3 pointA;       ///< on brick A, in its axes; of an obstacle in the world's
  Vector3 pointB;       ///< on the plane or edge of B, likewise
  Vector3 normal;       ///< of the plane, unit, towards A, or the direction of B's edge; as pointB
  bool isEdge = false;  ///< both sides are edges
  Vector3 edgeA = Vector3::Zero();  ///< direction of A's edge, as pointA: edgeA x B's edge points
                                    ///< from B towards A
  double friction = 0;              ///< Coulomb coefficient of the pair
  double slack = 0;                 ///< overlap that the pair had at the start and may keep, metres
  int partA = 0;                    ///< which convex part of a concave brick A, or of all obstacles
  int partB = 0;                    ///< likewise of B

  bool operator==(const Contact&) const = default;

  /// For files; see base/fields.h.
  static constexpr auto fields() {
    return describeFields<Contact>(
        field("brick_a", &Contact::brickA), field("brick_b", &Contact::brickB),
        field("point_a", &Contact::pointA, "m"), field("point_b", &Contact::pointB, "m"),
        field("normal", &Contact::normal), field("is_edge", &Contact::isEdge),
        field("edge_a", &Contact::edgeA), field("friction", &Contact::friction),
        field("slack", &Contact::slack, "m"), field("part_a", &Contact::partA),
        field("part_b", &Contact::partB));
  }
};

/// Whether two contacts hold points of one brick against the same plane of another, or points of
/// two bricks along the normal of the same two edges.
inline bool onOnePlane(const Contact& x, const Contact& y) {
  return x.brickA == y.brickA && x.brickB == y.brickB && x.partA == y.partA && x.partB == y.partB &&
         x.isEdge == y.isEdge && x.normal == y.normal && x.edgeA == y.edgeA;
}

/// The contact's unit normal from B towards A at the given poses, world axes.
inline Vector3 contactNormal(const Contact& contact, const Poses& poses) {
  const Vector3 ofB = poseOf(contact.brickB, poses).rotation * contact.normal;
  if (!contact.isEdge) return ofB;
  return (poseOf(contact.brickA, poses).rotation * contact.edgeA).cross(ofB).normalized();
}

/// Signed distance of the point from the plane, or of the edges, at the given poses plus the slack,
/// metres; negative where the contact is violated.
inline double contactGap(const Contact& contact, const Poses& poses) {
  const Vector3 pointA = poseOf(contact.brickA, poses).apply(contact.pointA);
  const Vector3 pointB = poseOf(contact.brickB, poses).apply(contact.pointB);
  return contactNormal(contact, poses).dot(pointA - pointB) + contact.slack;
}

/// Tells a solver what its bricks run into.
class ContactSource {
 public:
  virtual ~ContactSource() = default;

  /// Tells where a step starts. The bricks do not overlap there beyond rounding (or beyond the
  /// overlap that they began with).
  virtual void startStep(const Poses& start) = 0;

  /// Appends contacts that the move from the start to `end` violates and that were not given since
  /// the step started. Returns the largest overlap at `end`, metres.
  virtual double appendViolated(const Poses& end, std::vector<Contact>& contacts) = 0;

  /// Whether a contact that carried load in the last step still is in force at the start of the
  /// step, so that the step may begin with it: its point touches the other brick, or nothing else
  /// keeps the bricks apart.
  virtual bool isCurrent(const Contact& contact) const = 0;

  /// How many pairs of bricks were looked at closely so far; counts what the contacts cost.
  virtual double pairsExamined() const { return 0; }
};

// ------------------------------------------------------------------------------------------------
// Joined bricks as they meet each other: without the corners that they share.

/// The shape of a brick without some of its corners: each edge that leads to one ends `length`
/// metres earlier, or at two fifths of its own length if that is less. Mass and axes stay. The
/// brick is convex, or a piece of one that is not.
Brick withoutCorners(const Brick& brick, const std::vector<int>& corners, double length);

/// The same of a piece, `corners` being those of the whole brick.
Brick withoutCorners(const BrickPiece& piece, const std::vector<int>& corners, double length);

/// The corners at which two bricks are joined, as vertices of their tiles, each once.
struct SharedCorners {
  std::vector<int> ofA;  ///< rising
  std::vector<int> ofB;  ///< rising
  /// Whether both are parts of one tile: they never touch, as their common edge is where it bends.
  bool areOneTile = false;
};

/// The shared corners of all joined pairs, none where bricks are linked or fixed; keys have the
/// smaller brick number first.
std::map<std::pair<int, int>, SharedCorners> sharedCorners(std::span<const Pivot> pivots);

/// The length that is cut off each edge at a corner that two bricks share, metres: thick bricks
/// that are joined on one face would be stopped there by the least fold towards the other face.
/// `zone` is the part of both bricks' mean edge, from 0 (nothing) to 0.4.
double cutLength(const Brick& a, const Brick& b, double zone);

}  // namespace kirireel::model
