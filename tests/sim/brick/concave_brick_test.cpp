// Concave bricks: mass and inertia by closed forms, one body of several convex pieces.
#include <gtest/gtest.h>

#include "sim/brick/brick.h"
#include "sim/brick/contact.h"
#include "tests/support/polygons.h"

namespace kirireel {
namespace {

constexpr double kThickness = 0.3;

brick::BrickRule rule() {
  brick::BrickRule prism;
  prism.thickness = kThickness;
  prism.mass = brick::MassRule::Prism;
  prism.density = 700;
  return prism;
}

/// A box of the given sides about its centre.
Matrix3 boxInertia(double mass, double x, double y, double z) {
  return mass / 12 * Vector3(y * y + z * z, x * x + z * z, x * x + y * y).asDiagonal();
}

/// The inertia of a mass with its centre at r, about the origin (Steiner).
Matrix3 movedTo(const Matrix3& inertia, double mass, const Vector3& r) {
  return inertia + mass * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
}

TEST(ConcaveBrick, LHasTheInertiaOfItsTwoBoxes) {
  // Boxes 3 x 1 and 1 x 2 (on top of the first), with their centres in brick axes.
  const brick::Brick brick = brick::makeBrick(test::lShape(), rule());
  const double low = 700 * 3 * kThickness, high = 700 * 2 * kThickness;
  const Vector3 centre = (low * Vector3(1.5, 0.5, 0) + high * Vector3(0.5, 2, 0)) / (low + high);
  const Matrix3 inertia =
      movedTo(boxInertia(low, 3, 1, kThickness), low, Vector3(1.5, 0.5, 0) - centre) +
      movedTo(boxInertia(high, 1, 2, kThickness), high, Vector3(0.5, 2, 0) - centre);
  EXPECT_NEAR(brick.mass, low + high, 1e-12 * brick.mass);
  EXPECT_LT((brick.inertia - inertia).norm(), 1e-12 * inertia.norm());  // measured 2e-16
  EXPECT_LT((brick.bottom[0] - Vector3(-centre.x(), -centre.y(), -0.5 * kThickness)).norm(), 1e-12);
}

TEST(ConcaveBrick, StarHasTheInertiaOfItsTriangles) {
  // Ten triangles from the centre to a tip and a notch: about z, m / 6 (a.a + a.b + b.b) each; half
  // of it about x and y, by symmetry.
  const double outer = 2, inner = 0.7, angle = std::numbers::pi / 5;
  const brick::Brick brick = brick::makeBrick(test::starShape(5, outer, inner), rule());
  const double area = 10 * 0.5 * outer * inner * std::sin(angle);
  const double mass = 700 * area * kThickness;
  const double about = mass / 6 * (outer * outer + outer * inner * std::cos(angle) + inner * inner);
  const double across = 0.5 * about + mass * kThickness * kThickness / 12;
  EXPECT_NEAR(brick.mass, mass, 1e-12 * mass);
  const Matrix3 expected = Vector3(across, across, about).asDiagonal();
  EXPECT_LT((brick.inertia - expected).norm(), 1e-12 * expected.norm());  // measured 5e-16
}

TEST(ConcaveBrick, HasConvexPiecesOfOneBody) {
  const std::vector<brick::Brick> bricks =
      brick::makeBricks({test::starShape(5, 2, 0.7), {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}, rule());
  EXPECT_TRUE(bricks[1].parts.empty());
  const std::vector<brick::BrickPiece> pieces = brick::convexPieces(bricks);
  ASSERT_EQ(pieces.size(), bricks[0].parts.size() + 1);
  for (const brick::BrickPiece& piece : pieces) {
    const brick::Brick& whole = bricks[piece.brick];
    EXPECT_EQ(piece.shape.mass, whole.mass);
    for (std::size_t k = 0; k < piece.corners.size(); ++k) {
      EXPECT_EQ(piece.shape.bottom[k], whole.bottom[piece.corners[k]]);
      EXPECT_EQ(piece.shape.top[k], whole.top[piece.corners[k]]);
    }
  }
  EXPECT_EQ(pieces.back().brick, 1);
}

TEST(ConcaveBrick, SharedCornersAreCutOffEachPiece) {
  const brick::Brick star = brick::makeBrick(test::starShape(4, 2, 0.7), rule());
  const int notch = 1;
  for (const brick::BrickPiece& piece : brick::convexPieces(star)) {
    const bool holds = std::count(piece.corners.begin(), piece.corners.end(), notch) > 0;
    const brick::Brick cut = brick::withoutCorners(piece, {notch}, 0.05);
    EXPECT_EQ(cut.bottom.size(), piece.shape.bottom.size() + (holds ? 1 : 0));
    for (const Vector3& corner : cut.bottom) {
      EXPECT_GT((corner - star.bottom[notch]).norm(), 0.03);
    }
  }
}

}  // namespace
}  // namespace kirireel
