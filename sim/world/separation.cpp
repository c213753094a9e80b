// Planes between two convex bodies A and B by the separating axis theorem.
//
// Two convex polyhedra that do not meet are separated by a plane parallel to a face of either, or
// parallel to an edge of each (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996). With
// the unit normal n from B towards A,
//   s = min over A of (p . n) - max over B of (p . n)             metres
// is the separation: positive where they are apart, negative where they overlap along n. For a face
// of B, n is its outward normal, and the maximum over B is reached on the face, so that one point
// of it serves. For edges, n = +-(e_A x e_B) / |e_A x e_B|: both signs are tried as planes of their
// own, so that a plane keeps its side when it is followed.
//
// A prism over a polygon with k corners has k + 2 faces and up to k + 1 edge directions. In the
// plane only its k side faces count.
#include "sim/world/separation.h"

#include <algorithm>
#include <limits>

namespace kirireel {
namespace {

using Kind = SeparatingPlane::Kind;

// Below this sine two edges span no plane.
constexpr double kParallel = 1e-6;
// Below this sine the plane of two edges turns too fast to be held.
constexpr double kSteady = 0.05;
// Points that reach equally far to this part of an edge tie.
constexpr double kTie = 1e-9;

// The least projection of the points on a direction.
double lowest(const std::vector<Vector3>& points, const Vector3& direction) {
  double low = std::numeric_limits<double>::infinity();
  for (const Vector3& point : points) low = std::min(low, point.dot(direction));
  return low;
}

void addDirection(Outline& outline, const Vector3& edge) {
  const Vector3 direction = edge.normalized();
  const bool known =
      // Parallel edges span the same planes, so that they count once.
      std::any_of(outline.directions.begin(), outline.directions.end(),
                  [&](const Vector3& other) { return other.cross(direction).norm() < 1e-9; });
  if (!known) outline.directions.push_back(direction);
}

/// The point that reaches farthest along a direction; of both ends of an edge across it the first.
const Vector3& farthest(const PlacedOutline& placed, const Vector3& direction, int& index) {
  // Both ends of an edge across the direction reach equally far; rounding must not choose between
  // them.
  const double tie = kTie * (placed.points[1] - placed.points[0]).norm();
  index = 0;
  for (int p = 1; p < static_cast<int>(placed.points.size()); ++p) {
    if (placed.points[p].dot(direction) > placed.points[index].dot(direction) + tie) index = p;
  }
  return placed.outline->points[index];
}

/// Contacts of one body's points against a face of the other.
void appendFaceContacts(int pointBrick, int faceBrick, int face, const Outline& points,
                        const Outline& faces, std::vector<Contact>& contacts) {
  for (const Vector3& point : points.points) {
    contacts.push_back(
        {pointBrick, faceBrick, point, faces.points[faces.facePoints[face]], faces.normals[face]});
  }
}

/// Contacts of all points of either brick against the other's farthest point, along the normal of
/// an edge of each.
void appendEdgeContacts(const SeparatingPlane& plane, int brickA, int brickB,
                        const PlacedOutline& a, const PlacedOutline& b,
                        std::vector<Contact>& contacts) {
  const Vector3 normal = planeNormal(plane, a, b);
  int nearestA = 0;
  int nearestB = 0;
  Contact contact{brickA, brickB, farthest(a, -normal, nearestA), farthest(b, normal, nearestB),
                  b.outline->directions[plane.b]};
  contact.isEdge = true;
  contact.edgeA = plane.sign * a.outline->directions[plane.a];
  const Vector3 pointA = contact.pointA;
  for (const Vector3& point : a.outline->points) {
    contact.pointA = point;
    contacts.push_back(contact);
  }
  contact.pointA = pointA;
  for (int p = 0; p < static_cast<int>(b.outline->points.size()); ++p) {
    // That pair of points stands among those of A already.
    if (p == nearestB) continue;
    contact.pointB = b.outline->points[p];
    contacts.push_back(contact);
  }
}

}  // namespace

Outline makeOutline(const Brick& brick, bool planar) {
  Outline outline;
  const int count = static_cast<int>(brick.bottom.size());
  outline.points = brick.bottom;
  if (!planar) {
    outline.points.insert(outline.points.end(), brick.top.begin(), brick.top.end());
    outline.normals = {-brick.normal, brick.normal};
    outline.facePoints = {0, count};
  }
  for (int k = 0; k < count; ++k) {
    const int next = (k + 1) % count;
    const Vector3 edge = brick.bottom[next] - brick.bottom[k];
    outline.normals.push_back(edge.cross(brick.normal).normalized());
    outline.facePoints.push_back(k);
    if (planar) continue;
    addDirection(outline, edge);
    addDirection(outline, brick.normal);
  }
  return outline;
}

// Memory of `placed` is used again, as this is called for each pair in each step.
void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed) {
  // One matrix for all points is cheaper than a quaternion for each.
  const Matrix3 R = pose.rotation.toRotationMatrix();
  const auto turn = [&](const std::vector<Vector3>& from, std::vector<Vector3>& to) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) to[i] = R * from[i];
  };
  placed.outline = &outline;
  placed.pose = pose;
  turn(outline.points, placed.points);
  turn(outline.normals, placed.normals);
  turn(outline.directions, placed.directions);
  for (Vector3& point : placed.points) point += pose.position;
}

// Faces come first: they are cheaper, and keep most pairs apart.
std::vector<SeparatingPlane> separatingPlanes(const Outline& a, const Outline& b) {
  std::vector<SeparatingPlane> planes;
  for (int f = 0; f < static_cast<int>(a.normals.size()); ++f) {
    planes.push_back({Kind::FaceOfA, f, 0, 1});
  }
  for (int f = 0; f < static_cast<int>(b.normals.size()); ++f) {
    planes.push_back({Kind::FaceOfB, 0, f, 1});
  }
  for (int i = 0; i < static_cast<int>(a.directions.size()); ++i) {
    for (int j = 0; j < static_cast<int>(b.directions.size()); ++j) {
      planes.push_back({Kind::Edges, i, j, 1});
      planes.push_back({Kind::Edges, i, j, -1});
    }
  }
  return planes;
}

Vector3 planeNormal(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  switch (plane.kind) {
    case Kind::FaceOfA:
      return -a.normals[plane.a];
    case Kind::FaceOfB:
      return b.normals[plane.b];
    case Kind::Edges:
      break;
  }
  const Vector3 product = a.directions[plane.a].cross(b.directions[plane.b]);
  const double length = product.norm();
  return length < kParallel ? Vector3::Zero() : Vector3(plane.sign / length * product);
}

double separation(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  if (plane.kind == Kind::FaceOfA) {
    const Vector3& normal = a.normals[plane.a];
    return lowest(b.points, normal) - normal.dot(a.points[a.outline->facePoints[plane.a]]);
  }
  if (plane.kind == Kind::FaceOfB) {
    const Vector3& normal = b.normals[plane.b];
    return lowest(a.points, normal) - normal.dot(b.points[b.outline->facePoints[plane.b]]);
  }
  const Vector3 normal = planeNormal(plane, a, b);
  if (normal.isZero(0)) return -std::numeric_limits<double>::infinity();
  return lowest(a.points, normal) + lowest(b.points, -normal);
}

bool isSteady(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  return plane.kind != Kind::Edges ||
         a.directions[plane.a].cross(b.directions[plane.b]).norm() > kSteady;
}

void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& a, const PlacedOutline& b,
                         std::vector<Contact>& contacts) {
  switch (plane.kind) {
    case Kind::FaceOfA:
      return appendFaceContacts(brickB, brickA, plane.a, *b.outline, *a.outline, contacts);
    case Kind::FaceOfB:
      return appendFaceContacts(brickA, brickB, plane.b, *a.outline, *b.outline, contacts);
    case Kind::Edges:
      return appendEdgeContacts(plane, brickA, brickB, a, b, contacts);
  }
}

}  // namespace kirireel
