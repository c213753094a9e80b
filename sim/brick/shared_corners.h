/// Joined bricks as they meet each other: without the corners that they share.
#pragma once

#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/brick/brick.h"

namespace kirireel {

/// The shape of a brick without some of its corners: each edge that leads to one ends `length`
/// metres earlier, or at two fifths of its own length if that is less. Mass and axes stay. The
/// brick is convex, or a piece of one that is not.
Brick withoutCorners(const Brick& brick, const std::vector<int>& corners, double length);

/// The same of a piece, `corners` being those of the whole brick.
Brick withoutCorners(const BrickPiece& piece, const std::vector<int>& corners, double length);

/// The corners at which two bricks are joined, as vertices of their tiles, each once.
struct SharedCorners {
  std::vector<int> ofA;
  std::vector<int> ofB;
};

/// The shared corners of all joined pairs, none where bricks are linked or fixed; keys have the
/// smaller brick number first.
std::map<std::pair<int, int>, SharedCorners> sharedCorners(std::span<const Pivot> pivots);

/// The length that is cut off each edge at a corner that two bricks share, metres: thick bricks
/// that are joined on one face would be stopped there by the least fold towards the other face.
/// `zone` is the part of both bricks' mean edge, from 0 (nothing) to 0.4.
double cutLength(const Brick& a, const Brick& b, double zone);

}  // namespace kirireel
