// Sheets written with three and four digits: they keep their mechanism and deploy.
#include <gtest/gtest.h>

#include "sim/deploy/deployment.h"
#include "sim/generate/families.h"
#include "sim/measure/mobility.h"
#include "sim/model/alignment.h"
#include "sim/model/rounding.h"

namespace kirireel {
namespace {

void roundTo(std::vector<Tile>& tiles, int places) {
  for (Tile& tile : tiles) {
    for (Vector3& v : tile.vertices) {
      for (double& x : v) x = std::stod(fmt::format("{:.{}f}", x, places));
    }
  }
}

/// The same sheet as a file with so many decimals holds it.
Model rounded(Model model, int places) {
  roundTo(model.tiles, places);
  if (model.target) roundTo(*model.target, places);
  model.rounding = roundingOf(model.tiles);
  return model;
}

/// A sheet with a seed: single mechanisms (open irregular quads) in turn with over-constrained
/// ones.
Model seededSheet(int seed) {
  switch (seed % 4) {
    case 0:
      return generateModel(familyNamed("quads"), {{"columns", 4},
                                                  {"rows", 4},
                                                  {"seed", seed},
                                                  {"start-angle", 20 + seed % 7},
                                                  {"target-angle", 80 + seed % 11}});
    case 1:
      return generateModel(familyNamed("tessellation"), {{"columns", 2 + seed % 3},
                                                         {"rows", 4},
                                                         {"length", 0.9 + 0.013 * seed},
                                                         {"skew", seed % 30},
                                                         {"start-angle", 17 + seed % 9},
                                                         {"target-angle", 77}});
    case 2:
      return generateModel(familyNamed("heart"),
                           {{"start-angle", 15 + seed % 13}, {"target-angle", 70 + seed % 17}});
    default:
      return generateModel(
          familyNamed("fan"),
          {{"columns", 4}, {"rows", 4}, {"start-angle", 20 + seed % 10}, {"target-angle", 90}});
  }
}

TEST(RoundedSheets, KeepTheirDegreesOfFreedom) {
  for (int seed = 0; seed < 100; ++seed) {
    const Model exact = seededSheet(seed);
    const Mobility wanted = mobility(exact, exact.tiles, Freedom::Plane, 0.02);
    for (const int places : {3, 4}) {
      const Model model = rounded(exact, places);
      EXPECT_NEAR(model.rounding, std::pow(10, -places), 1e-12) << seed;
      EXPECT_EQ(mobility(model, model.tiles, Freedom::Plane, 0.02).freedoms, wanted.freedoms)
          << "seed " << seed << ", " << places << " decimals";
    }
  }
}

TEST(RoundedSheets, OpenTheirJointsByTwoDigitsAtMost) {
  double worst = 0;
  for (int seed = 0; seed < 100; ++seed) {
    const int places = 3 + seed / 4 % 2;
    Scene scene = openScene();
    scene.model = rounded(seededSheet(seed), places);
    alignStartToTarget(scene.model);
    fillFromModel(scene);
    scene.path.searchTime = 2;
    const DeploymentResult run = deploy(scene, 1, nullptr);
    const double digit = std::pow(10, -places);
    const double opening = std::max(run.accuracy.jointGapMax, run.accuracy.jointOpeningMax);
    worst = std::max(worst, opening / digit);
    EXPECT_LE(opening, 2 * digit) << "seed " << seed << ": " << run.pathReason;
  }
  RecordProperty("worst_opening_in_digits", fmt::format("{:.3g}", worst));
}

}  // namespace
}  // namespace kirireel
