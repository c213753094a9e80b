// Overlaps and shapes of tiles without thickness.
//
// Flat neighbours (planes parallel to 1e-6 and at one height) are compared in their plane by
// separating axes, perpendicular to the edges of both. Tiles in different planes intersect if the
// line of intersection of their planes passes through both. Their depth is the smallest of five
// lengths: how far each tile extends on either side of the other's plane, and the common length of
// their cuts on that line. Concave tiles are compared part by part. Pairs come from a sweep along
// x.
#include "sim/trajectory/sheet.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "sim/base/interruption.h"
#include "sim/model/convex_parts.h"
#include "sim/model/sheet_frame.h"
#include "sim/trajectory/measures.h"

namespace kirireel::trajectory {
namespace {

// If the normals of two planes differ by less than this sine, they count as one plane.
constexpr double kParallelPlanes = 1e-6;

/// A tile, or a convex part of one, with the data for the tests of a pair.
struct PlacedTile {
  int tile = 0;
  std::vector<Vector3> vertices;
  Vector3 normal;
  Eigen::AlignedBox3d box;
};

/// An interval along a line.
struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void extend(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// The smallest move that separates two intervals; negative if they are separated.
double overlap(const Interval& a, const Interval& b) {
  return std::min(a.high - b.low, b.high - a.low);
}

// Projections of the vertices on an axis from an origin. The origin is at the tile: this keeps all
// digits far from the world's origin.
Interval project(const PlacedTile& tile, const Vector3& axis, const Vector3& origin) {
  Interval interval;
  for (const Vector3& vertex : tile.vertices) interval.extend(axis.dot(vertex - origin));
  return interval;
}

/// The smallest overlap over the directions perpendicular to the edges of both (separating axes).
double depthInPlane(const PlacedTile& a, const PlacedTile& b) {
  double depth = std::numeric_limits<double>::infinity();
  for (const PlacedTile* tile : {&a, &b}) {
    const std::vector<Vector3>& vertices = tile->vertices;
    for (std::size_t k = 0; k < vertices.size(); ++k) {
      const Vector3 edge = vertices[(k + 1) % vertices.size()] - vertices[k];
      const Vector3 across = edge.cross(tile->normal).normalized();
      depth = std::min(depth,
                       overlap(project(a, across, vertices[k]), project(b, across, vertices[k])));
    }
  }
  return depth;
}

/// The part of the line origin + t direction that lies in the tile. The line lies in the tile's
/// plane.
Interval cut(const PlacedTile& tile, const Vector3& planeNormal, const Vector3& origin,
             const Vector3& direction) {
  Interval interval;
  const std::vector<Vector3>& vertices = tile.vertices;
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    const Vector3& from = vertices[k];
    const Vector3& to = vertices[(k + 1) % vertices.size()];
    const double before = planeNormal.dot(from - origin);
    const double after = planeNormal.dot(to - origin);
    // The edge does not cross the plane. A corner exactly on it counts to one side only.
    if ((before < 0) == (after < 0)) continue;
    const Vector3 crossing = from + before / (before - after) * (to - from);
    interval.extend(direction.dot(crossing - origin));
  }
  return interval;
}

/// How far tiles in different planes pass through each other: the smallest of the lengths on either
/// side of the other's plane and of the length that their cuts share.
double depthAcross(const PlacedTile& a, const PlacedTile& b) {
  const Vector3 direction = a.normal.cross(b.normal).normalized();
  const Vector3& pointA = a.vertices.front();
  const Vector3& pointB = b.vertices.front();
  // A point of both planes, nearest to the first tile's. inA is the direction in A's plane
  // perpendicular to the common line.
  const Vector3 inA = direction.cross(a.normal);
  const Vector3 origin = pointA + b.normal.dot(pointB - pointA) / b.normal.dot(inA) * inA;
  const Interval aboutB = project(a, b.normal, pointB);
  const Interval aboutA = project(b, a.normal, pointA);
  const double shared =
      overlap(cut(a, b.normal, origin, direction), cut(b, a.normal, origin, direction));
  return std::min({shared, aboutB.high, -aboutB.low, aboutA.high, -aboutA.low});
}

// The depth of two convex tiles, metres; <= 0 if they do not overlap. `tolerance`: smaller
// differences in height do not count.
double depthOf(const PlacedTile& a, const PlacedTile& b, double tolerance) {
  if (a.normal.cross(b.normal).norm() > kParallelPlanes) return depthAcross(a, b);
  const Vector3& origin = a.vertices.front();
  const Interval height = project(b, a.normal, origin);
  // Parallel planes at different heights.
  if (height.low > tolerance || height.high < -tolerance) return 0;
  return depthInPlane(a, b);
}

std::vector<PlacedTile> convexPartsOf(const std::vector<model::Tile>& tiles) {
  std::vector<PlacedTile> placed;
  for (int i = 0; i < std::ssize(tiles); ++i) {
    const std::vector<Vector3>& vertices = tiles[std::size_t(i)].vertices;
    const Vector3 normal = model::tileNormal(tiles[std::size_t(i)]);
    for (const model::PolygonPart& part : model::convexParts(vertices, normal)) {
      PlacedTile& entry = placed.emplace_back(PlacedTile{i, {}, normal, {}});
      for (const int corner : part) {
        entry.vertices.push_back(vertices[std::size_t(corner)]);
        entry.box.extend(entry.vertices.back());
      }
    }
  }
  return placed;
}

}  // namespace

// Sweep along x, then each pair's depth.
std::vector<TileOverlap> tileOverlaps(const std::vector<model::Tile>& tiles, double tolerance) {
  const std::vector<PlacedTile> placed = convexPartsOf(tiles);
  // In the order of their left sides, a tile can only meet those that start before it ends.
  std::vector<int> order(placed.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return placed[std::size_t(a)].box.min().x() < placed[std::size_t(b)].box.min().x();
  });
  std::map<std::pair<int, int>, double> depths;  // the deepest pair of parts
  long left = maxPairs(tiles.size());
  for (std::size_t i = 0; i < order.size() && left > 0; ++i) {
    const PlacedTile& first = placed[std::size_t(order[i])];
    for (std::size_t j = i + 1; j < order.size() && left > 0; ++j) {
      const PlacedTile& second = placed[std::size_t(order[j])];
      if (second.box.min().x() > first.box.max().x() + tolerance) break;
      if (first.tile == second.tile) continue;
      if (first.box.exteriorDistance(second.box) > tolerance) continue;
      --left;
      const double depth = depthOf(first, second, tolerance);
      if (depth <= tolerance) continue;
      double& deepest = depths[std::minmax(first.tile, second.tile)];
      deepest = std::max(deepest, depth);
    }
  }
  std::vector<TileOverlap> found;
  for (const auto& [pair, depth] : depths) found.push_back({pair.first, pair.second, depth});
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.depth > b.depth; });
  return found;
}

double largestShapeChange(const std::vector<model::Tile>& start,
                          const std::vector<model::Tile>& target) {
  double largest = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const std::vector<Vector3>& before = start[i].vertices;
    const std::vector<Vector3>& after = target[i].vertices;
    for (std::size_t b = 0; b < before.size(); ++b) {
      for (std::size_t a = 0; a < b; ++a) {
        const double change = (after[a] - after[b]).norm() - (before[a] - before[b]).norm();
        largest = std::max(largest, std::abs(change));
      }
    }
  }
  return largest;
}

double largestUnevenness(const std::vector<model::Tile>& tiles) {
  double largest = 0;
  for (const model::Tile& tile : tiles) {
    const Vector3 normal = model::tileNormal(tile);
    Vector3 middle = Vector3::Zero();
    for (const Vector3& vertex : tile.vertices) middle += vertex;
    middle /= static_cast<double>(tile.vertices.size());
    for (const Vector3& vertex : tile.vertices) {
      largest = std::max(largest, std::abs(normal.dot(vertex - middle)));
    }
  }
  return largest;
}

double smallestCornerSine(const std::vector<model::Tile>& tiles) {
  double least = 1;
  for (const model::Tile& tile : tiles) {
    const Vector3 normal = model::tileNormal(tile);
    const std::size_t count = tile.vertices.size();
    for (std::size_t k = 0; k < count; ++k) {
      const Vector3 before = tile.vertices[k] - tile.vertices[(k + count - 1) % count];
      const Vector3 after = tile.vertices[(k + 1) % count] - tile.vertices[k];
      least = std::min(least, before.normalized().cross(after.normalized()).dot(normal));
    }
  }
  return least;
}

// ------------------------------------------------------------------------------------------------
// First-order mobility from the rank of the joints' Jacobian J (equations x unknowns).
//
// The unknowns are the velocity v and the angular velocity w of each tile. w is multiplied by the
// mean edge s, which makes all columns of J plain numbers. A joint at the points a and b gives the
// equation
//   d . (v_A + w_A x (a - c_A)) - d . (v_B + w_B x (b - c_B)) = 0
// for each direction d that it holds, with c the centroids. A pivot holds 3 directions (2 in the
// plane), a link the one along itself, a fixed joint 3 and the relative rotation. Then
//   freedoms  = unknowns - rank J - 6        (3 in the plane: motions of the whole)
//   redundant = equations - rank J
// This is the count of J. C. Maxwell with states of self-stress (C. R. Calladine, Buckminster
// Fuller's tensegrity structures and Clerk Maxwell's rules for the construction of stiff frames,
// Int. J. Solids Struct. 14, 1978). It holds to first order: a freedom may be infinitesimal,
// without a finite motion, as in the closed state of these sheets.
//
// A hinge holds the two pivots at the bottom and at the top of its edge. The equations of the top
// are those of its motion relative to the bottom, in units of the thickness t:
//   d . (w_A x n_A - w_B x n_B) = 0
// so singular values do not depend on t.
//
// Tiles of a rounded or optimised design fit each other only to a misfit e. Redundant equations
// then have singular values of about e, in tiles, instead of zero, and the design would count as
// locked. The rank is therefore counted at the highest gap of the spectrum whose lower side is a
// possible misfit: a factor of kGap without a singular value.
//
// Small sheets use a dense singular value decomposition. For large ones, the number of eigenvalues
// of J^T J below s^2 is the number of negative pivots of J^T J - s^2 1 = L D L^T (Sylvester's law
// of inertia). This costs a sparse factorisation per s and gives the singular values to within a
// power of ten.

namespace {

using Sparse = Eigen::SparseMatrix<double>;

// Singular values above this fraction of the largest count. Observed zeros: 1e-15; smallest others:
// 1e-2 (tess_m10_n10, open).
constexpr double kCounts = 1e-6;
// A gap in the spectrum. Measured with misfits of 1e-9 to 1e-5 tiles: 2e4 and more.
constexpr double kGap = 30;
// A dense decomposition costs O(n^3).
constexpr int kMaxDenseUnknowns = 900;
constexpr int kMaxUnknowns = 60'000;

/// Writes the equations of joints one by one.
class JointJacobian {
 public:
  JointJacobian(const model::Model& model, const std::vector<model::Tile>& state, Freedom freedom,
                double thickness)
      : state_(state), planar_(freedom == Freedom::Plane), size_(model::tileSize(model)) {
    for (const model::Tile& tile : state) {
      centres_.push_back(model::tileCentroid(tile));
      normals_.push_back(model::tileNormal(tile));
      rises_.push_back(thickness * normals_.back());
    }
    for (const model::Joint& joint : model.joints) addJoint(joint);
  }

  int unknowns() const { return (planar_ ? 3 : 6) * static_cast<int>(state_.size()); }

  Sparse matrix() const {
    Sparse matrix(rows_, unknowns());
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    return matrix;
  }

 private:
  Vector3 place(const model::Corner& corner, bool top) const {
    const Vector3& bottom = state_[corner.tile].vertices[corner.vertex];
    return top ? Vector3(bottom + rises_[corner.tile]) : bottom;
  }

  // The rows of one joint, by its kind and face.
  void addJoint(const model::Joint& joint) {
    if (joint.kind == model::JointKind::Link) {
      // The distance of two points changes only by motion along their connection.
      const Vector3 along = (place(joint.a, false) - place(joint.b, false)).normalized();
      addDirection(joint, place(joint.a, false), place(joint.b, false), along);
      return;
    }
    if (joint.kind == model::JointKind::Fixed) return addFixed(joint);
    addPivot(joint, joint.face == model::JointFace::Top);
    // In the plane the upper pivot of a hinge is redundant.
    if (joint.face == model::JointFace::Both && !planar_) addHinge(joint);
  }

  // One row for each axis.
  void addPivot(const model::Joint& joint, bool top) {
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      addDirection(joint, place(joint.a, top), place(joint.b, top), Vector3::Unit(axis));
    }
  }

  /// The motion of the top relative to the bottom: d . (w_A x n_A - w_B x n_B) = 0.
  void addHinge(const model::Joint& joint) {
    for (int axis = 0; axis < 3; ++axis) {
      addRotation(joint.a.tile, normals_[joint.a.tile].cross(Vector3::Unit(axis)));
      addRotation(joint.b.tile, -normals_[joint.b.tile].cross(Vector3::Unit(axis)));
      ++rows_;
    }
  }

  /// The relative motion of the two tiles at one point, and their relative rotation.
  void addFixed(const model::Joint& joint) {
    const Vector3 point = place(joint.a, false);
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      addDirection(joint, point, point, Vector3::Unit(axis));
    }
    for (int axis = planar_ ? 2 : 0; axis < 3; ++axis) {
      addRotation(joint.a.tile, Vector3::Unit(axis));
      addRotation(joint.b.tile, -Vector3::Unit(axis));
      ++rows_;
    }
  }

  /// direction . (velocity of point a - velocity of point b) = 0.
  void addDirection(const model::Joint& joint, const Vector3& a, const Vector3& b,
                    const Vector3& direction) {
    addPoint(joint.a.tile, a, direction);
    addPoint(joint.b.tile, b, -direction);
    ++rows_;
  }

  void addPoint(int tile, const Vector3& point, const Vector3& direction) {
    const int first = (planar_ ? 3 : 6) * tile;
    for (int axis = 0; axis < (planar_ ? 2 : 3); ++axis) {
      entries_.emplace_back(rows_, first + axis, direction[axis]);
    }
    // d . (w x r) = w . (r x d), and w is measured in 1/s times the tile's size.
    addRotation(tile, (point - centres_[tile]).cross(direction) / size_);
  }

  void addRotation(int tile, const Vector3& moment) {
    const int first = (planar_ ? 3 : 6) * tile;
    if (planar_) {
      entries_.emplace_back(rows_, first + 2, moment.z());
      return;
    }
    for (int axis = 0; axis < 3; ++axis)
      entries_.emplace_back(rows_, first + 3 + axis, moment[axis]);
  }

  const std::vector<model::Tile>& state_;
  bool planar_;
  double size_;
  std::vector<Vector3> centres_;
  std::vector<Vector3> normals_;
  std::vector<Vector3> rises_;
  int rows_ = 0;
  std::vector<Eigen::Triplet<double>> entries_;
};

/// `floor`: upper limit of singular values that are zero except for rounding.
void countDense(const Sparse& jacobian, double floor, Mobility& result) {
  const Eigen::VectorXd values = singularValuesOf(Eigen::MatrixXd(jacobian));  // falling
  floor = std::max(floor, kCounts * values[0]);
  while (result.rank < values.size() && values[result.rank] > floor) {
    const bool mayBeMisfit = result.rank > 0 && values[result.rank] <= model::kMaxMisfit;
    if (mayBeMisfit && values[result.rank - 1] > kGap * values[result.rank]) break;
    ++result.rank;
  }
  result.smallestKept = result.rank > 0 ? values[result.rank - 1] : 0;
  result.largestDropped = result.rank < values.size() ? values[result.rank] : 0;
}

/// Counts the eigenvalues of J^T J below a square, by the signs of the pivots of J^T J - s^2.
class SignCounter {
 public:
  explicit SignCounter(const Sparse& square)
      : square_(square), identity_(square.rows(), square.cols()) {
    identity_.setIdentity();
    // A complete diagonal keeps the pattern: one ordering is enough for all counts.
    factors_.analyzePattern(Sparse(square_ + identity_));
  }

  int below(double value) {
    checkInterruption();
    factors_.factorize(Sparse(square_ - value * value * identity_));
    return static_cast<int>((factors_.vectorD().array() < 0).count());
  }

 private:
  const Sparse& square_;
  Sparse identity_;
  Eigen::SimplicialLDLT<Sparse> factors_;
};

// Uses the signs of pivots, which bound singular values by powers of ten.
void countSparse(const Sparse& jacobian, double floor, Mobility& result) {
  const Sparse square = jacobian.transpose() * jacobian;
  // Gershgorin's circles: no eigenvalue is larger than the largest sum of absolute values in a row.
  double bound = 0;
  for (Eigen::Index column = 0; column < square.outerSize(); ++column) {
    double sum = 0;
    for (Sparse::InnerIterator entry(square, column); entry; ++entry)
      sum += std::abs(entry.value());
    bound = std::max(bound, sum);
  }
  SignCounter counter(square);
  double threshold = std::max(floor, kCounts * std::sqrt(bound));
  int dropped = counter.below(threshold);
  for (double misfit = model::kMaxMisfit; misfit > threshold; misfit /= 10) {
    const int below = counter.below(misfit);
    if (counter.below(kGap * misfit) > below) continue;
    if (below > dropped) threshold = misfit;
    dropped = below;
    break;
  }
  result.areBounds = true;
  result.rank = result.unknowns - dropped;
  result.largestDropped = dropped > 0 ? threshold : 0;
  // The next power of ten with more values below it.
  for (double value = threshold; value < std::sqrt(bound); value *= 10) {
    if (counter.below(value) > dropped) break;
    result.smallestKept = value;
  }
}

}  // namespace

double zeroSingularValue(const model::Model& model) {
  // A row's entries change by about one digit over a tile, and a sheet has more than one row.
  constexpr double kDigits = 10;
  return model.rounding > 0 ? kDigits * model.rounding / model::tileSize(model) : 0;
}

Mobility mobility(const model::Model& model, const std::vector<model::Tile>& state, Freedom freedom,
                  double thickness) {
  // In the plane the equations are those of x, y and rotations about z in the sheet's own axes.
  const std::optional<model::SheetFrame> frame =
      freedom == Freedom::Plane ? model::sheetFrame(state, model::flatTolerance(model))
                                : std::nullopt;
  const std::vector<model::Tile> tiles = frame ? model::toFrame(*frame, state) : state;
  const JointJacobian equations(model, tiles, freedom, thickness);
  const Sparse jacobian = equations.matrix();
  Mobility result;
  result.unknowns = equations.unknowns();
  result.equations = static_cast<int>(jacobian.rows());
  result.isCounted = result.equations == 0 || result.unknowns <= kMaxUnknowns;
  if (!result.isCounted) return result;
  if (result.equations > 0) {
    const double floor = zeroSingularValue(model);
    result.unknowns <= kMaxDenseUnknowns ? countDense(jacobian, floor, result)
                                         : countSparse(jacobian, floor, result);
  }
  result.freedoms = result.unknowns - result.rank - (freedom == Freedom::Plane ? 3 : 6);
  result.redundant = result.equations - result.rank;
  return result;
}

}  // namespace kirireel::trajectory
