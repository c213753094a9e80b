// Measures against the exact motion of rotating squares.
//
// The sheet of squares has one way to move that keeps all joints closed, and it is known in closed
// form (tessellation.h): from the opening angle between two tiles follows the place of every
// vertex, up to a rigid motion. So a state is judged at its own angle, after the exact sheet has
// been moved onto it by the best fit: what is left is an error of shape, whatever the run's error
// in time may be.
//
// The error in time is judged against a limit of ever shorter steps. For a method of first order,
// x(h) = x + c_1 h + c_2 h^2 + O(h^3), and from the steps h, h/2, h/4
//   x = (8 x(h/4) - 6 x(h/2) + x(h)) / 3 + O(h^3)
// which is Richardson's extrapolation, twice (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
// Differential Equations I, II.9).
#include "sim/study/exact_sheet.h"

#include <algorithm>

#include "sim/model/alignment.h"
#include "sim/model/tessellation.h"

namespace kirireel {
namespace {

// All vertices one after the other, in the order of the tiles: what the best fit takes.
std::vector<Vector3> verticesOf(const std::vector<Tile>& tiles) {
  std::vector<Vector3> vertices;
  for (const Tile& tile : tiles) {
    vertices.insert(vertices.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return vertices;
}

}  // namespace

// A sheet of `side` x `side` squares without contacts, so that joints and springs alone act.
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

// The turn of tile 1 against tile 0, radians from 0 to pi. In space too it is one angle, since the
// closed motion turns tiles about the vertical alone.
double openingAngle(const Poses& poses) {
  const Quaternion relative = poses[0].rotation.conjugate() * poses[1].rotation;
  // The angle of a unit quaternion, from 0 to pi; precise for small angles, where an arc cosine is
  // not.
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

// All three ways must have states at the same times. The vertices are extrapolated one by one:
// their paths are smooth in the step.
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

// The largest error of any vertex at any of the times, metres. `wanted` must have at least as many
// states as `found`, which may have ended early.
double wayError(const SheetWay& found, const SheetWay& wanted) {
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, vertexError(found[k], wanted[k]).max);
  }
  return largest;
}

// The exact sheet is moved as a whole, which takes away where the sheet stands and how it is
// turned.
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
