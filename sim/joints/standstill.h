/// Bricks that wedge and stand still: which steps need not be tried again.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/load.h"

namespace kirireel {

/// Follows the steps of a solver in which bricks stand still, since none that were tried keep their
/// tolerances. As long as nothing changes, another try ends as the last one did.
class Standstill {
 public:
  /// Whether all bricks stood still through the last step.
  bool isWhole() const { return !poses_.empty(); }

  /// Begins a step of so many seconds from these poses, one load a brick; the loads count only
  /// where isWhole(). Returns false if it need not be tried: the last one that was began just so,
  /// and halves either failed then too or are not due.
  bool beginStep(const Poses& poses, const std::vector<Load>& loads, double seconds);
  /// Notes that bricks stood still in a part of the step, or that they moved.
  void noteStanding() { stood_ = true; }
  void noteMoving() { moved_ = true; }
  void endStep(const Poses& poses, const std::vector<Load>& loads);

  /// Whether a part of the step that fails may be tried in halves: not once bricks stand still in
  /// another part, and after such steps only in every tenth.
  bool mayHalve() const { return mayHalve_ && !stood_; }

  /// To be called when something else changes than poses and loads.
  void forget() { *this = {}; }

  void transfer(StateTape& tape);

 private:
  bool isAsBefore(const Poses& poses, const std::vector<Load>& loads, double seconds) const;

  // What the last step began with, where bricks stood still through it.
  Poses poses_;
  std::vector<Load> loads_;
  double seconds_ = 0;
  bool halved_ = false;  // it was tried in halves

  int steps_ = 0;  // in a row in which bricks stood still
  bool mayHalve_ = true;
  bool stood_ = false;
  bool moved_ = false;
};

}  // namespace kirireel
