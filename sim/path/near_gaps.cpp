// The gap of two convex pieces is their largest separation over all planes of faces and of pairs of
// edges (sim/contacts/contact_finder.h). Let n be the unit normal of that plane, from B to A, and c
// a point on it. As a point of brick A, c moves by dx_a + dphi_a x (c - x_a), as a point of B by
// dx_b + dphi_b x (c - x_b). Thus
//   dgap = n . dx_a + ((c - x_a) x n) . dphi_a - n . dx_b - ((c - x_b) x n) . dphi_b.
// For two edges, c is the middle of the nearest points of their lines. n is parallel to the line
// between these points, and its own change has no effect. For a face and points, c is each point.
#include "sim/path/near_gaps.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace kirireel::path {
namespace {

using contacts::Outline;
using contacts::PlacedOutline;
using contacts::SeparatingPlane;

// Planes separate bricks equally well up to this fraction of their radii.
constexpr double kEqualPlanes = 1e-9;

/// The point with the smallest product with `direction`.
const Vector3& lowestPoint(const PlacedOutline& placed, const Vector3& direction) {
  return *std::ranges::min_element(placed.points, {},
                                   [&](const Vector3& point) { return point.dot(direction); });
}

}  // namespace

NearGapFinder::NearGapFinder(const std::vector<brick::Brick>& bricks,
                             std::span<const brick::Pivot> pivots, scene::ContactFilter contacts,
                             double pivotZone, bool planar, const Poses& start)
    : planar_(planar) {
  const auto joined = brick::sharedCorners(pivots);
  const int count = static_cast<int>(bricks.size());
  std::vector<std::vector<brick::BrickPiece>> pieces;
  std::vector<std::vector<std::size_t>> whole;
  for (int brick = 0; brick < count; ++brick) {
    radii_.push_back(contacts::outerRadius(bricks[brick]));
    pieces.push_back(brick::convexPieces(bricks[brick], brick));
    whole.push_back(addPieces(pieces.back(), brick, {}, 0));
  }
  for (int a = 0; a < count; ++a) {
    for (int b = a + 1; b < count; ++b) {
      const auto corners = joined.find({a, b});
      if (corners == joined.end()) {
        addPair(a, b, whole[a], whole[b]);
      } else if (contacts == scene::ContactFilter::All && !corners->second.areOneTile) {
        const double length = brick::cutLength(bricks[a], bricks[b], pivotZone);
        addPair(a, b, addPieces(pieces[a], a, corners->second.ofA, length),
                addPieces(pieces[b], b, corners->second.ofB, length));
      }
    }
  }
  ++state_;
  for (NearBrickPair& ofBricks : pairs_) {
    for (PiecePair& pair : ofBricks.pieces) {
      pair.kept = std::max(0.0, -separate(pair, 0, start));
    }
  }
}

std::vector<std::size_t> NearGapFinder::addPieces(const std::vector<brick::BrickPiece>& pieces,
                                                  int brick, const std::vector<int>& withoutCorners,
                                                  double length) {
  std::vector<std::size_t> added;
  for (const brick::BrickPiece& shape : pieces) {
    added.push_back(pieces_.size());
    PlacedPiece& piece = pieces_.emplace_back();
    piece.brick = brick;
    piece.outline = contacts::makeOutline(
        length > 0 ? brick::withoutCorners(shape, withoutCorners, length) : shape.shape, planar_);
    piece.centre = meanPoint(piece.outline.points);
    for (const Vector3& point : piece.outline.points) {
      piece.radius = std::max(piece.radius, (point - piece.centre).norm());
    }
  }
  return added;
}

void NearGapFinder::addPair(int a, int b, const std::vector<std::size_t>& piecesA,
                            const std::vector<std::size_t>& piecesB) {
  NearBrickPair& added = pairs_.emplace_back(NearBrickPair{a, b, {}});
  for (const std::size_t ofA : piecesA) {
    for (const std::size_t ofB : piecesB) {
      PiecePair& pair = added.pieces.emplace_back(PiecePair{ofA, ofB});
      // Planes are indices of faces and edges: pieces with equal counts have the same list.
      const Outline &x = pieces_[ofA].outline, &y = pieces_[ofB].outline;
      const auto [list, isNew] = planeLists_.try_emplace(
          {x.normals.size(), x.directions.size(), y.normals.size(), y.directions.size()});
      if (isNew) list->second = contacts::separatingPlanes(x, y);
      pair.planes = &list->second;
    }
  }
}

/// The outline of a piece in the current state.
const PlacedOutline& NearGapFinder::place(std::size_t piece, const Poses& poses) {
  PlacedPiece& found = pieces_[piece];
  if (found.state != state_) {
    contacts::placeOutline(found.outline, poses[found.brick], found.placed);
    found.state = state_;
  }
  return found.placed;
}

/// The largest separation of a pair, metres. Stores its plane in `known`, the first of equally good
/// planes. If a lower bound of it is at least the margin, returns this bound.
double NearGapFinder::separate(PiecePair& pair, double margin, const Poses& poses) {
  const PlacedPiece &a = pieces_[pair.a], &b = pieces_[pair.b];
  const double apart = (poses[a.brick].apply(a.centre) - poses[b.brick].apply(b.centre)).norm() -
                       a.radius - b.radius;
  if (apart >= margin) return apart;
  const PlacedOutline &placedA = place(pair.a, poses), &placedB = place(pair.b, poses);
  const auto along = [&](std::size_t plane) {
    return contacts::separation((*pair.planes)[plane], placedA, placedB);
  };
  if (const double known = along(pair.known); known >= margin) return known;
  const double tie = kEqualPlanes * (radii_[a.brick] + radii_[b.brick]);
  double best = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < pair.planes->size(); ++k) {
    const double distance = along(k);
    if (!(distance > best + tie)) continue;
    if (!contacts::isSteady((*pair.planes)[k], placedA, placedB)) continue;
    best = distance;
    pair.known = k;
    if (best >= margin) return best;
  }
  return best;
}

bool NearGapFinder::areNear(const NearBrickPair& pair, double margin, const Poses& poses) const {
  const double near = radii_[pair.a] + radii_[pair.b] + margin;
  return (poses[pair.a].position - poses[pair.b].position).squaredNorm() < near * near;
}

std::vector<NearGap> NearGapFinder::find(const Poses& poses, double margin, double reach) {
  std::vector<NearGap> gaps;
  ++state_;
  for (NearBrickPair& ofBricks : pairs_) {
    if (!areNear(ofBricks, margin, poses)) continue;
    for (PiecePair& pair : ofBricks.pieces) {
      const double distance = separate(pair, margin, poses);
      if (distance < margin) append(pair, distance, reach, poses, gaps);
    }
  }
  return gaps;
}

std::vector<NearGap> NearGapFinder::findBetween(const std::array<Poses, 2>& ends,
                                                const Poses& poses, double margin, double reach) {
  for (std::size_t end = 0; end < ends.size(); ++end) {
    ++state_;
    for (NearBrickPair& ofBricks : pairs_) {
      const bool mayBeNear = areNear(ofBricks, margin, ends[end]);
      for (PiecePair& pair : ofBricks.pieces) {
        const bool isNear = mayBeNear && separate(pair, margin, ends[end]) < margin;
        pair.ofEnds[end] = isNear ? std::optional(pair.known) : std::nullopt;
      }
    }
  }
  std::vector<NearGap> gaps;
  ++state_;
  for (NearBrickPair& ofBricks : pairs_) {
    for (PiecePair& pair : ofBricks.pieces) {
      if (pair.ofEnds[1] == pair.ofEnds[0]) pair.ofEnds[1].reset();
      for (const auto& plane : pair.ofEnds) {
        if (!plane) continue;
        const PlacedOutline &placedA = place(pair.a, poses), &placedB = place(pair.b, poses);
        pair.known = *plane;
        const double distance = contacts::separation((*pair.planes)[*plane], placedA, placedB);
        if (distance < margin && contacts::isSteady((*pair.planes)[*plane], placedA, placedB)) {
          append(pair, distance, reach, poses, gaps);
        }
      }
    }
  }
  return gaps;
}

void NearGapFinder::append(const PiecePair& pair, double distance, double reach, const Poses& poses,
                           std::vector<NearGap>& gaps) const {
  const SeparatingPlane& plane = (*pair.planes)[pair.known];
  const int brickA = pieces_[pair.a].brick, brickB = pieces_[pair.b].brick;
  const PlacedOutline &placedA = pieces_[pair.a].placed, &placedB = pieces_[pair.b].placed;
  const Vector3 normal = contacts::planeNormal(plane, placedA, placedB);
  const auto add = [&](const Vector3& point, double gap) {
    NearGap& added = gaps.emplace_back();
    added.brickA = brickA;
    added.brickB = brickB;
    added.gap = gap + pair.kept;
    added.ofA << normal, (point - poses[brickA].position).cross(normal);
    added.ofB << -normal, -(point - poses[brickB].position).cross(normal);
  };
  if (plane.kind == SeparatingPlane::Kind::Edges) {
    const Vector3& pointA = lowestPoint(placedA, normal);
    const Vector3& pointB = lowestPoint(placedB, -normal);
    const Vector3 &a = placedA.directions[plane.a], &b = placedB.directions[plane.b];
    const auto [onA, onB] = nearestOnLines(pointA, a, pointB, b);
    add(0.5 * (pointA + onA * a + pointB + onB * b), distance);
    return;
  }
  const bool isOfA = plane.kind == SeparatingPlane::Kind::FaceOfA;
  const PlacedOutline& faces = isOfA ? placedA : placedB;
  const PlacedOutline& points = isOfA ? placedB : placedA;
  const Vector3 outward = isOfA ? Vector3(-normal) : normal;
  const int face = isOfA ? plane.a : plane.b;
  const double level = outward.dot(faces.points[faces.outline->facePoints[face]]);
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3& point : points.points) least = std::min(least, outward.dot(point));
  for (const Vector3& point : points.points) {
    if (outward.dot(point) <= least + reach) add(point, outward.dot(point) - level);
  }
}

}  // namespace kirireel::path
