/// Options of everything that paints.
#pragma once

#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Adds the options of pictures and what is made of them. The settings must outlive the parsing.
void addPictureOptions(CLI::App& command, PictureSettings& settings);

}  // namespace kirireel
