// One rule of shading for all pictures: a face has one colour,
//
//     c = round(min(255, base (a + k max(0, n . l_k) + f max(0, n . l_f)) (1 - o s))),
//
// with the ambient brightness a, strengths k and f of the key and the fill light, their directions
// l, the face's normal n (unit vectors in picture axes), the style's occlusion o and the fraction s
// of light that other bricks block. Channels are sRGB bytes and not linear light, which would need
// a conversion for each face and would not improve flat faces.
#include "render/picture/style.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace kirireel::picture {
namespace {

/// Lambert's cosine law; 0 for faces that face away.
double brightness(const Vector3& normal, const Light& light) {
  return light.strength * std::max(0.0, normal.dot(light.direction));
}

}  // namespace

Colour mixed(Colour colour, Colour with, double share) {
  const auto channel = [share](std::uint8_t from, std::uint8_t to) {
    return static_cast<std::uint8_t>(std::lround(from + share * (to - from)));
  };
  return {channel(colour.red, with.red), channel(colour.green, with.green),
          channel(colour.blue, with.blue), colour.alpha};
}

BrickColours shadesOf(Colour colour) {
  constexpr Colour kBlack = {0, 0, 0};
  constexpr Colour kWhite = {255, 255, 255};
  constexpr int kDark = 80;
  // Luma of ITU-R BT.601.
  const auto grey = static_cast<std::uint8_t>(
      std::lround(0.299 * colour.red + 0.587 * colour.green + 0.114 * colour.blue));
  const Colour muted = mixed(colour, {grey, grey, grey}, 0.5);
  const Colour bottom = grey < kDark ? mixed(muted, kWhite, 0.2) : mixed(muted, kBlack, 0.14);
  return {colour, bottom, mixed(colour, kBlack, 0.24)};
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

BrickColours withOpacity(BrickColours colours, double opacity) {
  const auto alpha = static_cast<std::uint8_t>(std::lround(255 * opacity));
  colours.top.alpha = colours.bottom.alpha = colours.side.alpha = alpha;
  return colours;
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
  const Vector3& source = style.shadowSource;
  return point - (point.z() - style.plate->height) / source.z() * source;
}

// On a transparent page only the alpha grows.
Colour partialShadow(const Style& style, double share) {
  const Colour full = style.shadow;
  const bool onPlate = style.plate && style.plate->visible;
  const Colour under = onPlate ? style.ground : style.background;
  if (under.alpha < 255) {
    const auto alpha = static_cast<std::uint8_t>(std::lround(share * full.alpha));
    return {full.red, full.green, full.blue, alpha};
  }
  Colour colour = mixed(under, full, share);
  colour.alpha = full.alpha;
  return colour;
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

// ------------------------------------------------------------------------------------------------
// Scales are tables of 17 colours at equal steps, interpolated linearly in each sRGB channel. They
// differ by at most two levels from the full tables of 256 colours, and are short enough to read.

namespace {

using Scale = std::array<std::array<std::uint8_t, 3>, 17>;

/// Every sixteenth colour of the viridis scale by N. Smith, S. van der Walt and E. Firing, in the
/// public domain (CC0).
constexpr Scale kViridis = {{{68, 1, 84},
                             {72, 24, 106},
                             {71, 45, 123},
                             {66, 64, 134},
                             {59, 82, 139},
                             {51, 99, 141},
                             {44, 114, 142},
                             {38, 130, 142},
                             {33, 145, 140},
                             {31, 159, 136},
                             {39, 173, 129},
                             {61, 188, 116},
                             {92, 200, 99},
                             {129, 211, 77},
                             {170, 220, 50},
                             {213, 226, 26},
                             {253, 231, 37}}};

/// The same of the cividis scale by J. Nunez, C. Anderton and R. Renslow (PLoS ONE 13(7), 2018) in
/// the table that Matplotlib dedicates to the public domain (CC0).
constexpr Scale kCividis = {{{0, 34, 78},
                             {0, 46, 106},
                             {26, 56, 111},
                             {50, 67, 109},
                             {67, 78, 108},
                             {83, 90, 109},
                             {97, 101, 111},
                             {111, 112, 115},
                             {125, 124, 120},
                             {139, 135, 120},
                             {154, 147, 118},
                             {170, 160, 115},
                             {187, 173, 109},
                             {204, 186, 100},
                             {221, 200, 88},
                             {239, 215, 72},
                             {254, 232, 56}}};

/// Every second colour of the smooth cool-warm scale by K. Moreland, "Diverging Color Maps for
/// Scientific Visualization" (ISVC 2009), table of 33 colours in the public domain.
constexpr Scale kCoolWarm = {{{59, 76, 192},
                              {77, 104, 215},
                              {98, 130, 234},
                              {119, 154, 247},
                              {141, 176, 254},
                              {163, 194, 255},
                              {184, 208, 249},
                              {204, 217, 238},
                              {221, 221, 221},
                              {236, 211, 197},
                              {245, 196, 173},
                              {247, 177, 148},
                              {244, 154, 123},
                              {236, 127, 99},
                              {222, 96, 77},
                              {203, 62, 56},
                              {180, 4, 38}}};

const Scale& scaleOf(ColourMap map) {
  switch (map) {
    case ColourMap::Cividis:
      return kCividis;
    case ColourMap::CoolWarm:
      return kCoolWarm;
    default:
      return kViridis;
  }
}

constexpr Colour kNoValue = {160, 160, 160};

}  // namespace

Colour mapColour(ColourMap map, double share) {
  if (std::isnan(share)) return kNoValue;
  const Scale& scale = scaleOf(map);
  const double place = std::clamp(share, 0.0, 1.0) * (scale.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(place), scale.size() - 2);
  const double rest = place - static_cast<double>(below);
  const auto channel = [&](int k) {
    return static_cast<std::uint8_t>(
        std::lround(scale[below][k] + rest * (scale[below + 1][k] - scale[below][k])));
  };
  return {channel(0), channel(1), channel(2)};
}

namespace {

/// Linear light of a byte of sRGB, [0, 1], and back (IEC 61966-2-1).
double toLight(std::uint8_t channel) {
  const double value = channel / 255.0;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}
std::uint8_t fromLight(double light) {
  const double value =
      light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

/// Relative luminance (WCAG), [0, 1].
double luminance(Colour colour) {
  return 0.2126 * toLight(colour.red) + 0.7152 * toLight(colour.green) +
         0.0722 * toLight(colour.blue);
}

/// CIE lightness, [0, 100], of a luminance, and back. Luminances are clamped to [0, 1].
double lightnessOf(double luminance) {
  const double bounded = std::clamp(luminance, 0.0, 1.0);
  return bounded <= 216.0 / 24389 ? bounded * 24389 / 27 : 116 * std::cbrt(bounded) - 16;
}
double luminanceOf(double lightness) {
  return lightness <= 8 ? lightness * 27 / 24389 : std::pow((lightness + 16) / 116, 3);
}

/// The same hue with another luminance: darker in proportion, or mixed with white.
Colour withLuminance(Colour colour, double requested) {
  const double present = luminance(colour);
  const auto change = [&](std::uint8_t channel) {
    const double light = toLight(channel);
    if (requested <= present) return fromLight(present > 0 ? light * requested / present : 0);
    return fromLight(light + (requested - present) / (1 - present) * (1 - light));
  };
  return {change(colour.red), change(colour.green), change(colour.blue), colour.alpha};
}

/// The factors of a lit face's luminance in colours of a scale: the smallest (in creases) and the
/// largest.
constexpr double kDimmed = 0.52;
constexpr double kBrightened = 1.13;
constexpr double kGraphicsContrast = 3;
constexpr double kTextContrast = 4.5;

/// The range of lightness with contrast to a background: the larger one of the ranges below and
/// above it.
std::pair<double, double> readableRange(Colour background) {
  const double light = luminance(background) + 0.05;
  const double darkest = lightnessOf((light / kGraphicsContrast - 0.05) / kBrightened);
  const double brightest = lightnessOf((light * kGraphicsContrast - 0.05) / kDimmed);
  if (darkest > 100 - brightest) return {0, darkest};
  return {brightest, 100};
}

}  // namespace

double contrastOf(Colour a, Colour b) {
  const auto [dark, bright] = std::minmax({luminance(a), luminance(b)});
  return (bright + 0.05) / (dark + 0.05);
}

Colour readableText(Colour text, Colour background) {
  if (contrastOf(text, background) >= kTextContrast) return text;
  // Black or white always has a contrast of at least 4.58.
  for (const Colour other : {Style().text, darkStyle().text}) {
    if (contrastOf(other, background) >= kTextContrast) return other;
  }
  constexpr Colour kBlack = {0, 0, 0}, kWhite = {255, 255, 255};
  return contrastOf(kBlack, background) > contrastOf(kWhite, background) ? kBlack : kWhite;
}

Colour outlineOn(Colour edge, std::span<const Colour> bricks) {
  constexpr Colour kPale = {205, 211, 220};
  const auto minContrast = [bricks](Colour outline) {
    double least = std::numeric_limits<double>::infinity();
    for (const Colour brick : bricks) least = std::min(least, contrastOf(outline, brick));
    return least;
  };
  return minContrast(kPale) > minContrast(edge) ? kPale : edge;
}

Colour readableHue(Colour colour, Colour background) {
  constexpr double kRounding = 1.01;  // rounding to bytes changes contrasts by less
  if (contrastOf(colour, background) >= kTextContrast) return colour;
  const double light = luminance(background) + 0.05;
  const double dark = light / (kRounding * kTextContrast) - 0.05;
  return withLuminance(colour, dark >= 0 ? dark : light * kRounding * kTextContrast - 0.05);
}

Colour mapColour(ColourMap map, double share, Colour background) {
  double least = 100, most = 0;
  for (const auto& [red, green, blue] : scaleOf(map)) {
    const double lightness = lightnessOf(luminance({red, green, blue}));
    least = std::min(least, lightness);
    most = std::max(most, lightness);
  }
  const auto [low, high] = readableRange(background);
  const double first = std::clamp(least, low, high), last = std::clamp(most, low, high);
  const Colour colour = mapColour(map, share);
  if (first == least && last == most) return colour;
  const double place = (lightnessOf(luminance(colour)) - least) / (most - least);
  return withLuminance(colour, luminanceOf(first + place * (last - first)));
}

Colour kindColour(int kind) {
  // After M. Okabe and K. Ito, "Color Universal Design" (2008), lightened for large areas.
  constexpr std::array<Colour, 7> kHues = {{{128, 174, 220},
                                            {244, 190, 116},
                                            {124, 196, 166},
                                            {222, 150, 186},
                                            {240, 228, 120},
                                            {226, 140, 100},
                                            {170, 170, 176}}};
  return kHues[static_cast<std::size_t>(kind) % kHues.size()];
}

}  // namespace kirireel::picture
