// One rule of shading for all pictures: a face has one colour,
//
//     c = round(min(255, base (a + k max(0, n . l_k) + f max(0, n . l_f)) (1 - o s))),
//
// with the ambient brightness a, strengths k and f of the key and the fill light, their directions
// l (unit vectors), the face's normal n, the style's occlusion o and the share s of light that
// other bricks keep away. Channels are sRGB bytes as they are, not light: sums of light would need
// a conversion for each face and look no better on flat faces.
#include "render/picture/style.h"

#include <algorithm>
#include <cmath>

namespace kirireel {
namespace {

/// Lambert's cosine law; faces that look away get nothing.
double brightness(const Vector3& normal, const Light& light) {
  return light.strength * std::max(0.0, normal.dot(light.direction));
}

/// `share` 0 gives the first colour, 1 the second; alpha is the first's.
Colour mixed(Colour colour, Colour with, double share) {
  const auto channel = [share](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(from + share * (to - from)));
  };
  return {channel(colour.red, with.red), channel(colour.green, with.green),
          channel(colour.blue, with.blue), colour.alpha};
}

}  // namespace

BrickColours shadesOf(Colour colour) {
  constexpr Colour kBlack = {0, 0, 0};
  constexpr Colour kWhite = {255, 255, 255};
  return {colour, mixed(colour, kWhite, 0.35), mixed(colour, kBlack, 0.24)};
}

Style darkStyle() {
  Style style;
  style.background = {22, 24, 28};
  style.edge = {14, 18, 26};
  style.ground = {44, 47, 53};
  style.scenery = {92, 94, 98};
  style.shadow = {29, 31, 36};
  style.mark = {255, 120, 96};
  style.overlay = {255, 110, 150};
  style.text = {226, 228, 232};
  return style;
}

bool isDark(const BrickColours& colours) {
  constexpr double kDarkest = 85;
  // Brightness as the eye weighs it (ITU-R BT.601).
  const Colour top = colours.top;
  return 0.299 * top.red + 0.587 * top.green + 0.114 * top.blue < kDarkest;
}

Colour faceColour(const Vector3& normal, Colour base, const Style& style, double occluded) {
  const double light =
      (style.ambient + brightness(normal, style.key) + brightness(normal, style.fill)) *
      (1 - style.occlusion * occluded);
  const auto lit = [light](std::uint8_t channel) {
    return static_cast<std::uint8_t>(std::lround(std::min(255.0, channel * light)));
  };
  return {lit(base.red), lit(base.green), lit(base.blue), base.alpha};
}

Vector3 shadowOf(const Vector3& point, const Style& style) {
  const Vector3& light = style.key.direction;
  return point - (point.z() - style.plate->height) / light.z() * light;
}

GroundPlate groundUnder(std::span<const Vector3> points, double height) {
  Eigen::AlignedBox3d box;
  for (const Vector3& point : points) box.extend(point);
  GroundPlate plate;
  plate.height = height;
  plate.centre = box.center().head<2>();
  plate.halfSize = 4 * box.diagonal().norm();
  return plate;
}

}  // namespace kirireel
