// First-order mobility from the rank of the joints' Jacobian J (equations x unknowns).
//
// Unknown are the velocity v and the angular velocity w of each tile, w times the mean edge s, so
// that all columns of J are plain numbers. A joint at the points a and b gives, for each direction
// d that it holds,
//   d . (v_A + w_A x (a - c_A)) - d . (v_B + w_B x (b - c_B)) = 0
// with c the centroids. A pivot holds 3 directions (2 in the plane), a link the one along itself, a
// fixed joint 3 and the relative rotation. Then
//   freedoms  = unknowns - rank J - 6        (3 in the plane: motions of the whole)
//   redundant = equations - rank J
// This is the count of J. C. Maxwell with states of self-stress (C. R. Calladine, Buckminster
// Fuller's tensegrity structures and Clerk Maxwell's rules for the construction of stiff frames,
// Int. J. Solids Struct. 14, 1978). It holds to first order: a freedom may be an infinitesimal one
// that no finite motion follows, as in the closed state of these sheets.
//
// Small sheets: a dense singular value decomposition. Large ones: the number of eigenvalues of J^T
// J below s^2 is the number of negative pivots of J^T J - s^2 1 = L D L^T (Sylvester's law of
// inertia), which costs a sparse factorisation for each s and gives the singular values to within a
// power of ten.
#include "sim/measure/mobility.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "sim/base/interruption.h"

namespace kirireel {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

// The part of the largest singular value above which one counts. Zeros met: 1e-15; least others:
// 1e-2 (tess_m10_n10, open).
constexpr double kCounts = 1e-6;
// A dense decomposition takes O(n^3).
constexpr int kMostDenseUnknowns = 900;
constexpr int kMostUnknowns = 60'000;

/// Writes the equations of joints, one after the other.
class JointJacobian {
 public:
  JointJacobian(const Model& model, const std::vector<Tile>& state, Freedom freedom,
                double thickness)
      : state_(state), planar_(freedom == Freedom::Plane), size_(tileSize(model)) {
    for (const Tile& tile : state) {
      centres_.push_back(tileCentroid(tile));
      rises_.push_back(thickness * tileNormal(tile));
    }
    for (const Joint& joint : model.joints) addJoint(joint);
  }

  int unknowns() const { return (planar_ ? 3 : 6) * static_cast<int>(state_.size()); }

  Sparse matrix() const {
    Sparse matrix(rows_, unknowns());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    return matrix;
  }

 private:
  Vector3 place(const Corner& corner, bool top) const {
    const Vector3& bottom = state_[corner.tile].vertices[corner.vertex];
    return top ? Vector3(bottom + rises_[corner.tile]) : bottom;
  }

  // The rows of one joint, by its kind and face.
  void addJoint(const Joint& joint) {
    if (joint.kind == JointKind::Link) {
      // The distance of two points changes along their connection alone.
      const Vector3 along = (place(joint.a, false) - place(joint.b, false)).normalized();
      addDirection(joint, place(joint.a, false), place(joint.b, false), along);
      return;
    }
    if (joint.kind == JointKind::Fixed) return addFixed(joint);
    const bool both = joint.face == JointFace::Both;
    if (joint.face != JointFace::Top) addPivot(joint, false);
    // In the plane the upper pivot of a hinge says nothing more.
    if (joint.face == JointFace::Top || (both && !planar_)) addPivot(joint, true);
  }

  // One row for each axis.
  void addPivot(const Joint& joint, bool top) {
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      addDirection(joint, place(joint.a, top), place(joint.b, top), Vector3::Unit(axis));
    }
  }

  /// The relative motion of the two tiles at one point, and their relative rotation.
  void addFixed(const Joint& joint) {
    const Vector3 point = place(joint.a, false);
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      addDirection(joint, point, point, Vector3::Unit(axis));
    }
    for (int axis = planar_ ? 2 : 0; axis < 3; ++axis) {
      addRotation(joint.a.tile, Vector3::Unit(axis));
      addRotation(joint.b.tile, -Vector3::Unit(axis));
      ++rows_;
    }
  }

  /// direction . (velocity of point a - velocity of point b) = 0.
  void addDirection(const Joint& joint, const Vector3& a, const Vector3& b,
                    const Vector3& direction) {
    addPoint(joint.a.tile, a, direction);
    addPoint(joint.b.tile, b, -direction);
    ++rows_;
  }

  void addPoint(int tile, const Vector3& point, const Vector3& direction) {
    const int first = (planar_ ? 3 : 6) * tile;
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      entries_.emplace_back(rows_, first + axis, direction[axis]);
    }
    // d . (w x r) = w . (r x d), and w is measured in 1/s times the tile's size.
    addRotation(tile, (point - centres_[tile]).cross(direction) / size_);
  }

  void addRotation(int tile, const Vector3& moment) {
    const int first = (planar_ ? 3 : 6) * tile;
    if (planar_) {
      entries_.emplace_back(rows_, first + 2, moment.z());
      return;
    }
    for (int axis = 0; axis < 3; ++axis)
      entries_.emplace_back(rows_, first + 3 + axis, moment[axis]);
  }

  const std::vector<Tile>& state_;
  bool planar_;
  double size_;
  std::vector<Vector3> centres_;
  std::vector<Vector3> rises_;
  int rows_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
};

/// `floor`: singular values up to it are what rounding leaves of zeros.
void countDense(const Sparse& jacobian, double floor, Mobility& result) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd{Eigen::MatrixXd(jacobian)};
  const Eigen::VectorXd& values = svd.singularValues();
  for (const double value : values) {
    const bool counts = value > std::max(floor, kCounts * values[0]);
    result.rank += counts ? 1 : 0;
    (counts ? result.leastKept : result.largestDropped) = value;
    // The values fall: the first that does not count is the largest of those.
    if (!counts) break;
  }
}

/// Counts the eigenvalues of J^T J below a square, by the signs of the pivots of J^T J - s^2.
class SignCounter {
 public:
  explicit SignCounter(const Sparse& square)
      : square_(square), identity_(square.rows(), square.cols()) {
    identity_.setIdentity();
    // A diagonal that is whole keeps the pattern, so that one ordering serves all counts.
    factors_.analyzePattern(Sparse(square_ + identity_));
  }

  int below(double value) {
    checkInterruption();
    factors_.factorize(Sparse(square_ - value * value * identity_));
    return static_cast<int>((factors_.vectorD().array() < 0).count());
  }

 private:
  const Sparse& square_;
  Sparse identity_;
  Eigen::SimplicialLDLT<Sparse> factors_;
};

// By signs of pivots; singular values are known to powers of ten.
void countSparse(const Sparse& jacobian, double floor, Mobility& result) {
  const Sparse square = jacobian.transpose() * jacobian;
  // Row sums bound the largest eigenvalue.
  // Gershgorin's circles: no eigenvalue is larger than the largest sum of absolute values in a row.
  double bound = 0;
  for (Eigen::Index column = 0; column < square.outerSize(); ++column) {
    double sum = 0;
    for (Sparse::InnerIterator entry(square, column); entry; ++entry)
      sum += std::abs(entry.value());
    bound = std::max(bound, sum);
  }
  SignCounter counter(square);
  const double threshold = std::max(floor, kCounts * std::sqrt(bound));
  const int dropped = counter.below(threshold);
  result.rank = result.unknowns - dropped;
  result.largestDropped = dropped > 0 ? threshold : 0;
  // The next power of ten with more values below it.
  for (double value = threshold; value < std::sqrt(bound); value *= 10) {
    if (counter.below(value) > dropped) break;
    result.leastKept = value;
  }
}

}  // namespace

double zeroSingularValue(const Model& model) {
  // A row's entries change by about a digit over a tile, and a sheet has more than one row.
  constexpr double kDigits = 10;
  return model.rounding > 0 ? kDigits * model.rounding / tileSize(model) : 0;
}

Mobility mobility(const Model& model, const std::vector<Tile>& state, Freedom freedom,
                  double thickness) {
  const JointJacobian equations(model, state, freedom, thickness);
  const Sparse jacobian = equations.matrix();
  Mobility result;
  result.unknowns = equations.unknowns();
  result.equations = static_cast<int>(jacobian.rows());
  result.isCounted = result.equations == 0 || result.unknowns <= kMostUnknowns;
  if (!result.isCounted) return result;
  if (result.equations > 0) {
    const double floor = zeroSingularValue(model);
    result.unknowns <= kMostDenseUnknowns ? countDense(jacobian, floor, result)
                                          : countSparse(jacobian, floor, result);
  }
  result.freedoms = result.unknowns - result.rank - (freedom == Freedom::Plane ? 3 : 6);
  result.redundant = result.equations - result.rank;
  return result;
}

}  // namespace kirireel
