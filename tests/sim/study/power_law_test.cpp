#include <cmath>

#include <gtest/gtest.h>

#include "sim/study/study.h"

namespace kirireel {
namespace {

TEST(PowerLaw, FindsTheExponentOfExactPoints) {
  std::vector<study::PowerPoint> points;
  for (const double x : {25.0, 100.0, 400.0}) points.push_back({x, 3 * std::pow(x, 1.36)});
  EXPECT_NEAR(study::fittedExponent(points), 1.36, 1e-12);  // measured 2e-16
}

TEST(PowerLaw, HasNoneForOnePoint) {
  EXPECT_TRUE(std::isnan(study::fittedExponent({{25, 1}})));
  EXPECT_TRUE(std::isnan(study::fittedExponent({})));
}

}  // namespace
}  // namespace kirireel
