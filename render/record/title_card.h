/// The card before a video.
#pragma once

#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// Throws InputError for a title that is not UTF-8, or has a character that the font lacks, and
/// OutputError when the font is missing.
void requireTitle(const std::string& title);

/// One line of text in UTF-8 in the middle of a picture, as large as a title should be and as
/// narrow as fits. Throws OutputError when the font is missing.
Frame titleCard(const std::string& text, FrameSize size, Colour background, Colour ink);

}  // namespace kirireel
