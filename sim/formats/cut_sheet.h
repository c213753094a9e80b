/// Tiles and joints between the cuts of a sheet.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "sim/formats/read_settings.h"
#include "sim/formats/slot_lines.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// A sheet found in a drawing.
struct CutSheet {
  model::Model model;
  std::string found;                   ///< summary of tiles, hinges, necks and slots, one line
  std::map<std::string, int> leftOut;  ///< lines and faces that are not part of it, with counts
};

/// Reads lines as a sheet. `tolerance`: distance of points that are one, metres. Throws
/// DrawingFault for open outlines, strips that must bend, pieces without a hinge, and cuts that
/// cross a line and end beyond it; InputError for lines that enclose nothing.
CutSheet sheetOfCuts(const CutLines& cuts, const Drawing& drawing, const ReadSettings& settings,
                     double tolerance, const std::filesystem::path& file);

}  // namespace kirireel::formats
