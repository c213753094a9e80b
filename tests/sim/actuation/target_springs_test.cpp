#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "sim/deploy/forces.h"
#include "sim/model/lattice.h"

namespace kirireel {
namespace {

/// One thick tile and a target that lies turned and shifted.
struct SpringScene {
  explicit SpringScene(double targetTurn, const TargetSpringSettings& settings = {})
      : bricks{makeBrick(tile(), {0.3, MassRule::Unit, 1})},
        target{tile()},
        springs(bricks, turned(target, targetTurn), {}, settings) {}

  static Tile tile() { return {{{0, 0, 0}, {2, 0.2, 0}, {2.5, 1.4, 0}, {0.3, 1, 0}}}; }

  static std::vector<Tile> turned(std::vector<Tile> tiles, double angle) {
    const Quaternion rotation = rotationFromVector(angle * Vector3(0.6, 0, 0.8));
    for (Vector3& vertex : tiles[0].vertices) vertex = rotation * vertex + Vector3(0.7, -0.4, 0.5);
    return tiles;
  }

  /// A pose not far from the target, displaced by a translation and a rotation vector.
  static Pose displaced(const Vector6& by) {
    const Quaternion start = rotationFromVector({0.3, -0.2, 0.5});
    return {Vector3(1.7, -0.1, 1.8) + by.head<3>(), rotationFromVector(by.tail<3>()) * start};
  }

  std::vector<Brick> bricks;
  std::vector<Tile> target;
  TargetSprings springs;
};

/// The derivative of a function of the six displacements, by central differences of fourth order.
template <typename Value, typename Function>
Value derivative(const Function& function, int coordinate) {
  const auto at = [&](double step) -> Value {
    Vector6 by = Vector6::Zero();
    by[coordinate] = step;
    return function(by);
  };
  constexpr double h = 1e-3;
  return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h);
}

TEST(TargetSprings, ForceIsMinusTheEnergysSlope) {
  const SpringScene scene(0.9);
  const Load load = scene.springs.load(0, SpringScene::displaced(Vector6::Zero()), 3);
  for (int k = 0; k < 6; ++k) {
    const double slope = derivative<double>(
        [&](const Vector6& by) { return scene.springs.energy({SpringScene::displaced(by)}, 3); },
        k);
    EXPECT_NEAR(load.force[k], -slope, 1e-8) << k;  // measured 3e-10
  }
}

TEST(TargetSprings, StiffnessIsTheForcesSlopeNearTheTarget) {
  // Symmetric part alone: the rest comes from turning the axes of a rotation vector.
  const SpringScene scene(0.9);
  const auto force = [&](const Vector6& by) -> Vector6 {
    return scene.springs.load(0, SpringScene::displaced(by), 1).force;
  };
  Matrix6 slope;
  for (int k = 0; k < 6; ++k) slope.col(k) = -derivative<Vector6>(force, k);
  const Matrix6 symmetric = 0.5 * (slope + slope.transpose());
  const Matrix6 K = scene.springs.load(0, SpringScene::displaced(Vector6::Zero()), 1).stiffness;
  EXPECT_LT((K - symmetric).cwiseAbs().maxCoeff(), 1e-7);  // measured 9e-11
}

TEST(TargetSprings, StiffnessIsNeverIndefinite) {
  for (double turn = 0; turn < 3.2; turn += 0.4) {
    const SpringScene scene(turn);
    const Matrix6 K = scene.springs.load(0, SpringScene::displaced(Vector6::Zero()), 1).stiffness;
    EXPECT_LT((K - K.transpose()).cwiseAbs().maxCoeff(), 1e-11);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(K).eigenvalues()[0], -1e-10) << turn;
  }
}

TEST(TargetSprings, PullsNothingAtTheTarget) {
  const std::vector<Brick> bricks{makeBrick(SpringScene::tile(), {})};
  const std::vector<Tile> target{SpringScene::tile()};
  const TargetSprings springs(bricks, target, {}, {});
  const Poses poses = startPoses(target, bricks);
  EXPECT_LT(springs.load(0, poses[0], 1).force.norm(), 1e-12);  // measured 3e-14
  EXPECT_LT(springs.energy(poses, 1), 1e-12);                   // measured 9e-14
}

TEST(TargetSprings, ForceIsThatOfVertexSprings) {
  // With equal stiffnesses, one force and one torque do what n springs at the vertices do.
  const SpringScene scene(0.9);
  const Pose pose = SpringScene::displaced(Vector6::Zero());
  const std::vector<Tile> target = SpringScene::turned({SpringScene::tile()}, 0.9);
  Vector6 sum = Vector6::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    const Vector3 point = pose.apply(scene.bricks[0].bottom[k]);
    const Vector3 pull = 100 * (target[0].vertices[k] - point);
    sum.head<3>() += pull;
    sum.tail<3>() += (point - pose.position).cross(pull);
  }
  EXPECT_LT((scene.springs.load(0, pose, 1).force - sum).norm(), 1e-10);  // measured 1e-13
}

TEST(TargetSprings, StiffeningScalesForceAndStiffnessButNotDamping) {
  const SpringScene scene(0.9);
  const Pose pose = SpringScene::displaced(Vector6::Zero());
  const Load soft = scene.springs.load(0, pose, 1);
  const Load stiff = scene.springs.load(0, pose, 16);
  EXPECT_LT((stiff.force - 16 * soft.force).norm(), 1e-9);
  EXPECT_LT((stiff.stiffness - 16 * soft.stiffness).norm(), 1e-9);
  EXPECT_EQ(stiff.damping, soft.damping);
}

TEST(TargetSprings, DampingIsDiagonal) {
  const SpringScene scene(0.9, {100, 100, 7, 3, true});
  const Matrix6 damping = scene.springs.load(0, Pose{}, 1).damping;
  Vector6 expected;
  expected << 7, 7, 7, 3, 3, 3;
  EXPECT_EQ(damping, Matrix6(expected.asDiagonal()));
}

TEST(TargetSprings, OnlyPulledBricksFeelThem) {
  const Model model = makeTessellation({2, 1});
  const std::vector<Brick> bricks = makeBricks(model.tiles, {});
  const TargetSprings springs(bricks, *model.target, std::vector<int>{1}, {});
  const Poses poses = startPoses(model.tiles, bricks);
  EXPECT_EQ(springs.load(0, poses[0], 1).force, Vector6::Zero());
  EXPECT_EQ(springs.load(0, poses[0], 1).damping(0, 0), 50);
  EXPECT_GT(springs.load(1, poses[1], 1).force.norm(), 1);
}

}  // namespace
}  // namespace kirireel
