/// A drawing for the cutter as a model, with the lines that are not cut.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/formats/drawing.h"
#include "sim/formats/read_settings.h"
#include "sim/model/model.h"

namespace kirireel::formats {

/// A drawing as a sheet.
struct DrawnSheet {
  model::Model model;              ///< as readCutPattern() returns it
  std::vector<DrawnPath> ignored;  ///< lines that are not cut, metres
};

/// Like readCutPattern(), with the lines that it ignores. Throws DrawingFault for a drawing that is
/// no sheet, if the fault has a place.
DrawnSheet readDrawnSheet(const std::filesystem::path& file, const ReadSettings& settings,
                          std::vector<std::string>& warnings);

}  // namespace kirireel::formats
