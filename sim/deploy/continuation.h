/// Kinematic paths: sequences of states with closed joints.
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
// Kinematic deployment: a path of the mechanism from its start to its target.

/// A kinematic path: states with closed joints, each a small move away from the one before.
struct MechanismPath {
  std::vector<Poses> states;      ///< the first is the start; one pose per tile
  std::vector<double> lengths;    ///< path length up to each state, metres; see pathDistance()
  double guideLength = 0;         ///< length of the guide from start to goal, metres
  double error = 0;               ///< target error at the end, metres; 0 without a target
  bool isStuck = false;           ///< the path ended early: the bricks no longer follow the guide
  bool isCutShort = false;        ///< the budget was spent or the caller stopped
  bool endsAtOpenJoints = false;  ///< the next states open joints by more than rounding explains
  bool isRounded = false;         ///< joints close only within the rounding of the coordinates
  std::vector<model::Symmetry> symmetries;  ///< model symmetries that all states have; a group

  /// Length of the whole path, metres.
  double length() const { return lengths.back(); }
};

/// The root mean square distance of a brick's bottom vertices from its centre of mass, metres.
double gyrationRadius(const model::Brick& brick);

/// Distance between two states of the same bricks, metres: the root of the mean over bricks of
///   |dx|^2 + w rho^2 |dphi|^2,
/// with dx the displacement of the centre of mass, dphi the rotation in radians, rho the brick's
/// gyrationRadius() and w `turnWeight`. Path lengths use w = 1.
double pathDistance(const std::vector<model::Brick>& bricks, const Poses& from, const Poses& to,
                    double turnWeight = 1);

/// Closes joints as Dynamics::assemble() does, but keeps the bricks' common centre fixed. Near
/// singular states, rounding errors times the stiffness would otherwise shift the whole sheet.
bool closeInPlace(Poses& poses, Dynamics& dynamics);

/// Measures how much deeper bricks overlap than at `start`. It counts the pairs that these contacts
/// keep apart, or all pairs if contacts are off. The meter keeps a reference to `bricks`.
trajectory::PenetrationMeter overlapMeter(const scene::Environment& environment,
                                          const std::vector<model::Brick>& bricks,
                                          std::span<const model::Pivot> pivots, const Poses& start);

/// Minimum number of states along a guide.
inline constexpr double kLeastStates = 60;

/// Settings of path following.
struct ContinuationSettings {
  /// Weight of rotations against positions (times rho^2) in the distance to the guide. With a large
  /// weight the rotations follow the guide, and the positions adapt.
  double turnWeight = 100;
  /// First progress along the guide, (0, 1]. The path jumps off a singular start to this progress,
  /// without contacts. 0: there is no jump; the first moves are tiny and then grow.
  double jump = 1.0 / 60;
  /// Stiffness of each joint, relative to the weight of a tile's position in the distance to the
  /// guide. Designs without freedom can leave their start only if joints open. Stiffer joints open
  /// less. Infinity: exact joints.
  double jointStiffness = std::numeric_limits<double>::infinity();

  /// Whether joints may open along the path.
  bool areJointsCompliant() const { return std::isfinite(jointStiffness); }
};

/// Called before each move with the progress along the guide, [0, 1]. Return false to end the path.
using PathObserver = std::function<bool(double progress)>;

/// Closes the joints of the first state of `guide`. Then follows the other states to the last,
/// whose joints are closed. Uses the scene's contacts and ignores loads and damping. A path with
/// exact joints ends at its state that is nearest to the scene's target. If the model's coordinates
/// were rounded, joints are exact only if the tiles fit each other along the whole path; see
/// assembled_state.h. `shouldContinue` may be empty. Computes 60 to 200 states at a cost of a few
/// factorisations each, more if bricks touch. Results depend only on the arguments. `budget` is
/// charged for the work.
MechanismPath continueAlong(const scene::Scene& scene, std::vector<Poses> guide,
                            const ContinuationSettings& settings, SearchBudget& budget,
                            const PathObserver& shouldContinue = {});

/// A path from the first state of a guide, whose joints are closed, to the state that is nearest
/// to the last one. Joints are exact, and the scene's contacts apply. The scene's target is
/// ignored.
MechanismPath connect(const scene::Scene& scene, std::vector<Poses> guide, SearchBudget& budget,
                      const PathObserver& shouldContinue = {});

/// A path from a start to a goal, both with closed joints. It is computed backwards from the
/// goal: flush bricks jam when a finite move separates them, but a path can end near that
/// state. Joints are exact from the goal to the state nearest to the start, and compliant for
/// the rest. `isStuck` if the path still does not reach the start. The scene's contacts
/// apply.
MechanismPath continueFromGoal(const scene::Scene& scene, const Poses& start, const Poses& goal,
                               SearchBudget& budget, const PathObserver& shouldContinue = {});

/// Follows the mechanism from the scene's start away from the tiles' common centre. It ends at full
/// extension, the maximum of the sum of squared distances from the centre.
MechanismPath continueToExtension(const scene::Scene& scene, SearchBudget& budget,
                                  const PathObserver& shouldContinue = {});

// ------------------------------------------------------------------------------------------------
// The guide of a kinematic path.

/// A guide: linear interpolation between given states, at constant speed. Distances between
/// states are pathDistance(). The speed is therefore constant in translations and rotations
/// together.
class PathGuide {
 public:
  /// Needs at least two states with one pose per brick.
  PathGuide(const std::vector<model::Brick>& bricks, std::vector<Poses> states)
      : states_(std::move(states)) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
      lengths_.push_back(lengths_.back() + pathDistance(bricks, states_[k - 1], states_[k]));
    }
  }

  /// Length of the whole guide, metres.
  double length() const { return lengths_.back(); }
  /// Its last state.
  const Poses& end() const { return states_.back(); }

  /// The state at a progress in [0, 1].
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

/// Number of states that momentsBetween() returns.
inline constexpr int kMomentsBetween = 10;
/// Radians. Up to here, states of momentsBetween() open joints by less than 1e-7 of a tile.
inline constexpr double kMostTurnBetween = 0.05;

/// Adds a joint-closing correction to an interpolated state. The correction is a cubic in `share`:
/// zero at both ends and equal to the known corrections (`open` to `closed`) at 1/3 and 2/3.
void moveByThirds(Poses& poses, double share, const std::array<Poses, 2>& open,
                  const std::array<Poses, 2>& closed);

/// kMomentsBetween equidistant states between two states, by the cubic through both of them and the
/// states at one third and two thirds.
std::vector<Poses> momentsThrough(const Poses& from, const std::array<Poses, 2>& thirds,
                                  const Poses& to);

/// Finds states between two samples of one run. Linear interpolation opens joints by the square of
/// the rotation between the samples. If the joints are closed in both samples, the interpolator
/// therefore closes them again. This moves the bricks as little as possible, weighted by their
/// masses.
class StateInterpolator {
 public:
  /// Both must outlive the interpolator.
  StateInterpolator(const model::Model& model, const std::vector<model::Brick>& bricks);
  /// The subject must outlive the interpolator.
  explicit StateInterpolator(const trajectory::Subject& subject)
      : StateInterpolator(subject.model, subject.bricks) {}

  /// The state at a share in [0, 1] between one sample and a later one. Time, joint gap and target
  /// error belong to this state. Penetration, pins and steps are those of the earlier sample. If
  /// joints are closed in both samples (to 1e-9 of a tile), they are closed to the same tolerance
  /// here. If no such state exists, this returns the nearer sample's state.
  trajectory::Sample between(const trajectory::Sample& from, const trajectory::Sample& to,
                             double share);

  /// kMomentsBetween equidistant states between two states. Closes the joints only twice, at one
  /// third and two thirds, and uses the cubic through these and the two given states. Returns an
  /// empty list if a brick rotates by more than kMostTurnBetween between the two states: its path
  /// is then unknown.
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
  std::unique_ptr<mechanics::JointSolver> inPlane_;  ///< created at first use, like inSpace_
  std::unique_ptr<mechanics::JointSolver> inSpace_;
};

}  // namespace kirireel::deploy
