// What `inspect` counts must not depend on how many digits a file has.
#include "render/report/inspection.h"

#include <gtest/gtest.h>

#include "sim/generate/lattice.h"

namespace kirireel {
namespace {

TEST(Inspection, CountsTheFreedomsInThePlaneOfRoundedSheets) {
  scene::Scene scene;
  scene.model = generate::makeTessellation({});
  const report::Inspection exact = report::inspect(scene);
  const Quaternion turn = rotationFromVector({0.4, -0.7, 1.1});
  for (std::vector<model::Tile>* state : {&scene.model.tiles, &*scene.model.target}) {
    for (model::Tile& tile : *state) {
      for (Vector3& v : tile.vertices) v = (turn * v).cast<float>().cast<double>();
    }
  }
  scene.model.rounding = 1e-6;
  const report::Inspection rounded = report::inspect(scene);
  ASSERT_TRUE(rounded.start.inPlane && rounded.target->inPlane);
  EXPECT_EQ(rounded.start.inPlane->freedoms, exact.start.inPlane->freedoms);
  EXPECT_EQ(rounded.target->inPlane->freedoms, exact.target->inPlane->freedoms);
}

}  // namespace
}  // namespace kirireel
