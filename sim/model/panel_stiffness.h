/// How stiffly tiles stretch and bend, and folds turn, as bars and hinges.
///
/// E. T. Filipov, K. Liu, T. Tachi, M. Schenk, G. H. Paulino, Bar and hinge models for scalable
/// analysis of origami, Int. J. Solids Struct. 124, 2017; K. Liu, G. H. Paulino, Highly efficient
/// nonlinear structural analysis of origami assemblages using the MERLIN2 software, Origami 7,
/// 2018. Young's modulus in Pa, lengths in metres, all positive.
#pragma once

#include <array>

#include "sim/base/geometry.h"

namespace kirireel {

/// The cross-section of the three bars at the sides of a triangle, square metres: A = 2 S t / ((1 -
/// nu) (a + b + c)), S its area, with which the triangle, stretched alike in all directions, holds
/// as much as a plate.
double barArea(const std::array<Vector3, 3>& triangle, double thickness, double poisson);

/// The moment per angle, N m/rad, of a tile that bends about a diagonal of length D: k = C E t^3 /
/// (12 (1 - nu^2)) (D / t)^(1/3), C = 0.55 - 0.42 s / pi, s the sum over the four corners round the
/// diagonal of what they differ from right angles; C is 0.05 at least. Restrained by its edges, a
/// thin sheet bends along a ridge, hence the third root.
double bendStiffness(const std::array<Vector3, 4>& corners, double diagonal, double youngs,
                     double poisson, double thickness);

/// Of a fold of a length, N m/rad: k = E t^3 / (12 (1 - nu^2)) length / scale. The length scale is
/// that over which a panel as stiff as the fold would bend: 25 to 100 mm for paper of 0.1 mm.
double foldStiffness(double length, double scale, double youngs, double poisson, double thickness);

}  // namespace kirireel
