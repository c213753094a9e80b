// Best rigid fits of one point set to another, by least squares.
//
// Wanted are the rotation R and the translation t that minimise
//   E(R, t) = sum over i of w_i |R a_i + t - b_i|^2
// for points a_i (from) and b_i (to), in metres, and weights w_i without unit. For any R the best t
// takes the weighted mean of the a_i to that of the b_i. What is left is to maximise trace(R C)
// with
//   C = sum over i of w_i (a_i - mean a)(b_i - mean b)^T          3 x 3, m^2
// In space: C = U S V^T (singular values) gives R = V diag(1, 1, d) U^T with d = det(V U^T) = +-1,
// so that R is a rotation and never a reflection. Points in one plane have a singular value 0,
// which d can use at no cost; points on one line leave the turn about the line open. In the plane:
// trace(R C) = cos(p) (C_xx + C_yy) + sin(p) (C_xy - C_yx), so that the angle is p = atan2(C_xy -
// C_yx, C_xx + C_yy).
//
// W. Kabsch, A solution for the best rotation to relate two sets of vectors, Acta Crystallographica
// A32, 1976.
#include "sim/model/isometry.h"

#include <algorithm>
#include <array>
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

// The weighted mean; the weights add up to something.
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

  /// The motion with this rotation that brings mean onto mean.
  RigidMotion withRotation(const Matrix3& rotation) const {
    return {rotation, toMean - rotation * fromMean};
  }
};

std::vector<double> evenWeights(std::size_t count) {
  return std::vector<double>(count, 1.0);
}

/// The best turn about the normal of a sheet: for sets in parallel planes the best motion in space
/// may flip the sheet over, which no sheet on a table can do.
RigidMotion bestPlanarMotion(const SheetFrame& frame, std::span<const Vector3> from,
                             std::span<const Vector3> to) {
  const Comparison sets(from, to, evenWeights(from.size()));
  const Matrix3& covariance = sets.covariance;
  const auto entry = [&](const Vector3& a, const Vector3& b) { return a.dot(covariance * b); };
  const double angle = std::atan2(entry(frame.x, frame.y) - entry(frame.y, frame.x),
                                  entry(frame.x, frame.x) + entry(frame.y, frame.y));
  return sets.withRotation(Eigen::AngleAxisd(angle, frame.normal).toRotationMatrix());
}

std::vector<Vector3> allVertices(const std::vector<Tile>& tiles) {
  std::vector<Vector3> points;
  for (const Tile& tile : tiles) {
    points.insert(points.end(), tile.vertices.begin(), tile.vertices.end());
  }
  return points;
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

// The fit is made from the vertices of all tiles, or of those that will be held, and moves all
// tiles.
RigidMotion alignStartToTarget(Model& model, std::span<const int> held) {
  if (!model.target) return {};
  const std::vector<Vector3> start = allVertices(model.tiles);
  const std::vector<Vector3> target = allVertices(*model.target);
  const double tolerance = flatTolerance(model);
  // Both states have to lie flat: one that folds up may well start upside down.
  const std::optional<SheetFrame> frame = sheetFrame(model.tiles, tolerance);
  const bool planar = frame && isParallel(*frame, *model.target, tolerance);
  const auto fit = [&](std::span<const Vector3> from, std::span<const Vector3> to) {
    return planar ? bestPlanarMotion(*frame, from, to) : bestRigidMotion(from, to);
  };
  const RigidMotion motion =
      held.empty() ? fit(start, target)
                   : fit(verticesOf(model.tiles, held), verticesOf(*model.target, held));
  for (Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) vertex = motion.apply(vertex);
  }
  return motion;
}

// ------------------------------------------------------------------------------------------------
// The symmetry group of a model by matching its tiles.
//
// An isometry x -> A x about the common centre is known from where it takes one tile: A = F' F^T,
// F the axes of tile 0 along an edge and its normal, F' those of an edge of its image, run either
// way. Each tile, edge and sense is tried, and what survives is checked tile by tile: the image of
// a tile is the one that stands where A takes it, at the start and at the target. Tiles are sorted
// by their distance from the centre, which A keeps, so that few are candidates.
//
// What one tile says of A is as good as its coordinates. A group knows better: A(g) is replaced by
// the rotation or reflection nearest to the mean over h in G of A(h)^T A(h g), which is exact to
// the square of what A was off by. Grove, Karcher, Ruh (1974), "Group actions and curvature",
// Invent. math. 23.
//
// The mean over a group G of a state's images, q -> sum of g q / |G|, is mapped onto itself by each
// g, since g only changes the order of the sum. Places are averaged as they are, and rotations as
// quaternions, whose mean is the rotation nearest to them all to second order: Gramkow (2001), "On
// averaging rotations", Int. J. Computer Vision 42.

namespace {

// Places that agree to this part of a tile are the same. Designs that are solved to 1e-12 have
// their symmetries with room to spare; coordinates of 9 digits and fewer have none.
constexpr double kSamePart = 1e-9;  // of a tile
// Isometries of larger groups stay as one tile says: each is compared with each product of two.
constexpr std::size_t kLargestPolished = 64;
// Each round squares what the isometries are off by: 1e-9, 1e-18. The second round is there for the
// rounding of the first.
constexpr int kPolishings = 2;
// Products of two isometries are a third up to this.
constexpr double kSameTurn = 1e-3;
// Vertices that are farther than this part of a tile from their images are moved.
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

  /// Axes along the edge from a vertex, and the normal. `sense`: 1 to the next vertex, -1 to the
  /// one before.
  Matrix3 axesAt(std::size_t tile, std::size_t vertex, int sense) const {
    const std::vector<Vector3>& points = vertices[tile];
    const std::size_t step = sense > 0 ? 1 : points.size() - 1;
    Matrix3 axes;
    axes.col(0) = (points[(vertex + step) % points.size()] - points[vertex]).normalized();
    axes.col(2) = normals[tile];
    // With the sense -1 the axes are left-handed, so that the isometry between them is a
    // reflection.
    axes.col(1) = sense * axes.col(2).cross(axes.col(0));
    return axes;
  }
};

/// Looks for the isometries of one model.
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

  // Tries every tile as the image of tile 0, by each of its edges and both senses.
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

  /// The isometry that takes tile 0's first edge to that of another, if it maps the model.
  std::optional<Symmetry> symmetryBy(std::size_t tile, std::size_t vertex, int sense) const {
    Symmetry symmetry;
    const CentredState& start = states_.front();
    symmetry.turn = start.axesAt(tile, vertex, sense) * start.axesAt(0, 0, 1).transpose();
    // Parallel edges give one isometry: it counts once, with the tile that it does take there.
    if (!isSame(symmetry.turn * start.vertices[0][0], start.vertices[tile][vertex])) return {};
    std::vector<std::vector<int>> corners;
    for (std::size_t i = 0; i < model_.tiles.size(); ++i) {
      checkInterruption();  // ten thousand tiles, and as many isometries to try
      const std::vector<int> images = tilesAt(symmetry.turn, i, true);
      // None: the isometry does not map the sheet. Several: tiles lie on each other in both states,
      // and cannot be told apart.
      if (images.size() != 1) return {};
      corners.push_back(cornersAt(symmetry.turn, i, static_cast<std::size_t>(images.front())));
      if (corners.back().empty()) return {};
      symmetry.images.push_back(images.front());
    }
    if (!mapsJoints(symmetry.images, corners) || !mapsPulled(symmetry.images)) return {};
    return symmetry;
  }

  /// The tiles that stand where an isometry takes one, at the start and the target; or, not
  /// `exactly`, all that are as far from the centre as it.
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

  /// The vertex of the image that each vertex of a tile is taken to, at the start and the target;
  /// empty where the isometry does not take the tile, with its normal, to the image.
  std::vector<int> cornersAt(const Matrix3& turn, std::size_t tile, std::size_t image) const {
    const std::size_t count = model_.tiles[tile].vertices.size();
    if (model_.tiles[image].vertices.size() != count) return {};
    for (const CentredState& state : states_) {
      // The normals decide on which side bricks grow.
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
  std::vector<std::pair<double, int>> byDistance_;  // of centroids from the centre, with the tile
  std::set<JointKey> joints_;
};

Matrix3 nearestOrthogonal(const Matrix3& matrix) {
  // The orthogonal factor of the polar decomposition is the nearest orthogonal matrix in the
  // Frobenius norm: N. J. Higham, Computing the polar decomposition - with applications, SIAM J.
  // Sci. Stat. Comput. 7, 1986.
  const Eigen::JacobiSVD<Matrix3> parts(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return parts.matrixU() * parts.matrixV().transpose();
}

/// The number of the member that turns so, and maps the first tile there; none where the members
/// are no group.
std::optional<std::size_t> memberThat(const std::vector<Symmetry>& group, const Matrix3& turn,
                                      int imageOfFirst) {
  for (std::size_t k = 0; k < group.size(); ++k) {
    if (group[k].images.front() != imageOfFirst) continue;
    if ((group[k].turn - turn).norm() < kSameTurn) return k;
  }
  return {};
}

/// Makes the isometries of a group exact to the square of what they are off by.
void polish(std::vector<Symmetry>& group) {
  std::vector<Matrix3> means(group.size(), Matrix3::Zero());
  for (std::size_t k = 0; k < group.size(); ++k) {
    for (const Symmetry& first : group) {
      const int image = first.images[static_cast<std::size_t>(group[k].images.front())];
      const auto both = memberThat(group, first.turn * group[k].turn, image);
      // The isometries found are no group, so that their mean means nothing: they stay as they are.
      if (!both) return;
      means[k] += first.turn.transpose() * group[*both].turn;
    }
  }
  for (std::size_t k = 0; k < group.size(); ++k) group[k].turn = nearestOrthogonal(means[k]);
}

/// The means of the tiles' images under a group of symmetries about their common centre. A vertex
/// is mapped to the one of the image tile that is nearest.
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

/// The farthest move of a vertex, metres.
double farthestMove(const std::vector<Tile>& from, const std::vector<Tile>& to) {
  double farthest = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    for (std::size_t k = 0; k < from[i].vertices.size(); ++k) {
      farthest = std::max(farthest, (to[i].vertices[k] - from[i].vertices[k]).norm());
    }
  }
  return farthest;
}

/// Flat sheets stay in their plane exactly.
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

// Replaces the tiles by the mean of their images where that moves any vertex by more than rounding.
void symmetriseTiles(std::vector<Tile>& tiles, std::span<const Symmetry> group, double least) {
  std::vector<Tile> mean = symmetricMean(tiles, group);
  // What is symmetric to rounding keeps its bits, so that such a model's run does not change.
  if (!(farthestMove(tiles, mean) > least)) return;
  keepHeights(tiles, mean);
  tiles = std::move(mean);
}

Vector3 centreOf(const Poses& poses) {
  Vector3 sum = Vector3::Zero();
  for (const Pose& pose : poses) sum += pose.position;
  return sum / static_cast<double>(poses.size());
}

/// Where a symmetry takes a pose. Its turn acts on rotations by conjugation, which takes a
/// reflection out again: brick axes are parallel to the world's at the start.
Pose imageOf(const Pose& pose, const Vector3& centre, const Symmetry& symmetry) {
  const Matrix3 rotation =
      symmetry.turn * pose.rotation.toRotationMatrix() * symmetry.turn.transpose();
  return {centre + symmetry.turn * (pose.position - centre), Quaternion(rotation)};
}

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

// The largest over all symmetries and tiles.
double asymmetry(const Poses& poses, std::span<const Symmetry> group, double radius) {
  const Vector3 centre = centreOf(poses);
  double farthest = 0;
  for (const Symmetry& symmetry : group) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Pose image = imageOf(poses[i], centre, symmetry);
      const Pose& there = poses[static_cast<std::size_t>(symmetry.images[i])];
      farthest = std::max({farthest, (image.position - there.position).norm(),
                           radius * turnBetween(image.rotation, there.rotation).norm()});
    }
  }
  return farthest;
}

Poses symmetricMean(const Poses& poses, std::span<const Symmetry> group) {
  if (group.size() < 2) return poses;
  const Vector3 centre = centreOf(poses);
  Poses mean(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) mean[i] = {Vector3::Zero(), poses[i].rotation};
  std::vector<Eigen::Vector4d> turns(poses.size(), Eigen::Vector4d::Zero());
  for (const Symmetry& symmetry : group) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const auto there = static_cast<std::size_t>(symmetry.images[i]);
      const Pose image = imageOf(poses[i], centre, symmetry);
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
