// Tiles thickened to prisms: shape, mass, inertia, pivots.
//
// A prism over a polygon with area S (m^2) and thickness t (m) has, for mass 1, the covariance
//   C = (1/S) integral of x x^T over the area + t^2 / 12 n n^T          m^2
// about its centre of mass, with the unit normal n. The second term is the covariance of a rod
// along n. The inertia is I = trace(C) 1 - C, times the mass. The integral over the polygon is the
// exact signed sum over the triangles between its centroid and its edges. Concave polygons need no
// triangulation.
//
// A fixed joint becomes three point joints. Three non-collinear points constrain all six relative
// degrees of freedom. Their nine rows are redundant, which the solver handles.
#include "sim/brick/brick.h"

#include <cmath>
#include <iterator>
#include <numeric>

namespace kirireel::brick {
namespace {

Vector3 centreOfMass(const model::Tile& tile, double thickness) {
  return model::tileCentroid(tile) + 0.5 * thickness * model::tileNormal(tile);
}

/// The mean of x x^T over the tile's area, x from the tile's centroid. Exact for each triangle
/// (0, a, b): the integral of x x^T is area / 12 (a a^T + b b^T + (a + b) (a + b)^T).
Matrix3 areaCovariance(const model::Tile& tile) {
  const Vector3 centroid = model::tileCentroid(tile);
  const Vector3 normal = model::tileNormal(tile);
  Matrix3 sum = Matrix3::Zero();
  double doubledArea = 0;
  for (size_t k = 0; k < tile.vertices.size(); ++k) {
    const Vector3 a = tile.vertices[k] - centroid;
    const Vector3 b = tile.vertices[(k + 1) % tile.vertices.size()] - centroid;
    // Twice the triangle's signed area.
    const double weight = a.cross(b).dot(normal);
    const Vector3 c = a + b;
    sum += weight / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose());
    doubledArea += weight;
  }
  return sum / doubledArea;
}

/// The inertia of a prism of mass 1: its covariance is the tile's plus thickness^2 / 12 along the
/// normal, and inertia = trace(covariance) - covariance.
Matrix3 unitInertia(const model::Tile& tile, double thickness) {
  const Vector3 normal = model::tileNormal(tile);
  const Matrix3 covariance =
      areaCovariance(tile) + thickness * thickness / 12.0 * normal * normal.transpose();
  return covariance.trace() * Matrix3::Identity() - covariance;
}

Pivot makePivot(const model::Joint& joint, int jointIndex, model::JointFace face,
                const std::vector<Brick>& bricks) {
  const auto point = [&](const model::Corner& corner) {
    const Brick& brick = bricks[corner.tile];
    return face == model::JointFace::Top ? brick.top[corner.vertex] : brick.bottom[corner.vertex];
  };
  // A joint only on the top is not a second pivot.
  const bool isUpper = joint.face == model::JointFace::Both && face == model::JointFace::Top;
  return {joint.a.tile, joint.b.tile,   point(joint.a), point(joint.b),    jointIndex, 0,
          isUpper,      joint.a.vertex, joint.b.vertex, joint.isWithinTile};
}

Pivot makeLinkPivot(const model::Joint& joint, int jointIndex, const std::vector<Brick>& bricks) {
  Pivot pivot = makePivot(joint, jointIndex, model::JointFace::Bottom, bricks);
  pivot.distance = joint.apart.norm();
  // Linked bricks share no corner, so no pivot zone is cut off.
  pivot.cornerA = pivot.cornerB = kNoCorner;
  return pivot;
}

/// The corner farthest from the line through the first edge.
std::size_t cornerAcrossFirstEdge(const std::vector<Vector3>& corners) {
  const Vector3 edge = corners[1] - corners[0];
  std::size_t farthest = 2;
  for (std::size_t k = 3; k < corners.size(); ++k) {
    const auto distance = [&](std::size_t i) { return edge.cross(corners[i] - corners[0]).norm(); };
    if (distance(k) > distance(farthest)) farthest = k;
  }
  return farthest;
}

/// Three non-collinear common points hold two bricks together: three corners of A, which B carries
/// along.
void appendFixedPivots(const model::Joint& joint, int jointIndex, const std::vector<Brick>& bricks,
                       std::vector<Pivot>& pivots) {
  const std::vector<Vector3>& corners = bricks[joint.a.tile].bottom;
  // Vector from the centre of brick B to that of brick A at the start. The axes are parallel then,
  // so a point r of A is r plus this vector in brick B.
  const Vector3 betweenCentres =
      corners[joint.a.vertex] - joint.apart - bricks[joint.b.tile].bottom[joint.b.vertex];
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}, cornerAcrossFirstEdge(corners)}) {
    pivots.push_back(
        {joint.a.tile, joint.b.tile, corners[k], corners[k] - betweenCentres, jointIndex});
  }
}

}  // namespace

Brick makeBrick(const model::Tile& tile, const BrickRule& rule) {
  Brick brick;
  brick.normal = model::tileNormal(tile);
  brick.thickness = rule.thickness;
  brick.volume = model::tileArea(tile) * rule.thickness;
  brick.mass = rule.mass == MassRule::Unit ? 1.0 : rule.density * brick.volume;
  brick.inertia = brick.mass * unitInertia(tile, rule.thickness);
  const Vector3 centre = centreOfMass(tile, rule.thickness);
  for (const Vector3& vertex : tile.vertices) {
    // Brick axes are parallel to the world axes at the start: only the origin moves.
    brick.bottom.push_back(vertex - centre);
    brick.top.push_back(brick.bottom.back() + rule.thickness * brick.normal);
  }
  brick.parts = partsOfBottom(brick.bottom, brick.normal);
  return brick;
}

std::vector<model::PolygonPart> partsOfBottom(const std::vector<Vector3>& bottom,
                                              const Vector3& normal) {
  // Readers refuse such tiles. They can only come from a damaged trajectory, and would be slow.
  if (bottom.size() > model::kMaxTileVertices || model::isConvexPolygon(bottom, normal)) return {};
  return model::convexParts(bottom, normal);
}

std::vector<BrickPiece> convexPieces(const Brick& brick, int number) {
  std::vector<BrickPiece> pieces;
  if (brick.parts.empty()) {
    model::PolygonPart all(brick.bottom.size());
    std::iota(all.begin(), all.end(), 0);
    pieces.push_back({brick, number, 0, std::move(all)});
  }
  for (std::size_t k = 0; k < brick.parts.size(); ++k) {
    BrickPiece& piece =
        pieces.emplace_back(BrickPiece{brick, number, static_cast<int>(k), brick.parts[k]});
    piece.shape.parts.clear();
    piece.shape.bottom.clear();
    piece.shape.top.clear();
    for (const int corner : brick.parts[k]) {
      piece.shape.bottom.push_back(brick.bottom[corner]);
      piece.shape.top.push_back(brick.top[corner]);
    }
  }
  return pieces;
}

std::vector<BrickPiece> convexPieces(const std::vector<Brick>& bricks) {
  std::vector<BrickPiece> pieces;
  pieces.reserve(bricks.size());
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    std::vector<BrickPiece> own = convexPieces(bricks[i], static_cast<int>(i));
    std::move(own.begin(), own.end(), std::back_inserter(pieces));
  }
  return pieces;
}

std::vector<Brick> makeBricks(const std::vector<model::Tile>& tiles, const BrickRule& rule) {
  std::vector<Brick> bricks;
  bricks.reserve(tiles.size());
  for (const model::Tile& tile : tiles) bricks.push_back(makeBrick(tile, rule));
  return bricks;
}

Poses startPoses(const std::vector<model::Tile>& tiles, const std::vector<Brick>& bricks) {
  Poses poses(tiles.size());
  for (size_t i = 0; i < tiles.size(); ++i) {
    poses[i].position = centreOfMass(tiles[i], bricks[i].thickness);
  }
  return poses;
}

std::vector<std::vector<Vector3>> brickFaces(const Brick& brick) {
  const size_t count = brick.bottom.size();
  std::vector<std::vector<Vector3>> faces;
  faces.reserve(count + 2);
  // The bottom faces against the normal, so its vertices are reversed.
  faces.emplace_back(brick.bottom.rbegin(), brick.bottom.rend());
  faces.push_back(brick.top);
  for (size_t k = 0; k < count; ++k) {
    const size_t next = (k + 1) % count;
    faces.push_back({brick.bottom[k], brick.bottom[next], brick.top[next], brick.top[k]});
  }
  return faces;
}

std::vector<model::Tile> bottomTiles(const std::vector<Brick>& bricks, const Poses& poses) {
  std::vector<model::Tile> tiles(bricks.size());
  for (size_t i = 0; i < bricks.size(); ++i) {
    for (const Vector3& point : bricks[i].bottom) {
      tiles[i].vertices.push_back(poses[i].apply(point));
    }
  }
  return tiles;
}

// The distance of two points changes only by motion along the line through them.
PivotRows pivotRows(const Pivot& pivot, const Vector3& apart) {
  PivotRows rows;
  if (pivot.joinsPoints()) {
    rows.gaps = apart;
  } else {
    rows.axes.row(0) = apart.normalized();
    rows.gaps.x() = apart.norm() - pivot.distance;
  }
  return rows;
}

double pivotGap(const Pivot& pivot, const Vector3& apart) {
  return std::abs(apart.norm() - pivot.distance);
}

double pivotGap(const Pivot& pivot, const Poses& poses) {
  const Vector3 a = poses[pivot.brickA].apply(pivot.pointA);
  const Vector3 b = poses[pivot.brickB].apply(pivot.pointB);
  return pivotGap(pivot, a - b);
}

std::vector<Pivot> makePivots(const std::vector<model::Joint>& joints,
                              const std::vector<Brick>& bricks) {
  std::vector<Pivot> pivots;
  for (size_t i = 0; i < joints.size(); ++i) {
    const int index = static_cast<int>(i);
    if (joints[i].kind == model::JointKind::Fixed) {
      appendFixedPivots(joints[i], index, bricks, pivots);
      continue;
    }
    if (joints[i].kind == model::JointKind::Link) {
      pivots.push_back(makeLinkPivot(joints[i], index, bricks));
      continue;
    }
    // The bottom pivot comes before the top one, which planar scenes omit.
    if (joints[i].face != model::JointFace::Top) {
      pivots.push_back(makePivot(joints[i], index, model::JointFace::Bottom, bricks));
    }
    if (joints[i].face != model::JointFace::Bottom) {
      pivots.push_back(makePivot(joints[i], index, model::JointFace::Top, bricks));
    }
  }
  return pivots;
}

double meanEdge(const Brick& brick) {
  double sum = 0;
  const size_t count = brick.bottom.size();
  for (size_t k = 0; k < count; ++k) {
    sum += (brick.bottom[(k + 1) % count] - brick.bottom[k]).norm();
  }
  return sum / static_cast<double>(count);
}

}  // namespace kirireel::brick
