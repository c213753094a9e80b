/// What to cut out of a flat sheet to make a planar model.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "sim/model/model.h"

namespace kirireel {

/// Kinds of lines, which cutters tell apart by layer.
enum class PatternLayer {
  Cuts,    ///< edges of one tile: outline and holes
  Slits,   ///< edges that two tiles share, once
  Hinges,  ///< material that stays: from a joint to the end of the cut beside it; not to be cut
};

/// A straight line in the sheet's plane, metres, seen from the side that the tiles face. Straight
/// from end to end; lines of one layer may touch but do not overlap.
struct PatternLine {
  PatternLayer layer = PatternLayer::Cuts;
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// The lines of the model's start. Around each joint a neck of material stays: the narrower gap
/// between its two tiles ends the hinge width (metres, positive) before the joint, so that the
/// sheet stays in one piece. Edges are shared when they coincide as a whole, within 1e-4 of the
/// tile size.
///
/// Throws InputError for a start that is not flat or has tiles on both faces, joints that are not
/// hinges at a corner, and a width at which an edge would not be cut at all. Hinges first, then
/// edges in the order of tiles. Costs a lookup an edge.
std::vector<PatternLine> cutPattern(const Model& model, double hingeWidth);

/// The lines as an SVG in millimetres at true size, a group a layer. A margin of 5 mm stays around
/// the pattern. Digits read back to the same doubles.
std::string patternSvg(const std::vector<PatternLine>& lines);

/// The lines as a DXF (R12) in metres, a layer a kind. Colours of layers: cuts red (1), slits blue
/// (5), hinges green (3).
std::string patternDxf(const std::vector<PatternLine>& lines);

}  // namespace kirireel
