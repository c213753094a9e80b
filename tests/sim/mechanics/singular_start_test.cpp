// The first step from rest at a closed sheet, against the motion along its path.
#include "sim/mechanics/singular_start.h"

#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel::mechanics {
namespace {

using test::JoinedBricks;

constexpr double kSecond = 1.0 / 60;
const Vector3 kGravity(-1, 2, 0);

TimedLoads weight(const JoinedBricks& sheet) {
  return [&sheet](double, const Poses&, std::vector<brick::Load>& loads) {
    for (std::size_t i = 0; i < loads.size(); ++i) {
      loads[i] = {};
      loads[i].force.head<3>() = sheet.bricks[i].mass * kGravity;
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

/// The acceleration of each brick of a closed sheet whose first brick is pinned: t (t.F) / (t.M t)
/// with t the rate of the poses by the angle between neighbours.
std::vector<Velocity> accelerations(int columns, int rows) {
  constexpr double kAngle = 1e-6;
  const JoinedBricks closed(tessellation(columns, rows, 0));
  const Poses from = relativePoses(closed.model);
  const Poses to = relativePoses(tessellation(columns, rows, kAngle));
  std::vector<Velocity> rate(from.size());
  double force = 0, mass = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    rate[i].linear = (to[i].position - from[i].position) / kAngle;
    rate[i].angular = turnBetween(from[i].rotation, to[i].rotation) / kAngle;
    force += closed.bricks[i].mass * kGravity.dot(rate[i].linear);
    mass += closed.bricks[i].mass * rate[i].linear.squaredNorm() +
            rate[i].angular.dot(closed.bricks[i].inertia * rate[i].angular);
  }
  for (Velocity& part : rate) part = {force / mass * part.linear, force / mass * part.angular};
  return rate;
}

TEST(SingularStart, BricksAccelerateAlongThePath) {
  for (const auto& [columns, rows] : {std::pair{3, 3}, {4, 4}, {3, 5}, {5, 5}}) {
    const std::vector<Velocity> exact = accelerations(columns, rows);
    for (const bool planar : {true, false}) {
      JoinedBricks sheet(tessellation(columns, rows, 0));
      const auto solver = sheet.solver(planar);
      std::vector<bool> pins(sheet.bricks.size());
      pins[0] = true;
      solver->setPinned(pins);
      const Poses start = sheet.motion.poses;
      StepReport report;
      const auto step = leaveSingularState(*solver, {.tolerance = 1e-6}, sheet.motion, kSecond,
                                           weight(sheet), {}, report);
      ASSERT_TRUE(step.has_value()) << columns << " x " << rows;
      double size = 0, missSpeed = 0, missPlace = 0;
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const Vector3 place =
            (sheet.motion.poses[i].position - start[i].position) * 2 / *step / *step;
        size = std::max(size, exact[i].linear.norm());
        missPlace = std::max(missPlace, (place - exact[i].linear).norm());
        const Velocity& velocity = sheet.motion.velocities[i];
        missSpeed = std::max({missSpeed, (velocity.linear / *step - exact[i].linear).norm(),
                              (velocity.angular / *step - exact[i].angular).norm()});
      }
      // Measured 1.5e-4 to 4.8e-4, and 2e-5 to 3.4e-4.
      EXPECT_LT(missSpeed, 1e-3 * size) << columns << " x " << rows << ' ' << planar;
      EXPECT_LT(missPlace, 1e-3 * size) << columns << " x " << rows << ' ' << planar;
    }
  }
}

TEST(SingularStart, IsReportedIfNoPathIsFound) {
  JoinedBricks sheet(tessellation(10, 10, 0));
  const auto solver = sheet.solver(true);
  StepReport report;
  EXPECT_FALSE(leaveSingularState(*solver, {.tolerance = 1e-3}, sheet.motion, kSecond,
                                  weight(sheet), {}, report));
  EXPECT_EQ(report.singularTime, 0);  // without a pin the sheet falls as a whole
  std::vector<bool> pins(sheet.bricks.size());
  pins[0] = true;
  solver->setPinned(pins);
  EXPECT_FALSE(leaveSingularState(*solver, {.tolerance = 1e-3}, sheet.motion, kSecond,
                                  weight(sheet), {}, report));
  EXPECT_EQ(report.singularTime, kSecond);
}

TEST(SingularStart, OtherStatesAreLeftToUsualSteps) {
  for (const double angle : {0.01 * kDegree, 30 * kDegree}) {
    JoinedBricks sheet(tessellation(4, 4, angle));
    const auto solver = sheet.solver(true);
    StepReport report;
    EXPECT_FALSE(leaveSingularState(*solver, {.tolerance = 1e-6}, sheet.motion, kSecond,
                                    weight(sheet), {}, report))
        << angle;
  }
  JoinedBricks moving(tessellation(4, 4, 0));
  moving.motion.velocities[3].linear.x() = 1e-3;
  StepReport report;
  EXPECT_FALSE(leaveSingularState(*moving.solver(true), {.tolerance = 1e-6}, moving.motion, kSecond,
                                  weight(moving), {}, report));
}

}  // namespace
}  // namespace kirireel::mechanics
