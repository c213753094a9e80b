// Impacts, rolling over an edge and sliding to rest, in steps to a tolerance, against known
// motions: closed forms, and equations of motion in one angle.
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/sim/run/moving.h"
#include "tests/support/physics.h"

namespace kirireel {
namespace {

using test::Moving;

using test::kCall;
using test::kGravity;
const std::vector<double> kTolerances = {1e-3, 1e-4, 1e-5, 1e-6};

/// A brick of side x depth x height that lies on the ground at z = 0.
scene::Scene brickOnGround(double side, double height, double friction) {
  scene::Scene scene;
  const double x = side / 2;
  scene.model.tiles = {{{{-x, -0.5, 0}, {x, -0.5, 0}, {x, 0.5, 0}, {-x, 0.5, 0}}}};
  scene.brick.thickness = height;
  scene.environment.gravity = {0, 0, -kGravity};
  scene.environment.ground = scene::Ground{0, friction};
  scene.environment.linearDamping = scene.environment.angularDamping = 0;
  scene.actuation.drive = scene::Drive::None;
  scene.solver.planar = false;
  return scene;
}

/// Bricks in motion to a tolerance under nothing but their weight.
struct Falling : Moving {
  Falling(scene::Scene scene, double tolerance) : Moving(keeping(std::move(scene), tolerance)) {
    dynamics->setTolerance({tolerance, 1.0 / 240, kCall});
  }

  static scene::Scene keeping(scene::Scene scene, double tolerance) {
    scene.solver.tolerance = tolerance;
    return scene;
  }
  void advance() {
    const mechanics::TimedLoads none = [](double, const Poses&, std::vector<brick::Load>& loads) {
      std::ranges::fill(loads, brick::Load{});
    };
    report += dynamics->advanceToTolerance(motion, kCall, none);
    time += kCall;
  }
  /// The distance of the brick from a position of its centre and a rotation about y.
  double error(const Vector3& centre, double turn) const {
    const Quaternion expected = rotationFromVector(Vector3(0, turn, 0));
    return (motion.poses[0].position - centre).norm() +
           turnBetween(expected, motion.poses[0].rotation).norm();
  }

  StepReport report;
  double time = 0;
};

/// One angle and its rate.
using AngleState = std::array<double, 2>;

/// A step of the classical Runge-Kutta method.
template <typename Acceleration>
AngleState rungeKutta(const AngleState& y, double h, const Acceleration& acceleration) {
  const auto slope = [&](const AngleState& at) {
    return AngleState{at[1], acceleration(at[0], at[1])};
  };
  const auto plus = [](const AngleState& at, double part, const AngleState& more) {
    return AngleState{at[0] + part * more[0], at[1] + part * more[1]};
  };
  const AngleState k1 = slope(y), k2 = slope(plus(y, h / 2, k1));
  const AngleState k3 = slope(plus(y, h / 2, k2)), k4 = slope(plus(y, h, k3));
  return plus(plus(plus(plus(y, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
}

/// A brick falls without friction on one edge and then, without rebound, on the other. After the
/// first impact the height of its centre above the ground is h(b) = (a sin b + t cos b) / 2, b its
/// tilt, and its centre falls vertically.
class TiltedFall {
 public:
  TiltedFall(const brick::Brick& brick, double side, double height, double tilt, double drop)
      : mass_(brick.mass),
        inertia_(brick.inertia(1, 1)),
        side_(side),
        height_(height),
        state_{tilt, 0},
        drop_(drop),
        impact_(std::sqrt(2 * drop / kGravity)) {}

  double centre(double tilt) const {
    return 0.5 * (side_ * std::sin(tilt) + height_ * std::cos(tilt));
  }
  double tilt() const { return state_[0]; }
  /// The height of the centre at a time. Times must not decrease.
  double heightAt(double time) {
    if (time <= impact_) return centre(state_[0]) + drop_ - 0.5 * kGravity * time * time;
    if (now_ == 0) strike();
    constexpr double kStep = 1e-5;
    while (now_ < time - 1e-12 && state_[0] > 0) {
      const double h = std::min(kStep, time - now_);
      state_ = rungeKutta(state_, h, [this](double b, double rate) {
        const double c = slope(b);
        return -mass_ * c * (kGravity - centre(b) * rate * rate) / (mass_ * c * c + inertia_);
      });
      now_ += h;
    }
    if (state_[0] <= 0) state_ = {0, 0};
    return centre(state_[0]);
  }

 private:
  double slope(double tilt) const {
    return 0.5 * (side_ * std::cos(tilt) - height_ * std::sin(tilt));
  }
  void strike() {
    const double c = slope(state_[0]);
    state_[1] = -mass_ * c * kGravity * impact_ / (mass_ * c * c + inertia_);
    now_ = impact_;
  }

  double mass_, inertia_, side_, height_;
  AngleState state_;
  double drop_;
  double impact_;   // when the edge strikes
  double now_ = 0;  // of the state, from the impact on
};

TEST(Impact, TiltedBrickFallsOnAnEdgeAndOnTheOther) {
  constexpr double kSide = 1, kHeight = 0.2, kTilt = 10 * kDegree, kDrop = 0.3;
  for (const double tolerance : kTolerances) {
    Falling brick(brickOnGround(kSide, kHeight, 0), tolerance);
    TiltedFall exact(brick.bricks[0], kSide, kHeight, kTilt, kDrop);
    brick.motion.poses[0] = {{0, 0, exact.heightAt(0)}, rotationFromVector(Vector3(0, kTilt, 0))};
    double error = 0;
    for (int call = 0; call < 36; ++call) {
      brick.advance();
      const Vector3 centre(0, 0, exact.heightAt(brick.time));
      error = std::max(error, brick.error(centre, exact.tilt()));
    }
    EXPECT_LT(error, 10 * tolerance) << tolerance;  // measured 1e-4 to 1.4e-3 times
    EXPECT_EQ(exact.tilt(), 0);
    EXPECT_EQ(brick.report.touchingTime, 0) << tolerance;
    EXPECT_EQ(brick.report.singularTime, 0) << tolerance;
  }
}

/// A cube of side 1 that rolls over its lower edge, which friction holds, onto its next face, and
/// then rocks from edge to edge. It is tilted from lying on that face by an angle that is negative
/// about the first edge, at the origin, and positive about the second, at x = 1. Where it strikes
/// the ground a quarter of its rate is left, from the moment about the edge that is struck.
/// Housner, The behavior of inverted pendulum structures during earthquakes, 1963, eq. 4 and 7.
class RockingCube {
 public:
  RockingCube(const brick::Brick& cube, double tilt)
      : frequency_(cube.mass * kGravity * kRadius /
                   (cube.inertia(1, 1) + cube.mass * kRadius * kRadius)),
        state_{tilt, 0} {}

  void advance(double seconds) {
    constexpr int kParts = 200;
    for (int k = 0; k < kParts; ++k) advanceBriefly(seconds / kParts);
  }
  double turn() const { return 90 * kDegree + state_[0]; }
  Vector3 centre() const {
    const double fromEdge = 45 * kDegree - std::abs(state_[0]);
    const double x = kRadius * std::sin(fromEdge);
    return {state_[0] < 0 ? x : 1 - x, 0, kRadius * std::cos(fromEdge)};
  }

 private:
  static constexpr double kRadius = std::numbers::sqrt2 / 2;
  static constexpr double kRateLeft = 0.25;
  static constexpr double kRest = 1e-9;  // radians and radians a second

  AngleState after(double seconds) const {
    return rungeKutta(state_, seconds, [this](double tilt, double) {
      return -std::copysign(frequency_, state_[0]) * std::sin(45 * kDegree - std::abs(tilt));
    });
  }
  /// There is at most one impact before this time.
  void advanceBriefly(double seconds) {
    if (std::abs(state_[0]) + std::abs(state_[1]) < kRest) return;
    const AngleState next = after(seconds);
    if (next[0] * state_[0] > 0) {
      state_ = next;
      return;
    }
    double low = 0, high = seconds;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (after(middle)[0] * state_[0] > 0 ? low : high) = middle;
    }
    const double rate = kRateLeft * after(high)[1];
    state_ = {std::copysign(1e-15, rate), rate};
    state_ = after(seconds - high);
  }

  double frequency_;  // squared
  AngleState state_;
};

TEST(Impact, CubeTipsOverItsEdgeAndRocks) {
  constexpr double kStart = -43 * kDegree;  // 2 degrees beyond its balance
  for (const double tolerance : kTolerances) {
    Falling cube(brickOnGround(1, 1, 0.8), tolerance);
    RockingCube exact(cube.bricks[0], kStart);
    cube.motion.poses[0] = {exact.centre(), rotationFromVector(Vector3(0, exact.turn(), 0))};
    double error = 0;
    for (int call = 0; call < 100; ++call) {
      cube.advance();
      exact.advance(kCall);
      error = std::max(error, cube.error(exact.centre(), exact.turn()));
    }
    EXPECT_LT(error, 10 * tolerance) << tolerance;  // measured 0.15 to 4.4 times
    EXPECT_NEAR(exact.turn(), 90 * kDegree, 1e-6);
    EXPECT_EQ(cube.report.touchingTime, 0) << tolerance;
    EXPECT_EQ(cube.report.singularTime, 0) << tolerance;
  }
}

TEST(Impact, BrickSlidesToRest) {
  constexpr double kFriction = 0.3, kSpeed = 1.5;
  for (const bool planar : {false, true}) {
    for (const double tolerance : kTolerances) {
      scene::Scene scene = brickOnGround(1, 0.1, kFriction);
      scene.solver.planar = planar;
      Falling brick(scene, tolerance);
      brick.motion.velocities[0].linear.x() = kSpeed;
      const Vector3 start = brick.motion.poses[0].position;
      const double end = kSpeed / (kFriction * kGravity);
      double error = 0;
      for (int call = 0; call < 60; ++call) {
        brick.advance();
        const double time = std::min(brick.time, end);
        const double moved = kSpeed * time - 0.5 * kFriction * kGravity * time * time;
        error = std::max(error, brick.error(start + Vector3(moved, 0, 0), 0));
      }
      EXPECT_LT(error, 10 * tolerance) << tolerance;  // measured 0.015 to 0.19 times
      EXPECT_LT(brick.motion.velocities[0].linear.norm(), 1e-12);
      EXPECT_EQ(brick.report.touchingTime, 0) << tolerance;
      EXPECT_EQ(brick.report.singularTime, 0) << tolerance;
    }
  }
}

}  // namespace
}  // namespace kirireel
