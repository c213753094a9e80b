#include "sim/model/alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace kirireel {
namespace {

Vector3 meanOf(std::span<const Vector3> points) {
  Vector3 sum = Vector3::Zero();
  for (const Vector3& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Sum of (from - mean) (to - mean)^T.
Matrix3 crossCovariance(std::span<const Vector3> from, std::span<const Vector3> to) {
  const Vector3 fromMean = meanOf(from);
  const Vector3 toMean = meanOf(to);
  Matrix3 sum = Matrix3::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    sum += (from[i] - fromMean) * (to[i] - toMean).transpose();
  }
  return sum;
}

/// The motion with this rotation that brings mean onto mean.
RigidMotion aboutMeans(const Matrix3& rotation, std::span<const Vector3> from,
                       std::span<const Vector3> to) {
  return {rotation, meanOf(to) - rotation * meanOf(from)};
}

/// The best turn about the z axis: for sets in horizontal planes the best motion in space may flip
/// the sheet over, which no sheet on a table can do.
RigidMotion bestPlanarMotion(std::span<const Vector3> from, std::span<const Vector3> to) {
  const Matrix3 covariance = crossCovariance(from, to);
  const double angle =
      std::atan2(covariance(0, 1) - covariance(1, 0), covariance(0, 0) + covariance(1, 1));
  const Matrix3 rotation = Eigen::AngleAxisd(angle, Vector3::UnitZ()).toRotationMatrix();
  return aboutMeans(rotation, from, to);
}

std::vector<Vector3> allVertices(const std::vector<Tile>& tiles) {
  std::vector<Vector3> points;
  for (const Tile& tile : tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return points;
}

bool isHorizontal(std::span<const Vector3> points, double tolerance) {
  const auto [low, high] =
      std::minmax_element(points.begin(), points.end(),
                          [](const Vector3& a, const Vector3& b) { return a.z() < b.z(); });
  return high->z() - low->z() <= tolerance;
}

}  // namespace

RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to) {
  // Kabsch 1976: with covariance = U S V^T the rotation is V diag(1, 1, +-1) U^T; the sign, on the
  // weakest axis, rules out a reflection.
  const Eigen::JacobiSVD<Matrix3> svd(crossCovariance(from, to),
                                      Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 signs = Vector3::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1;
  const Matrix3 rotation = svd.matrixV() * signs.asDiagonal() * svd.matrixU().transpose();
  return aboutMeans(rotation, from, to);
}

RigidMotion alignStartToTarget(Model& model) {
  if (!model.target) return {};
  const std::vector<Vector3> start = allVertices(model.tiles);
  const std::vector<Vector3> target = allVertices(*model.target);
  const double tolerance = 1e-9 * modelSize(model);
  const bool planar = isHorizontal(start, tolerance) && isHorizontal(target, tolerance);
  const RigidMotion motion =
      planar ? bestPlanarMotion(start, target) : bestRigidMotion(start, target);
  for (Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = motion.apply(vertex);
  }
  return motion;
}

}  // namespace kirireel
