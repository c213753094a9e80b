// Binary space partition (H. Fuchs, Z. M. Kedem, B. F. Naylor, "On Visible Surface Generation by A
// Priori Tree Structures", SIGGRAPH 1980). One piece is selected as splitter. Its plane n . p = o
// divides the others:
//
//     back (n . p < o)    on (within the tolerance)    front (n . p > o)
//
// A piece on both sides is cut in two. Back and front are sorted recursively. The order back, on,
// front is correct for the painter's algorithm, because every splitter faces the camera: nothing
// behind its plane can hide pieces on it or in front of it.
//
// The splitter is the best of twelve candidates, by the cost 8 cuts + |front - back|. Few cuts keep
// the file small, balance limits the depth of recursion. n pieces take about 12 n log n tests if
// planes divide well.
//
// Sorting by distance would be simpler, but wrong for faces that cross or hide each other
// cyclically.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "render/picture/picture_geometry.h"
#include "sim/base/interruption.h"

namespace kirireel::picture {
namespace {

/// Points nearer to a plane than this fraction of the model count as on it.
constexpr double kOnPlane = 1e-7;

/// Number of candidate planes at each cut.
constexpr std::size_t kCandidates = 12;

/// Cost of one additional cut polygon, in polygons of imbalance.
constexpr int kCostOfCut = 8;

/// A facet hides nothing this near to its own sides, in heights of the picture, since its
/// neighbours' sides are there. Far less than the width of an outline, whose own line covers the
/// remainder.
constexpr double kSideMargin = 2e-4;

struct Plane {
  Vector3 normal;
  double offset;
  double tolerance;

  double distance(const Vector3& point) const { return normal.dot(point) - offset; }
};

/// The part of a polygon in front of the plane (Sutherland and Hodgman's clipping). A side along
/// the plane is marked as cut. Empty if less than a triangle remains.
CutPolygon frontPart(const CutPolygon& polygon, const Plane& plane) {
  CutPolygon part;
  const std::size_t count = polygon.corners.size();
  const auto add = [&part](const Vector3& point, bool isCut) {
    part.corners.push_back(point);
    part.isCut.push_back(isCut ? 1 : 0);
  };
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3& from = polygon.corners[k];
    const Vector3& to = polygon.corners[(k + 1) % count];
    const double before = plane.distance(from), after = plane.distance(to);
    const bool isCut = polygon.isCut[k] != 0;
    if (before >= 0) add(from, isCut);
    if ((before >= 0) == (after >= 0)) continue;
    // The side after the point at which the polygon leaves the front is the cut.
    add(from + before / (before - after) * (to - from), before >= 0 || isCut);
  }
  if (part.corners.size() < 3) return {};
  return part;
}

Piece frontPart(const Piece& piece, const Plane& plane) {
  Piece part = piece;
  part.outer = frontPart(piece.outer, plane);
  return part;
}

struct Sides {
  bool front = false;
  bool back = false;
};

Sides sidesOf(const Piece& piece, const Plane& plane) {
  Sides sides;
  for (const Vector3& corner : piece.outer.corners) {
    const double distance = plane.distance(corner);
    sides.front |= distance > plane.tolerance;
    sides.back |= distance < -plane.tolerance;
  }
  return sides;
}

/// Recursion over smaller and smaller parts of space.
class Sorter {
 public:
  explicit Sorter(double tolerance) : tolerance_(tolerance) {}

  void sort(std::vector<Piece> pieces) {
    if (pieces.empty()) return;
    const std::size_t splitter = bestSplitter(pieces);
    const Plane plane = planeOf(pieces[splitter]);
    std::vector<Piece> back, on, front;
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      Piece& piece = pieces[k];
      // Tiles need not be exactly flat. The splitter is on its own plane by definition, so every
      // step removes one piece.
      const Sides sides = k == splitter ? Sides{} : sidesOf(piece, plane);
      if (sides.front && sides.back) {
        keep(frontPart(piece, {-plane.normal, -plane.offset, plane.tolerance}), back);
        keep(frontPart(piece, plane), front);
      } else {
        (sides.front ? front : sides.back ? back : on).push_back(std::move(piece));
      }
    }
    pieces = {};  // frees the memory before the recursion
    sort(std::move(back));
    std::move(on.begin(), on.end(), std::back_inserter(sorted));
    sort(std::move(front));
  }

  std::vector<Piece> sorted;

 private:
  static void keep(Piece piece, std::vector<Piece>& pieces) {
    if (!piece.outer.corners.empty()) pieces.push_back(std::move(piece));
  }

  Plane planeOf(const Piece& piece) const { return {piece.normal, piece.offset, tolerance_}; }

  std::size_t bestSplitter(const std::vector<Piece>& pieces) const {
    const std::size_t stride = 1 + (pieces.size() - 1) / kCandidates;
    std::size_t best = 0;
    int least = std::numeric_limits<int>::max();
    for (std::size_t candidate = 0; candidate < pieces.size(); candidate += stride) {
      checkInterruption();
      const int cost = costOf(planeOf(pieces[candidate]), pieces);
      if (cost >= least) continue;
      least = cost;
      best = candidate;
    }
    return best;
  }

  /// Checks all pieces.
  static int costOf(const Plane& plane, const std::vector<Piece>& pieces) {
    int front = 0, back = 0, cut = 0;
    for (const Piece& piece : pieces) {
      const Sides sides = sidesOf(piece, plane);
      front += sides.front ? 1 : 0;
      back += sides.back ? 1 : 0;
      cut += sides.front && sides.back ? 1 : 0;
    }
    return kCostOfCut * cut + std::abs(front - back);
  }

  double tolerance_;
};

/// Diagonal of the bounding box of all pieces, metres.
double sizeOf(const std::vector<Piece>& pieces) {
  Eigen::AlignedBox3d box;
  for (const Piece& piece : pieces) {
    for (const Vector3& corner : piece.outer.corners) box.extend(corner);
  }
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

/// The normal is that of the outer corners.
Piece makePiece(const PictureGeometry& geometry, const Facet& facet) {
  const std::span<const Vector3> outer = geometry.corners(facet);
  // The sides of a part of a face count as cut.
  Piece piece{{{outer.begin(), outer.end()}, std::vector<char>(outer.size(), facet.isPart ? 1 : 0)},
              facet.colour};
  const std::vector<Vector3>& corners = piece.outer.corners;
  piece.normal = Vector3::Zero();
  for (std::size_t k = 2; k < corners.size(); ++k) {
    piece.normal += (corners[k - 1] - corners[0]).cross(corners[k] - corners[0]);
  }
  piece.normal.normalize();
  piece.offset = piece.normal.dot(corners[0]);
  return piece;
}

/// Projection of points by a camera: right and up in the picture, in heights of the picture at the
/// camera's centre.
class View {
 public:
  explicit View(const Camera& camera)
      : camera_(camera),
        forward_((camera.centre - camera.eye).normalized()),
        right_(forward_.cross(camera.up).normalized()),
        up_(right_.cross(forward_)),
        height_(heightAtCentre(camera)) {}

  Eigen::Vector2d operator()(const Vector3& point) const {
    const Vector3 seen = point - camera_.eye;
    return scaleAt(seen) * Eigen::Vector2d(right_.dot(seen), up_.dot(seen));
  }

  /// Metres at a point for a length in heights of the picture.
  double metresAt(const Vector3& point, double heights) const {
    return heights / scaleAt(point - camera_.eye);
  }

  /// Unit direction to the right of a line in the picture, outside of a polygon on its left.
  Vector3 rightOf(const Vector3& from, const Vector3& to) const {
    const Vector3 back = camera_.orthographic ? Vector3(-forward_) : Vector3(camera_.eye - from);
    return (to - from).cross(back).normalized();
  }

  /// The half-space of points x with normal . x >= offset on the inner side of a polygon's side in
  /// the picture, `margin` heights of the picture away from it. Its plane goes through the eye or
  /// along the view.
  std::pair<Vector3, double> within(const Vector3& from, const Vector3& to, const Vector3& inside,
                                    double margin) const {
    const Vector3 along = camera_.orthographic ? forward_ : Vector3(from - camera_.eye);
    Vector3 normal = along.cross(to - from);
    const double length = normal.norm();
    if (length <= 0) return {Vector3::Zero(), 0};
    normal /= normal.dot(inside - from) < 0 ? -length : length;
    const double width = margin * height_;
    if (camera_.orthographic) return {normal, normal.dot(from) + width};
    // The margin in space grows with the distance.
    normal -= width / (camera_.centre - camera_.eye).norm() * forward_;
    return {normal, normal.dot(camera_.eye)};
  }

 private:
  double scaleAt(const Vector3& seen) const {
    if (camera_.orthographic) return 1 / height_;
    return (camera_.centre - camera_.eye).norm() / (forward_.dot(seen) * height_);
  }

  const Camera& camera_;
  Vector3 forward_, right_, up_;
  double height_;
};

/// The pieces that may hide something in a part of the picture: a grid of square cells, each with
/// the pieces whose boxes overlap it.
class PictureGrid {
 public:
  using Box = Eigen::AlignedBox2d;

  PictureGrid(const std::vector<Piece>& pieces, const View& view) {
    for (const Piece& piece : pieces) {
      Box& box = boxes_.emplace_back();
      for (const Vector3& corner : piece.outer.corners) box.extend(view(corner));
      all_.extend(box);
    }
    sides_ = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(pieces.size()))));
    cells_.resize(static_cast<std::size_t>(sides_) * sides_);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      forCells(boxes_[k], [&](std::vector<std::size_t>& cell) { cell.push_back(k); });
    }
  }

  /// Ascending and unique.
  std::vector<std::size_t> near(const Box& box) {
    std::vector<std::size_t> found;
    forCells(box, [&](const std::vector<std::size_t>& cell) {
      for (const std::size_t k : cell) {
        if (boxes_[k].intersects(box)) found.push_back(k);
      }
    });
    std::ranges::sort(found);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

 private:
  template <typename Action>
  void forCells(const Box& box, const Action& action) {
    const auto cellOf = [this](const Eigen::Vector2d& point) -> Eigen::Array2i {
      const Eigen::Array2d share =
          (point - all_.min()).array() / all_.sizes().array().max(1e-300) * sides_;
      return share.max(0).min(sides_ - 1).cast<int>();
    };
    const Eigen::Array2i least = cellOf(box.min()), most = cellOf(box.max());
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) action(cells_[y * sides_ + x]);
    }
  }

  Box all_;
  int sides_ = 1;
  std::vector<Box> boxes_;
  std::vector<std::vector<std::size_t>> cells_;
};

/// A part of a line, from 0 at its first point to 1 at its last.
using Interval = std::pair<double, double>;

/// The part of a line that lies within a piece in the picture and at least `depth` metres behind
/// its plane. It is one interval, since both are convex. Empty (first not less than second) if
/// there is none.
Interval behind(const Piece& piece, const Vector3& from, const Vector3& to, const View& view,
                double depth) {
  Interval hidden(0, 1);
  const auto keepWhere = [&](const Vector3& normal, double offset) {
    const double before = normal.dot(from) - offset, after = normal.dot(to) - offset;
    if (before < 0 && after < 0) {
      hidden = {1, 0};
    } else if (before < 0) {
      hidden.first = std::max(hidden.first, before / (before - after));
    } else if (after < 0) {
      hidden.second = std::min(hidden.second, before / (before - after));
    }
  };
  keepWhere(-piece.normal, -piece.offset + depth);
  const std::vector<Vector3>& corners = piece.outer.corners;
  Vector3 middle = Vector3::Zero();
  for (const Vector3& corner : corners) middle += corner / static_cast<double>(corners.size());
  for (std::size_t k = 0; k < corners.size() && hidden.first < hidden.second; ++k) {
    const auto [normal, offset] =
        view.within(corners[k], corners[(k + 1) % corners.size()], middle, kSideMargin);
    keepWhere(normal, offset);
  }
  return hidden;
}

/// The remainder of a whole line outside the intervals; gaps are at least `least` long.
std::vector<Interval> restOf(std::vector<Interval> hidden, double least) {
  std::ranges::sort(hidden);
  std::vector<Interval> rest;
  double end = 0;
  for (const auto& [first, second] : hidden) {
    if (first > end && (end == 0 || first - end > least)) rest.emplace_back(end, first);
    end = std::max(end, second);
  }
  if (end < 1) rest.emplace_back(end, 1);
  return rest;
}

/// Intersection of two lists; each is sorted and without overlaps.
std::vector<Interval> inBoth(const std::vector<Interval>& a, const std::vector<Interval>& b) {
  std::vector<Interval> common;
  for (const Interval& first : a) {
    for (const Interval& second : b) {
      const Interval part(std::max(first.first, second.first),
                          std::min(first.second, second.second));
      if (part.first < part.second) common.push_back(part);
    }
  }
  return common;
}

/// Lines from the visible parts of the sides of a polygon, in order from one corner.
class OutlineChain {
 public:
  /// A visible part of the next side. Extends a line that ends at its start.
  void add(const Vector3& from, const Vector3& to, const Interval& part, bool isSilhouette) {
    const auto at = [&](double share) -> Vector3 {
      return share == 0 ? from : share == 1 ? to : from + share * (to - from);
    };
    const Vector3 begin = at(part.first);
    if (lines_.empty() || lines_.back().isSilhouette != isSilhouette ||
        lines_.back().points.back() != begin) {
      lines_.push_back({{begin}, isSilhouette});
    }
    lines_.back().points.push_back(at(part.second));
  }

  /// Joins the last line to the first if it ends at its start.
  std::vector<VisibleLine> finish() {
    if (lines_.size() > 1 && lines_.back().isSilhouette == lines_.front().isSilhouette &&
        lines_.back().points.back() == lines_.front().points.front()) {
      std::vector<Vector3>& points = lines_.back().points;
      points.insert(points.end(), lines_.front().points.begin() + 1, lines_.front().points.end());
      lines_.erase(lines_.begin());
    }
    return std::move(lines_);
  }

 private:
  std::vector<VisibleLine> lines_;
};

/// Finds the visible parts of the sides of faces.
class SideFinder {
 public:
  SideFinder(const std::vector<Piece>& pieces, const Camera& camera, double silhouetteWidth)
      : pieces_(pieces),
        view_(camera),
        grid_(pieces, view_),
        tolerance_(kOnPlane * sizeOf(pieces)),
        silhouetteWidth_(silhouetteWidth) {}

  /// Appends the visible parts of a side.
  void addVisible(const Vector3& from, const Vector3& to, OutlineChain& chain) {
    const std::vector<Interval> seen = visibleParts(from, to);
    if (seen.empty()) return;
    const std::vector<Interval> bare = bareParts(from, to);
    std::vector<std::pair<Interval, bool>> parts;
    for (const Interval& part : inBoth(seen, bare)) parts.emplace_back(part, true);
    for (const Interval& part : inBoth(seen, restOf(bare, 0))) parts.emplace_back(part, false);
    std::ranges::sort(parts);
    for (const auto& [part, isSilhouette] : parts) chain.add(from, to, part, isSilhouette);
  }

 private:
  std::vector<Interval> visibleParts(const Vector3& from, const Vector3& to) {
    const Eigen::Vector2d begin = view_(from), end = view_(to);
    std::vector<Interval> hidden;
    for (const std::size_t k : grid_.near(Eigen::AlignedBox2d(begin).extend(end))) {
      if (pieces_[k].colour.alpha < 255) continue;
      const Interval part = behind(pieces_[k], from, to, view_, tolerance_);
      if (part.first < part.second) hidden.push_back(part);
    }
    // The margins of two adjacent facets are visible under the line between them.
    const double least = 3 * kSideMargin / std::max((end - begin).norm(), kSideMargin);
    return restOf(std::move(hidden), least);
  }

  /// The parts without a piece on the outer side. Parts shorter than the width of a line do not
  /// count.
  std::vector<Interval> bareParts(const Vector3& from, const Vector3& to) {
    if (silhouetteWidth_ <= 0) return {};
    const double width = view_.metresAt(from, silhouetteWidth_);
    const Vector3 away = 0.5 * width * view_.rightOf(from, to);
    const Vector3 first = from + away, last = to + away;
    const Eigen::Vector2d begin = view_(first), end = view_(last);
    std::vector<Interval> covered;
    for (const std::size_t k : grid_.near(Eigen::AlignedBox2d(begin).extend(end))) {
      const Interval part = behind(pieces_[k], first, last, view_, -width);
      if (part.first < part.second) covered.push_back(part);
    }
    std::vector<Interval> bare = restOf(std::move(covered), 0);
    const double least = silhouetteWidth_ / std::max((end - begin).norm(), silhouetteWidth_);
    std::erase_if(bare, [least](const Interval& part) { return part.second - part.first < least; });
    return bare;
  }

  const std::vector<Piece>& pieces_;
  View view_;
  PictureGrid grid_;
  double tolerance_;
  double silhouetteWidth_;
};

Plane nearPlaneOf(const Camera& camera) {
  const Vector3 forward = (camera.centre - camera.eye).normalized();
  return {forward, forward.dot(camera.eye) + camera.near, 0};
}

}  // namespace

std::vector<Piece> makePieces(const PictureGeometry& geometry, const std::vector<Facet>& facets,
                              const Camera& camera) {
  const Plane nearPlane = nearPlaneOf(camera);
  std::vector<Piece> pieces;
  for (const Facet& facet : facets) {
    Piece piece = makePiece(geometry, facet);
    if (sidesOf(piece, nearPlane).back) piece = frontPart(piece, nearPlane);
    if (!piece.outer.corners.empty()) pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::vector<Piece> drawnPieces(const PictureGeometry& geometry, const Camera& camera) {
  std::vector<Piece> pieces = makePieces(geometry, geometry.solid, camera);
  std::ranges::move(makePieces(geometry, geometry.translucent, camera), std::back_inserter(pieces));
  return pieces;
}

std::vector<VisibleOutline> visibleOutlines(const PictureGeometry& geometry,
                                            const std::vector<Piece>& pieces, const Camera& camera,
                                            double silhouetteWidth) {
  const Plane nearPlane = nearPlaneOf(camera);
  SideFinder finder(pieces, camera, silhouetteWidth);
  std::vector<VisibleOutline> outlines;
  for (const FaceOutline& outline : geometry.outlines) {
    checkInterruption();
    OutlineChain chain;
    for (int k = 0; k < outline.count; ++k) {
      Vector3 from = geometry.points[outline.first + k];
      Vector3 to = geometry.points[outline.first + (k + 1) % outline.count];
      const double before = nearPlane.distance(from), after = nearPlane.distance(to);
      if (before <= 0 && after <= 0) continue;
      const Vector3 cut = from + before / (before - after) * (to - from);
      if (before < 0) from = cut;
      if (after < 0) to = cut;
      finder.addVisible(from, to, chain);
    }
    outlines.push_back({chain.finish(), outline.opacity});
  }
  return outlines;
}

std::vector<Piece> farthestFirst(std::vector<Piece> pieces) {
  if (pieces.empty()) return {};
  Sorter sorter(kOnPlane * sizeOf(pieces));
  sorter.sort(std::move(pieces));
  return std::move(sorter.sorted);
}

}  // namespace kirireel::picture
