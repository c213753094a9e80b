// A convex brick and a sphere with the centre c and radius R, in brick axes.
//
// The nearest point of the brick to c lies on a face where c is over the face, else on an edge or
// at a corner. Within the brick, where all heights h = n . (c - f) over the faces are negative, the
// face with the largest height is nearest. The pair overlaps by R - distance. The contact plane is
// the face, or else the sphere's tangent plane at the nearest point. As a convex brick has a
// nearest point only, one contact a pair is enough. C. Ericson, Real-Time Collision Detection,
// 2005, section 5.1, has these cases.
#include "sim/world/sphere_pair.h"

#include <algorithm>
#include <limits>

namespace kirireel {
namespace {

/// Newell's normal: also of a face whose first corners lie in line.
Vector3 normalOf(const std::vector<Vector3>& face) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t k = 0; k < face.size(); ++k) {
    sum += (face[k] - face[0]).cross(face[(k + 1) % face.size()] - face[0]);
  }
  return sum.normalized();
}

// Whether the point projects into the face, seen along its normal.
bool isOverFace(const std::vector<Vector3>& face, const Vector3& normal, const Vector3& point) {
  for (std::size_t k = 0; k < face.size(); ++k) {
    const Vector3 edge = face[(k + 1) % face.size()] - face[k];
    if (edge.cross(point - face[k]).dot(normal) < 0) return false;
  }
  return true;
}

// The point must not lie on the edge, where the direction is not defined.
NearestPoint nearestOnEdge(const Vector3& from, const Vector3& to, const Vector3& point) {
  const Vector3 edge = to - from;
  const double part = std::clamp((point - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
  const Vector3 nearest = from + part * edge;
  const double distance = (point - nearest).norm();
  return {nearest, (point - nearest) / distance, distance, false};
}

}  // namespace

NearestPoint nearestPoint(const std::vector<std::vector<Vector3>>& faces, const Vector3& to) {
  NearestPoint nearest{{}, {}, std::numeric_limits<double>::infinity()};
  NearestPoint within{{}, {}, -std::numeric_limits<double>::infinity()};
  for (const std::vector<Vector3>& face : faces) {
    const Vector3 normal = normalOf(face);
    const double height = normal.dot(to - face[0]);
    const NearestPoint onFace{to - height * normal, normal, height};
    if (height > within.distance) within = onFace;
    // Faces that look away from the centre cannot hold the nearest point, unless the centre is
    // within.
    if (height <= 0) continue;
    if (isOverFace(face, normal, to)) return onFace;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const NearestPoint onEdge = nearestOnEdge(face[k], face[(k + 1) % face.size()], to);
      if (onEdge.distance < nearest.distance) nearest = onEdge;
    }
  }
  return within.distance <= 0 ? within : nearest;
}

SpherePair::SpherePair(int brick, int sphere, const Brick& shape, double radius, double tolerance)
    : brick_(brick),
      sphere_(sphere),
      faces_(brickFaces(shape)),
      radius_(radius),
      tolerance_(tolerance) {}

NearestPoint SpherePair::nearest(const Pose& brick, const Vector3& centre) const {
  return nearestPoint(faces_, brick.rotation.conjugate() * (centre - brick.position));
}

double SpherePair::overlap(const Pose& brick, const Vector3& centre) const {
  return std::max(0.0, radius_ - nearest(brick, centre).distance);
}

// The contact of the nearest feature at a pose, which stays for the step.
Contact SpherePair::contactAt(const Pose& brick, const Vector3& centre) const {
  const NearestPoint near = nearest(brick, centre);
  Contact contact;
  if (near.isOnFace) {
    contact.brickA = sphere_;
    contact.brickB = brick_;
    // The sphere's point that faces the brick; its axes are the world's, since it does not turn.
    contact.pointA = radius_ * (brick.rotation * -near.away);
    contact.pointB = near.point;
    contact.normal = near.away;
  } else {
    contact.brickA = brick_;
    contact.brickB = sphere_;
    contact.pointA = near.point;
    contact.normal = brick.rotation * -near.away;
    contact.pointB = radius_ * contact.normal;
  }
  return contact;
}

double SpherePair::appendViolated(const Pose& start, const Pose& end, const Vector3& centre,
                                  long step, std::vector<Contact>& contacts) {
  const double deep = overlap(end, centre);
  if (deep <= tolerance_) return 0;
  if (givenStep_ != step) given_.clear();
  givenStep_ = step;
  // The start's feature is what the brick came towards. When its contact is there and the overlap
  // stays, the end's feature is another one.
  for (const Pose* pose : {&start, &end}) {
    const Contact contact = contactAt(*pose, centre);
    if (std::find(given_.begin(), given_.end(), contact) != given_.end()) continue;
    given_.push_back(contact);
    contacts.push_back(contact);
    break;
  }
  return deep;
}

}  // namespace kirireel
