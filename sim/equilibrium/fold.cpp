// With the edge e from point 0 to point 1, the normals n = e x (x2 - x0) of the left triangle and
// m = (x3 - x0) x e of the right one, the angle is atan2(e/|e| . (m x n), n . m), and
//   d(angle)/dx2 = |e| n / n^2,   d(angle)/dx3 = |e| m / m^2;
// what points 0 and 1 add is what keeps the angle as all points move or turn together: with s and t
// the shares of the edge at the feet of points 2 and 3,
//   d/dx0 = -(1 - s) d/dx2 - (1 - t) d/dx3,   d/dx1 = -s d/dx2 - t d/dx3.
// The second derivative is that of these formulas by forward differentiation. Liu and Paulino,
// Nonlinear mechanics of non-rigid origami, Proc. R. Soc. A 473, 2017, section 2 and appendix.
#include "sim/equilibrium/fold.h"

#include <cmath>

#include <unsupported/Eigen/AutoDiff>

namespace kirireel {
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

// The angle is in (-pi, pi] and 0 where the two triangles lie flat, on opposite sides of the edge.
// atan2 is exact near 0 and pi, where the arc cosine of n . m would lose half of the digits.
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

}  // namespace kirireel
