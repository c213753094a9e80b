// Symmetry groups against closed forms, and the means of states under them.
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/model/isometry.h"

namespace kirireel {
namespace {

model::Model sheet(int columns, int rows) {
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = rows;
  return generate::makeTessellation(shape);
}

Poses randomPoses(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  const auto share = [&] { return random() / 4294967296.0 - 0.5; };
  Poses poses(count);
  for (Pose& pose : poses) {
    pose.position = Vector3(share(), share(), share());
    pose.rotation = rotationFromVector(Vector3(share(), share(), share()));
  }
  return poses;
}

Matrix3 product(const model::Symmetry& a, const model::Symmetry& b) {
  return a.turn * b.turn;
}

/// Neighbouring squares turn in opposite senses, and a reflection reverses each sense. A symmetry
/// of the open sheet maps neighbours of one sense to neighbours of one sense. An odd sheet
/// therefore has its quarter turns, and an even one the reflections that exchange both senses.
TEST(Symmetry, RotatingSquaresHaveTheIsometriesThatKeepEachSense) {
  EXPECT_EQ(model::symmetriesOf(sheet(3, 3)).size(), 4u);
  EXPECT_EQ(model::symmetriesOf(sheet(4, 4)).size(), 4u);
  EXPECT_EQ(model::symmetriesOf(sheet(4, 3)).size(), 2u);
}

TEST(Symmetry, AClosedSheetHasThoseOfItsOutlineThatKeepItsJoints) {
  model::Model model = sheet(3, 3);
  model.target.reset();
  for (const model::Symmetry& symmetry : model::symmetriesOf(model)) {
    EXPECT_LE((symmetry.turn * symmetry.turn.transpose() - Matrix3::Identity()).norm(), 1e-14);
    EXPECT_EQ(symmetry.turn(2, 2), 1);  // bricks stay on their side of the sheet
  }
}

TEST(Symmetry, TheIsometriesAreAGroup) {
  const std::vector<model::Symmetry> group = model::symmetriesOf(sheet(3, 3));
  for (const model::Symmetry& a : group) {
    for (const model::Symmetry& b : group) {
      const bool isThere = std::ranges::any_of(
          group, [&](const model::Symmetry& c) { return (c.turn - product(a, b)).norm() < 1e-9; });
      EXPECT_TRUE(isThere);
    }
  }
}

/// Odd sheets have the four quarter turns, even ones two reflections and their product. All images
/// of tiles under products of the generators are found here by their permutations.
TEST(Symmetry, ProductsOfTheGeneratorsAreTheGroup) {
  for (const auto& [size, count] : {std::pair(3, 1u), {4, 2u}}) {
    const std::vector<model::Symmetry> group = model::symmetriesOf(sheet(size, size));
    const std::vector<model::Symmetry> generators = model::generatorsOf(group);
    EXPECT_EQ(generators.size(), count);
    std::set<std::vector<int>> images = {group.front().images};
    for (bool isNew = true; isNew;) {
      const std::set<std::vector<int>> before = images;
      for (std::vector<int> image : before) {
        for (const model::Symmetry& generator : generators) {
          std::vector<int> next;
          for (const int tile : image)
            next.push_back(generator.images[static_cast<std::size_t>(tile)]);
          images.insert(next);
        }
      }
      isNew = images.size() > before.size();
    }
    EXPECT_EQ(images.size(), group.size());
  }
}

TEST(Symmetry, WithADisplacedTileOnlyTheIdentityRemains) {
  model::Model model = sheet(3, 3);
  for (Vector3& vertex : model.tiles.front().vertices) vertex.x() += 1e-6;
  EXPECT_EQ(model::symmetriesOf(model).size(), 1u);
  model::Model unlike = sheet(3, 3);
  unlike.joints.pop_back();
  EXPECT_EQ(model::symmetriesOf(unlike).size(), 1u);
}

TEST(Symmetry, MeansHaveAllSymmetriesAndDoNotChange) {
  const model::Model model = sheet(4, 4);
  const std::vector<model::Symmetry> group = model::symmetriesOf(model);
  const Poses random = randomPoses(model.tiles.size(), 3);
  EXPECT_GT(model::asymmetry(random, group, 1), 0.1);
  const Poses mean = model::symmetricMean(random, group);
  EXPECT_LE(model::asymmetry(mean, group, 1), 1e-14);  // measured: 8e-16
  const Poses again = model::symmetricMean(mean, group);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    EXPECT_LE((again[i].position - mean[i].position).norm(), 1e-15);
    EXPECT_LE(turnBetween(again[i].rotation, mean[i].rotation).norm(), 1e-14);
  }
}

/// The velocities of the mean of two motions a moment apart are the difference of their means.
TEST(Symmetry, VelocitiesAreAveragedAsTheStatesThatTheyLeadTo) {
  const model::Model model = sheet(4, 4);
  const std::vector<model::Symmetry> group = model::symmetriesOf(model);
  const Poses state = model::symmetricMean(randomPoses(model.tiles.size(), 3), group);
  const Poses rates = randomPoses(model.tiles.size(), 4);
  std::vector<Velocity> velocities;
  for (const Pose& rate : rates) {
    velocities.push_back({rate.position, turnBetween(Quaternion::Identity(), rate.rotation)});
  }
  Vector3 drift = Vector3::Zero();
  for (const Velocity& velocity : velocities) {
    drift += velocity.linear / static_cast<double>(velocities.size());
  }
  constexpr double kMoment = 1e-6;
  Poses moved = state;
  for (std::size_t i = 0; i < moved.size(); ++i) {
    velocities[i].linear -= drift;  // the mean does not move the centre
    moved[i].position += kMoment * velocities[i].linear;
    moved[i].rotation = rotationFromVector(kMoment * velocities[i].angular) * moved[i].rotation;
  }
  const Poses mean = model::symmetricMean(moved, group);
  const std::vector<Velocity> averaged = model::symmetricMean(velocities, group);
  for (std::size_t i = 0; i < mean.size(); ++i) {
    const Vector3 linear = (mean[i].position - state[i].position) / kMoment;
    const Vector3 angular = turnBetween(state[i].rotation, mean[i].rotation) / kMoment;
    EXPECT_LE((linear - averaged[i].linear).norm(), 1e-8);  // measured: 1e-10
    EXPECT_LE((angular - averaged[i].angular).norm(), 1e-5);
  }
}

/// A sheet whose vertices are moved by up to `part` of a metre, at the start and the target.
model::Model perturbed(double part) {
  model::Model model = sheet(3, 3);
  std::mt19937 random(7);
  const auto share = [&] { return random() / 4294967296.0 - 0.5; };
  for (std::vector<model::Tile>* tiles : {&model.tiles, &*model.target}) {
    for (model::Tile& tile : *tiles) {
      for (Vector3& vertex : tile.vertices) vertex += part * Vector3(share(), share(), 0);
    }
  }
  return model;
}

/// The largest distance of a vertex from the nearest one of its image under any isometry, metres.
double farthestImage(const std::vector<model::Tile>& tiles,
                     const std::vector<model::Symmetry>& group) {
  Vector3 centre = Vector3::Zero();
  for (const model::Tile& tile : tiles) centre += model::tileCentroid(tile) / double(tiles.size());
  double farthest = 0;
  for (const model::Symmetry& symmetry : group) {
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      for (const Vector3& vertex : tiles[i].vertices) {
        const Vector3 image = centre + symmetry.turn * (vertex - centre);
        double nearest = 1;
        for (const Vector3& corner : tiles[std::size_t(symmetry.images[i])].vertices) {
          nearest = std::min(nearest, (corner - image).norm());
        }
        farthest = std::max(farthest, nearest);
      }
    }
  }
  return farthest;
}

TEST(Symmetry, NearlySymmetricTilesBecomeSymmetricToRounding) {
  model::Model model = perturbed(2e-10);
  const std::vector<model::Symmetry> exact = model::symmetriesOf(sheet(3, 3));
  ASSERT_EQ(model::symmetriesOf(model).size(), exact.size());
  EXPECT_GT(farthestImage(model.tiles, exact), 1e-10);
  const model::Model before = model;
  model::symmetrise(model);
  const std::vector<model::Symmetry> group = model::symmetriesOf(model);
  EXPECT_LT(farthestImage(model.tiles, group), 1e-14);    // measured: 1e-15
  EXPECT_LT(farthestImage(*model.target, group), 1e-14);  // 1e-15
  for (std::size_t i = 0; i < model.tiles.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_LT((model.tiles[i].vertices[k] - before.tiles[i].vertices[k]).norm(), 5e-10);
      EXPECT_EQ(model.tiles[i].vertices[k].z(), before.tiles[i].vertices[k].z());
    }
  }
}

TEST(Symmetry, SymmetricAndRoundedTilesStayAsTheyAre) {
  model::Model symmetric = sheet(3, 3), rounded = perturbed(2e-10);
  rounded.rounding = 1e-9;
  for (model::Model* model : {&symmetric, &rounded}) {
    const model::Model before = *model;
    model::symmetrise(*model);
    for (std::size_t i = 0; i < model->tiles.size(); ++i) {
      EXPECT_EQ(model->tiles[i].vertices, before.tiles[i].vertices);
    }
  }
}

TEST(Symmetry, IsometriesOfNearlySymmetricTilesAreAGroupToRounding) {
  const std::vector<model::Symmetry> group = model::symmetriesOf(perturbed(2e-10));
  for (const model::Symmetry& a : group) {
    for (const model::Symmetry& b : group) {
      double nearest = 1;
      for (const model::Symmetry& c : group)
        nearest = std::min(nearest, (product(a, b) - c.turn).norm());
      EXPECT_LT(nearest, 1e-14);  // measured: 1e-15
    }
  }
}

}  // namespace
}  // namespace kirireel
