/// Finds what bricks run into: Bullet's broad phase picks the pairs, separating planes of the exact
/// bricks decide. No Bullet header is needed to use it.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "sim/scene/scene.h"
#include "sim/world/obstacle_parts.h"

namespace kirireel {

/// Looks at a step's start and end together. A pair is fine when one plane (a face of either brick,
/// or spanned by an edge of each) keeps the two apart at both: then they neither overlap nor have
/// passed through each other, however thin they are. One plane may also take over from another on
/// the way, while both hold. Otherwise the plane that held at the start and is violated least at
/// the end gives the contacts. Where bricks share a pivot, planes through the pivot count like any
/// other, so joined bricks are free to turn until they really meet.
///
/// No margins are used: contacts are exact to `tolerance`, and bricks that overlap in the model may
/// keep that overlap but not deepen it.
class ContactFinder : public ContactSource {
 public:
  /// `tolerance`: overlap in metres that counts as none. `planar`: only outlines meet.
  /// `obstacles`: the parts whose bodies are the last of the bricks, which stay where they are.
  /// Throws InputError when a brick overlaps an obstacle.
  /// `pivots` says which bricks are joined. `bricks` are copied. Poses are one a body.
  ContactFinder(const std::vector<Brick>& bricks, const Poses& start, std::span<const Pivot> pivots,
                const Environment& environment, bool planar, double tolerance,
                const std::vector<ObstaclePart>& obstacles = {});
  ~ContactFinder() override;

  void startStep(const Poses& start) override;
  double appendViolated(const Poses& end, std::vector<Contact>& contacts) override;
  bool isCurrent(const Contact& contact) const override;
  double pairsExamined() const override;

  /// What the next step takes from those before: what keeps each pair of bricks apart, and the
  /// overlap that it may keep.
  void transfer(StateTape& tape);

 private:
  struct Internals;
  std::unique_ptr<Internals> internals_;
};

}  // namespace kirireel
