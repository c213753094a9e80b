// The slope of a straight line through (ln x, ln y) by least squares: b = sum (X - mean X)(Y - mean
// Y) / sum (X - mean X)^2.
#include "sim/study/power_law.h"

#include <cmath>

namespace kirireel {

// Not a number where all points have the same x, or where a logarithm does not exist.
double fittedExponent(const std::vector<PowerPoint>& points) {
  const double count = static_cast<double>(points.size());
  double meanX = 0;
  double meanY = 0;
  for (const PowerPoint& point : points) {
    meanX += std::log(point.x) / count;
    meanY += std::log(point.y) / count;
  }
  double spread = 0;
  double slope = 0;
  for (const PowerPoint& point : points) {
    const double dx = std::log(point.x) - meanX;
    spread += dx * dx;
    slope += dx * (std::log(point.y) - meanY);
  }
  return spread > 0 ? slope / spread : std::nan("");
}

}  // namespace kirireel
