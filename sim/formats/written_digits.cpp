// The number of written digits, as explained in the header.
//
// std::to_chars gives the shortest decimal digits that read back as the same double (for such an
// algorithm see F. Loitsch, Printing floating-point numbers quickly and accurately with integers,
// PLDI 2010). A coordinate written as 0.866 becomes 866e-3 again: 3 digits, the last at 10^-3.
// Trailing zeros hide the last place of some numbers. The finest last place of all coordinates is
// therefore the decimal place of the file's rounding. Programs that compute in single precision
// round before they write: each number is then the written text of a float, whose last place is
// coarser than the written one.
#include "sim/formats/written_digits.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

namespace kirireel::formats {
namespace {

// A number with this many significant digits was not rounded for writing: doubles have 15 to 17.
constexpr int kAllDigits = 15;
// Floats have 7 to 9 significant digits. With this many or more, numbers are texts of floats by
// chance in one case of 50.
constexpr int kDigitsOfFloats = 9;
// Two roundings of one point differ by at most one unit along each axis: sqrt(3), plus a margin for
// the precision of doubles.
constexpr double kAcrossDigits = 1.75;
// Corners further apart than this fraction of an edge are different, even if digits are coarse.
constexpr double kVisible = 0.05;
// Finer places, metres, need no check for multiples of a coarser step.
constexpr double kFine = 1e-9;
// Digits coarser than this fraction of an edge would distort tiles beyond use. Such numbers are
// exact.
constexpr double kCoarse = 0.01;
// Numbers are exact if all are multiples of several last places, with at most this many such steps.
// Otherwise a common step is chance: 0.866 and 0.5 are even, 0.866025 is a multiple of 0.000025.
constexpr std::int64_t kTypedStep = 5;
constexpr std::int64_t kTypedSteps = 10'000;

// Fewer numbers could agree by chance.
constexpr int kEnough = 8;

/// A number's shortest text in scientific notation.
struct Digits {
  int count = 0;     ///< significant digits
  int exponent = 0;  ///< of the first digit
  int last() const { return exponent - count + 1; }
};

/// Empty for 0, which does not change by rounding.
Digits digitsOf(double value) {
  Digits digits;
  if (value == 0) return digits;
  char buffer[40];
  const char* const text = buffer;
  const char* const end =
      std::to_chars(buffer, buffer + sizeof buffer, std::abs(value), std::chars_format::scientific)
          .ptr;
  const char* const power = std::find(text, end, 'e');
  digits.count = static_cast<int>(power - text - std::count(text, power, '.'));
  const char* const sign = power + 1;
  std::from_chars(*sign == '+' ? sign + 1 : sign, end, digits.exponent);
  return digits;
}

template <typename Visit>
void forEachCoordinate(const std::vector<model::Tile>& tiles, const Visit& visit) {
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) visit(value);
    }
  }
}

/// Whether the number is the text of a float.
bool isSingle(double value, const Digits& digits) {
  const double half = 0.5000001 * std::pow(10.0, digits.last());
  return std::abs(value - static_cast<double>(static_cast<float>(value))) <= half;
}

/// The last place of the largest coordinate as a float, metres; 0 if not all are floats.
double placeOfFloats(const std::vector<model::Tile>& tiles) {
  bool areSingle = true;
  int full = 0;
  double largest = 0;
  forEachCoordinate(tiles, [&](double value) {
    if (!areSingle) return;
    const Digits digits = digitsOf(value);
    areSingle = isSingle(value, digits);
    full += digits.count >= kDigitsOfFloats ? 1 : 0;
    largest = std::max(largest, std::abs(value));
  });
  if (!areSingle || full < kEnough) return 0;
  return std::ldexp(1, std::ilogb(largest) + 1 - std::numeric_limits<float>::digits);
}

/// Whether most numbers below the largest decade have as many significant digits as those in it.
/// With fixed decimals they would have fewer.
bool countsSignificant(const std::vector<Digits>& all, int most, int highest) {
  int lower = 0, full = 0;
  for (const Digits& digits : all) {
    if (digits.exponent >= highest) continue;
    ++lower;
    full += digits.count == most ? 1 : 0;
  }
  return lower >= kEnough && 2 * full > lower;
}

model::Model modelOf(const std::vector<model::Tile>& tiles) {
  model::Model model;
  model.tiles = tiles;
  return model;
}

}  // namespace

double lastPlace(const std::vector<model::Tile>& tiles) {
  if (const double place = placeOfFloats(tiles); place > 0) return place;
  std::vector<Digits> all;
  int most = 0, finest = 0, highest = 0;
  for (const model::Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) {
        const Digits digits = digitsOf(value);
        if (digits.count == 0) continue;
        // One number with all its digits shows that the file was not rounded.
        if (digits.count >= kAllDigits) return 0;
        finest = all.empty() ? digits.last() : std::min(finest, digits.last());
        highest = all.empty() ? digits.exponent : std::max(highest, digits.exponent);
        most = std::max(most, digits.count);
        all.push_back(digits);
      }
    }
  }
  if (all.empty()) return 0;
  // With a fixed number of significant digits, the largest numbers have the coarsest last place. It
  // bounds the error of all numbers.
  const int place = countsSignificant(all, most, highest) ? highest + 1 - most : finest;
  return std::pow(10.0, place);
}

double roundingOf(const std::vector<model::Tile>& tiles) {
  return roundingOf(tiles, lastPlace(tiles));
}

// Decides whether this last place comes from rounding. 0 if the numbers are exact.
double roundingOf(const std::vector<model::Tile>& tiles, double place) {
  if (place == 0 || place > kCoarse * model::tileSize(modelOf(tiles))) return 0;
  if (place < kFine) return place;
  std::int64_t step = 0, largest = 0;
  forEachCoordinate(tiles, [&](double value) {
    const auto places = static_cast<std::int64_t>(std::llround(value / place));
    step = std::gcd(step, places);
    largest = std::max(largest, std::abs(places));
  });
  return step >= kTypedStep && largest <= kTypedSteps * step ? 0 : place;
}

double samePlaceTolerance(const std::vector<model::Tile>& tiles) {
  const model::Model model = modelOf(tiles);
  const double byDigits =
      std::min(kAcrossDigits * lastPlace(tiles), kVisible * model::tileSize(model));
  return std::max(byDigits, kSamePlace * model::modelSize(model));
}

}  // namespace kirireel::formats
