/// The end states of a sweep on one page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/grid/grid.h"
#include "render/picture/frame.h"

namespace kirireel {

/// One finished run.
struct ContactPicture {
  std::filesystem::path vertices;   ///< tiles as final_vertices.txt has them; empty: it failed
  double thickness = 0;             ///< of its bricks, metres
  std::vector<std::string> values;  ///< of the parameters that vary
};

/// Most pictures on a page.
inline constexpr std::size_t kMostContacts = 100;

/// Which pictures are on a page, row by row, and how they stand.
struct ContactLayout {
  std::vector<std::size_t> chosen;
  GridShape shape;
};

/// Where pictures come in series of `series` (those that differ in the last parameter alone; 1 for
/// none), rows end where series do, so that what is alike stands in one column. The page is about
/// as many pictures high as wide. Of more than kMostContacts pictures every so many series are
/// shown, and of them every so many pictures, the first and the last among them. count: a multiple
/// of series, positive.
ContactLayout layOutContacts(std::size_t count, std::size_t series);

/// Pictures of end states with their parameters, each in its own scale; nothing but the parameters
/// for runs that failed. keys: names of the parameters. Throws InputError when there is no picture
/// or a file cannot be read, OutputError when nothing can be painted. `pictures` in the order of
/// the table; each has as many values as there are keys. Paints up to 100 small pictures.
Frame composeContactSheet(const std::vector<std::string>& keys,
                          const std::vector<ContactPicture>& pictures);

}  // namespace kirireel
