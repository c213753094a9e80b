/// Exactly known motions: in closed form, and by the closure of a mechanism.
#pragma once

#include <vector>

#include "sim/model/model.h"
#include "sim/scene/scene.h"
#include "sim/trajectory/exact_motion.h"

namespace kirireel::study {

// ------------------------------------------------------------------------------------------------
// A sheet whose motion is known in closed form: squares that open from 0 to 90 degrees.

/// A square sheet of side x side tiles, without contacts. `startAngle`: opening at the start,
/// radians. Joints on both faces are hinges, i.e. two point joints each for engines. On the
/// bottom only they are one. Tiles are 1 m wide; the target is the sheet opened to 90
/// degrees.
scene::Scene sheetScene(int side, bool planar, model::JointFace face = model::JointFace::Both,
                        double startAngle = 0);

/// The angle between the first two tiles of a sheet, radians, >= 0.
double openingAngle(const Poses& poses);

/// The states of a sheet over time, at equal intervals.
using SheetPath = std::vector<std::vector<model::Tile>>;

/// The limit of first-order steps for a step length of 0. Their error is a power series in the
/// step. Results for steps of h, h / 2 and h / 4 give the limit up to the third order. All three
/// have states at the same times.
SheetPath limitOfSteps(const SheetPath& coarse, const SheetPath& middle, const SheetPath& fine);

/// The largest distance of a vertex between two motions at the same time, metres.
double pathError(const SheetPath& found, const SheetPath& desired);

/// The distance from the exact sheet at the same opening angle, after the best rigid motion.
trajectory::VertexDistance sheetError(int side, double angle,
                                      const std::vector<model::Tile>& found);

// ------------------------------------------------------------------------------------------------
// The exact path of a planar mechanism with one degree of freedom, by continuation of its closure
// equations. It uses no forces, no steps and no part of the joint solver.

/// Poses of the bottoms of planar tiles: x, y and rotation of each, about the mean of its
/// vertices.
using PlanarState = Eigen::VectorXd;

/// A sheet whose joints all lie in one horizontal plane.
class ClosurePath {
 public:
  /// `tiles`: the shape of each tile; `joints`: pivots. Tile 0 is fixed. The rotation of tile 1
  /// relative to it is the progress on the path.
  ClosurePath(const std::vector<model::Tile>& tiles, const std::vector<model::Joint>& joints);

  /// The state of the given tiles, which are congruent to those of the constructor.
  PlanarState stateOf(const std::vector<model::Tile>& placed) const;

  /// The rotation of tile 1 relative to tile 0 in a state, radians, up to full turns.
  double angle(const PlanarState& state) const { return state[5] - state[2]; }

  /// Closes all joints at the given angle by Gauss-Newton steps from a nearby state. Throws
  /// RunError if a gap above 1e-12 m remains. `angle` in radians. Each round factors a dense matrix
  /// of (2 joints + 4) x (3 tiles).
  PlanarState close(PlanarState state, double angle) const;

  /// Follows the path from a state on it to an angle, in steps of at most `step` radians.
  /// Throws RunError as close() does. `step` is positive.
  PlanarState follow(PlanarState state, double angle, double step) const;

  /// The largest joint gap, metres.
  double gap(const PlanarState& state) const;

  /// The tiles in a state, at height 0.
  std::vector<model::Tile> tiles(const PlanarState& state) const;

 private:
  struct ClosureEquations {
    Eigen::MatrixXd slopes;
    Eigen::VectorXd missed;
  };
  ClosureEquations equations(const PlanarState& state, const Vector3& held, double desired) const;
  Vector3 vertex(const PlanarState& state, const model::Corner& corner) const;

  std::vector<model::Tile> shapes_;  // about the mean of their vertices
  std::vector<model::Joint> joints_;
};

/// The rotation of planar points about their mean from one set to another, radians, [-pi,
/// pi].
double planarTurn(const model::Tile& from, const model::Tile& to);

}  // namespace kirireel::study
