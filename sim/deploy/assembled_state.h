/// The state that a deployment should reach: found before it, with joints closed, and what is
/// in the way there.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// What "closed" means for the joints of a model whose coordinates were rounded.
//
// Tiles of an over-constrained mechanism fit each other in all of its states only with all their
// digits. Rounded by d, in tiles, they miss each other by about d on the way, and no state but the
// start closes exactly: singular values of the joints' Jacobian that should be zero are about d,
// and closing a gap c exactly moves tiles along them by c / d, back to the start. So joints close
// as far as the tiles fit, by Tikhonov's rule: instead of c(q) = 0, states minimise
//   |q - g|^2 + r |c(q)|^2,   r = 10 / d,
// g the place that tiles are pulled to, less than a tile away. The pull opens joints by |q - g| /
// r beyond the tiles' misfit: less than a tenth of the digit. The misfit, r |c|^2 about r d^2,
// moves tiles along the mechanism by some r d^2, ten digits, and in singular states, where gaps
// grow with the square of the move, by the root of that. Motions with singular values above sqrt(d
// / 10) are held by the joints, those below go with the pull. Near its place a state comes nearer
// by softer joints, as long as they stay closed within two digits. Neumaier (1998), "Solving
// ill-conditioned and singular linear systems", SIAM Review 40, section 3.

/// The stiffness r of joints that close within the model's rounding, over that of the springs that
/// pull a tile to its place; infinite where coordinates have all their digits.
double roundedJointStiffness(const model::Model& model);

/// How much farther from its place a state may stand because of the rounding, and how far joints
/// may be open on the way, metres: ten digits.
double roundedReach(const model::Model& model);

/// How far joints may be open at the end, metres: two digits, by which two roundings of one corner
/// can be apart.
double roundedGap(const model::Model& model);

/// Calls `closes` with ever softer joints until it says that they are not closed within
/// roundedGap() any more.
void softenWhileClosed(const model::Model& model,
                       const std::function<bool(double stiffness)>& closes);

// ------------------------------------------------------------------------------------------------
// How near a jointed model was found to come to its target.

/// Joint-closed states near the target. Without a target the errors are negative, and there are no
/// poses.
struct AssembledState {
  double error = -1;      ///< the least target error found, metres: an upper bound of the least
  Poses poses;            ///< where it was found, one a tile
  double restError = -1;  ///< where the scene's springs come to rest near the target, metres
  Poses restPoses;        ///< that state
};

/// Joint-closed states near the target. First every tile is put where it fits its target best, the
/// joints are closed from there, and the scene's springs pull until nothing moves, joints exact:
/// the state of rest, which has the least sum of squares nearby. Then bricks that are farther off
/// are pulled more and more, those nearer less (Lawson's weights, as in measures.cpp): that
/// leads towards the least largest error. Where this leaves something, the springs pull from the
/// start, too. The best of all states is kept, the start among them. Both errors are zero where the
/// target's own data close. In a model whose coordinates were rounded, joints are closed within the
/// rounding only, see assembled_state.h. Contacts, ground and gravity are left out. Ends early when
/// `shouldContinue`, which may be empty, returns false.
AssembledState assembleAtTarget(const scene::Scene& scene,
                                const std::function<bool()>& shouldContinue = {});

// ------------------------------------------------------------------------------------------------
// Which bricks are in each other's way at the target.

/// Two bricks that would overlap at the target: contact stops the deployment before it gets there.
struct BlockingPair {
  int tileA = 0;       ///< from 0
  int tileB = 0;       ///< above tileA
  double overlap = 0;  ///< the shortest move that would separate them there, metres
  /// The face on which joints between the two would have to lie for them not to overlap there.
  std::optional<model::JointFace> freeingFace;
  /// The largest thickness (metres, to a few percent) at which they do not overlap there; 0 when
  /// the tiles themselves do.
  double freeingThickness = 0;
};

/// What blocks a scene, the deepest overlap first. Empty without contacts or a target. `atTarget`:
/// the state of rest, see assembleAtTarget(); overlaps that the contacts do not look at (of pairs
/// that are left out, of the corners at shared pivots) and overlaps below 1e-4 of a tile do not
/// count.
std::vector<BlockingPair> blockingPairs(const scene::Scene& scene, const Poses& atTarget);

/// "tiles 3 and 4 by 0.012 mm (free with joints on the top)". `countsFrom`: the first tile's
/// number.
std::string describe(const BlockingPair& pair, int countsFrom, const LengthUnit& unit = {});

}  // namespace kirireel::deploy
