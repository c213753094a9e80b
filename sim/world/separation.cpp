#include "sim/world/separation.h"

#include <algorithm>
#include <array>
#include <limits>

namespace kirireel {
namespace {

using Kind = SeparatingPlane::Kind;

// Below this sine two edges count as parallel and span no plane.
constexpr double kParallel = 1e-4;

double lowest(const std::vector<Vector3>& points, const Vector3& direction) {
  double low = std::numeric_limits<double>::infinity();
  for (const Vector3& point : points) low = std::min(low, point.dot(direction));
  return low;
}

void addEdge(Outline& outline, int from, int to) {
  const Vector3 direction = (outline.points[to] - outline.points[from]).normalized();
  for (std::size_t d = 0; d < outline.directions.size(); ++d) {
    if (outline.directions[d].cross(direction).norm() > 1e-9) continue;
    outline.edges[d].push_back({from, to});
    return;
  }
  outline.directions.push_back(direction);
  outline.edges.push_back({{from, to}});
}

/// The edge along direction number d that reaches farthest along `way`.
Outline::Edge farthestEdge(const PlacedOutline& placed, int d, const Vector3& way) {
  const std::vector<Outline::Edge>& edges = placed.outline->edges[d];
  return *std::max_element(edges.begin(), edges.end(),
                           [&](const Outline::Edge& x, const Outline::Edge& y) {
                             return placed.points[x.from].dot(way) < placed.points[y.from].dot(way);
                           });
}

/// The points of two skew lines nearest to each other, as parts of the way from `from` to `to`.
std::array<double, 2> nearestOnLines(const Vector3& fromA, const Vector3& wayA,
                                     const Vector3& fromB, const Vector3& wayB) {
  const Vector3 between = fromB - fromA;
  const Vector3 normal = wayA.cross(wayB);
  const double squared = normal.squaredNorm();
  return {between.cross(wayB).dot(normal) / squared, between.cross(wayA).dot(normal) / squared};
}

/// Contacts of one body's points against a face of the other.
void appendFaceContacts(int pointBrick, int faceBrick, int face, const PlacedOutline& endPoints,
                        const PlacedOutline& endFace, double reach,
                        std::vector<Contact>& contacts) {
  const Outline& faces = *endFace.outline;
  const int facePoint = faces.facePoints[face];
  const Vector3& normal = endFace.normals[face];
  for (std::size_t p = 0; p < endPoints.points.size(); ++p) {
    if (normal.dot(endPoints.points[p] - endFace.points[facePoint]) > reach) continue;
    contacts.push_back({pointBrick, faceBrick, endPoints.outline->points[p],
                        faces.points[facePoint], faces.normals[face]});
  }
}

/// The contact of an edge of A against an edge of B, where they pass each other most closely.
void appendEdgeContact(const SeparatingPlane& plane, int brickA, int brickB,
                       const PlacedOutline& startA, const PlacedOutline& startB,
                       std::vector<Contact>& contacts) {
  const Vector3 normal = planeNormal(plane, startA, startB);
  const Outline::Edge edgeA = farthestEdge(startA, plane.a, -normal);
  const Outline::Edge edgeB = farthestEdge(startB, plane.b, normal);
  const auto [s, t] = nearestOnLines(
      startA.points[edgeA.from], startA.points[edgeA.to] - startA.points[edgeA.from],
      startB.points[edgeB.from], startB.points[edgeB.to] - startB.points[edgeB.from]);
  const auto along = [](const Outline& outline, const Outline::Edge& edge, double part) {
    return Vector3(outline.points[edge.from] +
                   part * (outline.points[edge.to] - outline.points[edge.from]));
  };
  contacts.push_back({brickA, brickB, along(*startA.outline, edgeA, std::clamp(s, 0.0, 1.0)),
                      along(*startB.outline, edgeB, std::clamp(t, 0.0, 1.0)),
                      startB.pose.rotation.conjugate() * normal});
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
    addEdge(outline, k, next);
    addEdge(outline, count + k, count + next);
    addEdge(outline, k, count + k);
  }
  return outline;
}

void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed) {
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

void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& startA, const PlacedOutline& startB,
                         const PlacedOutline& endA, const PlacedOutline& endB, double reach,
                         std::vector<Contact>& contacts) {
  switch (plane.kind) {
    case Kind::FaceOfA:
      return appendFaceContacts(brickB, brickA, plane.a, endB, endA, reach, contacts);
    case Kind::FaceOfB:
      return appendFaceContacts(brickA, brickB, plane.b, endA, endB, reach, contacts);
    case Kind::Edges:
      return appendEdgeContact(plane, brickA, brickB, startA, startB, contacts);
  }
}

}  // namespace kirireel
