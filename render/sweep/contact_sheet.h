/// The end states of a sweep on one page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/picture/frame.h"

namespace kirireel {

/// One end state: tiles as final_vertices.txt has them, and what stands under its picture.
struct ContactPicture {
  std::filesystem::path vertices;
  std::string caption;
};

/// Most pictures on a page.
inline constexpr std::size_t kMostContacts = 100;

/// Pictures of end states in rows, each in its own scale, as many columns as rows or one more. Of
/// more than kMostContacts every so many are shown, the first and the last among them. Throws
/// InputError when there is none or a file cannot be read, OutputError when nothing can be painted.
Frame composeContactSheet(const std::vector<ContactPicture>& pictures);

}  // namespace kirireel
