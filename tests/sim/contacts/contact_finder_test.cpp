#include "sim/contacts/contact_finder.h"

#include <algorithm>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/trajectory/measures.h"
#include "tests/sim/contacts/prisms.h"

namespace kirireel {
namespace {

using test::Chance;
using test::moved;

constexpr double kTolerance = 1e-6;

scene::Environment around(scene::ContactFilter filter) {
  scene::Environment environment;
  environment.contacts = filter;
  return environment;
}

/// Contacts on one move.
struct Found {
  std::vector<brick::Contact> contacts;
  double overlap = 0;
};

Found findContacts(contacts::ContactFinder& finder, const Poses& start, const Poses& end) {
  Found found;
  finder.startStep(start);
  found.overlap = finder.appendViolated(end, found.contacts);
  return found;
}

Found findContacts(const std::vector<brick::Brick>& bricks, const Poses& start, const Poses& end,
                   bool planar = false) {
  contacts::ContactFinder finder(bricks, start, {}, around(scene::ContactFilter::All), planar,
                                 kTolerance);
  return findContacts(finder, start, end);
}

Pose at(double x, double y, double z) {
  return {{x, y, z}, Quaternion::Identity()};
}

TEST(ContactFinder, SharesNoContactsWithAnotherOne) {
  // Bricks that come near each other in only one of two finders.
  const std::vector<brick::Brick> bricks(2, test::plate(1e-3));
  const Poses far = {at(0, 0, 0), at(50, 0, 0)};
  const scene::Environment environment = around(scene::ContactFilter::All);
  contacts::ContactFinder near(bricks, far, {}, environment, false, kTolerance);
  contacts::ContactFinder other(bricks, far, {}, environment, false, kTolerance);
  findContacts(other, far, far);
  const Found found =
      findContacts(near, {at(0, 0, 0), at(1.01, 0.2, 0)}, {at(0, 0, 0), at(0.96, 0.2, 0)});
  ASSERT_FALSE(found.contacts.empty());
  EXPECT_FALSE(other.isCurrent(found.contacts.front()));
}

TEST(ContactFinder, CatchesThinBricksThatPassThroughEachOther) {
  // Flat through flat, and side through side, for any rotation in the world.
  Chance chance(1);
  const std::vector<brick::Brick> bricks(2, test::plate(1e-3));
  const Pose besides = at(1.01, 0.2, 0), above = at(0.3, 0.2, 0.01);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose world = chance.pose(3);
    for (const auto& [from, move] :
         {std::pair(above, Vector3(0, 0, -0.05)), std::pair(besides, Vector3(-0.05, 0, 0))}) {
      const Poses start = {moved(world, {}), moved(world, from)};
      Pose to = from;
      to.position += move;
      const Poses end = {start[0], moved(world, to)};
      const Found found = findContacts(bricks, start, end);
      EXPECT_FALSE(found.contacts.empty());
      EXPECT_GT(found.overlap, 0.03);
      // No contact is violated at the start, at least one at the end.
      double least = 0;
      for (const brick::Contact& contact : found.contacts) {
        EXPECT_GT(brick::contactGap(contact, start), 0);
        least = std::min(least, brick::contactGap(contact, end));
      }
      EXPECT_LT(least, -0.03);
    }
  }
}

TEST(ContactFinder, FindsAllContactsOnThePath) {
  // Random moves of random pairs; the second method checks 100 poses between.
  Chance chance(2);
  int met = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const std::vector<brick::Brick> bricks = {test::prism(3 + chance.below(3), 0.5, 1e-3),
                                              test::prism(3 + chance.below(3), 0.5, 1e-3)};
    const Poses start = {chance.pose(0.5), chance.pose(0.5)};
    if (trajectory::deepestPenetration(bricks, start).depth > 0) continue;
    const Vector3 move = 0.5 * chance.vector();
    double deepest = 0;
    Poses between = start;
    for (int part = 1; part <= 100; ++part) {
      between[1].position = start[1].position + part / 100.0 * move;
      deepest = std::max(deepest, trajectory::deepestPenetration(bricks, between).depth);
    }
    if (deepest < 1e-5) continue;
    EXPECT_FALSE(findContacts(bricks, start, between).contacts.empty());
    ++met;
  }
  EXPECT_GT(met, 50);
}

/// The intersection of convex polygons, anticlockwise from above (Sutherland and Hodgman).
std::vector<Vector3> overlapOf(std::vector<Vector3> polygon, const std::vector<Vector3>& other) {
  for (std::size_t k = 0; k < other.size(); ++k) {
    const Vector3 edge = other[(k + 1) % other.size()] - other[k];
    const auto inside = [&](const Vector3& p) {
      return edge.x() * (p.y() - other[k].y()) - edge.y() * (p.x() - other[k].x());
    };
    std::vector<Vector3> cut;
    for (std::size_t j = 0; j < polygon.size(); ++j) {
      const Vector3 &p = polygon[j], &q = polygon[(j + 1) % polygon.size()];
      const double atP = inside(p), atQ = inside(q);
      if (atP >= 0) cut.push_back(p);
      if (atP * atQ < 0) cut.emplace_back(p + atP / (atP - atQ) * (q - p));
    }
    polygon = cut;
  }
  return polygon;
}

TEST(ContactFinder, GivesTheCornersOfThePolygonInWhichFacesOverlap) {
  Chance chance(20);
  int crossings = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<brick::Brick> bricks = {test::prism(3 + chance.below(4), 0.5, 0.1),
                                              test::prism(3 + chance.below(4), 0.4, 0.1)};
    const Pose world = chance.pose(3);
    const Vector3 place(0.5 * chance.next(), 0.5 * chance.next(), 0.1001);
    const Pose above = {place, rotationFromVector({0, 0, 3 * chance.next()})};
    Pose fallen = above;
    fallen.position.z() -= 0.01;
    std::vector<Vector3> lower = bricks[0].bottom, upper;
    for (const Vector3& point : bricks[1].bottom) upper.push_back(above.apply(point));
    const std::vector<Vector3> expected = overlapOf(upper, lower);
    const Poses start = {world, moved(world, above)}, end = {world, moved(world, fallen)};
    const Found found = findContacts(bricks, start, end);
    if (expected.size() < 3) {
      EXPECT_TRUE(found.contacts.empty());
      continue;
    }
    ASSERT_EQ(found.contacts.size(), expected.size());
    for (const brick::Contact& contact : found.contacts) {
      EXPECT_TRUE(contact.isRegion);
      crossings += contact.isEdge ? 1 : 0;
      EXPECT_NEAR(brick::contactGap(contact, start), 1e-4, 1e-12);
      const Vector3 point =
          world.rotation.conjugate() * (brick::contactPoints(contact, start).onA - world.position);
      double nearest = 1;
      for (const Vector3& corner : expected) {
        nearest = std::min(nearest, (corner - point).head<2>().norm());
      }
      EXPECT_LT(nearest, 1e-12);
    }
  }
  EXPECT_GT(crossings, 100);
}

TEST(ContactFinder, GivesNoContactsForSeparateBricks) {
  Chance chance(3);
  int near = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<brick::Brick> bricks(2, test::plate(0.1));
    const Poses start = {chance.pose(0.7), chance.pose(0.7)};
    if (trajectory::deepestPenetration(bricks, start).depth > 0) continue;
    // Moved by less than their distance along a plane: this plane still separates them.
    Poses end = start;
    end[1].position += 1e-6 * chance.vector();
    const Found found = findContacts(bricks, start, end);
    EXPECT_TRUE(found.contacts.empty());
    EXPECT_EQ(found.overlap, 0);
    ++near;
  }
  EXPECT_GT(near, 30);
}

/// Two squares joined at one corner, opened by an angle; below zero they overlap.
struct JoinedPair {
  explicit JoinedPair(model::JointFace face = model::JointFace::Both) {
    shape.columns = 2;
    shape.rows = 1;
    shape.face = face;
    const model::Model model = generate::makeTessellation(shape);
    bricks = brick::makeBricks(model.tiles, {});
    pivots = brick::makePivots(model.joints, bricks);
  }

  /// The poses at an opening angle.
  Poses opened(double angle) const {
    const std::vector<model::Tile> closed = generate::tessellationTiles(shape, 0);
    const std::vector<model::Tile> tiles = generate::tessellationTiles(shape, angle);
    Poses poses(2);
    for (int i = 0; i < 2; ++i) {
      const Vector3 before = closed[i].vertices[1] - closed[i].vertices[0];
      const Vector3 after = tiles[i].vertices[1] - tiles[i].vertices[0];
      poses[i].rotation = Quaternion::FromTwoVectors(before, after);
      poses[i].position = model::tileCentroid(tiles[i]) + Vector3(0, 0, 0.5 * bricks[i].thickness);
    }
    return poses;
  }

  Found turn(double from, double to, bool planar) const {
    contacts::ContactFinder finder(bricks, opened(0), pivots, around(scene::ContactFilter::All),
                                   planar, kTolerance);
    return findContacts(finder, opened(from), opened(to));
  }

  generate::TessellationShape shape;
  std::vector<brick::Brick> bricks;
  std::vector<brick::Pivot> pivots;
};

TEST(ContactFinder, LetsJoinedBricksTurnAwayFreely) {
  const JoinedPair pair;
  for (const bool planar : {true, false}) {
    for (const double from : {0.0, 1e-7, 1e-3, 0.2, 1.5}) {
      for (const double by : {1e-6, 1e-2, 0.3, 1.0}) {
        const Found found = pair.turn(from, from + by, planar);
        EXPECT_TRUE(found.contacts.empty()) << from << " by " << by;
        EXPECT_EQ(found.overlap, 0);
      }
    }
  }
}

TEST(ContactFinder, StopsJoinedBricksWhoseSidesTouch) {
  const JoinedPair pair;
  for (const bool planar : {true, false}) {
    EXPECT_TRUE(pair.turn(0.1, 1e-7, planar).contacts.empty());
    for (const double from : {0.0, 0.05, 0.3}) {
      const Found found = pair.turn(from, -0.01, planar);
      EXPECT_FALSE(found.contacts.empty()) << from;
      EXPECT_NEAR(found.overlap, std::sin(0.01), 1e-3);  // a unit side turned through the other
      for (const brick::Contact& contact : found.contacts) {
        EXPECT_GT(brick::contactGap(contact, pair.opened(from)), -1e-12);
      }
    }
  }
}

TEST(ContactFinder, StopsAFoldWhenTheFacesTouch) {
  // The second plate is hinged along a side. It folds over the first and may lie on it, but not
  // overlap it.
  const std::vector<brick::Brick> bricks(2, test::plate(0.02));
  const Vector3 hinge(0.5, 0, 0.01);
  const auto folded = [&](double angle) {
    const Quaternion turn = rotationFromVector({0, -angle, 0});
    return Poses{{}, {hinge + turn * Vector3(0.5, 0, -0.01), turn}};
  };
  contacts::ContactFinder finder(bricks, folded(0), {}, around(scene::ContactFilter::All), false,
                                 kTolerance);
  for (const double angle : {0.0, 0.5, 1.5, 2.5, 3.0}) {
    EXPECT_TRUE(findContacts(finder, folded(angle), folded(angle + 0.1)).contacts.empty()) << angle;
  }
  EXPECT_FALSE(findContacts(finder, folded(3.1), folded(3.2)).contacts.empty());
  EXPECT_FALSE(findContacts(finder, folded(0), folded(-0.1)).contacts.empty());
}

TEST(ContactFinder, LeavesOutTheCornersThatBricksShare) {
  // Two bricks joined at their bottom corners and 0.3 rad open, folded towards their tops about the
  // line through the pivot across the gap. Whole bricks meet above the pivot at once. Bricks
  // without their corners meet when the fold has closed the gap next to these.
  const JoinedPair pair(model::JointFace::Bottom);
  const Poses open = pair.opened(0.3);
  const Vector3 pivot = open[0].apply(pair.pivots[0].pointA);
  const Vector3 across =
      ((open[0].position - pivot).normalized() + (open[1].position - pivot).normalized());
  const Vector3 axis(across.x(), across.y(), 0);
  const auto folded = [&](double angle) {
    Poses poses = open;
    for (const double sign : {-1, 1}) {
      Pose& pose = poses[sign < 0 ? 0 : 1];
      const double side = axis.cross(pose.position - pivot).z() > 0 ? 1 : -1;
      const Quaternion turn = rotationFromVector(0.5 * side * angle * axis.normalized());
      pose = {pivot + turn * (pose.position - pivot), turn * pose.rotation};
    }
    return poses;
  };
  const auto meets = [&](double zone, double angle) {
    scene::Environment environment = around(scene::ContactFilter::All);
    environment.pivotZone = zone;
    contacts::ContactFinder finder(pair.bricks, open, pair.pivots, environment, false, kTolerance);
    return !findContacts(finder, open, folded(angle)).contacts.empty();
  };
  int towardsTops = 0;
  for (const double away : {-1.0, 1.0}) {
    if (trajectory::deepestPenetration(pair.bricks, folded(0.1 * away)).depth == 0) {
      EXPECT_FALSE(meets(0, 0.1 * away));
      EXPECT_FALSE(meets(0.05, 0.1 * away));
    } else {
      ++towardsTops;
      EXPECT_TRUE(meets(0, 0.1 * away));
      EXPECT_FALSE(meets(0.05, 0.1 * away));
      EXPECT_TRUE(meets(0.05, 1.5 * away));
    }
  }
  EXPECT_EQ(towardsTops, 1);
}

TEST(ContactFinder, NeverChangesToAPlaneOnTheOtherSide) {
  // Thin plates that overlap by more than their thickness at the start. Every plane between them
  // counts as separating, but none may change to the plane on the other side.
  const std::vector<brick::Brick> bricks(2, test::plate(0.01));
  const Quaternion upright = rotationFromVector({0, 0.5 * std::numbers::pi, 0});
  const auto crossed = [&](double height) { return Poses{{}, {Vector3(0.2, 0, height), upright}}; };
  contacts::ContactFinder finder(bricks, crossed(0.45), {}, around(scene::ContactFilter::All),
                                 false, kTolerance);
  EXPECT_TRUE(findContacts(finder, crossed(0.45), crossed(0.46)).contacts.empty());
  EXPECT_FALSE(findContacts(finder, crossed(0.45), crossed(0.3)).contacts.empty());
  EXPECT_FALSE(findContacts(finder, crossed(0.45), crossed(-0.6)).contacts.empty());
}

TEST(ContactFinder, FiltersPairs) {
  const JoinedPair pair;
  for (const bool joined : {true, false}) {
    const std::vector<brick::Pivot> pivots = joined ? pair.pivots : std::vector<brick::Pivot>{};
    for (const scene::ContactFilter filter :
         {scene::ContactFilter::None, scene::ContactFilter::Unjoined, scene::ContactFilter::All}) {
      contacts::ContactFinder finder(pair.bricks, pair.opened(0), pivots, around(filter), false,
                                     kTolerance);
      const Found found = findContacts(finder, pair.opened(0.1), pair.opened(-0.1));
      const bool meets =
          filter == scene::ContactFilter::All || (filter != scene::ContactFilter::None && !joined);
      EXPECT_EQ(!found.contacts.empty(), meets);
      EXPECT_EQ(found.overlap > 0, meets);
    }
  }
}

TEST(ContactFinder, KeepsTheOverlapOfTheStartButNoMore) {
  const std::vector<brick::Brick> bricks(2, test::plate(0.5));
  const auto overlapping = [](double depth) { return Poses{{}, at(1 - depth, 0.3, 0)}; };
  contacts::ContactFinder finder(bricks, overlapping(0.1), {}, around(scene::ContactFilter::All),
                                 false, kTolerance);
  const Poses start = overlapping(0.1);
  EXPECT_TRUE(findContacts(finder, start, start).contacts.empty());
  EXPECT_TRUE(findContacts(finder, start, overlapping(0.05)).contacts.empty());
  EXPECT_TRUE(findContacts(finder, start, overlapping(-0.2)).contacts.empty());
  const Found deeper = findContacts(finder, start, overlapping(0.11));
  ASSERT_FALSE(deeper.contacts.empty());
  EXPECT_NEAR(deeper.overlap, 0.01, 1e-12);  // measured 9e-18
  for (const brick::Contact& contact : deeper.contacts) {
    EXPECT_NEAR(contact.slack, 0.1, 1e-12);  // measured 3e-17
    EXPECT_GT(brick::contactGap(contact, start), -1e-12);
  }
}

TEST(ContactFinder, KeepsAnOverlapClosedOnceItIs) {
  const std::vector<brick::Brick> bricks(2, test::plate(0.5));
  const auto overlapping = [](double depth) { return Poses{{}, at(1 - depth, 0.3, 0)}; };
  contacts::ContactFinder finder(bricks, overlapping(0.1), {}, around(scene::ContactFilter::All),
                                 false, kTolerance);
  EXPECT_FALSE(findContacts(finder, overlapping(0.04), overlapping(0.06)).contacts.empty());
  EXPECT_TRUE(findContacts(finder, overlapping(-0.01), overlapping(-0.01)).contacts.empty());
  EXPECT_NEAR(findContacts(finder, overlapping(-0.01), overlapping(0.02)).overlap, 0.02, 1e-12);
}

TEST(ContactFinder, GivesAPlaneOnceInAStep) {
  const std::vector<brick::Brick> bricks(2, test::plate(0.5));
  const Poses start = {{}, at(1.01, 0.3, 0)}, end = {{}, at(0.9, 0.3, 0)};
  contacts::ContactFinder finder(bricks, start, {}, around(scene::ContactFilter::All), true,
                                 kTolerance);
  finder.startStep(start);
  std::vector<brick::Contact> contacts;
  for (int round = 0; round < 20; ++round) finder.appendViolated(end, contacts);
  const auto same = [](const brick::Contact& x, const brick::Contact& y) {
    return x.brickA == y.brickA && x.pointA == y.pointA && x.pointB == y.pointB &&
           x.normal == y.normal;
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(same(contacts[i], contacts[j]));
  }
  const std::size_t first = contacts.size();
  EXPECT_GT(finder.appendViolated(end, contacts), 0.05);  // still reported, though nothing is new
  EXPECT_EQ(contacts.size(), first);
}

/// Four tiles in a heap that all overlap each other, in the given order.
Found heap(const std::vector<int>& order, int warmUps) {
  Chance chance(6);
  std::vector<brick::Brick> bricks;
  Poses start, end;
  for (int i = 0; i < 4; ++i) {
    bricks.push_back(test::prism(3 + i, 0.5 + 0.1 * i, 0.1));
    const double height = 0.3 * i;
    start.push_back({{0.1 * chance.next(), 0.1 * chance.next(), height},
                     rotationFromVector(0.1 * chance.vector())});
    end.push_back(
        {{start[i].position.x(), start[i].position.y(), 0.1 * height}, start[i].rotation});
  }
  const auto sorted = [&](const auto& values) {
    auto result = values;
    for (std::size_t i = 0; i < order.size(); ++i) result[i] = values[order[i]];
    return result;
  };
  contacts::ContactFinder finder(sorted(bricks), sorted(start), {},
                                 around(scene::ContactFilter::All), false, kTolerance);
  for (int i = 0; i < warmUps; ++i) {
    Poses elsewhere = sorted(start);
    elsewhere[i % 4].position += chance.vector();
    findContacts(finder, sorted(start), elsewhere);
  }
  return findContacts(finder, sorted(start), sorted(end));
}

/// The contacts as sorted rows of numbers, which do not depend on the order of bricks: the pair by
/// its original numbers, and the point in A.
std::vector<std::vector<double>> signatures(const Found& found, const std::vector<int>& order) {
  std::vector<std::vector<double>> rows;
  for (const brick::Contact& contact : found.contacts) {
    const Vector3& a = contact.pointA;
    const Vector3& b = contact.pointB;
    std::vector<double> row = {static_cast<double>(order[contact.brickA]),
                               static_cast<double>(order[contact.brickB])};
    // The plane of two edges belongs to neither brick.
    if (contact.isEdge) std::sort(row.begin(), row.end());
    const bool swapped = row[0] != order[contact.brickA];
    for (const Vector3& point : {swapped ? b : a, swapped ? a : b}) {
      row.insert(row.end(), point.begin(), point.end());
    }
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

TEST(ContactFinder, FindsTheSameForAnyHistory) {
  const std::vector<int> order = {0, 1, 2, 3};
  const Found fresh = heap(order, 0);
  EXPECT_GT(fresh.contacts.size(), 10u);
  for (const int warmUps : {1, 5, 20}) {
    const Found found = heap(order, warmUps);
    ASSERT_EQ(found.contacts.size(), fresh.contacts.size());
    EXPECT_EQ(found.overlap, fresh.overlap);
    for (std::size_t i = 0; i < found.contacts.size(); ++i) {
      EXPECT_EQ(found.contacts[i].brickA, fresh.contacts[i].brickA);
      EXPECT_EQ(found.contacts[i].brickB, fresh.contacts[i].brickB);
      EXPECT_EQ(found.contacts[i].pointA, fresh.contacts[i].pointA);
      EXPECT_EQ(found.contacts[i].normal, fresh.contacts[i].normal);
    }
  }
}

TEST(ContactFinder, FindsTheSameForRenumberedBricks) {
  const std::vector<int> order = {0, 1, 2, 3};
  const auto expected = signatures(heap(order, 0), order);
  std::vector<int> other = order;
  while (std::next_permutation(other.begin(), other.end())) {
    EXPECT_EQ(signatures(heap(other, 0), other), expected);
  }
}

/// Neither face is better than the other, so a choice would depend on the numbers of the bricks or
/// on rounding.
TEST(ContactFinder, GivesBothOfTwoFacesThatMirrorEachOther) {
  const std::vector<brick::Brick> bricks(2, test::plate(0.5));
  for (const double rounding : {0.0, 1e-14, -1e-14}) {
    const auto placed = [&](double x) -> Poses {
      return {{{-x, 0, 0}, rotationFromVector({0, 0.03 + rounding, 0})},
              {{x, 0, 0}, rotationFromVector({0, -0.03, 0})}};
    };
    contacts::ContactFinder finder(bricks, placed(0.52), {}, around(scene::ContactFilter::All),
                                   false, kTolerance, contacts::FaceContact::Planes);
    const Found found = findContacts(finder, placed(0.52), placed(0.49));
    std::map<int, int> points;  // for each brick with a face
    for (const brick::Contact& contact : found.contacts) ++points[contact.brickB];
    EXPECT_EQ(points[0], points[1]) << rounding;
    EXPECT_GT(points[0], 0);
  }
}

/// A plate whose bottom is at a height.
Poses plateAt(const brick::Brick& brick, double height) {
  return {at(0, 0, height + 0.5 * brick.thickness)};
}

TEST(ContactFinder, HoldsEveryPointAboveTheGround) {
  const std::vector<brick::Brick> bricks = {test::plate(0.2)};
  scene::Environment environment;
  environment.ground = scene::Ground{-1, 0.7};
  const Poses start = plateAt(bricks[0], -0.99);
  contacts::ContactFinder finder(bricks, start, {}, environment, false, kTolerance);
  EXPECT_TRUE(findContacts(finder, start, plateAt(bricks[0], -1)).contacts.empty());
  const Found found = findContacts(finder, start, plateAt(bricks[0], -1.05));
  EXPECT_NEAR(found.overlap, 0.05, 1e-15);  // measured 4e-17
  ASSERT_EQ(found.contacts.size(), 8u);
  for (const brick::Contact& contact : found.contacts) {
    EXPECT_EQ(contact.brickB, brick::kFixed);
    EXPECT_EQ(contact.friction, 0.7);
    const double height = start[0].apply(contact.pointA).z() + 1;
    EXPECT_NEAR(brick::contactGap(contact, start), height, 1e-15);
  }
}

TEST(ContactFinder, CatchesAThinBrickThatPassesThroughTheGround) {
  const std::vector<brick::Brick> bricks = {test::plate(1e-3)};
  scene::Environment environment;
  environment.ground = scene::Ground{};
  const Poses start = plateAt(bricks[0], 0.01);
  contacts::ContactFinder finder(bricks, start, {}, environment, false, kTolerance);
  EXPECT_EQ(findContacts(finder, start, plateAt(bricks[0], -0.04)).contacts.size(), 8u);
}

TEST(ContactFinder, GivesTheGroundOnceInAStep) {
  const std::vector<brick::Brick> bricks = {test::plate(0.2)};
  scene::Environment environment;
  environment.ground = scene::Ground{};
  const Poses start = plateAt(bricks[0], 0.01);
  contacts::ContactFinder finder(bricks, start, {}, environment, false, kTolerance);
  finder.startStep(start);
  std::vector<brick::Contact> contacts;
  for (int round = 0; round < 3; ++round) {
    EXPECT_GT(finder.appendViolated(plateAt(bricks[0], -0.05), contacts), 0.04);
    EXPECT_EQ(contacts.size(), 8u);
  }
}

TEST(ContactFinder, APlanarSceneHasNoGroundToFallThrough) {
  const std::vector<brick::Brick> bricks = {test::plate(0.2)};
  scene::Environment environment;
  environment.ground = scene::Ground{};
  const Poses start = plateAt(bricks[0], 0);
  contacts::ContactFinder finder(bricks, start, {}, environment, true, kTolerance);
  EXPECT_TRUE(findContacts(finder, start, plateAt(bricks[0], -1)).contacts.empty());
}

}  // namespace
}  // namespace kirireel
