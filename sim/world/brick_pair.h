/// Two bricks that may touch: what keeps them apart from step to step, and what they run into.
#pragma once

#include <vector>

#include "sim/world/separation.h"

namespace kirireel {

/// The poses of B in A's axes where a step starts and ends.
struct PairMove {
  Pose start;
  Pose end;
};

/// The pose of a brick in the axes of another.
Pose seenFrom(const Pose& seer, const Pose& seen);

/// Everything about a pair is looked at in the axes of brick A.
class BrickPair {
 public:
  /// A convex piece of each brick: the brick's number, the piece's, and its shape. `tolerance`:
  /// overlap in metres that counts as none.
  struct Side {
    int brick = 0;
    int part = 0;
    Outline outline;
  };
  /// Costs the making of all planes of the pair: faces of both, and in space products of their
  /// edges.
  BrickPair(Side a, Side b, double tolerance);
  BrickPair(const BrickPair&) = delete;
  BrickPair& operator=(const BrickPair&) = delete;

  int a() const { return a_; }
  int b() const { return b_; }
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
  double appendViolated(const PairMove& move, long step, std::vector<Contact>& contacts);

  /// Whether a contact of this pair still is in force at the start of a step: its point touches the
  /// other brick's face, or no other face keeps the two apart.
  bool isCurrent(const Contact& contact, const Pose& startOfB) const;

  /// What the next step takes from those before.
  void transfer(StateTape& tape) { tape.transfer(slack_, last_, lookedAt_, clearance_); }

 private:
  bool touches(const Contact& contact, const PlacedOutline& placedB) const;
  bool isApartOtherwise(const Contact& contact, const PlacedOutline& placedB) const;
  bool isSurelyApart(const PairMove& move) const;
  bool lastPlaneHolds();
  double separationAtStart(const SeparatingPlane& plane) const;
  double separationAtEnd(const SeparatingPlane& plane) const;
  double bestSeparationAtStart() const;
  bool keptApartInTurn(const PairMove& move) const;
  bool canGive(const SeparatingPlane& plane, long step);
  const SeparatingPlane* planeToGive(long step);
  void givePlane(const SeparatingPlane& plane, std::vector<Contact>& contacts);

  int a_, b_;
  int partA_, partB_;
  Outline outlineA_, outlineB_;
  double radiusB_;
  double tolerance_;
  double slack_ = 0;
  std::vector<SeparatingPlane> planes_;
  SeparatingPlane last_;                // that kept the pair apart when last looked at
  Pose lookedAt_;                       // B's pose then
  double clearance_;                    // the separation then
  std::vector<SeparatingPlane> given_;  // whose contacts were given in this step
  long givenStep_ = -1;
  PlacedOutline placedA_, startB_, endB_;
};

}  // namespace kirireel
