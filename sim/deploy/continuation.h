/// Paths of the mechanism through states that are closed.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/deploy/assembled_state.h"
#include "sim/deploy/dynamics.h"
#include "sim/deploy/search_budget.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/brick.h"
#include "sim/model/isometry.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::deploy {

// ------------------------------------------------------------------------------------------------
// The deployment as geometry: a path of the mechanism from its start to its target.

/// A path of the mechanism: states with their joints closed, each a small move from the one before.
struct MechanismPath {
  std::vector<Poses> states;      ///< the start first, one pose a tile
  std::vector<double> lengths;    ///< of the path up to each state, metres; see pathDistance()
  double guideLength = 0;         ///< of the tiles' own motions from the start to the goal, metres
  double error = 0;               ///< target error at the end, metres; 0 without a target
  bool isStuck = false;           ///< it ended early, where the bricks followed the guide no more
  bool isCutShort = false;        ///< the budget or the caller ended it
  bool endsAtOpenJoints = false;  ///< beyond its end joints open by more than the rounding explains
  bool isRounded = false;         ///< joints close within the rounding of the coordinates only
  std::vector<model::Symmetry> symmetries;  ///< of the model, that all states have; a group

  /// Of the whole path, metres.
  double length() const { return lengths.back(); }
};

/// The root mean square distance of a brick's bottom vertices from its centre of mass, metres.
double gyrationRadius(const model::Brick& brick);

/// How far two states of the same bricks are apart, metres: the root of the mean over bricks of
///   |dx|^2 + w rho^2 |dphi|^2,
/// dx the move of the centre of mass, dphi the turn in radians, rho its gyrationRadius(), and w
/// `turnWeight`: 1 in the length of a path.
double pathDistance(const std::vector<model::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight = 1);

/// Closes joints as Dynamics::assemble() does, and leaves the bricks' common centre in its place:
/// near singular states closing would carry the whole along, by rounding times its stiffness.
bool closeInPlace(Poses& poses, Dynamics& dynamics);

/// Measures how deep those bricks overlap that these contacts would hold apart, or all where there
/// are none, beyond `start`. Bricks must outlive the meter.
trajectory::PenetrationMeter overlapMeter(const scene::Environment& environment,
                                          const std::vector<model::Brick>& bricks,
                                          std::span<const model::Pivot> pivots, const Poses& start);

/// A guide is divided into so many states at least.
inline constexpr double kLeastStates = 60;

/// How a path is followed.
struct ContinuationSettings {
  /// Of turns against places, times rho^2, in what "nearest" means: a tile turns as its guide does,
  /// and where it stands follows.
  double turnWeight = 100;
  /// A singular start is left by a leap, contacts left out: the first state is sought at this
  /// progress of the guide. 0: the first moves are tiny instead, and grow.
  double leap = 1.0 / 60;
  /// Of each joint, over the weight of a tile's place in what "nearest" means. Designs without
  /// freedom leave their start only by opening their joints: the stiffer, the less. Infinity:
  /// exact.
  double jointStiffness = std::numeric_limits<double>::infinity();

  /// Whether joints may open on the way.
  bool areJointsCompliant() const { return std::isfinite(jointStiffness); }
};

/// Called before each move with the progress along the guide, 0 to 1; return false to end the path.
using PathObserver = std::function<bool(double progress)>;

/// Follows the mechanism from the first state of `guide`, once its joints are closed, along the
/// others to the last, whose joints are closed; among the contacts that the scene asks for. Loads
/// and damping are left out. A path with exact joints ends where it is nearest to the scene's
/// target. In a model whose coordinates were rounded, exact joints are taken where the tiles fit
/// each other all along the path; see assembled_state.h. `shouldContinue` may be empty.
/// Costs 60 to 200 states of a few factorisations each, more where bricks meet. All results depend
/// on their arguments alone. `budget` is charged for the work.
MechanismPath continueAlong(const scene::Scene& scene, std::vector<Poses> guide,
                            const ContinuationSettings& settings, SearchBudget& budget,
                            const PathObserver& shouldContinue = {});

/// A path from the first state of a guide, whose joints are closed, as near as the mechanism comes
/// to the last; joints exact, among the contacts that the scene asks for. The scene's target is
/// left out.
MechanismPath connect(const scene::Scene& scene, std::vector<Poses> guide, SearchBudget& budget,
                      const PathObserver& shouldContinue = {});

/// A path from a start to a goal, both with closed joints, found from the goal on: bricks that lie
/// flush at the start wedge when they leave it by a finite move, and come near it all the same.
/// Joints are exact from the goal back to where the mechanism comes nearest to the start, and
/// compliant for what is left; `isStuck` where even so the start is not reached. Among the contacts
/// that the scene asks for.
MechanismPath continueFromGoal(const scene::Scene& scene, const Poses& start, const Poses& goal,
                               SearchBudget& budget, const PathObserver& shouldContinue = {});

/// Follows the mechanism from the scene's start away from the tiles' common centre, up to the
/// state in which the sum of squared distances from it is greatest: full extension.
MechanismPath continueToExtension(const scene::Scene& scene, SearchBudget& budget,
                                  const PathObserver& shouldContinue = {});

// ------------------------------------------------------------------------------------------------
// What a path of the mechanism follows.

/// What a path follows: straight from each of its states to the next, at an even pace.
/// Distances between its states are pathDistance(), so that its pace is even in moves and turns
/// together.
class PathGuide {
 public:
  /// Two states at least, one pose a brick in each.
  PathGuide(const std::vector<model::Brick>& bricks, std::vector<Poses> states)
      : states_(std::move(states)) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
      lengths_.push_back(lengths_.back() + pathDistance(bricks, states_[k - 1], states_[k]));
    }
  }

  /// Of the whole guide, metres.
  double length() const { return lengths_.back(); }
  /// Its last state.
  const Poses& end() const { return states_.back(); }

  /// The place at a progress from 0 to 1.
  Poses at(double progress) const {
    const double length = progress * lengths_.back();
    const auto next = std::upper_bound(lengths_.begin() + 1, lengths_.end() - 1, length);
    const auto k = static_cast<std::size_t>(next - lengths_.begin());
    const double part = lengths_[k] - lengths_[k - 1];
    const double share = part > 0 ? (length - lengths_[k - 1]) / part : 1;
    return interpolate(states_[k - 1], states_[k], share);
  }

 private:
  std::vector<Poses> states_;
  std::vector<double> lengths_ = {0};  // up to each state, metres
};

// ------------------------------------------------------------------------------------------------
// States of a recorded run between its samples.

/// How many states momentsBetween() gives.
inline constexpr int kMomentsBetween = 10;
/// Radians. Joints of momentsBetween() open by less than 1e-7 of a tile then.
inline constexpr double kMostTurnBetween = 0.05;

/// Moves a state at a share of the way between two others as closing the joints moves the states at
/// a third and at two thirds of it: by the cubic through these moves that is 0 at both ends.
void moveByThirds(Poses& poses, double share, const std::array<Poses, 2>& open,
                  const std::array<Poses, 2>& closed);

/// States at kMomentsBetween equal shares of the way between two states, by the cubic through them
/// and the states at a third and at two thirds of the way.
std::vector<Poses> momentsThrough(const Poses& from, const std::array<Poses, 2>& thirds,
                                  const Poses& to);

/// Finds states between two samples of one run. The mechanism has no straight ways: half way
/// between two closed states, places taken straight and rotations by the shortest turn, its joints
/// gape by the square of the turn. So they are closed again, moving the bricks as little as their
/// masses allow, wherever they are closed in both samples.
class StateInterpolator {
 public:
  /// Both must outlive the interpolator.
  StateInterpolator(const model::Model& model, const std::vector<model::Brick>& bricks);
  /// The subject must outlive the interpolator.
  explicit StateInterpolator(const trajectory::Subject& subject)
      : StateInterpolator(subject.model, subject.bricks) {}

  /// The state at a share of the way from one sample to a later one, 0 to 1, with its time, joint
  /// gap and target error; penetration, pins and steps are the earlier sample's. Where the joints
  /// are closed in both samples (to 1e-9 of a tile), they are closed to that in it as well; where
  /// no such state lies between the two, it is the nearer sample's.
  trajectory::Sample between(const trajectory::Sample& from, const trajectory::Sample& to,
                             double share);

  /// States at kMomentsBetween equal shares of the way between two states, at the cost of closing
  /// the joints twice: by the cubic through the two states and the closed states at a third and two
  /// thirds of the way. Empty if a brick turns by more than kMostTurnBetween from one state to the
  /// other: its path is not known.
  std::vector<Poses> momentsBetween(const Poses& from, const Poses& to);

 private:
  bool areClosed(const Poses& poses) const;
  Poses closedBetween(const Poses& from, const Poses& to, double share);
  mechanics::JointSolver& solverFor(const Poses& from, const Poses& to);
  void setPinned(const std::vector<int>& tiles);

  const model::Model& model_;
  const std::vector<model::Brick>& bricks_;
  std::vector<bool> pinned_;
  std::vector<model::Pivot> pivots_;
  double tileSize_;                                  ///< metres
  std::unique_ptr<mechanics::JointSolver> inPlane_;  ///< made when first needed, as is the next
  std::unique_ptr<mechanics::JointSolver> inSpace_;
};

}  // namespace kirireel::deploy
