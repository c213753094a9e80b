// The string method: E, Ren, Vanden-Eijnden (2002), "String method for the study of rare events",
// Physical Review B 66.
//
// Images q_1 ... q_m of a path, at equal distances from each other, fall across the path towards
// less of the energy E(q) = sum over joints of |c_j(q)|^p, c_j a joint's gap:
//   minimise  sum w_j |c_j + J_j u|^2 + mu |u|_W^2,  w_j = |c_j|^(p - 2) over its mean,
// of which the part along the path is taken away; then they are spread evenly again. A fall that
// would make bricks overlap is halved until it does not. Images stop at contacts and do not slide
// along them, so the minimum is an upper bound for touching bricks. W is the metric of
// pathDistance(). As p grows from 2 to 32, E becomes a measure of the largest gap. What is left of
// it on the whole path, the smallest over all rounds, is the smallest opening that was found.
//
// For the length, images with closed joints go to the middle of their neighbours instead, as far as
// joints let them to the first order:
//   minimise |u - o d|_W^2  with  J u = -c,  d from the image to that middle, o over-relaxation,
// one image after the other. Symmetries of the model that all images have are kept: a path with
// them may be longer than one without, as a ball's path over a hilltop is.
//
// It shares no code with the paths of the program but bricks and pivots.
#include "tests/bench/string_method.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/SparseCholesky>

#include "sim/model/isometry.h"
#include "sim/run/mechanism_path.h"
#include "sim/scene/scene_needs.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

constexpr int kImages = 41;
constexpr int kRoundsAPower = 60;
constexpr double kPowers[] = {2, 4, 8, 16, 32};
// Of moves, over the joints' weights: larger is slower and more robust.
constexpr double kMinDamping = 1e-3;
constexpr int kHalvings = 6;
constexpr double kNoGap = 1e-12;  // metres
// For the length: rounds, the factor o, and the square of a singular value that counts as zero.
constexpr int kRoundsOfLength = 200;
constexpr double kOverRelaxation = 1.6;
constexpr double kZero = 1e-9;
constexpr int kClosings = 5;
constexpr double kAsymmetric = 1e-6;  // tiles

using Vector = Eigen::VectorXd;

class String {
 public:
  String(const scene::Scene& scene, const std::vector<Poses>& guide, double maxGrown)
      : maxGrown_(maxGrown),
        bricks_(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots_(brick::makePivots(scene.model.joints, bricks_)),
        meter_(bricks_, pivots_, scene.environment.pivotZone, guide.front(), 0),
        isPlanar_(scene::sceneNeeds(scene).planar.on),
        tile_(model::tileSize(scene.model)),
        group_(model::symmetriesOf(scene.model)) {
    if (isPlanar_) std::erase_if(pivots_, [](const brick::Pivot& pivot) { return pivot.isUpper; });
    for (const brick::Brick& brick : bricks_) {
      double sum = 0;
      for (const Vector3& point : brick.bottom) sum += point.squaredNorm();
      radii_.push_back(std::sqrt(sum / static_cast<double>(brick.bottom.size())));
    }
    images_ = guide;
    spreadEvenly();
  }

  double relax() {
    double least = opening();
    for (const double power : kPowers) {
      for (int round = 0; round < kRoundsAPower; ++round) {
        const std::vector<Poses> before = images_;
        for (std::size_t k = 1; k + 1 < images_.size(); ++k) {
          images_[k] = fallen(before[k], before[k - 1], before[k + 1], power);
        }
        spreadEvenly();
        least = std::min(least, opening());
      }
    }
    return least;
  }

  /// The length of the shortened path over that of the images.
  double shorten() {
    const double before = length();
    keepSymmetries();
    for (int round = 0; round < kRoundsOfLength; ++round) {
      for (std::size_t k = 1; k + 1 < images_.size(); ++k) {
        images_[k] = shortened(images_[k], images_[k - 1], images_[k + 1], kOverRelaxation);
      }
    }
    for (int round = 0; round < kClosings; ++round) {
      for (std::size_t k = 1; k + 1 < images_.size(); ++k) {
        images_[k] = shortened(images_[k], images_[k], images_[k], 0);
      }
    }
    return length() / before;
  }

 private:
  void keepSymmetries() {
    std::erase_if(group_, [&](const model::Symmetry& symmetry) {
      return std::ranges::any_of(images_, [&](const Poses& image) {
        return model::asymmetry(image, {&symmetry, 1}, tile_) > kAsymmetric * tile_;
      });
    });
  }

  double length() const {
    double sum = 0;
    for (std::size_t k = 1; k < images_.size(); ++k) {
      sum += run::pathDistance(bricks_, images_[k - 1], images_[k]);
    }
    return sum;
  }

  int freedoms() const { return isPlanar_ ? 3 : 6; }

  /// The largest gap on the path: of the images, and half way between them.
  double opening() {
    double largest = 0;
    for (std::size_t k = 0; k < images_.size(); ++k) {
      if (grown(images_[k]) > maxGrown_) return std::numeric_limits<double>::infinity();
      largest = std::max(largest, gapOf(images_[k]));
      if (k > 0) largest = std::max(largest, gapOf(interpolate(images_[k - 1], images_[k], 0.5)));
    }
    return largest;
  }

  /// The deepest overlap beyond that at the start, metres; 0 if any overlap is allowed.
  double grown(const Poses& poses) { return std::isfinite(maxGrown_) ? meter_.at(poses).grown : 0; }

  double gapOf(const Poses& poses) const {
    double largest = 0;
    for (const brick::Pivot& pivot : pivots_)
      largest = std::max(largest, brick::pivotGap(pivot, poses));
    return largest;
  }

  /// Puts the images at equal distances along the path.
  void spreadEvenly() {
    std::vector<double> lengths = {0};
    for (std::size_t k = 1; k < images_.size(); ++k) {
      lengths.push_back(lengths.back() + run::pathDistance(bricks_, images_[k - 1], images_[k]));
    }
    std::vector<Poses> even = {images_.front()};
    std::size_t next = 1;
    for (int k = 1; k + 1 < kImages; ++k) {
      const double length = lengths.back() * k / (kImages - 1);
      while (next + 1 < lengths.size() && lengths[next] < length) ++next;
      const double part = lengths[next] - lengths[next - 1];
      const double share = part > 0 ? (length - lengths[next - 1]) / part : 1;
      even.push_back(interpolate(images_[next - 1], images_[next], share));
    }
    even.push_back(images_.back());
    images_ = std::move(even);
  }

  /// A move between two states in units of the metric: distances, and rotations times radii.
  Vector moveBetween(const Poses& from, const Poses& to) const {
    Vector move(freedoms() * static_cast<int>(from.size()));
    for (std::size_t i = 0; i < from.size(); ++i) {
      const Vector3 place = to[i].position - from[i].position;
      const Vector3 turn = radii_[i] * turnBetween(from[i].rotation, to[i].rotation);
      const int first = freedoms() * static_cast<int>(i);
      if (isPlanar_) {
        move.segment<3>(first) << place.x(), place.y(), turn.z();
      } else {
        move.segment<6>(first) << place, turn;
      }
    }
    return move;
  }

  Poses moved(Poses poses, const Vector& move) const {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const int first = freedoms() * static_cast<int>(i);
      Vector3 place = Vector3::Zero(), turn = Vector3::Zero();
      if (isPlanar_) {
        place.head<2>() = move.segment<2>(first);
        turn.z() = move[first + 2] / radii_[i];
      } else {
        place = move.segment<3>(first);
        turn = move.segment<3>(first + 3) / radii_[i];
      }
      poses[i].position += place;
      poses[i].rotation = (rotationFromVector(turn) * poses[i].rotation).normalized();
    }
    return poses;
  }

  /// Adds the derivatives of a pivot's point in world axes to three rows.
  void addSlopes(std::vector<Eigen::Triplet<double>>& slopes, int row, int brick,
                 const Vector3& arm, double sign) const {
    const int first = freedoms() * brick;
    const double radius = radii_[static_cast<std::size_t>(brick)];
    for (int axis = 0; axis < 3; ++axis) {
      if (!isPlanar_ || axis < 2) slopes.emplace_back(row + axis, first + axis, sign);
    }
    for (int turn = isPlanar_ ? 2 : 0; turn < 3; ++turn) {
      const Vector3 slope = Vector3::Unit(turn).cross(arm) * (sign / radius);
      for (int axis = 0; axis < 3; ++axis) {
        slopes.emplace_back(row + axis, first + (isPlanar_ ? 2 : 3 + turn), slope[axis]);
      }
    }
  }

  /// The gaps of all joints and their slopes.
  struct Joints {
    Vector gaps;
    Eigen::SparseMatrix<double> jacobian;
  };

  Joints jointsAt(const Poses& poses) const {
    const int rows = 3 * static_cast<int>(pivots_.size());
    Joints joints{Vector(rows), {rows, freedoms() * static_cast<int>(poses.size())}};
    std::vector<Eigen::Triplet<double>> slopes;
    for (std::size_t j = 0; j < pivots_.size(); ++j) {
      const brick::Pivot& pivot = pivots_[j];
      const Pose& a = poses[static_cast<std::size_t>(pivot.brickA)];
      const Pose& b = poses[static_cast<std::size_t>(pivot.brickB)];
      const int row = 3 * static_cast<int>(j);
      joints.gaps.segment<3>(row) = a.apply(pivot.pointA) - b.apply(pivot.pointB);
      addSlopes(slopes, row, pivot.brickA, a.rotation * pivot.pointA, 1);
      addSlopes(slopes, row, pivot.brickB, b.rotation * pivot.pointB, -1);
    }
    joints.jacobian.setFromTriplets(slopes.begin(), slopes.end());
    return joints;
  }

  /// A state after a move. The move is halved until no overlap exceeds its limit.
  Poses clearlyMoved(const Poses& poses, Vector move) {
    const double most = std::max(maxGrown_, grown(poses));
    for (int halving = 0; halving < kHalvings; ++halving, move *= 0.5) {
      Poses found = moved(poses, move);
      if (grown(found) <= most) return found;
    }
    return poses;
  }

  Poses fallen(const Poses& poses, const Poses& before, const Poses& after, double power) {
    const double largest = std::max(gapOf(poses), kNoGap);
    const Joints joints = jointsAt(poses);
    Vector weights(joints.gaps.size());
    for (int row = 0; row < weights.size(); row += 3) {
      weights.segment<3>(row).setConstant(
          std::pow(joints.gaps.segment<3>(row).norm() / largest, power - 2));
    }
    const Eigen::SparseMatrix<double> weighted = weights.asDiagonal() * joints.jacobian;
    Vector move = solved(joints.jacobian.transpose() * weighted, kMinDamping,
                         -weighted.transpose() * joints.gaps) /
                  (power - 1);
    const Vector along = moveBetween(before, after).normalized();
    move -= move.dot(along) * along;
    return clearlyMoved(poses, move);
  }

  Poses shortened(const Poses& poses, const Poses& before, const Poses& after, double factor) {
    const Joints joints = jointsAt(poses);
    const Vector change = 0.5 * factor * (moveBetween(poses, before) + moveBetween(poses, after));
    const Vector opened = joints.jacobian * change + joints.gaps;
    const Vector closing = solved(joints.jacobian.transpose() * joints.jacobian, kZero,
                                  joints.jacobian.transpose() * opened);
    return model::symmetricMean(clearlyMoved(poses, change - closing), group_);
  }

  /// The solution of (matrix + damping) x = right.
  static Vector solved(Eigen::SparseMatrix<double> matrix, double damping, const Vector& right) {
    Eigen::SparseMatrix<double> one(matrix.rows(), matrix.cols());
    one.setIdentity();
    matrix += damping * one;
    return Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(matrix).solve(right);
  }

  double maxGrown_;  // metres
  std::vector<brick::Brick> bricks_;
  std::vector<brick::Pivot> pivots_;
  trajectory::PenetrationMeter meter_;
  bool isPlanar_;
  std::vector<double> radii_;  // of gyration, metres
  std::vector<Poses> images_;
  double tile_;                         // metres
  std::vector<model::Symmetry> group_;  // of the model, then of all images
};

}  // namespace

double minOpening(const scene::Scene& scene, const std::vector<Poses>& guide, double maxGrown) {
  return String(scene, guide, maxGrown).relax();
}

double minLength(const scene::Scene& scene, const std::vector<Poses>& path, double maxGrown) {
  return String(scene, path, maxGrown).shorten();
}

}  // namespace kirireel
