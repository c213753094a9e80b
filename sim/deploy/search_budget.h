/// How much work a search may cost.
///
/// Work is counted, not measured: the multiplications of StepReport::work. What may be spent is a
/// multiple of the work of the first candidate. A search therefore decides the same on every
/// machine, and for any number of tiles.
#pragma once

#include <algorithm>
#include <limits>

namespace kirireel::deploy {

/// What the candidates after the first one may cost together, over the work of the first one, at a
/// search effort of 1.
inline constexpr double kSearchMultiple = 150;

/// Work that may still be done. The last piece of work is not interrupted, so a budget can be
/// overspent by it.
class SearchBudget {
 public:
  /// Without a limit.
  SearchBudget() = default;
  /// Of so many multiplications, from 0.
  explicit SearchBudget(double work) : all_(work) {}

  /// Limits what is left by the work of the first candidate (multiplications) and the search
  /// effort, both >= 0. A budget that has a limit keeps it.
  void limitByFirst(double work, double effort) {
    if (!isLimited()) all_ = spent_ + effort * kSearchMultiple * work;
  }
  /// Whether there is a limit.
  bool isLimited() const { return all_ < std::numeric_limits<double>::infinity(); }

  /// Takes away what was done, in multiplications.
  void spend(double work) { spent_ += work; }

  /// The limit, multiplications; infinite without one.
  double all() const { return all_; }
  /// What is left, in multiplications; from 0.
  double left() const { return std::max(0.0, all_ - spent_); }
  /// What was done, in multiplications.
  double spent() const { return spent_; }
  /// Whether nothing is left.
  bool isSpent() const { return spent_ >= all_; }
  /// The part that is spent, 0 to 1.
  double share() const { return all_ > 0 ? std::min(1.0, spent_ / all_) : 1; }

 private:
  double all_ = std::numeric_limits<double>::infinity();
  double spent_ = 0;
};

}  // namespace kirireel::deploy
