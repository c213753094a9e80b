#include "sim/world/contact_finder.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <unordered_map>

#include "sim/brick/shared_corners.h"
#include "sim/world/brick_pair.h"
#include "sim/world/near_pairs.h"

namespace kirireel {
namespace {

using Key = std::uint64_t;

Key pairKey(int brickA, int brickB) {
  return static_cast<Key>(brickA) << 32 | static_cast<Key>(brickB);
}

}  // namespace

struct ContactFinder::Internals {
  explicit Internals(const std::vector<Brick>& all) : bricks(all), near(bricks) {}

  BrickPair& pairOf(int a, int b);
  void updatePairs(const Poses& from, const Poses& to);
  double appendGround(int brick, const Pose& end, std::vector<Contact>& contacts);

  std::vector<Brick> bricks;
  std::map<std::pair<int, int>, SharedCorners> joined;
  Environment environment;
  bool planar = false;
  double tolerance = 0;
  long step = 0;
  Poses start;
  NearPairs near;
  std::unordered_map<Key, BrickPair> pairs;  // that ever were near
  std::vector<BrickPair*> nearPairs;         // that are near now, in order of bricks
  std::vector<BrickPair*> overlapping;       // that overlapped where the run began
  std::vector<long> groundGiven;  // the step in which each brick's ground contacts were given
};

BrickPair& ContactFinder::Internals::pairOf(int a, int b) {
  const Key key = pairKey(a, b);
  const auto known = pairs.find(key);
  if (known != pairs.end()) return known->second;
  const auto corners = joined.find({a, b});
  const auto add = [&](const Brick& brickA, const Brick& brickB) -> BrickPair& {
    return pairs
        .try_emplace(key, a, b, makeOutline(brickA, planar), makeOutline(brickB, planar), tolerance)
        .first->second;
  };
  if (corners == joined.end() || environment.pivotZone == 0) return add(bricks[a], bricks[b]);
  const auto [cutA, cutB] =
      withoutSharedCorners(bricks[a], bricks[b], corners->second, environment.pivotZone);
  return add(cutA, cutB);
}

void ContactFinder::Internals::updatePairs(const Poses& from, const Poses& to) {
  if (environment.contacts == ContactFilter::None || !near.update(from, to)) return;
  nearPairs.clear();
  for (const auto& [a, b] : near.pairs()) {
    const bool passes = environment.contacts == ContactFilter::Unjoined && joined.contains({a, b});
    if (!passes) nearPairs.push_back(&pairOf(a, b));
  }
}

double ContactFinder::Internals::appendGround(int brick, const Pose& end,
                                              std::vector<Contact>& contacts) {
  const double height = environment.ground->height;
  const Vector3 up = end.rotation.conjugate() * Vector3::UnitZ();
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
                             bool planar, double tolerance)
    : internals_(std::make_unique<Internals>(bricks)) {
  Internals& in = *internals_;
  in.groundGiven.assign(bricks.size(), -1);
  in.joined = sharedCorners(pivots);
  in.environment = environment;
  in.planar = planar;
  in.tolerance = tolerance;
  in.updatePairs(start, start);
  for (BrickPair* pair : in.nearPairs) {
    pair->keepOverlap(seenFrom(start[pair->a()], start[pair->b()]));
    if (pair->slack() > 0) in.overlapping.push_back(pair);
  }
}

ContactFinder::~ContactFinder() = default;

void ContactFinder::startStep(const Poses& start) {
  Internals& in = *internals_;
  in.start = start;
  ++in.step;
  for (BrickPair* pair : in.overlapping) {
    pair->shrinkOverlap(seenFrom(start[pair->a()], start[pair->b()]));
  }
}

double ContactFinder::appendViolated(const Poses& end, std::vector<Contact>& contacts) {
  Internals& in = *internals_;
  in.updatePairs(in.start, end);
  double overlap = 0;
  const std::size_t first = contacts.size();
  for (BrickPair* pair : in.nearPairs) {
    const PairMove move{seenFrom(in.start[pair->a()], in.start[pair->b()]),
                        seenFrom(end[pair->a()], end[pair->b()])};
    overlap = std::max(overlap, pair->appendViolated(move, in.step, contacts));
  }
  for (std::size_t c = first; c < contacts.size(); ++c) {
    contacts[c].friction = in.environment.brickFriction;
  }
  if (in.environment.ground && !in.planar) {
    for (int i = 0; i < static_cast<int>(in.bricks.size()); ++i) {
      overlap = std::max(overlap, in.appendGround(i, end[i], contacts));
    }
  }
  return overlap;
}

bool ContactFinder::isCurrent(const Contact& contact) const {
  if (contact.brickB == kFixed) return true;
  Internals& in = *internals_;
  const auto [a, b] = std::minmax(contact.brickA, contact.brickB);
  return in.pairOf(a, b).isCurrent(contact, seenFrom(in.start[a], in.start[b]));
}

}  // namespace kirireel
