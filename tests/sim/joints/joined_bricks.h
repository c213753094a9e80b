/// Bricks with their joints and their motion, for tests of the joint solver.
#pragma once

#include <random>

#include <gtest/gtest.h>

#include "sim/deploy/forces.h"
#include "sim/mechanics/extrapolation.h"
#include "sim/mechanics/joint_solver.h"
#include "sim/model/brick.h"
#include "sim/model/lattice.h"
#include "tests/support/pair_forces.h"

namespace kirireel::test {

/// What a joint solver works on, at rest in the model's start.
struct JoinedBricks {
  explicit JoinedBricks(const Model& start, double thickness = 0.02)
      : model(start),
        bricks(makeBricks(start.tiles, {thickness, MassRule::Unit, 1})),
        pivots(makePivots(start.joints, bricks)),
        motion{startPoses(start.tiles, bricks), std::vector<Velocity>(bricks.size())} {}

  std::unique_ptr<JointSolver> solver(bool planar) const {
    return makeJointSolver(bricks, pivots,
                           {planar, tileSize(model), {}, pairForces(springs, ligaments)});
  }

  Model model;
  std::vector<Brick> bricks;
  std::vector<Pivot> pivots;
  Motion motion;
  std::vector<HingeSpring> springs;  // at hinges
  std::vector<Ligament> ligaments;
};

/// An opened sheet of unit squares, whose target is half open.
inline Model openSheet(int side, double startAngle) {
  TessellationShape shape;
  shape.columns = shape.rows = side;
  shape.startAngle = startAngle;
  return makeTessellation(shape);
}

/// Target springs and the environment's damping, as a deployment has them.
inline LoadSource springLoads(const JoinedBricks& sheet, const TargetSprings& springs,
                              Environment environment) {
  return [&sheet, &springs, environment](const Poses& poses, std::vector<Load>& loads) {
    for (std::size_t i = 0; i < poses.size(); ++i) {
      loads[i] = springs.load(static_cast<int>(i), poses[i], 1);
    }
    addEnvironmentLoads(environment, sheet.bricks, poses, loads);
  };
}

/// Loads that push nothing.
inline void noLoads(const Poses&, std::vector<Load>& loads) {
  std::fill(loads.begin(), loads.end(), Load{});
}

/// Moves a sheet for so many seconds to a tolerance in time, no loads but those of its solver.
inline void advance(JoinedBricks& sheet, Extrapolation& extrapolation, double seconds) {
  StepReport report;
  const TimedLoads none = [](double, const Poses& poses, std::vector<Load>& loads) {
    noLoads(poses, loads);
  };
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
