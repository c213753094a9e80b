#include "sim/base/error.h"

#include <algorithm>
#include <locale>
#include <numeric>

#include <fmt/format.h>

namespace kirireel {

std::string toString(const FileLocation& location) {
  std::string text = location.file.string();
  if (location.line > 0) text += fmt::format(":{}", location.line);
  if (location.line > 0 && location.column > 0) text += fmt::format(":{}", location.column);
  return text;
}

InputError inputErrorAt(const FileLocation& location, const std::string& message) {
  return InputError(fmt::format("{}: error: {}", toString(location), message));
}

// ------------------------------------------------------------------------------------------------
// Edit distance, and texts made safe for a terminal. The distance of two words is computed by
// dynamic programming over their prefixes,
//   d(i, j) = min(d(i-1, j) + 1, d(i, j-1) + 1, d(i-1, j-1) + (0 if the letters are equal, else
//   1)),
// in O(a b) time and O(b) memory: V. I. Levenshtein, Binary codes capable of correcting deletions,
// insertions and reversals, Soviet Physics Doklady 10, 1966.

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
  constexpr std::size_t kLongestWord = 100;  // longer words are not typing errors
  if (word.size() > kLongestWord) return "";
  // A third of the letters may be wrong, or two in short words.
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

std::optional<std::u32string> codePoints(std::string_view text) {
  using Converter = std::codecvt<char32_t, char8_t, std::mbstate_t>;
  const std::u8string bytes(text.begin(), text.end());
  std::u32string characters(bytes.size(), U'\0');
  std::mbstate_t state{};
  const char8_t* read = bytes.data();
  char32_t* written = characters.data();
  const auto result = std::use_facet<Converter>(std::locale::classic())
                          .in(state, read, bytes.data() + bytes.size(), read, written,
                              characters.data() + characters.size(), written);
  if (result != Converter::ok || read != bytes.data() + bytes.size()) return std::nullopt;
  characters.resize(static_cast<std::size_t>(written - characters.data()));
  // Surrogates are not characters, but some libraries accept them.
  const auto isHalf = [](char32_t character) { return character >= 0xd800 && character < 0xe000; };
  if (std::any_of(characters.begin(), characters.end(), isHalf)) return std::nullopt;
  return characters;
}

}  // namespace kirireel
