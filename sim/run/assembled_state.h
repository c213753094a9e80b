/// The nearest reachable state to the target, with closed joints, computed before the deployment.
/// Also the pairs of bricks that block the target.
#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::run {

// ------------------------------------------------------------------------------------------------
// The meaning of "closed" for the joints of a model with rounded coordinates.
//
// Tiles of an over-constrained mechanism fit each other in all states only with exact coordinates.
// If these are rounded by d, in tiles, the tiles misfit by about d, and only the start closes
// exactly. Singular values of the joints' Jacobian that should be zero are about d. Closing a gap c
// exactly moves tiles by c / d, back to the start. Joints therefore close only as far as the tiles
// fit, by Tikhonov's rule. Instead of c(q) = 0, states minimise
//   |q - g|^2 + r |c(q)|^2,   r = 10 / d,
// g the position that attracts the tiles, less than a tile away. The pull opens joints by
// |q - g| / r beyond the misfit: less than a tenth of the digit. The misfit, r |c|^2 about r d^2,
// moves tiles along the mechanism by r d^2, ten digits, and in singular states by the root of that:
// gaps grow with the square of the move. Joints resist motions with singular values above
// sqrt(d / 10), others follow the pull. Near g, softer joints bring a state nearer while they stay
// closed within two digits. Neumaier (1998), "Solving ill-conditioned and singular linear systems",
// SIAM Review 40, section 3.

/// The stiffness r of joints that close within the model's rounding, relative to the springs that
/// pull a tile to its place. Infinite if the coordinates were not rounded.
double roundedJointStiffness(const model::Model& model);

/// Largest additional distance of a state from its place because of the rounding, and largest joint
/// gap along the path, metres: ten digits.
double roundedReach(const model::Model& model);

/// Largest joint gap at the end, metres. It is two digits, the largest distance between two
/// roundings of one corner.
double roundedGap(const model::Model& model);

/// Calls `closes` with softer and softer joints. Stops when it returns false: the joints are then
/// no longer closed within roundedGap().
void softenWhileClosed(const model::Model& model,
                       const std::function<bool(double stiffness)>& closes);

// ------------------------------------------------------------------------------------------------
// The state nearest to the target, as found by a search.

/// Joint-closed states near the target. Without a target the errors are negative and the poses are
/// empty.
struct AssembledState {
  double error = -1;      ///< the smallest target error found, metres: an upper bound
  Poses poses;            ///< the state with this error, one pose per tile
  double restError = -1;  ///< target error at the scene's spring equilibrium, metres
  Poses restPoses;        ///< the spring equilibrium near the target, one pose per tile
};

/// Finds joint-closed states near the target. First fits every tile to its target and closes the
/// joints. The scene's springs then pull the exact joints to equilibrium, a local minimum of the
/// sum of squares. Then Lawson's weights (see measures.cpp) increase for distant bricks and
/// decrease for near ones, which approaches the smallest maximum error. If an error remains, the
/// springs also pull from the start. The result is the best state found, including the start. Both
/// errors are zero if the target's own joints are closed. If the coordinates were rounded, joints
/// close only within the rounding, see above. Contacts, ground and gravity are ignored. Ends early
/// if `shouldContinue` returns false; it may be empty.
AssembledState assembleAtTarget(const scene::Scene& scene,
                                const std::function<bool()>& shouldContinue = {});

// ------------------------------------------------------------------------------------------------
// Pairs of bricks that overlap at the target.

/// Two bricks that overlap at the target: contact stops the deployment before it arrives.
struct BlockingPair {
  int tileA = 0;       ///< index >= 0
  int tileB = 0;       ///< index > tileA
  double overlap = 0;  ///< length of the shortest move that separates them, metres
  /// The face on which the joints between the two must lie to avoid the overlap.
  std::optional<model::JointFace> freeingFace;
  /// The largest thickness without overlap at the target (metres, to a few percent). 0 if the tiles
  /// themselves overlap.
  double freeingThickness = 0;
};

/// The pairs that block a scene, the deepest overlap first. Empty without contacts or a target.
/// `atTarget` is the equilibrium state, see assembleAtTarget(). Overlaps below 1e-4 of a tile and
/// overlaps that the contacts ignore (excluded pairs, the corners at shared pivots) do not count.
std::vector<BlockingPair> blockingPairs(const scene::Scene& scene, const Poses& atTarget);

/// For example "tiles 3 and 4 by 0.012 mm (free with joints on the top)". `countsFrom`: the first
/// tile's number.
std::string describe(const BlockingPair& pair, int countsFrom, const LengthUnit& unit = {});

}  // namespace kirireel::run
