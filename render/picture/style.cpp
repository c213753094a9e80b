#include "render/picture/style.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

double brightness(const Vector3& normal, const Light& light) {
  return light.strength * std::max(0.0, normal.dot(light.direction));
}

}  // namespace

Colour faceColour(const Vector3& normal, Colour base, const Style& style) {
  const double light =
      style.ambient + brightness(normal, style.key) + brightness(normal, style.fill);
  const auto lit = [light](std::uint8_t channel) {
    return static_cast<std::uint8_t>(std::lround(std::min(255.0, channel * light)));
  };
  return {lit(base.red), lit(base.green), lit(base.blue), base.alpha};
}

GroundPlate groundUnder(std::span<const Vector3> points, double height) {
  Eigen::AlignedBox2d box;
  for (const Vector3& point : points) box.extend(point.head<2>());
  return {height, box.center(), 2.5 * box.sizes().maxCoeff()};
}

}  // namespace kirireel
