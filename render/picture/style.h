/// Appearance of pictures, and their colours.
#pragma once

#include <optional>
#include <span>

#include "render/picture/frame.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// Appearance of pictures: colours, lights, outlines, ground.

/// A light at infinity that moves with the camera: a face has the same colour in every view that
/// shows it at the same angle.
struct Light {
  /// Unit, from the model towards the light, picture axes (see pictureFromWorld()).
  Vector3 direction = Vector3::UnitZ();
  double strength = 0;  ///< added brightness of a face perpendicular to the light
};

/// A square plate under the model, visible only from above, with the bricks' shadow on it. The edge
/// of the shadow is softer for bricks higher above the plate. (The physics has its own Ground, in
/// the scene.)
struct GroundPlate {
  double height = 0;                                 ///< z of the plate, metres
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< x and y of its middle, metres
  double halfSize = 1;                               ///< half a side, metres
  bool visible = true;  ///< false: only the shadow shows, on the background
  bool shadow = true;   ///< cast by the bricks, away from Style::shadowSource
};

/// `share` 0 gives the first colour, 1 the second; alpha is the first's.
Colour mixed(Colour colour, Colour with, double share);

/// The colours of one brick before lighting. Their alphas are equal: the opacity.
struct BrickColours {
  Colour top = {128, 174, 220};     ///< face on the side of the tile's normal
  Colour bottom = {126, 146, 166};  ///< the tile itself, seen from below
  Colour side = {96, 130, 172};     ///< faces across the thickness

  bool operator==(const BrickColours&) const = default;
};

/// Colours of a brick with one base colour: darker sides, and a muted bottom: half as colourful,
/// and darker, or paler than a dark colour. The defaults above follow this rule from their top.
BrickColours shadesOf(Colour colour);

/// The same colours with an opacity, from 0 (not drawn) to 1 (opaque). A lower opacity shows what
/// is behind the brick.
BrickColours withOpacity(BrickColours colours, double opacity);

/// Whether a brick with these colours is drawn.
inline bool isDrawn(const BrickColours& colours) {
  return colours.top.alpha > 0;
}

/// Appearance of a picture. The defaults are for a journal page: white ground, muted colours that
/// differ in grey and for colour-blind readers, thin dark outlines. Lengths "in heights of the
/// picture" are measured in the middle of the picture.
struct Style {
  Colour background = {255, 255, 255};              ///< alpha below 255 gives a transparent picture
  BrickColours brick;                               ///< of bricks without their own colours
  BrickColours pinned = shadesOf({135, 206, 235});  ///< of pinned bricks: sky blue
  Colour edge = {38, 50, 66};                       ///< outlines, see outlineOn()
  Colour ground = {238, 238, 236};                  ///< of the plate, unlit
  Colour scenery = {176, 176, 174};                 ///< of obstacles
  /// Unlit colour of the shadow on the plate. With alpha below 255 it blends with the background.
  /// Overlapping shadows are as dark as one.
  Colour shadow = {206, 207, 208};
  /// Softness of the shadow of a point at height 1 above the plate, 0: hard edges. It is the
  /// tangent of the angular diameter of the light that casts it.
  double shadowSoftness = 0.2;
  /// Unit, from the model towards the light that casts the shadow, world axes, z > 0. The shadow
  /// stays in its place if the camera moves.
  Vector3 shadowSource = {-0.36, -0.48, 0.8};
  Colour mark = {196, 52, 44};     ///< dots on joints
  Colour overlay = {200, 30, 90};  ///< lines drawn over everything
  Colour text = {30, 30, 30};      ///< captions, scales
  /// Widths of lines on the edges of tiles, in heights of the picture: with another tile on the
  /// other side, and without one. 0: no lines.
  double slitWidth = 0.00196;
  double silhouetteWidth = 0.00294;
  double markSize = 0.016;                        ///< diameter of a dot, in heights of the picture
  double overlayWidth = 0.003;                    ///< of lines laid over, in heights of the picture
  double ambient = 0.58;                          ///< brightness of an unlit face
  Light key = {Vector3(-0.36, 0.48, 0.8), 0.40};  ///< main light, from the upper left
  Light fill = {Vector3(0.8, -0.36, 0.48), 0.16};  ///< softer, from the right
  /// Brightness loss of a face that other bricks fully occlude, 0 (none) to 1.
  double occlusion = 0.6;
  std::optional<GroundPlate> plate;  ///< drawn if present
};

/// The style for slides and dark pages: nearly black ground, the same bricks, pale text. Lights and
/// widths are those of the light style.
Style darkStyle();

/// The colour of a lit face, in each channel
///   round(min(255, base * (1 - occlusion * occluded)
///                       * (ambient + key.strength * max(0, normal . key.direction)
///                                  + fill.strength * max(0, normal . fill.direction))))
/// on sRGB bytes without conversion. Alpha is the base's. normal: unit, outward, picture
/// axes, +z for a face seen face on. occluded: see Occluders, 0 to 1.
Colour faceColour(const Vector3& normal, Colour base, const Style& style, double occluded = 0);

/// The colour of all outlines of a run: the given one, or a pale one if that has more contrast to
/// the brick with the least. bricks: unlit.
Colour outlineOn(Colour edge, std::span<const Colour> bricks);

/// Position of a point's shadow on the style's plate, which must exist.
Vector3 shadowOf(const Vector3& point, const Style& style);

/// The colour at a fraction of the full shadow, from 0 (no shadow) to 1.
Colour partialShadow(const Style& style, double share);

/// A ground plate around points at the given height. Half a side is four diagonals of the points'
/// box, so its borders are visible only from near the ground. Requires at least one point.
GroundPlate groundUnder(std::span<const Vector3> points, double height);

// ------------------------------------------------------------------------------------------------
// Colour sets: scales for values, and distinct hues.
//
// A scale maps fractions in [0, 1] to colours. ColourScale (label.h) maps values to fractions.
// Colours of kinds repeat after seven; a legend can then no longer distinguish them.

/// A perceptually uniform scale: equal steps of a value appear as equal steps of colour. Scales
/// from dark to bright are also uniform in grey.
enum class ColourMap {
  Viridis,   ///< dark blue over green to yellow
  Cividis,   ///< dark blue over grey to yellow, nearly the same for colour-blind readers
  CoolWarm,  ///< diverging: blue over light grey to red, brightest in the middle
};

/// The colour at a fraction of the scale, from 0 (its first end) to 1. Fractions outside have the
/// colours of the ends. Grey for NaN. Opaque.
Colour mapColour(ColourMap map, double share);

/// The same with a compressed range of lightness: a lit face of each colour has a contrast of at
/// least 3 to the background. Equal steps still appear equal.
Colour mapColour(ColourMap map, double share, Colour background);

/// The contrast of two opaque colours, 1 to 21 (WCAG 2.1, section 1.4.3). The standard requires 3
/// for graphics and 4.5 for text.
double contrastOf(Colour a, Colour b);

/// A colour for text on a background: `text` if its contrast is at least 4.5, else a dark or a pale
/// colour.
Colour readableText(Colour text, Colour background);

/// The same hue, darker or brighter if its contrast to the background is less than 4.5.
Colour readableHue(Colour colour, Colour background);

/// The colour of a kind, `kind` >= 0: seven hues that colour-blind readers can distinguish,
/// repeated for further kinds.
Colour kindColour(int kind);

}  // namespace kirireel::picture
