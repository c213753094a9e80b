/// States that keep the symmetries of their model.
#pragma once

#include <vector>

#include "sim/deploy/dynamics.h"
#include "sim/model/symmetry.h"
#include "sim/scene/scene.h"

namespace kirireel {

/// Keeps a path to the symmetries that its model and its ends have: rounding, and contacts that are
/// found in the order of the bricks, break them a little in each move, and singular states make
/// much of a little.
class SymmetricStates {
 public:
  /// With all symmetries of the scene's model.
  explicit SymmetricStates(const Scene& scene)
      : SymmetricStates(scene, symmetriesOf(scene.model)) {}
  /// With these, a group.
  SymmetricStates(const Scene& scene, std::vector<Symmetry> group);

  const std::vector<Symmetry>& group() const { return group_; }

  /// Leaves those symmetries alone that a state has, too.
  void keepThoseOf(const Poses& state);

  /// Replaces a state by the mean of its images under the symmetries. Exact joints that this opens,
  /// by about the square of the images' distance, are closed again by `dynamics`; a state in which
  /// they cannot be stays as it is.
  void restore(Poses& poses, Dynamics& dynamics) const;

  /// The same for a motion: velocities have the symmetries, too.
  void restore(Motion& motion, Dynamics& dynamics) const;

 private:
  std::vector<Symmetry> group_;
  std::vector<Pivot> pivots_;
  double tile_;  // metres
};

}  // namespace kirireel
