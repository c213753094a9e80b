/// A picture of a model with the numbers of its tiles and vertices.
#pragma once

#include "render/picture/frame.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// The model at the start and, where there is one, at the target, side by side: each tile's number
/// in its middle, each vertex's number inside its corner. Throws OutputError when no graphics
/// context can be made or the font is missing.
/// Corners that a reader mended are marked. `stateSize`: pixels of one state's picture.
Frame numberedPicture(const Scene& scene, FrameSize stateSize);

/// A polygon that makes no tile: its sides as lines, and where two of them meet as a dot. Throws
/// OutputError when no graphics context can be made. `place`: where two sides cross, metres.
Frame crossingPicture(const Tile& tile, const Vector3& place, FrameSize size);

}  // namespace kirireel
