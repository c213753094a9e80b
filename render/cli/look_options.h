/// Options of how pictures look and where their camera stands.
#pragma once

#include "render/studio/look.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Adds the options of look and camera, the same for every command that paints. The look must
/// outlive the parsing. Two groups in the help, "Look" ([style] in a scene file) and "Camera"
/// ([camera]).
void addLookOptions(CLI::App& command, Look& look);

}  // namespace kirireel
