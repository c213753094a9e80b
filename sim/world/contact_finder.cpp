// Contacts of all bricks in three stages.
//
// 1. The broad phase (near_pairs.h) lists pairs of convex pieces whose boxes meet. Concave bricks
//    have several pieces; those of one brick never meet each other.
// 2. Each listed pair that may touch is looked at as a `BrickPair`, or as a `SpherePair` where one
//    of the two is a sphere. These remember, from step to step, what keeps the two apart.
// 3. Bricks on the ground: a brick whose lowest vertex is below the ground gets a contact at each
//    of its vertices, of which the solver holds those that push.
//
// Bodies are numbered: first the bricks, then the parts of obstacles, so that a body is an obstacle
// where its number is not below movingCount(). Pairs are visited in the order of their numbers, so
// that contacts have the same order on every machine.
//
// Bricks that share a corner are looked at without that corner (pivotZone of an edge, see
// shared_corners.h): bricks joined on one face would else be stopped by the least fold, as the
// edges at their joint already touch.
#include "sim/world/contact_finder.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>

#include <fmt/format.h>

#include "sim/base/error.h"
#include "sim/base/interruption.h"
#include "sim/brick/shared_corners.h"
#include "sim/world/brick_pair.h"
#include "sim/world/near_pairs.h"
#include "sim/world/sphere_pair.h"

namespace kirireel {
namespace {

using Key = std::uint64_t;

Key pairKey(int pieceA, int pieceB) {
  return static_cast<Key>(pieceA) << 32 | static_cast<Key>(pieceB);
}

std::pair<int, int> piecesOf(Key key) {
  return {static_cast<int>(key >> 32), static_cast<int>(key & 0xffffffffU)};
}

std::vector<Brick> shapesOf(const std::vector<BrickPiece>& pieces) {
  std::vector<Brick> shapes;
  shapes.reserve(pieces.size());
  for (const BrickPiece& piece : pieces) shapes.push_back(piece.shape);
  return shapes;
}

}  // namespace

struct ContactFinder::Internals {
  Internals(const std::vector<Brick>& all, const std::vector<ObstaclePart>& obstacles)
      : bricks(all),
        parts(obstacles),
        pieces(convexPieces(bricks)),
        shapes(shapesOf(pieces)),
        near(shapes) {
    firstPiece.resize(bricks.size());
    // Backwards, so that the first piece of each brick is what stays.
    for (std::size_t k = pieces.size(); k-- > 0;) {
      firstPiece[pieces[k].brick] = static_cast<int>(k);
    }
  }

  int movingCount() const { return static_cast<int>(bricks.size() - parts.size()); }
  /// The obstacle's part that a body is; null for a brick.
  const ObstaclePart* partOf(int body) const {
    return body < movingCount() ? nullptr : &parts[body - movingCount()];
  }
  /// Of two pieces, the smaller number first.
  BrickPair& pairOf(int a, int b);
  SpherePair& sphereOf(int piece, int sphere);
  Poses posesOfPieces(const Poses& poses) const;
  bool mayTouch(int a, int b) const;
  void updatePairs(const Poses& from, const Poses& to);
  void listNearPairs();
  void transfer(StateTape& tape);
  double appendGround(int brick, const Pose& end, std::vector<Contact>& contacts);
  double frictionWith(int a, int b) const;
  void requireFree(int brick, int body, double overlap) const;

  std::vector<Brick> bricks;  // then the bodies of obstacles
  std::vector<ObstaclePart> parts;
  std::vector<BrickPiece> pieces;  // of all bricks and bodies; those of one never meet each other
  std::vector<Brick> shapes;       // of the pieces
  std::vector<int> firstPiece;     // of each brick
  std::map<std::pair<int, int>, SharedCorners> joined;
  Environment environment;
  bool planar = false;
  double tolerance = 0;
  long step = 0;
  double examined = 0;  // pairs so far
  Poses start;
  NearPairs near;
  std::unordered_map<Key, BrickPair> pairs;  // of pieces that ever were near
  std::vector<BrickPair*> nearPairs;         // that are near now, in order of bricks
  std::unordered_map<Key, SpherePair> spheres;
  std::vector<SpherePair*> nearSpheres;
  std::vector<BrickPair*> overlapping;  // that overlapped where the run began
  std::vector<long> groundGiven;        // the step in which each brick's ground contacts were given
};

BrickPair& ContactFinder::Internals::pairOf(int a, int b) {
  const Key key = pairKey(a, b);
  // Pairs are kept for the rest of the run, since what they remember is worth more than their
  // memory.
  const auto known = pairs.find(key);
  if (known != pairs.end()) return known->second;
  const BrickPiece& pieceA = pieces[a];
  const BrickPiece& pieceB = pieces[b];
  const auto add = [&](const Brick& shapeA, const Brick& shapeB) -> BrickPair& {
    BrickPair::Side sideA{pieceA.brick, pieceA.part, makeOutline(shapeA, planar)};
    BrickPair::Side sideB{pieceB.brick, pieceB.part, makeOutline(shapeB, planar)};
    return pairs.try_emplace(key, std::move(sideA), std::move(sideB), tolerance).first->second;
  };
  const auto corners = joined.find({pieceA.brick, pieceB.brick});
  if (corners == joined.end() || environment.pivotZone == 0) return add(shapes[a], shapes[b]);
  const double length =
      cutLength(bricks[pieceA.brick], bricks[pieceB.brick], environment.pivotZone);
  return add(withoutCorners(pieceA, corners->second.ofA, length),
             withoutCorners(pieceB, corners->second.ofB, length));
}

// The pair of a piece of a brick and the piece that stands for a sphere, made where it is new.
SpherePair& ContactFinder::Internals::sphereOf(int piece, int sphere) {
  const int body = pieces[sphere].brick;
  return spheres
      .try_emplace(pairKey(piece, sphere), pieces[piece].brick, body, shapes[piece],
                   *partOf(body)->radius, tolerance)
      .first->second;
}

// Pieces move with their bricks.
Poses ContactFinder::Internals::posesOfPieces(const Poses& poses) const {
  Poses placed;
  placed.reserve(pieces.size());
  for (const BrickPiece& piece : pieces) placed.push_back(poses[piece.brick]);
  return placed;
}

/// Two bodies, the smaller number first.
bool ContactFinder::Internals::mayTouch(int a, int b) const {
  if (a == b) return false;
  // b has the larger number, so that an obstacle among the two is b. Obstacles do not meet each
  // other.
  if (partOf(b)) return !partOf(a);
  return environment.contacts == ContactFilter::All ||
         (environment.contacts == ContactFilter::Unjoined && !joined.contains({a, b}));
}

// Takes notice of a move; the list of near pairs changes seldom.
void ContactFinder::Internals::updatePairs(const Poses& from, const Poses& to) {
  if (environment.contacts == ContactFilter::None && parts.empty()) return;
  const bool areBricks = pieces.size() == bricks.size();
  const bool isNew =
      areBricks ? near.update(from, to) : near.update(posesOfPieces(from), posesOfPieces(to));
  if (isNew) listNearPairs();
}

void ContactFinder::Internals::listNearPairs() {
  nearPairs.clear();
  nearSpheres.clear();
  for (const auto& [a, b] : near.pairs()) {
    checkInterruption();
    if (!mayTouch(pieces[a].brick, pieces[b].brick)) continue;
    const ObstaclePart* part = partOf(pieces[b].brick);
    if (part && part->radius) {
      nearSpheres.push_back(&sphereOf(a, b));
    } else {
      nearPairs.push_back(&pairOf(a, b));
    }
  }
}

void ContactFinder::Internals::transfer(StateTape& tape) {
  std::vector<std::pair<int, int>> known;
  for (const auto& [key, pair] : pairs) known.push_back(piecesOf(key));
  tape.transfer(near, known);
  // Playing back, pairOf() makes the pair anew, and the tape fills in what it remembered.
  for (const auto& [a, b] : known) pairOf(a, b).transfer(tape);
  if (tape.isPlaying()) listNearPairs();
}

// Coulomb's coefficient of a pair: an obstacle's own, else that between bricks.
double ContactFinder::Internals::frictionWith(int a, int b) const {
  const ObstaclePart* part = partOf(std::max(a, b));
  return part ? part->friction : environment.brickFriction;
}

// A brick in an obstacle could not be got out without a jump.
void ContactFinder::Internals::requireFree(int brick, int body, double overlap) const {
  const ObstaclePart* part = partOf(body);
  if (!part || overlap <= tolerance) return;
  throw InputError(fmt::format(
      "error: tile {} reaches {:.3g} m into obstacle {} at the start; move the obstacle away",
      brick, overlap, part->obstacle));
}

double ContactFinder::Internals::appendGround(int brick, const Pose& end,
                                              std::vector<Contact>& contacts) {
  const double height = environment.ground->height;
  // Heights in brick axes: one product for each vertex.
  const Vector3 up = end.rotation.conjugate() * Vector3::UnitZ();
  // The lowest vertex alone decides whether the brick is in the ground.
  double lowest = std::numeric_limits<double>::infinity();
  for (const std::vector<Vector3>* points : {&bricks[brick].bottom, &bricks[brick].top}) {
    for (const Vector3& point : *points) lowest = std::min(lowest, point.dot(up));
  }
  lowest += end.position.z();
  if (lowest >= height - tolerance) return 0;
  if (groundGiven[brick] == step) return height - lowest;
  groundGiven[brick] = step;
  for (const std::vector<Vector3>* points : {&bricks[brick].bottom, &bricks[brick].top}) {
    for (const Vector3& point : *points) {
      contacts.push_back({brick, kFixed, point, Vector3(0, 0, height), Vector3::UnitZ()});
      contacts.back().friction = environment.ground->friction;
    }
  }
  return height - lowest;
}

ContactFinder::ContactFinder(const std::vector<Brick>& bricks, const Poses& start,
                             std::span<const Pivot> pivots, const Environment& environment,
                             bool planar, double tolerance,
                             const std::vector<ObstaclePart>& obstacles)
    : internals_(std::make_unique<Internals>(bricks, obstacles)) {
  Internals& in = *internals_;
  in.groundGiven.assign(bricks.size(), -1);
  in.joined = sharedCorners(pivots);
  in.environment = environment;
  in.planar = planar;
  in.tolerance = tolerance;
  in.updatePairs(start, start);
  for (BrickPair* pair : in.nearPairs) {
    // Flush bricks of rounded models overlap a little where the run begins. They may keep that, but
    // an obstacle may not be entered at all.
    pair->keepOverlap(seenFrom(start[pair->a()], start[pair->b()]));
    in.requireFree(pair->a(), pair->b(), pair->slack());
    if (pair->slack() > 0) in.overlapping.push_back(pair);
  }
  for (const SpherePair* pair : in.nearSpheres) {
    const Vector3& centre = start[pair->sphere()].position;
    in.requireFree(pair->brick(), pair->sphere(), pair->overlap(start[pair->brick()], centre));
  }
}

ContactFinder::~ContactFinder() = default;

void ContactFinder::transfer(StateTape& tape) {
  internals_->transfer(tape);
}

void ContactFinder::startStep(const Poses& start) {
  Internals& in = *internals_;
  in.start = start;
  ++in.step;
  for (BrickPair* pair : in.overlapping) {
    pair->shrinkOverlap(seenFrom(start[pair->a()], start[pair->b()]));
  }
}

// Pairs of bricks, then spheres, then the ground.
double ContactFinder::appendViolated(const Poses& end, std::vector<Contact>& contacts) {
  Internals& in = *internals_;
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
  }
  // A planar sheet on the ground never leaves it.
  if (in.environment.ground && !in.planar) {
    for (int i = 0; i < in.movingCount(); ++i) {
      overlap = std::max(overlap, in.appendGround(i, end[i], contacts));
    }
  }
  return overlap;
}

double ContactFinder::pairsExamined() const {
  return internals_->examined;
}

bool ContactFinder::isCurrent(const Contact& contact) const {
  // The ground's contacts hold while they push.
  if (contact.brickB == kFixed) return true;
  const Internals& in = *internals_;
  const auto [a, b] = std::minmax(contact.brickA, contact.brickB);
  const ObstaclePart* part = in.partOf(b);
  // The nearest points of a sphere's contact turn with the brick, so that they are found anew in
  // each step.
  if (part && part->radius) return false;
  const auto [pieceA, pieceB] = std::minmax({in.firstPiece[contact.brickA] + contact.partA,
                                             in.firstPiece[contact.brickB] + contact.partB});
  // Its pair has been near, or there would be no such contact.
  return in.pairs.at(pairKey(pieceA, pieceB))
      .isCurrent(contact, seenFrom(in.start[a], in.start[b]));
}

}  // namespace kirireel
