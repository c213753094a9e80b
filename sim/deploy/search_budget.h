/// How much work a search may cost.
#pragma once

#include <algorithm>

namespace kirireel {

/// What a reference core does in a second, in the multiplications that StepReport::work counts:
/// measured on the trials of data/cap and data/cube_to_sphere among bricks that touch (3.9e9 and
/// 5.2e9 on a core with AVX2 that was shared with others). Where steps are smaller it is half of
/// that.
inline constexpr double kWorkPerSecond = 4e9;

/// Work that may still be done. It is counted, not measured: a search takes the same decisions on
/// every machine and under every load, and a second is one of the reference core.
/// It may be overspent by the last piece of work, which is not broken off.
class SearchBudget {
 public:
  /// `seconds` of a reference core, from 0.
  explicit SearchBudget(double seconds) : all_(seconds * kWorkPerSecond) {}

  /// Takes away what was done, in multiplications.
  void spend(double work) { spent_ += work; }

  /// What is left, in multiplications; from 0.
  double left() const { return std::max(0.0, all_ - spent_); }
  /// What was done, in multiplications.
  double spent() const { return spent_; }
  bool isSpent() const { return spent_ >= all_; }
  /// The part that is spent, 0 to 1.
  double share() const { return all_ > 0 ? std::min(1.0, spent_ / all_) : 1; }
  /// Seconds of a reference core, as given and as spent so far.
  double seconds() const { return all_ / kWorkPerSecond; }
  double spentSeconds() const { return spent_ / kWorkPerSecond; }

 private:
  double all_;
  double spent_ = 0;
};

}  // namespace kirireel
