// The path of a sheet of squares is known in closed form.
#include <cmath>

#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/generate/lattice.h"
#include "sim/study/exact_sheet.h"

namespace kirireel {
namespace {

constexpr int kSide = 4;

std::vector<model::Tile> squaresAt(double angle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = kSide;
  return generate::tessellationTiles(shape, angle);
}

study::ClosurePath pathOfSquares() {
  return {squaresAt(0), study::sheetScene(kSide, true).model.joints};
}

TEST(ClosurePath, FollowsTheExactMotionBothWays) {
  const study::ClosurePath path = pathOfSquares();
  const study::PlanarState open = path.stateOf(squaresAt(1));
  const double sign = path.angle(open) < 0 ? -1 : 1;
  for (const double angle : {0.1, 0.6, 1.5}) {
    const study::PlanarState there = path.follow(open, sign * angle, 0.02);
    EXPECT_LT(path.gap(there), 1e-14);                                         // measured 3e-15
    EXPECT_LT(study::sheetError(kSide, angle, path.tiles(there)).largest, 1e-12);  // measured 2e-14
  }
}

TEST(ClosurePath, ClosesAStateThatIsALittleOff) {
  const study::ClosurePath path = pathOfSquares();
  const study::PlanarState exact = path.stateOf(squaresAt(0.8));
  study::PlanarState off = exact;
  for (Eigen::Index k = 3; k < off.size(); ++k) off[k] += k % 2 == 0 ? 1e-3 : -1e-3;
  EXPECT_GT(path.gap(off), 1e-4);
  const study::PlanarState closed = path.close(off, path.angle(exact));
  EXPECT_LT((closed - exact).lpNorm<Eigen::Infinity>(), 1e-12);  // measured 2e-15
}

TEST(ClosurePath, ReportsWhereNothingCloses) {
  // Two squares joined along an edge at both of its ends cannot turn against each other.
  model::Tile left;
  left.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  model::Tile right = left;
  for (Vector3& vertex : right.vertices) vertex.x() += 1;
  const study::ClosurePath path({left, right}, {{{0, 1}, {1, 0}}, {{0, 2}, {1, 3}}});
  try {
    path.close(path.stateOf({left, right}), 0.5);
    FAIL() << "no error";
  } catch (const RunError& error) {
    EXPECT_STREQ(error.what(), "error: no closed state at 0.5 radians: a gap of 0.17 m is left");
  }
}

}  // namespace
}  // namespace kirireel
