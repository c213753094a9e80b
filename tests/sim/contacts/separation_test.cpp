/// Separating planes against brute-force projection, the independent measure of penetration, and
/// finite differences.
#include <algorithm>
#include <limits>
#include <memory>

#include <gtest/gtest.h>

#include "sim/contacts/contact_finder.h"
#include "sim/mechanics/step_system.h"
#include "sim/trajectory/measures.h"
#include "tests/sim/contacts/prisms.h"

namespace kirireel {
namespace {

using Kind = contacts::SeparatingPlane::Kind;
using test::Chance;

/// Two prisms at their poses.
struct Pair {
  Pair(const brick::Brick& brickA, const Pose& poseA, const brick::Brick& brickB, const Pose& poseB,
       bool planar)
      : bricks{brickA, brickB},
        poses{poseA, poseB},
        outlineA(contacts::makeOutline(brickA, planar)),
        outlineB(contacts::makeOutline(brickB, planar)) {
    place();
  }
  Pair(const Pair&) = delete;
  Pair& operator=(const Pair&) = delete;

  void place() {
    contacts::placeOutline(outlineA, poses[0], a);
    contacts::placeOutline(outlineB, poses[1], b);
  }

  std::vector<contacts::SeparatingPlane> planes() const {
    return contacts::separatingPlanes(outlineA, outlineB);
  }

  double largestSeparation() const {
    double largest = -std::numeric_limits<double>::infinity();
    for (const contacts::SeparatingPlane& plane : planes()) {
      largest = std::max(largest, contacts::separation(plane, a, b));
    }
    return largest;
  }

  std::vector<brick::Contact> contacts(const contacts::SeparatingPlane& plane) const {
    std::vector<brick::Contact> found;
    contacts::appendPlaneContacts(plane, 0, 1, a, b, found);
    return found;
  }

  std::vector<brick::Brick> bricks;
  Poses poses;
  contacts::Outline outlineA, outlineB;
  contacts::PlacedOutline a, b;
};

/// Planar pairs get tall prisms, whose shortest separation is never vertical.
brick::Brick anyPrism(Chance& chance, bool planar) {
  const int corners = 3 + chance.below(4);
  const double thickness = chance.next() > 0 ? 0.02 : 0.5;
  return test::prism(corners, 0.8 + 0.2 * chance.next(), planar ? 50 : thickness);
}

std::unique_ptr<Pair> anyPair(Chance& chance, bool planar, double distance) {
  const auto pose = [&] { return planar ? chance.planarPose(distance) : chance.pose(distance); };
  const brick::Brick a = anyPrism(chance, planar), b = anyPrism(chance, planar);
  const Pose poseA = pose(), poseB = pose();
  return std::make_unique<Pair>(a, poseA, b, poseB, planar);
}

double lowestAlong(const std::vector<Vector3>& points, const Vector3& direction) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vector3& point : points) lowest = std::min(lowest, point.dot(direction));
  return lowest;
}

TEST(Outline, HoldsAPrism) {
  for (int corners = 3; corners < 8; ++corners) {
    const contacts::Outline outline = contacts::makeOutline(test::prism(corners, 1, 0.3), false);
    ASSERT_EQ(outline.points.size(), 2u * corners);
    ASSERT_EQ(outline.normals.size(), corners + 2u);
    ASSERT_EQ(outline.facePoints.size(), outline.normals.size());
    for (std::size_t f = 0; f < outline.normals.size(); ++f) {
      const Vector3& normal = outline.normals[f];
      EXPECT_NEAR(normal.norm(), 1, 1e-15);
      unsigned onFace = 0;
      for (const Vector3& point : outline.points) {
        const double height = normal.dot(point - outline.points[outline.facePoints[f]]);
        EXPECT_LT(height, 1e-14);  // measured 4e-16
        if (height > -1e-14) ++onFace;
      }
      EXPECT_EQ(onFace, f < 2 ? corners : 4u);
    }
  }
}

TEST(Outline, HasTheDirectionsOfAllEdgesOnce) {
  for (int corners = 3; corners < 8; ++corners) {
    const brick::Brick brick = test::prism(corners, 1, 0.3);
    const contacts::Outline outline = contacts::makeOutline(brick, false);
    const int across = corners % 2 == 0 ? corners / 2 : corners;  // opposite sides are parallel
    EXPECT_EQ(outline.directions.size(), across + 1u);
    const auto isKnown = [&](const Vector3& edge) {
      return std::any_of(outline.directions.begin(), outline.directions.end(),
                         [&](const Vector3& known) {
                           return std::abs(std::abs(known.dot(edge.normalized())) - 1) < 1e-14;
                         });
    };
    EXPECT_TRUE(isKnown(brick.normal));
    for (int k = 0; k < corners; ++k) {
      EXPECT_TRUE(isKnown(brick.bottom[(k + 1) % corners] - brick.bottom[k]));
    }
  }
}

TEST(Outline, OfAPlanarSceneIsThePolygon) {
  const brick::Brick brick = test::prism(5, 1, 0.3);
  const contacts::Outline outline = contacts::makeOutline(brick, true);
  EXPECT_EQ(outline.points, brick.bottom);
  EXPECT_TRUE(outline.directions.empty());
  ASSERT_EQ(outline.normals.size(), 5u);
  for (int k = 0; k < 5; ++k) {
    const Vector3 middle = 0.5 * (brick.bottom[k] + brick.bottom[(k + 1) % 5]);
    const Vector3 outwards = Vector3(middle.x(), middle.y(), 0).normalized();
    EXPECT_LT((outline.normals[k] - outwards).norm(), 1e-14);
  }
}

TEST(Outline, IsPlacedLikeItsBrick) {
  Chance chance(1);
  const brick::Brick brick = test::prism(4, 1, 0.3);
  const contacts::Outline outline = contacts::makeOutline(brick, false);
  const Pose pose = chance.pose(2);
  contacts::PlacedOutline placed;
  contacts::placeOutline(outline, pose, placed);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_LT((placed.points[k] - pose.apply(brick.bottom[k])).norm(), 1e-14);
    EXPECT_LT((placed.points[k + 4] - pose.apply(brick.top[k])).norm(), 1e-14);
  }
  EXPECT_LT((placed.normals[1] - pose.rotation * brick.normal).norm(), 1e-14);
}

TEST(Separation, IsTheGapOfTheProjections) {
  Chance chance(2);
  for (const bool planar : {true, false}) {
    for (int trial = 0; trial < 40; ++trial) {
      const auto pair = anyPair(chance, planar, 1);
      for (const contacts::SeparatingPlane& plane : pair->planes()) {
        const Vector3 normal = contacts::planeNormal(plane, pair->a, pair->b);
        EXPECT_NEAR(normal.norm(), 1, 1e-14);
        const double gap =
            lowestAlong(pair->a.points, normal) + lowestAlong(pair->b.points, -normal);
        EXPECT_NEAR(contacts::separation(plane, pair->a, pair->b), gap, 1e-14);  // measured 2e-15
      }
    }
  }
}

TEST(Separation, OfParallelEdgesDoesNotExist) {
  const brick::Brick plate = test::plate(0.1);
  const Pair pair(plate, {}, plate, {{3, 0, 0}, Quaternion::Identity()}, false);
  int parallel = 0;
  for (const contacts::SeparatingPlane& plane : pair.planes()) {
    if (plane.kind != Kind::Edges || plane.a != plane.b) continue;
    EXPECT_TRUE(contacts::planeNormal(plane, pair.a, pair.b).isZero(0));
    EXPECT_EQ(contacts::separation(plane, pair.a, pair.b),
              -std::numeric_limits<double>::infinity());
    ++parallel;
  }
  EXPECT_EQ(parallel, 6);  // three directions, both signs
}

TEST(Separation, AgreesWithTheMeasuredPenetration) {
  Chance chance(3);
  for (const bool planar : {true, false}) {
    int overlapping = 0, apart = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      const auto pair = anyPair(chance, planar, 1.2);
      const double depth = trajectory::deepestPenetration(pair->bricks, pair->poses).depth;
      const double largest = pair->largestSeparation();
      EXPECT_NEAR(std::max(0.0, -largest), depth, 1e-13);  // measured 3e-15
      ++(depth > 0 ? overlapping : apart);
    }
    EXPECT_GT(overlapping, 100);
    EXPECT_GT(apart, 100);
  }
}

TEST(Separation, TurnsSignWithTheOrderOfThePair) {
  Chance chance(4);
  for (int trial = 0; trial < 50; ++trial) {
    const auto pair = anyPair(chance, false, 1);
    const Pair swapped(pair->bricks[1], pair->poses[1], pair->bricks[0], pair->poses[0], false);
    EXPECT_NEAR(pair->largestSeparation(), swapped.largestSeparation(), 1e-14);
  }
}

TEST(PlaneContacts, OfAFaceAreAllPointsAtTheirDistances) {
  Chance chance(5);
  for (const bool planar : {true, false}) {
    for (int trial = 0; trial < 40; ++trial) {
      const auto pair = anyPair(chance, planar, 1);
      for (const contacts::SeparatingPlane& plane : pair->planes()) {
        if (plane.kind == Kind::Edges) continue;
        const bool onA = plane.kind == Kind::FaceOfA;
        const contacts::PlacedOutline& points = onA ? pair->b : pair->a;
        const contacts::PlacedOutline& faces = onA ? pair->a : pair->b;
        const int face = onA ? plane.a : plane.b;
        const std::vector<brick::Contact> contacts = pair->contacts(plane);
        ASSERT_EQ(contacts.size(), points.points.size());
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < contacts.size(); ++k) {
          EXPECT_EQ(contacts[k].brickA, onA ? 1 : 0);
          EXPECT_EQ(contacts[k].brickB, onA ? 0 : 1);
          const Vector3 onFace = faces.points[faces.outline->facePoints[face]];
          const double distance = faces.normals[face].dot(points.points[k] - onFace);
          const double gap = brick::contactGap(contacts[k], pair->poses);
          EXPECT_NEAR(gap, distance, 1e-14);  // measured 1e-15
          least = std::min(least, gap);
        }
        EXPECT_NEAR(least, contacts::separation(plane, pair->a, pair->b), 1e-14);
      }
    }
  }
}

/// The planes of a pair whose two edges are far from parallel.
std::vector<contacts::SeparatingPlane> edgePlanes(const Pair& pair) {
  std::vector<contacts::SeparatingPlane> found;
  for (const contacts::SeparatingPlane& plane : pair.planes()) {
    if (plane.kind == Kind::Edges && contacts::isSteady(plane, pair.a, pair.b))
      found.push_back(plane);
  }
  return found;
}

TEST(PlaneContacts, OfTwoEdgesHoldBothBricksOnTheirSides) {
  Chance chance(6);
  for (int trial = 0; trial < 100; ++trial) {
    const auto pair = anyPair(chance, false, 1);
    for (const contacts::SeparatingPlane& plane : edgePlanes(*pair)) {
      const std::vector<brick::Contact> contacts = pair->contacts(plane);
      ASSERT_EQ(contacts.size(), pair->a.points.size() + pair->b.points.size() - 1);
      const Vector3 normal = contacts::planeNormal(plane, pair->a, pair->b);
      double least = std::numeric_limits<double>::infinity();
      for (const brick::Contact& contact : contacts) {
        EXPECT_LT((brick::contactNormal(contact, pair->poses) - normal).norm(), 1e-12);
        const Vector3 between =
            pair->poses[0].apply(contact.pointA) - pair->poses[1].apply(contact.pointB);
        const double gap = brick::contactGap(contact, pair->poses);
        EXPECT_NEAR(gap, normal.dot(between), 1e-12);
        least = std::min(least, gap);
      }
      EXPECT_NEAR(least, contacts::separation(plane, pair->a, pair->b), 1e-12);  // measured 2e-14
    }
  }
}

TEST(PlaneContacts, OfNearlyParallelEdgesAreNotSteady) {
  const brick::Brick plate = test::plate(0.1);
  for (const double angle : {1e-3, 0.04, 0.06, 0.5}) {
    // Rotated about z. The directions along the sides bound the angle.
    const Pair pair(plate, {}, plate, {{0, 0, 1}, rotationFromVector({0, 0, angle})}, false);
    int steady = 0;
    for (const contacts::SeparatingPlane& plane : pair.planes()) {
      const Vector3 normal = contacts::planeNormal(plane, pair.a, pair.b);
      const bool flat = plane.kind == Kind::Edges && std::abs(std::abs(normal.z()) - 1) < 1e-9;
      if (!flat || std::abs(pair.a.directions[plane.a].dot(pair.b.directions[plane.b])) < 0.7) {
        continue;
      }
      if (contacts::isSteady(plane, pair.a, pair.b)) ++steady;
    }
    EXPECT_EQ(steady, std::sin(angle) > 0.05 ? 4 : 0) << angle;
  }
}

/// Two plates that share a corner of their bottoms and are rotated about it. An edge of each starts
/// there.
std::unique_ptr<Pair> cornerPair(Chance& chance) {
  const brick::Brick plate = test::plate(0.2);
  const Quaternion turnA = rotationFromVector(0.4 * chance.vector());
  const Quaternion turnB = rotationFromVector(0.4 * chance.vector());
  const Pose poseA = {-(turnA * plate.bottom[0]), turnA};
  const Pose poseB = {-(turnB * plate.bottom[2]), turnB};
  return std::make_unique<Pair>(plate, poseA, plate, poseB, false);
}

/// The largest difference between a contact's normal row and the central difference of its gap,
/// over all coordinates of both bricks.
template <int D>
double rowError(const brick::Contact& contact, const Poses& poses) {
  constexpr double kMove = 1e-6;
  const mechanics::ContactRow<D> row = mechanics::makeContactRow<D>(contact, poses, 1, 0);
  double largest = 0;
  for (const bool ofA : {true, false}) {
    const int brick = ofA ? contact.brickA : contact.brickB;
    if (brick == brick::kFixed) continue;
    for (int k = 0; k < D; ++k) {
      const auto gapAfter = [&](double move) {
        Poses after = poses;
        mechanics::Coordinates<D>::displace(after[brick],
                                            move * mechanics::Coordinates<D>::Vector::Unit(k));
        return brick::contactGap(contact, after);
      };
      const double difference = (gapAfter(kMove) - gapAfter(-kMove)) / (2 * kMove);
      const double derivative = ofA ? row.normalA[k] : row.normalB[k];
      largest = std::max(largest, std::abs(difference - derivative));
    }
  }
  return largest;
}

template <int D>
void expectFaceRows(unsigned seed) {
  Chance chance(seed);
  for (int trial = 0; trial < 40; ++trial) {
    const auto pair = anyPair(chance, D == 3, 1);
    for (const contacts::SeparatingPlane& plane : pair->planes()) {
      if (plane.kind == Kind::Edges) continue;
      for (const brick::Contact& contact : pair->contacts(plane)) {
        EXPECT_LT(rowError<D>(contact, pair->poses), 1e-8);  // measured 2e-9
      }
    }
  }
}

TEST(ContactRow, OfAFaceIsTheGapsDerivativeInSpace) {
  expectFaceRows<6>(8);
}

TEST(ContactRow, OfAFaceIsTheGapsDerivativeInThePlane) {
  expectFaceRows<3>(9);
}

TEST(ContactRow, OfTheGroundIsTheGapsDerivative) {
  Chance chance(10);
  const Poses poses = {chance.pose(1)};
  const brick::Contact contact = {0, brick::kFixed, chance.vector(), chance.vector(),
                                  Vector3::UnitZ()};
  EXPECT_LT(rowError<6>(contact, poses), 1e-8);
}

/// Checks the steady planes of two edges. Returns the number of checked rows.
int expectEdgeRows(const Pair& pair) {
  int rows = 0;
  for (const contacts::SeparatingPlane& plane : edgePlanes(pair)) {
    // The gap of nearly parallel edges is too curved for a difference.
    const Vector3& edgeA = pair.a.directions[plane.a];
    if (edgeA.cross(pair.b.directions[plane.b]).norm() < 0.2) continue;
    for (const brick::Contact& contact : pair.contacts(plane)) {
      EXPECT_LT(rowError<6>(contact, pair.poses), 1e-7);  // measured 2e-9
      ++rows;
    }
  }
  return rows;
}

TEST(ContactRow, OfCrossingEdgesIsTheGapsDerivative) {
  Chance chance(11);
  int rows = 0;
  for (int trial = 0; trial < 20; ++trial) rows += expectEdgeRows(*anyPair(chance, false, 1));
  EXPECT_GT(rows, 2000);
}

TEST(ContactRow, OfEdgesWithACommonEndIsTheGapsDerivative) {
  Chance chance(12);
  int rows = 0;
  for (int trial = 0; trial < 20; ++trial) rows += expectEdgeRows(*cornerPair(chance));
  EXPECT_GT(rows, 2000);
}

}  // namespace
}  // namespace kirireel
