/// How pictures look, and the colours they are made of.
#pragma once

#include <optional>
#include <span>

#include "render/picture/frame.h"
#include "sim/base/geometry.h"

namespace kirireel::picture {

// ------------------------------------------------------------------------------------------------
// How pictures look: colours, lights, outlines, ground.

/// A light at infinity.
struct Light {
  Vector3 direction = Vector3::UnitZ();  ///< unit, from the model towards the light, world axes
  double strength = 0;                   ///< added brightness of a face that faces the light
};

/// A square plate under the model, seen from above only, and the bricks' shadow on it, whose edge
/// is the softer the higher above the plate the brick is that casts it. (The physics has its own
/// Ground, in the scene.)
struct GroundPlate {
  double height = 0;                                 ///< z of the plate, metres
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< x and y of its middle, metres
  double halfSize = 1;                               ///< half a side, metres
  bool visible = true;  ///< else only the shadow shows, on the background
  bool shadow = true;   ///< cast by the bricks, along the key light
};

/// The colours of one brick before lighting. Their alphas are the same: how opaque it is.
struct BrickColours {
  Colour top = {128, 174, 220};     ///< face on the side of the tile's normal
  Colour bottom = {244, 190, 116};  ///< the tile itself, seen from below
  Colour side = {96, 130, 172};     ///< faces across the thickness

  bool operator==(const BrickColours&) const = default;
};

/// Colours of a brick that is one colour all over: its sides are darker, its bottom paler.
BrickColours shadesOf(Colour colour);

/// The same colours on a brick that lets what is behind it show through: opacity 0 (not there at
/// all) to 1 (opaque).
BrickColours withOpacity(BrickColours colours, double opacity);

/// Whether a brick with these colours is drawn at all.
inline bool isDrawn(const BrickColours& colours) {
  return colours.top.alpha > 0;
}

/// The look of a picture. The defaults are meant for a page of a journal: white ground, quiet
/// colours that stay apart in grey and for the colour-blind, thin dark outlines. Lengths "in
/// heights of the picture" are measured in the middle of the picture.
struct Style {
  Colour background = {255, 255, 255};              ///< alpha below 255 gives a transparent picture
  BrickColours brick;                               ///< of bricks that have no colours of their own
  BrickColours pinned = shadesOf({135, 206, 235});  ///< of pinned bricks: sky blue
  Colour edge = {38, 50, 66};                       ///< outlines
  Colour paleEdge = {168, 176, 188};                ///< outlines of dark bricks, see isDark()
  Colour ground = {238, 238, 236};                  ///< of the plate, drawn as it is, not lit
  Colour scenery = {176, 176, 174};                 ///< of obstacles
  /// Drawn where the key light does not reach, as it is. With alpha below 255 it takes the place of
  /// what is under it: overlapping shadows are as dark as one.
  Colour shadow = {206, 207, 208};
  /// How far the shadow of a point at height 1 above the plate fades out, 0 for hard edges: the
  /// tangent of the angle under which the key light is seen.
  double shadowSoftness = 0.2;
  Colour mark = {196, 52, 44};     ///< dots on joints
  Colour overlay = {200, 30, 90};  ///< lines laid over everything
  Colour text = {30, 30, 30};      ///< captions, scales
  /// Widths of lines on the edges of tiles, in heights of the picture: where a tile continues on
  /// the other side, and where none does. 0 for no lines.
  double slitWidth = 0.00196;
  double silhouetteWidth = 0.00294;
  double markSize = 0.016;      ///< diameter of a dot, in heights of the picture
  double overlayWidth = 0.003;  ///< of lines laid over, in heights of the picture
  double ambient = 0.58;        ///< brightness of a face that no light reaches
  Light key = {Vector3(-0.36, -0.48, 0.8), 0.40};  ///< main light, from the upper left
  Light fill = {Vector3(0.8, -0.36, 0.48), 0.16};  ///< softer, from the right
  /// Brightness that a face loses from which other bricks keep all light away, 0 (none) to 1.
  double occlusion = 0.6;
  std::optional<GroundPlate> plate;  ///< drawn when present
};

/// The look for slides and dark pages: nearly black ground, the same bricks, pale lettering. Lights
/// and widths are those of the light one.
Style darkStyle();

/// The colour of a lit face, the one rule of shading: in each channel
///   round(min(255, base * (1 - occlusion * occluded)
///                       * (ambient + key.strength * max(0, normal . key.direction)
///                                  + fill.strength * max(0, normal . fill.direction))))
/// on sRGB bytes as they are. Alpha is the base's. normal: unit, outward, world axes. occluded: see
/// Occluders, 0 to 1.
Colour faceColour(const Vector3& normal, Colour base, const Style& style, double occluded = 0);

/// Whether dark outlines hardly show on a brick of these colours. Below a luma of 85 of 255 on the
/// top face.
bool isDark(const BrickColours& colours);

/// Where the key light casts the shadow of a point: on the style's plate, which must be there.
Vector3 shadowOf(const Vector3& point, const Style& style);

/// The colour of a share of the full shadow, 0 (what is under it) to 1.
Colour partialShadow(const Style& style, double share);

/// A ground plate around points at the given height, so wide that its borders are out of sight
/// except from near the ground. At least one point. Half a side is four diagonals of the points'
/// box.
GroundPlate groundUnder(std::span<const Vector3> points, double height);

// ------------------------------------------------------------------------------------------------
// Sets of colours: scales for values, and hues that stay apart.
//
// Colours of a scale are given for shares from 0 to 1. The scale (label.h) maps values to shares.
// Colours of kinds repeat after seven; a legend can then no longer distinguish them.

/// A perceptually even scale: equal steps of a value look like equal steps of colour; those from
/// dark to bright in grey too.
enum class ColourMap {
  Viridis,   ///< dark blue over green to yellow
  Cividis,   ///< dark blue over grey to yellow, the same to nearly all colour-blind readers
  CoolWarm,  ///< diverging: blue over light grey to red, brightest in the middle
};

/// The colour of a share of the scale, 0 (its first end) to 1; shares beyond are the ends' colours.
/// Grey for NaN. Opaque.
Colour mapColour(ColourMap map, double share);

/// The same, with the scale's range of lightness compressed: a lit face of each colour has a
/// contrast of 3 or more to the background. Equal steps still look equal.
Colour mapColour(ColourMap map, double share, Colour background);

/// The contrast of two opaque colours, 1 to 21 (WCAG 2.1, section 1.4.3). At least 3 is required of
/// graphics, 4.5 of text.
double contrastOf(Colour a, Colour b);

/// A colour for text on a background: `text` if its contrast is at least 4.5, else a dark or a pale
/// one.
Colour readableText(Colour text, Colour background);

/// The colour of one of several kinds, from 0: seven hues that the colour-blind tell apart, then
/// the same again. `kind` from 0.
Colour kindColour(int kind);

}  // namespace kirireel::picture
