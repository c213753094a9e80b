/// Sketches on pages, hidden surfaces removed.
#pragma once

#include "render/picture/camera.h"
#include "render/picture/sketch.h"
#include "render/vector/canvas.h"

namespace kirireel {

/// Draws what the camera sees of the sketch, from back to front, in parts called `name`_ground,
/// _shadow, _bricks, _outlines and _overlay as far as there are such (without `name`_ when that is
/// empty). size: of the picture, pixels; its upper left corner stands at `corner` of the canvas.
/// Names must be unique on a page: they become ids in SVG.
void drawSketch(const Sketch& sketch, const Camera& camera, FrameSize size,
                const Eigen::Vector2d& corner, const std::string& name, Canvas& canvas);

}  // namespace kirireel
