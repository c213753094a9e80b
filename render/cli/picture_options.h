/// Options of everything that paints.
#pragma once

#include "render/record/record.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Adds the options of pictures and what is made of them. The settings must outlive the parsing.
/// The group in a scene file is [recording]; look and camera follow in groups of their own. Values
/// are checked one by one here, and together by record() and render().
void addPictureOptions(CLI::App& command, PictureSettings& settings);

}  // namespace kirireel
