// With l the vector from point A to point B, l0 that of the start and phi the turns of the bricks,
//   E = k_l (|l| - |l0|)^2 / 2 + k_s gamma^2 / 2,   gamma = angle(l0, l) - (phi_A + phi_B) / 2,
// which is exact for large turns: neither part changes as the whole is turned. Together with a
// torsional spring on phi_B - phi_A this is the rigid unit's ligament of Deng, Raney, Tournat and
// Bertoldi, Elastic vector solitons in soft architected materials, Phys. Rev. Lett. 118, 2017, with
// the strains of Bordiga, Medina, Jafarzadeh et al., Automated discovery of reprogrammable
// nonlinear dynamic metamaterials, Nat. Mater. 23, 2024. A beam whose ends turn by a and b against
// its chord has E I / L (2 a^2 + 2 a b + 2 b^2) = 12 E I / L gamma^2 / 2 + E I / L (b - a)^2 / 2.
//
// A pin parts by d from point A to point B. With n and t the directions across and along its slit,
// turned by the mean m of both bricks' turns since the start, of which dn/dm = t and dt/dm = -n,
//   E = k_l (n . d)^2 / 2 + k_s (t . d)^2 / 2,
//   d(n . d) = n . dd + (t . d) dm,   d(t . d) = t . dd - (n . d) dm,
// and what opening costs beyond a linear spring, b a^3 / 3 + c a^4 / 4 with a = phi_B - phi_A.
#include "sim/brick/ligament.h"

#include <cmath>
#include <numbers>

namespace kirireel {
namespace {

using Row2 = Eigen::Matrix<double, 2, 6>;

/// The derivative of l by the six coordinates.
Row2 slopeOf(const Vector3& armA, const Vector3& armB) {
  Row2 slope;
  slope << -1, 0, armA.y(), 1, 0, -armB.y(), 0, -1, -armA.x(), 0, 1, armB.x();
  return slope;
}

/// The second derivative of l along a direction, which is by the turns alone.
Matrix6 bendOf(const Vector3& armA, const Vector3& armB, const Eigen::Vector2d& direction) {
  Matrix6 bend = Matrix6::Zero();
  bend(2, 2) = direction.dot(armA.head<2>());
  bend(5, 5) = -direction.dot(armB.head<2>());
  return bend;
}

/// A component of d, its derivatives by the coordinates of both bricks.
struct PinComponent {
  double value = 0;
  Vector6 slope = Vector6::Zero();
  Matrix6 bend = Matrix6::Zero();
};

/// The component along a direction that turns with the mean; `turned`: its derivative by that.
PinComponent componentAlong(const Eigen::Vector2d& d, const Eigen::Vector2d& direction,
                            const Eigen::Vector2d& turned, const Eigen::Vector2d& armA,
                            const Eigen::Vector2d& armB) {
  const auto slopeAlong = [&](const Eigen::Vector2d& along) {
    Vector6 slope;
    slope << -along, along.x() * armA.y() - along.y() * armA.x(), along,
        along.y() * armB.x() - along.x() * armB.y();
    return slope;
  };
  Vector6 mean = Vector6::Zero();
  mean[2] = mean[5] = 0.5;
  PinComponent found{direction.dot(d), slopeAlong(direction) + turned.dot(d) * mean};
  const Matrix6 mixed = slopeAlong(turned) * mean.transpose();
  found.bend = mixed + mixed.transpose() - found.value * mean * mean.transpose();
  found.bend(2, 2) += direction.dot(armA);
  found.bend(5, 5) -= direction.dot(armB);
  return found;
}

void addPinSpring(double stiffness, const PinComponent& of, LigamentEnergy& sum) {
  sum.energy += 0.5 * stiffness * of.value * of.value;
  sum.gradient += stiffness * of.value * of.slope;
  sum.hessian += stiffness * (of.slope * of.slope.transpose() + of.value * of.bend);
}

LigamentEnergy pinEnergy(const Ligament& pin, const Vector3& between, const Vector3& armA,
                         const Vector3& armB, double turnA, double turnB) {
  const Eigen::Vector2d d = (between + armB - armA).head<2>();
  const Vector3 across = rotationFromVector(Vector3(0, 0, 0.5 * (turnA + turnB))) * pin.across;
  const Eigen::Vector2d n = across.head<2>(), t(-n.y(), n.x());
  LigamentEnergy sum;
  addPinSpring(pin.stretchStiffness, componentAlong(d, n, t, armA.head<2>(), armB.head<2>()), sum);
  addPinSpring(pin.shearStiffness, componentAlong(d, t, -n, armA.head<2>(), armB.head<2>()), sum);
  const double a = turnB - turnA;
  const auto [square, cube] = pin.opening;
  Vector6 turning = Vector6::Zero();
  turning[2] = -1;
  turning[5] = 1;
  // The moment square a^2 + cube a^3, integrated over a.
  sum.energy += a * a * a * (square / 3 + cube * a / 4);
  sum.gradient += a * a * (square + cube * a) * turning;
  sum.hessian += a * (2 * square + 3 * cube * a) * turning * turning.transpose();
  return sum;
}

}  // namespace

void setNeckStiffness(double youngs, double poisson, double thickness, double width, double length,
                      Ligament& ligament) {
  // Of a rectangle: S. P. Timoshenko's shear coefficient in its usual approximation.
  constexpr double kShearFactor = 5.0 / 6;
  const double area = width * thickness;
  const double bending = youngs * thickness * width * width * width / 12;
  const double shearing = kShearFactor * youngs / (2 * (1 + poisson)) * area;
  ligament.stretchStiffness = youngs * area / length;
  ligament.shearStiffness = 1 / (length / (12 * bending) + 1 / (shearing * length));
}

LigamentEnergy ligamentEnergy(const Ligament& ligament, const Vector3& between, const Vector3& armA,
                              const Vector3& armB, double turnA, double turnB) {
  if (ligament.isPin()) return pinEnergy(ligament, between, armA, armB, turnA, turnB);
  const Eigen::Vector2d l = (between + armB - armA).head<2>();
  const Eigen::Vector2d l0 = ligament.start.head<2>();
  // The ligament's length and direction now, and the direction across it.
  const double length = l.norm();
  const Eigen::Vector2d n = l / length, t(-n.y(), n.x());
  const double stretch = length - l0.norm();
  const double turn = std::atan2(l0.x() * l.y() - l0.y() * l.x(), l0.dot(l));
  const double shear = std::remainder(turn - 0.5 * (turnA + turnB), 2 * std::numbers::pi);

  // d|l| = n . dl, and the angle of l changes by t . dl / |l|.
  const Row2 slope = slopeOf(armA, armB);
  const Vector6 ofStretch = slope.transpose() * n;
  Vector6 ofShear = slope.transpose() * t / length;
  ofShear[2] -= 0.5;
  ofShear[5] -= 0.5;
  const Vector6 across = slope.transpose() * t;
  // The second derivative of |l| is t t^T / |l| along l's own changes, and n . d2l; that of the
  // angle is -(n t^T + t n^T) / |l|^2, and t . d2l / |l|.
  const Matrix6 stretchBend = across * across.transpose() / length + bendOf(armA, armB, n);
  const Matrix6 mixed = ofStretch * across.transpose();
  const Matrix6 shearBend =
      -(mixed + mixed.transpose()) / (length * length) + bendOf(armA, armB, t) / length;

  const double kl = ligament.stretchStiffness, ks = ligament.shearStiffness;
  return {0.5 * kl * stretch * stretch + 0.5 * ks * shear * shear,
          kl * stretch * ofStretch + ks * shear * ofShear,
          kl * (ofStretch * ofStretch.transpose() + stretch * stretchBend) +
              ks * (ofShear * ofShear.transpose() + shear * shearBend)};
}

LigamentEnergy ligamentEnergy(const Ligament& ligament, const Poses& poses) {
  const Pose& a = poses[static_cast<std::size_t>(ligament.brickA)];
  const Pose& b = poses[static_cast<std::size_t>(ligament.brickB)];
  const auto turnOf = [](const Quaternion& rotation) {
    return 2 * std::atan2(rotation.z(), rotation.w());
  };
  const double turnA = turnOf(a.rotation);
  // The turn of B is taken near that of A, since each is known to whole turns alone.
  const double turnB = turnA + std::remainder(turnOf(b.rotation) - turnA, 2 * std::numbers::pi);
  return ligamentEnergy(ligament, b.position - a.position, a.rotation * ligament.pointA,
                        b.rotation * ligament.pointB, turnA, turnB);
}

double elasticEnergy(std::span<const Ligament> ligaments, const Poses& poses) {
  double sum = 0;
  for (const Ligament& ligament : ligaments) sum += ligamentEnergy(ligament, poses).energy;
  return sum;
}

}  // namespace kirireel
