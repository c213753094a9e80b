/// The files that a page is made of, as the program has them within.
#pragma once

#include <string_view>

namespace kirireel::record {

/// All bytes of a file of render/record/web or of three.js by its name, for example "page.css";
/// empty where the program was built without it.
std::string_view embeddedFile(std::string_view name);

}  // namespace kirireel::record
