// Extends the open ends of cuts.
//
// All rays grow straight and at the same speed. A ray stops at the first line or earlier ray. Two
// rays towards one vertex both stop there. Ends that face each other meet midway. This is the
// motorcycle graph (D. Eppstein, J. Erickson, Raising roofs, crashing cycles, and playing pool,
// Discrete & Computational Geometry 22, 1999), except that the first ray at a crossing waits there
// for the second.
//
// Necks are the rays up to a maximum width. The number of tiles changes only at ray lengths, so the
// maximum lies in the longest interval between them.
#include "sim/formats/cut_rays.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace kirireel::formats {
namespace {

// Maximum deviation of a cut's direction from its aim, as a fraction of the distance.
constexpr double kAim = 0.03;

class RayTracer {
 public:
  /// `curveError`: deviation of straight pieces from their curve, metres; 0 without curves.
  RayTracer(const Arrangement& lines, double curveError, double tolerance)
      : lines_(lines), curveError_(curveError), tolerance_(tolerance) {
    for (int node = 0; node < std::ssize(lines.nodes()); ++node) {
      if (lines.leaving(node).size() == 1) rays_.push_back(rayAt(node));
    }
    std::vector<int> rayOf(lines.nodes().size(), -1);
    for (int k = 0; k < std::ssize(rays_); ++k) rayOf[rays_[k].node] = k;
    for (CutRay& ray : rays_) {
      const int node = findHit(ray, lines_, tolerance_);
      const int facing = node >= 0 ? rayOf[node] : -1;
      const bool faces = facing >= 0 && rays_[facing].along.dot(ray.along) < -0.9;
      ray.partner = faces ? facing : -1;
    }
  }

  /// Finds the stop of every ray.
  std::vector<CutRay> run() {
    struct RayEvent {
      double time;
      int one, other;  // other: -1 at a line
      double alongOne, alongOther;
    };
    std::vector<RayEvent> events;
    for (int i = 0; i < std::ssize(rays_); ++i) {
      const CutRay& ray = rays_[i];
      if (ray.hit == kNever) continue;
      // Ends that face each other wait for rays that aim between them.
      events.push_back({ray.partner >= 0 ? 3 * ray.hit : ray.hit, i, -1, ray.hit, 0});
    }
    for (int i = 0; i < std::ssize(rays_); ++i) {
      for (int j = i + 1; j < std::ssize(rays_); ++j) {
        if (std::abs(crossZ(rays_[i].along, rays_[j].along)) < 1e-3) continue;
        const auto [s, t] =
            *crossingShares(rays_[i].from, rays_[i].along, rays_[j].from, rays_[j].along);
        const bool isAhead = s > tolerance_ && t > tolerance_;
        if (!isAhead || s > rays_[i].hit + tolerance_ || t > rays_[j].hit + tolerance_) continue;
        if (s == kNever || t == kNever) continue;
        events.push_back({std::max(s, t), i, j, s, t});
      }
    }
    std::ranges::stable_sort(events, {}, &RayEvent::time);
    for (const RayEvent& event : events) {
      CutRay& one = rays_[event.one];
      if (event.other < 0) {
        if (one.isRunning) reachLine(event.one);
        continue;
      }
      CutRay& other = rays_[event.other];
      const auto covers = [&](const CutRay& ray, double distance) {
        return ray.isRunning || ray.stop >= distance - ray.slack(distance, tolerance_);
      };
      if ((!one.isRunning && !other.isRunning) || !covers(one, event.alongOne) ||
          !covers(other, event.alongOther)) {
        continue;
      }
      Vector2 place = one.from + event.alongOne * one.along;
      if (one.isRunning && other.isRunning) {
        place = settled(place, event.time);
      } else {
        // On the path of the stopped ray, or at its stop.
        const CutRay& trail = one.isRunning ? other : one;
        const double near = tolerance_ + kAim * event.time;
        if ((trail.stopPlace - place).norm() <= near) place = trail.stopPlace;
      }
      for (CutRay* ray : {&one, &other}) {
        if (ray->isRunning) stopAt(*ray, place);
      }
    }
    return std::move(rays_);
  }

 private:
  CutRay rayAt(int node) const {
    CutRay ray;
    ray.node = node;
    ray.from = lines_.at(node);
    int last = lines_.to(lines_.leaving(node)[0]);
    const Vector2 piece = ray.from - lines_.at(last);
    ray.along = piece.normalized();
    // Backwards along the straight line. A longer line gives a more accurate direction.
    for (int before = node; before >= 0;) {
      int further = -1;
      for (const int half : lines_.leaving(last)) {
        const Vector2 whole = ray.from - lines_.at(lines_.to(half));
        const Vector2 step = lines_.at(last) - lines_.at(lines_.to(half));
        if (lines_.to(half) == before || step.dot(ray.along) <= 0.99 * step.norm()) continue;
        const double off = std::abs(crossZ(whole, ray.from - lines_.at(last))) / whole.norm();
        if (off <= tolerance_) further = lines_.to(half);
      }
      if (further < 0) break;
      before = last;
      last = further;
      ray.along = (ray.from - lines_.at(last)).normalized();
    }
    ray.straight = (ray.from - lines_.at(last)).norm();
    // The tangent at a curve's end is half a turn angle beyond its last piece. A piece of length L
    // that turns by a deviates from its curve by L a / 8.
    if (curveError_ > 0 && lines_.leaving(last).size() == 2) {
      for (const int half : lines_.leaving(last)) {
        const Vector2 before = lines_.at(last) - lines_.at(lines_.to(half));
        const double turn = std::atan2(crossZ(before, ray.along), before.dot(ray.along));
        const double ratio = before.norm() / ray.straight;
        const bool isCurve = ray.straight * std::abs(turn) <= 8 * curveError_;
        if (isCurve && std::abs(turn) < 0.8 && ratio > 0.5 && ratio < 2) {
          ray.along = Eigen::Rotation2Dd(turn / 2) * ray.along;
        }
      }
    }
    return ray;
  }

  void stopAt(CutRay& ray, const Vector2& place) {
    ray.isRunning = false;
    ray.stop = (place - ray.from).norm();
    ray.stopPlace = place;
    stops_.push_back(place);
  }

  void reachLine(int number) {
    CutRay& ray = rays_[number];
    if (ray.partner < 0) return stopAt(ray, ray.hitPlace);
    CutRay& partner = rays_[ray.partner];
    if (!partner.isRunning) return stopAt(ray, partner.stopPlace);
    const Vector2 middle = 0.5 * (ray.from + partner.from);
    stopAt(ray, middle);
    stopAt(partner, middle);
    ray.isFacing = partner.isFacing = true;
  }

  /// One vertex for all rays that meet there within rounding.
  Vector2 settled(const Vector2& place, double distance) const {
    for (const Vector2& known : stops_) {
      if ((known - place).norm() <= tolerance_ + kAim * distance) return known;
    }
    return place;
  }

  const Arrangement& lines_;
  double curveError_;  // metres
  double tolerance_;
  std::vector<CutRay> rays_;
  std::vector<Vector2> stops_;
};

}  // namespace

int findHit(CutRay& ray, const Arrangement& lines, double tolerance) {
  int aim = -1;
  for (const auto& [first, second] : lines.edges()) {
    if (first == ray.node || second == ray.node) continue;
    // Whether there are ends of the line that the cut aims at.
    bool hasEnd = false;
    for (const int node : {first, second}) {
      const Vector2 rest = lines.at(node) - ray.from;
      const double ahead = rest.dot(ray.along);
      // Points within the tolerance of the cut's end are this end.
      if (ahead <= 0 || std::abs(crossZ(ray.along, rest)) > ray.slack(ahead, tolerance)) continue;
      hasEnd = true;
      if (ahead >= ray.hit) continue;
      ray.hit = ahead;
      ray.hitPlace = lines.at(node);
      aim = node;
    }
    if (hasEnd) continue;
    const Vector2 a = lines.at(first), line = lines.at(second) - a;
    const auto shares = crossingShares(ray.from, ray.along, a, line);
    if (!shares) continue;
    const auto [ahead, share] = *shares;
    if (ahead <= tolerance || ahead >= ray.hit || share < 0 || share > 1) continue;
    ray.hit = ahead;
    ray.hitPlace = a + share * line;
    aim = -1;
  }
  return aim;
}

double CutRay::slack(double distance, double tolerance) const {
  return tolerance * (1 + distance / std::max(straight, tolerance)) + kAim * distance;
}

std::vector<CutRay> traceCutRays(const Arrangement& lines, double curveError, double tolerance) {
  return RayTracer(lines, curveError, tolerance).run();
}

std::vector<double> crossingsOf(const std::vector<PlaneSegment>& border, const Vector2& from,
                                const Vector2& along) {
  std::vector<double> distances;
  for (const auto& [a, b] : border) {
    const auto shares = crossingShares(from, along, a, b - a);
    if (shares && shares->second >= 0 && shares->second <= 1) distances.push_back(shares->first);
  }
  return distances;
}

void findNeckTips(std::vector<CutRay>& rays, const std::vector<PlaneSegment>& border, double kerf,
                  double tolerance) {
  for (CutRay& ray : rays) {
    if (ray.stop == kNever || border.empty()) continue;
    // A slit in the material between slots has no width.
    if (kerf > 0 && isWithin(border, ray.from)) {
      ray.isJoined = ray.stop < 0.5 * kerf + tolerance;
      continue;
    }
    double first = kNever, last = 0, end = 0;
    for (const double ahead : crossingsOf(border, ray.from, ray.along)) {
      if (ahead < -tolerance || ahead > ray.stop - tolerance) continue;
      first = std::min(first, std::max(ahead, 0.0));
      end = std::max(end, ahead);
      // For a relieved slit, the far side of its own relief.
      if (ahead <= 0.5 * ray.stop) last = std::max(last, ahead);
    }
    // Material ends at a slot, or at the stop.
    if (isWithin(border, ray.from + (ray.stop - tolerance) * ray.along)) end = ray.stop;
    // Rounding of both borders leaves slivers.
    ray.isJoined = kerf > 0 && (first == kNever || end - first <= 3 * tolerance);
    ray.tip = ray.isJoined ? 0 : kerf > 0 ? first : last;
  }
}

double neckMaterial(const CutRay& ray, const std::vector<PlaneSegment>& border, double tolerance) {
  const Vector2 along = (ray.stopPlace - ray.from).normalized();
  if (isWithin(border, ray.stopPlace - tolerance * along)) return ray.width();
  double end = ray.tip;
  for (const double ahead : crossingsOf(border, ray.from, along)) {
    if (ahead <= ray.stop) end = std::max(end, ahead);
  }
  return end - ray.tip;
}

double widestNeck(const std::vector<CutRay>& rays, double scale) {
  const double cap = 0.5 * scale;
  std::vector<double> widths;
  for (const CutRay& ray : rays) {
    if (ray.stop < kNever && !ray.isJoined && ray.width() < cap) widths.push_back(ray.width());
  }
  if (widths.empty()) return 0;
  std::ranges::sort(widths);
  widths.push_back(cap);
  std::size_t best = 0;
  for (std::size_t k = 0; k + 1 < widths.size(); ++k) {
    // If intervals are equal, take the one with wider necks.
    if (widths[k + 1] - widths[k] >= widths[best + 1] - widths[best]) best = k;
  }
  return 0.5 * (widths[best] + widths[best + 1]);
}

}  // namespace kirireel::formats
