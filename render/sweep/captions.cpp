// Finds the fewest digits, from three on, with which values that differ still look different, one
// parameter at a time. Values of a range have nine digits (12.6991457), and captions with all of
// them would not fit under small pictures.
#include "render/sweep/captions.h"

#include <algorithm>
#include <charconv>
#include <set>

#include <fmt/format.h>

namespace kirireel {
namespace {

constexpr int kFewestDigits = 3;
/// As many as the numbers of a range have. SweepRange::at() writes nine; with as many, texts are
/// taken as they are.
constexpr int kMostDigits = 9;

/// Whole numbers and texts stay as they are.
std::string rounded(const std::string& text, int digits) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [next, error] = std::from_chars(text.data(), end, number);
  // A number with neither point nor exponent is whole. "0,0,-9.81" is read up to its first comma,
  // so it counts as a text.
  if (error != std::errc() || next != end || text.find_first_of(".e") == std::string::npos) {
    return text;
  }
  return fmt::format("{:.{}g}", number, digits);
}

/// Values that differ get texts that differ.
std::vector<std::string> shortened(const std::vector<std::string>& values) {
  const std::set<std::string> distinct(values.begin(), values.end());
  for (int digits = kFewestDigits; digits < kMostDigits; ++digits) {
    std::set<std::string> texts;
    for (const std::string& value : distinct) texts.insert(rounded(value, digits));
    // Two values have become one text: a digit more is needed.
    if (texts.size() < distinct.size()) continue;
    std::vector<std::string> chosen;
    chosen.reserve(values.size());
    for (const std::string& value : values) chosen.push_back(rounded(value, digits));
    return chosen;
  }
  return values;
}

/// As a person writes it.
std::string spoken(std::string key) {
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

}  // namespace

std::vector<std::string> captionsOf(const std::vector<std::string>& keys,
                                    const std::vector<std::vector<std::string>>& runs) {
  std::vector<std::string> captions(runs.size());
  for (std::size_t k = 0; k < keys.size(); ++k) {
    std::vector<std::string> values;
    values.reserve(runs.size());
    for (const auto& run : runs) values.push_back(run[k]);
    values = shortened(values);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      captions[i] += fmt::format("{}{} {}", k == 0 ? "" : ", ", spoken(keys[k]), values[i]);
    }
  }
  return captions;
}

}  // namespace kirireel
