/// Arrangement of lines in the plane: their intersections, and the faces between them.
#pragma once

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/formats/drawing.h"

namespace kirireel::formats {

/// Numbered points of the plane. Points within a tolerance are one.
class PointNumbers {
 public:
  /// Cells are relative to `origin`, a point of the drawing, which keeps their numbers small.
  PointNumbers(double tolerance, const Vector2& origin) : tolerance_(tolerance), origin_(origin) {}

  /// The number of the known point at this position; absent if there is none.
  std::optional<int> find(const Vector2& point) const;
  /// The number of the point; a new one if no known point is near.
  int add(const Vector2& point);

  const Vector2& operator[](int number) const { return points_[number]; }
  int count() const { return static_cast<int>(points_.size()); }
  const std::vector<Vector2>& points() const { return points_; }

 private:
  std::pair<long, long> cellOf(const Vector2& point) const;

  double tolerance_;
  Vector2 origin_;
  std::vector<Vector2> points_;
  std::unordered_map<long, std::vector<int>> cells_;
};

/// A straight segment, metres.
using PlaneSegment = std::pair<Vector2, Vector2>;

/// A closed polygon without its last point, metres.
using PlaneRing = std::vector<Vector2>;

/// Shares s and t with p + s u = q + t v, where two lines cross. Absent for parallel lines.
inline std::optional<std::pair<double, double>> crossingShares(const Vector2& p, const Vector2& u,
                                                               const Vector2& q, const Vector2& v) {
  const double area = crossZ(u, v);
  if (area == 0) return {};
  const Vector2 apart = q - p;
  return std::pair(crossZ(apart, v) / area, crossZ(apart, u) / area);
}

/// Calls visit(i, j), i != j, once per pair of segments whose boxes are within reach, metres.
template <typename Visit>
void visitNearSegments(const std::vector<PlaneSegment>& segments, double reach, Visit visit);

/// The planar subdivision by segments. Ends and crossings within the tolerance are one node. An end
/// within the tolerance of another segment lies on it. Coinciding pieces are one edge. Edge e has
/// the half edges 2 e, from first to second, and 2 e + 1, in reverse.
class Arrangement {
 public:
  Arrangement() = default;
  /// The cost is a sort, and a test of each pair of segments with overlapping boxes.
  Arrangement(const std::vector<PlaneSegment>& segments, double tolerance);
  /// Edges between numbered nodes that meet only at nodes, none twice. There is no nodeAt().
  Arrangement(std::vector<Vector2> nodes, std::vector<std::pair<int, int>> edges)
      : nodes_(std::move(nodes)), edges_(std::move(edges)) {
    connect();
  }

  const std::vector<Vector2>& nodes() const { return nodes_; }
  const std::vector<std::pair<int, int>>& edges() const { return edges_; }
  /// The node at a position; absent if there is none.
  std::optional<int> nodeAt(const Vector2& place) const { return numbers_.find(place); }
  /// Half edges that start at a node, anticlockwise.
  const std::vector<int>& leaving(int node) const { return leaving_[node]; }
  /// The numbers of the segments that an edge is part of, ascending. Empty for given edges.
  const std::vector<int>& segmentsOf(int edge) const { return segments_[edge]; }
  int from(int half) const { return half % 2 ? edges_[half / 2].second : edges_[half / 2].first; }
  int to(int half) const { return from(half ^ 1); }
  const Vector2& at(int node) const { return nodes_[node]; }

  /// Drops edges with the same face on both sides: open ends and bridges.
  void dropBridges();

  /// The cycles of half edges with a face on their left. Clockwise cycles are the outer boundaries
  /// of connected parts.
  const std::vector<std::vector<int>>& cycles() const { return cycles_; }
  /// The number of the cycle of a half edge.
  int cycleOf(int half) const { return cycleOf_[half]; }
  /// The area inside a cycle, square metres; < 0 for clockwise cycles.
  double areaOf(int cycle) const;
  /// The number of each node's connected part.
  std::vector<int> parts() const;

 private:
  void connect();

  PointNumbers numbers_{1, Vector2::Zero()};
  std::vector<Vector2> nodes_;
  std::vector<std::pair<int, int>> edges_;
  std::vector<std::vector<int>> segments_;  // of edges
  std::vector<std::vector<int>> leaving_;
  std::vector<std::vector<int>> cycles_;
  std::vector<int> cycleOf_;
};

/// Whether the cycles are faces of sheets. A face next to the outside is. Of two other neighbours,
/// exactly one is if their common edge is a boundary, else both or none. Cycles with an area up to
/// `least` are the outside.
std::vector<bool> sheetCycles(const Arrangement& lines, const std::vector<bool>& isBoundary,
                              double least);

/// A node of a sheet's face that has a separate part of the drawing inside, and a node of that
/// part. Absent if there is none.
std::optional<std::pair<int, int>> faceAround(const Arrangement& lines,
                                              const std::vector<bool>& isSheet);

/// Appends the sides of a closed polygon.
inline void appendRing(const PlaneRing& ring, std::vector<PlaneSegment>& segments) {
  for (std::size_t k = 0; k < ring.size(); ++k) {
    segments.emplace_back(ring[k], ring[(k + 1) % ring.size()]);
  }
}

/// Whether a point is within closed lines: a ray along x crosses them an odd number of times.
bool isWithin(const std::vector<PlaneSegment>& lines, const Vector2& point);

/// The same for one closed polygon.
bool isWithinRing(const PlaneRing& ring, const Vector2& point);
/// Whether all points are.
bool areWithinRing(const PlaneRing& ring, const std::vector<Vector2>& points);

/// The area of a closed polygon, > 0 if anticlockwise.
double ringArea(const PlaneRing& ring);

/// The points of a chain to keep, including both ends, for a simplification within the tolerance
/// (D. H. Douglas, T. K. Peucker 1973).
std::vector<bool> simplifiedChain(const std::vector<Vector2>& chain, double tolerance);

// ------------------------------------------------------------------------------------------------

template <typename Visit>
void visitNearSegments(const std::vector<PlaneSegment>& segments, double reach, Visit visit) {
  struct SegmentBox {
    double left, right, low, high;
    int number;
  };
  std::vector<SegmentBox> boxes;
  boxes.reserve(segments.size());
  for (std::size_t k = 0; k < segments.size(); ++k) {
    const Vector2 low = segments[k].first.cwiseMin(segments[k].second);
    const Vector2 high = segments[k].first.cwiseMax(segments[k].second);
    boxes.push_back({low.x() - reach / 2, high.x() + reach / 2, low.y() - reach / 2,
                     high.y() + reach / 2, static_cast<int>(k)});
  }
  std::sort(boxes.begin(), boxes.end(), [](const SegmentBox& a, const SegmentBox& b) {
    return a.left != b.left ? a.left < b.left : a.number < b.number;
  });
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = i + 1; j < boxes.size() && boxes[j].left <= boxes[i].right; ++j) {
      if (boxes[j].low > boxes[i].high || boxes[j].high < boxes[i].low) continue;
      visit(boxes[i].number, boxes[j].number);
    }
  }
}

}  // namespace kirireel::formats
