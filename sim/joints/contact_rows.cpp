// Rows of contacts and their augmented Lagrangian: a contact with the multiplier p pushes with
//   max(0, p - rho (c x - b)),
// and rubs with s - rho t x, cut to the length mu p of Coulomb's cone, the radius of the round
// before. Points of one plane become rows together. Of contacts that carried load the next step
// begins with the multipliers.
#include "sim/joints/contact_rows.h"

#include <algorithm>
#include <array>

namespace kirireel {
namespace {

// Two unit vectors that span the plane across a unit normal. Which two they are does not matter:
// friction's bound is round.
std::array<Vector3, 2> tangentsOf(const Vector3& normal) {
  const Vector3 first = normal.unitOrthogonal();
  return {first, normal.cross(first)};
}

/// Adds what turning edges contribute: the normal of two edges turns with both bricks,
///   d(a x b . d) = w_A . (a x (b x d)) + w_B . (b x (d x a)),
/// and only what of d lies across the normal counts, since the normal keeps its length.
template <int D>
void addTurningNormal(ContactRow<D>& row, const Poses& poses) {
  const Contact& contact = row.contact;
  const Vector3 a = poses[contact.brickA].rotation * contact.edgeA;
  const Vector3 b = poses[contact.brickB].rotation * contact.normal;
  const double length = a.cross(b).norm();
  const Vector3 normal = a.cross(b) / length;
  const Vector3 between =
      poses[contact.brickA].apply(contact.pointA) - poses[contact.brickB].apply(contact.pointB);
  const Vector3 d = between - normal.dot(between) * normal;
  row.normalA += Coordinates<D>::turning(a.cross(b.cross(d)) / length);
  row.normalB += Coordinates<D>::turning(b.cross(d.cross(a)) / length);
}

}  // namespace

template <int D>
// w = C u for this row, m/s; positive where the points part.
double ContactRow<D>::normalVelocity(const Eigen::VectorXd& u) const {
  double w = normalA.dot(u.segment<D>(D * contact.brickA));
  if (contact.brickB != kFixed) w += normalB.dot(u.segment<D>(D * contact.brickB));
  return w;
}

template <int D>
typename ContactRow<D>::Tangent ContactRow<D>::slipVelocity(const Eigen::VectorXd& u) const {
  Tangent w = tangentA * u.segment<D>(D * contact.brickA);
  if (contact.brickB != kFixed) w += tangentB * u.segment<D>(D * contact.brickB);
  return w;
}

template <int D>
void ContactRow<D>::addNormal(double scale, Eigen::VectorXd& to) const {
  to.segment<D>(D * contact.brickA) += scale * normalA.transpose();
  if (contact.brickB != kFixed) to.segment<D>(D * contact.brickB) += scale * normalB.transpose();
}

template <int D>
void ContactRow<D>::addTangent(const Tangent& scale, Eigen::VectorXd& to) const {
  to.segment<D>(D * contact.brickA) += tangentA.transpose() * scale;
  if (contact.brickB != kFixed) to.segment<D>(D * contact.brickB) += tangentB.transpose() * scale;
}

template <int D>
double ContactRow<D>::pushingImpulse(const Eigen::VectorXd& u, double rho) const {
  return multiplier - rho * (normalVelocity(u) + bias);
}

template <int D>
double ContactRow<D>::trialImpulse(const Eigen::VectorXd& u, double rho) const {
  return hasNormal ? std::max(0.0, pushingImpulse(u, rho)) : 0.0;
}

template <int D>
typename ContactRow<D>::Tangent ContactRow<D>::trialSlipImpulse(const Eigen::VectorXd& u,
                                                                double rho,
                                                                TangentMatrix* stiffness) const {
  const Tangent trial = slipMultiplier - rho * slipVelocity(u);
  const double length = trial.norm();
  if (length <= slipBound) {
    if (stiffness) stiffness->setIdentity();
    return trial;
  }
  const Tangent direction = trial / length;
  const double share = slipBound / length;
  if (stiffness) {
    *stiffness = share * (TangentMatrix::Identity() - direction * direction.transpose());
  }
  return share * trial;
}

template <int D>
void placeRow(ContactRow<D>& row, const Poses& poses) {
  const Contact& contact = row.contact;
  const Pose& poseA = poses[contact.brickA];
  const Vector3 armA = poseA.rotation * contact.pointA;
  const Vector3 normal = contactNormal(contact, poses);
  Vector3 armB = Vector3::Zero();
  if (contact.brickB != kFixed) {
    // A plane of B turns with B, so B's arm too goes to A's point.
    const Pose& poseB = poses[contact.brickB];
    armB = contact.isEdge ? Vector3(poseB.rotation * contact.pointB)
                          : Vector3(poseA.position + armA - poseB.position);
  }
  row.normalA = Coordinates<D>::pointVelocity(armA, normal);
  row.normalB = -Coordinates<D>::pointVelocity(armB, normal);
  if (contact.isEdge) addTurningNormal(row, poses);
  const std::array<Vector3, 2> tangents = tangentsOf(normal);
  for (int k = 0; k < ContactRow<D>::kTangents; ++k) {
    row.tangentA.row(k) = Coordinates<D>::pointVelocity(armA, tangents[k]);
    row.tangentB.row(k) = -Coordinates<D>::pointVelocity(armB, tangents[k]);
  }
}

template <int D>
ContactRow<D> makeContactRow(const Contact& contact, const Poses& poses, double step,
                             double recovery) {
  ContactRow<D> row;
  row.contact = contact;
  placeRow(row, poses);
  const double gap = contactGap(contact, poses);
  row.aim = std::min(0.0, gap + recovery);
  row.bias = std::max(0.0, gap) / step;
  return row;
}

template struct ContactRow<3>;
template struct ContactRow<6>;
template ContactRow<3> makeContactRow<3>(const Contact&, const Poses&, double, double);
template ContactRow<6> makeContactRow<6>(const Contact&, const Poses&, double, double);
template void placeRow<3>(ContactRow<3>&, const Poses&);
template void placeRow<6>(ContactRow<6>&, const Poses&);

}  // namespace kirireel
