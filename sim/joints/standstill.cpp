// When a step of wedged bricks need not be tried. A step that ended with all bricks standing still
// is a function of its poses, loads and length alone. Begun again with the same three, to the last
// bit, it would end in the same way, so that it is answered without a try. Halving is dear (2^8
// parts), so that after a failure it is allowed in every tenth step only.
#include "sim/joints/standstill.h"

#include <algorithm>

namespace kirireel {
namespace {

constexpr int kPatience = 10;  // steps in a row that stand still before halving is tried anew

// Exact comparison is meant: anything else is a change.
bool areEqual(const Pose& a, const Pose& b) {
  return a.position == b.position && a.rotation.coeffs() == b.rotation.coeffs();
}

bool areEqual(const Load& a, const Load& b) {
  return a.force == b.force && a.stiffness == b.stiffness && a.damping == b.damping;
}

template <typename Value>
bool areEqual(const std::vector<Value>& a, const std::vector<Value>& b) {
  return std::ranges::equal(a, b, [](const Value& x, const Value& y) { return areEqual(x, y); });
}

}  // namespace

// Says whether a step is to be tried. `poses`, `loads` and `seconds` are what the step begins with.
bool Standstill::beginStep(const Poses& poses, const std::vector<Load>& loads, double seconds) {
  const bool mayHalve = steps_ % kPatience == 0;
  // Inputs are the same and the last answer was "stands still". It would differ only if halving
  // were allowed now and had not been allowed then.
  if (isWhole() && isAsBefore(poses, loads, seconds) && (halved_ || !mayHalve)) {
    ++steps_;
    return false;
  }
  mayHalve_ = mayHalve;
  seconds_ = seconds;
  stood_ = false;
  moved_ = false;
  return true;
}

// Notes the outcome. Poses and loads are kept only where no brick moved, since another step cannot
// be the same.
void Standstill::endStep(const Poses& poses, const std::vector<Load>& loads) {
  steps_ = stood_ ? steps_ + 1 : 0;
  halved_ = mayHalve_;
  poses_.clear();
  loads_.clear();
  if (moved_) return;
  poses_ = poses;
  loads_ = loads;
}

// The order of the comparisons is by their cost.
bool Standstill::isAsBefore(const Poses& poses, const std::vector<Load>& loads,
                            double seconds) const {
  return seconds == seconds_ && areEqual(poses, poses_) && areEqual(loads, loads_);
}

void Standstill::transfer(StateTape& tape) {
  tape.transfer(poses_, loads_, seconds_, halved_, steps_);
}

}  // namespace kirireel
