// Contacts of all bricks in three stages.
//
// 1. The broad phase (contact_finder.h) lists pairs of convex pieces whose boxes overlap. Concave
//    bricks have several pieces, which never collide with each other.
// 2. Each listed pair that may touch is checked as a `BrickPair`, or as a `SpherePair` if one of
//    the two is a sphere. These store, from step to step, the features that separate the two.
// 3. A brick whose lowest vertex is below the ground gets a contact at each of its vertices. The
//    solver holds those that push.
//
// In this file bodies are numbered: first the bricks, then the parts of obstacles. Pairs are
// visited in the order of their numbers, so contacts have the same order on every machine. Contacts
// in the result have obstacle parts in world axes and the obstacle's own number.
//
// Bricks that share a corner are checked without that corner (pivotZone of an edge, see
// sim/brick/contact.h). Otherwise bricks joined on one face could not fold at all, because the
// edges at their joint already touch.
#include "sim/contacts/contact_finder.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include "sim/base/interruption.h"
#include "sim/contacts/bullet_values.h"

namespace kirireel::contacts {
namespace {

using Key = std::uint64_t;

Key pairKey(int pieceA, int pieceB) {
  return static_cast<Key>(pieceA) << 32 | static_cast<Key>(pieceB);
}

std::vector<brick::Brick> shapesOf(const std::vector<brick::BrickPiece>& pieces) {
  std::vector<brick::Brick> shapes;
  shapes.reserve(pieces.size());
  for (const brick::BrickPiece& piece : pieces) shapes.push_back(piece.shape);
  return shapes;
}

/// A convex piece of an obstacle: a box, a face of a mesh, a sphere.
struct ObstaclePart {
  brick::Brick body;             ///< its shape; of a sphere the cube round it
  Pose pose;                     ///< fixed
  std::optional<double> radius;  ///< of a sphere, metres
  double friction = 0;           ///< Coulomb coefficient
  int obstacle = 0;              ///< that it belongs to, >= 0
};

/// The parts of all obstacles, in order.
std::vector<ObstaclePart> obstacleParts(const std::vector<scene::Obstacle>& obstacles);

std::vector<brick::Brick> withParts(std::vector<brick::Brick> bricks,
                                    const std::vector<ObstaclePart>& parts) {
  for (const ObstaclePart& part : parts) bricks.push_back(part.body);
  return bricks;
}

/// The bricks, then the parts of obstacles, and the convex pieces of them all.
struct ContactBodies {
  ContactBodies(const std::vector<brick::Brick>& bricks, std::vector<ObstaclePart> obstacles)
      : brickCount(static_cast<int>(bricks.size())),
        parts(std::move(obstacles)),
        bodies(withParts(bricks, parts)),
        pieces(brick::convexPieces(bodies)),
        shapes(shapesOf(pieces)),
        firstPiece(bodies.size()) {
    // Backwards, so the first piece of each brick remains.
    for (std::size_t k = pieces.size(); k-- > 0;) {
      firstPiece[pieces[k].brick] = static_cast<int>(k);
    }
  }

  /// The obstacle's part that a body is; null for a brick.
  const ObstaclePart* partOf(int body) const {
    return body < brickCount ? nullptr : &parts[body - brickCount];
  }
  /// The poses of all bodies: those of the bricks if there are no obstacles, else `all`.
  const Poses& posesOf(const Poses& ofBricks, Poses& all) const {
    if (parts.empty()) return ofBricks;
    all = ofBricks;
    for (const ObstaclePart& part : parts) all.push_back(part.pose);
    return all;
  }
  brick::Contact given(brick::Contact contact) const;
  brick::Contact betweenBodies(brick::Contact contact) const;
  /// Pieces move with their bricks.
  Poses posesOfPieces(const Poses& poses) const {
    Poses placed;
    placed.reserve(pieces.size());
    for (const brick::BrickPiece& piece : pieces) placed.push_back(poses[piece.brick]);
    return placed;
  }

  int brickCount;
  std::vector<ObstaclePart> parts;
  std::vector<brick::Brick> bodies;
  std::vector<brick::BrickPiece> pieces;  // those of one body never collide with each other
  std::vector<brick::Brick> shapes;       // of the pieces
  std::vector<int> firstPiece;            // of each body
};

/// A contact of two bodies as others know it.
brick::Contact ContactBodies::given(brick::Contact contact) const {
  if (const ObstaclePart* part = partOf(contact.brickA)) {
    contact.partA = contact.brickA - brickCount;
    contact.brickA = brick::kFirstObstacle - part->obstacle;
    contact.pointA = part->pose.apply(contact.pointA);
    contact.edgeA = part->pose.rotation * contact.edgeA;
  } else if (const ObstaclePart* other = partOf(contact.brickB)) {
    contact.partB = contact.brickB - brickCount;
    contact.brickB = brick::kFirstObstacle - other->obstacle;
    contact.pointB = other->pose.apply(contact.pointB);
    contact.normal = other->pose.rotation * contact.normal;
  }
  return contact;
}

/// The inverse.
brick::Contact ContactBodies::betweenBodies(brick::Contact contact) const {
  if (!brick::isBrick(contact.brickA)) {
    const Pose& pose = parts[contact.partA].pose;
    contact.brickA = brickCount + std::exchange(contact.partA, 0);
    contact.pointA = pose.rotation.conjugate() * (contact.pointA - pose.position);
    contact.edgeA = pose.rotation.conjugate() * contact.edgeA;
  } else if (!brick::isBrick(contact.brickB)) {
    const Pose& pose = parts[contact.partB].pose;
    contact.brickB = brickCount + std::exchange(contact.partB, 0);
    contact.pointB = pose.rotation.conjugate() * (contact.pointB - pose.position);
    contact.normal = pose.rotation.conjugate() * contact.normal;
  }
  return contact;
}

}  // namespace

struct ContactFinder::Internals {
  Internals(const std::vector<brick::Brick>& bricks, const scene::Environment& surroundings)
      : bodies(bricks, obstacleParts(surroundings.obstacles)),
        environment(surroundings),
        near(bodies.shapes),
        wholeShapes(bodies.pieces.size()) {}

  /// The pair of two pieces, the smaller number first.
  BrickPair& pairOf(int a, int b);
  std::shared_ptr<const PieceShape> shapeOf(const brick::Brick& piece) const;
  std::shared_ptr<const PieceShape> wholeShape(int piece);
  const std::vector<SeparatingPlane>& planesOf(const Outline& a, const Outline& b);
  SpherePair& sphereOf(int piece, int sphere);
  bool mayTouch(int a, int b) const;
  void updatePairs(const Poses& from, const Poses& to);
  void listNearPairs();
  void transfer(StateTape& tape);
  double appendGround(int brick, const Pose& end, std::vector<brick::Contact>& contacts);
  double frictionWith(int a, int b) const;
  BrickPair* knownPair(const brick::Contact& contact);
  const BrickPair* knownPair(const brick::Contact& contact) const {
    return const_cast<Internals*>(this)->knownPair(contact);
  }

  const ContactBodies bodies;
  std::map<std::pair<int, int>, brick::SharedCorners> joined;
  scene::Environment environment;
  bool planar = false;
  double tolerance = 0;
  FaceContact faceContact = FaceContact::Region;
  long step = 0;
  double examined = 0;  // pairs so far
  Poses start;          // of all bodies
  Poses placed;         // the same elsewhere, see posesOf()
  NearPairs near;
  PairScratch scratch;
  std::map<std::array<std::size_t, 4>, std::vector<SeparatingPlane>> planeLists;  // of all pairs
  std::vector<std::shared_ptr<const PieceShape>> wholeShapes;  // of the pieces; null until needed
  std::unordered_map<Key, BrickPair> pairs;                    // of pieces that ever were near
  std::vector<BrickPair*> nearPairs;  // that are near now, in order of bricks
  std::unordered_map<Key, SpherePair> spheres;
  std::vector<SpherePair*> nearSpheres;
  std::vector<BrickPair*> overlapping;  // that overlapped at the start of the run
  std::vector<long> groundGiven;        // step of each brick's last ground contacts
};

BrickPair& ContactFinder::Internals::pairOf(int a, int b) {
  const Key key = pairKey(a, b);
  // Pairs are kept for the rest of the run, because their stored planes save more time than their
  // memory costs.
  const auto known = pairs.find(key);
  if (known != pairs.end()) return known->second;
  const brick::BrickPiece& pieceA = bodies.pieces[a];
  const brick::BrickPiece& pieceB = bodies.pieces[b];
  const auto add = [&](std::shared_ptr<const PieceShape> ofA,
                       std::shared_ptr<const PieceShape> ofB) -> BrickPair& {
    const std::vector<SeparatingPlane>& planes = planesOf(ofA->outline, ofB->outline);
    return pairs
        .try_emplace(key, OutlinedPiece{pieceA.brick, pieceA.part, std::move(ofA)},
                     OutlinedPiece{pieceB.brick, pieceB.part, std::move(ofB)}, planes, tolerance,
                     faceContact, scratch)
        .first->second;
  };
  const auto corners = joined.find({pieceA.brick, pieceB.brick});
  if (corners == joined.end() || environment.pivotZone == 0)
    return add(wholeShape(a), wholeShape(b));
  const double length = brick::cutLength(bodies.bodies[pieceA.brick], bodies.bodies[pieceB.brick],
                                         environment.pivotZone);
  return add(shapeOf(brick::withoutCorners(pieceA, corners->second.ofA, length)),
             shapeOf(brick::withoutCorners(pieceB, corners->second.ofB, length)));
}

// Planes are identified by numbers of faces and edges: pairs with equal counts have the same list.
const std::vector<SeparatingPlane>& ContactFinder::Internals::planesOf(const Outline& a,
                                                                       const Outline& b) {
  const std::array counts = {a.normals.size(), a.directions.size(), b.normals.size(),
                             b.directions.size()};
  const auto [list, isNew] = planeLists.try_emplace(counts);
  if (isNew) list->second = separatingPlanes(a, b);
  return list->second;
}

std::shared_ptr<const PieceShape> ContactFinder::Internals::shapeOf(
    const brick::Brick& piece) const {
  return std::make_shared<PieceShape>(makeOutline(piece, planar));
}

// Made for the first pair that needs it.
std::shared_ptr<const PieceShape> ContactFinder::Internals::wholeShape(int piece) {
  if (!wholeShapes[piece]) wholeShapes[piece] = shapeOf(bodies.shapes[piece]);
  return wholeShapes[piece];
}

// The pair of a piece of a brick and the piece of a sphere, created at the first use.
SpherePair& ContactFinder::Internals::sphereOf(int piece, int sphere) {
  const int body = bodies.pieces[sphere].brick;
  return spheres
      .try_emplace(pairKey(piece, sphere), bodies.pieces[piece].brick, body, bodies.shapes[piece],
                   *bodies.partOf(body)->radius, tolerance)
      .first->second;
}

/// Two bodies, the smaller number first.
bool ContactFinder::Internals::mayTouch(int a, int b) const {
  if (a == b) return false;
  // b has the larger number: an obstacle among the two is b. Obstacles do not collide with each
  // other.
  if (bodies.partOf(b)) return !bodies.partOf(a);
  const scene::ContactFilter contacts = environment.contacts;
  if (contacts != scene::ContactFilter::All && contacts != scene::ContactFilter::Unjoined)
    return false;
  const auto corners = joined.find({a, b});
  if (corners == joined.end()) return true;
  return contacts == scene::ContactFilter::All && !corners->second.areOneTile;
}

// Updates boxes for a move. The list of near pairs changes rarely.
void ContactFinder::Internals::updatePairs(const Poses& from, const Poses& to) {
  if (environment.contacts == scene::ContactFilter::None && bodies.parts.empty()) return;
  const bool areConvex = bodies.pieces.size() == bodies.bodies.size();
  const bool isNew = areConvex ? near.update(from, to)
                               : near.update(bodies.posesOfPieces(from), bodies.posesOfPieces(to));
  if (isNew) listNearPairs();
}

void ContactFinder::Internals::listNearPairs() {
  nearPairs.clear();
  nearSpheres.clear();
  for (const auto& [a, b] : near.pairs()) {
    checkInterruption();
    if (!mayTouch(bodies.pieces[a].brick, bodies.pieces[b].brick)) continue;
    const ObstaclePart* part = bodies.partOf(bodies.pieces[b].brick);
    if (part && part->radius) {
      nearSpheres.push_back(&sphereOf(a, b));
    } else {
      nearPairs.push_back(&pairOf(a, b));
    }
  }
}

void ContactFinder::Internals::transfer(StateTape& tape) {
  std::vector<std::pair<int, int>> known;
  for (const auto& [key, pair] : pairs)
    known.push_back({static_cast<int>(key >> 32), static_cast<int>(key & 0xffffffffU)});
  tape.transfer(near, known);
  // In playback, pairOf() makes the pair again, and the tape restores its state.
  for (const auto& [a, b] : known) pairOf(a, b).transfer(tape);
  if (tape.isPlaying()) listNearPairs();
}

// Coulomb's coefficient of a pair: an obstacle's own, else that between bricks.
double ContactFinder::Internals::frictionWith(int a, int b) const {
  const ObstaclePart* part = bodies.partOf(std::max(a, b));
  return part ? part->friction : environment.brickFriction;
}

/// The pair of a contact between bodies. Null for a sphere, and for a pair that was never near in
/// this finder; the contact is from another finder then.
BrickPair* ContactFinder::Internals::knownPair(const brick::Contact& contact) {
  const auto [pieceA, pieceB] = std::minmax({bodies.firstPiece[contact.brickA] + contact.partA,
                                             bodies.firstPiece[contact.brickB] + contact.partB});
  const auto found = pairs.find(pairKey(pieceA, pieceB));
  return found == pairs.end() ? nullptr : &found->second;
}

double ContactFinder::Internals::appendGround(int brick, const Pose& end,
                                              std::vector<brick::Contact>& contacts) {
  const double height = environment.ground->height;
  // Heights in brick axes: one product per vertex.
  const Vector3 up = end.rotation.conjugate() * Vector3::UnitZ();
  // The lowest vertex shows whether the brick is in the ground.
  double lowest = std::numeric_limits<double>::infinity();
  for (const std::vector<Vector3>* points :
       {&bodies.bodies[brick].bottom, &bodies.bodies[brick].top}) {
    for (const Vector3& point : *points) lowest = std::min(lowest, point.dot(up));
  }
  lowest += end.position.z();
  if (lowest >= height - tolerance) return 0;
  if (groundGiven[brick] == step) return height - lowest;
  groundGiven[brick] = step;
  for (const std::vector<Vector3>* points :
       {&bodies.bodies[brick].bottom, &bodies.bodies[brick].top}) {
    for (const Vector3& point : *points) {
      contacts.push_back({brick, brick::kFixed, point, Vector3(0, 0, height), Vector3::UnitZ()});
      contacts.back().friction = environment.ground->friction;
    }
  }
  return height - lowest;
}

ContactFinder::ContactFinder(const std::vector<brick::Brick>& bricks, const Poses& start,
                             std::span<const brick::Pivot> pivots,
                             const scene::Environment& environment, bool planar, double tolerance,
                             FaceContact faces)
    : internals_(std::make_unique<Internals>(bricks, environment)) {
  Internals& in = *internals_;
  in.groundGiven.assign(bricks.size(), -1);
  in.joined = brick::sharedCorners(pivots);
  in.planar = planar;
  in.tolerance = tolerance;
  in.faceContact = faces;
  in.start = in.bodies.posesOf(start, in.placed);
  in.updatePairs(in.start, in.start);
  for (BrickPair* pair : in.nearPairs) {
    checkInterruption();
    // Flush bricks of rounded models overlap slightly at the start of the run. They may keep that,
    // but obstacles allow no overlap.
    pair->keepOverlap(seenFrom(in.start[pair->a()], in.start[pair->b()]));
    if (pair->slack() > 0) in.overlapping.push_back(pair);
  }
}

ContactFinder::~ContactFinder() = default;

void ContactFinder::transfer(StateTape& tape) {
  internals_->transfer(tape);
}

void ContactFinder::startStep(const Poses& start) {
  Internals& in = *internals_;
  in.start = in.bodies.posesOf(start, in.placed);
  ++in.step;
  for (BrickPair* pair : in.overlapping) {
    pair->shrinkOverlap(seenFrom(in.start[pair->a()], in.start[pair->b()]));
  }
}

// Pairs of bricks, then spheres, then the ground.
double ContactFinder::appendViolated(const Poses& ofBricks, std::vector<brick::Contact>& contacts) {
  Internals& in = *internals_;
  const Poses& end = in.bodies.posesOf(ofBricks, in.placed);
  in.updatePairs(in.start, end);
  in.examined += static_cast<double>(in.nearPairs.size() + in.nearSpheres.size());
  double overlap = 0;
  const std::size_t first = contacts.size();
  for (BrickPair* pair : in.nearPairs) {
    checkInterruption();
    const PairMove move{seenFrom(in.start[pair->a()], in.start[pair->b()]),
                        seenFrom(end[pair->a()], end[pair->b()])};
    overlap = std::max(overlap, pair->appendViolated(move, in.step, contacts));
  }
  for (SpherePair* pair : in.nearSpheres) {
    const int brick = pair->brick();
    overlap = std::max(overlap,
                       pair->appendViolated(in.start[brick], end[brick],
                                            in.start[pair->sphere()].position, in.step, contacts));
  }
  for (std::size_t c = first; c < contacts.size(); ++c) {
    contacts[c].friction = in.frictionWith(contacts[c].brickA, contacts[c].brickB);
    contacts[c] = in.bodies.given(contacts[c]);
  }
  // A planar sheet on the ground never leaves it.
  if (in.environment.ground && !in.planar) {
    for (int i = 0; i < in.bodies.brickCount; ++i) {
      overlap = std::max(overlap, in.appendGround(i, end[i], contacts));
    }
  }
  return overlap;
}

double ContactFinder::pairsExamined() const {
  return internals_->examined;
}

std::optional<ObstacleOverlap> ContactFinder::overlapWithObstacle(const Poses& ofBricks) const {
  const Internals& in = *internals_;
  Poses placed;
  const Poses& poses = in.bodies.posesOf(ofBricks, placed);
  for (const BrickPair* pair : in.nearPairs) {
    const ObstaclePart* part = in.bodies.partOf(pair->b());
    if (part && pair->slack() > in.tolerance) return {{pair->a(), part->obstacle, pair->slack()}};
  }
  for (const SpherePair* pair : in.nearSpheres) {
    const Pose& brick = poses[pair->brick()];
    const double depth = pair->overlap(brick, poses[pair->sphere()].position);
    const int obstacle = in.bodies.partOf(pair->sphere())->obstacle;
    if (depth > in.tolerance) return {{pair->brick(), obstacle, depth}};
  }
  return std::nullopt;
}

bool ContactFinder::isCurrent(const brick::Contact& given) const {
  // The ground's contacts hold while they push.
  if (given.brickB == brick::kFixed) return true;
  const Internals& in = *internals_;
  const brick::Contact contact = in.bodies.betweenBodies(given);
  // The nearest points of a sphere's contact rotate with the brick. Each step finds them again.
  const BrickPair* pair = in.knownPair(contact);
  return pair && pair->isCurrent(contact, seenFrom(in.start[pair->a()], in.start[pair->b()]));
}

void ContactFinder::appendRegion(const brick::Contact& given,
                                 std::vector<brick::Contact>& contacts) {
  Internals& in = *internals_;
  const brick::Contact contact = in.bodies.betweenBodies(given);
  BrickPair* pair = in.knownPair(contact);
  if (!pair) return;
  const std::size_t first = contacts.size();
  pair->appendRegion(contact, seenFrom(in.start[pair->a()], in.start[pair->b()]), contacts);
  for (std::size_t c = first; c < contacts.size(); ++c) {
    contacts[c].friction = given.friction;
    contacts[c] = in.bodies.given(contacts[c]);
  }
}

double ContactFinder::insideBorders(const brick::Contact& given, const Poses& ofBricks) const {
  if (!given.isRegion) return std::numeric_limits<double>::infinity();
  const Internals& in = *internals_;
  const brick::Contact contact = in.bodies.betweenBodies(given);
  const BrickPair* pair = in.knownPair(contact);
  if (!pair) return std::numeric_limits<double>::infinity();
  Poses placed;
  const Poses& poses = in.bodies.posesOf(ofBricks, placed);
  return pair->insideBorders(contact, seenFrom(poses[pair->a()], poses[pair->b()]));
}

// ------------------------------------------------------------------------------------------------
// The broad phase: which pairs of convex bodies may collide in a step.
//
// Each body has a box around its positions at the start and at the end of a move, widened by the
// same margin for all. The list of pairs is valid while no body has moved by more than the margin
// since its box was made. Checking that needs only a bound on each body's motion:
//   |p' - p| + 2 |q' - q| r
// with the position p, the unit quaternion q and the distance r of the farthest point. Otherwise
// all boxes are set again, and Bullet's dynamic bounding volume tree lists the overlapping ones
// (O(n log n) for n bodies that are spread out).

namespace {

// Wider boxes give more pairs, narrower ones change more often.
constexpr double kMarginOfRadius = 0.05;

int number(const btBroadphaseProxy* proxy) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(proxy->m_clientObject));
}

// The box of all corners of a brick at a pose.
void extend(Eigen::AlignedBox3d& box, const brick::Brick& brick, const Pose& pose) {
  for (const std::vector<Vector3>* points : {&brick.bottom, &brick.top}) {
    for (const Vector3& point : *points) box.extend(pose.apply(point));
  }
}

}  // namespace

double motionBound(const Pose& from, const Pose& to, double radius) {
  // A rotation by an angle moves points by at most 2 sin(angle / 2) radii, and the quaternions by 2
  // sin(angle / 4).
  const double turned = (to.rotation.coeffs() - from.rotation.coeffs()).norm();
  return (to.position - from.position).norm() + 2 * turned * radius;
}

double outerRadius(const brick::Brick& brick) {
  double squared = 0;
  for (const Vector3& point : brick.bottom) squared = std::max(squared, point.squaredNorm());
  for (const Vector3& point : brick.top) squared = std::max(squared, point.squaredNorm());
  return std::sqrt(squared);
}

struct NearPairs::Internals {
  explicit Internals(const std::vector<brick::Brick>& all) : bricks(all), broadphase(&cache) {}
  ~Internals() {
    // For each proxy Bullet searches all pairs.
    cache.getOverlappingPairArray().clear();
    for (btBroadphaseProxy* proxy : proxies) broadphase.destroyProxy(proxy, nullptr);
  }

  bool anyLeft(const Poses& poses) const;
  void setBoxes();
  void setBox(int brick, const Eigen::AlignedBox3d& box);
  void listPairs();

  const std::vector<brick::Brick>& bricks;
  std::vector<double> radii;
  double margin = 0;
  Poses boxedFrom;  // the move of the boxes; empty before the first call
  Poses boxedTo;
  std::vector<Eigen::AlignedBox3d> boxes;
  btHashedOverlappingPairCache cache;
  btDbvtBroadphase broadphase;
  std::vector<btBroadphaseProxy*> proxies;
  std::vector<std::pair<int, int>> pairs;
};

// Whether any body may have left its box.
bool NearPairs::Internals::anyLeft(const Poses& poses) const {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (motionBound(boxedTo[i], poses[i], radii[i]) > margin) return true;
  }
  return false;
}

// Makes boxes for `boxedFrom` and `boxedTo`.
void NearPairs::Internals::setBoxes() {
  boxes.assign(bricks.size(), {});
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    checkInterruption();
    Eigen::AlignedBox3d& box = boxes[i];
    extend(box, bricks[i], boxedFrom[i]);
    extend(box, bricks[i], boxedTo[i]);
    const Vector3 wider = Vector3::Constant(margin);
    box = {box.min() - wider, box.max() + wider};
    setBox(static_cast<int>(i), box);
  }
  listPairs();
}

/// Makes a proxy on the first call, moves it afterwards.
void NearPairs::Internals::setBox(int brick, const Eigen::AlignedBox3d& box) {
  const btVector3 low = toBullet(box.min());
  const btVector3 high = toBullet(box.max());
  if (brick < static_cast<int>(proxies.size())) {
    broadphase.setAabb(proxies[brick], low, high, nullptr);
    return;
  }
  // The user pointer contains the brick's number.
  void* carried = reinterpret_cast<void*>(static_cast<std::intptr_t>(brick));
  proxies.push_back(broadphase.createProxy(low, high, BOX_SHAPE_PROXYTYPE, carried, 1, 1, nullptr));
}

/// Bullet's tree widens moving boxes and removes pairs late, so its pairs depend on all earlier
/// moves. These pairs depend only on the boxes.
void NearPairs::Internals::listPairs() {
  broadphase.calculateOverlappingPairs(nullptr);
  pairs.clear();
  const btBroadphasePairArray& found = cache.getOverlappingPairArray();
  for (int i = 0; i < found.size(); ++i) {
    const auto [a, b] = std::minmax({number(found[i].m_pProxy0), number(found[i].m_pProxy1)});
    if (boxes[a].intersects(boxes[b])) pairs.emplace_back(a, b);
  }
  // Sorted, because Bullet's order depends on the history of its tree.
  std::sort(pairs.begin(), pairs.end());
}

NearPairs::NearPairs(const std::vector<brick::Brick>& bricks)
    : internals_(std::make_unique<Internals>(bricks)) {
  double sum = 0;
  for (const brick::Brick& brick : bricks) {
    internals_->radii.push_back(outerRadius(brick));
    sum += internals_->radii.back();
  }
  if (!bricks.empty()) {
    internals_->margin = kMarginOfRadius * sum / static_cast<double>(bricks.size());
  }
}

NearPairs::~NearPairs() = default;

bool NearPairs::update(const Poses& start, const Poses& end) {
  Internals& in = *internals_;
  if (!in.boxedTo.empty() && !in.anyLeft(start) && !in.anyLeft(end)) return false;
  in.boxedFrom = start;
  in.boxedTo = end;
  in.setBoxes();
  return true;
}

void NearPairs::transfer(StateTape& tape) {
  Internals& in = *internals_;
  tape.transfer(in.boxedFrom, in.boxedTo);
  if (!tape.isPlaying()) return;
  // If recorded before the first update, there is no move with pairs.
  if (in.boxedTo.empty()) return in.pairs.clear();
  in.setBoxes();
}

const std::vector<std::pair<int, int>>& NearPairs::pairs() const {
  return internals_->pairs;
}

// ------------------------------------------------------------------------------------------------
// Obstacles as fixed bricks. A box is one brick. Each face of a mesh is a brick without thickness.
// A sphere is its bounding cube, for the broad phase, with its radius.

namespace {

ObstaclePart makePart(const model::Tile& floor, double thickness, double friction, int obstacle) {
  ObstaclePart part;
  part.body = brick::makeBrick(floor, {.thickness = thickness});
  part.pose = brick::startPoses({floor}, {part.body}).front();
  part.friction = friction;
  part.obstacle = obstacle;
  return part;
}

void append(const scene::Obstacle& obstacle, int number, std::vector<ObstaclePart>& parts) {
  const double diameter = 2 * obstacle.radius;
  switch (obstacle.shape) {
    case scene::Obstacle::Shape::Box:
      parts.push_back(makePart(scene::boxFloor(obstacle, obstacle.size), obstacle.size.z(),
                               obstacle.friction, number));
      return;
    case scene::Obstacle::Shape::Sphere:
      parts.push_back(makePart(scene::boxFloor(obstacle, Vector3::Constant(diameter)), diameter,
                               obstacle.friction, number));
      parts.back().radius = obstacle.radius;
      return;
    case scene::Obstacle::Shape::Mesh:
      for (const model::Tile& face : scene::obstacleFaces(obstacle)) {
        // A face without thickness works on both sides: no plane that held on one side at the start
        // holds on the other.
        parts.push_back(makePart(face, 0, obstacle.friction, number));
      }
  }
}

std::vector<ObstaclePart> obstacleParts(const std::vector<scene::Obstacle>& obstacles) {
  std::vector<ObstaclePart> parts;
  for (std::size_t k = 0; k < obstacles.size(); ++k) {
    append(obstacles[k], static_cast<int>(k), parts);
  }
  return parts;
}

}  // namespace

// ------------------------------------------------------------------------------------------------
// Whether two convex bricks may move from one relative pose to another in a step.
//
// Two disjoint convex bodies are separated by a plane of a face of either, or along an edge of each
// (the separating axis theorem). A step is collision-free if one plane, which moves with its
// feature, separates them at the start and at the end, or if one plane replaces another along the
// screw motion between the poses. The plane of the last step is checked first. A pair is checked
// only after its bricks could have moved by their distance, so most pairs cost a few comparisons
// per step.
//
// If no plane separates them, the plane that held at the start and is violated least at the end
// gives contacts: points of one brick that must not cross the plane of the other. Bricks that
// overlap at the start of a run may keep that overlap. The allowed overlap shrinks as they
// separate. Gottschalk, Lin and Manocha, "OBBTree", 1996, for the axes; Mirtich, "V-Clip", 1998,
// for features that are followed from step to step.
//

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Overlaps after a step are removed gradually. Meanwhile they may grow by the fraction kWorsening
// of the tolerance per step, up to kWorst tolerances.
constexpr double kWorsening = 0.1;
constexpr double kWorst = 7;
// Two planes whose normals agree to this cosine count as the same.
constexpr double kSameDirection = 0.999;
// Planes are equally good if their separations differ by less than this fraction of the tolerance
// and their normals agree to this cosine.
constexpr double kEqual = 1e-3;
constexpr double kNearDirection = 0.9;

// A point at most this far outside a face, in radii of the larger brick, still touches it.
constexpr double kTouching = 1e-3;

// Maximum changes of the separating plane of a pair within a step, and bisections for the moment of
// each change.
constexpr int kPlaneChanges = 4;
constexpr int kTouchBisections = 20;
// Below this angle the motion of a pair counts as straight, radians.
constexpr double kNoTurn = 1e-9;

/// A rotation about an axis and a translation along it. It keeps a pivot that two bricks share
/// fixed.
struct Screw {
  Vector3 turn = Vector3::Zero();  // rotation vector
  Vector3 centre = Vector3::Zero();
  Vector3 advance = Vector3::Zero();
};

/// The screw that takes one pose to another.
// The centre c of a screw with the angle p about the unit axis a satisfies
// to = c + R (from - c) + advance along a; with d the part of the displacement across a,
// c = from + (d + a x d / tan(p/2)) / 2.
Screw screwBetween(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turned(to.rotation * from.rotation.conjugate());
  Screw screw{Vector3::Zero(), from.position, to.position - from.position};
  // A pure translation has no finite centre.
  if (turned.angle() < kNoTurn) return screw;
  const Vector3& axis = turned.axis();
  const Vector3 across = screw.advance - axis.dot(screw.advance) * axis;
  screw.turn = turned.angle() * axis;
  screw.centre += 0.5 * (across + axis.cross(across) / std::tan(0.5 * turned.angle()));
  screw.advance -= across;
  return screw;
}

/// The pose at a fraction of a screw motion.
Pose poseAlong(const Screw& screw, const Pose& from, double part) {
  const Quaternion turn = rotationFromVector(part * screw.turn);
  return {screw.centre + part * screw.advance + turn * (from.position - screw.centre),
          turn * from.rotation};
}

// The farthest point of the outline from the brick's centre of mass, metres.
double outerRadius(const Outline& outline) {
  double radius = 0;
  for (const Vector3& point : outline.points) radius = std::max(radius, point.norm());
  return radius;
}

}  // namespace

// R_s^T (x - x_s), R_s^T R for the seer s.
Pose seenFrom(const Pose& seer, const Pose& seen) {
  const Quaternion back = seer.rotation.conjugate();
  return {back * (seen.position - seer.position), back * seen.rotation};
}

PieceShape::PieceShape(Outline ofPiece) : outline(std::move(ofPiece)) {
  placeOutline(outline, {}, placed);
}

BrickPair::BrickPair(OutlinedPiece a, OutlinedPiece b, const std::vector<SeparatingPlane>& planes,
                     double tolerance, FaceContact faces, PairScratch& scratch)
    : a_(std::move(a)),
      b_(std::move(b)),
      scratch_(scratch),
      radiusB_(outerRadius(outlineB())),
      touching_(kTouching * std::max(radiusB_, outerRadius(a_.shape->outline))),
      tolerance_(tolerance),
      faceContact_(faces),
      planes_(planes),
      last_(planes_.front()),
      clearance_(-kInfinity) {}

void BrickPair::keepOverlap(const Pose& startOfB) {
  // The largest separation over all planes is the distance of the two, or, if it is negative, minus
  // the smallest depth.
  placeOutline(outlineB(), startOfB, scratch_.startB);
  slack_ = std::max(0.0, -bestSeparationAtStart());
}

void BrickPair::shrinkOverlap(const Pose& startOfB) {
  placeOutline(outlineB(), startOfB, scratch_.startB);
  // Separated pairs must not overlap again.
  slack_ = std::min(slack_, std::max(0.0, -bestSeparationAtStart()));
}

/// Whether the pair cannot have moved by the distance between its bricks since the last check.
bool BrickPair::isSurelyApart(const PairMove& move) const {
  // An upper bound on the displacement of B's points. While it is below the last separation, no
  // plane is checked.
  return motionBound(checkedPose_, move.start, radiusB_) < clearance_ &&
         motionBound(checkedPose_, move.end, radiusB_) < clearance_;
}

double BrickPair::separationAtStart(const SeparatingPlane& plane) const {
  return separation(plane, placedA(), scratch_.startB);
}

double BrickPair::separationAtEnd(const SeparatingPlane& plane) const {
  return separation(plane, placedA(), scratch_.endB);
}

// The largest separation over all planes, metres.
double BrickPair::bestSeparationAtStart() const {
  double best = -kInfinity;
  for (const SeparatingPlane& plane : planes_) best = std::max(best, separationAtStart(plane));
  return best;
}

// Whether the separating plane of the last step separates the two at both ends of this one.
bool BrickPair::lastPlaneHolds() {
  const double after = separationAtEnd(last_);
  if (after < -tolerance_ - slack_) return false;
  if (separationAtStart(last_) < -tolerance_ - slack_) return false;
  // The separation along one plane is a lower bound of the distance.
  checkedPose_ = scratch_.endB.pose;
  clearance_ = after;
  return true;
}

// From the cheapest test to the most expensive: a bound on the motion, the last plane, all planes,
// changes of planes.
double BrickPair::appendViolated(const PairMove& move, long step,
                                 std::vector<brick::Contact>& contacts) {
  if (isSurelyApart(move)) return 0;
  placeOutline(outlineB(), move.start, scratch_.startB);
  placeOutline(outlineB(), move.end, scratch_.endB);
  if (lastPlaneHolds()) return 0;
  const double limit = -tolerance_ - slack_;
  const double bestBefore = bestSeparationAtStart();
  // Planes that hold at the start: within the tolerance, or the best one if the pair already
  // overlaps.
  const double held = std::min(limit, bestBefore);
  const double worsening = bestBefore > limit - kWorst * tolerance_ ? kWorsening * tolerance_ : 0;
  // An overlap above the tolerance may grow only slightly, since a solver removes it over several
  // steps.
  const double requested = std::min(limit, bestBefore - worsening);
  double bestAfter = -kInfinity;  // of the planes that held at the start
  for (const SeparatingPlane& plane : planes_) {
    // A plane that did not separate at the start proves nothing about the motion: B may have passed
    // through.
    if (separationAtStart(plane) < held) continue;
    const double after = separationAtEnd(plane);
    if (after <= bestAfter) continue;
    bestAfter = after;
    last_ = plane;
  }
  if (bestAfter >= requested) {
    checkedPose_ = move.end;
    clearance_ = bestAfter;
    return 0;
  }
  // The most expensive test is only for pairs that no single plane separates.
  if (isSeparatedInTurn(move)) return 0;
  // No plane separates the pair.
  for (const SeparatingPlane* plane : planesToGive(step)) givePlane(*plane, contacts);
  return std::max(0.0, -bestAfter - slack_);
}

/// Whether consecutive planes separate the pair, as for bricks that rotate around a corner: each
/// plane must hold until the next one does. The allowed initial overlap is not used here: if it
/// exceeds the thickness, the bricks could pass through each other.
bool BrickPair::isSeparatedInTurn(const PairMove& move) const {
  const Screw screw = screwBetween(move.start, move.end);
  PlacedOutline placedB = scratch_.startB;
  const auto holds = [&](const SeparatingPlane& plane) {
    return separation(plane, placedA(), placedB) >= -tolerance_;
  };
  const auto ends = [&](const SeparatingPlane& plane) {
    return separationAtEnd(plane) >= -tolerance_;
  };
  double reached = 0;
  for (int change = 0; change < kPlaneChanges; ++change) {
    std::vector<SeparatingPlane> holding;
    std::copy_if(planes_.begin(), planes_.end(), std::back_inserter(holding), holds);
    if (std::any_of(holding.begin(), holding.end(), ends)) return true;
    // Bisect for the last moment at which one of them holds.
    double lost = 1;
    const double from = reached;
    for (int round = 0; round < kTouchBisections; ++round) {
      const double part = 0.5 * (reached + lost);
      placeOutline(outlineB(), poseAlong(screw, move.start, part), placedB);
      (std::any_of(holding.begin(), holding.end(), holds) ? reached : lost) = part;
    }
    // No plane separates them, so the two collide.
    if (reached == from) return false;
    placeOutline(outlineB(), poseAlong(screw, move.start, reached), placedB);
  }
  return false;
}

/// The new steady planes with the largest gap at the start and the least violation at the end: one,
/// or several that are equally good. Empty if there is none.
std::vector<const SeparatingPlane*> BrickPair::planesToGive(long step) {
  std::vector<const SeparatingPlane*> candidates;
  double best = -kInfinity;
  for (const SeparatingPlane& plane : planes_) {
    if (!isSteady(plane, placedA(), scratch_.startB)) continue;
    best = std::max(best, separationAtStart(plane));
    if (canGive(plane, step)) candidates.push_back(&plane);
  }
  const double equal = faceContact_ == FaceContact::Planes ? kEqual * tolerance_ : 0;
  const double held = std::min(-tolerance_ - slack_, best - equal);
  std::erase_if(candidates, [&](const auto* plane) { return separationAtStart(*plane) < held; });
  if (candidates.empty()) return {};
  const auto after = [&](const auto* plane) { return separationAtEnd(*plane); };
  const auto least = std::ranges::max_element(candidates, {}, after);
  if (equal == 0) return {*least};
  // The planes of two faces that mirror each other. Planes in other directions are alternatives,
  // and edges on a face repeat it.
  const double violated = after(*least) - equal;
  const Vector3 normal = planeNormal(**least, placedA(), scratch_.startB);
  std::erase_if(candidates, [&](const auto* plane) {
    return after(plane) < violated ||
           planeNormal(*plane, placedA(), scratch_.startB).dot(normal) < kNearDirection;
  });
  const auto isEdge = [](const auto* plane) { return plane->kind == SeparatingPlane::Kind::Edges; };
  if (!std::ranges::all_of(candidates, isEdge)) std::erase_if(candidates, isEdge);
  return candidates;
}

/// Whether contacts on this plane would be new in this step.
bool BrickPair::canGive(const SeparatingPlane& plane, long step) {
  if (givenStep_ != step) {
    given_.clear();
    corners_.clear();
  }
  givenStep_ = step;
  return std::find(given_.begin(), given_.end(), plane) == given_.end();
}

/// Sets the common fields of the pair's contacts.
void BrickPair::finishContacts(std::vector<brick::Contact>& contacts) const {
  for (brick::Contact& contact : contacts) {
    const bool onA = contact.brickA == a_.brick;
    // The overlap from the start of the run moves the contact's zero.
    contact.slack = slack_;
    contact.partA = onA ? a_.part : b_.part;
    contact.partB = onA ? b_.part : a_.part;
  }
}

/// Removes the corners of regions that were already appended in this step, and those that do not
/// hold at its start: edges that cross at the end may have passed each other.
void BrickPair::keepNew(std::vector<brick::Contact>& contacts) const {
  std::erase_if(contacts, [this](brick::Contact contact) {
    const bool isRegion = std::exchange(contact.isRegion, true);
    if (std::ranges::find(corners_, contact) != corners_.end()) return true;
    const bool onA = contact.brickA == a_.brick;
    contact.brickA = onA ? 0 : 1;
    contact.brickB = onA ? 1 : 0;
    const double gap = brick::contactGap(contact, {Pose{}, scratch_.startB.pose});
    return isRegion && gap < -kWorst * tolerance_;
  });
}

/// First the region at the start of the step. If that does not keep the pair apart, or the faces do
/// not overlap, the region at the end of the step. Then all points of one brick against the plane.
void BrickPair::givePlane(const SeparatingPlane& plane, std::vector<brick::Contact>& contacts) {
  last_ = plane;
  std::vector<brick::Contact> found;
  for (const PlacedOutline* b : {&scratch_.startB, &scratch_.endB}) {
    if (faceContact_ != FaceContact::Region) break;
    appendRegionContacts(planeNormal(plane, placedA(), *b),
                         plane.kind == SeparatingPlane::Kind::Edges ? &plane : nullptr, a_.brick,
                         b_.brick, placedA(), *b, found);
    finishContacts(found);
    keepNew(found);
    if (!found.empty()) break;
  }
  corners_.insert(corners_.end(), found.begin(), found.end());
  if (found.empty()) {
    given_.push_back(plane);
    appendPlaneContacts(plane, a_.brick, b_.brick, placedA(), scratch_.startB, found);
    finishContacts(found);
    keepNew(found);
  }
  contacts.insert(contacts.end(), found.begin(), found.end());
}

/// The contact's normal from B towards A of the pair, in A's axes.
Vector3 BrickPair::normalOf(const brick::Contact& contact, const PlacedOutline& placedB) const {
  // The contact's first brick may be B of the pair; its normal then has the opposite sign.
  const bool swapped = contact.brickA != a_.brick;
  brick::Contact numbered = contact;
  numbered.brickA = swapped ? 1 : 0;
  numbered.brickB = swapped ? 0 : 1;
  return (swapped ? -1 : 1) * brick::contactNormal(numbered, {Pose{}, placedB.pose});
}

void BrickPair::appendRegion(const brick::Contact& contact, const Pose& startOfB,
                             std::vector<brick::Contact>& contacts) const {
  PlacedOutline placedB;
  placeOutline(outlineB(), startOfB, placedB);
  std::vector<brick::Contact> found;
  appendRegionContacts(normalOf(contact, placedB), nullptr, a_.brick, b_.brick, placedA(), placedB,
                       found);
  finishContacts(found);
  // If only edges cross, their crossing is the region while it exists.
  if (found.empty() && contact.isEdge && insideBorders(contact, startOfB) >= 0)
    found.push_back(contact);
  contacts.insert(contacts.end(), found.begin(), found.end());
}

double BrickPair::insideBorders(const brick::Contact& contact, const Pose& poseOfB) const {
  PlacedOutline placedB;
  placeOutline(outlineB(), poseOfB, placedB);
  const bool swapped = contact.brickA != a_.brick;
  return contacts::insideBorders(contact, swapped ? placedB : placedA(),
                                 swapped ? placedA() : placedB);
}

bool BrickPair::isCurrent(const brick::Contact& contact, const Pose& startOfB) const {
  PlacedOutline placedB;
  placeOutline(outlineB(), startOfB, placedB);
  return touches(contact, placedB) || !isApartOtherwise(contact, placedB);
}

/// Whether the contact's point lies on its face, not outside.
bool BrickPair::touches(const brick::Contact& contact, const PlacedOutline& placedB) const {
  // A contact of two edges has no face.
  if (contact.isEdge) return false;
  const bool onA = contact.brickA == a_.brick;
  const PlacedOutline& other = onA ? placedB : placedA();
  const Vector3 point = (onA ? placedA() : placedB).pose.apply(contact.pointA);
  for (std::size_t f = 0; f < other.normals.size(); ++f) {
    const Vector3& onFace = other.points[other.outline->facePoints[f]];
    // Beyond the plane of any face, the point is outside the other brick, so it cannot touch the
    // face within its borders.
    if (other.normals[f].dot(point - onFace) > touching_) return false;
  }
  return true;
}

/// Whether a plane other than the contact's separates the pair at the start of the step.
bool BrickPair::isApartOtherwise(const brick::Contact& contact,
                                 const PlacedOutline& placedB) const {
  const Vector3 normal = normalOf(contact, placedB);
  return std::any_of(planes_.begin(), planes_.end(), [&](const SeparatingPlane& plane) {
    return plane.kind != SeparatingPlane::Kind::Edges &&
           planeNormal(plane, placedA(), placedB).dot(normal) < kSameDirection &&
           separation(plane, placedA(), placedB) >= -tolerance_ - slack_;
  });
}

// ------------------------------------------------------------------------------------------------
// Planes between two convex bodies A and B by the separating axis theorem.
//
// Two disjoint convex polyhedra are separated by a plane parallel to a face of either, or parallel
// to an edge of each (S. Gottschalk, M. C. Lin, D. Manocha, OBBTree, SIGGRAPH 1996). With the unit
// normal n from B towards A,
//   s = min over A of (p . n) - max over B of (p . n)             metres
// is the separation: positive if they are apart, negative if they overlap along n. For a face of B,
// n is its outward normal, and the maximum over B is at any point of the face. For edges,
// n = +-(e_A x e_B) / |e_A x e_B|, with a separate plane for each sign. A plane keeps its sign from
// step to step.
//
// A prism over a polygon with k corners has k + 2 faces and up to k + 1 edge directions. In the
// plane only its k side faces count.

namespace {

using Kind = SeparatingPlane::Kind;

// Below this sine two edges span no plane.
constexpr double kParallelEdges = 1e-6;
// Below this sine the plane of two edges rotates too fast to be held.
constexpr double kSteady = 0.05;
// Projections of points that differ by less than this fraction of an edge are equal.
constexpr double kTie = 1e-9;

// The smallest projection of the points on a direction.
double lowest(const std::vector<Vector3>& points, const Vector3& direction) {
  double low = std::numeric_limits<double>::infinity();
  for (const Vector3& point : points) low = std::min(low, point.dot(direction));
  return low;
}

void addDirection(Outline& outline, const Vector3& edge) {
  const Vector3 direction = edge.normalized();
  const bool known =
      // Parallel edges span the same planes, so they count once.
      std::any_of(outline.directions.begin(), outline.directions.end(),
                  [&](const Vector3& other) { return other.cross(direction).norm() < 1e-9; });
  if (!known) outline.directions.push_back(direction);
}

/// The point with the largest projection on a direction. For an edge across it, the first end.
const Vector3& farthest(const PlacedOutline& placed, const Vector3& direction, int& index) {
  // Both ends of an edge across the direction have the same projection. Rounding must not choose
  // between them.
  const double tie = kTie * (placed.points[1] - placed.points[0]).norm();
  index = 0;
  for (int p = 1; p < static_cast<int>(placed.points.size()); ++p) {
    if (placed.points[p].dot(direction) > placed.points[index].dot(direction) + tie) index = p;
  }
  return placed.outline->points[index];
}

/// Contacts of one body's points against a face of the other.
void appendFaceContacts(int pointBrick, int faceBrick, int face, const Outline& points,
                        const Outline& faces, std::vector<brick::Contact>& contacts) {
  for (const Vector3& point : points.points) {
    contacts.push_back(
        {pointBrick, faceBrick, point, faces.points[faces.facePoints[face]], faces.normals[face]});
  }
}

/// Contacts of all points of either brick against the other's farthest point, along the normal of
/// an edge of each.
void appendEdgeContacts(const SeparatingPlane& plane, int brickA, int brickB,
                        const PlacedOutline& a, const PlacedOutline& b,
                        std::vector<brick::Contact>& contacts) {
  const Vector3 normal = planeNormal(plane, a, b);
  int nearestA = 0;
  int nearestB = 0;
  brick::Contact contact{brickA, brickB, farthest(a, -normal, nearestA),
                         farthest(b, normal, nearestB), b.outline->directions[plane.b]};
  contact.isEdge = true;
  contact.edgeA = plane.sign * a.outline->directions[plane.a];
  const Vector3 pointA = contact.pointA;
  for (const Vector3& point : a.outline->points) {
    contact.pointA = point;
    contacts.push_back(contact);
  }
  contact.pointA = pointA;
  for (int p = 0; p < static_cast<int>(b.outline->points.size()); ++p) {
    // That pair of points is already among those of A.
    if (p == nearestB) continue;
    contact.pointB = b.outline->points[p];
    contacts.push_back(contact);
  }
}

}  // namespace

Outline makeOutline(const brick::Brick& brick, bool planar) {
  Outline outline;
  const int count = static_cast<int>(brick.bottom.size());
  outline.points = brick.bottom;
  if (!planar) {
    outline.points.insert(outline.points.end(), brick.top.begin(), brick.top.end());
    outline.normals = {-brick.normal, brick.normal};
    outline.facePoints = {0, count};
    outline.faces.resize(2);
    for (int k = 0; k < count; ++k) {
      outline.faces[0].push_back(count - 1 - k);
      outline.faces[1].push_back(count + k);
    }
  }
  for (int k = 0; k < count; ++k) {
    const int next = (k + 1) % count;
    const Vector3 edge = brick.bottom[next] - brick.bottom[k];
    outline.normals.push_back(edge.cross(brick.normal).normalized());
    outline.facePoints.push_back(k);
    outline.faces.push_back({k, next});
    if (planar) continue;
    outline.faces.back() = {k, next, count + next, count + k};
    addDirection(outline, edge);
    addDirection(outline, brick.normal);
  }
  return outline;
}

// Reuses the memory of `placed`, because each step calls this for each pair.
void placeOutline(const Outline& outline, const Pose& pose, PlacedOutline& placed) {
  // A matrix for all points is cheaper than the quaternion.
  const Matrix3 R = pose.rotation.toRotationMatrix();
  const auto turn = [&](const std::vector<Vector3>& from, std::vector<Vector3>& to) {
    to.resize(from.size());
    for (std::size_t i = 0; i < from.size(); ++i) to[i] = R * from[i];
  };
  placed.outline = &outline;
  placed.pose = pose;
  turn(outline.points, placed.points);
  turn(outline.normals, placed.normals);
  turn(outline.directions, placed.directions);
  for (Vector3& point : placed.points) point += pose.position;
}

// Faces come first, because they are cheaper and separate most pairs.
std::vector<SeparatingPlane> separatingPlanes(const Outline& a, const Outline& b) {
  std::vector<SeparatingPlane> planes;
  for (int f = 0; f < static_cast<int>(a.normals.size()); ++f) {
    planes.push_back({Kind::FaceOfA, f, 0, 1});
  }
  for (int f = 0; f < static_cast<int>(b.normals.size()); ++f) {
    planes.push_back({Kind::FaceOfB, 0, f, 1});
  }
  for (int i = 0; i < static_cast<int>(a.directions.size()); ++i) {
    for (int j = 0; j < static_cast<int>(b.directions.size()); ++j) {
      planes.push_back({Kind::Edges, i, j, 1});
      planes.push_back({Kind::Edges, i, j, -1});
    }
  }
  return planes;
}

Vector3 planeNormal(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  switch (plane.kind) {
    case Kind::FaceOfA:
      return -a.normals[plane.a];
    case Kind::FaceOfB:
      return b.normals[plane.b];
    case Kind::Edges:
      break;
  }
  const Vector3 product = a.directions[plane.a].cross(b.directions[plane.b]);
  const double length = product.norm();
  return length < kParallelEdges ? Vector3::Zero() : Vector3(plane.sign / length * product);
}

double separation(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  if (plane.kind == Kind::FaceOfA) {
    const Vector3& normal = a.normals[plane.a];
    return lowest(b.points, normal) - normal.dot(a.points[a.outline->facePoints[plane.a]]);
  }
  if (plane.kind == Kind::FaceOfB) {
    const Vector3& normal = b.normals[plane.b];
    return lowest(a.points, normal) - normal.dot(b.points[b.outline->facePoints[plane.b]]);
  }
  const Vector3 normal = planeNormal(plane, a, b);
  if (normal.isZero(0)) return -std::numeric_limits<double>::infinity();
  return lowest(a.points, normal) + lowest(b.points, -normal);
}

bool isSteady(const SeparatingPlane& plane, const PlacedOutline& a, const PlacedOutline& b) {
  return plane.kind != Kind::Edges ||
         a.directions[plane.a].cross(b.directions[plane.b]).norm() > kSteady;
}

void appendPlaneContacts(const SeparatingPlane& plane, int brickA, int brickB,
                         const PlacedOutline& a, const PlacedOutline& b,
                         std::vector<brick::Contact>& contacts) {
  switch (plane.kind) {
    case Kind::FaceOfA:
      return appendFaceContacts(brickB, brickA, plane.a, *b.outline, *a.outline, contacts);
    case Kind::FaceOfB:
      return appendFaceContacts(brickA, brickB, plane.b, *a.outline, *b.outline, contacts);
    case Kind::Edges:
      return appendEdgeContacts(plane, brickA, brickB, a, b, contacts);
  }
}

// ------------------------------------------------------------------------------------------------
// The region in which two bricks touch: the polygon in which a face of each overlap, seen along the
// normal between them. Each of its corners is a contact of two features: a corner of one brick on
// the face of the other, or two edges that cross. Every contact point therefore lies on both
// bricks, and stays on the features while bricks slide.

namespace {

// Faces within this angle of the plane between two bricks may touch as faces, cosine of 0.2 rad.
constexpr double kFlat = 0.98;
// A face across the normal up to this cosine touches the other one at any angle.
constexpr double kLevel = 1 - 1e-6;
// Edges whose common normal is farther from the region's than 60 degrees do not cross: they are
// parallel as seen from the side.
constexpr double kUpright = 0.5;
// Corners of a region closer than this fraction of an edge are the same.
constexpr double kOneCorner = 1e-9;
// Below this sine edges of faces that touch count as parallel.
constexpr double kNoCrossing = 1e-9;

/// A face of a placed outline.
struct PlacedFace {
  const PlacedOutline& placed;
  int number = 0;

  const std::vector<int>& corners() const { return placed.outline->faces[number]; }
  const Vector3& normal() const { return placed.normals[number]; }
  std::size_t size() const { return corners().size(); }
  const Vector3& corner(std::size_t k) const { return placed.points[corners()[k % size()]]; }
  /// In brick axes.
  const Vector3& ownCorner(std::size_t k) const {
    return placed.outline->points[corners()[k % size()]];
  }
};

/// Distance of a point from the sides of a face, seen along its normal, metres; > 0 inside.
double insideFace(const PlacedFace& face, const Vector3& point) {
  double least = std::numeric_limits<double>::infinity();
  // A face of a planar scene is a segment. Both of its ends are sides.
  const bool isSegment = face.size() == 2;
  for (std::size_t k = 0; k < face.size(); ++k) {
    const Vector3 edge = face.corner(k + 1) - face.corner(k);
    const double length = edge.norm();
    if (length == 0) continue;
    const Vector3 inwards = isSegment ? edge : face.normal().cross(edge);
    least = std::min(least, inwards.dot(point - face.corner(k)) / length);
  }
  return least;
}

/// The face whose normal is nearest to a direction.
PlacedFace faceAlong(const PlacedOutline& placed, const Vector3& direction) {
  const auto most = std::ranges::max_element(
      placed.normals, {}, [&](const Vector3& normal) { return normal.dot(direction); });
  return {placed, static_cast<int>(most - placed.normals.begin())};
}

/// An edge of a placed outline, in brick axes and in world axes.
struct PlacedEdge {
  Vector3 ownFrom;
  Vector3 ownEdge;
  Vector3 from;
  Vector3 edge;
};

PlacedEdge edgeOf(const PlacedOutline& placed, int from, int to) {
  const std::vector<Vector3>& own = placed.outline->points;
  return {own[from], own[to] - own[from], placed.points[from],
          placed.points[to] - placed.points[from]};
}

/// Collects the corners of a region.
class RegionMaker {
 public:
  RegionMaker(int brickA, int brickB, const Vector3& normal, double closest,
              std::vector<brick::Contact>& contacts)
      : brickA_(brickA), brickB_(brickB), normal_(normal), closest_(closest), contacts_(contacts) {}

  /// Corners of one face that lie over the other.
  void addCorners(const PlacedFace& points, const PlacedFace& face, bool areOfA) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (insideFace(face, points.corner(k)) < -closest_) continue;
      add(points.corner(k), onFace(points.ownCorner(k), face, areOfA));
    }
  }

  /// Crossings of the edges of two faces.
  void addCrossings(const PlacedFace& a, const PlacedFace& b) {
    if (a.size() == 2) return;  // of a planar scene
    for (std::size_t i = 0; i < a.size(); ++i) {
      for (std::size_t j = 0; j < b.size(); ++j) addCrossing(a, i, b, j);
    }
  }

  /// Adds nothing if the two do not cross.
  void addCrossing(const PlacedEdge& a, const PlacedEdge& b) {
    const Vector3 across = a.edge.cross(b.edge);
    if (across.norm() <= kNoCrossing * a.edge.norm() * b.edge.norm()) return;
    const auto [onA, onB] = nearestOnLines(a.from, a.edge, b.from, b.edge);
    if (!isWithin(onA) || !isWithin(onB)) return;
    brick::Contact contact{brickA_, brickB_, a.ownFrom, b.ownFrom, b.ownEdge.normalized()};
    contact.isEdge = true;
    contact.edgeA = (across.dot(normal_) > 0 ? 1 : -1) * a.ownEdge.normalized();
    add(a.from + onA * a.edge, contact);
  }

 private:
  // Up to rounding: a corner on a border counts in at least one of its two tests.
  static bool isWithin(double share) { return share >= -kOneCorner && share <= 1 + kOneCorner; }

  brick::Contact onFace(const Vector3& ownPoint, const PlacedFace& face, bool isOfA) const {
    const Outline& outline = *face.placed.outline;
    return {isOfA ? brickA_ : brickB_, isOfA ? brickB_ : brickA_, ownPoint,
            outline.points[outline.facePoints[face.number]], outline.normals[face.number]};
  }

  void addCrossing(const PlacedFace& a, std::size_t i, const PlacedFace& b, std::size_t j) {
    const PlacedEdge ofA = edgeOf(a.placed, a.corners()[i], a.corners()[(i + 1) % a.size()]);
    const PlacedEdge ofB = edgeOf(b.placed, b.corners()[j], b.corners()[(j + 1) % b.size()]);
    const Vector3 across = ofA.edge.cross(ofB.edge);
    const double lengths = ofA.edge.norm() * ofB.edge.norm();
    const double along = across.dot(normal_);
    if (std::abs(along) > std::max(kSteady * lengths, kUpright * across.norm()))
      return addCrossing(ofA, ofB);
    if (!(std::abs(along) > kNoCrossing * lengths)) return;
    // The normal of other edges rotates too fast or lies in the faces. So this is a point of one
    // edge on the face of the other that is more nearly across.
    const Vector3 between = ofB.from - ofA.from;
    const double onA = between.cross(ofB.edge).dot(normal_) / along;
    const double onB = between.cross(ofA.edge).dot(normal_) / along;
    if (!isWithin(onA) || !isWithin(onB)) return;
    const bool isOfA = b.normal().dot(normal_) >= -a.normal().dot(normal_);
    const Vector3 own = isOfA ? ofA.ownFrom + onA * ofA.ownEdge : ofB.ownFrom + onB * ofB.ownEdge;
    add(ofA.from + onA * ofA.edge, onFace(own, isOfA ? b : a, isOfA));
  }

  void add(const Vector3& place, brick::Contact contact) {
    const bool isKnown = std::ranges::any_of(
        places_, [&](const Vector3& other) { return (place - other).norm() <= closest_; });
    if (isKnown) return;
    places_.push_back(place);
    contact.isRegion = true;
    contacts_.push_back(std::move(contact));
  }

  int brickA_, brickB_;
  const Vector3& normal_;
  double closest_;
  std::vector<brick::Contact>& contacts_;
  std::vector<Vector3> places_;
};

/// The ends of the edge of a brick through one of its corners along a direction.
std::pair<int, int> endsOfEdge(const PlacedOutline& placed, int corner, const Vector3& direction) {
  for (const std::vector<int>& face : placed.outline->faces) {
    for (std::size_t k = 0; k < face.size(); ++k) {
      const int from = face[k], to = face[(k + 1) % face.size()];
      if (from != corner && to != corner) continue;
      const Vector3 edge = placed.points[to] - placed.points[from];
      if (edge.cross(direction).norm() <= kParallelEdges * edge.norm()) return {from, to};
    }
  }
  return {corner, corner};
}

/// Distance of a point from the ends of the edge that begins at a corner in brick axes, metres.
double insideEdge(const PlacedOutline& placed, const Vector3& ownCorner, const Vector3& direction,
                  const Vector3& point) {
  const auto corner = std::ranges::min_element(
      placed.outline->points, {}, [&](const Vector3& other) { return (other - ownCorner).norm(); });
  const auto [from, to] =
      endsOfEdge(placed, static_cast<int>(corner - placed.outline->points.begin()), direction);
  const double a = direction.dot(point - placed.points[from]);
  const double b = direction.dot(point - placed.points[to]);
  return std::min(std::max(a, b), std::max(-a, -b));
}

}  // namespace

void appendRegionContacts(const Vector3& normal, const SeparatingPlane* edges, int brickA,
                          int brickB, const PlacedOutline& a, const PlacedOutline& b,
                          std::vector<brick::Contact>& contacts) {
  const PlacedFace faceA = faceAlong(a, -normal), faceB = faceAlong(b, normal);
  RegionMaker region(brickA, brickB, normal, kOneCorner * (a.points[1] - a.points[0]).norm(),
                     contacts);
  const auto [tilted, level] =
      std::minmax({-faceA.normal().dot(normal), faceB.normal().dot(normal)});
  if (level >= kLevel || tilted >= kFlat) {
    region.addCorners(faceA, faceB, true);
    region.addCorners(faceB, faceA, false);
    region.addCrossings(faceA, faceB);
  } else if (edges) {
    int cornerA = 0, cornerB = 0;
    farthest(a, -normal, cornerA);
    farthest(b, normal, cornerB);
    const auto [fromA, toA] = endsOfEdge(a, cornerA, a.directions[edges->a]);
    const auto [fromB, toB] = endsOfEdge(b, cornerB, b.directions[edges->b]);
    if (fromA != toA && fromB != toB)
      region.addCrossing(edgeOf(a, fromA, toA), edgeOf(b, fromB, toB));
  }
}

double insideBorders(const brick::Contact& ofBricks, const PlacedOutline& a,
                     const PlacedOutline& b) {
  brick::Contact contact = ofBricks;
  contact.brickA = 0;
  contact.brickB = 1;
  const auto [onA, onB] = brick::contactPoints(contact, {a.pose, b.pose});
  if (contact.isEdge) {
    return std::min(insideEdge(a, contact.pointA, a.pose.rotation * contact.edgeA, onA),
                    insideEdge(b, contact.pointB, b.pose.rotation * contact.normal, onB));
  }
  return insideFace(faceAlong(b, b.pose.rotation * contact.normal), onA);
}

// ------------------------------------------------------------------------------------------------
// A convex brick and a sphere with the centre c and radius R, in brick axes.
//
// The point of the brick that is nearest to c is on a face if c projects into the face, else on an
// edge or at a corner. Inside the brick all heights h = n . (c - f) over the faces are negative,
// and the face with the largest height is nearest. The pair overlaps by R - distance. The contact
// plane is the face, or else the sphere's tangent plane at the nearest point. A convex brick has
// one nearest point, so one contact per pair is enough. The cases are in C. Ericson, Real-Time
// Collision Detection, 2005, section 5.1.

namespace {

// Whether the point projects into the face, seen along its normal.
bool isOverFace(const std::vector<Vector3>& face, const Vector3& normal, const Vector3& point) {
  for (std::size_t k = 0; k < face.size(); ++k) {
    const Vector3 edge = face[(k + 1) % face.size()] - face[k];
    if (edge.cross(point - face[k]).dot(normal) < 0) return false;
  }
  return true;
}

// The point must not lie on the edge, where the direction is not defined.
NearestPoint nearestOnEdge(const Vector3& from, const Vector3& to, const Vector3& point) {
  const Vector3 nearest = nearestOnSegment(point, from, to);
  const double distance = (point - nearest).norm();
  return {nearest, (point - nearest) / distance, distance, false};
}

}  // namespace

NearestPoint nearestPoint(const std::vector<std::vector<Vector3>>& faces, const Vector3& to) {
  NearestPoint nearest{{}, {}, std::numeric_limits<double>::infinity()};
  NearestPoint within{{}, {}, -std::numeric_limits<double>::infinity()};
  for (const std::vector<Vector3>& face : faces) {
    const Vector3 normal = doubledVectorArea(face).normalized();
    const double height = normal.dot(to - face[0]);
    const NearestPoint onFace{to - height * normal, normal, height};
    if (height > within.distance) within = onFace;
    // Faces that point away from the centre cannot have the nearest point, unless the centre is
    // inside.
    if (height <= 0) continue;
    if (isOverFace(face, normal, to)) return onFace;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const NearestPoint onEdge = nearestOnEdge(face[k], face[(k + 1) % face.size()], to);
      if (onEdge.distance < nearest.distance) nearest = onEdge;
    }
  }
  return within.distance <= 0 ? within : nearest;
}

SpherePair::SpherePair(int brick, int sphere, const brick::Brick& shape, double radius,
                       double tolerance)
    : brick_(brick),
      sphere_(sphere),
      faces_(brick::brickFaces(shape)),
      radius_(radius),
      tolerance_(tolerance) {}

NearestPoint SpherePair::nearest(const Pose& brick, const Vector3& centre) const {
  return nearestPoint(faces_, brick.rotation.conjugate() * (centre - brick.position));
}

double SpherePair::overlap(const Pose& brick, const Vector3& centre) const {
  return std::max(0.0, radius_ - nearest(brick, centre).distance);
}

// The contact of the nearest feature at a pose. The step keeps it.
brick::Contact SpherePair::contactAt(const Pose& brick, const Vector3& centre) const {
  const NearestPoint near = nearest(brick, centre);
  brick::Contact contact;
  if (near.isOnFace) {
    contact.brickA = sphere_;
    contact.brickB = brick_;
    // The sphere's point that faces the brick, in world axes, since it does not rotate.
    contact.pointA = radius_ * (brick.rotation * -near.away);
    contact.pointB = near.point;
    contact.normal = near.away;
  } else {
    contact.brickA = brick_;
    contact.brickB = sphere_;
    contact.pointA = near.point;
    contact.normal = brick.rotation * -near.away;
    contact.pointB = radius_ * contact.normal;
  }
  return contact;
}

double SpherePair::appendViolated(const Pose& start, const Pose& end, const Vector3& centre,
                                  long step, std::vector<brick::Contact>& contacts) {
  const double deep = overlap(end, centre);
  if (deep <= tolerance_) return 0;
  if (givenStep_ != step) given_.clear();
  givenStep_ = step;
  // The first contact is of the nearest feature at the start. If the overlap remains with it, the
  // nearest feature at the end is another one.
  for (const Pose* pose : {&start, &end}) {
    const brick::Contact contact = contactAt(*pose, centre);
    if (std::find(given_.begin(), given_.end(), contact) != given_.end()) continue;
    given_.push_back(contact);
    contacts.push_back(contact);
    break;
  }
  return deep;
}

}  // namespace kirireel::contacts
