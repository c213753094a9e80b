/// Tips of openings, such as holes between tiles, that stop short of other lines.
#pragma once

#include <vector>

#include "sim/formats/arrangement.h"
#include "sim/formats/cut_rays.h"
#include "sim/formats/drawing.h"

namespace kirireel::formats {

/// A tip of an opening: two straight sides, and a corner, a short edge or a fillet between them. Or
/// a point of a smooth opening.
struct OpeningTip {
  Vector2 from = Vector2::Zero();   ///< position of the tip, metres
  Vector2 along = Vector2::Zero();  ///< bisector of the sides, into the material; unit vector
  double straight = 0;              ///< length of the shorter side, or distance to the middle
  bool isSharp = false;             ///< the sides meet at the tip
  std::vector<Vector2> ends;        ///< the vertices between the sides
};

/// Rings with material on their left: outlines anticlockwise, openings in them clockwise. Outer
/// rings without any of `within` in their material are frames of a page and are dropped.
std::vector<PlaneRing> orientedRings(std::vector<PlaneRing> rings,
                                     const std::vector<Vector2>& within);

/// The tips of openings with an angle of at most 150 degrees, except of slots. Rings have material
/// on their left.
std::vector<OpeningTip> openingTips(const std::vector<PlaneRing>& rings, double tolerance);

/// The rays of the tips up to the next line, in the order of the tips. Tips of one kind that face
/// each other stop midway. A ray that has no use has no stop: other lines leave its tip, or it runs
/// back along the ray of another tip.
std::vector<CutRay> traceTips(const std::vector<OpeningTip>& tips, const Arrangement& lines,
                              double tolerance);

/// The largest width of a neck at a tip, metres, at most half of a tile's size. If there are other
/// necks, it is twice their largest width `known`. Otherwise it lies in the largest gap, as a
/// ratio, between the widths of the rays. `area`, `faces`: of the sheet without tips.
double widestTip(const std::vector<CutRay>& rays, double known, double area, int faces);

}  // namespace kirireel::formats
