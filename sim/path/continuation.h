/// Kinematic paths: sequences of states with closed joints.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/run/mechanism_path.h"
#include "sim/run/search_budget.h"
#include "sim/scene/scene.h"

namespace kirireel::path {

/// Minimum number of states along a guide.
inline constexpr double kMinStates = 60;

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
run::MechanismPath continueAlong(const scene::Scene& scene, std::vector<Poses> guide,
                                 const ContinuationSettings& settings, run::SearchBudget& budget,
                                 const PathObserver& shouldContinue = {});

/// A path from the first state of a guide, whose joints are closed, to the state that is nearest
/// to the last one. Joints are exact, and the scene's contacts apply. The scene's target is
/// ignored.
run::MechanismPath connect(const scene::Scene& scene, std::vector<Poses> guide,
                           run::SearchBudget& budget, const PathObserver& shouldContinue = {});

/// A path along a guide from a start to a goal, both with closed joints. It is computed backwards
/// from the goal: flush bricks jam when a finite move separates them, but a path can end near that
/// state. Joints are exact from the goal to the state nearest to the start, and compliant for
/// the rest. `isStuck` if the path still does not reach the start. The scene's contacts
/// apply.
run::MechanismPath continueFromGoal(const scene::Scene& scene, std::vector<Poses> guide,
                                    run::SearchBudget& budget,
                                    const PathObserver& shouldContinue = {});

/// Follows the mechanism from the scene's start away from the tiles' common centre. It ends at full
/// extension, the maximum of the sum of squared distances from the centre. Joints of finite
/// `jointStiffness`, as in ContinuationSettings, open on the way and close at its end.
run::MechanismPath continueToExtension(const scene::Scene& scene, double jointStiffness,
                                       run::SearchBudget& budget,
                                       const PathObserver& shouldContinue = {});

// ------------------------------------------------------------------------------------------------
// The guide of a kinematic path.

/// A guide: linear interpolation between given states, at constant speed. Distances between
/// states are pathDistance(). The speed is therefore constant in translations and rotations
/// together.
class PathGuide {
 public:
  /// Needs at least two states with one pose per brick.
  PathGuide(const std::vector<brick::Brick>& bricks, std::vector<Poses> states)
      : states_(std::move(states)) {
    for (std::size_t k = 1; k < states_.size(); ++k) {
      lengths_.push_back(lengths_.back() + run::pathDistance(bricks, states_[k - 1], states_[k]));
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

}  // namespace kirireel::path
