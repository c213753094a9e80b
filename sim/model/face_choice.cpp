// Faces of joints from the shape of the deployed sheet.
//
// A brick is a tile thickened along its normal, so that two bricks that fold towards each other on
// the side of their normals collide there, unless they are joined on that side. With normals n_a
// and n_b and the unit direction e of the shared edge, the first tile on its left,
//   s = (n_a x n_b) . e          the sine of the fold: s > 0 a mountain, s < 0 a valley
// decides between top and bottom. Tiles that meet at one vertex only have no edge. There the
// direction between the centroids stands for the normal of the edge: normals that converge along it
// are a valley. PyKirigami takes the edge from its lower to its higher vertex number in place of
// anticlockwise, so that its sign depends on the numbering: that rule is kept for files that were
// made for it.
#include "sim/model/face_choice.h"

#include <optional>
#include <utility>

#include "sim/model/rounding.h"

namespace kirireel {
namespace {

// Below this sine between normals a fold is flat, and its sign is rounding.
constexpr double kFlatFold = 1e-6;

/// The edge of the first tile along which a joint's tiles lie side by side: two of its vertices,
/// the joint's own first.
using SharedEdge = std::pair<int, int>;

// The vertex before (-1) or after (+1) one, round the tile.
int neighbour(const Tile& tile, int vertex, int step) {
  const int count = static_cast<int>(tile.vertices.size());
  return (vertex + step + count) % count;
}

std::optional<SharedEdge> sharedEdge(const Joint& joint, const Tile& a, const Tile& b,
                                     double tolerance) {
  // The neighbours on either side of both corners: four pairs of edges can coincide.
  for (const int stepA : {1, -1}) {
    for (const int stepB : {1, -1}) {
      const int endA = neighbour(a, joint.a.vertex, stepA);
      const int endB = neighbour(b, joint.b.vertex, stepB);
      const double gap = (a.vertices[endA] - b.vertices[endB]).norm();
      if (gap <= tolerance) return SharedEdge{joint.a.vertex, endA};
    }
  }
  return std::nullopt;
}

/// The edge's direction, anticlockwise round the tile or from the lower to the higher number.
Vector3 edgeDirection(const Tile& tile, const SharedEdge& edge, FaceRule rule) {
  const Vector3 away = tile.vertices[edge.second] - tile.vertices[edge.first];
  const bool forward = rule == FaceRule::PyKirigami ? edge.first < edge.second
                                                    : neighbour(tile, edge.first, 1) == edge.second;
  return (forward ? away : Vector3(-away)).normalized();
}

// The face of one joint, from the fold about its edge or from how the normals converge.
JointFace faceOf(const Joint& joint, const std::vector<Tile>& tiles, FaceRule rule,
                 double tolerance) {
  const Tile& a = tiles[joint.a.tile];
  const Tile& b = tiles[joint.b.tile];
  const Vector3 normalA = tileNormal(a);
  const Vector3 normalB = tileNormal(b);
  if (const std::optional<SharedEdge> edge = sharedEdge(joint, a, b, tolerance)) {
    const double sine = normalA.cross(normalB).dot(edgeDirection(a, *edge, rule));
    const bool top = rule == FaceRule::PyKirigami ? sine > kFlatFold : sine < -kFlatFold;
    return top ? JointFace::Top : JointFace::Bottom;
  }
  const Vector3 across = (tileCentroid(b) - tileCentroid(a)).normalized();
  const bool converging = (normalB - normalA).dot(across) < -kFlatFold;
  return converging ? JointFace::Top : JointFace::Bottom;
}

}  // namespace

void chooseJointFaces(Model& model, FaceRule rule) {
  const double tolerance = samePlaceTolerance(model.tiles);
  const std::vector<Tile>& deployed = model.target ? *model.target : model.tiles;
  const bool planar = liesFlat(model.tiles, tolerance) && liesFlat(deployed, tolerance);
  for (Joint& joint : model.joints) {
    if (joint.kind != JointKind::Pivot) continue;
    joint.face = planar ? JointFace::Both : faceOf(joint, deployed, rule, tolerance);
  }
}

}  // namespace kirireel
