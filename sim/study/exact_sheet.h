/// Motions that are known exactly: in closed form, and by the closure of a mechanism.
#pragma once

#include <vector>

#include "sim/model/model.h"
#include "sim/scene/scene.h"

namespace kirireel::study {

// ------------------------------------------------------------------------------------------------
// The sheet whose motion is known in closed form: squares that open from 0 to 90 degrees.

/// A square sheet of side x side tiles, without contacts, opened by so many radians at the start.
/// Joints on both faces are hinges, two point joints each to engines; on the bottom only they are
/// one.
/// Tiles are 1 m wide; the target is the sheet opened to 90 degrees.
scene::Scene sheetScene(int side, bool planar, model::JointFace face = model::JointFace::Both,
                        double startAngle = 0);

/// The angle between the first two tiles of a sheet, radians from 0.
double openingAngle(const Poses& poses);

/// How far vertices are from where they should be, metres.
struct VertexError {
  double max = 0;   ///< metres
  double mean = 0;  ///< metres
};

/// How far corresponding vertices are apart.
VertexError vertexError(const std::vector<model::Tile>& found,
                        const std::vector<model::Tile>& desired);

/// The states that a sheet passes through, at equal times.
using SheetWay = std::vector<std::vector<model::Tile>>;

/// The limit of ever shorter steps of first order: their error is a power series in the step, so
/// that ways in steps of h, h / 2 and h / 4 give it but for the third order.
/// All three have the same states at the same times.
SheetWay limitOfSteps(const SheetWay& coarse, const SheetWay& middle, const SheetWay& fine);

/// The farthest that a vertex is on one way from where it is on another at that time, metres.
double wayError(const SheetWay& found, const SheetWay& desired);

/// How far a sheet is from the exact one at the same opening angle, wherever that one is placed.
VertexError sheetError(int side, double angle, const std::vector<model::Tile>& found);

// ------------------------------------------------------------------------------------------------
// The exact path of a planar mechanism with one way to move, by continuation of its closure
// equations. Knows no forces, no steps and nothing of the joint solver.

/// The places of the bottoms of planar tiles: x, y and turn of each, about the mean of its
/// vertices.
using PlanarState = Eigen::VectorXd;

/// A sheet whose joints all lie in one horizontal plane.
class ClosurePath {
 public:
  /// `tiles`: the shape of each tile; `joints`: pivots. Tile 0 is held, and the turn of tile 1
  /// against it is the progress on the path.
  ClosurePath(const std::vector<model::Tile>& tiles, const std::vector<model::Joint>& joints);

  /// The state of the given tiles, which are congruent to those of the constructor.
  PlanarState stateOf(const std::vector<model::Tile>& placed) const;

  /// The turn of tile 1 against tile 0 in a state, radians, to whole turns.
  double angle(const PlanarState& state) const { return state[5] - state[2]; }

  /// Closes all joints at the given angle by Gauss-Newton steps from a state nearby. Throws
  /// RunError when a gap above 1e-12 is left.
  /// `angle` in radians. Each round factors a dense matrix of (2 joints + 4) x (3 tiles).
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

/// The angle by which planar points are turned about their mean from one set to another, radians
/// from -pi to pi.
double planarTurn(const model::Tile& from, const model::Tile& to);

}  // namespace kirireel::study
