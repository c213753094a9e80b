// Torsional springs at hinges: closed forms, the equation of motion of one angle, energy, and steps
// and stiffnesses over many decades.
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sim/brick/hinge.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/trajectory/measures.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

/// Puts springs at all hinges, at rest at an angle.
void addSprings(JoinedBricks& sheet, bool planar, double stiffness, double rest, double damping) {
  for (const brick::Hinge& hinge : brick::findHinges(sheet.bricks, sheet.pivots, planar).hinges) {
    sheet.springs.push_back({hinge, stiffness, rest, damping});
  }
}

/// Moves sprung bricks without other loads to a tolerance in time.
class SprungMotion {
 public:
  SprungMotion(JoinedBricks& sheet, bool planar, double tolerance)
      : sheet_(sheet),
        solver_(sheet.solver(planar)),
        extrapolation_(sheet.bricks, *solver_,
                       {.tolerance = tolerance, .lengthScale = model::tileSize(sheet.model)}) {}

  void pin(const std::vector<bool>& pinned) {
    solver_->setPinned(pinned);
    extrapolation_.setSupported(true);
  }

  void advance(double seconds) {
    const mechanics::TimedLoads none = [](double, const Poses& poses,
                                          std::vector<brick::Load>& loads) {
      test::noLoads(poses, loads);
    };
    for (double done = 0; done < seconds * (1 - 1e-9);) {
      const auto taken = extrapolation_.step(sheet_.motion, seconds - done, none, {}, report_);
      ASSERT_TRUE(taken.has_value());
      done += *taken;
    }
  }

 private:
  JoinedBricks& sheet_;
  std::unique_ptr<mechanics::JointSolver> solver_;
  mechanics::Extrapolation extrapolation_;
  StepReport report_;
};

/// Two squares that are joined at a corner on both faces.
JoinedBricks twoSquares() {
  model::Model model;
  for (const double at : {0.0, 1.0}) {
    const Vector3 low(at, at, 0);
    model.tiles.push_back(
        {{low, low + Vector3(1, 0, 0), low + Vector3(1, 1, 0), low + Vector3(0, 1, 0)}});
  }
  model.joints = {{{0, 2}, {1, 0}, model::JointFace::Both}};
  return JoinedBricks(model);
}

// A square on a spring at its corner, the other square held, swings as
//   angle = rest + (start - rest) cos(w t),   w^2 = k / (I + m r^2).
TEST(SpringPendulum, SwingsWithTheFrequencyOfItsClosedForm) {
  for (const bool planar : {true, false}) {
    JoinedBricks squares = twoSquares();
    const double stiffness = 7, swing = 0.4;
    addSprings(squares, planar, stiffness, 90 * kDegree + swing, 0);
    const brick::Brick& brick = squares.bricks[1];
    const double frequency = std::sqrt(stiffness / (brick.inertia(2, 2) + 0.5 * brick.mass));
    SprungMotion motion(squares, planar, 1e-9);
    motion.pin({true, false});
    double phase = 0;
    for (double time = 0.05; time < 10.02; time += 0.05) {
      motion.advance(0.05);
      const brick::HingeSpring& spring = squares.springs[0];
      const double off = spring.rest - brick::hingeAngle(spring.hinge, squares.motion.poses);
      const double rate =
          spring.hinge.axis.z() * squares.motion.velocities[1].angular.z() / frequency;
      phase += std::remainder(std::atan2(rate, off) - phase, 2 * std::numbers::pi);
      EXPECT_NEAR(phase / time, frequency, 1e-6 * frequency);  // measured 2e-10
      EXPECT_NEAR(off, swing * std::cos(frequency * time), 1e-6);
    }
  }
}

// The joint removes a part of such velocities at once. This is not an error of the step.
// SprungMotion fails if a step exceeds the tolerance.
TEST(SpringPendulum, StartsFromVelocitiesThatItsJointDoesNotAllow) {
  for (const bool planar : {true, false}) {
    JoinedBricks squares = twoSquares();
    addSprings(squares, planar, 7, 90 * kDegree + 0.4, 0);
    squares.motion.velocities[1].linear = {1e-3, 2e-3, 0};
    SprungMotion motion(squares, planar, 1e-9);
    motion.pin({true, false});
    motion.advance(0.05);
  }
}

/// The angle of a sheet of unit squares and its rate, a mechanism of one angle: the centre of tile
/// i is x_i = a_i cos(angle / 2) + b_i sin(angle / 2), it turns by half the angle, and with n
/// hinges
///   M angle" + M' angle'^2 / 2 = n (k (rest - angle) - c angle'),   M = sum m |x_i'|^2 + I / 4.
class OneAngle {
 public:
  OneAngle(const JoinedBricks& sheet, int side, double angle) : sheet_(sheet), angle_(angle) {
    generate::TessellationShape shape;
    shape.columns = shape.rows = side;
    const std::vector<model::Tile> flat = generate::tessellationTiles(shape, 0);
    const std::vector<model::Tile> open = generate::tessellationTiles(shape, std::numbers::pi / 2);
    for (std::size_t i = 0; i < flat.size(); ++i) {
      a_.push_back(meanPoint(flat[i].vertices));
      b_.push_back(std::sqrt(2.0) * meanPoint(open[i].vertices) - a_.back());
    }
  }

  /// By the classical Runge-Kutta method, with much shorter steps.
  void advance(double seconds) {
    const int count = static_cast<int>(std::lround(seconds / 1e-4));
    const double h = seconds / count;
    for (int k = 0; k < count; ++k) {
      const auto [v1, f1] = slope(angle_, rate_);
      const auto [v2, f2] = slope(angle_ + h / 2 * v1, rate_ + h / 2 * f1);
      const auto [v3, f3] = slope(angle_ + h / 2 * v2, rate_ + h / 2 * f2);
      const auto [v4, f4] = slope(angle_ + h * v3, rate_ + h * f3);
      angle_ += h / 6 * (v1 + 2 * v2 + 2 * v3 + v4);
      rate_ += h / 6 * (f1 + 2 * f2 + 2 * f3 + f4);
    }
  }

  double angle() const { return angle_; }

 private:
  std::pair<double, double> slope(double angle, double rate) const {
    double mass = 0, massSlope = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const brick::Brick& brick = sheet_.bricks[i];
      const double c = std::cos(angle / 2), s = std::sin(angle / 2);
      const Vector3 along = 0.5 * (b_[i] * c - a_[i] * s);
      const Vector3 bend = -0.25 * (a_[i] * c + b_[i] * s);
      mass += brick.mass * along.squaredNorm() + brick.inertia(2, 2) / 4;
      massSlope += 2 * brick.mass * along.dot(bend);
    }
    double moment = 0;
    for (const brick::HingeSpring& spring : sheet_.springs) {
      moment += spring.stiffness * (spring.rest - angle) - spring.damping * rate;
    }
    return {rate, (moment - 0.5 * massSlope * rate * rate) / mass};
  }

  const JoinedBricks& sheet_;
  double angle_;
  double rate_ = 0;
  std::vector<Vector3> a_, b_;
};

TEST(RotatingSquares, SwingByTheirEquationOfMotion) {
  for (const int side : {2, 4}) {
    for (const double damping : {0.0, 0.05}) {
      const double start = 0.5;
      JoinedBricks sheet(test::openSheet(side, start));
      addSprings(sheet, true, 2, 1.0, damping);
      OneAngle exact(sheet, side, start);
      SprungMotion motion(sheet, true, 1e-8);
      double worst = 0;
      for (int k = 0; k < 20; ++k) {
        motion.advance(0.1);
        exact.advance(0.1);
        for (const brick::HingeSpring& spring : sheet.springs) {
          worst = std::max(
              worst, std::abs(brick::hingeAngle(spring.hinge, sheet.motion.poses) - exact.angle()));
        }
      }
      EXPECT_LT(worst, 1e-6) << side;  // measured 3e-9 to 5e-8
    }
  }
}

TEST(RotatingSquares, KeepTheirEnergyToTheTolerance) {
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    JoinedBricks sheet(test::openSheet(4, 0.5));
    addSprings(sheet, true, 2, 1.0, 0);
    const double energy = test::energyOf(sheet);
    SprungMotion motion(sheet, true, tolerance);
    double worst = 0;
    for (int k = 0; k < 50; ++k) {
      motion.advance(0.1);
      worst = std::max(worst, std::abs(test::energyOf(sheet) / energy - 1));
    }
    EXPECT_LT(worst, 100 * tolerance);  // measured 0.6 to 11 times
  }
}

/// Results of one run with fixed steps from random speeds.
struct Fate {
  double growth = 0;  ///< of the energy in any step, relative to that of the start
  double gap = 0;     ///< the largest of any joint
  int unconverged = 0;
};

Fate fateOf(bool planar, double stiffness, double step, double damping) {
  JoinedBricks sheet(test::openSheet(3, 0.3));
  addSprings(sheet, planar, stiffness, 0.8, damping);
  test::Numbers numbers(2);
  for (Velocity& velocity : sheet.motion.velocities) {
    velocity.linear = numbers.vector();
    velocity.angular.z() = numbers.next();
    if (planar) velocity.linear.z() = 0;
  }
  const auto solver = sheet.solver(planar);
  const double start = test::energyOf(sheet);
  double before = start;
  Fate fate;
  for (int k = 0; k < 120; ++k) {
    fate.unconverged += solver->advance(sheet.motion, step, test::noLoads, nullptr).unconverged;
    const double after = test::energyOf(sheet);
    if (!(after - before <= fate.growth * start)) fate.growth = (after - before) / start;
    fate.gap = std::max(fate.gap, trajectory::jointGap(sheet.pivots, sheet.motion.poses).max);
    before = after;
  }
  return fate;
}

TEST(HingeSprings, NeverDiverge) {
  for (const bool planar : {true, false}) {
    for (double stiffness = 1e-6; stiffness < 2e9; stiffness *= 1e3) {
      for (const double step : {1.0 / 960, 1.0 / 240, 1.0 / 60, 1.0 / 10}) {
        for (const double damping : {0.0, 1e-3, 1e3}) {
          const Fate fate = fateOf(planar, stiffness, step, damping);
          const std::string name =
              fmt::format("planar {} k {:g} h {:.4f} c {:g}", planar, stiffness, step, damping);
          EXPECT_LT(fate.growth, 1e-12) << name;  // measured 0
          EXPECT_LT(fate.gap, 1e-10) << name;     // measured 1.4e-12
          EXPECT_EQ(fate.unconverged, 0) << name;
        }
      }
    }
  }
}

}  // namespace
}  // namespace kirireel
