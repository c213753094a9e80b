/// The sheet whose motion is known in closed form: squares that open from 0 to 90 degrees.
#pragma once

#include <vector>

#include "sim/scene/scene.h"

namespace kirireel {

/// A square sheet of side x side tiles, without contacts, opened by so many radians at the start.
/// Joints on both faces are hinges, two point joints each to engines; on the bottom alone they are
/// one.
/// Tiles are 1 m wide; the target is the sheet opened to 90 degrees.
Scene sheetScene(int side, bool planar, JointFace face = JointFace::Both, double startAngle = 0);

/// The angle between the first two tiles of a sheet, radians from 0.
double openingAngle(const Poses& poses);

/// How far vertices are from where they should be, metres.
struct VertexError {
  double max = 0;
  double mean = 0;
};

/// How far corresponding vertices are apart.
VertexError vertexError(const std::vector<Tile>& found, const std::vector<Tile>& wanted);

/// The states that a sheet passes through, at equal times.
using SheetWay = std::vector<std::vector<Tile>>;

/// The limit of ever shorter steps of first order: their error is a power series in the step, so
/// that ways in steps of h, h / 2 and h / 4 give it but for the third order.
/// All three have the same states at the same times.
SheetWay limitOfSteps(const SheetWay& coarse, const SheetWay& middle, const SheetWay& fine);

/// The farthest that a vertex is on one way from where it is on another at that time, metres.
double wayError(const SheetWay& found, const SheetWay& wanted);

/// How far a sheet is from the exact one at the same opening angle, wherever that one is placed.
VertexError sheetError(int side, double angle, const std::vector<Tile>& found);

}  // namespace kirireel
