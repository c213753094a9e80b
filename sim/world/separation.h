/// Planes between two bricks: which of their faces and edges keep them apart.
#pragma once

#include <vector>

#include "sim/base/geometry.h"
#include "sim/base/state_tape.h"
#include "sim/brick/brick.h"
#include "sim/brick/contact.h"

namespace kirireel {

/// A brick as the points, outward face normals and edges of a convex body, in brick axes. In a
/// planar scene only the outline counts: the bottom's vertices and the side faces.
struct Outline {
  std::vector<Vector3> points;
  std::vector<Vector3> normals;     ///< one a face, unit
  std::vector<int> facePoints;      ///< a point on each face, as an index into points
  std::vector<Vector3> directions;  ///< of edges, unit, parallel ones once
};

/// `brick` is convex. O(n^2) in its corners, for the directions of its edges.
Outline makeOutline(const Brick& brick, bool planar);

/// An outline at a pose, in world axes.
struct PlacedOutline {
  const Outline* outline = nullptr;
  Pose pose;
  std::vector<Vector3> points;
  std::vector<Vector3> normals;
  std::vector<Vector3> directions;
};

/// Replaces `placed` by the outline at a pose.
void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed);

/// A direction that may separate two bricks A and B, tied to their features so that it can be
/// followed from pose to pose.
struct SeparatingPlane {
  enum class Kind { FaceOfA, FaceOfB, Edges };
  Kind kind = Kind::FaceOfB;
  int a = 0;        ///< face or edge direction of A
  int b = 0;        ///< face or edge direction of B
  double sign = 1;  ///< of the product of edge directions

  bool operator==(const SeparatingPlane&) const = default;

  void transfer(StateTape& tape) { tape.transfer(kind, a, b, sign); }
};

/// All planes to be tried for a pair: the faces of both, and in space the products of their edges.
std::vector<SeparatingPlane> separatingPlanes(const Outline& a, const Outline& b);

/// The unit normal of a plane from B towards A, world axes; zero where two edges are parallel.
Vector3 planeNormal(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Distance between A and B along a plane's normal, metres: negative where they overlap along it,
/// minus infinity where the plane does not exist.
/// O(points of A and B).
double separation(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// Whether contacts should hold A and B on their sides of a plane: not where two edges are nearly
/// parallel, since their plane turns too fast.
bool isSteady(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b);

/// The contacts that keep A and B (brick numbers as given) on their sides of a plane: every point
/// of one against a face of the other, or every point of either against the other's farthest point
/// along the normal of two edges.
void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& a, const PlacedOutline& b,
                         std::vector<Contact>& contacts);

}  // namespace kirireel
