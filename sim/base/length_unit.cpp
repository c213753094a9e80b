// A number in a file, such as 20 (mm), becomes fl(20 * 1e-3) metres. Dividing by 1e-3 can give
// 19.999999999999996 again. Therefore inUnit() searches a number with 15 to 17 digits whose product
// with the unit is exactly the given length. For numbers with at most 15 digits the first attempt
// succeeds.
#include "sim/base/length_unit.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

namespace kirireel {

const std::vector<LengthUnit>& lengthUnits() {
  static const std::vector<LengthUnit> units = {
      {"nm", 1e-9, 12}, {"um", 1e-6, 13},  {"mm", 1e-3, 4},        {"cm", 1e-2, 5},  {"m", 1, 6},
      {"km", 1e3, 7},   {"in", 0.0254, 1}, {"pt", 0.0254 / 72, 0}, {"ft", 0.3048, 2}};
  return units;
}

LengthUnit millimetre() {
  return *findLengthUnit("mm");
}

std::optional<LengthUnit> findLengthUnit(std::string_view name) {
  const auto found = std::ranges::find(lengthUnits(), name, &LengthUnit::name);
  return found == lengthUnits().end() ? std::nullopt : std::optional(*found);
}

double inUnit(double metres, const LengthUnit& unit) {
  if (unit.metres == 1) return metres;
  const double quotient = metres / unit.metres;
  for (const int digits : {15, 16}) {
    const double rounded = std::strtod(fmt::format("{:.{}g}", quotient, digits).c_str(), nullptr);
    if (rounded * unit.metres == metres) return rounded;
  }
  return quotient;
}

std::string lengthText(double metres, const LengthUnit& unit, int digits) {
  // 400 mm instead of 4e+02 mm.
  const double rounded =
      std::strtod(fmt::format("{:.{}g}", metres / unit.metres, digits).c_str(), nullptr);
  return fmt::format("{:g} {}", rounded, unit.name);
}

Vector3 inUnit(const Vector3& metres, const LengthUnit& unit) {
  return {inUnit(metres.x(), unit), inUnit(metres.y(), unit), inUnit(metres.z(), unit)};
}

}  // namespace kirireel
