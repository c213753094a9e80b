// Comparison with the exact motion of rotating squares.
//
// The sheet of squares has one motion that keeps all joints closed. It is known in closed form
// (lattice.h): the opening angle between two tiles determines the position of every vertex, up to a
// rigid motion. A state is therefore compared at its own angle, after the exact sheet has been
// moved onto it by the best fit. The remaining difference is an error of shape. It does not depend
// on the run's error in time.
//
// The reference for the error in time is the limit of ever shorter steps. For a method of first
// order, x(h) = x + c_1 h + c_2 h^2 + O(h^3), and the steps h, h/2, h/4 give
//   x = (8 x(h/4) - 6 x(h/2) + x(h)) / 3 + O(h^3).
// This is Richardson's extrapolation, applied twice (E. Hairer, S. P. Norsett, G. Wanner, Solving
// Ordinary Differential Equations I, II.9).
#include "sim/study/exact_sheet.h"

#include <algorithm>
#include <cmath>

#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel::study {
// A sheet of `side` x `side` squares without contacts: only joints and springs act.
scene::Scene sheetScene(int side, bool planar, model::JointFace face, double startAngle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.face = face;
  shape.startAngle = startAngle;
  scene::Scene scene;
  scene.model = generate::makeTessellation(shape);
  scene.environment.contacts = scene::ContactFilter::None;
  scene.solver.planar = planar;
  return scene;
}

// One angle in space too, because the closed motion rotates tiles only about the vertical.
double openingAngle(const Poses& poses) {
  const Quaternion relative = poses[0].rotation.conjugate() * poses[1].rotation;
  // The angle of a unit quaternion, [0, pi]. It is precise for small angles; an arc cosine is not.
  return 2 * std::atan2(relative.vec().norm(), std::abs(relative.w()));
}

// Each vertex is extrapolated separately: its path depends smoothly on the step.
SheetPath limitOfSteps(const SheetPath& coarse, const SheetPath& middle, const SheetPath& fine) {
  SheetPath limit = fine;
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

// `desired` has at least as many states as `found`, which may have ended early.
double pathError(const SheetPath& found, const SheetPath& desired) {
  double largest = 0;
  for (std::size_t k = 0; k < found.size(); ++k) {
    largest = std::max(largest, trajectory::vertexDistance(found[k], desired[k]).largest);
  }
  return largest;
}

trajectory::VertexDistance sheetError(int side, double angle,
                                      const std::vector<model::Tile>& found) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  const std::vector<model::Tile> exact = generate::tessellationTiles(shape, angle);
  return trajectory::vertexDistance(found, model::bestFitted(exact, found));
}

}  // namespace kirireel::study
