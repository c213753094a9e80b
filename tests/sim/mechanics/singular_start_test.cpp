// The first step from rest at a closed sheet, against the motion along its path.
#include "sim/mechanics/singular_start.h"

#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel::mechanics {
namespace {

using test::JoinedBricks;

constexpr double kSecond = 1.0 / 60;
const Vector3 kGravity(-1, 2, 0);

TimedLoads weight(const JoinedBricks& sheet, const Vector3& gravity = kGravity) {
  return [&sheet, gravity](double, const Poses&, std::vector<brick::Load>& loads) {
    for (std::size_t i = 0; i < loads.size(); ++i) {
      loads[i] = {};
      loads[i].force.head<3>() = sheet.bricks[i].mass * gravity;
    }
  };
}

model::Model tessellation(int columns, int rows, double startAngle) {
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.startAngle = startAngle;
  return generate::makeTessellation(shape);
}

/// The poses relative to the first brick, whose first edge is along x.
Poses relativePoses(const model::Model& model) {
  const JoinedBricks sheet(model);
  const Vector3 edge = model.tiles[0].vertices[1] - model.tiles[0].vertices[0];
  const Quaternion back(Eigen::AngleAxisd(-std::atan2(edge.y(), edge.x()), Vector3::UnitZ()));
  Poses poses;
  for (std::size_t i = 0; i < sheet.bricks.size(); ++i) {
    const Vector3 side = model.tiles[i].vertices[1] - model.tiles[i].vertices[0];
    const double turn = std::atan2(side.y(), side.x());
    poses.push_back({back * (sheet.motion.poses[i].position - sheet.motion.poses[0].position),
                     back * Quaternion(Eigen::AngleAxisd(turn, Vector3::UnitZ()))});
  }
  return poses;
}

/// The motion of a closed sheet along its path, from its energy. The first brick is pinned.
struct MotionOnPath {
  double seconds = 0;
  double angularSpeed = 0;  // of neighbours
};

MotionOnPath motionOnPath(int columns, int rows, double angle) {
  constexpr double kDifference = 1e-5;
  constexpr int kParts = 20;
  const JoinedBricks closed(tessellation(columns, rows, 0));
  const Poses start = relativePoses(closed.model);
  const auto speedAt = [&](double at) {
    const double before = std::max(at - kDifference, 0.0), after = at + kDifference;
    const Poses from = relativePoses(tessellation(columns, rows, before));
    const Poses to = relativePoses(tessellation(columns, rows, after));
    const Poses here = relativePoses(tessellation(columns, rows, at));
    double work = 0, mass = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      const brick::Brick& brick = closed.bricks[i];
      const Vector3 rate = (to[i].position - from[i].position) / (after - before);
      const Vector3 turn = turnBetween(from[i].rotation, to[i].rotation) / (after - before);
      work += brick.mass * kGravity.dot(here[i].position - start[i].position);
      mass += brick.mass * rate.squaredNorm() + turn.dot(brick.inertia * turn);
    }
    return std::sqrt(2 * work / mass);
  };
  // The time is the integral of 1 / speed, by the root of the angle.
  MotionOnPath result{0, speedAt(angle)};
  for (int k = 0; k < kParts; ++k) {
    const double root = std::sqrt(angle) * (k + 0.5) / kParts;
    result.seconds += 2 * root / speedAt(root * root) * std::sqrt(angle) / kParts;
  }
  return result;
}

TEST(SingularStart, BricksAccelerateAlongThePath) {
  for (const auto& [columns, rows] :
       {std::pair{3, 3}, {4, 4}, {3, 8}, {5, 5}, {6, 6}, {10, 10}, {20, 20}}) {
    for (const bool planar : {true, false}) {
      if (!planar && columns * rows > 25) continue;
      JoinedBricks sheet(tessellation(columns, rows, 0));
      const auto solver = sheet.solver(planar);
      std::vector<bool> pins(sheet.bricks.size());
      pins[0] = true;
      solver->setPinned(pins);
      StepReport report;
      const auto left = leaveSingularState(sheet.bricks, *solver, {.tolerance = 1e-6}, sheet.motion,
                                           kSecond, weight(sheet), {}, report);
      ASSERT_TRUE(left.has_value()) << columns << " x " << rows;
      const PassedState& end = left->states.back();
      const double angle =
          turnBetween(sheet.motion.poses[1].rotation, end.motion.poses[1].rotation).z();
      const MotionOnPath exact = motionOnPath(columns, rows, angle);
      // Measured up to 2.2e-5 and 8.3e-6.
      EXPECT_NEAR(end.seconds / exact.seconds, 1, 1e-4) << columns << " x " << rows << planar;
      EXPECT_NEAR(end.motion.velocities[1].angular.z() / exact.angularSpeed, 1, 1e-4)
          << columns << " x " << rows << planar;
      EXPECT_EQ(report.singularTime, 0);
    }
  }
}

TEST(SingularStart, DoesNotDependOnNumbers) {
  std::vector<double> durations, speeds;
  for (const bool isReversed : {false, true}) {
    model::Model model = tessellation(6, 6, 0);
    const int last = static_cast<int>(model.tiles.size()) - 1;
    if (isReversed) {
      std::ranges::reverse(model.tiles);
      std::ranges::reverse(model.joints);
      for (model::Joint& joint : model.joints) {
        joint.a.tile = last - joint.a.tile;
        joint.b.tile = last - joint.b.tile;
      }
    }
    JoinedBricks sheet(model);
    const auto solver = sheet.solver(true);
    std::vector<bool> pins(sheet.bricks.size());
    pins[isReversed ? static_cast<std::size_t>(last) : 0] = true;
    solver->setPinned(pins);
    StepReport report;
    // These loads alone leave the bricks at the start.
    const auto left = leaveSingularState(sheet.bricks, *solver, {.tolerance = 1e-6}, sheet.motion,
                                         kSecond, weight(sheet, Vector3(3, 0.3, 0)), {}, report);
    ASSERT_TRUE(left.has_value());
    durations.push_back(left->states.back().seconds);
    const std::size_t next = isReversed ? static_cast<std::size_t>(last) - 1 : 1;
    speeds.push_back(left->states.back().motion.velocities[next].angular.z());
  }
  // Measured 1.7e-7 and 1.5e-9.
  EXPECT_NEAR(durations[1] / durations[0], 1, 1e-5);
  EXPECT_NEAR(speeds[1] / durations[1] / (speeds[0] / durations[0]), 1, 1e-6);
}

TEST(SingularStart, IsReportedIfLoadsDoNotPullAlongThePath) {
  JoinedBricks sheet(tessellation(3, 3, 0));
  const auto solver = sheet.solver(true);
  const TimedLoads across = weight(sheet, Vector3(1, 0, 0));
  StepReport report;
  EXPECT_FALSE(leaveSingularState(sheet.bricks, *solver, {.tolerance = 1e-3}, sheet.motion, kSecond,
                                  across, {}, report));
  EXPECT_EQ(report.singularTime, 0);  // without a pin the sheet falls as a whole
  std::vector<bool> pins(sheet.bricks.size());
  pins[0] = true;
  solver->setPinned(pins);
  EXPECT_FALSE(leaveSingularState(sheet.bricks, *solver, {.tolerance = 1e-3}, sheet.motion, kSecond,
                                  across, {}, report));
  EXPECT_EQ(report.singularTime, kSecond);
}

TEST(SingularStart, OtherStatesAreLeftToUsualSteps) {
  for (const double angle : {0.01 * kDegree, 30 * kDegree}) {
    JoinedBricks sheet(tessellation(4, 4, angle));
    const auto solver = sheet.solver(true);
    StepReport report;
    EXPECT_FALSE(leaveSingularState(sheet.bricks, *solver, {.tolerance = 1e-6}, sheet.motion,
                                    kSecond, weight(sheet), {}, report))
        << angle;
  }
  JoinedBricks moving(tessellation(4, 4, 0));
  moving.motion.velocities[3].linear.x() = 1e-3;
  StepReport report;
  EXPECT_FALSE(leaveSingularState(moving.bricks, *moving.solver(true), {.tolerance = 1e-6},
                                  moving.motion, kSecond, weight(moving), {}, report));
}

}  // namespace
}  // namespace kirireel::mechanics
