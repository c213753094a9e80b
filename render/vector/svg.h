/// Figures as scalable vector graphics, for print and for editing.
#pragma once

#include <string>

#include "render/picture/frame.h"
#include "render/picture/sketch.h"

namespace kirireel {

/// The text of an SVG 1.1 file that shows the sketch as the painter does: the same colours, hidden
/// surfaces removed, one unit a pixel of a picture of this size. Its elements are filled paths
/// alone, so that every program reads it. The same sketch gives the same bytes.
std::string svgText(const Sketch& sketch, const Camera& camera, FrameSize size, Colour background);

}  // namespace kirireel
