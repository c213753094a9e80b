/// Options of everything that paints: looks, cameras, videos.
#pragma once

#include "render/picture/state_painter.h"
#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel {

// ------------------------------------------------------------------------------------------------
// Options of everything that paints.

/// Adds the options of pictures and what is made of them. The settings must outlive the parsing.
/// The group in a scene file is [recording]; look and camera follow in groups of their own. Values
/// are checked one by one here, and together by record() and render().
void addPictureOptions(CLI::App& command, PictureSettings& settings);

// ------------------------------------------------------------------------------------------------
// Options of how pictures look and where their camera stands.

/// Adds the options of look and camera, the same for every command that paints. The look must
/// outlive the parsing. Two groups in the help, "Look" ([style] in a scene file) and "Camera"
/// ([camera]).
void addLookOptions(CLI::App& command, Look& look);

// ------------------------------------------------------------------------------------------------
// Options of the video.

/// Adds the options of the video, but for its frames a second. The settings must outlive the
/// parsing. They stand in [recording] of a scene file.
void addVideoOptions(CLI::App& command, PictureSettings& settings);

}  // namespace kirireel
