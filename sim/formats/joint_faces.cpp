// Selects the faces of joints from the deployed shape.
//
// A brick is a tile thickened along its normal. Two bricks that fold towards each other on the side
// of their normals collide there unless the joint is on that side. With normals n_a and n_b and the
// unit direction e of the common edge, the first tile on its left,
//   s = (n_a x n_b) . e          the sine of the fold: s > 0 a mountain, s < 0 a valley
// decides between top and bottom. Tiles with only a common vertex have no common edge. There the
// direction between the centroids replaces the normal of the edge, and normals that converge along
// it are a valley. PyKirigami points the edge from its lower to its higher vertex number, not
// anticlockwise. Its sign therefore depends on the numbering. This rule is kept for files made for
// it.
#include "sim/formats/joint_faces.h"

#include <optional>
#include <utility>

#include "sim/formats/written_digits.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::formats {
namespace {

// Below this sine between normals a fold is flat, and its sign comes from rounding.
constexpr double kFlatFold = 1e-6;

/// The common edge of a joint's tiles: two vertices of the first tile, the joint's own first.
using SharedEdge = std::pair<int, int>;

// The previous (-1) or next (+1) vertex around the tile.
int neighbour(const model::Tile& tile, int vertex, int step) {
  const int count = static_cast<int>(tile.vertices.size());
  return (vertex + step + count) % count;
}

std::optional<SharedEdge> sharedEdge(const model::Joint& joint, const model::Tile& a,
                                     const model::Tile& b, double tolerance) {
  // Four pairs of edges can coincide: the neighbours on either side of both corners.
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

/// Direction of the edge: anticlockwise around the tile, or from the lower to the higher number.
Vector3 edgeDirection(const model::Tile& tile, const SharedEdge& edge, FaceRule rule) {
  const Vector3 away = tile.vertices[edge.second] - tile.vertices[edge.first];
  const bool forward = rule == FaceRule::PyKirigami ? edge.first < edge.second
                                                    : neighbour(tile, edge.first, 1) == edge.second;
  return (forward ? away : Vector3(-away)).normalized();
}

// The face of one joint, from the fold about the common edge or from converging normals.
model::JointFace faceOf(const model::Joint& joint, const std::vector<model::Tile>& tiles,
                        FaceRule rule, double tolerance) {
  const model::Tile& a = tiles[joint.a.tile];
  const model::Tile& b = tiles[joint.b.tile];
  const Vector3 normalA = model::tileNormal(a);
  const Vector3 normalB = model::tileNormal(b);
  if (const std::optional<SharedEdge> edge = sharedEdge(joint, a, b, tolerance)) {
    const double sine = normalA.cross(normalB).dot(edgeDirection(a, *edge, rule));
    const bool top = rule == FaceRule::PyKirigami ? sine > kFlatFold : sine < -kFlatFold;
    return top ? model::JointFace::Top : model::JointFace::Bottom;
  }
  const Vector3 across = (model::tileCentroid(b) - model::tileCentroid(a)).normalized();
  const bool converging = (normalB - normalA).dot(across) < -kFlatFold;
  return converging ? model::JointFace::Top : model::JointFace::Bottom;
}

}  // namespace

void chooseJointFaces(model::Model& model, FaceRule rule) {
  const double tolerance = samePlaceTolerance(model.tiles);
  const std::vector<model::Tile>& deployed = model.target ? *model.target : model.tiles;
  const std::optional<model::SheetFrame> frame = model::sheetFrame(model.tiles, tolerance);
  const bool planar = frame && model::isParallel(*frame, deployed, tolerance);
  for (model::Joint& joint : model.joints) {
    if (joint.kind != model::JointKind::Pivot) continue;
    joint.face = planar ? model::JointFace::Both : faceOf(joint, deployed, rule, tolerance);
  }
}

}  // namespace kirireel::formats
