// States before a goal with folds of half a turn.
//
// The shortest rotation between two poses has no sign if it is half a turn. So the start and the
// goal of a flat-folded sheet do not define which folds are mountains. The model's fold angles phi
// define it. All folds open together, in kSteps steps. In each step brick i moves by v_i and turns
// by w_i about its centre c_i, such that
//   w_b - w_a = -phi / kSteps e                    at each fold with the axis e
//   v_a + w_a x (p - c_a) + p_a = v_b + w_b x (p - c_b) + p_b                  at each pivot p
// p_a and p_b are the pivot's points on both bricks. Around a vertex these equations contradict
// each other, so they hold in the least-squares sense (lengths divided by the size of a tile). Of
// all solutions this is the smallest. The open sheet is then a rotated and moved copy of the start.
// This rigid motion is taken back in equal parts, one per step.
#include "sim/path/fold_guide.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/SparseCholesky>

#include "sim/model/isometry.h"

namespace kirireel::path {
namespace {

// Folds that differ from half a turn by less than this angle count as folds of half a turn,
// radians.
constexpr double kHalfTurn = 0.01;
// Number of steps that open the folds. The last one ends at the start.
constexpr int kSteps = 8;
// A fold is on the wrong side beyond this angle, radians.
constexpr double kWrongSide = 0.02;
// Weight of the size of a motion against the equations.
constexpr double kSmallest = 1e-9;

/// Linear equations in the bricks' moves (divided by a length) and turns, six unknowns per brick.
class SmallMotion {
 public:
  SmallMotion(std::size_t bricks, double length)
      : length_(length), unknowns_(6 * static_cast<int>(bricks)) {}

  /// turn of B - turn of A = difference
  void addTurns(int brickA, int brickB, const Vector3& difference) {
    for (int k = 0; k < 3; ++k) {
      entries_.emplace_back(rows(), 6 * brickB + 3 + k, 1);
      entries_.emplace_back(rows(), 6 * brickA + 3 + k, -1);
      right_.push_back(difference[k]);
    }
  }

  /// Two points of two bricks, with these arms from the centres, come together. `gap` is from the
  /// point of B to that of A.
  void addPoints(int brickA, int brickB, const Vector3& armA, const Vector3& armB,
                 const Vector3& gap) {
    const Matrix3 turnsA = crossMatrix(armA / length_), turnsB = crossMatrix(armB / length_);
    for (int k = 0; k < 3; ++k) {
      entries_.emplace_back(rows(), 6 * brickA + k, 1);
      entries_.emplace_back(rows(), 6 * brickB + k, -1);
      for (int j = 0; j < 3; ++j) {
        entries_.emplace_back(rows(), 6 * brickA + 3 + j, -turnsA(k, j));
        entries_.emplace_back(rows(), 6 * brickB + 3 + j, turnsB(k, j));
      }
      right_.push_back(-gap[k] / length_);
    }
  }

  /// The poses after the smallest motion.
  Poses moved(const Poses& from) const {
    Eigen::SparseMatrix<double> matrix(rows(), unknowns_), one(unknowns_, unknowns_);
    matrix.setFromTriplets(entries_.begin(), entries_.end());
    one.setIdentity();
    const Eigen::Map<const Eigen::VectorXd> right(right_.data(), rows());
    const Eigen::SparseMatrix<double> square = matrix.transpose() * matrix + kSmallest * one;
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(square);
    const Eigen::VectorXd x = factor.solve(matrix.transpose() * right);
    Poses to;
    for (std::size_t i = 0; i < from.size(); ++i) {
      const auto at = 6 * static_cast<Eigen::Index>(i);
      to.push_back(displaced(from[i], length_ * x.segment<3>(at), x.segment<3>(at + 3)));
    }
    return to;
  }

 private:
  int rows() const { return static_cast<int>(right_.size()); }

  double length_;
  int unknowns_;
  std::vector<Eigen::Triplet<double>> entries_;
  std::vector<double> right_;
};

}  // namespace

FoldGuide::FoldGuide(Poses goal, const model::Model& model, const std::vector<brick::Brick>& bricks,
                     const std::vector<brick::Pivot>& pivots)
    : goal_(std::move(goal)), bricks_(bricks), pivots_(pivots), tile_(model::tileSize(model)) {
  if (model.foldAngles.empty()) return;
  for (const brick::Hinge& hinge : brick::findHinges(bricks, pivots, false).hinges) {
    const auto fold = model.foldAngles.find({hinge.brickA, hinge.brickB});
    if (fold == model.foldAngles.end()) continue;
    const double angle = std::abs(brick::hingeAngle(hinge, goal_));
    folds_.push_back({hinge, std::copysign(angle, fold->second),
                      std::abs(std::numbers::pi - angle) < kHalfTurn});
  }
  if (std::ranges::none_of(folds_, &SignedFold::isHalfTurn)) folds_.clear();
}

bool FoldGuide::isOnWrongSide(const Poses& halfway) const {
  return std::ranges::any_of(folds_, [&](const SignedFold& fold) {
    const double angle = std::copysign(1.0, fold.angle) * brick::hingeAngle(fold.hinge, halfway);
    return fold.isHalfTurn && angle < -kWrongSide && angle > kWrongSide - std::numbers::pi;
  });
}

/// The state after a step that opens the folds.
Poses FoldGuide::opened(const Poses& poses) const {
  SmallMotion motion(poses.size(), tile_);
  for (const SignedFold& fold : folds_) {
    const brick::Hinge& hinge = fold.hinge;
    motion.addTurns(hinge.brickA, hinge.brickB,
                    -fold.angle / kSteps * (poses[hinge.brickA].rotation * hinge.axis));
  }
  for (const brick::Pivot& pivot : pivots_) {
    if (!pivot.joinsPoints()) continue;
    const Pose &a = poses[pivot.brickA], &b = poses[pivot.brickB];
    motion.addPoints(pivot.brickA, pivot.brickB, a.rotation * pivot.pointA,
                     b.rotation * pivot.pointB, a.apply(pivot.pointA) - b.apply(pivot.pointB));
  }
  return motion.moved(poses);
}

/// Moves the last state onto the start, and each state before it by its part of this motion.
void FoldGuide::takeBackRigidMotion(const Poses& start, std::vector<Poses>& states) const {
  const auto pointsOf = [&](const Poses& poses) {
    std::vector<Vector3> points;
    for (std::size_t i = 0; i < bricks_.size(); ++i) {
      for (const Vector3& point : bricks_[i].bottom) points.push_back(poses[i].apply(point));
    }
    return points;
  };
  const std::vector<Vector3> from = pointsOf(states.back()), to = pointsOf(start);
  const Vector3 centre = meanPoint(from), move = meanPoint(to) - centre;
  const Vector3 turn =
      turnBetween(Quaternion::Identity(), Quaternion(model::bestRigidMotion(from, to).rotation));
  for (std::size_t k = 1; k < states.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(states.size() - 1);
    const Quaternion rotation = rotationFromVector(share * turn);
    for (Pose& pose : states[k]) {
      pose.position = centre + share * move + rotation * (pose.position - centre);
      pose.rotation = rotation * pose.rotation;
    }
  }
}

std::vector<Poses> FoldGuide::from(const Poses& start) const {
  if (folds_.empty()) return {start, goal_};
  std::vector<Poses> guide = {goal_};
  for (int step = 1; step <= kSteps; ++step) guide.push_back(opened(guide.back()));
  takeBackRigidMotion(start, guide);
  guide.back() = start;
  std::ranges::reverse(guide);
  return guide;
}

}  // namespace kirireel::path
