#include "sim/base/spelling.h"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

namespace kirireel {

int editDistance(std::string_view a, std::string_view b) {
  // One row of the distance table at a time: row[j] turns the first i letters of a into j of b.
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string suggestion(std::string_view word, const std::vector<std::string>& knownWords) {
  int nearest = std::max<int>(2, static_cast<int>(word.size()) / 3) + 1;
  std::string found;
  for (const std::string& known : knownWords) {
    const int distance = editDistance(word, known);
    if (distance >= nearest) continue;
    nearest = distance;
    found = known;
  }
  return found.empty() ? "" : fmt::format(", did you mean {}?", found);
}

}  // namespace kirireel
