// Pair forces other than hinge springs and ligaments: closed forms in the plane and in space, hinge
// springs by another method, and derivatives against differences.
#include "tests/support/pair_forces.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "sim/mechanics/extrapolation.h"
#include "tests/sim/mechanics/joined_bricks.h"

namespace kirireel {
namespace {

using test::JoinedBricks;

/// A spring between the centres of mass of two bricks, at rest at a length l:
///   E = k (|d| - l)^2 / 2,   g = k (|d| - l) n,   K = k n n^T + k (1 - l / |d|) (1 - n n^T).
class CentreSpring : public brick::PairForce {
 public:
  CentreSpring(int brickA, int brickB, double stiffness, double length)
      : brickA_(brickA), brickB_(brickB), stiffness_(stiffness), length_(length) {}

  const brick::PairForceName& name() const override { return kName; }
  std::size_t size() const override { return 1; }
  std::pair<int, int> bricks(std::size_t) const override { return {brickA_, brickB_}; }
  double energy(std::size_t, const Poses& poses) const override {
    return 0.5 * stiffness_ * std::pow(apart(poses).norm() - length_, 2);
  }
  brick::PairEnergy derivatives(std::size_t pair, const Poses& poses) const override {
    const double far = apart(poses).norm();
    const Vector3 n = apart(poses) / far;
    const Matrix3 along = n * n.transpose();
    const Matrix3 K = stiffness_ * (along + (1 - length_ / far) * (Matrix3::Identity() - along));
    brick::PairEnergy found{energy(pair, poses)};
    found.gradient.segment<3>(6) = stiffness_ * (far - length_) * n;
    found.gradient.head<3>() = -found.gradient.segment<3>(6);
    found.hessian.topLeftCorner<3, 3>() = found.hessian.block<3, 3>(6, 6) = K;
    found.hessian.block<3, 3>(0, 6) = found.hessian.block<3, 3>(6, 0) = -K;
    return found;
  }
  std::vector<brick::PairColumn> columns() const override { return {}; }

 private:
  static constexpr brick::PairForceName kName{"centre_springs", "centre_springs", "{} springs"};

  Vector3 apart(const Poses& poses) const {
    return poses[static_cast<std::size_t>(brickB_)].position -
           poses[static_cast<std::size_t>(brickA_)].position;
  }

  int brickA_, brickB_;
  double stiffness_, length_;
};

/// A force that has only derivatives.
class FromDerivatives : public brick::PairForce {
 public:
  explicit FromDerivatives(std::vector<brick::HingeSpring> springs)
      : springs_(std::move(springs)) {}

  const brick::PairForceName& name() const override { return springs_.name(); }
  std::size_t size() const override { return springs_.size(); }
  std::pair<int, int> bricks(std::size_t pair) const override { return springs_.bricks(pair); }
  double energy(std::size_t pair, const Poses& poses) const override {
    return springs_.energy(pair, poses);
  }
  brick::PairEnergy derivatives(std::size_t pair, const Poses& poses) const override {
    return springs_.derivatives(pair, poses);
  }
  std::vector<brick::PairColumn> columns() const override { return {}; }

 private:
  brick::HingeSprings springs_;
};

std::unique_ptr<mechanics::JointSolver> solverWith(const JoinedBricks& sheet, bool planar,
                                                   std::shared_ptr<const brick::PairForce> force) {
  mechanics::JointSolverSettings settings{planar, model::tileSize(sheet.model)};
  settings.pairForces.add(std::move(force));
  return mechanics::makeJointSolver(sheet.bricks, sheet.pivots, settings);
}

// Two free squares on a spring part and meet as a mass m / 2: stretch = a sin(w t), w^2 = 2 k / m.
TEST(PairForces, SwingWithTheFrequencyOfTheirClosedForm) {
  for (const bool planar : {true, false}) {
    for (const bool isSwapped : {false, true}) {
      JoinedBricks squares(test::openSheet(2, 0.6));
      squares.pivots.clear();
      squares.bricks.resize(2);
      squares.motion.poses.resize(2);
      squares.motion.velocities.resize(2);
      if (!planar) squares.motion.poses[1].position.z() += 0.7;
      const Vector3 apart = squares.motion.poses[1].position - squares.motion.poses[0].position;
      const double k = 11, w = std::sqrt(2 * k / squares.bricks[0].mass);
      squares.motion.velocities[0].linear = -0.1 * apart.normalized();
      squares.motion.velocities[1].linear = 0.1 * apart.normalized();
      const auto solver = solverWith(
          squares, planar,
          std::make_shared<CentreSpring>(isSwapped ? 1 : 0, isSwapped ? 0 : 1, k, apart.norm()));
      mechanics::Extrapolation extrapolation(squares.bricks, *solver, {.tolerance = 1e-9});
      double worst = 0;
      for (int n = 1; n <= 20; ++n) {
        test::advance(squares, extrapolation, 0.1);
        const Vector3 now = squares.motion.poses[1].position - squares.motion.poses[0].position;
        worst = std::max(
            worst, std::abs((now - apart).norm() - std::abs(0.2 / w * std::sin(w * 0.1 * n))));
      }
      EXPECT_LT(worst, 1e-6) << planar << isSwapped;
    }
  }
}

// Hinge springs are linear in the angles of the plane. A step with them as rows and one with them
// as blocks, by Newton's method, therefore end in the same state.
TEST(PairForces, MoveASheetLikeSpringsAtItsHinges) {
  for (const bool planar : {true, false}) {
    model::Model model = test::openSheet(3, 0.6);
    for (model::Joint& joint : model.joints) joint.face = model::JointFace::Both;
    JoinedBricks rows(model);
    for (const brick::Hinge& hinge : brick::findHinges(rows.bricks, rows.pivots, planar).hinges) {
      rows.springs.push_back({hinge, 2, hinge.start + 0.3, 0});
    }
    ASSERT_EQ(rows.springs.size(), 12U);
    JoinedBricks blocks = rows;
    const auto byRows = rows.solver(planar);
    const auto byBlocks =
        solverWith(blocks, planar, std::make_shared<FromDerivatives>(rows.springs));
    for (int n = 0; n < 30; ++n) {
      byRows->advance(rows.motion, 1.0 / 240, test::noLoads, nullptr);
      byBlocks->advance(blocks.motion, 1.0 / 240, test::noLoads, nullptr);
    }
    EXPECT_NEAR(byBlocks->energy(blocks.motion), byRows->energy(rows.motion), 1e-9) << planar;
    double worst = 0;
    for (std::size_t i = 0; i < rows.bricks.size(); ++i) {
      worst =
          std::max(worst, (rows.motion.poses[i].position - blocks.motion.poses[i].position).norm());
    }
    EXPECT_LT(worst, 1e-9) << planar;
  }
}

/// The poses with one of a brick's six coordinates changed.
Poses moved(Poses poses, std::size_t brick, int coordinate, double by) {
  Vector3 step = Vector3::Zero();
  step[coordinate % 3] = by;
  if (coordinate < 3) {
    poses[brick].position += step;
  } else {
    poses[brick].rotation = rotationFromVector(step) * poses[brick].rotation;
  }
  return poses;
}

// Central differences of second order; measured 2e-10 N m at most.
TEST(PairForces, HaveTheGradientOfTheirEnergy) {
  model::Model model = test::openSheet(2, 0.6);
  JoinedBricks sheet(model);
  sheet.motion.poses[1] = moved(moved(sheet.motion.poses, 1, 0, 0.1), 1, 5, 0.2)[1];
  const brick::Hinge hinge = brick::findHinges(sheet.bricks, sheet.pivots, true).hinges.at(0);
  brick::Ligament ligament{0, 1};
  ligament.start = Vector3(0.4, 0.2, 0);
  ligament.stretchStiffness = 3;
  ligament.shearStiffness = 0.7;
  const brick::HingeSprings springs({{hinge, 2, 0.1, 0}});
  const brick::Ligaments ligaments({ligament});
  const CentreSpring centre(0, 1, 5, 0.8);
  for (const brick::PairForce* force : {static_cast<const brick::PairForce*>(&springs),
                                        static_cast<const brick::PairForce*>(&ligaments),
                                        static_cast<const brick::PairForce*>(&centre)}) {
    const auto [a, b] = force->bricks(0);
    const brick::PairEnergy found = force->derivatives(0, sheet.motion.poses);
    const brick::PairEnergy flat = brick::inSpace(brick::inPlane(found));
    const double h = 1e-5;
    for (const int k : {0, 1, 5, 6, 7, 11}) {
      const auto brick = static_cast<std::size_t>(k < 6 ? a : b);
      const double slope = (force->energy(0, moved(sheet.motion.poses, brick, k % 6, h)) -
                            force->energy(0, moved(sheet.motion.poses, brick, k % 6, -h))) /
                           (2 * h);
      EXPECT_NEAR(found.gradient[k], slope, 1e-8) << k;
      EXPECT_EQ(flat.gradient[k], found.gradient[k]);
      EXPECT_EQ(flat.hessian(k, 0), found.hessian(k, 0));
    }
    EXPECT_EQ(found.energy, force->energy(sheet.motion.poses));
  }
}

// The default addForces() adds the loads of springs at rest.
TEST(PairForces, PushByTheirGradients) {
  JoinedBricks sheet(test::openSheet(2, 0.6));
  std::vector<brick::HingeSpring> springs;
  for (const brick::Hinge& hinge : brick::findHinges(sheet.bricks, sheet.pivots, true).hinges) {
    springs.push_back({hinge, 2, hinge.start + 0.3, 0});
  }
  std::vector<Vector6> expected(4, Vector6::Zero()), found(4, Vector6::Zero());
  brick::HingeSprings(springs).addForces(sheet.motion, expected);
  FromDerivatives(springs).addForces(sheet.motion, found);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT((expected[i] - found[i]).norm(), 1e-15) << i;
  EXPECT_GT(expected[0].norm(), 0.5);
}

TEST(PairForces, AreLeftOutWithoutPairs) {
  brick::PairForces forces;
  forces.add(nullptr);
  forces.add(std::make_shared<brick::Ligaments>(std::vector<brick::Ligament>{}));
  EXPECT_TRUE(forces.empty());
  EXPECT_FALSE(forces.replaceJoints());
  forces.add(std::make_shared<CentreSpring>(0, 1, 1, 1));
  EXPECT_FALSE(forces.replaceJoints());
  forces.add(std::make_shared<brick::Ligaments>(std::vector<brick::Ligament>(1)));
  EXPECT_TRUE(forces.replaceJoints());
  EXPECT_TRUE(brick::hingeSpringsOf(forces).empty());
  EXPECT_EQ(brick::ligamentsOf(forces).size(), 1u);
}

}  // namespace
}  // namespace kirireel
