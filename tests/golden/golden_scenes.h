/// Scenes and appearances of the golden pictures.
#pragma once

#include <string>
#include <vector>

#include "render/picture/state_painter.h"

namespace kirireel::test {

/// A state in the middle of a motion.
struct GoldenScene {
  std::string name;  ///< of its sheet in tests/golden
  picture::PictureContent content;
  Poses poses;
};

/// Squares and rectangles half open, bricks in many rotations, bricks that cross, a sheet bent to
/// half a cylinder, and one bent to a cap.
std::vector<GoldenScene> goldenScenes();

/// One way to show a scene.
struct GoldenLook {
  std::string name;
  picture::Appearance appearance;
  std::vector<int> pinned;
};

/// All styles.
std::vector<GoldenLook> goldenLooks();

}  // namespace kirireel::test
