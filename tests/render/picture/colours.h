/// Colours for tests of pictures.
#pragma once

#include "render/picture/frame.h"

namespace kirireel::test {

inline constexpr picture::Colour kWhite = {255, 255, 255};
inline constexpr picture::Colour kBlack = {0, 0, 0};

}  // namespace kirireel::test
