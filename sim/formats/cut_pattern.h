/// Cut patterns: what the reader of slits and that of slots share.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/formats/arrangement.h"
#include "sim/formats/drawing.h"
#include "sim/formats/read_settings.h"
#include "sim/formats/tile_checks.h"

namespace kirireel::formats {

/// The lines that part a sheet, as if the cutter took nothing away.
struct CutLines {
  std::vector<PlaneSegment> lines;     ///< outline and cuts, metres
  std::vector<PlaneSegment> border;    ///< of the removed material, that cuts end at; may be empty
  double kerf = 0;                     ///< width of the slots, metres; 0 of slits
  std::map<std::string, int> leftOut;  ///< what is no cut, and how often
};

/// Closed chains of the paths' lines. Lines whose ends meet, an even number at each place, make
/// one. `open` receives the other paths.
std::vector<std::vector<Vector2>> closedRings(const std::vector<const DrawnPath*>& paths,
                                              double tolerance,
                                              std::vector<const DrawnPath*>& open);

/// Slots, closed outlines of removed material in closed outlines of a sheet, as their centre lines.
/// Open lines are slits, or enclose a slot together with other lines. Without lines if the drawing
/// has no narrow slots.
CutLines slotLines(const std::vector<std::vector<Vector2>>& rings,
                   const std::vector<const DrawnPath*>& open, double tolerance);

/// A drawing as a sheet.
struct DrawnSheet {
  model::Model model;              ///< as readCutPattern() returns it
  std::vector<DrawnPath> ignored;  ///< lines that are not cut, metres
};

/// Like readCutPattern(), with the lines that it ignores. Throws DrawingFault for a drawing that is
/// no sheet, if the fault has a place.
DrawnSheet readDrawnSheet(const std::filesystem::path& file, const ReadSettings& settings,
                          std::vector<std::string>& warnings);

/// A pattern written by `kirireel export`. Its layers contain the kinds of lines.
model::Model ownPattern(const Drawing& drawing, const std::filesystem::path& file,
                        std::vector<std::string>& warnings);

/// Whether the names of layers are those of such a pattern.
bool isOwnPattern(const Drawing& drawing);

/// Tiles of a drawing, which have no line of their own in the file.
TileTable patternTable(const std::filesystem::path& file, const std::vector<model::Tile>& tiles);

}  // namespace kirireel::formats
