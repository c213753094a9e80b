/// Units of length. Inside the program every length is in metres. Readers convert once, and writers
/// convert back.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/base/geometry.h"

namespace kirireel {

/// A unit of length in files and on the command line.
struct LengthUnit {
  std::string name = "m";  ///< as in lengthUnits()
  double metres = 1;       ///< one unit, metres
  int dxfNumber = 6;       ///< in $INSUNITS of a DXF file; 0 if DXF has no number for it

  bool operator==(const LengthUnit&) const = default;
};

/// nm, um, mm, cm, m, km, in, pt (1/72 in) and ft.
const std::vector<LengthUnit>& lengthUnits();

/// Unit of drawings and of machine files.
LengthUnit millimetre();

/// The unit of this name; absent if there is none.
std::optional<LengthUnit> findLengthUnit(std::string_view name);

/// A length in metres as a number of units. It is the number with the fewest digits (at least 15)
/// that converts to exactly these metres, otherwise the nearest number.
double inUnit(double metres, const LengthUnit& unit);
/// The same for each coordinate.
Vector3 inUnit(const Vector3& metres, const LengthUnit& unit);

/// A length for messages, e.g. "0.08 mm", with this many significant digits.
std::string lengthText(double metres, const LengthUnit& unit, int digits = 3);

}  // namespace kirireel
