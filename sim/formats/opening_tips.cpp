// Finds necks between openings that are wider than slots, as in sheets that are drawn partly open.
//
// 1. *Tips*: between two sides of a ring is a chain of vertices that turns around the opening. Its
//    edges are shorter than half of both sides. Of all chains those between the longest sides are
//    tips.
//    A smooth opening has tips where it is farthest from its middle.
// 2. *Rays* follow the bisector of the sides. They stop at the next line, or at a corner if they
//    aim at it. The designer's mechanism closes there.
#include "sim/formats/opening_tips.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "sim/formats/geos_plane.h"

namespace kirireel::formats {
namespace {

// Maximum deviation of a tip's direction from another tip, as a fraction of the distance. Rounding
// and fillets bend short tips.
constexpr double kTipAim = 0.25;
constexpr double kFacing = -0.5;  // largest cosine between tips that face each other
constexpr double kMinTurn = std::numbers::pi / 6;  // of the sides, radians
constexpr std::size_t kMaxVertices = 40;           // of a tip

/// The ring without vertices on straight lines.
PlaneRing withoutStraight(const PlaneRing& ring, double tolerance) {
  PlaneRing kept;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    const Vector2& before = kept.empty() ? ring.back() : kept.back();
    const Vector2 whole = ring[(k + 1) % ring.size()] - before, part = ring[k] - before;
    if (std::abs(crossZ(whole, part)) > tolerance * whole.norm() || whole.dot(part) < 0) {
      kept.push_back(ring[k]);
    }
  }
  return kept;
}

/// Whether a ring is a slot: a strip along half of its perimeter that is much longer than wide. A
/// star has a long perimeter too, but a wide middle.
bool isSlender(const PlaneRing& ring) {
  constexpr double kSlender = 0.05;  // width / length
  if (ringArea(ring) >= 0) return false;
  double perimeter = (ring.front() - ring.back()).norm();
  for (std::size_t k = 1; k < ring.size(); ++k) perimeter += (ring[k] - ring[k - 1]).norm();
  const double halfWidth = 0.25 * kSlender * perimeter;
  GeosPlane plane;
  return !(plane.area(plane.grown(plane.polygon(ring), -halfWidth)) > 0);
}

/// The angle by which the direction turns clockwise, around the opening, (-pi, pi].
double turnOf(const Vector2& from, const Vector2& to) {
  return -std::atan2(crossZ(from, to), from.dot(to));
}

struct TipChain {
  std::size_t first = 0, count = 1;  // of the vertices
  double side = 0;                   // length of the shorter side
};

class RingTips {
 public:
  explicit RingTips(const PlaneRing& ring) : ring_(ring) {}

  std::vector<OpeningTip> find() const {
    std::vector<TipChain> chains;
    for (std::size_t k = 0; k < ring_.size(); ++k) collectFrom(k, chains);
    std::ranges::stable_sort(chains, std::greater<>(), &TipChain::side);
    std::vector<bool> isTaken(ring_.size(), false);
    std::vector<OpeningTip> tips;
    for (const TipChain& chain : chains) {
      bool isFree = true;
      for (std::size_t k = 0; k < chain.count; ++k) isFree &= !isTaken[index(chain.first + k)];
      if (!isFree) continue;
      for (std::size_t k = 0; k < chain.count; ++k) isTaken[index(chain.first + k)] = true;
      tips.push_back(tipOf(chain));
    }
    return tips;
  }

 private:
  std::size_t index(std::size_t k) const { return k % ring_.size(); }
  const Vector2& at(std::size_t k) const { return ring_[index(k)]; }
  Vector2 edge(std::size_t k) const { return at(k + 1) - at(k); }
  Vector2 sideBefore(const TipChain& chain) const { return edge(chain.first + ring_.size() - 1); }
  Vector2 sideAfter(const TipChain& chain) const { return edge(chain.first + chain.count - 1); }

  /// Chains that start at this vertex.
  void collectFrom(std::size_t first, std::vector<TipChain>& chains) const {
    TipChain chain{first, 1, 0};
    double turn = 0, longest = 0;
    for (; chain.count <= std::min(kMaxVertices, ring_.size() - 2); ++chain.count) {
      const std::size_t last = first + chain.count - 1;
      const double corner = turnOf(edge(last + ring_.size() - 1), edge(last));
      turn += corner;
      if (chain.count > 1) longest = std::max(longest, edge(last - 1).norm());
      if (corner <= 0 || turn >= std::numbers::pi) return;
      chain.side = std::min(sideBefore(chain).norm(), sideAfter(chain).norm());
      const double width = (at(last) - at(first)).norm();
      if (turn >= kMinTurn && 2 * longest < chain.side && width < chain.side) {
        chains.push_back(chain);
      }
    }
  }

  OpeningTip tipOf(const TipChain& chain) const {
    OpeningTip tip;
    const Vector2 before = sideBefore(chain).normalized(), after = sideAfter(chain).normalized();
    tip.along = (before - after).normalized();
    tip.straight = chain.side;
    tip.isSharp = chain.count == 1;
    for (std::size_t k = 0; k < chain.count; ++k) tip.ends.push_back(at(chain.first + k));
    tip.from = tip.ends.front();
    if (tip.isSharp) return tip;
    tip.from = 0.5 * (tip.ends.front() + tip.ends.back());
    const auto shares = crossingShares(tip.ends.front(), before, tip.ends.back(), after);
    if (!shares) return tip;
    // The chain where it crosses the bisector.
    const Vector2 apex = tip.ends.front() + shares->first * before;
    for (std::size_t k = 0; k + 1 < tip.ends.size(); ++k) {
      const double one = crossZ(tip.along, tip.ends[k] - apex);
      const double other = crossZ(tip.along, tip.ends[k + 1] - apex);
      if ((one > 0) == (other > 0)) continue;
      tip.from = tip.ends[k] + one / (one - other) * (tip.ends[k + 1] - tip.ends[k]);
    }
    return tip;
  }

  const PlaneRing& ring_;
};

/// The tips of smooth openings, such as ellipses: the points of a chain that are farthest from its
/// middle. A chain is a whole ring, or lies between two corners of the material, such as a half
/// ellipse at the border of a sheet.
class SmoothTips {
 public:
  explicit SmoothTips(const PlaneRing& ring) : ring_(ring) {}

  std::vector<OpeningTip> find() {
    std::vector<std::size_t> breaks;
    for (std::size_t k = 0; k < ring_.size(); ++k) {
      if (std::abs(turnAt(k)) >= kMinTurn) breaks.push_back(k);
    }
    if (breaks.empty() && ringArea(ring_) < 0) addTips(0, ring_.size(), middleOf(ring_));
    for (std::size_t k = 0; k < breaks.size(); ++k) {
      const std::size_t first = breaks[k];
      const std::size_t last = k + 1 < breaks.size() ? breaks[k + 1] : breaks[0] + ring_.size();
      if (turnAt(first) > 0 || turnAt(last) > 0) continue;
      double turn = 0;
      for (std::size_t j = first + 1; j < last; ++j) turn += turnAt(j);
      if (turn > std::numbers::pi / 2) addTips(first, last, 0.5 * (at(first) + at(last)));
    }
    return std::move(tips_);
  }

 private:
  const Vector2& at(std::size_t k) const { return ring_[k % ring_.size()]; }
  double turnAt(std::size_t k) const {
    const Vector2& before = at(k + ring_.size() - 1);
    return turnOf(at(k) - before, at(k + 1) - at(k));
  }

  static Vector2 middleOf(const PlaneRing& ring) {
    Vector2 sum(0, 0);
    double whole = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vector2 a = ring[k] - ring[0], b = ring[(k + 1) % ring.size()] - ring[0];
      sum += crossZ(a, b) / 3 * (a + b);
      whole += crossZ(a, b);
    }
    return ring[0] + sum / whole;
  }

  void addTips(std::size_t first, std::size_t last, const Vector2& middle) {
    constexpr double kFarther = 1.1;  // than the points on both sides; circles have no tips
    const auto distanceAt = [&](std::size_t k) { return (at(k) - middle).norm(); };
    // A ring starts at its nearest point.
    if (last - first == ring_.size()) {
      for (std::size_t k = first; k < ring_.size(); ++k) {
        if (distanceAt(k) < distanceAt(first)) first = k;
      }
      last = first + ring_.size();
    }
    double nearest = distanceAt(first);
    std::size_t farthest = first;
    for (std::size_t k = first + 1; k <= last; ++k) {
      const double distance = distanceAt(k);
      if (distance > std::max(distanceAt(farthest), kFarther * nearest)) farthest = k;
      if (farthest == first || distanceAt(farthest) < kFarther * distance) {
        nearest = std::min(nearest, distance);
        continue;
      }
      const Vector2 from = at(farthest);
      tips_.push_back({from, (from - middle).normalized(), distanceAt(farthest), false, {}});
      first = farthest = k;
      nearest = distance;
    }
  }

  const PlaneRing& ring_;
  std::vector<OpeningTip> tips_;
};

/// Drops the rays of sharp tips at which other rays stop: their necks are there. Shorter rays count
/// first, after those of tips that are not sharp.
void dropAims(const std::vector<OpeningTip>& tips, double tolerance, std::vector<CutRay>& rays) {
  std::vector<std::size_t> order(rays.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {},
                           [&](std::size_t k) { return std::pair(tips[k].isSharp, rays[k].stop); });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const CutRay& ray = rays[order[i]];
    if (ray.stop == kNever || ray.isFacing) continue;
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      CutRay& aim = rays[order[j]];
      const bool isAim = (aim.from - ray.stopPlace).norm() <= 2 * tolerance;
      if (isAim && tips[order[j]].isSharp) aim.stop = kNever;
    }
  }
}

}  // namespace

std::vector<PlaneRing> orientedRings(std::vector<PlaneRing> rings,
                                     const std::vector<Vector2>& within) {
  std::ranges::stable_sort(rings, std::greater<>(),
                           [](const PlaneRing& ring) { return std::abs(ringArea(ring)); });
  const auto depthOf = [&](const Vector2& point) {
    return std::ranges::count_if(rings,
                                 [&](const PlaneRing& ring) { return isWithinRing(ring, point); });
  };
  const auto isFramed = [&] {
    const auto outside = std::ranges::count_if(
        within, [&](const Vector2& point) { return depthOf(point) % 2 == 0; });
    return 2 * outside > std::ssize(within);
  };
  while (!rings.empty() && isFramed()) rings.erase(rings.begin());
  std::vector<Eigen::AlignedBox2d> boxes;
  for (const PlaneRing& ring : rings) {
    Eigen::AlignedBox2d& box = boxes.emplace_back();
    for (const Vector2& point : ring) box.extend(point);
  }
  for (std::size_t r = 0; r < rings.size(); ++r) {
    PlaneRing& ring = rings[r];
    // A ring may touch others at its corners, or cross them.
    std::ptrdiff_t odd = 0;
    for (std::size_t k = 0; k < ring.size(); ++k) {
      const Vector2 middle = 0.5 * (ring[k] + ring[(k + 1) % ring.size()]);
      bool isOdd = false;
      for (std::size_t o = 0; o < rings.size(); ++o) {
        if (o == r || !boxes[o].contains(middle)) continue;
        if (isWithinRing(rings[o], middle)) isOdd = !isOdd;
      }
      odd += isOdd ? 1 : 0;
    }
    if ((ringArea(ring) > 0) != (2 * odd < std::ssize(ring))) std::ranges::reverse(ring);
  }
  return rings;
}

std::vector<OpeningTip> openingTips(const std::vector<PlaneRing>& rings, double tolerance) {
  std::vector<OpeningTip> tips;
  for (const PlaneRing& ring : rings) {
    if (isSlender(ring)) continue;
    const PlaneRing corners = withoutStraight(ring, tolerance);
    if (corners.size() < 3) continue;
    std::vector<OpeningTip> found = RingTips(corners).find();
    if (found.empty()) found = SmoothTips(corners).find();
    tips.insert(tips.end(), found.begin(), found.end());
  }
  return tips;
}

std::vector<CutRay> traceTips(const std::vector<OpeningTip>& tips, const Arrangement& lines,
                              double tolerance) {
  std::vector<CutRay> rays(tips.size());
  std::vector<int> facing(tips.size(), -1);
  for (std::size_t k = 0; k < tips.size(); ++k) {
    CutRay& ray = rays[k];
    ray.from = tips[k].from;
    ray.along = tips[k].along;
    ray.straight = tips[k].straight;
    ray.node = -1;
    ray.isRunning = false;
    findHit(ray, lines, tolerance);
    double nearest = kNever;
    for (std::size_t other = 0; other < tips.size(); ++other) {
      const Vector2 rest = tips[other].from - ray.from;
      const double ahead = rest.dot(ray.along);
      const double slack = std::max(ray.slack(ahead, tolerance), kTipAim * ahead);
      if (other == k || ahead <= tolerance || ahead > std::min(ray.hit + slack, nearest)) continue;
      if (tips[other].along.dot(ray.along) > kFacing) continue;
      if (std::abs(crossZ(ray.along, rest)) > slack) continue;
      facing[k] = static_cast<int>(other);
      nearest = ahead;
    }
  }
  for (std::size_t k = 0; k < tips.size(); ++k) {
    CutRay& ray = rays[k];
    const auto node = lines.nodeAt(ray.from);
    const bool isUsed = tips[k].isSharp && node && lines.leaving(*node).size() > 2;
    if (isUsed || ray.hit == kNever) continue;
    ray.stopPlace = ray.hitPlace;
    if (facing[k] >= 0) {
      const OpeningTip& other = tips[facing[k]];
      if (tips[k].isSharp && !other.isSharp) continue;  // the other ray runs to this corner
      const bool isMutual = facing[facing[k]] == static_cast<int>(k);
      ray.isFacing = isMutual && tips[k].isSharp == other.isSharp;
      if (ray.isFacing) {
        ray.stopPlace = 0.5 * (ray.from + other.from);
      } else if (other.isSharp) {
        ray.stopPlace = other.from;
      }
    }
    ray.stop = (ray.stopPlace - ray.from).norm();
  }
  dropAims(tips, tolerance, rays);
  return rays;
}

double widestTip(const std::vector<CutRay>& rays, double known, double area, int faces) {
  constexpr double kOfKnown = 2;
  constexpr double kOfTile = 0.5;
  // Narrower necks are alike, as a fraction of a tile.
  constexpr double kNarrow = 0.02;
  std::vector<double> widths;
  for (const CutRay& ray : rays) {
    if (ray.stop < kNever) widths.push_back(ray.stop);
  }
  if (widths.empty()) return 0;
  std::ranges::sort(widths);
  // Two necks make a tile.
  const auto tile = [&](std::size_t necks) {
    return std::sqrt(area / (faces + 0.5 * static_cast<double>(necks)));
  };
  std::size_t count = 0;
  while (count < widths.size() && widths[count] < kOfTile * tile(count + 1)) ++count;
  if (count == 0) return 0;
  const double most = kOfTile * tile(count);
  if (known > 0) return std::min(kOfKnown * known, most);
  widths.resize(count);
  widths.push_back(most);
  std::size_t best = 0;
  const auto ratio = [&](std::size_t k) {
    return widths[k + 1] / std::max(widths[k], kNarrow * tile(count));
  };
  for (std::size_t k = 1; k < count; ++k) {
    if (ratio(k) >= ratio(best)) best = k;
  }
  return 0.5 * (widths[best] + widths[best + 1]);
}

}  // namespace kirireel::formats
