/// Slots: cuts with a width, as closed outlines of removed material.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/formats/arrangement.h"
#include "sim/formats/opening_tips.h"

namespace kirireel::formats {

/// The lines that part a sheet, as if the cutter removed nothing.
struct CutLines {
  std::vector<PlaneSegment> lines;     ///< outline and cuts, metres
  std::vector<PlaneSegment> border;    ///< of the removed material, that cuts end at; may be empty
  double kerf = 0;                     ///< width of the slots, metres; 0 of slits
  std::vector<OpeningTip> tips;        ///< of openings wider than slots, and of the outline
  std::vector<PlaneRing> openings;     ///< those of the tips
  std::map<std::string, int> leftOut;  ///< lines that are not cuts, with their numbers
};

/// Closed chains of the paths' lines. Lines whose ends meet, an even number at each position, make
/// one. `open` receives the other paths.
std::vector<PlaneRing> closedRings(const std::vector<const DrawnPath*>& paths, double tolerance,
                                   std::vector<const DrawnPath*>& open);

/// Largest extent of a relief, as a fraction of the length of its slit.
inline constexpr double kRelief = 0.5;

/// The diagonal of a ring's bounding box, metres.
double extentOf(const std::vector<Vector2>& ring);

/// Removes rings around one outline that itself contains rings. Sorts the rings by size.
void dropFrames(std::vector<PlaneRing>& rings, std::map<std::string, int>& leftOut);

/// The borders of sheets without what other rings remove, by GEOS. Material is on their left.
std::vector<PlaneRing> materialRings(const std::vector<PlaneRing>& rings);

/// Slots, closed outlines of removed material in closed outlines of a sheet, as their centre lines.
/// Open lines are slits, or enclose a slot together with other lines. Without lines if the drawing
/// has no narrow slots.
CutLines slotLines(const std::vector<PlaneRing>& rings, const std::vector<const DrawnPath*>& open,
                   double tolerance);

}  // namespace kirireel::formats
