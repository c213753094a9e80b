#include "sim/joints/standstill.h"

#include <algorithm>

namespace kirireel {
namespace {

constexpr int kPatience = 10;  // steps in a row that stand still before halving is tried anew

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

bool Standstill::beginStep(const Poses& poses, const std::vector<Load>& loads, double seconds) {
  const bool mayHalve = steps_ % kPatience == 0;
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

void Standstill::endStep(const Poses& poses, const std::vector<Load>& loads) {
  steps_ = stood_ ? steps_ + 1 : 0;
  halved_ = mayHalve_;
  poses_.clear();
  loads_.clear();
  if (moved_) return;
  poses_ = poses;
  loads_ = loads;
}

bool Standstill::isAsBefore(const Poses& poses, const std::vector<Load>& loads,
                            double seconds) const {
  return seconds == seconds_ && areEqual(poses, poses_) && areEqual(loads, loads_);
}

void Standstill::transfer(StateTape& tape) {
  tape.transfer(poses_, loads_, seconds_, halved_, steps_);
}

}  // namespace kirireel
