/// What "closed" means for the joints of a model whose coordinates were rounded.
///
/// Tiles of an over-constrained mechanism fit each other in all of its states only with all their
/// digits. Rounded by d, in tiles, they miss each other by about d on the way, and no state but the
/// start closes exactly: singular values of the joints' Jacobian that should be zero are about d,
/// and closing a gap c exactly moves tiles along them by c / d, back to the start. So joints close
/// as far as the tiles fit, by Tikhonov's rule: instead of c(q) = 0, states minimise
///   |q - g|^2 + r |c(q)|^2,   r = 10 / d,
/// g the place that tiles are pulled to, less than a tile away. The pull opens joints by |q - g| /
/// r beyond the tiles' misfit: less than a tenth of the digit. The misfit, r |c|^2 about r d^2,
/// moves tiles along the mechanism by some r d^2, ten digits, and in singular states, where gaps
/// grow with the square of the move, by the root of that. Motions with singular values above sqrt(d
/// / 10) are held by the joints, those below go with the pull. Near its place a state comes nearer
/// by softer joints, as long as they stay closed within two digits. Neumaier (1998), "Solving
/// ill-conditioned and singular linear systems", SIAM Review 40, section 3.
#pragma once

#include <functional>

#include "sim/model/model.h"

namespace kirireel {

/// The stiffness r of joints that close within the model's rounding, over that of the springs that
/// pull a tile to its place; infinite where coordinates have all their digits.
double roundedJointStiffness(const Model& model);

/// How much farther from its place a state may stand because of the rounding, and how far joints
/// may be open on the way, metres: ten digits.
double roundedReach(const Model& model);

/// How far joints may be open at the end, metres: two digits, by which two roundings of one corner
/// can be apart.
double roundedGap(const Model& model);

/// Calls `closes` with ever softer joints until it says that they are not closed within
/// roundedGap() any more.
void softenWhileClosed(const Model& model, const std::function<bool(double stiffness)>& closes);

}  // namespace kirireel
