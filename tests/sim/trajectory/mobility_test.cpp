#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "sim/formats/read_model.h"
#include "sim/generate/lattice.h"
#include "sim/trajectory/sheet.h"

namespace kirireel {
namespace {

constexpr double kThickness = 0.02;

model::Model tessellation(int columns, int rows, double angle,
                          model::JointFace face = model::JointFace::Both) {
  generate::TessellationShape shape;
  shape.columns = columns;
  shape.rows = rows;
  shape.startAngle = angle;
  shape.face = face;
  return generate::makeTessellation(shape);
}

int planarFreedoms(const model::Model& model) {
  return trajectory::mobility(model, model.tiles, trajectory::Freedom::Plane, kThickness).freedoms;
}

/// Central differences of the joints' gaps over poses, and the rank by a full-pivot factorisation.
/// Only the definition is shared with the measure.
int rankByDifferences(const model::Model& model) {
  const int tiles = static_cast<int>(model.tiles.size());
  const auto gaps = [&](int unknown, double step) {
    std::vector<model::Tile> moved = model.tiles;
    const int tile = unknown / 6, axis = unknown % 6;
    const Vector3 centre = model::tileCentroid(moved[tile]);
    const Eigen::AngleAxisd turn(axis < 3 ? 0 : step, Vector3::Unit(axis % 3));
    const Vector3 shift = axis < 3 ? Vector3(step * Vector3::Unit(axis)) : Vector3::Zero();
    for (Vector3& vertex : moved[tile].vertices) vertex = centre + turn * (vertex - centre) + shift;
    Eigen::VectorXd all(6 * static_cast<int>(model.joints.size()));
    for (int j = 0; j < std::ssize(model.joints); ++j) {
      const model::Joint& joint = model.joints[j];
      const auto place = [&](const model::Corner& corner, double rise) {
        return Vector3(moved[corner.tile].vertices[corner.vertex] +
                       rise * model::tileNormal(moved[corner.tile]));
      };
      all.segment<3>(6 * j) = place(joint.a, 0) - place(joint.b, 0);
      all.segment<3>(6 * j + 3) = place(joint.a, kThickness) - place(joint.b, kThickness);
    }
    return all;
  };
  Eigen::MatrixXd jacobian(6 * static_cast<int>(model.joints.size()), 6 * tiles);
  for (int k = 0; k < 6 * tiles; ++k) {
    jacobian.col(k) = (gaps(k, 1e-5) - gaps(k, -1e-5)) / 2e-5;
  }
  Eigen::FullPivLU<Eigen::MatrixXd> factors(jacobian);
  factors.setThreshold(1e-7);
  return static_cast<int>(factors.rank());
}

TEST(Mobility, OpenTessellationHasOneFreedomInThePlane) {
  // Grima and Evans 2000: rotating squares are one mechanism, for any number of tiles.
  for (const auto& [columns, rows] : {std::pair(2, 2), {3, 5}, {10, 10}}) {
    EXPECT_EQ(planarFreedoms(tessellation(columns, rows, 0.8)), 1) << columns << " x " << rows;
  }
}

TEST(Mobility, ClosedTessellationIsSingular) {
  // Whole rows and columns of slits can start to open separately: columns + rows - 2.
  EXPECT_EQ(planarFreedoms(tessellation(10, 10, 0)), 18);
}

TEST(Mobility, LooseAndPairedTiles) {
  model::Model model = tessellation(2, 1, 0.5);
  EXPECT_EQ(planarFreedoms(model), 1);
  EXPECT_EQ(
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness).freedoms,
      1);  // a hinge
  model.joints[0].face = model::JointFace::Bottom;
  EXPECT_EQ(
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness).freedoms,
      3);  // a ball joint
  model.joints.clear();
  EXPECT_EQ(planarFreedoms(model), 3);
  EXPECT_EQ(
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness).freedoms, 6);
}

TEST(Mobility, LinksAndFixedJointsCount) {
  model::Model model = tessellation(2, 1, 0.5);
  model.joints = {model::makeLink(model.tiles, {0, 0}, {1, 1})};
  EXPECT_EQ(planarFreedoms(model), 2);
  EXPECT_EQ(
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness).freedoms, 5);
  model.joints = {model::makeFixedJoint(model.tiles, 0, 1)};
  EXPECT_EQ(planarFreedoms(model), 0);
  EXPECT_EQ(
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness).freedoms, 0);
}

TEST(Mobility, AgreesWithDifferencesInSpace) {
  for (const double angle : {0.0, 0.7}) {
    const model::Model model = tessellation(4, 3, angle);
    const trajectory::Mobility found =
        trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness);
    EXPECT_EQ(found.rank, rankByDifferences(model)) << angle;
    EXPECT_EQ(found.redundant, found.equations - found.rank);
  }
}

TEST(Mobility, SignCountsAgreeWithSingularValues) {
  // 20 x 20 tiles use the sparse method, and also have one freedom.
  const model::Model model = tessellation(20, 20, 0.8);
  const trajectory::Mobility found =
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Plane, kThickness);
  EXPECT_GT(found.unknowns, 900);
  EXPECT_EQ(found.freedoms, 1);
  EXPECT_GT(found.smallestKept, 10 * found.largestDropped);
  EXPECT_TRUE(found.areBounds);
}

TEST(Mobility, SpectrumHasAGap) {
  const model::Model model = tessellation(6, 6, 0.8);
  const trajectory::Mobility found =
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Plane, kThickness);
  EXPECT_GT(found.smallestKept, 1e-2);
  EXPECT_LT(found.largestDropped, 1e-13);
  EXPECT_FALSE(found.areBounds);
}

/// Moves the corners at each point of the plane together, at random by up to `most` along each
/// axis: a design whose joints close but whose lattice is not exact, as an optimiser leaves it.
model::Model withMisfit(model::Model model, double most) {
  std::mt19937 random(7);
  std::map<std::pair<long, long>, Vector3> moves;
  const auto next = [&] { return most * (2 * std::generate_canonical<double, 32>(random) - 1); };
  for (model::Tile& tile : model.tiles) {
    for (Vector3& vertex : tile.vertices) {
      const auto place = std::pair(std::lround(1e4 * vertex.x()), std::lround(1e4 * vertex.y()));
      if (!moves.contains(place)) moves[place] = Vector3(next(), next(), 0);
      vertex += moves[place];
    }
  }
  return model;
}

TEST(Mobility, DoesNotDependOnAMisfitOfTheTiles) {
  // The oracle is the exact lattice. 20 x 20 tiles use the sparse method. Singular values in space
  // without a misfit are at least 0.26.
  for (const auto& [size, angle] : {std::pair(4, 0.0), {6, 0.8}, {20, 0.8}}) {
    const model::Model exact = tessellation(size, size, angle);
    for (const auto freedom : {trajectory::Freedom::Plane, trajectory::Freedom::Space}) {
      if (size > 6 && freedom == trajectory::Freedom::Space) continue;
      const trajectory::Mobility expected =
          trajectory::mobility(exact, exact.tiles, freedom, kThickness);
      for (const double misfit : {1e-9, 1e-7, 1e-5}) {
        const model::Model model = withMisfit(exact, misfit);
        const trajectory::Mobility found =
            trajectory::mobility(model, model.tiles, freedom, kThickness);
        EXPECT_EQ(found.rank, expected.rank) << size << " " << misfit;
        EXPECT_TRUE(found.isCertain()) << size << " " << misfit;
        if (found.areBounds) continue;
        EXPECT_NEAR(found.smallestKept, expected.smallestKept, 10 * misfit)
            << size << " " << misfit;
      }
    }
  }
}

TEST(Mobility, DoesNotDependOnTheThickness) {
  const model::Model model = tessellation(4, 3, 0.7);
  const trajectory::Mobility expected =
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, kThickness);
  for (const double thickness : {1e-7, 1e-4, 1.0}) {
    const trajectory::Mobility found =
        trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, thickness);
    EXPECT_EQ(found.rank, expected.rank) << thickness;
    EXPECT_NEAR(found.smallestKept, expected.smallestKept, 1e-12) << thickness;
  }
}

TEST(Mobility, MatchesThePublishedModels) {
  const std::filesystem::path shared =
      std::filesystem::path(KIRIREEL_SOURCE_DIR) / "../shared/models";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << shared << " is not there";
  const std::pair<const char*, int> published[] = {
      {"square2disk", 8}, {"demo_nonrigid", 1}, {"stampfli24", 21}, {"quad_tessellation", 6}};
  for (const auto& [name, freedoms] : published) {
    std::vector<std::string> warnings;
    EXPECT_EQ(planarFreedoms(formats::readModelFolder(shared / name, warnings)), freedoms) << name;
  }
}

TEST(Mobility, OfTooManyTilesIsNotCounted) {
  generate::TessellationShape shape;
  shape.columns = shape.rows = 101;
  const model::Model model = generate::makeTessellation(shape);
  const trajectory::Mobility found =
      trajectory::mobility(model, model.tiles, trajectory::Freedom::Space, 0.02);
  EXPECT_FALSE(found.isCounted);
  EXPECT_EQ(found.unknowns, 6 * 101 * 101);
}

}  // namespace
}  // namespace kirireel
