#include "render/record/load_curve_file.h"

#include <cmath>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "sim/trajectory/array_file.h"
#include "tests/support/files.h"

namespace kirireel {
namespace {

/// Random numbers, in which any lost digit is noticed.
mechanics::LoadCurve randomCurve() {
  std::mt19937_64 generator(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  mechanics::LoadCurve curve{{{"grip 1 x"}, {"grip 2 turn", true}}, 1, {}};
  for (const mechanics::Turning turning :
       {mechanics::Turning::None, mechanics::Turning::LoadLimit, mechanics::Turning::Bifurcation}) {
    mechanics::Equilibrium& state = curve.states.emplace_back();
    state.load = uniform(generator);
    state.energy = uniform(generator);
    state.stiffness = std::numeric_limits<double>::infinity();
    state.displacements = {uniform(generator), uniform(generator)};
    state.forces = {uniform(generator), uniform(generator)};
    state.unstableModes = static_cast<int>(turning);
    state.turning = turning;
  }
  return curve;
}

/// A file with content, as of a finished run.
void writeOther(const std::filesystem::path& file) {
  trajectory::ArrayWriter writer(file, file);
  writer.write("time", std::vector<double>{0, 1}, {2});
  writer.close();
}

TEST(LoadCurveFile, GivesBackEveryBit) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "run.h5", again = folder / "again.h5";
  const mechanics::LoadCurve curve = randomCurve();
  for (const std::filesystem::path& path : {file, again}) {
    writeOther(path);
    record::addLoadCurve(path, curve);
  }
  EXPECT_EQ(test::bytesOf(file), test::bytesOf(again));
  EXPECT_THAT(trajectory::ArrayReader(file).doubles("time"), testing::ElementsAre(0, 1));
  const std::optional<mechanics::LoadCurve> read = record::readLoadCurve(file);
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->leading, 1u);
  ASSERT_EQ(read->grips.size(), 2u);
  EXPECT_EQ(read->grips[1].name, "grip 2 turn");
  EXPECT_TRUE(read->grips[1].isTurn);
  EXPECT_FALSE(read->grips[0].isTurn);
  ASSERT_EQ(read->states.size(), curve.states.size());
  for (std::size_t k = 0; k < curve.states.size(); ++k) {
    const mechanics::Equilibrium &a = curve.states[k], &b = read->states[k];
    EXPECT_EQ(a.load, b.load);
    EXPECT_EQ(a.energy, b.energy);
    EXPECT_EQ(a.stiffness, b.stiffness);
    EXPECT_EQ(a.displacements, b.displacements);
    EXPECT_EQ(a.forces, b.forces);
    EXPECT_EQ(a.unstableModes, b.unstableModes);
    EXPECT_EQ(a.turning, b.turning);
  }
}

TEST(LoadCurveFile, IsAbsentWithoutGrips) {
  const test::TemporaryFolder folder;
  writeOther(folder / "run.h5");
  EXPECT_FALSE(record::readLoadCurve(folder / "run.h5").has_value());
}

TEST(LoadCurveFile, RefusesArraysThatDisagree) {
  const test::TemporaryFolder folder;
  writeOther(folder / "run.h5");
  mechanics::LoadCurve curve = randomCurve();
  curve.leading = 2;
  record::addLoadCurve(folder / "run.h5", curve);
  try {
    record::readLoadCurve(folder / "run.h5");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("the leading grip of load_curve does not exist"));
  }
}

}  // namespace
}  // namespace kirireel
