/// Bricks that cannot move against each other, as rigid pieces.
#pragma once

#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"

namespace kirireel::mechanics {

/// Bricks in rigid pieces: those that pairs connect are one piece. The axes of a piece are the
/// world's at the poses it is made at, and its origin is its centre of mass.
class RigidPieces {
 public:
  /// `pairs`: numbers of two bricks each. `bricks` must outlive this.
  RigidPieces(const std::vector<brick::Brick>& bricks, const Poses& poses,
              const std::vector<std::pair<int, int>>& pairs);

  /// One rigid body a piece: mass, inertia about its centre of mass, no shape.
  const std::vector<brick::Brick>& bodies() const { return bodies_; }
  /// The piece of a brick, >= 0.
  int pieceOf(int brick) const { return pieces_[static_cast<std::size_t>(brick)]; }
  /// Where a brick is in the axes of its piece.
  const Pose& placeInPiece(int brick) const { return places_[static_cast<std::size_t>(brick)]; }

  /// The motion of the pieces that has the linear and angular momentum of their bricks. `planar`:
  /// turns about z only.
  Motion motionOf(const Motion& ofBricks, bool planar) const;
  /// The bricks' poses for those of the pieces.
  Poses posesOfBricks(const Poses& ofPieces) const;
  /// The bricks' motion for that of the pieces.
  Motion motionOfBricks(const Motion& ofPieces) const;
  /// Sums the loads on bricks at these poses to loads on pieces.
  std::vector<brick::Load> loadsOnPieces(const Poses& ofPieces,
                                         const std::vector<brick::Load>& onBricks) const;

 private:
  const std::vector<brick::Brick>& bricks_;
  Poses start_;              // of the pieces, when they were made
  std::vector<int> pieces_;  // one per brick
  Poses places_;             // one per brick, in the axes of its piece
  std::vector<brick::Brick> bodies_;
};

/// Contacts between pieces, from a source of contacts between bricks. Those within a piece are left
/// out.
class PieceContacts : public brick::ContactSource {
 public:
  /// Both must outlive this.
  PieceContacts(const RigidPieces& pieces, brick::ContactSource& source)
      : pieces_(pieces), source_(source) {}

  void startStep(const Poses& start) override;
  double appendViolated(const Poses& end, std::vector<brick::Contact>& contacts) override;
  bool isCurrent(const brick::Contact& contact) const override;
  void appendRegion(const brick::Contact& contact, std::vector<brick::Contact>& contacts) override;
  double pairsExamined() const override { return source_.pairsExamined(); }

 private:
  brick::Contact ofPieces(brick::Contact contact) const;

  const RigidPieces& pieces_;
  brick::ContactSource& source_;
  // Those given so far, as they are between pieces and between bricks.
  std::vector<std::pair<brick::Contact, brick::Contact>> given_;
  std::vector<brick::Contact> inStep_;
};

}  // namespace kirireel::mechanics
