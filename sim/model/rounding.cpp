// How many digits a file was written with, as the header explains.
//
// std::to_chars gives the shortest decimal digits that read back as the same double (F. Loitsch,
// Printing floating-point numbers quickly and accurately with integers, PLDI 2010, describes such
// an algorithm). A coordinate that was written as 0.866 comes out as 866e-3 again: 3 digits, the
// last at 10^-3. The finest last place of all coordinates is the place that the file was rounded
// to, as zeros at the end hide it in some numbers but not in all.
#include "sim/model/rounding.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace kirireel {
namespace {

// Significant digits from which on a number was not rounded for writing: doubles have 15 to 17.
constexpr int kAllDigits = 15;
// Two roundings of one point differ by a unit along each axis at most: sqrt(3), and a bit for what
// doubles cannot hold.
constexpr double kAcross = 1.75;
// Corners further apart than this part of an edge are two, however coarse the digits are.
constexpr double kVisible = 0.05;
// Finer places, metres, need no look at whether all numbers are multiples of something.
constexpr double kFine = 1e-9;
// Digits coarser than this part of an edge would change a tile's shape beyond use: the numbers are
// those that were meant.
constexpr double kCoarse = 0.01;
// Numbers that are all multiples of so many last places, and at most so many of these steps, were
// meant so. Others are by chance: 0.866 and 0.5 are even, 0.866025 is a multiple of 0.000025.
constexpr std::int64_t kMeantStep = 5;
constexpr std::int64_t kMeantSteps = 10'000;

/// A number as its shortest text in scientific notation has it.
struct Digits {
  int count = 0;     ///< significant ones
  int exponent = 0;  ///< of the first
  int last() const { return exponent - count + 1; }
};

/// None for 0, which every rounding leaves as it is.
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
void forEachCoordinate(const std::vector<Tile>& tiles, const Visit& visit) {
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) visit(value);
    }
  }
}

/// Whether the numbers below the largest decade use as many significant digits as those in it,
/// most of the time: decimals would be fewer there.
bool countsSignificant(const std::vector<Digits>& all, int most, int highest) {
  int lower = 0, full = 0;
  for (const Digits& digits : all) {
    if (digits.exponent >= highest) continue;
    ++lower;
    full += digits.count == most ? 1 : 0;
  }
  // Fewer numbers would let chance decide.
  constexpr int kEnough = 8;
  return lower >= kEnough && 2 * full > lower;
}

Model modelOf(const std::vector<Tile>& tiles) {
  Model model;
  model.tiles = tiles;
  return model;
}

}  // namespace

// A power of ten, or 0.
double lastPlace(const std::vector<Tile>& tiles) {
  std::vector<Digits> all;
  int most = 0, finest = 0, highest = 0;
  for (const Tile& tile : tiles) {
    for (const Vector3& vertex : tile.vertices) {
      for (const double value : vertex) {
        const Digits digits = digitsOf(value);
        if (digits.count == 0) continue;
        // One number with all its digits shows that none was rounded.
        if (digits.count >= kAllDigits) return 0;
        finest = all.empty() ? digits.last() : std::min(finest, digits.last());
        highest = all.empty() ? digits.exponent : std::max(highest, digits.exponent);
        most = std::max(most, digits.count);
        all.push_back(digits);
      }
    }
  }
  if (all.empty()) return 0;
  // With so many significant digits everywhere, the largest numbers have the coarsest last place,
  // which bounds the error of all.
  const int place = countsSignificant(all, most, highest) ? highest + 1 - most : finest;
  return std::pow(10.0, place);
}

// Whether that power of ten came from rounding, or is what was meant.
double roundingOf(const std::vector<Tile>& tiles) {
  const double place = lastPlace(tiles);
  if (place == 0 || place > kCoarse * tileSize(modelOf(tiles))) return 0;
  if (place < kFine) return place;
  std::int64_t step = 0, largest = 0;
  forEachCoordinate(tiles, [&](double value) {
    const auto places = static_cast<std::int64_t>(std::llround(value / place));
    step = std::gcd(step, places);
    largest = std::max(largest, std::abs(places));
  });
  return step >= kMeantStep && largest <= kMeantSteps * step ? 0 : place;
}

double samePlaceTolerance(const std::vector<Tile>& tiles) {
  const Model model = modelOf(tiles);
  const double byDigits = std::min(kAcross * lastPlace(tiles), kVisible * tileSize(model));
  return std::max(byDigits, kSamePlace * modelSize(model));
}

}  // namespace kirireel
