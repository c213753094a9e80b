// Whether a step may lead from one relative pose of two convex bricks to another.
//
// Two convex bodies are apart where a plane separates them: one of a face of either, or one along
// an edge of each (the separating axis theorem). A step is fine where one plane, carried along by
// the feature that it belongs to, separates them at the start and at the end; or where one takes
// over from the other on the way, along the screw that leads from pose to pose. The plane of the
// last step is tried first, and a pair is not looked at before its bricks could have used up their
// distance, so that most pairs cost a few comparisons a step.
//
// Where no plane serves, the one that held at the start and is violated least at the end becomes
// contacts: points of one brick that may not come through the plane of the other. Bricks that
// overlap where a run begins may keep that overlap, and lose it as they come apart.
// Gottschalk, Lin and Manocha, "OBBTree", 1996, for the axes; Mirtich, "V-Clip", 1998, for features
// that are followed from step to step.
//
#include "sim/world/brick_pair.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/world/near_pairs.h"

namespace kirireel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Overlaps left by a step are taken back bit by bit, and may meanwhile grow by this part of the
// tolerance a step, up to so many tolerances.
constexpr double kWorsening = 0.1;
constexpr double kWorst = 7;
// Two planes whose normals agree to this cosine count as the same.
constexpr double kSameDirection = 0.999;

// A point that far beside a face, in radii of a brick, still touches it.
constexpr double kTouching = 1e-3;

// How often the plane that keeps a pair apart may change within a step, and how finely the moment
// of a change is sought.
constexpr int kPlaneChanges = 4;
constexpr int kBisections = 20;
// Below this angle the motion of a pair counts as straight, radians.
constexpr double kNoTurn = 1e-9;

/// A turn about an axis and an advance along it: bricks that share a pivot move against each other
/// so, and the pivot stays where it is on the way.
struct Screw {
  Vector3 turn = Vector3::Zero();  // rotation vector
  Vector3 centre = Vector3::Zero();
  Vector3 advance = Vector3::Zero();
};

/// The screw that takes one pose to another.
// The centre c of a screw with the angle p about the unit axis a satisfies to = c + R (from - c) +
// advance along a; with d the part of the displacement across a, c = from + (d + a x d / tan(p/2))
// / 2.
Screw screwBetween(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turned(to.rotation * from.rotation.conjugate());
  Screw screw{Vector3::Zero(), from.position, to.position - from.position};
  // A pure translation has no finite centre.
  if (turned.angle() < kNoTurn) return screw;
  const Vector3& axis = turned.axis();
  const Vector3 across = screw.advance - axis.dot(screw.advance) * axis;
  screw.turn = turned.angle() * axis;
  screw.centre += 0.5 * (across + axis.cross(across) / std::tan(0.5 * turned.angle()));
  screw.advance -= across;
  return screw;
}

/// The pose a part of the way along a screw.
Pose onTheWay(const Screw& screw, const Pose& from, double part) {
  const Quaternion turn = rotationFromVector(part * screw.turn);
  return {screw.centre + part * screw.advance + turn * (from.position - screw.centre),
          turn * from.rotation};
}

// The farthest point of the outline from the brick's centre of mass, metres.
double outerRadius(const Outline& outline) {
  double radius = 0;
  for (const Vector3& point : outline.points) radius = std::max(radius, point.norm());
  return radius;
}

}  // namespace

// R_s^T (x - x_s), R_s^T R for the seer s.
Pose seenFrom(const Pose& seer, const Pose& seen) {
  const Quaternion back = seer.rotation.conjugate();
  return {back * (seen.position - seer.position), back * seen.rotation};
}

BrickPair::BrickPair(Side a, Side b, double tolerance)
    : a_(a.brick),
      b_(b.brick),
      partA_(a.part),
      partB_(b.part),
      outlineA_(std::move(a.outline)),
      outlineB_(std::move(b.outline)),
      radiusB_(outerRadius(outlineB_)),
      tolerance_(tolerance),
      planes_(separatingPlanes(outlineA_, outlineB_)),
      last_(planes_.front()),
      clearance_(-kInfinity) {
  // A never moves in its own axes: it is placed once.
  placeOutline(outlineA_, {}, placedA_);
}

void BrickPair::keepOverlap(const Pose& startOfB) {
  // The largest separation over all planes is the distance of the two, or, where it is negative,
  // minus the least depth.
  placeOutline(outlineB_, startOfB, startB_);
  slack_ = std::max(0.0, -bestSeparationAtStart());
}

void BrickPair::shrinkOverlap(const Pose& startOfB) {
  placeOutline(outlineB_, startOfB, startB_);
  // What has come apart must not overlap again.
  slack_ = std::min(slack_, std::max(0.0, -bestSeparationAtStart()));
}

/// Whether the pair cannot have used up the distance between its bricks since they were looked at.
bool BrickPair::isSurelyApart(const PairMove& move) const {
  // A bound on how far any point of B has moved: while it is below the last separation, no plane
  // need be looked at.
  return motionBound(lookedAt_, move.start, radiusB_) < clearance_ &&
         motionBound(lookedAt_, move.end, radiusB_) < clearance_;
}

double BrickPair::separationAtStart(const SeparatingPlane& plane) const {
  return separation(plane, placedA_, startB_);
}

double BrickPair::separationAtEnd(const SeparatingPlane& plane) const {
  return separation(plane, placedA_, endB_);
}

// The largest separation over all planes, metres.
double BrickPair::bestSeparationAtStart() const {
  double best = -kInfinity;
  for (const SeparatingPlane& plane : planes_) best = std::max(best, separationAtStart(plane));
  return best;
}

// Whether the plane that kept the two apart in the last step does so at both ends of this one.
bool BrickPair::lastPlaneHolds() {
  const double after = separationAtEnd(last_);
  if (after < -tolerance_ - slack_) return false;
  if (separationAtStart(last_) < -tolerance_ - slack_) return false;
  // The separation along one plane is a lower bound of the distance.
  lookedAt_ = endB_.pose;
  clearance_ = after;
  return true;
}

// From the cheapest test to the dearest: a bound on the motion, the last plane, all planes, planes
// in turn.
double BrickPair::appendViolated(const PairMove& move, long step, std::vector<Contact>& contacts) {
  if (isSurelyApart(move)) return 0;
  placeOutline(outlineB_, move.start, startB_);
  placeOutline(outlineB_, move.end, endB_);
  if (lastPlaneHolds()) return 0;
  const double limit = -tolerance_ - slack_;
  const double bestBefore = bestSeparationAtStart();
  // Planes that hold at the start: within the tolerance, or, of a pair that overlaps already, the
  // best one.
  const double held = std::min(limit, bestBefore);
  const double worsening = bestBefore > limit - kWorst * tolerance_ ? kWorsening * tolerance_ : 0;
  // An overlap deeper than the tolerance may not grow but by a little, since a solver takes it back
  // over several steps.
  const double wanted = std::min(limit, bestBefore - worsening);
  double bestAfter = -kInfinity;  // of the planes that held before
  for (const SeparatingPlane& plane : planes_) {
    // A plane that did not hold at the start says nothing about the way: B may have come through.
    if (separationAtStart(plane) < held) continue;
    const double after = separationAtEnd(plane);
    if (after <= bestAfter) continue;
    bestAfter = after;
    last_ = plane;
  }
  if (bestAfter >= wanted) {
    lookedAt_ = move.end;
    clearance_ = bestAfter;
    return 0;
  }
  // The dearest test comes last, and only for pairs that no single plane keeps apart.
  if (keptApartInTurn(move)) return 0;
  // No plane kept the pair apart.
  if (const SeparatingPlane* plane = planeToGive(step)) givePlane(*plane, contacts);
  return std::max(0.0, -bestAfter - slack_);
}

/// Whether the pair is kept apart by one plane after the other, as bricks that turn past a corner
/// are: each plane must hold until the next one does. Overlaps from the start do not count here: a
/// pair that may overlap by more than it is thick could hand over through itself.
bool BrickPair::keptApartInTurn(const PairMove& move) const {
  const Screw screw = screwBetween(move.start, move.end);
  PlacedOutline way = startB_;
  const auto holds = [&](const SeparatingPlane& plane) {
    return separation(plane, placedA_, way) >= -tolerance_;
  };
  const auto ends = [&](const SeparatingPlane& plane) {
    return separationAtEnd(plane) >= -tolerance_;
  };
  double reached = 0;
  for (int change = 0; change < kPlaneChanges; ++change) {
    std::vector<SeparatingPlane> holding;
    std::copy_if(planes_.begin(), planes_.end(), std::back_inserter(holding), holds);
    if (std::any_of(holding.begin(), holding.end(), ends)) return true;
    // Bisect for the last moment to which one of them holds.
    double lost = 1;
    const double from = reached;
    for (int round = 0; round < kBisections; ++round) {
      const double part = 0.5 * (reached + lost);
      placeOutline(outlineB_, onTheWay(screw, move.start, part), way);
      (std::any_of(holding.begin(), holding.end(), holds) ? reached : lost) = part;
    }
    // No plane holds any further: the two really meet.
    if (reached == from) return false;
    placeOutline(outlineB_, onTheWay(screw, move.start, reached), way);
  }
  return false;
}

/// Of the steady planes that held best at the start and were not given yet, the one that is
/// violated least at the end; null when there is none.
const SeparatingPlane* BrickPair::planeToGive(long step) {
  std::vector<const SeparatingPlane*> candidates;
  double best = -kInfinity;
  for (const SeparatingPlane& plane : planes_) {
    if (!isSteady(plane, placedA_, startB_)) continue;
    best = std::max(best, separationAtStart(plane));
    if (canGive(plane, step)) candidates.push_back(&plane);
  }
  const double held = std::min(-tolerance_ - slack_, best);
  const SeparatingPlane* chosen = nullptr;
  double leastViolated = -kInfinity;
  for (const SeparatingPlane* plane : candidates) {
    if (separationAtStart(*plane) < held) continue;
    const double after = separationAtEnd(*plane);
    if (after <= leastViolated) continue;
    leastViolated = after;
    chosen = plane;
  }
  return chosen;
}

/// Whether contacts on this plane would be new in this step.
bool BrickPair::canGive(const SeparatingPlane& plane, long step) {
  if (givenStep_ != step) given_.clear();
  givenStep_ = step;
  return std::find(given_.begin(), given_.end(), plane) == given_.end();
}

void BrickPair::givePlane(const SeparatingPlane& plane, std::vector<Contact>& contacts) {
  last_ = plane;
  given_.push_back(plane);
  const std::size_t first = contacts.size();
  appendPlaneContacts(plane, a_, b_, placedA_, startB_, contacts);
  for (std::size_t c = first; c < contacts.size(); ++c) {
    const bool onA = contacts[c].brickA == a_;
    // The overlap from the start of the run moves the contact's zero.
    contacts[c].slack = slack_;
    contacts[c].partA = onA ? partA_ : partB_;
    contacts[c].partB = onA ? partB_ : partA_;
  }
}

bool BrickPair::isCurrent(const Contact& contact, const Pose& startOfB) const {
  PlacedOutline placedB;
  placeOutline(outlineB_, startOfB, placedB);
  return touches(contact, placedB) || !isApartOtherwise(contact, placedB);
}

/// Whether the contact's point lies on the face that it is held against, not beside it.
bool BrickPair::touches(const Contact& contact, const PlacedOutline& placedB) const {
  // An edge against an edge has no face that it could lie on.
  if (contact.isEdge) return false;
  const bool onA = contact.brickA == a_;
  const PlacedOutline& other = onA ? placedB : placedA_;
  const Vector3 point = (onA ? placedA_ : placedB).pose.apply(contact.pointA);
  for (std::size_t f = 0; f < other.normals.size(); ++f) {
    const Vector3& onFace = other.points[other.outline->facePoints[f]];
    // Beyond the plane of any face, the point is outside the other brick, so that it cannot touch
    // the face from within its borders.
    if (other.normals[f].dot(point - onFace) > kTouching * radiusB_) return false;
  }
  return true;
}

/// Whether another plane than that of the contact keeps the pair apart at the start of the step.
bool BrickPair::isApartOtherwise(const Contact& contact, const PlacedOutline& placedB) const {
  // The contact's first brick may be B of the pair; its normal then points the other way.
  const bool swapped = contact.brickA != a_;
  Contact numbered = contact;
  numbered.brickA = swapped ? 1 : 0;
  numbered.brickB = swapped ? 0 : 1;
  const Vector3 normal = (swapped ? -1 : 1) * contactNormal(numbered, {Pose{}, placedB.pose});
  return std::any_of(planes_.begin(), planes_.end(), [&](const SeparatingPlane& plane) {
    return plane.kind != SeparatingPlane::Kind::Edges &&
           planeNormal(plane, placedA_, placedB).dot(normal) < kSameDirection &&
           separation(plane, placedA_, placedB) >= -tolerance_ - slack_;
  });
}

}  // namespace kirireel
