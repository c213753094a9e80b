#include "sim/model/neck_stiffness.h"

namespace kirireel {

double neckStiffness(double youngs, double thickness, double width, double length) {
  constexpr double kEnds = 1.26;  ///< widths
  return youngs * thickness * width * width * width / (12 * (length + kEnds * width));
}

}  // namespace kirireel
