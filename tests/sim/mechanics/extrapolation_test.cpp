// Steps to a tolerance in time against known motions: equations of motion in one or two angles,
// integrated by another method with much shorter steps.
#include "sim/mechanics/extrapolation.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "sim/trajectory/measures.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

constexpr double kLongest = 1.0 / 60;

/// Loads that do not depend on time.
mechanics::TimedLoads timeless(const mechanics::LoadSource& loads) {
  return [loads](double, const Poses& poses, std::vector<brick::Load>& out) { loads(poses, out); };
}

/// Steps to a tolerance without contacts.
struct Stepping {
  Stepping(JoinedBricks& moving, bool planar, double tolerance)
      : bricks(moving),
        solver(moving.solver(planar)),
        extrapolation(moving.bricks, *solver,
                      {.tolerance = tolerance,
                       .longestStep = kLongest,
                       .lengthScale = model::tileSize(moving.model)}) {}
  Stepping(const Stepping&) = delete;
  Stepping& operator=(const Stepping&) = delete;

  void advance(double seconds, const mechanics::TimedLoads& loads) {
    double done = 0;
    while (done < seconds * (1 - 1e-9)) {
      const double begin = done;
      const auto taken = extrapolation.step(
          bricks.motion, seconds - done,
          [&](double after, const Poses& poses, std::vector<brick::Load>& out) {
            loads(begin + after, poses, out);
          },
          {}, report);
      ASSERT_TRUE(taken.has_value());
      done += *taken;
      ++steps;
    }
  }

  JoinedBricks& bricks;
  std::unique_ptr<mechanics::JointSolver> solver;
  mechanics::Extrapolation extrapolation;
  StepReport report;
  int steps = 0;
};

/// One step of the classical Runge-Kutta method for y' = f(y).
template <std::size_t N, typename Function>
std::array<double, N> rungeKutta(const std::array<double, N>& y, double h, const Function& f) {
  const auto plus = [](std::array<double, N> sum, double part, const std::array<double, N>& more) {
    for (std::size_t k = 0; k < N; ++k) sum[k] += part * more[k];
    return sum;
  };
  const auto k1 = f(y);
  const auto k2 = f(plus(y, h / 2, k1));
  const auto k3 = f(plus(y, h / 2, k2));
  const auto k4 = f(plus(y, h, k3));
  return plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
}

/// The slope of log(error) over log(tolerance), by least squares.
double slopeOf(const std::vector<double>& tolerances, const std::vector<double>& errors) {
  const double count = static_cast<double>(errors.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const double a = std::log(tolerances[k]), b = std::log(errors[k]);
    x += a, y += b, xx += a * a, xy += a * b;
  }
  return (count * xy - x * y) / (count * xx - x * x);
}

const std::vector<double> kTolerances = {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7};

/// A sheet of squares as a mechanism of one angle: the centre of tile i is
///   x_i = a_i cos(theta / 2) + b_i sin(theta / 2),
/// it turns by -theta/2 or +theta/2, and (M omega)' - M' omega^2 / 2 = Q for M = sum m x'^2 + I /
/// 4.
class OneAngleSheet {
 public:
  OneAngleSheet(const JoinedBricks& sheet, int side, double startAngle,
                const mechanics::LoadSource& loads)
      : sheet_(sheet), side_(side), startAngle_(startAngle), loads_(loads), angle_{startAngle, 0} {
    generate::TessellationShape shape;
    shape.columns = shape.rows = side;
    const std::vector<model::Tile> flat = generate::tessellationTiles(shape, 0);
    const std::vector<model::Tile> open = generate::tessellationTiles(shape, std::numbers::pi / 2);
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const Vector3 a = meanPoint(flat[i].vertices);
      a_.push_back(a);
      b_.push_back(std::sqrt(2.0) * meanPoint(open[i].vertices) - a);
    }
  }

  void advance(double seconds) {
    const int count = static_cast<int>(std::lround(seconds / 5e-5));
    for (int k = 0; k < count; ++k) {
      angle_ = rungeKutta<2>(angle_, seconds / count, [this](const std::array<double, 2>& y) {
        return std::array<double, 2>{y[1], acceleration(y[0], y[1])};
      });
    }
  }

  Poses poses() const { return posesAt(angle_[0]); }

 private:
  double sign(std::size_t i) const {
    const int column = static_cast<int>(i) % side_, row = static_cast<int>(i) / side_;
    return (column + row) % 2 == 0 ? -0.5 : 0.5;
  }
  Vector3 along(std::size_t i, double angle) const {
    return 0.5 * (b_[i] * std::cos(angle / 2) - a_[i] * std::sin(angle / 2));
  }
  Poses posesAt(double angle) const {
    Poses poses = sheet_.motion.poses;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const Vector3 centre = a_[i] * std::cos(angle / 2) + b_[i] * std::sin(angle / 2);
      poses[i].position.head<2>() = centre.head<2>();
      poses[i].rotation = rotationFromVector(Vector3(0, 0, sign(i) * (angle - startAngle_)));
    }
    return poses;
  }
  double acceleration(double angle, double rate) {
    loads_(posesAt(angle), scratch_ = std::vector<brick::Load>(a_.size()));
    double mass = 0, massSlope = 0, force = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const brick::Brick& brick = sheet_.bricks[i];
      const Vector3 direction = along(i, angle);
      const Vector3 bend = -0.25 * (a_[i] * std::cos(angle / 2) + b_[i] * std::sin(angle / 2));
      mass += brick.mass * direction.squaredNorm() + brick.inertia(2, 2) / 4;
      massSlope += 2 * brick.mass * direction.dot(bend);
      Vector6 move;
      move << direction, Vector3(0, 0, sign(i));
      force += move.dot(scratch_[i].force - scratch_[i].damping * (rate * move));
    }
    return (force - 0.5 * massSlope * rate * rate) / mass;
  }

  const JoinedBricks& sheet_;
  int side_;
  double startAngle_;
  mechanics::LoadSource loads_;
  std::array<double, 2> angle_;
  std::vector<Vector3> a_, b_;
  std::vector<brick::Load> scratch_;
};

double farthest(const JoinedBricks& bricks, const Poses& expected) {
  return trajectory::targetError(brick::bottomTiles(bricks.bricks, expected), bricks.bricks,
                                 bricks.motion.poses);
}

class SheetOfSquares : public testing::TestWithParam<int> {};

TEST_P(SheetOfSquares, FollowsItsEquationOfMotionToTheTolerance) {
  const int side = GetParam();
  const double start = 5 * kDegree;
  std::vector<double> errors;
  for (const double tolerance : kTolerances) {
    JoinedBricks sheet(test::openSheet(side, start));
    const JoinedBricks still = sheet;
    const run::TargetSprings springs(sheet.bricks, *sheet.model.target, {}, {});
    const mechanics::LoadSource loads = test::springLoads(still, springs, {});
    OneAngleSheet exact(still, side, start, loads);
    ASSERT_LT(farthest(sheet, exact.poses()), 1e-12);
    Stepping stepping(sheet, true, tolerance);
    double error = 0;
    for (int k = 0; k < 5; ++k) {
      stepping.advance(0.1, timeless(loads));
      exact.advance(0.1);
      error = std::max(error, farthest(sheet, exact.poses()));
      EXPECT_LT(trajectory::jointGap(sheet.pivots, sheet.motion.poses).max,
                1e-11);  // measured 1e-12
    }
    EXPECT_LT(error, 10 * tolerance);  // measured 0.1 to 0.9 times
    errors.push_back(error);
  }
  const double slope = slopeOf(kTolerances, errors);
  EXPECT_GT(slope, 0.8);  // measured 0.97 and 1.04
  EXPECT_LT(slope, 1.2);
}

INSTANTIATE_TEST_SUITE_P(Of, SheetOfSquares, testing::Values(4, 10));

/// Three squares in a chain, the first to be pinned: a double pendulum at 45 degrees.
JoinedBricks chainOfSquares() {
  model::Model model;
  for (const double at : {0.0, 1.0, 2.0}) {
    const Vector3 low(at, at, 0);
    model.tiles.push_back(
        {{low, low + Vector3(1, 0, 0), low + Vector3(1, 1, 0), low + Vector3(0, 1, 0)}});
  }
  model.joints = {{{0, 2}, {1, 0}}, {{1, 2}, {2, 0}}};
  return JoinedBricks(model, 0.02);
}

/// The angles a and b of both pendulums from the x axis and their rates: with d from a joint to a
/// centre and L from joint to joint,
///   (I + m d^2 + m L^2) a" + m L d cos(a - b) b" = -m L d sin(a - b) b'^2 + m (d + L) g.n(a),
///   m L d cos(a - b) a" + (I + m d^2) b" = m L d sin(a - b) a'^2 + m d g.n(b).
std::array<double, 4> doublePendulum(const std::array<double, 4>& y, const brick::Brick& brick,
                                     const Vector3& gravity) {
  const double d = std::sqrt(0.5), length = 2 * d, m = brick.mass, inertia = brick.inertia(2, 2);
  const auto pull = [&](double angle) {
    return gravity.y() * std::cos(angle) - gravity.x() * std::sin(angle);
  };
  const double across = m * length * d * std::cos(y[0] - y[1]);
  const double whirl = m * length * d * std::sin(y[0] - y[1]);
  Eigen::Matrix2d masses;
  masses << inertia + m * (d * d + length * length), across, across, inertia + m * d * d;
  const Eigen::Vector2d forces(-whirl * y[3] * y[3] + m * (d + length) * pull(y[0]),
                               whirl * y[2] * y[2] + m * d * pull(y[1]));
  const Eigen::Vector2d rates = masses.inverse() * forces;
  return {y[2], y[3], rates[0], rates[1]};
}

TEST(DoublePendulum, FollowsItsEquationsOfMotionToTheTolerance) {
  const Vector3 gravity = 9.81 * Vector3(std::cos(-0.25), std::sin(-0.25), 0);
  const mechanics::LoadSource weight = [&](const Poses&, std::vector<brick::Load>& loads) {
    std::fill(loads.begin(), loads.end(), brick::Load{});
    for (brick::Load& load : loads) load.force.head<3>() = gravity;  // every mass is 1
  };
  std::vector<double> errors;
  for (const double tolerance : kTolerances) {
    JoinedBricks chain = chainOfSquares();
    const brick::Brick brick = chain.bricks[1];
    Stepping stepping(chain, true, tolerance);
    stepping.solver->setPinned({true, false, false});
    stepping.extrapolation.setSupported(true);
    std::array<double, 4> exact = {45 * kDegree, 45 * kDegree, 0, 0};
    double error = 0;
    for (int k = 0; k < 50; ++k) {
      stepping.advance(0.1, timeless(weight));
      for (int n = 0; n < 500; ++n) {
        exact = rungeKutta<4>(exact, 2e-4, [&](const std::array<double, 4>& y) {
          return doublePendulum(y, brick, gravity);
        });
      }
      const Vector3 end(1 + std::sqrt(2.0) * (std::cos(exact[0]) + 0.5 * std::cos(exact[1])),
                        1 + std::sqrt(2.0) * (std::sin(exact[0]) + 0.5 * std::sin(exact[1])), 0);
      const Vector3 off = chain.motion.poses[2].position - end;
      error = std::max(error, off.head<2>().norm());
    }
    EXPECT_LT(error, 10 * tolerance) << tolerance;  // measured 0.1 to 0.6 times
    errors.push_back(error);
  }
  const double slope = slopeOf(kTolerances, errors);
  EXPECT_GT(slope, 0.8);  // measured 0.97
  EXPECT_LT(slope, 1.2);
}

double kineticEnergy(const JoinedBricks& bricks) {
  double sum = 0;
  for (std::size_t i = 0; i < bricks.bricks.size(); ++i) {
    const auto& [linear, angular] = bricks.motion.velocities[i];
    const Vector3 spin = bricks.motion.poses[i].rotation.conjugate() * angular;
    sum += 0.5 * bricks.bricks[i].mass * linear.squaredNorm() +
           0.5 * spin.dot(bricks.bricks[i].inertia * spin);
  }
  return sum;
}

Vector3 angularMomentum(const JoinedBricks& bricks) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bricks.bricks.size(); ++i) {
    const auto& [position, rotation] = bricks.motion.poses[i];
    const auto& [linear, angular] = bricks.motion.velocities[i];
    sum += bricks.bricks[i].mass * position.cross(linear) +
           rotation * (bricks.bricks[i].inertia * (rotation.conjugate() * angular));
  }
  return sum;
}

/// A brick of 3 x 1 x 0.02 that spins about its middle axis, which is unstable.
JoinedBricks spinningBrick() {
  model::Model model;
  model.tiles = {{{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {0, 1, 0}}}};
  JoinedBricks bricks(model, 0.02);
  bricks.motion.velocities[0].angular = Vector3(0.3, 3.3, 0.1);
  return bricks;
}

TEST(FreeBrick, KeepsItsEnergyAndItsMomentum) {
  JoinedBricks brick = spinningBrick();
  const double energy = kineticEnergy(brick);
  const Vector3 momentum = angularMomentum(brick);
  Stepping(brick, false, 1e-6).advance(60, timeless(test::noLoads));
  EXPECT_NEAR(kineticEnergy(brick), energy, 1e-4 * energy);                        // measured 4e-6
  EXPECT_LT((angularMomentum(brick) - momentum).norm(), 1e-12 * momentum.norm());  // measured 2e-14
}

/// Of the angular velocity of a free brick (Landau and Lifshitz, Mechanics, 1976, 37), seconds.
double tumblingPeriod(Vector3 inertia, const Vector3& spin) {
  const double twiceEnergy = inertia.dot(spin.cwiseAbs2());
  const double square = inertia.cwiseProduct(spin).squaredNorm();
  std::sort(inertia.begin(), inertia.end());
  if (square < twiceEnergy * inertia[1]) std::swap(inertia[0], inertia[2]);
  const double fast = (inertia[2] - inertia[1]) * (square - twiceEnergy * inertia[0]);
  const double slow = (inertia[1] - inertia[0]) * (twiceEnergy * inertia[2] - square);
  return 4 * std::comp_ellint_1(std::sqrt(slow / fast)) * std::sqrt(inertia.prod() / fast);
}

TEST(FreeBrick, TumblesWithThePeriodOfTheEllipticIntegral) {
  JoinedBricks brick = spinningBrick();
  const Vector3 spin = brick.motion.velocities[0].angular;
  Stepping stepping(brick, false, 1e-8);
  const auto middle = [&] {
    return (brick.motion.poses[0].rotation.conjugate() * brick.motion.velocities[0].angular).y();
  };
  std::vector<double> turns;  // when the brick's spin about its middle axis changes sign
  double before = middle();
  for (double time = 0; time < 60; time += 0.01) {
    stepping.advance(0.01, timeless(test::noLoads));
    const double now = middle();
    if (before * now < 0) turns.push_back(time + 0.01 * before / (before - now));
    before = now;
  }
  ASSERT_GT(turns.size(), 4u);
  const double period = 2 * (turns.back() - turns.front()) / static_cast<double>(turns.size() - 1);
  const double expected = tumblingPeriod(brick.bricks[0].inertia.diagonal(), spin);
  EXPECT_NEAR(period, expected, 1e-4 * expected);  // measured 7e-6
}

TEST(FreeSheet, KeepsItsEnergyAndItsMomenta) {
  JoinedBricks sheet(test::openSheet(4, 0.7));
  test::Numbers numbers(2);
  for (Velocity& velocity : sheet.motion.velocities) {
    velocity = {0.3 * numbers.vector(), 0.3 * numbers.vector()};
  }
  Stepping stepping(sheet, false, 1e-6);
  stepping.solver->project(sheet.motion);  // to velocities that the joints allow
  const double energy = kineticEnergy(sheet);
  const Vector3 momentum = angularMomentum(sheet);
  stepping.advance(5, timeless(test::noLoads));
  EXPECT_NEAR(kineticEnergy(sheet), energy, 1e-3 * energy);      // measured 1e-8
  EXPECT_LT((angularMomentum(sheet) - momentum).norm(), 1e-12);  // measured 5e-15
}

TEST(Extrapolation, KeepsTheMotionIfAStepIsRejected) {
  JoinedBricks brick = spinningBrick();
  const Motion before = brick.motion;
  Stepping stepping(brick, false, 1e-4);
  const auto refuse = [](const Motion&, const Motion&, double) { return false; };
  const auto taken = stepping.extrapolation.step(brick.motion, 0.1, timeless(test::noLoads), refuse,
                                                 stepping.report);
  EXPECT_FALSE(taken.has_value());
  EXPECT_EQ(brick.motion.poses[0].position, before.poses[0].position);
  EXPECT_EQ(brick.motion.velocities[0].angular, before.velocities[0].angular);
}

}  // namespace
}  // namespace kirireel
