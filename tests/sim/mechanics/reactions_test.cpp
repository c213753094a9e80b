// Forces of joints and pins, against statics, mechanics, other solvers and dense linear algebra.
#include <numbers>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "sim/mechanics/joint_solver.h"
#include "sim/run/forces.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

constexpr double kExact = std::numeric_limits<double>::infinity();

std::unique_ptr<mechanics::ReactionSolver> reactionSolver(const JoinedBricks& bricks, bool planar) {
  return mechanics::makeReactionSolver(bricks.bricks, bricks.pivots, planar,
                                       model::tileSize(bricks.model));
}

std::vector<Vector6> evenLoads(const JoinedBricks& bricks, const Vector3& force) {
  std::vector<Vector6> loads(bricks.bricks.size(), Vector6::Zero());
  for (Vector6& load : loads) load.head<3>() = force;
  return loads;
}

/// Random forces and torques on all bricks, only those of the plane if requested.
std::vector<Vector6> randomLoads(std::size_t count, bool planar, unsigned seed) {
  test::Numbers numbers(seed);
  std::vector<Vector6> loads;
  for (std::size_t i = 0; i < count; ++i) {
    Vector6 load;
    load << numbers.vector(), numbers.vector();
    if (planar) load.segment<3>(2).setZero();
    loads.push_back(load);
  }
  return loads;
}

/// A unit square hanging by its upper corner from the lower corner of the one above it.
model::Model hangingChain(int count) {
  model::Model model;
  const double r = std::sqrt(0.5);
  for (int i = 0; i < count; ++i) {
    const double y = -2 * r * i;
    model.tiles.push_back({{{0, y - r, 0}, {r, y, 0}, {0, y + r, 0}, {-r, y, 0}}});
    if (i > 0) model.joints.push_back({{i - 1, 0}, {i, 2}, model::JointFace::Both});
  }
  return model;
}

TEST(Reactions, OfAHangingChainAreItsWeight) {
  JoinedBricks chain(hangingChain(12));
  const Vector3 weight(0, -9.81, 0);
  std::vector<bool> pinned(12, false);
  pinned[0] = true;
  for (const bool planar : {true, false}) {
    const auto solver = reactionSolver(chain, planar);
    const mechanics::Reactions found =
        solver->solve(chain.motion, evenLoads(chain, weight), pinned, kExact);
    EXPECT_LT((found.pinForces[0].head<3>() + 12 * weight).norm(), 1e-9);  // measured 1e-13
    EXPECT_LT(found.pinForces[0].tail<3>().norm(), 1e-9);
    std::vector<Vector3> forces(11, Vector3::Zero());
    for (std::size_t p = 0; p < chain.pivots.size(); ++p) {
      forces[chain.pivots[p].joint] += found.pivotForces[p];
    }
    for (int j = 0; j < 11; ++j) {
      // The upper tile carries all tiles below.
      EXPECT_LT((forces[j] - (11 - j) * weight).norm(), 1e-9) << j;
    }
    EXPECT_LT(found.imbalance, 1e-9);
  }
}

/// Two bars that lean on each other over a span, and on a pinned tile each: hinges at (0, 0), at
/// the top and at (span, 0).
model::Model threeHingedArch(const Vector3& top, double span) {
  const auto bar = [](const Vector3& from, const Vector3& to) {
    const Vector3 side = 0.1 * (to - from).normalized().cross(Vector3::UnitZ());
    const Vector3 middle = 0.5 * (from + to);
    return model::Tile{{from, middle + side, to, middle - side}};
  };
  model::Model model;
  const Vector3 end(span, 0, 0);
  model.tiles = {model::Tile{{{-1, -1, 0}, {0, -1, 0}, {0, 0, 0}, {-1, 0, 0}}}, bar({0, 0, 0}, top),
                 bar(end, top),
                 model::Tile{{{span, -1, 0}, {span + 1, -1, 0}, {span + 1, 0, 0}, end}}};
  constexpr model::JointFace kHinge = model::JointFace::Both;
  model.joints = {{{0, 2}, {1, 0}, kHinge}, {{1, 2}, {2, 2}, kHinge}, {{2, 0}, {3, 3}, kHinge}};
  return model;
}

TEST(Reactions, OfAThreeHingedArchAreThoseOfStatics) {
  const double span = 10;
  const Vector3 top(4, 3, 0);
  JoinedBricks arch(threeHingedArch(top, span));
  // P on the first bar a third of the way up, Q sideways at the middle of the second.
  const double P = 7, Q = 2;
  std::vector<Vector6> loads(4, Vector6::Zero());
  const Vector3 atP = top / 3;
  const Vector3 force1(0, -P, 0), force2(-Q, 0, 0);
  loads[1].head<3>() = force1;
  loads[1].tail<3>() = (atP - arch.motion.poses[1].position).cross(force1);
  loads[1][3] = loads[1][4] = 0;
  loads[2].head<3>() = force2;
  const Vector3 atQ = 0.5 * (top + Vector3(span, 0, 0));
  loads[2].tail<3>() = (atQ - arch.motion.poses[2].position).cross(force2);
  loads[2][3] = loads[2][4] = 0;
  // About (0, 0), of the whole: the right support's lift; about the top, of the left bar: thrust.
  const double right = (P * atP.x() - Q * atQ.y()) / span;
  const double left = P - right;
  const double thrust = (left * top.x() - P * (top.x() - atP.x())) / top.y();
  for (const bool planar : {true, false}) {
    const auto solver = reactionSolver(arch, planar);
    const mechanics::Reactions found =
        solver->solve(arch.motion, loads, {true, false, false, true}, kExact);
    const Vector3 pinLeft = found.pinForces[0].head<3>(), pinRight = found.pinForces[3].head<3>();
    EXPECT_LT((pinLeft - Vector3(thrust, left, 0)).norm(), 1e-9) << planar;
    EXPECT_LT((pinRight - Vector3(Q - thrust, right, 0)).norm(), 1e-9) << planar;
    // The pinned tile's centre is half an edge to the side of and below the hinge.
    const Vector3 arm = -arch.motion.poses[0].position;
    EXPECT_NEAR(found.pinForces[0][5], arm.cross(pinLeft).z(), 1e-9);
  }
}

TEST(Reactions, TurnAPendulum) {
  // A square on a pinned corner that turns at rate w is pulled in by m w^2 r.
  model::Model model = hangingChain(2);
  JoinedBricks pendulum(model);
  const double turn = 3, radius = std::sqrt(0.5);
  pendulum.motion.velocities[1] = {Vector3(turn * radius, 0, 0), Vector3(0, 0, turn)};
  for (const bool planar : {true, false}) {
    const mechanics::Reactions found =
        reactionSolver(pendulum, planar)
            ->solve(pendulum.motion, evenLoads(pendulum, Vector3::Zero()), {true, false}, kExact);
    const Vector3 pull = found.pinForces[0].head<3>();
    EXPECT_LT((pull - Vector3(0, turn * turn * radius, 0)).norm(), 1e-9);
  }
}

TEST(Reactions, AlongALinkKeepItsLength) {
  // Two squares on a link that go round each other: the link pulls with m w^2 r.
  model::Model model;
  for (const double x : {0.0, 3.0}) {
    model.tiles.push_back({{{x, 0, 0}, {x + 1, 0, 0}, {x + 1, 1, 0}, {x, 1, 0}}});
  }
  model.joints = {model::makeLink(model.tiles, {0, 1}, {1, 0})};
  JoinedBricks pair(model);
  // Both squares go round the middle of the link, each with the link's turn, at the corner's
  // height.
  const double turn = 2;
  const Vector3 middle(2, 0, 0), spin(0, 0, turn);
  for (int i = 0; i < 2; ++i) {
    pair.motion.velocities[i] = {spin.cross(pair.motion.poses[i].position - middle), spin};
  }
  for (const bool planar : {true, false}) {
    const auto solver = reactionSolver(pair, planar);
    const mechanics::Reactions found =
        solver->solve(pair.motion, evenLoads(pair, Vector3::Zero()), {false, false}, kExact);
    // Both ends are half an edge beyond the squares' centres. Without the link its length 2 would
    // change by w^2 / 2 for each end along it, and by (2 w)^2 / 2 across. A force along the link
    // balances this, by Newton and Euler.
    Vector3 leverage = pair.pivots[0].pointA.cross(Vector3::UnitX());
    if (planar) leverage.head<2>().setZero();
    const double give =
        1 / pair.bricks[0].mass + leverage.dot(pair.bricks[0].inertia.inverse() * leverage);
    EXPECT_NEAR(found.pivotForces[0].x(), 3 * turn * turn / (2 * give), 1e-9) << planar;
    EXPECT_NEAR(found.pivotForces[0].y(), 0, 1e-9);
  }
}

/// All rows of the joints as a dense matrix: three per pivot, six columns per brick.
Eigen::MatrixXd denseRows(const JoinedBricks& sheet, const std::vector<bool>& pinned, bool planar) {
  const auto columns = static_cast<Eigen::Index>(6 * sheet.bricks.size());
  const auto rows = static_cast<Eigen::Index>(3 * sheet.pivots.size());
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, columns);
  for (std::size_t p = 0; p < sheet.pivots.size(); ++p) {
    const brick::Pivot& pivot = sheet.pivots[p];
    const auto put = [&](int brick, const Vector3& point, double sign) {
      if (pinned[static_cast<std::size_t>(brick)]) return;
      Eigen::Matrix<double, 3, 6> block;
      block << Matrix3::Identity(), -crossMatrix(sheet.motion.poses[brick].rotation * point);
      if (planar) {
        block.row(2).setZero();
        block.middleCols<3>(2).setZero();
      }
      if (planar && pivot.isUpper) block.setZero();
      J.block<3, 6>(3 * static_cast<Eigen::Index>(p), 6 * brick) = sign * block;
    };
    put(pivot.brickA, pivot.pointA, 1);
    put(pivot.brickB, pivot.pointB, -1);
  }
  return J;
}

/// Masses and inertias of all bricks on the diagonal of a matrix.
Eigen::MatrixXd denseMasses(const JoinedBricks& sheet) {
  const auto size = static_cast<Eigen::Index>(6 * sheet.bricks.size());
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t i = 0; i < sheet.bricks.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(6 * i);
    M.block<3, 3>(at, at) = sheet.bricks[i].mass * Matrix3::Identity();
    const Matrix3 R = sheet.motion.poses[i].rotation.toRotationMatrix();
    M.block<3, 3>(at + 3, at + 3) = R * sheet.bricks[i].inertia * R.transpose();
  }
  return M;
}

Eigen::VectorXd stacked(const std::vector<Vector6>& loads) {
  Eigen::VectorXd all(6 * static_cast<Eigen::Index>(loads.size()));
  for (std::size_t i = 0; i < loads.size(); ++i) {
    all.segment<6>(6 * static_cast<Eigen::Index>(i)) = loads[i];
  }
  return all;
}

/// The forces of least norm by singular values: J M^-1 J^T l = -J M^-1 F at rest.
Eigen::VectorXd leastForces(const Eigen::MatrixXd& J, const Eigen::MatrixXd& M,
                            const Eigen::VectorXd& F) {
  const Eigen::MatrixXd MinvJt = M.ldlt().solve(J.transpose());
  const Eigen::VectorXd r =
      J.transpose() * (J * MinvJt).completeOrthogonalDecomposition().solve(-J * M.ldlt().solve(F));
  Eigen::BDCSVD<Eigen::MatrixXd> svd(J.transpose(), Eigen::ComputeThinU | Eigen::ComputeThinV);
  svd.setThreshold(1e-9);
  return svd.solve(r);
}

/// Sheets of squares in the plane and in space, and one whose tiles are coplanar in no pair. They
/// have closed loops, so joints are redundant in space.
class RedundantSheet : public testing::TestWithParam<bool> {};

TEST_P(RedundantSheet, HasTheLeastForces) {
  const bool planar = GetParam();
  JoinedBricks sheet(test::openSheet(4, 0.4));
  std::vector<bool> pinned(sheet.bricks.size(), false);
  pinned[0] = true;
  const std::vector<Vector6> loads = randomLoads(sheet.bricks.size(), planar, 3);
  const auto solver = reactionSolver(sheet, planar);
  const mechanics::Reactions found = solver->solve(sheet.motion, loads, pinned, kExact);
  const Eigen::VectorXd expected =
      leastForces(denseRows(sheet, pinned, planar), denseMasses(sheet), stacked(loads));
  double difference = 0;
  for (std::size_t p = 0; p < sheet.pivots.size(); ++p) {
    const Vector3 other = expected.segment<3>(3 * static_cast<Eigen::Index>(p));
    difference = std::max(difference, (found.pivotForces[p] - other).norm());
  }
  EXPECT_LT(difference, 1e-7 * expected.lpNorm<Eigen::Infinity>());
  EXPECT_LT(found.imbalance, 1e-7 * expected.lpNorm<Eigen::Infinity>());
}

/// The joints in which a state of self-stress has a force, by the projector on the left null space.
std::vector<bool> indeterminateBySvd(const JoinedBricks& sheet, const Eigen::MatrixXd& J,
                                     bool planar) {
  Eigen::BDCSVD<Eigen::MatrixXd> svd(J, Eigen::ComputeFullU);
  const double limit = 1e-9 * svd.singularValues()[0];
  const Eigen::Index rank = (svd.singularValues().array() > limit).count();
  const Eigen::MatrixXd null = svd.matrixU().rightCols(J.rows() - rank);
  std::vector<Eigen::MatrixXd> sums(sheet.model.joints.size(),
                                    Eigen::MatrixXd::Zero(3, null.cols()));
  for (std::size_t p = 0; p < sheet.pivots.size(); ++p) {
    if (planar && sheet.pivots[p].isUpper) continue;
    Eigen::MatrixXd rows = null.middleRows(3 * static_cast<Eigen::Index>(p), 3);
    if (planar) rows.row(2).setZero();
    sums[sheet.pivots[p].joint] += rows;
  }
  std::vector<bool> found;
  for (const Eigen::MatrixXd& sum : sums) found.push_back(sum.norm() > 1e-6);
  return found;
}

TEST_P(RedundantSheet, MarksWhatIsIndeterminate) {
  const bool planar = GetParam();
  for (const double angle : {0.0, 0.4}) {
    JoinedBricks sheet(test::openSheet(4, angle));
    std::vector<bool> pinned(sheet.bricks.size(), false);
    for (const bool bothHeld : {false, true}) {
      pinned[0] = bothHeld;
      pinned.back() = bothHeld;
      const auto solver = reactionSolver(sheet, planar);
      solver->solve(sheet.motion, evenLoads(sheet, Vector3::Zero()), pinned, kExact);
      const std::vector<bool> found = solver->indeterminateJoints(sheet.model.joints.size());
      EXPECT_EQ(found, indeterminateBySvd(sheet, denseRows(sheet, pinned, planar), planar))
          << planar << " " << angle << " " << bothHeld;
    }
  }
}

/// A chain of squares that branches off a sheet: only its joints are determinate.
TEST(Reactions, AreDeterminateInATree) {
  model::Model model = test::openSheet(3, 0.4);
  const auto loops = static_cast<int>(model.tiles.size());
  const std::size_t before = model.joints.size();
  for (int k = 0; k < 3; ++k) {
    const int from = k == 0 ? 0 : loops + k - 1;
    const Vector3 corner = model.tiles[from].vertices[0];
    model.tiles.push_back({{corner + Vector3(-1, -1, 0), corner + Vector3(0, -1, 0), corner,
                            corner + Vector3(-1, 0, 0)}});
    model.joints.push_back({{from, 0}, {loops + k, 2}});
  }
  JoinedBricks sheet(model);
  const std::vector<bool> pinned(sheet.bricks.size(), false);
  const auto solver = reactionSolver(sheet, false);
  solver->solve(sheet.motion, evenLoads(sheet, Vector3::Zero()), pinned, kExact);
  const std::vector<bool> found = solver->indeterminateJoints(model.joints.size());
  for (std::size_t j = 0; j < found.size(); ++j) EXPECT_EQ(found[j], j < before) << j;
}

TEST_P(RedundantSheet, HasTheForcesOfEquallyStiffJoints) {
  // A sheet that is pinned at one end and pulled at the other, at rest on compliant joints: in the
  // limit of stiff joints their forces are those of least norm.
  const bool planar = GetParam();
  JoinedBricks sheet(test::openSheet(4, 0.4));
  std::vector<bool> pinned(sheet.bricks.size(), false);
  pinned[0] = true;
  const Vector3 pull(3, 2, planar ? 0 : 1);
  double before = 0;
  for (const double stiffness : {1e6, 1e7, 1e8}) {
    const auto dynamics = sheet.solver(planar);
    dynamics->setPinned(pinned);
    dynamics->setJointStiffness(stiffness);
    Motion motion = sheet.motion;
    const mechanics::LoadSource pulled = [&](const Poses& poses, std::vector<brick::Load>& loads) {
      for (brick::Load& load : loads) {
        load = {};
        load.damping.diagonal().setConstant(20);
      }
      // Soft springs hold all corners. Otherwise the sheet would stretch out to a state with
      // unbounded forces.
      for (std::size_t i = 0; i < poses.size(); ++i) {
        const Pose& start = sheet.motion.poses[i];
        for (const Vector3& corner : sheet.bricks[i].bottom) {
          run::addPointSpring({corner, start.apply(corner), 5, 0}, poses[i], loads[i]);
        }
      }
      const Vector3 arm = poses.back().rotation * sheet.bricks.back().bottom[2];
      loads.back().force.head<3>() += pull;
      loads.back().force.tail<3>() += arm.cross(pull);
    };
    for (int step = 0; step < 400; ++step) dynamics->advance(motion, 0.5, pulled, nullptr);
    std::vector<brick::Load> loads(sheet.bricks.size());
    pulled(motion.poses, loads);
    std::vector<Vector6> applied;
    for (const brick::Load& load : loads) applied.push_back(load.force);
    const auto solver = reactionSolver(sheet, planar);
    const mechanics::Reactions springs = solver->solve(motion, applied, pinned, stiffness);
    const mechanics::Reactions exact = solver->solve(motion, applied, pinned, kExact);
    double largest = 0, difference = 0;
    for (std::size_t p = 0; p < sheet.pivots.size(); ++p) {
      largest = std::max(largest, springs.pivotForces[p].norm());
      difference = std::max(difference, (springs.pivotForces[p] - exact.pivotForces[p]).norm());
    }
    // The difference falls with the stiffness.
    if (before > 0) {
      EXPECT_LT(difference / largest, 0.2 * before);
    }
    before = difference / largest;
  }
  EXPECT_LT(before, 1e-4);  // measured 1.1e-6 in the plane, 4.6e-5 in space
}

INSTANTIATE_TEST_SUITE_P(Reactions, RedundantSheet, testing::Bool(),
                         [](const auto& info) { return info.param ? "Plane" : "Space"; });

}  // namespace
}  // namespace kirireel
