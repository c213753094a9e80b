/// Options of the video.
#pragma once

#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Adds the options of the video, but for its frames a second. The settings must outlive the
/// parsing. They stand in [recording] of a scene file.
void addVideoOptions(CLI::App& command, PictureSettings& settings);

}  // namespace kirireel
