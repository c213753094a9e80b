// Comparison with the exact motion of rotating squares.
//
// The sheet of squares has one motion that keeps all joints closed. It is known in closed form
// (lattice.h): the opening angle between two tiles determines the position of every vertex, up to a
// rigid motion. A state is therefore compared at its own angle, after the exact sheet has been
// moved onto it by the best fit. The remaining difference is an error of shape. It does not depend
// on the run's error in time.
//
// The reference for the error in time is the limit of ever shorter steps. For a method of first
// order, x(h) = x + c_1 h + c_2 h^2 + O(h^3), and the steps h, h/2, h/4 give
//   x = (8 x(h/4) - 6 x(h/2) + x(h)) / 3 + O(h^3).
// This is Richardson's extrapolation, applied twice (E. Hairer, S. P. Norsett, G. Wanner, Solving
// Ordinary Differential Equations I, II.9).
#include "sim/study/exact_sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/QR>
#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel::study {
// A sheet of `side` x `side` squares without contacts: only joints and springs act.
scene::Scene sheetScene(int side, bool planar, model::JointFace face, double startAngle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.face = face;
  shape.startAngle = startAngle;
  scene::Scene scene;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.solver.planar = planar;
  return scene;
}

// The rotation of tile 1 relative to tile 0, radians, [0, pi]. It is one angle in space too,
// because the closed motion rotates tiles only about the vertical.
double openingAngle(const Poses& poses) {
  const Quaternion relative = poses[0].rotation.conjugate() * poses[1].rotation;
  // The angle of a unit quaternion, [0, pi]. It is precise for small angles; an arc cosine is
  // not.
  return 2 * std::atan2(relative.vec().norm(), std::abs(relative.w()));
}

// All three motions must have states at the same times. Each vertex is extrapolated separately: its
// path depends smoothly on the step.
SheetPath limitOfSteps(const SheetPath& coarse, const SheetPath& middle, const SheetPath& fine) {
  SheetPath limit = fine;
  for (std::size_t k = 0; k < limit.size(); ++k) {
    for (std::size_t i = 0; i < limit[k].size(); ++i) {
      for (std::size_t v = 0; v < limit[k][i].vertices.size(); ++v) {
        Vector3& vertex = limit[k][i].vertices[v];
        vertex = (8 * vertex - 6 * middle[k][i].vertices[v] + coarse[k][i].vertices[v]) / 3;
      }
    }
  }
  return limit;
}

// The largest error of any vertex at any time, metres. `desired` must have at least as many states
// as `found`, which may have ended early.
double pathError(const SheetPath& found, const SheetPath& desired) {
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, trajectory::vertexDistance(found[k], desired[k]).largest);
  }
  return largest;
}

// The exact sheet is moved by a rigid motion, which removes the position and rotation of the
// sheet.
trajectory::VertexDistance sheetError(int side, double angle,
                                      const std::vector<model::Tile>& found) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  const std::vector<model::Tile> exact = generate::tessellationTiles(shape, angle);
  return trajectory::vertexDistance(found, model::bestFitted(exact, found));
}

// ------------------------------------------------------------------------------------------------
// The path of a planar mechanism by continuation of its closure equations, independent of all
// solvers.
//
// Unknowns are x, y (m) and the rotation p (rad) of every tile, q = (x_0, y_0, p_0, x_1, ...). With
// r a corner's position about the mean of its tile's vertices and R(p) the rotation, a corner is at
// v = (x, y) + R(p) r. The equations are
//   v_a - v_b = 0                    for each joint, 2 rows
//   (x_0, y_0, p_0) = start value    tile 0 is fixed
//   p_1 - p_0 = theta                the progress on the path
// There may be more rows than unknowns, because joints in closed loops are redundant. A
// Gauss-Newton step of least norm, from a complete orthogonal decomposition (which finds the rank),
// converges quadratically if the rows are consistent. The derivative of v with respect to p is
// (-(v_y - y), v_x - x). The path is followed by natural continuation in theta: steps of a degree
// or less, each from the last state. It fails at turning points of theta, which these sheets do not
// have, and near closed states, where the rank drops. E. L. Allgower, K. Georg, Introduction to
// Numerical Continuation Methods, SIAM, 2003.
//
// All matrices are dense: O(n^3) for n tiles, suitable for some dozens.

namespace {

constexpr double kClosedSheet = 1e-12;  // metres
// Quadratic convergence needs about 5; near singular states it is linear.
constexpr int kMaxRounds = 50;

// Mean of the vertices; any fixed point of a tile would be possible.
Vector3 meanOf(const model::Tile& tile) {
  Vector3 mean = Vector3::Zero();
  for (const Vector3& vertex : tile.vertices) mean += vertex;
  return mean / static_cast<double>(tile.vertices.size());
}

// Rotates a point in the plane about the origin.
Vector3 turned(const Vector3& point, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * point.x() - s * point.y(), s * point.x() + c * point.y(), 0};
}

}  // namespace

// With a and b the positions about the two tiles' means, the rotation that minimises sum |b - R
// a|^2 is atan2(sum a x b, sum a . b), radians. Both tiles must have their vertices in the same
// order.
double planarTurn(const model::Tile& from, const model::Tile& to) {
  const Vector3 meanFrom = meanOf(from);
  const Vector3 meanTo = meanOf(to);
  double along = 0;
  double across = 0;
  for (std::size_t k = 0; k < from.vertices.size(); ++k) {
    const Vector3 a = from.vertices[k] - meanFrom;
    const Vector3 b = to.vertices[k] - meanTo;
    along += a.x() * b.x() + a.y() * b.y();
    across += crossZ(a, b);
  }
  // The best rotation by least squares, as in isometry.cpp.
  return std::atan2(across, along);
}

// Shapes are stored about their own means: x and y of a state are the position of the mean.
ClosurePath::ClosurePath(const std::vector<model::Tile>& tiles,
                         const std::vector<model::Joint>& joints)
    : shapes_(tiles), joints_(joints) {
  for (model::Tile& shape : shapes_) {
    const Vector3 mean = meanOf(shape);
    for (Vector3& vertex : shape.vertices) vertex -= mean;
  }
}

// The rotation is that of the best fit: tiles deformed by rounding, or by an engine, also have a
// state.
PlanarState ClosurePath::stateOf(const std::vector<model::Tile>& placed) const {
  PlanarState state(3 * static_cast<Eigen::Index>(placed.size()));
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const Vector3 mean = meanOf(placed[i]);
    state.segment<3>(3 * static_cast<Eigen::Index>(i)) << mean.x(), mean.y(),
        planarTurn(shapes_[i], placed[i]);
  }
  return state;
}

// The position of a corner in a state, metres, at height 0.
Vector3 ClosurePath::vertex(const PlanarState& state, const model::Corner& corner) const {
  const auto first = 3 * static_cast<Eigen::Index>(corner.tile);
  const Vector3& point = shapes_[std::size_t(corner.tile)].vertices[std::size_t(corner.vertex)];
  return turned(point, state[first + 2]) + Vector3(state[first], state[first + 1], 0);
}

// The largest distance between the two corners of a joint, metres.
double ClosurePath::gap(const PlanarState& state) const {
  double largest = 0;
  for (const model::Joint& joint : joints_) {
    largest = std::max(largest, (vertex(state, joint.a) - vertex(state, joint.b)).norm());
  }
  return largest;
}

/// Residuals and derivatives: all joints closed, tile 0 fixed and tile 1 at the desired
/// angle.
ClosurePath::ClosureEquations ClosurePath::equations(const PlanarState& state, const Vector3& held,
                                                     double desired) const {
  const auto last = 2 * static_cast<Eigen::Index>(joints_.size());
  ClosureEquations made{Eigen::MatrixXd::Zero(last + 4, state.size()),
                        Eigen::VectorXd::Zero(last + 4)};
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const auto row = 2 * static_cast<Eigen::Index>(j);
    const model::Joint& joint = joints_[j];
    made.missed.segment<2>(row) = (vertex(state, joint.a) - vertex(state, joint.b)).head<2>();
    // dv/d(x, y) is the identity. dv/dp is the position about the mean, rotated by 90 degrees.
    for (const auto& [corner, sign] : {std::pair(joint.a, 1.0), std::pair(joint.b, -1.0)}) {
      const auto first = 3 * static_cast<Eigen::Index>(corner.tile);
      const Vector3 place = vertex(state, corner);
      made.slopes(row, first) += sign;
      made.slopes(row + 1, first + 1) += sign;
      made.slopes(row, first + 2) -= sign * (place.y() - state[first + 1]);
      made.slopes(row + 1, first + 2) += sign * (place.x() - state[first]);
    }
  }
  // The three rows that fix tile 0, and the row for the angle of tile 1 relative to it.
  made.slopes.block<3, 3>(last, 0).setIdentity();
  made.missed.segment<3>(last) = state.head<3>() - held;
  made.slopes(last + 3, 5) = 1;
  made.slopes(last + 3, 2) = -1;
  // Angles are compared up to full turns.
  made.missed[last + 3] = std::remainder(angle(state) - desired, 2 * std::numbers::pi);
  return made;
}

// Gauss-Newton from a nearby state to the closed one with the desired angle (radians). Throws
// RunError if the joints do not close. One round costs a dense decomposition, O(n^3).
PlanarState ClosurePath::close(PlanarState state, double desired) const {
  const Vector3 held = state.head<3>();
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMaxRounds; ++round) {
    const ClosureEquations here = equations(state, held, desired);
    const double worst = here.missed.lpNorm<Eigen::Infinity>();
    // Iterates to rounding: the first round that does not halve the residual is the last.
    if (worst < kClosedSheet && worst > 0.5 * before) break;
    before = worst;
    state -= here.slopes.completeOrthogonalDecomposition().solve(here.missed);
  }
  if (gap(state) <= kClosedSheet) return state;
  throw RunError(fmt::format("error: no closed state at {} radians: a gap of {:.2g} m is left",
                             desired, gap(state)));
}

// Closes the state at equal steps of the angle of at most `step` radians, each from the previous
// state.
PlanarState ClosurePath::follow(PlanarState state, double desired, double step) const {
  const double from = angle(state);
  // The shorter direction.
  const double turn = std::remainder(desired - from, 2 * std::numbers::pi);
  const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(turn) / step)));
  for (int k = 1; k <= steps; ++k) state = close(std::move(state), from + turn * k / steps);
  return state;
}

// Vertices of all tiles in a state, metres, at height 0.
std::vector<model::Tile> ClosurePath::tiles(const PlanarState& state) const {
  std::vector<model::Tile> placed = shapes_;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    for (std::size_t k = 0; k < placed[i].vertices.size(); ++k) {
      placed[i].vertices[k] = vertex(state, {static_cast<int>(i), static_cast<int>(k)});
    }
  }
  return placed;
}

}  // namespace kirireel::study
