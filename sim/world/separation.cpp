#include "sim/world/separation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace kirireel {
namespace {

using Kind = SeparatingPlane::Kind;

// Below this sine two edges count as parallel and span no plane.
constexpr double kParallel = 1e-4;
// This part of an edge's length from its end counts as the end.
constexpr double kEndPart = 1e-6;

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
void appendFaceContacts(int pointBrick, int faceBrick, int face, const Outline& points,
                        const Outline& faces, std::vector<Contact>& contacts) {
  for (const Vector3& point : points.points) {
    contacts.push_back(
        {pointBrick, faceBrick, point, faces.points[faces.facePoints[face]], faces.normals[face]});
  }
}

/// Where the edges that span a plane pass each other most closely.
struct Crossing {
  Outline::Edge edgeA, edgeB;
  std::array<double, 2> parts;  // of the way along A's and B's edge
};

Crossing crossingOf(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  const Vector3 normal = planeNormal(plane, a, b);
  Crossing crossing{farthestEdge(a, plane.a, -normal), farthestEdge(b, plane.b, normal), {}};
  const auto& [edgeA, edgeB, parts] = crossing;
  crossing.parts = nearestOnLines(a.points[edgeA.from], a.points[edgeA.to] - a.points[edgeA.from],
                                  b.points[edgeB.from], b.points[edgeB.to] - b.points[edgeB.from]);
  return crossing;
}

bool isEnd(double part) {
  return std::abs(part) < kEndPart || std::abs(part - 1) < kEndPart;
}

/// The point a part of the way along an edge.
Vector3 along(const std::vector<Vector3>& points, const Outline::Edge& edge, double part) {
  return points[edge.from] + part * (points[edge.to] - points[edge.from]);
}

void appendEdgeContacts(const SeparatingPlane& plane, int brickA, int brickB,
                        const PlacedOutline& a, const PlacedOutline& b,
                        std::vector<Contact>& contacts) {
  const Crossing crossing = crossingOf(plane, a, b);
  const std::vector<Vector3>& pointsA = a.outline->points;
  const std::vector<Vector3>& pointsB = b.outline->points;
  Contact contact{brickA, brickB, along(pointsA, crossing.edgeA, crossing.parts[0]),
                  along(pointsB, crossing.edgeB, crossing.parts[1]),
                  b.outline->directions[plane.b]};
  contact.isEdge = true;
  contact.edgeA = plane.sign * a.outline->directions[plane.a];
  if (!isEnd(crossing.parts[0]) || !isEnd(crossing.parts[1])) {
    contacts.push_back(contact);
    return;
  }
  // The edges themselves cannot part: the other points must stay on their sides.
  for (int p = 0; p < static_cast<int>(pointsA.size()); ++p) {
    if (p == crossing.edgeA.from || p == crossing.edgeA.to) continue;
    contacts.push_back(contact);
    contacts.back().pointA = pointsA[p];
  }
  for (int p = 0; p < static_cast<int>(pointsB.size()); ++p) {
    if (p == crossing.edgeB.from || p == crossing.edgeB.to) continue;
    contacts.push_back(contact);
    contacts.back().pointB = pointsB[p];
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

bool canCarry(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  if (plane.kind != Kind::Edges) return true;
  const auto [edgeA, edgeB, parts] = crossingOf(plane, a, b);
  const auto within = [](double part) { return part > -kEndPart && part < 1 + kEndPart; };
  if (!within(parts[0]) || !within(parts[1])) return false;
  // The edges must be what reaches farthest towards the other brick.
  const Vector3 normal = planeNormal(plane, a, b);
  const double between = normal.dot(a.points[edgeA.from] - b.points[edgeB.from]);
  const double length = (a.points[edgeA.to] - a.points[edgeA.from]).norm();
  return between <= separation(plane, a, b) + kEndPart * length;
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
