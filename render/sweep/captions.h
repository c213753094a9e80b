/// What a run of a sweep is told by, in few letters.
///
/// Digits are chosen for all captions of a page together, so that one parameter looks alike on all.
#pragma once

#include <string>
#include <vector>

namespace kirireel {

/// One caption for each run: the names of the parameters and the run's values, "spring stiffness
/// 12.7, rows 4". Fractions have three significant digits, more where the values of a parameter
/// would be alike otherwise. `runs` has one value for each key in each row. Returns as many
/// captions as there are runs, in their order.
std::vector<std::string> captionsOf(const std::vector<std::string>& keys,
                                    const std::vector<std::vector<std::string>>& runs);

}  // namespace kirireel
