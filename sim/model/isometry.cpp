// Least-squares rigid fit of one point set to another.
//
// The fit minimises over rotations R and translations t
//   E(R, t) = sum over i of w_i |R a_i + t - b_i|^2
// for points a_i (from) and b_i (to), in metres, and dimensionless weights w_i. For any R the best
// t maps the weighted mean of the a_i to that of the b_i. It remains to maximise trace(R C) with
//   C = sum over i of w_i (a_i - mean a)(b_i - mean b)^T          3 x 3, m^2
// In space: C = U S V^T (singular values) gives R = V diag(1, 1, d) U^T. d = det(V U^T) = +-1 makes
// R a rotation, never a reflection. Coplanar points have a singular value 0, so d costs nothing
// there. Collinear points leave the rotation about their line undetermined. In the plane:
// trace(R C) = cos(p) (C_xx + C_yy) + sin(p) (C_xy - C_yx), so the angle is
// p = atan2(C_xy - C_yx, C_xx + C_yy).
//
// W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Crystallographica
// A32, 1976.
#include "sim/model/isometry.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "sim/base/interruption.h"
#include "sim/model/sheet_frame.h"

namespace kirireel::model {
namespace {

// The weighted mean. The sum of the weights is not zero.
Vector3 meanOf(std::span<const Vector3> points, std::span<const double> weights) {
  Vector3 sum = Vector3::Zero();
  double total = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += weights[i] * points[i];
    total += weights[i];
  }
  return sum / total;
}

/// Two point sets with their weighted means, and the sum of weight (from - mean) (to - mean)^T.
struct Comparison {
  Vector3 fromMean;
  Vector3 toMean;
  Matrix3 covariance = Matrix3::Zero();

  Comparison(std::span<const Vector3> from, std::span<const Vector3> to,
             std::span<const double> weights)
      : fromMean(meanOf(from, weights)), toMean(meanOf(to, weights)) {
    for (std::size_t i = 0; i < from.size(); ++i) {
      covariance += weights[i] * (from[i] - fromMean) * (to[i] - toMean).transpose();
    }
  }

  /// The motion with this rotation that maps mean to mean.
  RigidMotion withRotation(const Matrix3& rotation) const {
    return {rotation, toMean - rotation * fromMean};
  }
};

std::vector<double> evenWeights(std::size_t count) {
  return std::vector<double>(count, 1.0);
}

/// The best rotation about the normal of a sheet. For sets in parallel planes the best spatial
/// motion can turn the sheet over, which is impossible in the plane.
RigidMotion bestPlanarMotion(const SheetFrame& frame, std::span<const Vector3> from,
                             std::span<const Vector3> to) {
  const Comparison sets(from, to, evenWeights(from.size()));
  const Matrix3& covariance = sets.covariance;
  const auto entry = [&](const Vector3& a, const Vector3& b) { return a.dot(covariance * b); };
  const double angle = std::atan2(entry(frame.x, frame.y) - entry(frame.y, frame.x),
                                  entry(frame.x, frame.x) + entry(frame.y, frame.y));
  return sets.withRotation(Eigen::AngleAxisd(angle, frame.normal).toRotationMatrix());
}

std::vector<Vector3> verticesOf(const std::vector<Tile>& tiles, std::span<const int> chosen) {
  std::vector<Vector3> points;
  for (const int i : chosen) {
    const std::vector<Vector3>& vertices = tiles[static_cast<std::size_t>(i)].vertices;
    points.insert(points.end(), vertices.begin(), vertices.end());
  }
  return points;
}

}  // namespace

std::vector<Vector3> allVertices(const std::vector<Tile>& tiles) {
  std::vector<Vector3> points;
  for (const Tile& tile : tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return points;
}

RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to,
                            std::span<const double> weights) {
  // Kabsch 1976: with covariance = U S V^T the rotation is V diag(1, 1, +-1) U^T; the sign, on the
  // weakest axis, rules out a reflection.
  const Comparison sets(from, to, weights);
  const Eigen::JacobiSVD<Matrix3> svd(sets.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3 signs = Vector3::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1;
  return sets.withRotation(svd.matrixV() * signs.asDiagonal() * svd.matrixU().transpose());
}

RigidMotion bestRigidMotion(std::span<const Vector3> from, std::span<const Vector3> to) {
  return bestRigidMotion(from, to, evenWeights(from.size()));
}

namespace {

// Fits the vertices of all tiles or of the held tiles of `from` to those of `to`, and moves all
// tiles of `from`. A motion in the plane of the model's flat start does not leave it.
RigidMotion moveOnto(const std::vector<Tile>& to, std::span<const int> held, bool planar,
                     const std::optional<SheetFrame>& frame, std::vector<Tile>& from) {
  const auto points = [&](const std::vector<Tile>& tiles) {
    return held.empty() ? allVertices(tiles) : verticesOf(tiles, held);
  };
  const RigidMotion motion = planar ? bestPlanarMotion(*frame, points(from), points(to))
                                    : bestRigidMotion(points(from), points(to));
  for (Tile& tile : from) {
    for (Vector3& vertex : tile.vertices) vertex = motion.apply(vertex);
  }
  return motion;
}

}  // namespace

std::vector<Tile> bestFitted(std::vector<Tile> tiles, const std::vector<Tile>& onto) {
  const RigidMotion fit = bestRigidMotion(allVertices(tiles), allVertices(onto));
  for (Tile& tile : tiles) {
    for (Vector3& vertex : tile.vertices) vertex = fit.apply(vertex);
  }
  return tiles;
}

RigidMotion alignStartToTarget(Model& model, std::span<const int> held) {
  if (!model.target) return {};
  const double tolerance = flatTolerance(model);
  // Both states must be flat: a folding sheet may start upside down.
  const std::optional<SheetFrame> frame = sheetFrame(model.tiles, tolerance);
  const bool planar = frame && isParallel(*frame, *model.target, tolerance);
  return moveOnto(*model.target, held, planar, frame, model.tiles);
}

RigidMotion alignToStart(const Model& model, std::vector<Tile>& state, std::span<const int> held) {
  const double tolerance = flatTolerance(model);
  const std::optional<SheetFrame> frame = sheetFrame(model.tiles, tolerance);
  // A flat state whose tiles all face the opposite side is turned over as a whole.
  const bool isTurned = countTurnedOver(model.tiles, state) == static_cast<int>(model.tiles.size());
  const bool planar = frame && !isTurned && isParallel(*frame, state, tolerance);
  return moveOnto(model.tiles, held, planar, frame, state);
}

// ------------------------------------------------------------------------------------------------
// Finds the symmetry group of a model by matching its tiles.
//
// An isometry x -> A x about the common centre follows from the image of one tile: A = F' F^T. F
// are the axes of tile 0 along an edge and its normal, F' those of an edge of its image in either
// direction. Each tile, edge and direction is a candidate. Each candidate is then checked tile by
// tile: the image of a tile is the tile at the transformed position, at the start and at the
// target. Tiles are sorted by their distance from the centre, which A preserves, so each tile has
// few candidates.
//
// A from one tile is as accurate as its coordinates. Averaging over the group is more accurate:
// A(g) is replaced by the rotation or reflection nearest to the mean over h in G of A(h)^T A(h g).
// This squares the error. Grove, Karcher, Ruh (1974), "Group actions and curvature", Invent. math.
// 23.
//
// The mean over a group G of a state's images, q -> sum of g q / |G|, is invariant under each g,
// since g only changes the order of the sum. Positions use the arithmetic mean. Rotations use the
// mean of quaternions, which is the nearest rotation to all of them to second order: Gramkow
// (2001), "On averaging rotations", Int. J. Computer Vision 42.

namespace {

// Positions are equal if they agree to this fraction of a tile. Designs solved to 1e-12 have their
// symmetries with a wide margin. Coordinates with 9 digits or fewer have none.
constexpr double kSamePart = 1e-9;  // of a tile
// Larger groups are not refined, since each isometry is compared with each product of two.
constexpr std::size_t kLargestPolished = 64;
// Each round squares the error: 1e-9, 1e-18. The second round removes the rounding of the first.
constexpr int kPolishings = 2;
// A product of two isometries equals a third up to this tolerance.
constexpr double kSameTurn = 1e-3;
// Vertices farther than this fraction of a tile from their images are moved.
constexpr double kSymmetricPart = 1e-13;

/// The tiles of one state about their common centre.
struct CentredState {
  std::vector<Vector3> centroids;
  std::vector<std::vector<Vector3>> vertices;
  std::vector<Vector3> normals;

  explicit CentredState(const std::vector<Tile>& tiles) {
    for (const Tile& tile : tiles) {
      centroids.push_back(tileCentroid(tile));
      vertices.push_back(tile.vertices);
      normals.push_back(tileNormal(tile));
    }
    const Vector3 centre = meanPoint(centroids);
    for (Vector3& point : centroids) point -= centre;
    for (std::vector<Vector3>& tile : vertices) {
      for (Vector3& point : tile) point -= centre;
    }
  }

  /// Axes along the edge from a vertex, and the normal. `sense`: 1 towards the next vertex, -1
  /// towards the previous one.
  Matrix3 axesAt(std::size_t tile, std::size_t vertex, int sense) const {
    const std::vector<Vector3>& points = vertices[tile];
    const std::size_t step = sense > 0 ? 1 : points.size() - 1;
    Matrix3 axes;
    axes.col(0) = (points[(vertex + step) % points.size()] - points[vertex]).normalized();
    axes.col(2) = normals[tile];
    // With sense -1 the axes are left-handed. The isometry between them is then a reflection.
    axes.col(1) = sense * axes.col(2).cross(axes.col(0));
    return axes;
  }
};

/// Searches the isometries of one model.
class SymmetrySearch {
 public:
  explicit SymmetrySearch(const Model& model)
      : model_(model), tolerance_(kSamePart * tileSize(model)) {
    states_.emplace_back(model.tiles);
    if (model.target) states_.emplace_back(*model.target);
    const std::vector<Vector3>& centroids = states_.front().centroids;
    for (std::size_t i = 0; i < centroids.size(); ++i) {
      byDistance_.emplace_back(centroids[i].norm(), static_cast<int>(i));
    }
    std::ranges::sort(byDistance_);
    for (const Joint& joint : model.joints) joints_.insert(keyOf(joint, joint.a, joint.b));
  }

  // Tries every tile as the image of tile 0, with each of its edges and both senses.
  std::vector<Symmetry> find() {
    Symmetry identity;
    for (std::size_t i = 0; i < model_.tiles.size(); ++i) {
      identity.images.push_back(static_cast<int>(i));
    }
    std::vector<Symmetry> group = {identity};
    const std::size_t corners = model_.tiles.front().vertices.size();
    for (const int tile : tilesAt(Matrix3::Identity(), 0, false)) {
      if (model_.tiles[static_cast<std::size_t>(tile)].vertices.size() != corners) continue;
      for (std::size_t vertex = 0; vertex < corners; ++vertex) {
        for (const int sense : {1, -1}) {
          if (tile == 0 && vertex == 0 && sense == 1) continue;
          std::optional<Symmetry> found = symmetryBy(static_cast<std::size_t>(tile), vertex, sense);
          if (found) group.push_back(std::move(*found));
        }
      }
    }
    return group;
  }

 private:
  using CornerKey = std::pair<int, int>;
  using JointKey = std::tuple<JointKind, JointFace, CornerKey, CornerKey>;

  static JointKey keyOf(const Joint& joint, const Corner& a, const Corner& b) {
    const CornerKey first(a.tile, a.vertex), second(b.tile, b.vertex);
    return {joint.kind, joint.face, std::min(first, second), std::max(first, second)};
  }

  /// The isometry that maps tile 0's first edge to that of another tile, if it maps the model.
  std::optional<Symmetry> symmetryBy(std::size_t tile, std::size_t vertex, int sense) const {
    Symmetry symmetry;
    const CentredState& start = states_.front();
    symmetry.turn = start.axesAt(tile, vertex, sense) * start.axesAt(0, 0, 1).transpose();
    // Parallel edges give the same isometry. It counts once, for the tile at the image position.
    if (!isSame(symmetry.turn * start.vertices[0][0], start.vertices[tile][vertex])) return {};
    std::vector<std::vector<int>> corners;
    for (std::size_t i = 0; i < model_.tiles.size(); ++i) {
      checkInterruption();  // up to ten thousand tiles and as many isometries
      const std::vector<int> images = tilesAt(symmetry.turn, i, true);
      // No image: the isometry does not map the sheet. Several: tiles coincide in both states and
      // are indistinguishable.
      if (images.size() != 1) return {};
      corners.push_back(cornersAt(symmetry.turn, i, static_cast<std::size_t>(images.front())));
      if (corners.back().empty()) return {};
      symmetry.images.push_back(images.front());
    }
    if (!mapsJoints(symmetry.images, corners) || !mapsPulled(symmetry.images)) return {};
    return symmetry;
  }

  /// The tiles at the image of one tile, at the start and the target. If not `exactly`: all tiles
  /// at the same distance from the centre.
  std::vector<int> tilesAt(const Matrix3& turn, std::size_t tile, bool exactly) const {
    const double distance = states_.front().centroids[tile].norm();
    std::vector<int> found;
    for (auto other = std::ranges::lower_bound(byDistance_, std::pair(distance - tolerance_, -1));
         other != byDistance_.end() && other->first <= distance + tolerance_; ++other) {
      const auto isThere = [&](const CentredState& state) {
        return isSame(turn * state.centroids[tile],
                      state.centroids[static_cast<std::size_t>(other->second)]);
      };
      if (!exactly || std::ranges::all_of(states_, isThere)) found.push_back(other->second);
    }
    return found;
  }

  /// The image vertex of each vertex of a tile, at the start and the target. Empty if the isometry
  /// does not map the tile and its normal to the image.
  std::vector<int> cornersAt(const Matrix3& turn, std::size_t tile, std::size_t image) const {
    const std::size_t count = model_.tiles[tile].vertices.size();
    if (model_.tiles[image].vertices.size() != count) return {};
    for (const CentredState& state : states_) {
      // The normals decide on which side the bricks are.
      if ((turn * state.normals[tile]).dot(state.normals[image]) < 0.5) return {};
    }
    std::vector<int> corners;
    for (std::size_t from = 0; from < count; ++from) {
      for (std::size_t to = 0; to < count; ++to) {
        const auto isThere = [&](const CentredState& state) {
          return isSame(turn * state.vertices[tile][from], state.vertices[image][to]);
        };
        if (!std::ranges::all_of(states_, isThere)) continue;
        corners.push_back(static_cast<int>(to));
        break;
      }
      if (corners.size() != from + 1) return {};
    }
    return corners;
  }

  // Every joint must become a joint of the same kind and face.
  bool mapsJoints(const std::vector<int>& images,
                  const std::vector<std::vector<int>>& corners) const {
    const auto imageOf = [&](const Corner& corner) -> Corner {
      const auto tile = static_cast<std::size_t>(corner.tile);
      return {images[tile], corners[tile][static_cast<std::size_t>(corner.vertex)]};
    };
    return std::ranges::all_of(model_.joints, [&](const Joint& joint) {
      return joints_.contains(keyOf(joint, imageOf(joint.a), imageOf(joint.b)));
    });
  }

  bool mapsPulled(const std::vector<int>& images) const {
    if (!model_.pulledTiles) return true;
    const std::set<int> pulled(model_.pulledTiles->begin(), model_.pulledTiles->end());
    return std::ranges::all_of(
        pulled, [&](int tile) { return pulled.contains(images[static_cast<std::size_t>(tile)]); });
  }

  bool isSame(const Vector3& a, const Vector3& b) const { return (a - b).norm() <= tolerance_; }

  const Model& model_;
  double tolerance_;                                // metres
  std::vector<CentredState> states_;                // start, and target if there is one
  std::vector<std::pair<double, int>> byDistance_;  // distance of the centroid from the centre,
                                                    // tile
  std::set<JointKey> joints_;
};

Matrix3 nearestOrthogonal(const Matrix3& matrix) {
  // The orthogonal factor of the polar decomposition is the nearest orthogonal matrix in the
  // Frobenius norm: N. J. Higham, Computing the polar decomposition - with applications, SIAM J.
  // Sci. Stat. Comput. 7, 1986.
  const Eigen::JacobiSVD<Matrix3> parts(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return parts.matrixU() * parts.matrixV().transpose();
}

/// The member with this rotation and this image of the first tile. Absent if the members are not a
/// group.
std::optional<std::size_t> memberThat(const std::vector<Symmetry>& group, const Matrix3& turn,
                                      int imageOfFirst) {
  for (std::size_t k = 0; k < group.size(); ++k) {
    if (group[k].images.front() != imageOfFirst) continue;
    if ((group[k].turn - turn).norm() < kSameTurn) return k;
  }
  return {};
}

/// Refines the isometries of a group: squares their error.
void polish(std::vector<Symmetry>& group) {
  std::vector<Matrix3> means(group.size(), Matrix3::Zero());
  for (std::size_t k = 0; k < group.size(); ++k) {
    for (const Symmetry& first : group) {
      const int image = first.images[static_cast<std::size_t>(group[k].images.front())];
      const auto both = memberThat(group, first.turn * group[k].turn, image);
      // The isometries are not a group. Their mean has no meaning, so they stay unchanged.
      if (!both) return;
      means[k] += first.turn.transpose() * group[*both].turn;
    }
  }
  for (std::size_t k = 0; k < group.size(); ++k) group[k].turn = nearestOrthogonal(means[k]);
}

/// The means of the tiles' images under a symmetry group about their common centre. A vertex is
/// mapped to the nearest vertex of the image tile.
std::vector<Tile> symmetricMean(const std::vector<Tile>& tiles, std::span<const Symmetry> group) {
  std::vector<Vector3> centroids;
  for (const Tile& tile : tiles) centroids.push_back(tileCentroid(tile));
  const Vector3 centre = meanPoint(centroids);
  std::vector<Tile> mean = tiles;
  for (Tile& tile : mean) {
    for (Vector3& vertex : tile.vertices) vertex.setZero();
  }
  for (const Symmetry& symmetry : group) {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      const auto there = static_cast<std::size_t>(symmetry.images[i]);
      for (const Vector3& vertex : tiles[i].vertices) {
        const Vector3 image = centre + symmetry.turn * (vertex - centre);
        const std::vector<Vector3>& corners = tiles[there].vertices;
        const auto nearest = std::ranges::min_element(
            corners, {}, [&](const Vector3& corner) { return (corner - image).squaredNorm(); });
        mean[there].vertices[static_cast<std::size_t>(nearest - corners.begin())] +=
            image / static_cast<double>(group.size());
      }
    }
  }
  return mean;
}

/// The largest displacement of a vertex, metres.
double farthestMove(const std::vector<Tile>& from, const std::vector<Tile>& to) {
  double farthest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    for (std::size_t k = 0; k < from[i].vertices.size(); ++k) {
      farthest = std::max(farthest, (to[i].vertices[k] - from[i].vertices[k]).norm());
    }
  }
  return farthest;
}

/// Flat sheets stay exactly in their plane.
void keepHeights(const std::vector<Tile>& from, std::vector<Tile>& to) {
  const double height = from.front().vertices.front().z();
  for (const Tile& tile : from) {
    if (std::ranges::any_of(tile.vertices, [&](const Vector3& v) { return v.z() != height; }))
      return;
  }
  for (Tile& tile : to) {
    for (Vector3& vertex : tile.vertices) vertex.z() = height;
  }
}

// Replaces the tiles by the mean of their images if this moves any vertex by more than rounding.
void symmetriseTiles(std::vector<Tile>& tiles, std::span<const Symmetry> group, double least) {
  std::vector<Tile> mean = symmetricMean(tiles, group);
  // Tiles that are symmetric to rounding stay bitwise equal. The run of such a model does not
  // change.
  if (!(farthestMove(tiles, mean) > least)) return;
  keepHeights(tiles, mean);
  tiles = std::move(mean);
}

/// Maps poses by a symmetry about a centre. Conjugation transforms a rotation, which also removes a
/// reflection: brick axes are parallel to the world axes at the start.
class ImageOf {
 public:
  ImageOf(const Symmetry& symmetry, const Vector3& centre)
      : turn_(symmetry.turn),
        centre_(centre),
        rotation_(Matrix3(symmetry.turn * symmetry.turn.determinant())) {}

  Pose operator()(const Pose& pose) const {
    return {centre_ + turn_ * (pose.position - centre_),
            rotation_ * pose.rotation * rotation_.conjugate()};
  }

 private:
  Matrix3 turn_;
  Vector3 centre_;
  Quaternion rotation_;  // the turn, without its reflection
};

}  // namespace

std::vector<Symmetry> symmetriesOf(const Model& model) {
  std::vector<Symmetry> group = SymmetrySearch(model).find();
  const bool isPolished = group.size() > 1 && group.size() <= kLargestPolished;
  for (int i = 0; isPolished && i < kPolishings; ++i) polish(group);
  return group;
}

void symmetrise(Model& model) {
  const std::vector<Symmetry> group = symmetriesOf(model);
  if (group.size() < 2 || model.rounding > 0) return;
  const double least = kSymmetricPart * tileSize(model);
  symmetriseTiles(model.tiles, group, least);
  if (model.target) symmetriseTiles(*model.target, group, least);
}

// Each symmetry that the products of the earlier ones do not reach becomes a generator.
std::vector<Symmetry> generatorsOf(std::span<const Symmetry> group) {
  std::vector<Symmetry> generators;
  std::vector<Matrix3> reached = {Matrix3::Identity()};
  const auto isReached = [&](const Matrix3& turn) {
    return std::ranges::any_of(
        reached, [&](const Matrix3& known) { return known.isApprox(turn, kSameTurn); });
  };
  for (const Symmetry& symmetry : group) {
    if (isReached(symmetry.turn)) continue;
    generators.push_back(symmetry);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const Symmetry& generator : generators) {
        const Matrix3 product = generator.turn * reached[i];
        if (!isReached(product)) reached.push_back(product);
      }
    }
  }
  return generators;
}

// The largest over all symmetries and tiles.
double asymmetry(const Poses& poses, std::span<const Symmetry> group, double radius) {
  const Vector3 centre = meanPosition(poses);
  double farthest = 0;
  for (const Symmetry& symmetry : group) {
    const ImageOf imageOf(symmetry, centre);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Pose image = imageOf(poses[i]);
      const Pose& there = poses[static_cast<std::size_t>(symmetry.images[i])];
      farthest = std::max({farthest, (image.position - there.position).norm(),
                           radius * turnBetween(image.rotation, there.rotation).norm()});
    }
  }
  return farthest;
}

Poses symmetricMean(const Poses& poses, std::span<const Symmetry> group) {
  if (group.size() < 2) return poses;
  const Vector3 centre = meanPosition(poses);
  Poses mean(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) mean[i] = {Vector3::Zero(), poses[i].rotation};
  std::vector<Eigen::Vector4d> turns(poses.size(), Eigen::Vector4d::Zero());
  for (const Symmetry& symmetry : group) {
    const ImageOf imageOf(symmetry, centre);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto there = static_cast<std::size_t>(symmetry.images[i]);
      const Pose image = imageOf(poses[i]);
      mean[there].position += image.position / static_cast<double>(group.size());
      // A quaternion and its negative are one rotation.
      const double sign = image.rotation.dot(poses[there].rotation) < 0 ? -1 : 1;
      turns[there] += sign * image.rotation.coeffs();
    }
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    mean[i].rotation = Quaternion(Eigen::Vector4d(turns[i].normalized()));
  }
  return mean;
}

std::vector<Velocity> symmetricMean(const std::vector<Velocity>& velocities,
                                    std::span<const Symmetry> group) {
  std::vector<Velocity> mean(velocities.size());
  const double share = 1.0 / static_cast<double>(group.size());
  for (const Symmetry& symmetry : group) {
    // An angular velocity is an axial vector, which a reflection reverses.
    const Matrix3 axial = symmetry.turn.determinant() * symmetry.turn;
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      Velocity& there = mean[static_cast<std::size_t>(symmetry.images[i])];
      there.linear += share * symmetry.turn * velocities[i].linear;
      there.angular += share * axial * velocities[i].angular;
    }
  }
  return mean;
}

}  // namespace kirireel::model
