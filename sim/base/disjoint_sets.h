/// Disjoint sets that are merged: connected components.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace kirireel {

/// Disjoint sets of the elements 0 to n - 1, initially one per element. Each element points to
/// another of its set. The chain ends at the lowest element: the result does not depend on the
/// order of the unions. With path halving: R. E. Tarjan, J. van Leeuwen, Worst-case analysis of set
/// union algorithms, J. ACM 31, 1984.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : towards_(count) {
    std::iota(towards_.begin(), towards_.end(), 0);
  }

  /// The lowest element in the set of this one.
  int lowestOf(int element) {
    while (at(element) != element) element = at(element) = at(at(element));
    return element;
  }

  /// Merges the sets of two elements.
  void unite(int a, int b) {
    const auto [low, high] = std::minmax({lowestOf(a), lowestOf(b)});
    at(high) = low;
  }

  /// The number of each element's set. Sets are numbered from 0 in the order of their lowest
  /// elements.
  std::vector<int> numbers() {
    std::vector<int> numbers;
    int count = 0;
    for (int element = 0; element < static_cast<int>(towards_.size()); ++element) {
      const int lowest = lowestOf(element);
      numbers.push_back(lowest == element ? count++ : numbers[static_cast<std::size_t>(lowest)]);
    }
    return numbers;
  }

 private:
  int& at(int element) { return towards_[static_cast<std::size_t>(element)]; }

  std::vector<int> towards_;
};

/// 0, 1, ... count - 1.
inline std::vector<int> numbersBelow(std::size_t count) {
  std::vector<int> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

}  // namespace kirireel
