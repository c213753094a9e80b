/// States of a recorded run between its samples.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/brick/brick.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/model.h"
#include "sim/trajectory/measures.h"
#include "sim/trajectory/trajectory.h"

namespace kirireel::run {

/// Number of states that momentsBetween() returns.
inline constexpr int kMomentsBetween = 10;
/// Radians. Up to here, states of momentsBetween() open joints by less than 1e-7 of a tile.
inline constexpr double kMaxTurnBetween = 0.05;

/// A joint-closing correction of interpolated states. It is a cubic in the share: zero at both ends
/// and equal to the known corrections at 1/3 and 2/3.
class ThirdsCorrection {
 public:
  /// The interpolated states at 1/3 and 2/3, and the same with closed joints.
  ThirdsCorrection(const std::array<Poses, 2>& open, const std::array<Poses, 2>& closed);

  /// Corrects the interpolated state at a share in [0, 1].
  void addTo(Poses& poses, double share) const;

 private:
  std::array<std::vector<Vector3>, 2> moves_, turns_;  // metres and radians, one per brick
};

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
  StateInterpolator(const model::Model& model, const std::vector<brick::Brick>& bricks);
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
  /// empty list if a brick rotates by more than kMaxTurnBetween between the two states: its path is
  /// then unknown.
  std::vector<Poses> momentsBetween(const Poses& from, const Poses& to);

 private:
  bool areClosed(const Poses& poses) const;
  Poses closedBetween(const Poses& from, const Poses& to, double share);
  mechanics::JointSolver& solverFor(const Poses& from, const Poses& to);
  void setPinned(const std::vector<int>& tiles);

  const model::Model& model_;
  const std::vector<brick::Brick>& bricks_;
  std::vector<bool> pinned_;
  std::vector<brick::Pivot> pivots_;
  double tileSize_;                                  ///< metres
  std::unique_ptr<mechanics::JointSolver> inPlane_;  ///< created at first use, like inSpace_
  std::unique_ptr<mechanics::JointSolver> inSpace_;
};

}  // namespace kirireel::run
