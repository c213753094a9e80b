// Bars and hinges: derivatives against finite differences, closed forms, rigid motions.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

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

// A steep truss buckles sideways if l^3 = l0 y^2, with l the length of the bars, l0 that at rest
// and y the height. It is straight again at a second height. Grips hold its feet, so both states
// depend on the stiffness of constraints.
TEST(BarHingeSheets, ShowWhereASteepTrussBuckles) {
  const double b = 1, h = 3, move = 2.8, rest = std::hypot(b, h);
  statics::BarHingeModel model;
  model.nodes = {Vector3(-b, 0, 0), Vector3(b, 0, 0), Vector3(0, 0, h)};
  model.bars = {{0, 2, rest, 40}, {1, 2, rest, 40}};
  std::vector<statics::NodeGrip> grips = {{{{2}}, Vector3::UnitZ(), -move, false},
                                          {{{2}}, Vector3::UnitY(), 0, false}};
  for (const int foot : {0, 1}) {
    for (int axis = 0; axis < 3; ++axis) grips.push_back({{{foot}}, Vector3::Unit(axis), 0, false});
  }
  const mechanics::LoadPath path =
      mechanics::followLoad(statics::BarHingeSheet(model, grips), 0, {}, {});
  ASSERT_TRUE(path.arrives) << path.trouble;
  const auto heightBetween = [&](double buckled, double straight) {
    for (int round = 0; round < 60; ++round) {
      const double middle = 0.5 * (buckled + straight);
      const bool isStraight = std::pow(std::hypot(b, middle), 3) > rest * middle * middle;
      (isStraight ? straight : buckled) = middle;
    }
    return buckled;
  };
  const double first = (h - heightBetween(2, h)) / move, second = (h - heightBetween(2, 0)) / move;
  std::vector<double> found;
  for (const mechanics::Equilibrium& state : path.states) {
    if (state.turning == mechanics::Turning::Bifurcation) {
      found.push_back(state.load);
    } else {
      EXPECT_EQ(state.unstableModes, state.load > first && state.load < second) << state.load;
    }
  }
  ASSERT_EQ(found.size(), 2U);
  EXPECT_NEAR(found[0], first, 1e-6);   // measured
  EXPECT_NEAR(found[1], second, 1e-6);  // measured
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

/// The number of negative eigenvalues of the Hessian within the constraints, which are linear.
int negativesWithin(const mechanics::LoadedSheet& sheet, const Eigen::VectorXd& q) {
  const Eigen::MatrixXd J = sheet.jacobian(q);
  const Eigen::MatrixXd free = Eigen::FullPivLU<Eigen::MatrixXd>(J).kernel();
  const Eigen::MatrixXd basis = Eigen::HouseholderQR<Eigen::MatrixXd>(free).householderQ() *
                                Eigen::MatrixXd::Identity(q.size(), free.cols());
  const Eigen::MatrixXd within =
      basis.transpose() * Eigen::MatrixXd(sheet.hessian(q, 1, Eigen::VectorXd())) * basis;
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(within).eigenvalues();
  return static_cast<int>((values.array() < 0).count());
}

/// The equilibrium at the load 1, by plain Newton steps of equal length along the path on the dense
/// equations: energy, force, loads at which the load turns back, and the negative eigenvalues of
/// the Hessian within the constraints.
struct PlainEnd {
  double energy = 0;
  double force = 0;
  int negatives = 0;
  std::vector<double> limits;
};

PlainEnd plainNewton(const mechanics::LoadedSheet& sheet) {
  const int n = sheet.unknowns(), m = sheet.rows();
  const double length = 1e-3;
  const Eigen::MatrixXd J = sheet.jacobian(sheet.startCoordinates());
  // The coordinates, the multipliers, and the load.
  Eigen::VectorXd now = Eigen::VectorXd::Zero(n + m + 1);
  now.head(n) = sheet.startCoordinates();
  // Newton's method; the last row keeps the product with a direction.
  const auto close = [&](Eigen::VectorXd& at, const Eigen::VectorXd& direction) {
    for (int round = 0; round < 20; ++round) {
      const Eigen::VectorXd q = at.head(n), multipliers = at.segment(n, m);
      Eigen::VectorXd right = Eigen::VectorXd::Zero(n + m + 1);
      right.head(n) = -(sheet.gradient(q, at[n + m]) + J.transpose() * multipliers);
      right.segment(n, m) = -sheet.residual(q, at[n + m]);
      if (right.norm() < 1e-9) return true;
      Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + m + 1, n + m + 1);
      whole.topLeftCorner(n, n) = Eigen::MatrixXd(sheet.hessian(q, at[n + m], multipliers));
      whole.block(0, n, n, m) = J.transpose();
      whole.block(n, 0, m, n) = J;
      whole.col(n + m).head(n) = -sheet.pull(q);
      whole.col(n + m).segment(n, m) = -sheet.motion();
      whole.row(n + m) = direction;
      at += whole.partialPivLu().solve(right);
    }
    return false;
  };
  Eigen::VectorXd direction = Eigen::VectorXd::Unit(n + m + 1, n + m);  // keeps the load
  PlainEnd end;
  Eigen::VectorXd last = now;
  last[n + m] = length;
  EXPECT_TRUE(close(last, direction));
  std::swap(now, last);
  for (int step = 0; step < 10000 && now[n + m] < 1; ++step) {
    Eigen::VectorXd along = now - last;
    direction = along;
    direction.segment(n, m).setZero();
    along *= length / direction.norm();
    last = now;
    now += along;
    EXPECT_TRUE(close(now, direction));
    if ((now[n + m] - last[n + m]) * along[n + m] < 0) end.limits.push_back(last[n + m]);
  }
  now += (1 - now[n + m]) / (now[n + m] - last[n + m]) * (now - last);
  EXPECT_TRUE(close(now, Eigen::VectorXd::Unit(n + m + 1, n + m)));
  const Eigen::VectorXd q = now.head(n), multipliers = now.segment(n, m);
  end.energy = sheet.energy(q);
  end.force = sheet.force(0, 1, multipliers);
  end.negatives = negativesWithin(sheet, q);
  return end;
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

/// Twelve triangles of random shape and height between twelve nodes. An inner node is pressed down.
struct RandomSheet {
  explicit RandomSheet(unsigned seed) {
    std::mt19937 random(seed);
    const auto jitter = [&](double size) {
      return size * (static_cast<double>(random()) / static_cast<double>(random.max()) - 0.5);
    };
    for (int k = 0; k < 12; ++k) {
      const double x = k % 4 + jitter(0.5), y = k / 4 + jitter(0.5);
      model.nodes.emplace_back(x, y, jitter(0.3));
    }
    std::map<std::pair<int, int>, std::vector<int>> opposite;  // nodes, of each edge
    for (const int corner : {0, 1, 2, 4, 5, 6}) {
      const bool isRising = random() % 2 == 0;
      const std::array<int, 4> c = {corner, corner + 1, corner + 5, corner + 4};
      for (const std::array<int, 3>& t : {std::array{c[0], c[1], c[isRising ? 2 : 3]},
                                          std::array{c[isRising ? 0 : 1], c[2], c[3]}}) {
        for (std::size_t k = 0; k < 3; ++k)
          opposite[std::minmax(t[k], t[(k + 1) % 3])].push_back(t[(k + 2) % 3]);
      }
    }
    const auto node = [&](int k) { return model.nodes[static_cast<std::size_t>(k)]; };
    for (const auto& [edge, others] : opposite) {
      const auto [i, j] = edge;
      const double length = (node(j) - node(i)).norm();
      model.bars.push_back({i, j, length, 2e4 / length});
      if (others.size() < 2) continue;
      const double rest = statics::foldAngle({node(i), node(j), node(others[0]), node(others[1])});
      model.folds.push_back({{i, j, others[0], others[1]}, 0.05, rest});
    }
    grips.push_back({{{5}}, Vector3::UnitZ(), -0.3, false});
    for (const int held : {0, 3, 8}) grips.push_back({{{held}}, Vector3::UnitZ(), 0, false});
    for (const int held : {0, 3}) grips.push_back({{{held}}, Vector3::UnitY(), 0, false});
    grips.push_back({{{0}}, Vector3::UnitX(), 0, false});
  }
  statics::BarHingeSheet sheet() const { return {model, grips}; }

  statics::BarHingeModel model;
  std::vector<statics::NodeGrip> grips;
};

// Sheet 6 turns back twice: at the loads 0.7235 and 0.1055.
TEST(BarHingeSheets, OfRandomShapeHaveOnePathForAnyNumberOfStates) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const RandomSheet random(seed);
    const PlainEnd expected = plainNewton(random.sheet());
    for (const int states : {1, 10, 100}) {
      const mechanics::LoadPath path =
          mechanics::followLoad(random.sheet(), 0, {.minStates = states}, {});
      ASSERT_TRUE(path.arrives) << path.trouble << seed;
      const mechanics::Equilibrium& end = path.states.back();
      EXPECT_NEAR(end.energy / expected.energy, 1, 1e-10) << seed;   // measured 2e-14
      EXPECT_NEAR(end.forces[0] / expected.force, 1, 1e-7) << seed;  // measured 2e-9
      EXPECT_EQ(end.unstableModes, expected.negatives) << seed;
      std::vector<double> limits;
      for (const mechanics::Equilibrium& state : path.states) {
        if (state.turning == mechanics::Turning::LoadLimit) limits.push_back(state.load);
      }
      ASSERT_EQ(limits.size(), expected.limits.size()) << seed;
      for (std::size_t k = 0; k < limits.size(); ++k) {
        EXPECT_NEAR(limits[k], expected.limits[k], 2e-4) << seed;  // measured 8e-5
      }
    }
  }
}

/// A storey of a Kresling tower: a ring of triangles between two polygons. The lower one is held,
/// the upper one is pressed down.
statics::BarHingeSheet storey(int sides, double twist, double press) {
  statics::BarHingeModel model;
  for (const double level : {0.0, 1.0}) {
    for (int k = 0; k < sides; ++k) {
      const double angle = 2 * std::numbers::pi * k / sides + level * twist;
      model.nodes.emplace_back(std::cos(angle), std::sin(angle), level);
    }
  }
  const auto node = [&](int k) { return model.nodes[static_cast<std::size_t>(k)]; };
  const auto addBar = [&](int a, int b) {
    const double length = (node(b) - node(a)).norm();
    model.bars.push_back({a, b, length, 5e3 / length});
  };
  const auto addFold = [&](int a, int b, int left, int right) {
    const double rest = statics::foldAngle({node(a), node(b), node(left), node(right)});
    model.folds.push_back({{a, b, left, right}, 0.05, rest});
  };
  for (int k = 0; k < sides; ++k) {
    const int next = (k + 1) % sides, up = sides + k, nextUp = sides + next;
    for (const auto& [a, b] : {std::pair(k, next), {up, nextUp}, {k, up}, {next, up}}) addBar(a, b);
    addFold(next, up, k, nextUp);
    addFold(k, up, sides + (k + sides - 1) % sides, next);
  }
  std::vector<statics::NodeGrip> grips;
  for (int k = 0; k < sides; ++k) {
    model.fixed.push_back(k);
    grips.push_back({{{sides + k}}, Vector3::UnitZ(), -press, false});
  }
  return {std::move(model), std::move(grips)};
}

// The count of unstable modes is that of the stiffness within the constraints, and no change of it
// is without a row.
TEST(BarHingeSheets, ReportEachChangeOfStability) {
  int changes = 0;
  const auto expectRows = [&](const statics::BarHingeSheet& sheet) {
    const mechanics::LoadPath path = mechanics::followLoad(sheet, 0, {.minStates = 60}, {});
    ASSERT_TRUE(path.arrives) << path.trouble;
    const mechanics::Equilibrium* last = &path.states.front();
    bool isReported = true;
    for (const mechanics::Equilibrium& state : path.states) {
      isReported |= state.turning != mechanics::Turning::None;
      if (state.turning != mechanics::Turning::None) continue;
      EXPECT_EQ(state.unstableModes, negativesWithin(sheet, state.coordinates)) << state.load;
      if (state.unstableModes != last->unstableModes) {
        EXPECT_TRUE(isReported) << last->load << " to " << state.load;
        ++changes;
      }
      last = &state;
      isReported = false;
    }
  };
  for (const double twist : {0.5, 0.8}) expectRows(storey(6, twist, 0.6));
  expectRows(storey(5, 0.6, 0.7));
  expectRows(Waterbomb(0.1).sheet());
  for (unsigned seed = 1; seed <= 10; ++seed) expectRows(RandomSheet(seed).sheet());
  EXPECT_GT(changes, 10);
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
