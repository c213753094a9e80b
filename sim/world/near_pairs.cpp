// The broad phase: which pairs of convex bodies may meet in a step.
//
// Each body has a box round its places at the start and at the end of a move, widened by a margin,
// the same for all. While no body has moved by more than the margin from the place that its box was
// made for, the list of pairs stays valid, and nothing is computed but a bound on each body's
// motion:
//   |p' - p| + 2 |q' - q| r
// p and q position and unit quaternion, r the distance of the farthest point. Otherwise all boxes
// are set anew, and Bullet's dynamic bounding volume tree lists which of them meet (O(n log n) for
// n bodies that are spread out).
#include "sim/world/near_pairs.h"

#include <algorithm>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include "sim/base/interruption.h"
#include "sim/world/bullet_values.h"

namespace kirireel {
namespace {

// Wider boxes give more pairs, narrower ones must be set more often.
constexpr double kMarginOfRadius = 0.05;

int number(const btBroadphaseProxy* proxy) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(proxy->m_clientObject));
}

// By all corners of a brick at a pose.
void extend(Eigen::AlignedBox3d& box, const Brick& brick, const Pose& pose) {
  for (const std::vector<Vector3>* points : {&brick.bottom, &brick.top}) {
    for (const Vector3& point : *points) box.extend(pose.apply(point));
  }
}

}  // namespace

double motionBound(const Pose& from, const Pose& to, double radius) {
  // A turn by an angle moves points by at most 2 sin(angle / 2) radii, and the quaternions by
  // 2 sin(angle / 4).
  const double turned = (to.rotation.coeffs() - from.rotation.coeffs()).norm();
  return (to.position - from.position).norm() + 2 * turned * radius;
}

double outerRadius(const Brick& brick) {
  double squared = 0;
  for (const Vector3& point : brick.bottom) squared = std::max(squared, point.squaredNorm());
  for (const Vector3& point : brick.top) squared = std::max(squared, point.squaredNorm());
  return std::sqrt(squared);
}

struct NearPairs::Internals {
  explicit Internals(const std::vector<Brick>& all) : bricks(all), broadphase(&cache) {}
  ~Internals() {
    // With each proxy Bullet looks through all pairs for its own.
    cache.getOverlappingPairArray().clear();
    for (btBroadphaseProxy* proxy : proxies) broadphase.destroyProxy(proxy, nullptr);
  }

  bool anyLeft(const Poses& poses) const;
  void setBoxes();
  void setBox(int brick, const Eigen::AlignedBox3d& box);
  void listPairs();

  const std::vector<Brick>& bricks;
  std::vector<double> radii;
  double margin = 0;
  Poses boxedFrom;  // the move that boxes were made for; empty before the first call
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

// From the two states of `boxedFrom` and `boxedTo`.
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
  // The user pointer only has to carry the brick's number.
  void* carried = reinterpret_cast<void*>(static_cast<std::intptr_t>(brick));
  proxies.push_back(broadphase.createProxy(low, high, BOX_SHAPE_PROXYTYPE, carried, 1, 1, nullptr));
}

/// Bullet's tree widens boxes that move, and forgets pairs late: which of those it has depends on
/// all moves before. Ours depend on the boxes alone.
void NearPairs::Internals::listPairs() {
  broadphase.calculateOverlappingPairs(nullptr);
  pairs.clear();
  const btBroadphasePairArray& found = cache.getOverlappingPairArray();
  for (int i = 0; i < found.size(); ++i) {
    const auto [a, b] = std::minmax({number(found[i].m_pProxy0), number(found[i].m_pProxy1)});
    if (boxes[a].intersects(boxes[b])) pairs.emplace_back(a, b);
  }
  // Bullet's order depends on the history of its tree, and the order of contacts on this one.
  std::sort(pairs.begin(), pairs.end());
}

NearPairs::NearPairs(const std::vector<Brick>& bricks)
    : internals_(std::make_unique<Internals>(bricks)) {
  double sum = 0;
  for (const Brick& brick : bricks) {
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
  tape.transfer(internals_->boxedFrom, internals_->boxedTo);
  if (tape.isPlaying()) internals_->setBoxes();
}

const std::vector<std::pair<int, int>>& NearPairs::pairs() const {
  return internals_->pairs;
}

}  // namespace kirireel
