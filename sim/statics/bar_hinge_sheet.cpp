// The sheet's energy is the sum over bars of k (l - l0)^2 / 2, with
//   dl/dx = n,   d^2l/dx^2 = (1 - n n^T) / l   at the second end, minus that at the first,
// and over folds of k (angle - rest)^2 / 2 (see the end of this file). Fixed nodes and moved
// handles are linear in the coordinates. Schenk and Guest, Origami folding: a structural
// engineering approach, Origami 5, 2011; Liu and Paulino 2017 (see the end of this file).
#include "sim/statics/bar_hinge_sheet.h"

#include <algorithm>
#include <cmath>

#include <unsupported/Eigen/AutoDiff>

#include "sim/model/isometry.h"

namespace kirireel::statics {
namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

// The mean rest length of the bars, metres: the length scale of the coordinates. 1 without bars.
double meanLength(const std::vector<Bar>& bars) {
  double sum = 0;
  for (const Bar& bar : bars) sum += bar.rest;
  return bars.empty() ? 1 : sum / static_cast<double>(bars.size());
}

/// The derivative of a handle's position along a direction with respect to its nodes' coordinates.
template <typename Add>
void addHandle(const std::vector<int>& nodes, const Vector3& direction, const Add& add) {
  for (const int node : nodes) {
    for (int k = 0; k < 3; ++k) {
      add(3 * node + k, direction[k] / static_cast<double>(nodes.size()));
    }
  }
}

// Position of a handle along a direction: the mean over its nodes of direction . x, in units of q.
double handlePlace(const std::vector<int>& nodes, const Vector3& direction,
                   const Eigen::VectorXd& q) {
  double sum = 0;
  addHandle(nodes, direction, [&](int index, double part) { sum += part * q[index]; });
  return sum;
}

// The pseudoinverse by Newton's method: A. Ben-Israel, D. Cohen, On iterative computation of
// generalized inverses and associated projections, SIAM J. Numer. Anal. 3, 1966. Rows that share no
// coordinates stay separate, and redundant rows need no special treatment.
mechanics::LinearRows linearRowsOf(const BarHingeSheet::Matrix& jacobian) {
  constexpr double kConverged = 1e-8;  // relative change; the next one is its square
  constexpr double kRounding = 1e-13;
  BarHingeSheet::Matrix held = jacobian.transpose() / jacobian.squaredNorm(), change = held;
  while (change.norm() > kConverged * held.norm()) {
    change = held - BarHingeSheet::Matrix(BarHingeSheet::Matrix(held * jacobian) * held);
    held += change;
  }
  BarHingeSheet::Matrix free(held.rows(), held.rows());
  free.setIdentity();
  free -= BarHingeSheet::Matrix(held * jacobian);
  return {std::move(held), free.pruned(1.0, kRounding)};
}

}  // namespace

// The stiffness scale is the largest second derivative of the energy with respect to a scaled
// coordinate: k scale^2 for a bar, about its own stiffness for a fold, both joules.
BarHingeSheet::BarHingeSheet(BarHingeModel model, std::vector<NodeGrip> grips)
    : model_(std::move(model)), grips_(std::move(grips)), scale_(meanLength(model_.bars)) {
  if (!model_.nodes.empty()) origin_ = model_.nodes.front();
  for (const Bar& bar : model_.bars) {
    stiffness_ = std::max(stiffness_, bar.stiffness * scale_ * scale_);
  }
  for (const Fold& fold : model_.folds) stiffness_ = std::max(stiffness_, fold.stiffness);
  addRows();
}

// Rows of the constraints J (q - start) - load * motion = 0. Each fixed node has three rows, and
// each handle of a grip that moves has one. All rows are linear in q: J is built once. The start
// satisfies them at the load 0.
void BarHingeSheet::addRows() {
  Triplets entries;
  std::vector<double> motions;
  const auto addRow = [&](const std::vector<int>& nodes, const Vector3& direction, double motion) {
    const int row = static_cast<int>(motions.size());
    addHandle(nodes, direction,
              [&](int index, double part) { entries.emplace_back(row, index, part); });
    motions.push_back(motion);
  };
  for (const int node : model_.fixed) {
    for (int k = 0; k < 3; ++k) addRow({node}, Vector3::Unit(k), 0);
  }
  for (const NodeGrip& grip : grips_) {
    // A dead load has no rows. Its first row is still stored: indices of grips and entries match.
    firstRow_.push_back(static_cast<Eigen::Index>(motions.size()));
    if (grip.isForce) continue;
    for (const std::vector<int>& handle : grip.handles) {
      addRow(handle, grip.direction, grip.amount / scale_);
    }
  }
  jacobian_.resize(static_cast<Eigen::Index>(motions.size()), unknowns());
  jacobian_.setFromTriplets(entries.begin(), entries.end());
  linearRows_ = linearRowsOf(jacobian_);
  motion_ = Eigen::Map<const Vector>(motions.data(), static_cast<Eigen::Index>(motions.size()));
}

// Coordinates 3 i to 3 i + 2 are the position of node i from the first one's start over the length
// scale. Far from the origin, they keep all their digits.
BarHingeSheet::Vector BarHingeSheet::startCoordinates() const {
  Vector q(unknowns());
  for (std::size_t i = 0; i < model_.nodes.size(); ++i) {
    q.segment<3>(3 * static_cast<Eigen::Index>(i)) = (model_.nodes[i] - origin_) / scale_;
  }
  return q;
}

// An elastic tile is not a rigid body. Its pose is the start's, moved by the rigid motion that fits
// its nodes best by least squares (model/isometry.h).
Poses BarHingeSheet::posesAt(const Vector& q) const {
  Poses poses = model_.start;
  for (std::size_t t = 0; t < poses.size(); ++t) {
    std::vector<Vector3> before, now;
    for (const int node : model_.tiles[t]) {
      before.push_back(model_.nodes[static_cast<std::size_t>(node)] - origin_);
      now.push_back(place(node, q));
    }
    const model::RigidMotion motion = model::bestRigidMotion(before, now);
    poses[t].position = origin_ + motion.apply(poses[t].position - origin_);
    poses[t].rotation = (Quaternion(motion.rotation) * poses[t].rotation).normalized();
  }
  return poses;
}

// The positions of a fold's four nodes from the origin, metres, in the order of FoldPoints.
FoldPoints BarHingeSheet::pointsOf(const Fold& fold, const Vector& q) const {
  FoldPoints points;
  std::ranges::transform(fold.nodes, points.begin(), [&](int node) { return place(node, q); });
  return points;
}

double BarHingeSheet::strainOf(const Bar& bar, const Vector& q) const {
  return ((place(bar.nodeB, q) - place(bar.nodeA, q)).norm() - bar.rest) / bar.rest;
}

// E = sum k (l - l0)^2 / 2 over bars + sum k (angle - rest)^2 / 2 over folds, joules.
double BarHingeSheet::energy(const Vector& q) const {
  double sum = 0;
  for (const Bar& bar : model_.bars) sum += bar.energy(strainOf(bar, q));
  for (const Fold& fold : model_.folds) sum += fold.energy(foldAngle(pointsOf(fold, q)));
  return sum;
}

trajectory::LoadedPanels BarHingeSheet::panels() const {
  return {model_.tiles, model_.bars, model_.folds, {}};
}

// Strains and angles come from the coordinates, which have more digits than nodes far from the
// origin.
trajectory::PanelState BarHingeSheet::panelState(const Vector& q) const {
  trajectory::PanelState state;
  for (int node = 0; node < static_cast<int>(model_.nodes.size()); ++node) {
    state.nodes.push_back(origin_ + place(node, q));
  }
  for (const Bar& bar : model_.bars) state.strains.push_back(strainOf(bar, q));
  for (const Fold& fold : model_.folds) state.angles.push_back(foldAngle(pointsOf(fold, q)));
  return state;
}

// The dead loads at load 1, in the coordinates q. The handles of a grip share its force of `amount`
// newtons equally. The factor scale converts metres to units of q. Entries are joules. The forces
// keep their direction and do not depend on q.
BarHingeSheet::Vector BarHingeSheet::pull(const Vector& q) const {
  Vector forces = Vector::Zero(q.size());
  for (const NodeGrip& grip : grips_) {
    if (!grip.isForce) continue;
    const double each = scale_ * grip.amount / static_cast<double>(grip.handles.size());
    for (const std::vector<int>& handle : grip.handles) {
      addHandle(handle, grip.direction,
                [&](int index, double part) { forces[index] += each * part; });
    }
  }
  return forces;
}

// dE/dq - load * pull, joules: for a bar +- scale k (l - l0) n at its two ends, with the unit
// vector n from A to B; for a fold scale k (angle - rest) d(angle)/dx.
BarHingeSheet::Vector BarHingeSheet::gradient(const Vector& q, double load) const {
  Vector sum = -load * pull(q);
  for (const Bar& bar : model_.bars) {
    const Vector3 along = place(bar.nodeB, q) - place(bar.nodeA, q);
    const double length = along.norm();
    const Vector3 force = scale_ * bar.stiffness * (length - bar.rest) / length * along;
    sum.segment<3>(3 * bar.nodeA) -= force;
    sum.segment<3>(3 * bar.nodeB) += force;
  }
  for (const Fold& fold : model_.folds) {
    const FoldPoints points = pointsOf(fold, q);
    const Vector12 slope =
        scale_ * fold.stiffness * (foldAngle(points) - fold.rest) * foldSlope(points);
    for (int i = 0; i < 4; ++i) {
      sum.segment<3>(3 * fold.nodes[static_cast<std::size_t>(i)]) += slope.segment<3>(3 * i);
    }
  }
  return sum;
}

BarHingeSheet::Vector BarHingeSheet::residual(const Vector& q, double load) const {
  return jacobian_ * (q - startCoordinates()) - load * motion_;
}

// The second derivative of the energy by q, joules. The rows are linear and the dead loads
// constant: neither the multipliers nor the load take part.
BarHingeSheet::Matrix BarHingeSheet::hessian(const Vector& q, double, const Vector&) const {
  Triplets entries;
  const auto add = [&](int nodeA, int nodeB, const Matrix3& block) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) entries.emplace_back(3 * nodeA + i, 3 * nodeB + j, block(i, j));
    }
  };
  // Two derivatives with respect to q are scale^2 times those with respect to positions.
  const double square = scale_ * scale_;
  for (const Bar& bar : model_.bars) {
    const Vector3 along = place(bar.nodeB, q) - place(bar.nodeA, q);
    const double length = along.norm();
    const Matrix3 line = along * along.transpose() / (length * length);
    // The first part is the bar's elastic stiffness along its line. The second is the geometric
    // stiffness across it, k (1 - l0/l), which is negative under compression.
    const Matrix3 block =
        square * bar.stiffness * (line + (1 - bar.rest / length) * (Matrix3::Identity() - line));
    add(bar.nodeA, bar.nodeA, block);
    add(bar.nodeB, bar.nodeB, block);
    add(bar.nodeA, bar.nodeB, -block);
    add(bar.nodeB, bar.nodeA, -block);
  }
  for (const Fold& fold : model_.folds) {
    const FoldPoints points = pointsOf(fold, q);
    const Vector12 slope = foldSlope(points);
    // The chain rule twice: k (slope slope^T + (angle - rest) d^2(angle)/dx^2).
    const Matrix12 blocks =
        square * fold.stiffness *
        (slope * slope.transpose() + (foldAngle(points) - fold.rest) * foldBend(points));
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        add(fold.nodes[static_cast<std::size_t>(i)], fold.nodes[static_cast<std::size_t>(j)],
            blocks.block<3, 3>(3 * i, 3 * j));
      }
    }
  }
  Matrix matrix(unknowns(), unknowns());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// A grip's displacement is linear in q: it equals its slope times q - q(start).
double BarHingeSheet::displacement(std::size_t grip, const Vector& q) const {
  return displacementSlope(grip, q, q - startCoordinates());
}

double BarHingeSheet::displacementSlope(std::size_t grip, const Vector&,
                                        const Vector& along) const {
  const NodeGrip& found = grips_[grip];
  double sum = 0;
  for (const std::vector<int>& handle : found.handles) {
    sum += scale_ * handlePlace(handle, found.direction, along);
  }
  return sum / static_cast<double>(found.handles.size());
}

mechanics::RowRange BarHingeSheet::rowsOf(std::size_t grip) const {
  const NodeGrip& found = grips_[grip];
  const std::size_t count = found.isForce ? 0 : found.handles.size();
  return {firstRow_[grip], static_cast<Eigen::Index>(count)};
}

// A multiplier is the energy per motion of a row, which is in length scales. Divided by the scale
// it is in newtons. The sign converts the force of the row on the sheet to the force of the grip.
double BarHingeSheet::force(std::size_t grip, double load, const Vector& multipliers) const {
  const NodeGrip& found = grips_[grip];
  if (found.isForce) return load * found.amount;
  const auto [first, count] = rowsOf(grip);
  return -multipliers.segment(first, count).sum() / scale_;
}

// ------------------------------------------------------------------------------------------------
// With the edge e from point 0 to point 1, the normals n = e x (x2 - x0) of the left triangle and
// m = (x3 - x0) x e of the right one, the angle is atan2(e/|e| . (m x n), n . m), and
//   d(angle)/dx2 = |e| n / n^2,   d(angle)/dx3 = |e| m / m^2.
// The derivatives at points 0 and 1 follow because rigid motions do not change the angle. With s
// and t the shares of the edge at the feet of points 2 and 3,
//   d/dx0 = -(1 - s) d/dx2 - (1 - t) d/dx3,   d/dx1 = -s d/dx2 - t d/dx3.
// The second derivative is that of these formulas by forward differentiation. Liu and Paulino,
// Nonlinear mechanics of non-rigid origami, Proc. R. Soc. A 473, 2017, section 2 and appendix.

namespace {

// The vector operations are written out, each result cast to a Scalar: AutoDiffScalar's operators
// return expressions, which must not outlive their operands.
template <typename Scalar>
using Point = Eigen::Matrix<Scalar, 3, 1>;

template <typename Scalar>
Point<Scalar> crossOf(const Point<Scalar>& a, const Point<Scalar>& b) {
  return {Scalar(a[1] * b[2] - a[2] * b[1]), Scalar(a[2] * b[0] - a[0] * b[2]),
          Scalar(a[0] * b[1] - a[1] * b[0])};
}

template <typename Scalar>
Scalar dotOf(const Point<Scalar>& a, const Point<Scalar>& b) {
  return Scalar(a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

template <typename Scalar>
Point<Scalar> minus(const Point<Scalar>& a, const Point<Scalar>& b) {
  return {Scalar(a[0] - b[0]), Scalar(a[1] - b[1]), Scalar(a[2] - b[2])};
}

template <typename Scalar>
std::array<Point<Scalar>, 4> slopesOf(const std::array<Point<Scalar>, 4>& x) {
  using std::sqrt;
  const Point<Scalar> edge = minus(x[1], x[0]);
  const Point<Scalar> left = minus(x[2], x[0]), right = minus(x[3], x[0]);
  const Point<Scalar> n = crossOf(edge, left), m = crossOf(right, edge);
  const Scalar square = dotOf(edge, edge);
  const Scalar length = sqrt(square);
  const Scalar overN = Scalar(length / dotOf(n, n)), overM = Scalar(length / dotOf(m, m));
  const Scalar s = Scalar(dotOf(left, edge) / square), t = Scalar(dotOf(right, edge) / square);
  std::array<Point<Scalar>, 4> slopes;
  for (int k = 0; k < 3; ++k) {
    slopes[2][k] = overN * n[k];
    slopes[3][k] = overM * m[k];
    slopes[1][k] = -s * slopes[2][k] - t * slopes[3][k];
    slopes[0][k] = -slopes[1][k] - slopes[2][k] - slopes[3][k];
  }
  return slopes;
}

}  // namespace

// The angle is in (-pi, pi], and 0 if the two triangles are flat, on opposite sides of the edge.
// atan2 is exact near 0 and pi. The arc cosine of n . m would lose half of the digits.
double foldAngle(const FoldPoints& points) {
  const Vector3 edge = points[1] - points[0];
  const Vector3 n = edge.cross(points[2] - points[0]);
  const Vector3 m = (points[3] - points[0]).cross(edge);
  return std::atan2(edge.normalized().dot(m.cross(n)), n.dot(m));
}

// The angle's derivatives by the four points, in their order, rad/m.
Vector12 foldSlope(const FoldPoints& points) {
  const std::array<Vector3, 4> slopes = slopesOf<double>(points);
  Vector12 slope;
  slope << slopes[0], slopes[1], slopes[2], slopes[3];
  return slope;
}

// Each of the 12 coordinates is a dual number that carries its derivatives by all 12. The slopes'
// derivatives are then the rows of the second derivative, rad/m^2, exact to rounding.
Matrix12 foldBend(const FoldPoints& points) {
  using Dual = Eigen::AutoDiffScalar<Vector12>;
  std::array<Point<Dual>, 4> x;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      x[static_cast<std::size_t>(i)][k] =
          Dual(points[static_cast<std::size_t>(i)][k], 12, 3 * i + k);
    }
  }
  const std::array<Point<Dual>, 4> slopes = slopesOf<Dual>(x);
  Matrix12 bend;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      bend.row(3 * i + k) = slopes[static_cast<std::size_t>(i)][k].derivatives().transpose();
    }
  }
  return bend;
}

}  // namespace kirireel::statics
