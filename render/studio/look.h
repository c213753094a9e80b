/// What is asked of the pictures of a run.
///
/// Plain values; what each needs of a run is checked by Stage.
#pragma once

#include <optional>
#include <vector>

#include "render/picture/camera_path.h"
#include "render/picture/frame.h"
#include "render/picture/palette.h"

namespace kirireel {

/// Page that the pictures are meant for.
enum class Theme { Light, Dark };

/// What the colours of the bricks say.
enum class Colouring {
  Plain,         ///< nothing: one set of colours
  Shape,         ///< which tiles are congruent; by their number of corners when many shapes differ
  State,         ///< whether a brick is at its start, on its way, or at its target
  TargetError,   ///< largest distance of a vertex from its target
  Displacement,  ///< distance from the start
  Rotation,      ///< angle from the start
  JointGap,      ///< largest gap of the brick's joints
  Moment,        ///< largest moment of the springs at the brick's hinges
  Energy,        ///< half of what these springs hold
};

/// What lies under the bricks.
enum class GroundLook {
  Auto,    ///< a plate and a shadow when the scene has a ground, else nothing
  Plate,   ///< a plate and a shadow
  Shadow,  ///< a shadow on the page
  None,    ///< nothing
};

/// What the camera must hold in sight.
enum class FitScope {
  Auto,  ///< as Ends; as Run when there is no target or something would be cut off
  Run,   ///< the start, the target and everything in between
  Ends,  ///< the start and the target; what leaves them on the way is cut off
};

/// A colour for some tiles.
struct TileColour {
  std::vector<int> tiles;  ///< numbers, from 0
  Colour colour;
};

/// The look of all pictures of a run. Defaults give the pictures that a run leaves without any
/// option.
struct Look {
  Theme theme = Theme::Light;
  bool transparent = false;  ///< no background
  Colouring colouring = Colouring::Plain;
  ColourMap map = ColourMap::Viridis;  ///< of colours by a measure
  /// Values at the ends of the scale, in the unit of the measure; absent: 0, and the largest to be
  /// expected.
  std::optional<double> colourLeast, colourMost;
  std::optional<Colour> brickColour;  ///< of all bricks, where the colouring is plain
  std::optional<Colour> backColour;   ///< of the tile's own side, likewise
  /// Of single tiles, where colours stand for no measure; of two for one tile the later counts.
  std::vector<TileColour> tileColours;
  std::optional<Colour> outlineColour;  ///< absent: the theme's, as is the next
  std::optional<Colour> background;
  bool outlines = true;     ///< lines on the edges of tiles
  double outlineWidth = 1;  ///< of these lines, times the style's, positive
  /// Brightness that a face loses from which other bricks keep all light away, 0 to 1; absent: the
  /// style's.
  std::optional<double> occlusion;
  bool jointMarks = false;   ///< a dot on each joint
  bool targetLines = false;  ///< the target's tiles as lines, dashed where bricks hide them
  GroundLook ground = GroundLook::Auto;
  CameraChoice camera;
  FitScope fit = FitScope::Auto;
};

}  // namespace kirireel
