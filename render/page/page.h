/// Pages to hand over: one HTML file that shows runs in 3-D in any browser, without a network.
///
/// A page is page.html with its style sheet, its scripts, three.js (r111, MIT licence) and the
/// runs' data within. What it shows looks as our pictures do: colours, lights, widths and cameras
/// come from render/picture and render/studio as data.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "render/page/page_data.h"
#include "render/studio/look.h"

namespace kirireel {

/// The file that a page is, in its folder.
inline constexpr const char* kPageFile = "page.html";

/// At most so many runs stand side by side on a page.
inline constexpr std::size_t kMostPageRuns = 2;

/// Which page is wanted. One look for all runs, so that two of them can be compared.
struct WebPageSettings {
  std::filesystem::path folder;  ///< made if need be
  PageStates states;
  /// Files in the folder of each trajectory that go into the page: videos play, pictures show,
  /// others can be saved from it.
  std::vector<std::string> embedded;
  double mostMegabytes = 25;  ///< a larger page is refused; 1e6 bytes each
  Look look;                  ///< of all runs
};

/// Whether this program can make pages: three.js was there when it was built. three.js is taken in
/// at build time.
bool canMakePages();
/// Throws OutputError where it cannot, with what to do about it.
void requirePages();

/// The text of a page of one run or two. Throws InputError where a run lacks what the look asks for
/// and where the page would be too large, OutputError where the program cannot make pages. A run is
/// read from its trajectory; with 201 states of a thousand bricks the text has some megabytes.
std::string pageText(const std::vector<std::filesystem::path>& trajectories,
                     const WebPageSettings& settings);

/// Writes it as page.html into the folder, and lists it in the folder's contents.json. Throws as
/// pageText(), and OutputError when it cannot be written.
void writePage(const std::vector<std::filesystem::path>& trajectories,
               const WebPageSettings& settings);

}  // namespace kirireel
