#include "sim/generate/constrained_fit.h"

#include <cmath>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

TEST(ConstrainedFit, FindsThePointOfACircleNearestToAPoint) {
  // Closed form: the point of the unit circle in the direction of (0.66, 0.88).
  const auto source = [](const Eigen::VectorXd& x, generate::DesignEquations& equations) {
    for (const int k : {0, 1}) {
      equations.desired.begin(x[k] - (k == 0 ? 0.66 : 0.88));
      equations.desired.slope(k, 1);
    }
    equations.exact.begin(x.squaredNorm() - 1);
    for (const int k : {0, 1}) equations.exact.slope(k, 2 * x[k]);
  };
  const generate::Fit fit = generate::fitDesign(source, Eigen::Vector2d(1, 0.1), {});
  EXPECT_NEAR(fit.unknowns[0], 0.6, 1e-7);  // measured 2e-10
  EXPECT_NEAR(fit.unknowns[1], 0.8, 1e-7);
  EXPECT_LT(fit.violation, 1e-13);  // measured 0
}

TEST(ConstrainedFit, AllowsRepeatedEquations) {
  const auto source = [](const Eigen::VectorXd& x, generate::DesignEquations& equations) {
    equations.desired.begin(x[0]);
    equations.desired.slope(0, 1);
    for (const double scale : {1.0, 2.0, 1.0}) {
      equations.exact.begin(scale * (x[0] + x[1] - 2));
      equations.exact.slope(0, scale);
      equations.exact.slope(1, scale);
    }
  };
  const generate::Fit fit = generate::fitDesign(source, Eigen::Vector2d(5, 5), {});
  EXPECT_NEAR(fit.unknowns[0], 0, 1e-7);
  EXPECT_NEAR(fit.unknowns[1], 2, 1e-7);
  EXPECT_LT(fit.violation, 1e-13);
}

TEST(ConstrainedFit, ReportsWhenEquationsContradictEachOther) {
  const auto source = [](const Eigen::VectorXd& x, generate::DesignEquations& equations) {
    for (const double value : {1.0, 2.0}) {
      equations.exact.begin(x[0] - value);
      equations.exact.slope(0, 1);
    }
  };
  EXPECT_GT(generate::fitDesign(source, Eigen::VectorXd::Zero(1), {}).violation, 0.4);
}

}  // namespace
}  // namespace kirireel
