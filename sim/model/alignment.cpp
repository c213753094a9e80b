// Best rigid fits of one point set to another, by least squares.
//
// Wanted are the rotation R and the translation t that minimise
//   E(R, t) = sum over i of w_i |R a_i + t - b_i|^2
// for points a_i (from) and b_i (to), in metres, and weights w_i without unit. For any R the best t
// takes the weighted mean of the a_i to that of the b_i. What is left is to maximise trace(R C)
// with
//   C = sum over i of w_i (a_i - mean a)(b_i - mean b)^T          3 x 3, m^2
// In space: C = U S V^T (singular values) gives R = V diag(1, 1, d) U^T with d = det(V U^T) = +-1,
// so that R is a rotation and never a reflection. Points in one plane have a singular value 0,
// which d can use at no cost; points on one line leave the turn about the line open. In the plane:
// trace(R C) = cos(p) (C_xx + C_yy) + sin(p) (C_xy - C_yx), so that the angle is p = atan2(C_xy -
// C_yx, C_xx + C_yy).
//
// W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Crystallographica
// A32, 1976.
#include "sim/model/alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace kirireel {
namespace {

// The weighted mean; the weights add up to something.
Vector3 meanOf(std::span<const Vector3> points, std::span<const double> weights) {
  Vector3 sum = Vector3::Zero();
  double total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += weights[i] * points[i];
    total += weights[i];
  }
  return sum / total;
}

/// Two point sets with their weighted means, and the sum of weight (from - mean) (to - mean)^T.
struct Comparison {
  Vector3 fromMean;
  Vector3 toMean;
  Matrix3 covariance = Matrix3::Zero();

  Comparison(std::span<const Vector3> from, std::span<const Vector3> to,
             std::span<const double> weights)
      : fromMean(meanOf(from, weights)), toMean(meanOf(to, weights)) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      covariance += weights[i] * (from[i] - fromMean) * (to[i] - toMean).transpose();
    }
  }

  /// The motion with this rotation that brings mean onto mean.
  RigidMotion withRotation(const Matrix3& rotation) const {
    return {rotation, toMean - rotation * fromMean};
  }
};

std::vector<double> evenWeights(std::size_t count) {
  return std::vector<double>(count, 1.0);
}

/// The best turn about the z axis: for sets in horizontal planes the best motion in space may flip
/// the sheet over, which no sheet on a table can do.
RigidMotion bestPlanarMotion(std::span<const Vector3> from, std::span<const Vector3> to) {
  const Comparison sets(from, to, evenWeights(from.size()));
  const Matrix3& covariance = sets.covariance;
  const double angle =
      std::atan2(covariance(0, 1) - covariance(1, 0), covariance(0, 0) + covariance(1, 1));
  return sets.withRotation(Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix());
}

std::vector<Vector3> allVertices(const std::vector<Tile>& tiles) {
  std::vector<Vector3> points;
  for (const Tile& tile : tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return points;
}

std::vector<Vector3> verticesOf(const std::vector<Tile>& tiles, std::span<const int> chosen) {
  std::vector<Vector3> points;
  for (const int i : chosen) {
    const std::vector<Vector3>& vertices = tiles[static_cast<std::size_t>(i)].vertices;
    points.insert(points.end(), vertices.begin(), vertices.end());
  }
  return points;
}

// Whether all points lie at one height, whatever it is, to the tolerance in metres.
bool isHorizontal(std::span<const Vector3> points, double tolerance) {
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(),
                          [](const Vector3& a, const Vector3& b) { return a.z() < b.z(); });
  return high->z() - low->z() <= tolerance;
}

}  // namespace

RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to,
                            std::span<const double> weights) {
  // Kabsch 1976: with covariance = U S V^T the rotation is V diag(1, 1, +-1) U^T; the sign, on the
  // weakest axis, rules out a reflection.
  const Comparison sets(from, to, weights);
  const Eigen::JacobiSVD<Matrix3> svd(sets.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 signs = Vector3::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1;
  return sets.withRotation(svd.matrixV() * signs.asDiagonal() * svd.matrixU().transpose());
}

RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to) {
  return bestRigidMotion(from, to, evenWeights(from.size()));
}

// The fit is made from the vertices of all tiles, or of those that will be held, and moves all
// tiles.
RigidMotion alignStartToTarget(Model& model, std::span<const int> held) {
  if (!model.target) return {};
  const std::vector<Vector3> start = allVertices(model.tiles);
  const std::vector<Vector3> target = allVertices(*model.target);
  // Heights that differ by less than a billionth of the sheet come from rounding.
  const double tolerance = 1e-9 * modelSize(model);
  // Both states have to lie flat: one that folds up may well start upside down.
  const bool planar = isHorizontal(start, tolerance) && isHorizontal(target, tolerance);
  const auto fit = [planar](std::span<const Vector3> from, std::span<const Vector3> to) {
    return planar ? bestPlanarMotion(from, to) : bestRigidMotion(from, to);
  };
  const RigidMotion motion =
      held.empty() ? fit(start, target)
                   : fit(verticesOf(model.tiles, held), verticesOf(*model.target, held));
  for (Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = motion.apply(vertex);
  }
  return motion;
}

}  // namespace kirireel
