/// Equilibria of a sheet under grips, instead of a deployment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/brick/hinge.h"
#include "sim/mechanics/load_path.h"
#include "sim/run/result.h"
#include "sim/scene/scene.h"
#include "sim/statics/bar_hinge_sheet.h"

namespace kirireel::statics {

/// Follows the equilibria of a scene with grips (see followLoad()) from load 0 to 1. Samples them
/// along the path at constant speed (PathSettings::playTime). Limit points and bifurcations become
/// events and states of the result's load curve. The outcome is Settled if load 1 is reached, else
/// Locked. Throws InputError if the scene has features that equilibria do not support (contacts,
/// gravity, a timeline, links, space) or if no grip moves or pushes. Throws RunError if nothing
/// resists or no equilibrium is found at the start.
run::DeploymentResult followGrips(const scene::Scene& scene, double sampleInterval,
                                  const run::SampleObserver& observer);

// ------------------------------------------------------------------------------------------------
// A scene whose tiles stretch and bend, as a sheet of bars and hinges under grips.

/// One direction of a grip of the scene.
struct GripOrder {
  const scene::GripSetting* setting = nullptr;  ///< the grip
  Vector3 direction = Vector3::UnitX();         ///< unit vector; zero for a rotation
  double amount = 0;                            ///< at load 1, see Grip
  mechanics::GripName name;                     ///< name in tables
  std::string axis;                             ///< "x", "y", "z" or "turn"
};

/// The sheet of a scene with panels. Joined corners become one node, regardless of their face.
/// Tiles with more than three corners bend about the diagonals of tileTriangles(). Folds have the
/// stiffness and rest angle of their springs (hingeSprings()). Throws InputError for joints on both
/// faces, fixed tiles, springs at hinges that are no common edge of two tiles, and grips that
/// rotate.
std::unique_ptr<BarHingeSheet> makeBarHingeSheet(const scene::Scene& scene,
                                                 const std::vector<brick::Brick>& bricks,
                                                 const brick::PairForces& pairForces,
                                                 const std::vector<int>& pinned,
                                                 const std::vector<GripOrder>& grips);

}  // namespace kirireel::statics
