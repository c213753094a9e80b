/// Options of everything that simulates.
#pragma once

#include "sim/scene/scene.h"

namespace CLI {
class App;
}

namespace kirireel {

class OptionGroup;

/// Adds --thickness, which is 0 where the model decides.
void addThicknessOption(OptionGroup& group, BrickRule& brick);

/// Adds the options that fill a scene: bricks, springs, environment, end of the run, solver. The
/// scene must outlive the parsing.
void addSceneOptions(CLI::App& command, Scene& scene);

}  // namespace kirireel
