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
  constexpr std::size_t kLongestWord = 100;  // nothing that long is a slip of the pen
  if (word.size() > kLongestWord) return "";
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

std::string oneLine(std::string_view text) {
  std::string line(text);
  const auto isControl = [](unsigned char letter) { return letter < ' ' || letter == 127; };
  std::replace_if(line.begin(), line.end(), isControl, '?');
  return line;
}

std::string shown(std::string_view text, std::size_t most) {
  std::string line = oneLine(text.substr(0, most));
  const auto isForeign = [](unsigned char letter) { return letter > 127; };
  std::replace_if(line.begin(), line.end(), isForeign, '?');
  return text.size() > most ? line + "..." : line;
}

}  // namespace kirireel
