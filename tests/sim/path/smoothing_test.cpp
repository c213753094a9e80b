// Smoothing of a whole path. Oracles: a dense solution, distances in closed form, differences of
// gaps, and the figures of the paths.
#include "sim/path/smoothing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/path/banded_program.h"
#include "sim/path/joint_openings.h"
#include "sim/path/near_gaps.h"
#include "sim/trajectory/measures.h"

namespace kirireel {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStates = 5;
constexpr int kSize = 3;

/// A banded positive definite matrix, and the same as a dense matrix.
struct BandedExample {
  path::BandedMatrix banded;
  MatrixXd dense = MatrixXd::Zero(kStates * kSize, kStates* kSize);

  BandedExample() {
    const auto value = [](int i, int j) { return std::sin(1.7 * i + 0.6 * j * j); };
    for (int offset = 0; offset <= 2; ++offset) {
      for (int i = 0; i + offset < kStates; ++i) {
        MatrixXd block(kSize, kSize);
        for (int r = 0; r < kSize; ++r) {
          for (int c = 0; c < kSize; ++c) block(r, c) = value(7 * i + r, 5 * offset + c);
        }
        if (offset == 0)
          block = (block * block.transpose()).eval() + 9 * MatrixXd::Identity(kSize, kSize);
        dense.block((i + offset) * kSize, i * kSize, kSize, kSize) = block;
        dense.block(i * kSize, (i + offset) * kSize, kSize, kSize) = block.transpose();
        (offset == 0   ? banded.diagonal
         : offset == 1 ? banded.first
                       : banded.second)
            .push_back(block);
      }
    }
  }
};

path::BandedProgram programOf(const BandedExample& example) {
  path::BandedProgram program{example.banded, MatrixXd(kSize, kStates), {}, {}, 1};
  for (int i = 0; i < kStates; ++i) {
    for (int k = 0; k < kSize; ++k) program.gradient(k, i) = std::cos(2.0 * i + k);
    program.constraints.emplace_back(0, kSize);
    program.bounds.emplace_back(0);
  }
  return program;
}

path::BandedSolution solutionOf(const path::BandedProgram& program) {
  return path::solve(program, path::unconstrainedMinimum(program));
}

TEST(BandedProgram, WithoutConstraintsIsADenseSystem) {
  const BandedExample example;
  const path::BandedProgram program = programOf(example);
  const MatrixXd found = solutionOf(program).y;
  const VectorXd expected = example.dense.fullPivLu().solve(-program.gradient.reshaped());
  // Measured 3e-17.
  EXPECT_LT((found.reshaped() - expected).cwiseAbs().maxCoeff(), 1e-15);
}

// For one active constraint, y = y0 + H^-1 a (b - a y0) / (a H^-1 a).
TEST(BandedProgram, HoldsAConstraint) {
  const BandedExample example;
  path::BandedProgram program = programOf(example);
  VectorXd row = VectorXd::Zero(kStates * kSize);
  row.segment(2 * kSize, kSize) << 0.5, -1, 2;
  const VectorXd free = example.dense.fullPivLu().solve(-program.gradient.reshaped());
  const double bound = row.dot(free) + 0.3;
  program.constraints[2] = row.segment(2 * kSize, kSize).transpose();
  program.bounds[2] = VectorXd::Constant(1, bound);
  const VectorXd along = example.dense.fullPivLu().solve(row);
  const VectorXd expected = free + along * (0.3 / row.dot(along));
  // Measured 3e-17.
  EXPECT_LT((solutionOf(program).y.reshaped() - expected).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(BandedProgram, IgnoresSatisfiedConstraints) {
  const BandedExample example;
  path::BandedProgram program = programOf(example);
  const path::BandedSolution free = solutionOf(program);
  program.constraints[2] = MatrixXd::Ones(1, kSize);
  program.bounds[2] = VectorXd::Constant(1, free.y.col(2).sum() - 1e-3);
  const path::BandedSolution found = solutionOf(program);
  EXPECT_EQ(found.y, free.y);
  EXPECT_EQ(found.factorisations, 0);
}

// y >= 1 and -y >= 1: the smallest violation of both is at y = 0.
TEST(BandedProgram, ViolatesContradictionsAsLittleAsPossible) {
  path::BandedProgram program;
  program.hessian.diagonal = {MatrixXd::Identity(1, 1)};
  program.gradient = MatrixXd::Zero(1, 1);
  program.constraints = {(MatrixXd(2, 1) << 1, -1).finished()};
  program.bounds = {VectorXd::Ones(2)};
  program.priceScale = 1;
  EXPECT_NEAR(solutionOf(program).y(0, 0), 0, 1e-9);
}

TEST(BandedProgram, IsEmptyWithoutADefiniteHessian) {
  path::BandedProgram program;
  program.hessian.diagonal = {-MatrixXd::Identity(1, 1)};
  program.gradient = MatrixXd::Ones(1, 1);
  program.constraints = {MatrixXd(0, 1)};
  program.bounds = {VectorXd()};
  EXPECT_EQ(solutionOf(program).y.size(), 0);
}

/// A row of squares of 1 m, each joined to the next at a corner.
scene::Scene row(int squares) {
  scene::Scene scene;
  generate::TessellationShape shape;
  shape.columns = squares;
  shape.rows = 1;
  scene.model = generate::makeTessellation(shape);
  scene::fillFromModel(scene);
  return scene;
}

struct Squares {
  explicit Squares(int count)
      : scene(row(count)),
        bricks(brick::makeBricks(scene.model.tiles, scene.brick)),
        pivots(brick::makePivots(scene.model.joints, bricks)),
        start(brick::startPoses(scene.model.tiles, bricks)) {}

  scene::Scene scene;
  std::vector<brick::Brick> bricks;
  std::vector<brick::Pivot> pivots;
  Poses start;
};

TEST(NearGaps, OfAnUnjoinedPairAreItsDistance) {
  Squares squares(2);
  Poses apart = squares.start;
  apart[1].position += Vector3(0.07, 0.02, 0.001);
  path::NearGapFinder finder(squares.bricks, {}, scene::ContactFilter::All, 0.05, false,
                             squares.start);
  const std::vector<path::NearGap> found = finder.find(apart, 0.1, 1e-3);
  ASSERT_FALSE(found.empty());
  const double edge = (squares.bricks[0].bottom[1] - squares.bricks[0].bottom[0]).norm();
  const double expected = (apart[1].position - apart[0].position).x() - edge;
  for (const path::NearGap& near : found) EXPECT_NEAR(near.gap, expected, 1e-14);
  EXPECT_TRUE(finder.find(apart, 0.05, 1e-3).empty());
}

// The reach selects among the points of a pair, but never excludes its nearest point.
TEST(NearGaps, OfAnOverlapAreItsDepthForAnyReach) {
  Squares squares(2);
  Poses closer = squares.start;
  closer[1].position.x() -= 0.01;
  for (const bool isPlanar : {false, true}) {
    path::NearGapFinder finder(squares.bricks, {}, scene::ContactFilter::All, 0.05, isPlanar,
                               squares.start);
    for (const double reach : {0.0, 1e-3}) {
      const std::vector<path::NearGap> found = finder.find(closer, 0, reach);
      ASSERT_FALSE(found.empty()) << isPlanar << reach;
      for (const path::NearGap& near : found) EXPECT_NEAR(near.gap, -0.01, 1e-14);  // 1e-16
    }
  }
}

// Small moves of both bricks change the smallest gap by its derivative: central differences.
TEST(NearGaps, ChangeByTheirDerivatives) {
  Squares squares(2);
  Poses apart = squares.start;
  apart[1] = displaced(apart[1], Vector3(0.08, 0.05, 0.03), Vector3(0.2, -0.3, 0.15));
  path::NearGapFinder finder(squares.bricks, {}, scene::ContactFilter::All, 0.05, false,
                             squares.start);
  const auto least = [&](const Poses& poses) {
    return std::ranges::min(finder.find(poses, 0.5, 1e-9), {}, &path::NearGap::gap).gap;
  };
  const std::vector<path::NearGap> nearest = finder.find(apart, 0.5, 1e-9);
  ASSERT_EQ(nearest.size(), 1U);
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    Vector6 move = Vector6::Zero();
    move[k] = kStep;
    Poses more = apart, less = apart;
    more[0] = displaced(more[0], move.head<3>(), move.tail<3>());
    less[0] = displaced(less[0], -move.head<3>(), -move.tail<3>());
    // Measured 1e-10.
    EXPECT_NEAR((least(more) - least(less)) / (2 * kStep), nearest.front().ofA[k], 1e-8) << k;
  }
}

// One square is next to the other in one state and above it in the next. Between these states it
// must be apart in both directions. In a single state one direction is enough.
TEST(NearGaps, BetweenTwoSidesOfACornerAreAlongBoth) {
  Squares squares(2);
  const double edge = (squares.bricks[0].bottom[1] - squares.bricks[0].bottom[0]).norm();
  for (const bool isPlanar : {false, true}) {
    path::NearGapFinder finder(squares.bricks, {}, scene::ContactFilter::All, 0.05, isPlanar,
                               squares.start);
    const auto at = [&](double x, double y) {
      Poses poses = squares.start;
      poses[1].position = poses[0].position + Vector3(edge + x, edge + y, 0);
      return poses;
    };
    const std::array<Poses, 2> ends = {at(0.01, -0.02), at(-0.02, 0.01)};
    Vector3 smallest = Vector3::Constant(1);
    for (const path::NearGap& near : finder.findBetween(ends, at(-0.002, -0.003), 0.1, 1e-3)) {
      int axis = 0;
      EXPECT_NEAR(near.ofA.head<3>().cwiseAbs().maxCoeff(&axis), 1, 1e-14);
      smallest[axis] = std::min(smallest[axis], near.gap);
    }
    EXPECT_NEAR(smallest.x(), -0.002, 1e-14) << isPlanar;  // 4e-16
    EXPECT_NEAR(smallest.y(), -0.003, 1e-14) << isPlanar;  // 4e-16
  }
}

/// Squares in a row whose joints are open.
struct OpenSquares : Squares {
  OpenSquares() : Squares(4), joints(bricks, pivots, true), poses(start) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const double shift = 0.02 * std::sin(2.3 * static_cast<double>(i) + 1);
      poses[i].position += Vector3(shift, 0.5 * shift * shift, 0);
    }
  }

  path::JointOpenings joints;
  Poses poses;
};

TEST(JointOpenings, CostsHaveTheirDerivatives) {
  const OpenSquares squares;
  const VectorXd openings = squares.joints.openings(squares.poses);
  const double step = 1e-7;
  for (const double exponent : {2.0, 4.0, 32.0}) {
    const auto costAt = [&](const VectorXd& c) {
      return squares.joints.cost(c, exponent, 0.05, 0.1);
    };
    const path::OpeningCost cost = costAt(openings);
    for (Eigen::Index k = 0; k < openings.size(); ++k) {
      VectorXd less = openings, more = openings;
      less[k] -= step;
      more[k] += step;
      const path::OpeningCost before = costAt(less), after = costAt(more);
      // Measured 5e-13 and 2e-11.
      EXPECT_NEAR(cost.gradient[k], (after.value - before.value) / (4 * step), 1e-11);
      const VectorXd column = (after.gradient - before.gradient) / (2 * step);
      EXPECT_LT((MatrixXd(cost.hessian).col(k) - column).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(JointOpenings, ChangeByTheirJacobian) {
  const OpenSquares squares;
  const MatrixXd jacobian = squares.joints.jacobian(squares.poses);
  const double step = 1e-6;
  for (int k = 0; k < squares.joints.columns(); ++k) {
    const VectorXd move = step * VectorXd::Unit(squares.joints.columns(), k);
    const VectorXd change = squares.joints.openings(squares.joints.moved(squares.poses, move)) -
                            squares.joints.openings(squares.joints.moved(squares.poses, -move));
    // Measured 1e-10.
    EXPECT_LT((change / (2 * step) - jacobian.col(k)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

/// Two tiles with a common edge of three joints that fit each other only to `misfit` metres: the
/// second tile is longer beyond the middle one.
scene::Scene misfitPair(double misfit) {
  scene::Scene scene;
  const auto tile = [](const std::vector<std::array<double, 2>>& points) {
    model::Tile corners;
    for (const auto& [x, y] : points) corners.vertices.emplace_back(x, y, 0);
    return corners;
  };
  const double end = 2 + misfit;
  scene.model.tiles = {tile({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {0, 1}}),
                       tile({{0, 0}, {0, -1}, {end, -1}, {end, 0}, {1, 0}})};
  for (const auto& [a, b] : {std::array{0, 0}, {1, 4}, {2, 3}}) {
    model::Joint joint;
    joint.a = {0, a};
    joint.b = {1, b};
    scene.model.joints.push_back(joint);
  }
  scene::fillFromModel(scene);
  return scene;
}

// With the second tile moved by -t, the joints open by t, t and misfit - t. The largest opening is
// least at t = misfit / 2. The sum of squares is least at t = misfit / 3, where one joint opens by
// twice as much as the others.
TEST(Smoothing, OpensJointsHardlyMoreThanNecessary) {
  const double misfit = 0.03;
  const scene::Scene scene = misfitPair(misfit);
  const std::vector<brick::Brick> bricks = brick::makeBricks(scene.model.tiles, scene.brick);
  const std::vector<brick::Pivot> pivots = brick::makePivots(scene.model.joints, bricks);
  run::GeometricPath found;
  found.hasCompliantJoints = true;
  constexpr int kIntervals = 20;
  for (int k = 0; k <= kIntervals; ++k) {
    const double t = k % kIntervals == 0 ? misfit / 2 : misfit / 3;
    Poses poses = brick::startPoses(scene.model.tiles, bricks);
    for (Pose& pose : poses) pose.position += Vector3(0, 3.0 * k / kIntervals, 0);
    poses[1].position -= Vector3(t, 0, 0);
    found.path.states.push_back(poses);
  }
  found.path.lengths = run::pathLengths(bricks, found.path.states);
  found.evaluation.opening = 2 * misfit / 3;
  run::SearchBudget budget;
  const std::optional<run::MechanismPath> improved =
      path::smoothed(scene, found, scene::ContactFilter::None, budget);
  ASSERT_TRUE(improved);
  double opening = 0;
  for (const Poses& poses : improved->states) {
    opening = std::max(opening, trajectory::jointGap(pivots, poses).max);
  }
  // An exponent of 32 and no squares: 1.011. Measured 1.012.
  EXPECT_LT(opening / (misfit / 2), 1.02);
  EXPECT_GE(opening / (misfit / 2), 1 - 1e-12);
}

// Four squares in a row have three free angles: a path that goes through a kink is straightened.
TEST(Smoothing, StraightensAKink) {
  Squares squares(4);
  squares.scene.environment.contacts = scene::ContactFilter::None;
  const auto folded = [&](double first, double second) {
    Poses guide = squares.start;
    for (std::size_t i = 0; i < guide.size(); ++i) {
      const double turn = (i % 2 == 0 ? 1 : -1) * (i < 2 ? first : second);
      guide[i].rotation = Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()));
    }
    return guide;
  };
  run::SearchBudget budget;
  run::GeometricPath found;
  found.path =
      path::connect(squares.scene, {squares.start, folded(0.1, 0.5), folded(0.6, 0.6)}, budget);
  const std::optional<run::MechanismPath> improved =
      path::smoothed(squares.scene, found, scene::ContactFilter::None, budget);
  ASSERT_TRUE(improved);
  const run::MechanismPath& smooth = *improved;
  ASSERT_GT(smooth.states.size(), found.path.states.size() / 2);
  // The ends stay.
  EXPECT_EQ(smooth.states.front()[2].position, found.path.states.front()[2].position);
  EXPECT_EQ(smooth.states.back()[2].position, found.path.states.back()[2].position);
  double gap = 0, turn = 0;
  for (std::size_t k = 0; k < smooth.states.size(); ++k) {
    gap = std::max(gap, trajectory::jointGap(squares.pivots, smooth.states[k]).max);
    if (k < 2) continue;
    // The largest angle between two moves of all squares together.
    double product = 0, before = 0, after = 0;
    for (std::size_t i = 0; i < squares.bricks.size(); ++i) {
      const Vector3 come = smooth.states[k - 1][i].position - smooth.states[k - 2][i].position;
      const Vector3 go = smooth.states[k][i].position - smooth.states[k - 1][i].position;
      product += come.dot(go);
      before += come.squaredNorm();
      after += go.squaredNorm();
    }
    turn = std::max(turn, std::acos(std::min(1.0, product / std::sqrt(before * after))));
  }
  EXPECT_LT(gap, 1e-11);
  EXPECT_LT(turn, 5 * kDegree);
}

// Both squares rotate about their joint, which is one motion.
TEST(Smoothing, LeavesASingleMotionAsItIs) {
  Squares squares(2);
  Poses end = squares.start;
  end[1].rotation = Quaternion(Eigen::AngleAxisd(1, Vector3::UnitZ()));
  run::SearchBudget budget;
  run::GeometricPath found;
  found.path = path::connect(squares.scene, {squares.start, end}, budget);
  EXPECT_FALSE(path::smoothed(squares.scene, found, scene::ContactFilter::None, budget));
}

}  // namespace
}  // namespace kirireel
