/// Bricks with their joints and their motion, for tests of the joint solver.
#pragma once

#include <random>

#include <gtest/gtest.h>

#include "sim/brick/brick.h"
#include "sim/generate/lattice.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/run/forces.h"
#include "sim/trajectory/measures.h"
#include "tests/support/pair_forces.h"

namespace kirireel::test {

/// The input of a joint solver, at rest in the model's start.
struct JoinedBricks {
  explicit JoinedBricks(const model::Model& start, double thickness = 0.02)
      : model(start),
        bricks(brick::makeBricks(start.tiles, {thickness, brick::MassRule::Unit, 1})),
        pivots(brick::makePivots(start.joints, bricks)),
        motion{brick::startPoses(start.tiles, bricks), std::vector<Velocity>(bricks.size())} {}

  std::unique_ptr<mechanics::JointSolver> solver(bool planar) const {
    return mechanics::makeJointSolver(
        bricks, pivots, {planar, model::tileSize(model), {}, pairForces(springs, ligaments)});
  }

  model::Model model;
  std::vector<brick::Brick> bricks;
  std::vector<brick::Pivot> pivots;
  Motion motion;
  std::vector<brick::HingeSpring> springs;  // at hinges
  std::vector<brick::Ligament> ligaments;
};

/// Kinetic and elastic energy, J.
inline double energyOf(const JoinedBricks& sheet) {
  return trajectory::kineticEnergy(sheet.bricks, sheet.motion) +
         brick::elasticEnergy(sheet.springs, sheet.motion.poses) +
         brick::elasticEnergy(sheet.ligaments, sheet.motion.poses);
}

/// An opened sheet of unit squares, whose target is half open.
inline model::Model openSheet(int side, double startAngle) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.startAngle = startAngle;
  return generate::makeTessellation(shape);
}

/// Target springs and the environment's damping, as in a deployment.
inline mechanics::LoadSource springLoads(const JoinedBricks& sheet,
                                         const run::TargetSprings& springs,
                                         scene::Environment environment) {
  return [&sheet, &springs, environment](const Poses& poses, std::vector<brick::Load>& loads) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] = springs.load(static_cast<int>(i), poses[i], 1);
    }
    run::addEnvironmentLoads(environment, sheet.bricks, poses, loads);
  };
}

/// No loads.
inline void noLoads(const Poses&, std::vector<brick::Load>& loads) {
  std::fill(loads.begin(), loads.end(), brick::Load{});
}

/// Moves a sheet for so many seconds to a tolerance in time, without other loads than those of its
/// solver.
inline void advance(JoinedBricks& sheet, mechanics::Extrapolation& extrapolation, double seconds) {
  StepReport report;
  const mechanics::TimedLoads none = [](double, const Poses& poses,
                                        std::vector<brick::Load>& loads) { noLoads(poses, loads); };
  for (double done = 0; done < seconds * (1 - 1e-9);) {
    const auto taken = extrapolation.step(sheet.motion, seconds - done, none, {}, report);
    ASSERT_TRUE(taken.has_value());
    done += *taken;
  }
}

/// Uniform in [-1, 1], the same on every machine.
class Numbers {
 public:
  explicit Numbers(unsigned seed) : generator_(seed) {}
  double next() { return static_cast<double>(generator_()) / 2147483647.5 - 1; }
  Vector3 vector() {
    const double x = next(), y = next(), z = next();
    return {x, y, z};
  }

 private:
  std::mt19937 generator_;
};

}  // namespace kirireel::test
