#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/run/forces.h"

namespace kirireel {
namespace {

/// One thick tile and a rotated and translated target.
struct SpringScene {
  explicit SpringScene(double targetTurn, const scene::TargetSpringSettings& settings = {})
      : bricks{brick::makeBrick(tile(), {0.3, brick::MassRule::Unit, 1})},
        target{tile()},
        springs(bricks, turned(target, targetTurn), {}, settings) {}

  static model::Tile tile() { return {{{0, 0, 0}, {2, 0.2, 0}, {2.5, 1.4, 0}, {0.3, 1, 0}}}; }

  static std::vector<model::Tile> turned(std::vector<model::Tile> tiles, double angle) {
    const Quaternion rotation = rotationFromVector(angle * Vector3(0.6, 0, 0.8));
    for (Vector3& vertex : tiles[0].vertices) vertex = rotation * vertex + Vector3(0.7, -0.4, 0.5);
    return tiles;
  }

  /// A pose not far from the target, displaced by a translation and a rotation vector.
  static Pose displaced(const Vector6& by) {
    const Quaternion start = rotationFromVector({0.3, -0.2, 0.5});
    return {Vector3(1.7, -0.1, 1.8) + by.head<3>(), rotationFromVector(by.tail<3>()) * start};
  }

  std::vector<brick::Brick> bricks;
  std::vector<model::Tile> target;
  run::TargetSprings springs;
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
  const brick::Load load = scene.springs.load(0, SpringScene::displaced(Vector6::Zero()), 3);
  for (int k = 0; k < 6; ++k) {
    const double slope = derivative<double>(
        [&](const Vector6& by) { return scene.springs.energy({SpringScene::displaced(by)}, 3); },
        k);
    EXPECT_NEAR(load.force[k], -slope, 1e-8) << k;  // measured 3e-10
  }
}

TEST(TargetSprings, StiffnessIsTheForcesSlopeNearTheTarget) {
  // Only the symmetric part. The rest comes from the rotating axes of a rotation vector.
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

TEST(TargetSprings, DoNotPullAtTheTarget) {
  const std::vector<brick::Brick> bricks{brick::makeBrick(SpringScene::tile(), {})};
  const std::vector<model::Tile> target{SpringScene::tile()};
  const run::TargetSprings springs(bricks, target, {}, {});
  const Poses poses = brick::startPoses(target, bricks);
  EXPECT_LT(springs.load(0, poses[0], 1).force.norm(), 1e-12);  // measured 3e-14
  EXPECT_LT(springs.energy(poses, 1), 1e-12);                   // measured 9e-14
}

TEST(TargetSprings, ForceIsThatOfVertexSprings) {
  // With equal stiffnesses, one force and one torque are equivalent to n springs at the vertices.
  const SpringScene scene(0.9, scene::paperSprings());
  const Pose pose = SpringScene::displaced(Vector6::Zero());
  const std::vector<model::Tile> target = SpringScene::turned({SpringScene::tile()}, 0.9);
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
  const brick::Load soft = scene.springs.load(0, pose, 1);
  const brick::Load stiff = scene.springs.load(0, pose, 16);
  EXPECT_LT((stiff.force - 16 * soft.force).norm(), 1e-9);
  EXPECT_LT((stiff.stiffness - 16 * soft.stiffness).norm(), 1e-9);
  EXPECT_EQ(stiff.damping, soft.damping);
}

TEST(TargetSprings, DampingThatIsGivenIsTheSameAboutAllAxes) {
  scene::TargetSpringSettings settings;
  settings.forceDamping = 7;
  settings.torqueDamping = 3;
  const SpringScene scene(0.9, settings);
  const Pose pose = SpringScene::displaced(Vector6::Zero());
  Vector6 expected;
  expected << 7, 7, 7, 3, 3, 3;
  const Matrix6 damping = scene.springs.load(0, pose, 1).damping;
  EXPECT_LT((damping - Matrix6(expected.asDiagonal())).norm(), 1e-14);
}

TEST(TargetSprings, OnlyPulledBricksFeelThem) {
  const model::Model model = generate::makeTessellation({2, 1});
  const std::vector<brick::Brick> bricks = brick::makeBricks(model.tiles, {});
  const run::TargetSprings springs(bricks, *model.target, std::vector<int>{1}, {});
  const Poses poses = brick::startPoses(model.tiles, bricks);
  EXPECT_EQ(springs.load(0, poses[0], 1).force, Vector6::Zero());
  EXPECT_GT(springs.load(0, poses[0], 1).damping(0, 0), 1);
  EXPECT_GT(springs.load(1, poses[1], 1).force.norm(), 1);
}

/// One regular tile of `corners` vertices, whose target is itself, and its motion on its springs by
/// short implicit steps of second order.
class SwingingBrick {
 public:
  SwingingBrick(int corners, const brick::BrickRule& rule,
                const scene::TargetSpringSettings& settings)
      : tile_{regular(corners)},
        bricks_{brick::makeBrick(tile_[0], rule)},
        springs_(bricks_, tile_, {}, settings),
        pose_(brick::startPoses(tile_, bricks_)[0]) {}

  static model::Tile regular(int corners) {
    model::Tile tile;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners;
      tile.vertices.emplace_back(0.7 * std::cos(angle), 0.7 * std::sin(angle), 0);
    }
    return tile;
  }

  /// The displacement along x, or the angle about z, at each of `count` steps after its release.
  std::vector<double> swing(bool turns, double amplitude, double step, int count) {
    const int at = turns ? 5 : 0;
    const double inertia = turns ? bricks_[0].inertia(2, 2) : bricks_[0].mass;
    std::vector<double> places = {amplitude};
    double speed = 0;
    for (int k = 0; k < count; ++k) {
      // The trapezoidal rule: m (v' - v) / h = (f + f') / 2 - c (v + v') / 2.
      const brick::Load load = this->load(turns, places.back());
      const double c = load.damping(at, at), stiffness = load.stiffness(at, at);
      const double push = load.force[at] - 0.5 * step * stiffness * speed - c * speed;
      const double gained =
          step * push / (inertia + 0.5 * step * c + 0.25 * step * step * stiffness);
      places.push_back(places.back() + step * (speed + 0.5 * gained));
      speed += gained;
    }
    return places;
  }

 private:
  brick::Load load(bool turns, double place) const {
    Pose pose = pose_;
    if (turns) {
      pose.rotation = rotationFromVector({0, 0, place});
    } else {
      pose.position.x() += place;
    }
    return springs_.load(0, pose, 1);
  }

  std::vector<model::Tile> tile_;
  std::vector<brick::Brick> bricks_;
  run::TargetSprings springs_;
  Pose pose_;
};

/// x(t) of x" + 2 zeta w x' + w^2 x = 0 from rest at 1, zeta below 1.
double freeSwing(double w, double zeta, double time) {
  const double damped = w * std::sqrt(1 - zeta * zeta);
  return std::exp(-zeta * w * time) *
         (std::cos(damped * time) + zeta * w / damped * std::sin(damped * time));
}

TEST(TargetSprings, SwingABrickWithTheirFrequencyAndDecay) {
  // For any mass of the brick. Turning has the rate of decay of moving, and the frequency that
  // springs at the vertices give: w^2 sum |p'|^2 / n over the square of the radius of gyration,
  // which for n corners on a circle of radius r is r^2 (2 + cos(2 pi / n)) / 6.
  const scene::TargetSpringSettings settings{.frequency = 2.5, .dampingRatio = 0.1};
  const double w = 2 * std::numbers::pi * 2.5;
  for (const int corners : {3, 4, 6}) {
    for (const brick::BrickRule& rule : {brick::BrickRule{}, {0.1, brick::MassRule::Prism, 700}}) {
      SwingingBrick brick(corners, rule, settings);
      const std::vector<double> moved = brick.swing(false, 1, 1e-4, 10000);
      const std::vector<double> turned = brick.swing(true, 1e-4, 1e-4, 10000);
      const double ratio = std::sqrt(6 / (2 + std::cos(2 * std::numbers::pi / corners)));
      // Measured 6.0e-6, the error of the steps.
      for (std::size_t k = 0; k < moved.size(); k += 100) {
        const double time = 1e-4 * static_cast<double>(k);
        EXPECT_NEAR(moved[k], freeSwing(w, 0.1, time), 1e-5) << corners << ' ' << time;
        EXPECT_NEAR(1e4 * turned[k], freeSwing(ratio * w, 0.1 / ratio, time), 1e-5)
            << corners << ' ' << time;
      }
    }
  }
}

TEST(TargetSprings, InNewtonsHaveTheRatioOfTheirOwnStiffness) {
  scene::TargetSpringSettings settings;
  settings.springStiffness = 25;
  settings.dampingRatio = 0.2;
  const brick::Brick brick =
      brick::makeBrick(SwingingBrick::regular(4), {0.1, brick::MassRule::Prism, 700});
  const run::BrickSpring spring = run::springOf(brick, settings);
  EXPECT_EQ(spring.springStiffness, 25);
  const double w = 2 * std::numbers::pi * settings.frequency;
  EXPECT_DOUBLE_EQ(spring.torqueStiffness, brick.mass * w * w / 4);
  EXPECT_DOUBLE_EQ(spring.forceDamping, 2 * 0.2 * std::sqrt(4 * 25 * brick.mass));
  settings.torqueStiffness = 0;
  EXPECT_TRUE(run::springOf(brick, settings).torqueDamping.isZero(0));
  EXPECT_TRUE(settings.pull());
  settings.springStiffness = 0;
  EXPECT_FALSE(settings.pull());
}

}  // namespace
}  // namespace kirireel
