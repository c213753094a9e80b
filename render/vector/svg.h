/// Pages as SVG, for print and for editing.
#pragma once

#include <memory>

#include "render/vector/canvas.h"

namespace kirireel {

/// Writes SVG 1.1 that every program reads: filled paths, lines and text, named groups that editors
/// show as layers, and one style sheet that says how faces, outlines and text look. The same page
/// gives the same bytes. The text grows in memory.
std::unique_ptr<Canvas> makeSvgCanvas(const PageSettings& settings);

}  // namespace kirireel
