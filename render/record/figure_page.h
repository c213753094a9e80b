/// Figures of a paper: pictures and curves of runs as panels of one page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/record/curves.h"
#include "render/record/job.h"
#include "sim/base/error.h"

namespace kirireel::record {

/// A panel: the pictures of `kirireel render`, or the diagrams of `kirireel curves`.
struct FigurePanel {
  std::string title;             ///< next to its letter, UTF-8; may be empty
  double share = 1;              ///< of the row's width, relative to the row's other panels, > 0
  std::optional<double> height;  ///< millimetres without letter and title; pictures: at most
  std::vector<std::filesystem::path> runs;  ///< their trajectory.h5, one or more
  PictureSettings pictures;                 ///< of the pictures; size in print is the page's
  /// Which curves a plot shows, and its axis. Absent: the panel has pictures.
  std::optional<CurvesSettings> curves;
  FileLocation where;  ///< of the panel in its page file; errors name it
};

/// A page and its files.
struct FigurePage {
  double width = 180;        ///< millimetres
  double fontPoints = 7;     ///< size of all text
  double dotsPerInch = 300;  ///< pixels of a PNG, and the unit of SVG
  std::string font;          ///< family of all text; empty: the program's
  picture::PanelLetters letters = picture::PanelLetters::Small;  ///< of the panels
  std::vector<std::vector<FigurePanel>> rows;  ///< from the top, panels from the left
  std::filesystem::path folder;                ///< created if needed
  std::vector<std::string> files;              ///< in the folder; each ends in .svg, .pdf or .png
};

/// The format of a page with this name. Throws InputError for an ending other than .svg, .pdf and
/// .png.
picture::PageFormat pageFormatOf(const std::string& file);

/// Writes the page in each format, all files or none, and lists them in contents.json. Equal pages
/// give equal bytes. Throws InputError for a run that cannot be read, a curve that does not exist
/// and a panel that is too narrow, each with the panel's position. Throws InputError if files from
/// elsewhere are in the way, OutputError if a file cannot be written.
void writeFigure(const FigurePage& page);

}  // namespace kirireel::record
