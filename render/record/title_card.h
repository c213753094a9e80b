/// The card before a video.
#pragma once

#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// One line of ASCII text in the middle of a picture, as large as a title should be and as narrow
/// as fits. Throws OutputError when the font is missing.
Frame titleCard(const std::string& text, FrameSize size, Colour background, Colour ink);

}  // namespace kirireel
