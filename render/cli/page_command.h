/// `kirireel page RUN...`.
#pragma once

#include <filesystem>
#include <vector>

#include "render/page/page.h"

namespace CLI {
class App;
}

namespace kirireel {

/// Which runs go on a page, and how. At least one run, at most kMostPageRuns.
struct PageOrder {
  std::vector<std::filesystem::path> runs;  ///< each a trajectory.h5, or the folder that it is in
  WebPageSettings settings;                 ///< the folder is empty when --out was not given
};

/// Adds the options that say what a page has. The settings must outlive the parsing.
void addPageOptions(CLI::App& command, WebPageSettings& settings);

/// Adds `page`. The order must outlive the parsing.
CLI::App* addPageCommand(CLI::App& program, PageOrder& order);

/// Throws InputError where something is missing or too much. To be called after parsing.
void completeOrder(const CLI::App& command, PageOrder& order);

/// Writes the page, and prints its name. Returns the exit code. The size is in megabytes of 10^6
/// bytes. Throws InputError for a folder without a trajectory or a page above --most-size, and what
/// writePage throws.
int carryOut(const PageOrder& order);

}  // namespace kirireel
