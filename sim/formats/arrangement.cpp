// The faces of a planar straight-line graph (M. de Berg, O. Cheong, M. van Kreveld, M. Overmars,
// Computational Geometry, chapter 2). At the end of a half edge the next one of its cycle is the
// first clockwise from the reverse direction. Points are compared through a grid of cells, segments
// by a sweep over their boxes.
#include "sim/formats/arrangement.h"

#include <cmath>
#include <map>

namespace kirireel::formats {

std::optional<int> PointNumbers::find(const Vector2& point) const {
  // Cells are as wide as the tolerance. A point within it is in this cell or a neighbouring cell.
  const auto [column, row] = cellOf(point);
  for (long x = column - 1; x <= column + 1; ++x) {
    for (long y = row - 1; y <= row + 1; ++y) {
      // Cells with the same key by chance only cost time, since the points are compared.
      const auto cell = cells_.find(static_cast<long>(static_cast<unsigned long>(x) * 1000003UL +
                                                      static_cast<unsigned long>(y)));
      if (cell == cells_.end()) continue;
      for (const int number : cell->second) {
        if ((points_[number] - point).norm() <= tolerance_) return number;
      }
    }
  }
  return std::nullopt;
}

int PointNumbers::add(const Vector2& point) {
  if (const std::optional<int> known = find(point)) return *known;
  const auto [column, row] = cellOf(point);
  points_.push_back(point);
  cells_[static_cast<long>(static_cast<unsigned long>(column) * 1000003UL +
                           static_cast<unsigned long>(row))]
      .push_back(static_cast<int>(points_.size()) - 1);
  return static_cast<int>(points_.size()) - 1;
}

std::pair<long, long> PointNumbers::cellOf(const Vector2& point) const {
  const Vector2 steps = (point - origin_) / tolerance_;
  return {std::lround(steps.x()), std::lround(steps.y())};
}

Arrangement::Arrangement(const std::vector<PlaneSegment>& segments, double tolerance)
    : numbers_(tolerance, segments.empty() ? Vector2(0, 0) : segments.front().first) {
  std::vector<std::pair<int, int>> ends;
  for (const PlaneSegment& one : segments) {
    const int first = numbers_.add(one.first);
    ends.emplace_back(first, numbers_.add(one.second));
  }
  std::vector<std::vector<std::pair<double, int>>> splits(segments.size());
  const auto split = [&](int k, int node) {
    const auto& [a, b] = segments[k];
    splits[k].emplace_back((numbers_[node] - a).dot(b - a), node);
  };
  // Whether a node lies on a segment, off its ends.
  const auto liesOn = [&](int node, int k) {
    if (node == ends[k].first || node == ends[k].second) return false;
    const auto& [a, b] = segments[k];
    const Vector2 along = b - a, rest = numbers_[node] - a;
    const double length = along.norm(), place = rest.dot(along) / length;
    return place > 0 && place < length && std::abs(crossZ(along, rest)) <= tolerance * length;
  };
  visitNearSegments(segments, 2 * tolerance, [&](int i, int j) {
    if (ends[i].first == ends[i].second || ends[j].first == ends[j].second) return;
    bool touches = ends[i].first == ends[j].first || ends[i].first == ends[j].second ||
                   ends[i].second == ends[j].first || ends[i].second == ends[j].second;
    for (const auto& [one, other] : {std::pair(i, j), std::pair(j, i)}) {
      for (const int node : {ends[one].first, ends[one].second}) {
        if (!liesOn(node, other)) continue;
        split(other, node);
        touches = true;
      }
    }
    if (touches) return;
    const auto& [from, to] = segments[i];
    const auto shares =
        crossingShares(from, to - from, segments[j].first, segments[j].second - segments[j].first);
    if (!shares || std::min(shares->first, shares->second) <= 0 ||
        std::max(shares->first, shares->second) >= 1) {
      return;
    }
    const int node = numbers_.add(from + shares->first * (to - from));
    split(i, node);
    split(j, node);
  });
  std::map<std::pair<int, int>, std::size_t> known;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    std::sort(splits[k].begin(), splits[k].end());
    int last = ends[k].first;
    splits[k].emplace_back(0, ends[k].second);
    for (const auto& [place, node] : splits[k]) {
      if (node == last) continue;
      const auto [edge, isNew] = known.emplace(std::minmax(last, node), edges_.size());
      if (isNew) {
        edges_.emplace_back(last, node);
        segments_.emplace_back();
      }
      segments_[edge->second].push_back(static_cast<int>(k));
      last = node;
    }
  }
  nodes_ = numbers_.points();
  connect();
}

void Arrangement::connect() {
  leaving_.assign(nodes_.size(), {});
  for (int half = 0; half < 2 * static_cast<int>(edges_.size()); ++half) {
    leaving_[from(half)].push_back(half);
  }
  const auto angle = [&](int half) {
    const Vector2 along = at(to(half)) - at(from(half));
    return std::atan2(along.y(), along.x());
  };
  std::vector<int> place(2 * edges_.size());
  for (std::vector<int>& around : leaving_) {
    std::stable_sort(around.begin(), around.end(),
                     [&](int a, int b) { return angle(a) < angle(b); });
    for (std::size_t k = 0; k < around.size(); ++k) place[around[k]] = static_cast<int>(k);
  }
  cycles_.clear();
  cycleOf_.assign(2 * edges_.size(), -1);
  for (int first = 0; first < std::ssize(cycleOf_); ++first) {
    if (cycleOf_[first] >= 0) continue;
    std::vector<int>& cycle = cycles_.emplace_back();
    for (int half = first; cycleOf_[half] < 0;) {
      cycleOf_[half] = static_cast<int>(cycles_.size()) - 1;
      cycle.push_back(half);
      const std::vector<int>& around = leaving_[to(half)];
      half = around[(place[half ^ 1] + around.size() - 1) % around.size()];
    }
  }
}

void Arrangement::dropBridges() {
  std::vector<std::pair<int, int>> kept;
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (cycleOf_[2 * e] != cycleOf_[2 * e + 1]) kept.push_back(edges_[e]);
  }
  edges_ = std::move(kept);
  connect();
}

double Arrangement::areaOf(int cycle) const {
  std::vector<Vector2> ring;
  for (const int half : cycles_[cycle]) ring.push_back(at(from(half)));
  return ringArea(ring);
}

std::vector<int> Arrangement::parts() const {
  std::vector<int> part(nodes().size(), -1);
  int count = 0;
  for (int first = 0; first < std::ssize(part); ++first) {
    if (part[first] >= 0) continue;
    std::vector<int> open{first};
    part[first] = count;
    while (!open.empty()) {
      const int node = open.back();
      open.pop_back();
      for (const int half : leaving_[node]) {
        if (part[to(half)] >= 0) continue;
        part[to(half)] = count;
        open.push_back(to(half));
      }
    }
    ++count;
  }
  return part;
}

std::vector<bool> sheetCycles(const Arrangement& lines, const std::vector<bool>& isBoundary,
                              double least) {
  // Breadth first from the outside of all parts.
  std::vector<std::optional<bool>> isSheet(lines.cycles().size());
  std::vector<bool> isOutside;
  std::vector<int> waiting;
  for (int cycle = 0; cycle < std::ssize(isSheet); ++cycle) {
    isOutside.push_back(lines.areaOf(cycle) <= least);
  }
  const auto set = [&](int cycle, bool value) {
    if (isSheet[cycle] || isOutside[cycle]) return;
    isSheet[cycle] = value;
    waiting.push_back(cycle);
  };
  for (int half = 0; half < 2 * std::ssize(lines.edges()); ++half) {
    if (isOutside[lines.cycleOf(half)]) set(lines.cycleOf(half ^ 1), true);
  }
  for (std::size_t k = 0; k < waiting.size(); ++k) {
    const bool isOwn = *isSheet[waiting[k]];
    for (const int half : lines.cycles()[waiting[k]]) {
      set(lines.cycleOf(half ^ 1), isOwn != isBoundary[half / 2]);
    }
  }
  std::vector<bool> known;
  for (const std::optional<bool>& value : isSheet) known.push_back(value.value_or(false));
  return known;
}

std::optional<std::pair<int, int>> faceAround(const Arrangement& lines,
                                              const std::vector<bool>& isSheet) {
  const std::vector<int> parts = lines.parts();
  const auto firstOf = [&](int cycle) { return lines.from(lines.cycles()[cycle].front()); };
  std::map<int, int> insideOf;  // a node of each part
  for (int cycle = 0; cycle < std::ssize(isSheet); ++cycle) {
    if (isSheet[cycle]) insideOf.emplace(parts[firstOf(cycle)], firstOf(cycle));
  }
  for (int face = 0; face < std::ssize(isSheet) && insideOf.size() > 1; ++face) {
    if (!isSheet[face]) continue;
    PlaneRing ring;
    for (const int half : lines.cycles()[face]) ring.push_back(lines.at(lines.from(half)));
    for (const auto& [part, node] : insideOf) {
      if (part != parts[firstOf(face)] && isWithinRing(ring, lines.at(node))) {
        return std::pair(firstOf(face), node);
      }
    }
  }
  return std::nullopt;
}

namespace {

/// Whether the ray from the point along x crosses the segment from a to b.
bool crossesRay(const Vector2& a, const Vector2& b, const Vector2& point) {
  if ((a.y() > point.y()) == (b.y() > point.y())) return false;
  return point.x() < a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
}

}  // namespace

bool isWithin(const std::vector<PlaneSegment>& lines, const Vector2& point) {
  bool isInside = false;
  for (const auto& [a, b] : lines) isInside = isInside != crossesRay(a, b, point);
  return isInside;
}

bool isWithinRing(const PlaneRing& ring, const Vector2& point) {
  bool isInside = false;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    isInside = isInside != crossesRay(ring[k], ring[(k + 1) % ring.size()], point);
  }
  return isInside;
}

bool areWithinRing(const PlaneRing& ring, const std::vector<Vector2>& points) {
  return std::ranges::all_of(points,
                             [&](const Vector2& point) { return isWithinRing(ring, point); });
}

double ringArea(const PlaneRing& ring) {
  double twice = 0;
  for (std::size_t k = 0; k < ring.size(); ++k) {
    // Relative to the first point, which keeps the precision of distant positions.
    twice += crossZ(ring[k] - ring[0], ring[(k + 1) % ring.size()] - ring[0]);
  }
  return 0.5 * twice;
}

std::vector<bool> simplifiedChain(const std::vector<Vector2>& chain, double tolerance) {
  std::vector<bool> isKept(chain.size(), false);
  if (chain.empty()) return isKept;
  isKept.front() = isKept.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, chain.size() - 1}};
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double worst = tolerance;
    std::size_t where = first;
    const Vector2 along = chain[last] - chain[first];
    const double length = along.norm();
    for (std::size_t k = first + 1; k < last; ++k) {
      const Vector2 rest = chain[k] - chain[first];
      const double place = length > 0 ? rest.dot(along) / length : 0;
      const double off = place > 0 && place < length
                             ? std::abs(crossZ(along, rest)) / length
                             : std::min(rest.norm(), (chain[k] - chain[last]).norm());
      if (off <= worst) continue;
      worst = off;
      where = k;
    }
    if (where == first) continue;
    isKept[where] = true;
    open.emplace_back(first, where);
    open.emplace_back(where, last);
  }
  return isKept;
}

}  // namespace kirireel::formats
