/// Budget of work for a search.
///
/// Work is counted, not measured: the multiplications of StepReport::work. The budget is a multiple
/// of the work of the first candidate. A search therefore decides the same on every machine and for
/// any number of tiles.
#pragma once

#include <algorithm>
#include <limits>

namespace kirireel::run {

/// Maximum work of all candidates after the first one, over the work of the first one, at a search
/// effort of 1.
inline constexpr double kSearchMultiple = 150;

/// Remaining work of a search. The last piece of work is not interrupted and may exceed the budget.
class SearchBudget {
 public:
  /// Unlimited.
  SearchBudget() = default;
  /// A limit in multiplications, >= 0.
  explicit SearchBudget(double work) : all_(work) {}

  /// Limits the remaining work by the work of the first candidate (multiplications) and the search
  /// effort, both >= 0. An existing limit is kept.
  void limitByFirst(double work, double effort) {
    if (!isLimited()) all_ = spent_ + effort * kSearchMultiple * work;
  }
  /// Whether there is a limit.
  bool isLimited() const { return all_ < std::numeric_limits<double>::infinity(); }

  /// Adds work that was done, multiplications.
  void spend(double work) { spent_ += work; }

  /// The limit, multiplications; infinite without one.
  double all() const { return all_; }
  /// Remaining work, multiplications, >= 0.
  double left() const { return std::max(0.0, all_ - spent_); }
  /// Work done, multiplications.
  double spent() const { return spent_; }
  /// Whether no budget remains.
  bool isSpent() const { return spent_ >= all_; }
  /// The spent share, [0, 1].
  double share() const { return all_ > 0 ? std::min(1.0, spent_ / all_) : 1; }

 private:
  double all_ = std::numeric_limits<double>::infinity();
  double spent_ = 0;
};

}  // namespace kirireel::run
