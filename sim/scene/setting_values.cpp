// Texts to values and back. Numbers are read by std::from_chars, which knows no locale, and written
// with the fewest digits that read back as the same double. A value that was converted (degrees to
// radians) is written so that converting it again gives the same bits: candidates with 6 to 17
// digits are tried, then the doubles next to the guess.
#include "sim/scene/setting_values.h"

#include <charconv>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sim/base/spelling.h"
#include "sim/scene/toml_file.h"

namespace kirireel {
namespace {

template <typename T>
std::optional<T> readAll(std::string_view text) {
  // from_chars knows no plus sign, people do.
  if (text.starts_with('+')) text.remove_prefix(1);
  T number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  // The whole text has to be the number.
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string describe(Range range, const char* kind) {
  const Range all;
  if (range.least == all.least && range.most == all.most) return kind;
  if (range.most == all.most) return fmt::format("{} of at least {:g}", kind, range.least);
  return fmt::format("{} from {:g} to {}{:g}", kind, range.least,
                     range.isMostLeftOut ? "less than " : "", range.most);
}

}  // namespace

std::optional<double> readNumber(std::string_view text) {
  return readAll<double>(text);
}

std::optional<long> readWhole(std::string_view text) {
  return readAll<long>(text);
}

// The pieces refer to the text, which must outlive them.
std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

double parseNumber(const TypedValue& value, Range range) {
  const std::optional<double> number = readNumber(value.text);
  // from_chars reads "inf" and "nan" too.
  const bool fits = number && std::isfinite(*number) && range.holds(*number);
  if (!fits) throw valueError(value, describe(range, "a number"));
  return *number;
}

long parseInteger(const TypedValue& value, Range range) {
  const std::optional<long> number = readWhole(value.text);
  const bool fits = number && range.holds(static_cast<double>(*number));
  if (!fits) throw valueError(value, describe(range, "a whole number"));
  return *number;
}

Vector3 parseGravity(const TypedValue& value) {
  const std::vector<std::string_view> parts = split(value.text, ',');
  std::vector<double> numbers;
  for (const std::string_view part : parts) {
    const std::optional<double> number = readNumber(part);
    if (number && std::isfinite(*number)) numbers.push_back(*number);
  }
  const bool complete = numbers.size() == parts.size();
  if (complete && numbers.size() == 1) return {0, 0, numbers[0]};
  if (complete && numbers.size() == 3) return {numbers[0], numbers[1], numbers[2]};
  throw valueError(value, "one number (along z) or three as X,Y,Z, in m/s^2, as in 0,0,-9.81");
}

HingeNeck parseNeck(const TypedValue& value) {
  const std::vector<std::string_view> parts = split(value.text, ',');
  if (parts.size() != 3 && parts.size() != 4) {
    throw valueError(value, "width, length and Young's modulus, for example 0.1,0.3,2e9");
  }
  const auto part = [&](std::size_t k, const Range& range) {
    return parseNumber({value.name, std::string(parts[k])}, range);
  };
  HingeNeck neck{part(0, {1e-9, 1e6}), part(1, {0, 1e6}), part(2, {1e-9, 1e15})};
  if (parts.size() == 4) neck.poisson = part(3, {0, 0.5, true});
  return neck;
}

PanelMaterial parsePanels(const TypedValue& value) {
  const std::vector<std::string_view> parts = split(value.text, ',');
  if (parts.empty() || parts.size() > 3) {
    throw valueError(value,
                     "Young's modulus, Poisson's ratio and a length of folds, for example 2e9,0.3");
  }
  const auto part = [&](std::size_t k, const Range& range) {
    return parseNumber({value.name, std::string(parts[k])}, range);
  };
  PanelMaterial panels{part(0, {1e-9, 1e15})};
  if (parts.size() > 1) panels.poisson = part(1, {0, 0.5, true});
  if (parts.size() > 2) panels.foldLength = part(2, {0, 1e9});
  return panels;
}

InputError valueError(const TypedValue& value, const std::string& wanted) {
  return InputError(fmt::format("error: {}: '{}' is not allowed; give {}", value.name,
                                shown(value.text), wanted));
}

std::string numberText(double number) {
  return fmt::format("{}", number);
}

std::string quotedText(const std::string& text) {
  return text.empty() ? "" : tomlText(text);
}

std::string quotedList(const std::vector<std::string>& values) {
  if (values.size() < 2) return values.empty() ? "" : values.front();
  return fmt::format("[{}]", fmt::join(values, ", "));
}

double numberReadAs(double wanted, double guess, const std::function<double(double)>& read) {
  // 17 digits tell any two doubles apart, fewer are nicer to read.
  for (int digits = 6; digits <= 17; ++digits) {
    const double shorter = std::stod(fmt::format("{:.{}g}", guess, digits));
    if (read(shorter) == wanted) return shorter;
  }
  // The conversion rounds: a number next to the guess is the one.
  constexpr int kNeighbours = 8;
  double below = guess;
  double above = guess;
  for (int k = 0; k < kNeighbours; ++k) {
    below = std::nextafter(below, -std::numeric_limits<double>::infinity());
    above = std::nextafter(above, std::numeric_limits<double>::infinity());
    if (read(below) == wanted) return below;
    if (read(above) == wanted) return above;
  }
  return guess;
}

std::string vectorText(const Vector3& vector) {
  return fmt::format("[{}, {}, {}]", vector.x(), vector.y(), vector.z());
}

std::string neckText(const HingeNeck& neck) {
  const auto& [width, length, youngs, poisson] = neck;
  return quotedText(fmt::format("{},{},{},{}", width, length, youngs, poisson));
}

std::string panelsText(const PanelMaterial& panels) {
  const auto& [youngs, poisson, foldLength] = panels;
  return quotedText(fmt::format("{},{},{}", youngs, poisson, foldLength));
}

std::string listWords(const std::vector<std::string>& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i];
  }
  return list;
}

}  // namespace kirireel
