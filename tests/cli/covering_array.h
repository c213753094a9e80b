/// Covering arrays: few rows with every combination of a few values.
#pragma once

#include <vector>

namespace kirireel::test {

/// A value of a factor, both by their numbers.
struct FactorValue {
  int factor = 0;
  int value = 0;
};

/// Values of different factors that must not be together in a row.
using Conflict = std::vector<FactorValue>;

/// Rows with a value for each factor. Every combination of `strength` values of different factors
/// without a conflict is in a row. `counts`: values of each factor; value 0 conflicts with nothing.
/// No row has a conflict. The result is the same each time.
std::vector<std::vector<int>> coveringArray(const std::vector<int>& counts, int strength,
                                            const std::vector<Conflict>& conflicts);

}  // namespace kirireel::test
