// Bars and hinges: derivatives against finite differences, closed forms, rigid motions.
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/mechanics/load_path.h"
#include "sim/statics/bar_hinge_sheet.h"

namespace kirireel {
namespace {

/// Two triangles about the y axis, folded by an angle; neither is isosceles.
statics::FoldPoints valley(double angle) {
  return {Vector3(0, 0, 0), Vector3(0, 2, 0), Vector3(-1.5, 0.7, 0),
          Vector3(1.1 * std::cos(angle), 1.4, 1.1 * std::sin(angle))};
}

TEST(Folds, HaveTheAngleOfFold) {
  for (const double angle : {-3.0, -1.2, -1e-9, 0.0, 0.4, 1.7, 3.1}) {
    EXPECT_NEAR(statics::foldAngle(valley(angle)), angle, 1e-14);
  }
}

TEST(Folds, HaveTheDerivativesOfTheirAngle) {
  const double h = 1e-5;
  for (const double angle : {-2.8, -1.0, 0.0, 0.6, 2.2}) {
    const statics::FoldPoints points = valley(angle);
    const Vector12 slope = statics::foldSlope(points);
    const Matrix12 bend = statics::foldBend(points);
    EXPECT_LT((bend - bend.transpose()).norm(), 1e-13);
    for (int k = 0; k < 12; ++k) {
      statics::FoldPoints more = points, less = points;
      more[static_cast<std::size_t>(k / 3)][k % 3] += h;
      less[static_cast<std::size_t>(k / 3)][k % 3] -= h;
      EXPECT_NEAR(slope[k], (statics::foldAngle(more) - statics::foldAngle(less)) / (2 * h), 1e-9);
      EXPECT_LT(
          (bend.col(k) - (statics::foldSlope(more) - statics::foldSlope(less)) / (2 * h)).norm(),
          1e-8);
    }
  }
}

/// The two triangles with bars at their edges and a fold; the left one stays.
statics::BarHingeModel flap(double angle, double stiffness) {
  statics::BarHingeModel model;
  const statics::FoldPoints points = valley(angle);
  model.nodes.assign(points.begin(), points.end());
  for (const auto& [a, b] : {std::pair(0, 1), {0, 2}, {1, 2}, {0, 3}, {1, 3}}) {
    const double length =
        (model.nodes[static_cast<std::size_t>(b)] - model.nodes[static_cast<std::size_t>(a)])
            .norm();
    model.bars.push_back({a, b, length, 50});
  }
  model.folds = {{{0, 1, 2, 3}, stiffness, angle}};
  model.fixed = {0, 1, 2};
  model.tiles = {{0, 1, 2}, {1, 0, 3}};
  model.start = Poses(2);
  return model;
}

TEST(BarHingeSheets, HaveTheDerivativesOfTheirEnergy) {
  const statics::BarHingeSheet sheet(flap(0.5, 0.7), {{{{3}}, Vector3::UnitZ(), 2, true}});
  const mechanics::LoadedSheet::Vector start = sheet.startCoordinates();
  mechanics::LoadedSheet::Vector q = start;
  for (Eigen::Index k = 0; k < q.size(); ++k) q[k] += 0.1 * std::sin(3.7 * static_cast<double>(k));
  const double h = 1e-5, load = 0.3;
  const auto total = [&](const mechanics::LoadedSheet::Vector& at) {
    return sheet.energy(at) - load * sheet.pull(at).dot(at - start);
  };
  const mechanics::LoadedSheet::Vector slope = sheet.gradient(q, load), none;
  const Eigen::MatrixXd bend = sheet.hessian(q, load, none);
  for (Eigen::Index k = 0; k < q.size(); ++k) {
    mechanics::LoadedSheet::Vector more = q, less = q;
    more[k] += h;
    less[k] -= h;
    EXPECT_NEAR(slope[k], (total(more) - total(less)) / (2 * h), 1e-7);
    const mechanics::LoadedSheet::Vector change =
        (sheet.gradient(more, load) - sheet.gradient(less, load)) / (2 * h);
    EXPECT_LT((bend.col(k) - change).norm(), 1e-6);
  }
}

TEST(BarHingeSheets, HaveNoEnergyFromRigidMotions) {
  const statics::BarHingeSheet sheet(flap(0.5, 0.7), {});
  mechanics::LoadedSheet::Vector q = sheet.startCoordinates();
  const Quaternion turn(Eigen::AngleAxisd(1.3, Vector3(1, 2, -1).normalized()));
  for (Eigen::Index k = 0; k < q.size(); k += 3) {
    q.segment<3>(k) = (turn * q.segment<3>(k) + Vector3(3, -2, 5)).eval();
  }
  EXPECT_NEAR(sheet.energy(q), 0, 1e-24);
  EXPECT_LT(sheet.gradient(q, 0).norm(), 1e-11);
}

// A flap that is lifted at its tip turns by M = F r. With stiff bars, the height r sin(angle) needs
// F = k (angle - rest) / (r cos(angle)).
TEST(BarHingeSheets, FollowAFlapThatIsLifted) {
  statics::BarHingeModel model = flap(0.2, 0.7);
  for (statics::Bar& bar : model.bars) bar.stiffness = 1e6;
  const double r = 1.1, rise = r * (std::sin(1.1) - std::sin(0.2));
  const statics::BarHingeSheet sheet(model, {{{{3}}, Vector3::UnitZ(), rise, false}});
  const mechanics::LoadPath path = mechanics::followLoad(sheet, 0, {}, {});
  EXPECT_TRUE(path.arrives) << path.trouble;
  for (const mechanics::Equilibrium& state : path.states) {
    const double angle = std::asin(std::sin(0.2) + state.displacements[0] / r);
    const double force = 0.7 * (angle - 0.2) / (r * std::cos(angle));
    EXPECT_NEAR(state.forces[0], force, 1e-5 * force + 1e-6);  // bars stretch by F / 1e6
    EXPECT_NEAR(state.energy, 0.35 * (angle - 0.2) * (angle - 0.2), 2e-6);
  }
  const Quaternion turned = path.states.back().poses[1].rotation;
  EXPECT_NEAR(2 * std::acos(turned.w()), 0.9, 1e-5);
}

/// Two bars as a shallow roof of half the span b and the height h, with a force at the top: von
/// Mises' truss snaps through, F = 2 k y (1 - l0 / l).
TEST(BarHingeSheets, SnapThroughLikeVonMisesTruss) {
  const double b = 1, h = 0.3, stiffness = 40, rest = std::hypot(b, h);
  statics::BarHingeModel model;
  model.nodes = {Vector3(-b, 0, 0), Vector3(b, 0, 0), Vector3(0, 0, h)};
  model.bars = {{0, 2, rest, stiffness}, {1, 2, rest, stiffness}};
  model.fixed = {0, 1};
  const std::vector<statics::NodeGrip> grips = {{{{2}}, Vector3::UnitZ(), -2 * h, false},
                                                {{{2}}, Vector3::UnitX(), 0, false},
                                                {{{2}}, Vector3::UnitY(), 0, false}};
  const statics::BarHingeSheet sheet(model, grips);
  const mechanics::LoadPath path = mechanics::followLoad(sheet, 0, {}, {});
  EXPECT_TRUE(path.arrives) << path.trouble;
  const auto force = [&](double y) { return 2 * stiffness * y * (1 - rest / std::hypot(b, y)); };
  const double snap = std::sqrt(std::pow(rest * b * b, 2.0 / 3) - b * b);
  double largest = 0;
  for (const mechanics::Equilibrium& state : path.states) {
    EXPECT_NEAR(state.forces[0], force(h + state.displacements[0]), 1e-10);
    if (state.turning == mechanics::Turning::ForceLimit)
      largest = std::max(largest, -state.forces[0]);
  }
  EXPECT_NEAR(largest, -force(snap), 1e-10);
  EXPECT_NEAR(path.states.back().energy, 0, 1e-14);
}

/// Eight triangles around a raised vertex, pressed by 0.8 m through the plane of their rims: a
/// waterbomb, whose bars are 1e8 times stiffer than its folds.
struct Waterbomb {
  explicit Waterbomb(double fold) {
    model.nodes = {Vector3(0, 0, 0.35)};
    for (int k = 0; k < 8; ++k) {
      const double angle = std::numbers::pi * k / 4;
      model.nodes.emplace_back(std::cos(angle), std::sin(angle), k % 2 == 0 ? 0.12 : -0.12);
    }
    const auto length = [&](int a, int b) {
      return (model.nodes[static_cast<std::size_t>(b)] - model.nodes[static_cast<std::size_t>(a)])
          .norm();
    };
    for (int k = 0; k < 8; ++k) {
      const int a = 1 + k, b = 1 + (k + 1) % 8, before = 1 + (k + 7) % 8;
      model.bars.push_back({0, a, length(0, a), 4e4});
      model.bars.push_back({a, b, length(a, b), 3e4});
      model.folds.push_back({{0, a, b, before}, fold, 0});
      const std::array<int, 4>& nodes = model.folds.back().nodes;
      model.folds.back().rest =
          statics::foldAngle({model.nodes[static_cast<std::size_t>(nodes[0])],
                              model.nodes[static_cast<std::size_t>(nodes[1])],
                              model.nodes[static_cast<std::size_t>(nodes[2])],
                              model.nodes[static_cast<std::size_t>(nodes[3])]});
    }
    grips.push_back({{{0}}, Vector3::UnitZ(), -0.8, false});
    for (const int node : {2, 4, 6, 8}) grips.push_back({{{node}}, Vector3::UnitZ(), 0, false});
    grips.push_back({{{1}}, Vector3::UnitY(), 0, false});
    grips.push_back({{{5}}, Vector3::UnitY(), 0, false});
    grips.push_back({{{3}}, Vector3::UnitX(), 0, false});
  }
  statics::BarHingeSheet sheet() const { return {model, grips}; }

  statics::BarHingeModel model;
  std::vector<statics::NodeGrip> grips;
};

/// The equilibrium at the load 1, by plain Newton steps at 1500 fixed loads on the dense equations:
/// energy, force, and the negative eigenvalues of the Hessian within the constraints.
struct PlainEnd {
  double energy = 0;
  double force = 0;
  int negatives = 0;
};

PlainEnd plainNewton(const mechanics::LoadedSheet& sheet) {
  const int n = sheet.unknowns(), m = sheet.rows();
  Eigen::VectorXd q = sheet.startCoordinates(), before = q;
  Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(m);
  const Eigen::MatrixXd J = sheet.jacobian(q);
  const int steps = 1500;
  for (int step = 0; step <= steps; ++step) {
    const double load = static_cast<double>(step) / steps;
    const Eigen::VectorXd guess = 2 * q - before;
    before = q;
    q = guess;
    for (int round = 0; round < 20; ++round) {
      Eigen::VectorXd right(n + m);
      right << -(sheet.gradient(q, load) + J.transpose() * multipliers), -sheet.residual(q, load);
      if (right.norm() < 1e-9) break;
      Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + m, n + m);
      whole.topLeftCorner(n, n) = Eigen::MatrixXd(sheet.hessian(q, load, multipliers));
      whole.topRightCorner(n, m) = J.transpose();
      whole.bottomLeftCorner(m, n) = J;
      const Eigen::VectorXd change = whole.partialPivLu().solve(right);
      q += change.head(n);
      multipliers += change.tail(m);
    }
  }
  const Eigen::MatrixXd free = Eigen::FullPivLU<Eigen::MatrixXd>(J).kernel();
  const Eigen::MatrixXd basis = Eigen::HouseholderQR<Eigen::MatrixXd>(free).householderQ() *
                                Eigen::MatrixXd::Identity(n, free.cols());
  const Eigen::MatrixXd within =
      basis.transpose() * Eigen::MatrixXd(sheet.hessian(q, 1, multipliers)) * basis;
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(within).eigenvalues();
  return {sheet.energy(q), sheet.force(0, 1, multipliers),
          static_cast<int>((values.array() < 0).count())};
}

// Steps to an arbitrary equilibrium jump to a branch of 450 times the energy here.
TEST(BarHingeSheets, StayOnTheirBranchAsAWaterbombIsPressedThrough) {
  for (const double fold : {0.1, 0.02}) {
    const Waterbomb bomb(fold);
    const PlainEnd expected = plainNewton(bomb.sheet());
    for (const int states : {1, 60}) {
      const mechanics::LoadPath path =
          mechanics::followLoad(bomb.sheet(), 0, {.minStates = states}, {});
      ASSERT_TRUE(path.arrives) << path.trouble;
      const mechanics::Equilibrium& end = path.states.back();
      EXPECT_NEAR(end.energy, expected.energy, 1e-7 * expected.energy) << fold;
      EXPECT_NEAR(end.forces[0], expected.force, 1e-6 * std::abs(expected.force)) << fold;
      EXPECT_EQ(end.unstableModes, expected.negatives);
    }
  }
}

// A thousand sizes from the origin, coordinates of positions would lose three digits that bars
// need.
TEST(BarHingeSheets, FollowTheSamePathFarFromTheOrigin) {
  const Waterbomb near(0.1);
  Waterbomb far = near;
  for (Vector3& node : far.model.nodes) node += Vector3(1234.5, -987.6, 543.2);
  const mechanics::LoadPath path = mechanics::followLoad(near.sheet(), 0, {}, {});
  const mechanics::LoadPath moved = mechanics::followLoad(far.sheet(), 0, {}, {});
  ASSERT_TRUE(path.arrives) << path.trouble;
  ASSERT_TRUE(moved.arrives) << moved.trouble;
  const mechanics::Equilibrium &a = path.states.back(), &b = moved.states.back();
  EXPECT_NEAR(b.energy / a.energy, 1, 1e-7);        // measured 2e-13
  EXPECT_NEAR(b.forces[0] / a.forces[0], 1, 1e-7);  // measured 2e-13
}

}  // namespace
}  // namespace kirireel
