#include "sim/world/contact_finder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include "sim/world/separation.h"

namespace kirireel {
namespace {

static_assert(sizeof(btScalar) == sizeof(double), "link Bullet's float64 libraries");

// Overlaps left by a failed step are taken back bit by bit, and may meanwhile grow by this part of
// the tolerance.
constexpr double kWorsening = 0.1;
// Two planes whose normals agree to this cosine count as the same.
constexpr double kSameDirection = 0.999;

// How often the plane that keeps a pair apart may change within a step, and how finely the moment
// of a change is sought.
constexpr int kPlaneChanges = 4;
constexpr int kBisections = 20;
// Below this angle the motion of a pair counts as straight, radians.
constexpr double kNoTurn = 1e-9;

using Key = std::uint64_t;

Key pairKey(int brickA, int brickB) {
  return static_cast<Key>(brickA) << 32 | static_cast<Key>(brickB);
}

btVector3 toBullet(const Vector3& v) {
  return {v.x(), v.y(), v.z()};
}

/// The pose of a brick in the axes of another.
Pose seenFrom(const Pose& seer, const Pose& seen) {
  const Quaternion back = seer.rotation.conjugate();
  return {back * (seen.position - seer.position), back * seen.rotation};
}

/// A turn about an axis and an advance along it: bricks that share a pivot move against each other
/// so, and the pivot stays where it is on the way.
struct Screw {
  Vector3 turn = Vector3::Zero();  // rotation vector
  Vector3 centre = Vector3::Zero();
  Vector3 advance = Vector3::Zero();
};

/// The screw that takes one pose to another.
Screw screwBetween(const Pose& from, const Pose& to) {
  const Eigen::AngleAxisd turned(to.rotation * from.rotation.conjugate());
  Screw screw{Vector3::Zero(), from.position, to.position - from.position};
  if (turned.angle() < kNoTurn) return screw;
  const Vector3& axis = turned.axis();
  const Vector3 across = screw.advance - axis.dot(screw.advance) * axis;
  screw.turn = turned.angle() * axis;
  screw.centre += 0.5 * (across + axis.cross(across) / std::tan(0.5 * turned.angle()));
  screw.advance -= across;
  return screw;
}

/// The pose a part of the way along a screw.
Pose onTheWay(const Screw& screw, const Pose& from, double part) {
  const Quaternion turn = rotationFromVector(part * screw.turn);
  return {screw.centre + part * screw.advance + turn * (from.position - screw.centre),
          turn * from.rotation};
}

/// Bullet's dynamic box tree over the space that each brick sweeps in a step.
class SweptBoxes {
 public:
  SweptBoxes() : broadphase_(&pairs_) {}
  ~SweptBoxes() {
    for (btBroadphaseProxy* proxy : proxies_) broadphase_.destroyProxy(proxy, nullptr);
  }
  SweptBoxes(const SweptBoxes&) = delete;
  SweptBoxes& operator=(const SweptBoxes&) = delete;

  /// Makes proxies on the first call, moves them afterwards.
  void set(int brick, const Eigen::AlignedBox3d& box) {
    const btVector3 low = toBullet(box.min());
    const btVector3 high = toBullet(box.max());
    if (brick < static_cast<int>(proxies_.size())) {
      broadphase_.setAabb(proxies_[brick], low, high, nullptr);
      return;
    }
    // The user pointer only has to carry the brick's number.
    void* number = reinterpret_cast<void*>(static_cast<std::intptr_t>(brick));
    proxies_.push_back(
        broadphase_.createProxy(low, high, BOX_SHAPE_PROXYTYPE, number, 1, 1, nullptr));
  }

  /// The pairs whose boxes overlap, smaller number first, sorted.
  const std::vector<std::pair<int, int>>& overlapping() {
    broadphase_.calculateOverlappingPairs(nullptr);
    found_.clear();
    const btBroadphasePairArray& pairs = pairs_.getOverlappingPairArray();
    for (int i = 0; i < pairs.size(); ++i) {
      const auto [a, b] = std::minmax({number(pairs[i].m_pProxy0), number(pairs[i].m_pProxy1)});
      found_.emplace_back(a, b);
    }
    std::sort(found_.begin(), found_.end());
    return found_;
  }

 private:
  static int number(const btBroadphaseProxy* proxy) {
    return static_cast<int>(reinterpret_cast<std::intptr_t>(proxy->m_clientObject));
  }

  btHashedOverlappingPairCache pairs_;
  btDbvtBroadphase broadphase_;
  std::vector<btBroadphaseProxy*> proxies_;
  std::vector<std::pair<int, int>> found_;
};

}  // namespace

struct ContactFinder::Internals {
  struct PairState {
    std::vector<SeparatingPlane> planes;
    SeparatingPlane last;                // that kept the pair apart when last looked at
    std::vector<SeparatingPlane> given;  // whose contacts were given in this step
    long givenStep = -1;
    double slack = 0;  // overlap kept from the start of the run
  };

  double appendPair(int a, int b, std::vector<Contact>& contacts);
  bool canGive(PairState& state, const SeparatingPlane& plane) const;
  bool keptApartInTurn(PairState& state, double held, double wanted, int a, int b) const;
  const SeparatingPlane* planeToGive(PairState& state, const std::vector<double>& before, int a,
                                     int b) const;
  void givePlane(PairState& state, const SeparatingPlane& plane, int a, int b,
                 std::vector<Contact>& contacts);
  double appendGround(int brick, std::vector<Contact>& contacts);
  PairState& stateOf(int a, int b);
  double bestSeparation(const PairState& state, const PlacedOutline& a,
                        const PlacedOutline& b) const;
  bool holds(const SeparatingPlane& plane, double limit, int a, int b) const;
  void keepOverlaps(const Poses& start);
  void shrinkOverlaps();
  void place(const Poses& poses, std::vector<PlacedOutline>& placed);
  void sweep();

  std::vector<Outline> outlines;
  std::unordered_set<Key> joined;
  Environment environment;
  bool planar = false;
  double tolerance = 0;
  long step = 0;
  SweptBoxes boxes;
  std::unordered_map<Key, PairState> pairs;
  std::vector<std::pair<int, int>> overlapping;  // pairs that overlapped where the run began
  std::vector<PlacedOutline> start, end;
  std::vector<long> groundGiven;  // the step in which each brick's ground contacts were given
};

void ContactFinder::Internals::place(const Poses& poses, std::vector<PlacedOutline>& placed) {
  placed.resize(outlines.size());
  for (std::size_t i = 0; i < outlines.size(); ++i) placeOutline(outlines[i], poses[i], placed[i]);
}

void ContactFinder::Internals::sweep() {
  for (std::size_t i = 0; i < outlines.size(); ++i) {
    Eigen::AlignedBox3d box;
    for (const Vector3& point : start[i].points) box.extend(point);
    for (const Vector3& point : end[i].points) box.extend(point);
    boxes.set(static_cast<int>(i), box);
  }
}

ContactFinder::Internals::PairState& ContactFinder::Internals::stateOf(int a, int b) {
  const auto [found, isNew] = pairs.try_emplace(pairKey(a, b));
  PairState& state = found->second;
  if (isNew) {
    state.planes = separatingPlanes(outlines[a], outlines[b]);
    state.last = state.planes.front();
  }
  return state;
}

double ContactFinder::Internals::bestSeparation(const PairState& state, const PlacedOutline& a,
                                                const PlacedOutline& b) const {
  double best = -std::numeric_limits<double>::infinity();
  for (const SeparatingPlane& plane : state.planes) best = std::max(best, separation(plane, a, b));
  return best;
}

bool ContactFinder::Internals::holds(const SeparatingPlane& plane, double limit, int a,
                                     int b) const {
  return separation(plane, end[a], end[b]) >= limit &&
         separation(plane, start[a], start[b]) >= limit;
}

/// Notes how far pairs overlap where the run begins.
void ContactFinder::Internals::keepOverlaps(const Poses& poses) {
  place(poses, start);
  end = start;
  sweep();
  for (const auto& [a, b] : boxes.overlapping()) {
    PairState& state = stateOf(a, b);
    state.slack = std::max(0.0, -bestSeparation(state, start[a], start[b]));
    if (state.slack > 0) overlapping.emplace_back(a, b);
  }
}

double ContactFinder::Internals::appendPair(int a, int b, std::vector<Contact>& contacts) {
  PairState& state = stateOf(a, b);
  const double limit = -tolerance - state.slack;
  if (holds(state.last, limit, a, b)) return 0;
  std::vector<double> before;
  for (const SeparatingPlane& plane : state.planes) {
    before.push_back(separation(plane, start[a], start[b]));
  }
  const double bestBefore = *std::max_element(before.begin(), before.end());
  const double held = std::min(limit, bestBefore);
  const double wanted = std::min(limit, bestBefore - kWorsening * tolerance);
  double bestAfter = -std::numeric_limits<double>::infinity();  // of the planes that held before
  bool apartAfter = false;
  for (std::size_t p = 0; p < state.planes.size(); ++p) {
    const double after = separation(state.planes[p], end[a], end[b]);
    apartAfter = apartAfter || after >= wanted;
    if (before[p] < held) continue;
    bestAfter = std::max(bestAfter, after);
    if (after < wanted) continue;
    state.last = state.planes[p];
    return 0;
  }
  if (apartAfter && keptApartInTurn(state, held, wanted, a, b)) return 0;
  // No plane kept the pair apart.
  if (const SeparatingPlane* plane = planeToGive(state, before, a, b)) {
    givePlane(state, *plane, a, b, contacts);
  }
  return std::max(0.0, -bestAfter - state.slack);
}

/// Lets pairs keep no more of the overlap that they began with than they still have.
void ContactFinder::Internals::shrinkOverlaps() {
  for (const auto& [a, b] : overlapping) {
    PairState& state = stateOf(a, b);
    const double overlap = std::max(0.0, -bestSeparation(state, start[a], start[b]));
    state.slack = std::min(state.slack, overlap);
  }
}

/// Whether the pair is kept apart by one plane after the other, as bricks that turn past a corner
/// are: each plane must hold until the next one does.
bool ContactFinder::Internals::keptApartInTurn(PairState& state, double held, double wanted, int a,
                                               int b) const {
  const PlacedOutline& placedA = start[a];
  PlacedOutline placedB = start[b];
  const Pose fromA = seenFrom(start[a].pose, start[b].pose);
  const Screw screw = screwBetween(fromA, seenFrom(end[a].pose, end[b].pose));
  const auto place = [&](double part) {
    const Pose way = onTheWay(screw, fromA, part);
    const Pose& seer = start[a].pose;
    placeOutline(outlines[b], {seer.apply(way.position), seer.rotation * way.rotation}, placedB);
  };
  double limit = held;
  double reached = 0;
  for (int change = 0; change < kPlaneChanges; ++change) {
    std::vector<SeparatingPlane> holding;
    for (const SeparatingPlane& plane : state.planes) {
      if (separation(plane, placedA, placedB) < limit) continue;
      holding.push_back(plane);
      if (separation(plane, end[a], end[b]) < wanted) continue;
      state.last = plane;
      return true;
    }
    // Bisect for the last moment to which one of them holds.
    limit = wanted;
    double lost = 1;
    const double from = reached;
    for (int round = 0; round < kBisections; ++round) {
      const double part = 0.5 * (reached + lost);
      place(part);
      const bool holds =
          std::any_of(holding.begin(), holding.end(), [&](const SeparatingPlane& plane) {
            return separation(plane, placedA, placedB) >= limit;
          });
      (holds ? reached : lost) = part;
    }
    if (reached == from) return false;
    place(reached);
  }
  return false;
}

/// Of the steady planes that held best at the start and were not given yet, the one that is
/// violated least at the end; null when there is none.
const SeparatingPlane* ContactFinder::Internals::planeToGive(PairState& state,
                                                             const std::vector<double>& before,
                                                             int a, int b) const {
  std::vector<std::size_t> candidates;
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < state.planes.size(); ++p) {
    if (!isSteady(state.planes[p], start[a], start[b])) continue;
    best = std::max(best, before[p]);
    if (canGive(state, state.planes[p])) candidates.push_back(p);
  }
  const double held = std::min(-tolerance - state.slack, best);
  const SeparatingPlane* chosen = nullptr;
  double leastViolated = -std::numeric_limits<double>::infinity();
  for (std::size_t p : candidates) {
    if (before[p] < held) continue;
    const double after = separation(state.planes[p], end[a], end[b]);
    if (after <= leastViolated) continue;
    leastViolated = after;
    chosen = &state.planes[p];
  }
  return chosen;
}

/// Whether contacts on this plane would be new in this step.
bool ContactFinder::Internals::canGive(PairState& state, const SeparatingPlane& plane) const {
  if (state.givenStep != step) state.given.clear();
  state.givenStep = step;
  return std::find(state.given.begin(), state.given.end(), plane) == state.given.end();
}

void ContactFinder::Internals::givePlane(PairState& state, const SeparatingPlane& plane, int a,
                                         int b, std::vector<Contact>& contacts) {
  state.last = plane;
  state.given.push_back(plane);
  const std::size_t first = contacts.size();
  appendPlaneContacts(plane, a, b, start[a], start[b], contacts);
  for (std::size_t c = first; c < contacts.size(); ++c) {
    contacts[c].friction = environment.brickFriction;
    contacts[c].slack = state.slack;
  }
}

double ContactFinder::Internals::appendGround(int brick, std::vector<Contact>& contacts) {
  const double height = environment.ground->height;
  const PlacedOutline& placed = end[brick];
  const auto below = [](const Vector3& x, const Vector3& y) { return x.z() < y.z(); };
  const double lowest = std::min_element(placed.points.begin(), placed.points.end(), below)->z();
  if (lowest >= height - tolerance) return 0;
  if (groundGiven[brick] == step) return height - lowest;
  groundGiven[brick] = step;
  for (const Vector3& point : placed.outline->points) {
    contacts.push_back({brick, kFixed, point, Vector3(0, 0, height), Vector3::UnitZ()});
    contacts.back().friction = environment.ground->friction;
  }
  return height - lowest;
}

ContactFinder::ContactFinder(const std::vector<Brick>& bricks, const Poses& start,
                             std::span<const Pivot> pivots, const Environment& environment,
                             bool planar, double tolerance)
    : internals_(std::make_unique<Internals>()) {
  for (const Brick& brick : bricks) internals_->outlines.push_back(makeOutline(brick, planar));
  internals_->groundGiven.assign(bricks.size(), -1);
  for (const Pivot& pivot : pivots) {
    const auto [a, b] = std::minmax(pivot.brickA, pivot.brickB);
    internals_->joined.insert(pairKey(a, b));
  }
  internals_->environment = environment;
  internals_->planar = planar;
  internals_->tolerance = tolerance;
  internals_->keepOverlaps(start);
}

ContactFinder::~ContactFinder() = default;

void ContactFinder::startStep(const Poses& start) {
  internals_->place(start, internals_->start);
  internals_->shrinkOverlaps();
  ++internals_->step;
}

double ContactFinder::appendViolated(const Poses& end, std::vector<Contact>& contacts) {
  Internals& in = *internals_;
  in.place(end, in.end);
  double overlap = 0;
  if (in.environment.contacts != ContactFilter::None) {
    in.sweep();
    for (const auto& [a, b] : in.boxes.overlapping()) {
      const bool passed =
          in.environment.contacts == ContactFilter::Unjoined && in.joined.contains(pairKey(a, b));
      if (!passed) overlap = std::max(overlap, in.appendPair(a, b, contacts));
    }
  }
  if (in.environment.ground && !in.planar) {
    for (int i = 0; i < static_cast<int>(in.outlines.size()); ++i) {
      overlap = std::max(overlap, in.appendGround(i, contacts));
    }
  }
  return overlap;
}

bool ContactFinder::isCurrent(const Contact& contact) const {
  if (contact.brickB == kFixed) return true;
  Internals& in = *internals_;
  const auto [a, b] = std::minmax(contact.brickA, contact.brickB);
  const Internals::PairState& state = in.stateOf(a, b);
  const PlacedOutline& placedA = in.start[a];
  const PlacedOutline& placedB = in.start[b];
  const Poses poses = {in.start[contact.brickA].pose, in.start[contact.brickB].pose};
  Contact pair = contact;
  pair.brickA = 0;
  pair.brickB = 1;
  const double turn = contact.brickA == a ? 1 : -1;
  const Vector3 normal = turn * contactNormal(pair, poses);
  return std::none_of(state.planes.begin(), state.planes.end(), [&](const SeparatingPlane& plane) {
    return plane.kind != SeparatingPlane::Kind::Edges &&
           planeNormal(plane, placedA, placedB).dot(normal) < kSameDirection &&
           separation(plane, placedA, placedB) >= -in.tolerance - state.slack;
  });
}

}  // namespace kirireel
