// Energies and moments of panels. Oracles: closed forms, sums over tiles.
#include "sim/trajectory/panels.h"

#include <algorithm>
#include <numeric>

#include <gtest/gtest.h>

namespace kirireel {
namespace {

/// A square of two triangles that bends at its diagonal, and a triangle at one of its sides.
trajectory::LoadedPanels squareAndTriangle() {
  trajectory::LoadedPanels sheet;
  sheet.tileNodes = {{0, 1, 2, 3}, {2, 1, 4}};
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {2, 3}, {0, 3}, {0, 2}, {1, 4}, {2, 4}}) {
    sheet.bars.push_back({a, b, 2, 10});
  }
  sheet.folds = {{{0, 2, 3, 1}, 3, 0.25, {0, 0}}, {{1, 2, 0, 4}, 5, 0, {0, 1}}};
  const std::vector<Vector3> nodes(5, Vector3::Zero());
  sheet.states = {{0, nodes, std::vector<double>(7, 0), {0.25, 0}},
                  {2, nodes, {0.1, 0.2, 0, 0, -0.1, 0, 0.3}, {0.75, -0.4}}};
  return sheet;
}

// A bar holds k (e l)^2 / 2 = 20 e^2, the folds 1.5 * 0.5^2 and 2.5 * 0.4^2.
TEST(Panels, HaveTheEnergyOfBarsAndFolds) {
  const trajectory::LoadedPanels sheet = squareAndTriangle();
  EXPECT_EQ(sheet.energy(sheet.states[0]), 0);
  EXPECT_NEAR(sheet.energy(sheet.states[1]), 20 * 0.15 + 0.375 + 0.4, 1e-14);
  const std::vector<double> end = sheet.tileEnergies(2);
  ASSERT_EQ(end.size(), 2u);
  // The bar and the fold between the two tiles count half for each.
  EXPECT_NEAR(end[0], 20 * 0.02 + 10 * 0.04 + 0.375 + 0.2, 1e-14);
  EXPECT_NEAR(end[1], 20 * 0.09 + 10 * 0.04 + 0.2, 1e-14);
}

TEST(Panels, AreLinearBetweenTheirStates) {
  const trajectory::LoadedPanels sheet = squareAndTriangle();
  for (const double time : {-1.0, 0.0, 0.5, 2.0, 3.0}) {
    const std::vector<double> energies = sheet.tileEnergies(time);
    EXPECT_NEAR(std::accumulate(energies.begin(), energies.end(), 0.0),
                std::clamp(time / 2, 0.0, 1.0) * sheet.energy(sheet.states[1]), 1e-14);
  }
}

TEST(Panels, HaveTheLargestMomentOfTheirFolds) {
  const trajectory::LoadedPanels sheet = squareAndTriangle();
  EXPECT_EQ(sheet.tileMoments(0), (std::vector<double>{0, 0}));
  EXPECT_EQ(sheet.tileMoments(2), (std::vector<double>{2, 2}));  // 5 * 0.4, over 3 * 0.5
  brick::Elasticity elasticity{{{"springs", 1}}, 7, 7, 7};
  trajectory::setElasticity(sheet, elasticity);
  EXPECT_EQ(elasticity.count("springs"), 1);
  EXPECT_EQ(elasticity.count("bars"), 7);
  EXPECT_EQ(elasticity.count("folds"), 2);
  EXPECT_EQ(elasticity.energyStart, 0);
  EXPECT_EQ(elasticity.energyEnd, sheet.energy(sheet.states[1]));
  EXPECT_EQ(elasticity.momentEnd, 2);
}

}  // namespace
}  // namespace kirireel
