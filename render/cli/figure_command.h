/// `kirireel figure PAGE`: pictures and curves of runs on one page, from a page file.
#pragma once

#include <filesystem>
#include <vector>

#include "render/record/figure_page.h"

namespace CLI {
class App;
}

namespace kirireel::cli {

/// A page file, and the figure that it describes. completeOrder() reads it.
struct FigureOrder {
  std::filesystem::path file;                  ///< of the page
  std::vector<std::filesystem::path> outputs;  ///< of --out; empty: the page's name with .pdf
  record::FigurePage page;
};

/// Reads a page file:
///
///     width = "180mm"                  # and font_size, font, letters, dpi
///     rows = [["cap"], ["error", "size"]]
///
///     [panel.cap]
///     run = "out/cap"                  # a run, or a list of runs; from the page file's folder
///     title = "Cap"                    # and share, height, and options of `render`
///
///     [panel.error]
///     run = ["out/cap", "out/fan"]
///     curves = "target_error"          # a plot, with options of `curves`
///
/// Throws InputError with file:line:column for invalid TOML, unknown keys, values that are not
/// allowed, and names of panels and runs that do not exist, with those that exist.
record::FigurePage readFigurePage(const std::filesystem::path& file);

/// Adds `figure`. The order must outlive the parsing.
CLI::App* addFigureCommand(CLI::App& program, FigureOrder& order);

/// Reads the page file. Throws like readFigurePage() and pageFormatOf(). Call it after parsing.
void completeOrder(const CLI::App& command, FigureOrder& order);

/// Writes the files and prints their names. Returns the exit code. Throws like writeFigure().
int carryOut(const FigureOrder& order);

}  // namespace kirireel::cli
