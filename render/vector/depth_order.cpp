#include "render/vector/depth_order.h"

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "sim/base/interruption.h"

namespace kirireel {
namespace {

/// Points nearer to a plane than this part of the model count as on it.
constexpr double kOnPlane = 1e-7;

/// Planes that are tried at each cut.
constexpr std::size_t kCandidates = 12;

/// One cut polygon more costs as much as this many polygons of imbalance.
constexpr int kCostOfCut = 8;

struct Plane {
  Vector3 normal;
  double offset;
  double tolerance;

  double distance(const Vector3& point) const { return normal.dot(point) - offset; }
};

/// The part of a polygon in front of the plane. A side along the plane is marked as cut.
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
    // What follows the point where the polygon leaves the front is the cut.
    add(from + before / (before - after) * (to - from), before >= 0 || isCut);
  }
  if (part.corners.size() < 3) return {};
  return part;
}

Piece frontPart(const Piece& piece, const Plane& plane) {
  Piece part = piece;
  part.outer = frontPart(piece.outer, plane);
  part.inner = frontPart(piece.inner, plane);
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

/// Recursion over ever smaller parts of space.
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
      // Tiles need not be exactly flat: the splitter is on its own plane by definition, so that
      // every step takes one piece away.
      const Sides sides = k == splitter ? Sides{} : sidesOf(piece, plane);
      if (sides.front && sides.back) {
        keep(frontPart(piece, {-plane.normal, -plane.offset, plane.tolerance}), back);
        keep(frontPart(piece, plane), front);
      } else {
        (sides.front ? front : sides.back ? back : on).push_back(std::move(piece));
      }
    }
    pieces = {};  // gives the memory back before going deeper
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

CutPolygon uncut(std::span<const Vector3> corners) {
  return {{corners.begin(), corners.end()}, std::vector<char>(corners.size(), 0)};
}

Piece makePiece(const Sketch& sketch, const Facet& facet) {
  Piece piece{uncut(sketch.corners(facet)), uncut(sketch.inner(facet)), facet.outlined, facet.pale,
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

}  // namespace

std::vector<Piece> makePieces(const Sketch& sketch, const std::vector<Facet>& facets,
                              const Camera& camera) {
  const Vector3 forward = (camera.centre - camera.eye).normalized();
  const Plane nearPlane{forward, forward.dot(camera.eye) + camera.near, 0};
  std::vector<Piece> pieces;
  for (const Facet& facet : facets) {
    Piece piece = makePiece(sketch, facet);
    if (sidesOf(piece, nearPlane).back) piece = frontPart(piece, nearPlane);
    if (!piece.outer.corners.empty()) pieces.push_back(std::move(piece));
  }
  return pieces;
}

std::vector<Piece> farthestFirst(std::vector<Piece> pieces) {
  Eigen::AlignedBox3d box;
  for (const Piece& piece : pieces) {
    for (const Vector3& corner : piece.outer.corners) box.extend(corner);
  }
  if (box.isEmpty()) return {};
  Sorter sorter(kOnPlane * box.diagonal().norm());
  sorter.sort(std::move(pieces));
  return std::move(sorter.sorted);
}

}  // namespace kirireel
