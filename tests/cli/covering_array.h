/// Covering arrays: few rows that hold every combination of a few values.
#pragma once

#include <array>
#include <vector>

namespace kirireel::test {

/// A value of a factor, both by their numbers.
struct FactorValue {
  int factor = 0;
  int value = 0;
};

/// Rows with a value for each factor, in which every combination of `strength` values of different
/// factors appears that holds no conflict. `counts`: values of each factor, of which value 0
/// conflicts with nothing. No row holds a conflict. The same rows each time.
std::vector<std::vector<int>> coveringArray(
    const std::vector<int>& counts, int strength,
    const std::vector<std::array<FactorValue, 2>>& conflicts);

}  // namespace kirireel::test
