/// Sets of colours: scales for values, and hues that stay apart.
///
/// Colours of a scale are given for shares from 0 to 1; which value is which share is for the scale
/// to say (grid/scale.h). Colours of kinds repeat after seven, and a legend tells them apart no
/// longer.
#pragma once

#include "render/picture/frame.h"

namespace kirireel {

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

/// The colour of one of several kinds, from 0: seven hues that the colour-blind tell apart, then
/// the same again. `kind` from 0.
Colour kindColour(int kind);

}  // namespace kirireel
