/// A sheet that grips hold, move and push: its equilibria in place of a deployment.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/deploy/result.h"
#include "sim/mechanics/load_path.h"
#include "sim/model/hinge.h"
#include "sim/scene/scene.h"

namespace kirireel::deploy {

/// Follows the equilibria of a scene with grips (see followLoad()) from the load 0 to 1 and samples
/// them as a walk at an even pace (PathSettings::walkTime). Limit points and bifurcations are
/// events and states of the result's load curve. Settled where the load 1 is reached, else Locked.
/// Throws InputError where the scene has what equilibria of a planar sheet do not know (contacts,
/// gravity, a timeline, links, space) or no grip moves or pushes, RunError where nothing resists or
/// no equilibrium is found at the start.
DeploymentResult followGrips(const scene::Scene& scene, double sampleInterval,
                             const SampleObserver& observer);

// ------------------------------------------------------------------------------------------------
// A scene whose tiles stretch and bend, as a sheet of bars and hinges that grips load.

/// One direction of a grip of the scene.
struct GripOrder {
  const scene::GripSetting* setting = nullptr;  ///< that it is of
  Vector3 direction = Vector3::UnitX();         ///< unit; zero for a turn
  double amount = 0;                            ///< at the load 1, see Grip
  mechanics::GripName name;                     ///< what tables call it
  std::string axis;                             ///< "x", "y", "z" or "turn"
};

/// The sheet of a scene with panels. Corners that joints hold together are one node, whichever face
/// they lie on; tiles with more than three corners bend about the diagonals of tileTriangles().
/// Folds have the stiffness and rest angle of their springs (hingeSprings()). Throws InputError for
/// joints on both faces, fixed tiles, springs at hinges that are no common edge of two tiles, and
/// grips that turn.
std::unique_ptr<mechanics::LoadedSheet> makeBarHingeSheet(const scene::Scene& scene,
                                                          const std::vector<model::Brick>& bricks,
                                                          const model::PairForces& pairForces,
                                                          const std::vector<int>& pinned,
                                                          const std::vector<GripOrder>& grips);

}  // namespace kirireel::deploy
