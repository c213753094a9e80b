#include "sim/study/exact_sheet.h"

#include <algorithm>

#include "sim/model/alignment.h"
#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

std::vector<Vector3> verticesOf(const std::vector<Tile>& tiles) {
  std::vector<Vector3> vertices;
  for (const Tile& tile : tiles) {
    vertices.insert(vertices.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return vertices;
}

}  // namespace

Scene sheetScene(int side, bool planar, JointFace face, double startAngle) {
  TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.face = face;
  shape.startAngle = startAngle;
  Scene scene;
  scene.model = makeTessellation(shape);
  scene.environment.contacts = ContactFilter::None;
  scene.solver.planar = planar;
  return scene;
}

double openingAngle(const Poses& poses) {
  const Quaternion relative = poses[0].rotation.conjugate() * poses[1].rotation;
  return 2 * std::atan2(relative.vec().norm(), std::abs(relative.w()));
}

VertexError vertexError(const std::vector<Tile>& found, const std::vector<Tile>& wanted) {
  VertexError error;
  std::size_t count = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t k = 0; k < found[i].vertices.size(); ++k, ++count) {
      const double distance = (found[i].vertices[k] - wanted[i].vertices[k]).norm();
      error.max = std::max(error.max, distance);
      error.mean += distance;
    }
  }
  if (count > 0) error.mean /= static_cast<double>(count);
  return error;
}

SheetWay limitOfSteps(const SheetWay& coarse, const SheetWay& middle, const SheetWay& fine) {
  SheetWay limit = fine;
  for (std::size_t k = 0; k < limit.size(); ++k) {
    for (std::size_t i = 0; i < limit[k].size(); ++i) {
      for (std::size_t v = 0; v < limit[k][i].vertices.size(); ++v) {
        Vector3& vertex = limit[k][i].vertices[v];
        vertex = (8 * vertex - 6 * middle[k][i].vertices[v] + coarse[k][i].vertices[v]) / 3;
      }
    }
  }
  return limit;
}

double wayError(const SheetWay& found, const SheetWay& wanted) {
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, vertexError(found[k], wanted[k]).max);
  }
  return largest;
}

VertexError sheetError(int side, double angle, const std::vector<Tile>& found) {
  TessellationShape shape;
  shape.columns = shape.rows = side;
  std::vector<Tile> exact = tessellationTiles(shape, angle);
  const RigidMotion fit = bestRigidMotion(verticesOf(exact), verticesOf(found));
  for (Tile& tile : exact) {
    for (Vector3& vertex : tile.vertices) vertex = fit.apply(vertex);
  }
  return vertexError(found, exact);
}

}  // namespace kirireel
