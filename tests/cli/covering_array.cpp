// Greedy, one row after another (AETG): a row begins with a missing combination. The other factors
// follow in a random order for each candidate. Each takes the value that completes the most missing
// combinations. The best candidate becomes a row.
//
// D. M. Cohen, S. R. Dalal, M. L. Fredman, G. C. Patton, The AETG system: an approach to testing
// based on combinatorial design, IEEE Transactions on Software Engineering 23, 1997.
#include "tests/cli/covering_array.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>
#include <utility>

namespace kirireel::test {
namespace {

constexpr int kCandidates = 6;
constexpr int kOpen = -1;

class Generator {
 public:
  Generator(const std::vector<int>& counts, int strength, const std::vector<Conflict>& conflicts)
      : counts_(counts), conflicts_(conflicts) {
    std::vector<int> factors;
    addSets(0, strength, factors);
    for (Set& set : sets_) {
      std::vector<int> row(counts_.size(), kOpen);
      markImpossible(set, 0, row);
    }
  }

  std::vector<std::vector<int>> rows() {
    std::vector<std::vector<int>> rows;
    while (missing_ > 0) {
      std::vector<int> best;
      int most = -1;
      for (int k = 0; k < kCandidates; ++k) {
        std::vector<int> row = candidate();
        const int gain = gainOf(row);
        if (gain > most) {
          most = gain;
          best = std::move(row);
        }
      }
      take(best);
      rows.push_back(best);
    }
    return rows;
  }

 private:
  /// Factors, and the missing combinations of their values.
  struct Set {
    std::vector<int> factors;
    std::vector<bool> isMissing;  // by indexIn()
  };

  void addSets(int from, int left, std::vector<int>& factors) {
    if (left == 0) {
      std::size_t size = 1;
      for (const int factor : factors) size *= static_cast<std::size_t>(counts_[factor]);
      for (const int factor : factors)
        setsOf_.resize(counts_.size()), setsOf_[factor].push_back(static_cast<int>(sets_.size()));
      sets_.push_back({factors, std::vector<bool>(size, true)});
      missing_ += static_cast<long>(size);
      return;
    }
    for (int factor = from; factor < std::ssize(counts_); ++factor) {
      factors.push_back(factor);
      addSets(factor + 1, left - 1, factors);
      factors.pop_back();
    }
  }

  /// The index of a combination; -1 if a value is open.
  long indexIn(const Set& set, const std::vector<int>& row) const {
    long index = 0;
    for (const int factor : set.factors) {
      if (row[factor] == kOpen) return -1;
      index = index * counts_[factor] + row[factor];
    }
    return index;
  }

  bool mayTake(const std::vector<int>& row, int factor, int value) const {
    return std::ranges::none_of(conflicts_, [&](const Conflict& conflict) {
      const auto isNew = [&](const FactorValue& one) {
        return one.factor == factor && one.value == value;
      };
      return std::ranges::any_of(conflict, isNew) &&
             std::ranges::all_of(conflict, [&](const FactorValue& one) {
               return isNew(one) || row[one.factor] == one.value;
             });
    });
  }

  void markImpossible(Set& set, std::size_t depth, std::vector<int>& row) {
    if (depth == set.factors.size()) return;
    const int factor = set.factors[depth];
    for (int value = 0; value < counts_[factor]; ++value) {
      const bool fits = mayTake(row, factor, value);
      row[factor] = value;
      if (fits) {
        markImpossible(set, depth + 1, row);
      } else {
        markAll(set, depth + 1, row);
      }
      row[factor] = kOpen;
    }
  }

  /// For any values of the remaining factors.
  void markAll(Set& set, std::size_t depth, std::vector<int>& row) {
    if (depth == set.factors.size()) {
      set.isMissing[static_cast<std::size_t>(indexIn(set, row))] = false;
      --missing_;
      return;
    }
    const int factor = set.factors[depth];
    for (int value = 0; value < counts_[factor]; ++value) {
      row[factor] = value;
      markAll(set, depth + 1, row);
      row[factor] = kOpen;
    }
  }

  /// Values of a missing combination, all others open.
  std::vector<int> seed() {
    std::vector<int> row(counts_.size(), kOpen);
    const std::size_t from = chance_() % sets_.size();
    for (std::size_t k = 0; k < sets_.size(); ++k) {
      const Set& set = sets_[(from + k) % sets_.size()];
      const auto found = std::ranges::find(set.isMissing, true);
      if (found == set.isMissing.end()) continue;
      long index = found - set.isMissing.begin();
      for (std::size_t f = set.factors.size(); f-- > 0;) {
        const int factor = set.factors[f];
        row[factor] = static_cast<int>(index % counts_[factor]);
        index /= counts_[factor];
      }
      break;
    }
    return row;
  }

  std::vector<int> candidate() {
    std::vector<int> row = seed();
    std::vector<int> order(counts_.size());
    std::iota(order.begin(), order.end(), 0);
    // std::shuffle may differ between libraries.
    for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[chance_() % i]);
    for (const int factor : order) {
      if (row[factor] == kOpen) row[factor] = bestValue(row, factor);
    }
    return row;
  }

  int bestValue(std::vector<int>& row, int factor) {
    int best = 0, most = -1;
    const int first = static_cast<int>(chance_() % static_cast<std::uint32_t>(counts_[factor]));
    for (int k = 0; k < counts_[factor]; ++k) {
      const int value = (first + k) % counts_[factor];
      if (!mayTake(row, factor, value)) continue;
      row[factor] = value;
      const int gain = gainAt(row, factor);
      row[factor] = kOpen;
      if (gain > most) {
        most = gain;
        best = value;
      }
    }
    return best;
  }

  bool isGain(const Set& set, const std::vector<int>& row) const {
    const long index = indexIn(set, row);
    return index >= 0 && set.isMissing[static_cast<std::size_t>(index)];
  }
  int gainAt(const std::vector<int>& row, int factor) const {
    return static_cast<int>(
        std::ranges::count_if(setsOf_[factor], [&](int set) { return isGain(sets_[set], row); }));
  }
  int gainOf(const std::vector<int>& row) const {
    return static_cast<int>(
        std::ranges::count_if(sets_, [&](const Set& set) { return isGain(set, row); }));
  }

  void take(const std::vector<int>& row) {
    for (Set& set : sets_) {
      if (!isGain(set, row)) continue;
      set.isMissing[static_cast<std::size_t>(indexIn(set, row))] = false;
      --missing_;
    }
  }

  const std::vector<int>& counts_;
  const std::vector<Conflict>& conflicts_;
  std::vector<Set> sets_;
  std::vector<std::vector<int>> setsOf_;  // numbers of the sets that each factor is in
  long missing_ = 0;
  std::minstd_rand chance_{1};
};

}  // namespace

std::vector<std::vector<int>> coveringArray(const std::vector<int>& counts, int strength,
                                            const std::vector<Conflict>& conflicts) {
  return Generator(counts, strength, conflicts).rows();
}

}  // namespace kirireel::test
