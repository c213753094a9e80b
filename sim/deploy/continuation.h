/// The deployment as geometry: a path of the mechanism from its start to its target.
#pragma once

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/search_budget.h"
#include "sim/model/symmetry.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// A path of the mechanism: states with their joints closed, each a small move from the one before.
struct MechanismPath {
  std::vector<Poses> states;    ///< the start first, one pose a tile
  std::vector<double> lengths;  ///< of the path up to each state, metres; see pathDistance()
  double guideLength = 0;       ///< of the tiles' own motions from the start to the goal, metres
  double error = 0;             ///< target error at the end, metres; 0 without a target
  bool isStuck = false;         ///< it ended early, where the bricks followed the guide no more
  bool isCutShort = false;      ///< the budget or the caller ended it
  bool isRounded = false;       ///< joints close within the rounding of the coordinates only
  std::vector<Symmetry> symmetries;  ///< of the model, that all states have; a group

  double length() const { return lengths.back(); }
};

/// How far two states of the same bricks are apart, metres: the root of the mean over bricks of
///   |dx|^2 + rho^2 |dphi|^2,
/// dx the move of the centre of mass, dphi the turn in radians, and rho the root mean square
/// distance of the brick's bottom vertices from its centre of mass.
double pathDistance(const std::vector<Brick>& bricks, const Poses& from, const Poses& to);

/// Closes joints as Dynamics::assemble() does, and leaves the bricks' common centre in its place:
/// near singular states closing would carry the whole along, by rounding times its stiffness.
bool closeInPlace(Poses& poses, Dynamics& dynamics);

/// How a path is followed.
struct ContinuationSettings {
  /// Of turns against places, times rho^2, in what "nearest" means: a tile turns as its guide does,
  /// and where it stands follows.
  double turnWeight = 100;
  /// Tiles first move away from their common centre for a path of so many mean edges.
  double opening = 0;
  /// A singular start is left by a leap, contacts left out: the first state is sought at this
  /// progress of the guide. 0: the first moves are tiny instead, and grow.
  double leap = 1.0 / 60;
  /// Of each joint, over that of the springs that move a tile along its guide. Designs without
  /// freedom leave their start only by opening their joints: the stiffer, the less. Infinity:
  /// exact.
  double jointStiffness = std::numeric_limits<double>::infinity();

  bool areJointsCompliant() const { return std::isfinite(jointStiffness); }
};

/// Called before each move with the progress along the guide, 0 to 1; return false to end the path.
using PathObserver = std::function<bool(double progress)>;

/// Follows the mechanism from the first state of `guide`, once its joints are closed, along the
/// others to the last, whose joints are closed; among the contacts that the scene asks for. Loads
/// and damping are left out. A path with exact joints ends where it is nearest to the scene's
/// target. In a model whose coordinates were rounded, exact joints are taken where the tiles fit
/// each other all along the path; see rounded_joints.h. `goesOn` may be empty.
/// Costs 60 to 200 states of a few factorisations each, more where bricks meet. All results depend
/// on their arguments alone. `budget` is charged for the work.
MechanismPath continueAlong(const Scene& scene, std::vector<Poses> guide,
                            const ContinuationSettings& settings, SearchBudget& budget,
                            const PathObserver& goesOn = {});

/// A path of states that are there already, `states`, and on from the last of them to the state
/// nearest to a goal, joints exact, among the contacts that the scene asks for. Ends where it is
/// nearest to the scene's target.
MechanismPath continueTo(const Scene& scene, std::vector<Poses> states, const Poses& goal,
                         SearchBudget& budget, const PathObserver& goesOn = {});

/// A path from the first state of a guide, whose joints are closed, as near as the mechanism comes
/// to the last; joints exact, among the contacts that the scene asks for. The scene's target is
/// left out.
MechanismPath connect(const Scene& scene, std::vector<Poses> guide, SearchBudget& budget,
                      const PathObserver& goesOn = {});

/// Follows the mechanism from the scene's start away from the tiles' common centre, up to the
/// state in which the sum of squared distances from it is greatest: full extension.
MechanismPath continueToExtension(const Scene& scene, SearchBudget& budget,
                                  const PathObserver& goesOn = {});

}  // namespace kirireel
