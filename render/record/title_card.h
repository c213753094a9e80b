/// The card before a video.
#pragma once

#include <string>

#include "render/picture/frame.h"

namespace kirireel {

/// What a card says, UTF-8; line feeds begin new lines.
struct Title {
  std::string title;
  std::string subtitle;

  bool empty() const { return title.empty() && subtitle.empty(); }
};

/// Throws InputError for a text that is not UTF-8, or has a character that the font lacks, and
/// OutputError when the font is missing.
void requireTitle(const Title& title);

/// The title in the middle of a picture, its subtitle below in smaller letters. Lines that would be
/// too wide are wrapped; what is too wide or too high even so is drawn smaller. Throws OutputError
/// when the font is missing. At least one of the texts is not empty.
Frame titleCard(const Title& title, FrameSize size, Colour background, Colour ink);

}  // namespace kirireel
