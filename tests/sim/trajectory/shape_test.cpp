#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Eigenvalues>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sim/generate/lattice.h"
#include "sim/trajectory/array_file.h"
#include "sim/trajectory/run_curves.h"
#include "tests/support/files.h"
#include "tests/support/layouts.h"
#include "tests/support/trajectories.h"

namespace kirireel {
namespace {

constexpr int kColumns = 6, kRows = 4;
constexpr double kTolerance = 1e-9;

/// Rotating squares of side 1, each turned by `turn` in either sense, against their closed forms
/// (Grima and Evans, J. Mater. Sci. Lett. 19, 2000): each fills a box of side cos + sin.
struct RotatingSquares {
  explicit RotatingSquares(double halfOpening)
      : turn(halfOpening),
        tiles(generate::tessellationTiles(test::squares(kColumns, kRows, 0), 2 * halfOpening)) {}

  double cell() const { return std::cos(turn) + std::sin(turn); }
  /// The box without a triangle at each corner, whose sides are sin and cos.
  double hullArea() const {
    return kColumns * kRows * cell() * cell() - 2 * std::sin(turn) * std::cos(turn);
  }
  double hullPerimeter() const { return 2 * (kColumns + kRows) * cell() - 4 * cell() + 4; }

  double turn;
  std::vector<model::Tile> tiles;
};

TEST(Shape, OfRotatingSquaresIsThatOfTheirClosedForms) {
  const std::vector<model::Tile> start = RotatingSquares(0).tiles;
  for (const double turn : {0.0, 0.1, 0.3, 0.6, 0.785}) {
    const RotatingSquares squares(turn);
    const Vector3 sides = trajectory::boxSides(squares.tiles);
    const double width = std::max(sides.x(), sides.y()), height = std::min(sides.x(), sides.y());
    EXPECT_NEAR(width, kColumns * squares.cell(), kTolerance);  // measured 2e-15
    EXPECT_NEAR(height, kRows * squares.cell(), kTolerance);
    const trajectory::HullSize hull = trajectory::hullSize(squares.tiles);
    EXPECT_NEAR(hull.area, squares.hullArea(), kTolerance);  // measured 1e-14
    EXPECT_NEAR(hull.perimeter, squares.hullPerimeter(), kTolerance);
    EXPECT_NEAR(*trajectory::coveredArea(squares.tiles), kColumns * kRows, kTolerance);
    if (turn > 0) {
      EXPECT_NEAR(*trajectory::poissonsRatio(start, squares.tiles), -1, kTolerance);
    }  // measured 7e-16
  }
  EXPECT_FALSE(trajectory::poissonsRatio(start, start));
}

// Centres move by an affine map, tiles turn about them: only the map's strain counts, in the axes
// of the start. Neither a rotation of all nor protruding tiles at the border change it.
TEST(Shape, PoissonsRatioIsThatOfTheCentresMap) {
  const std::vector<model::Tile> start = RotatingSquares(0).tiles;
  const double shear = 0.1;
  Matrix3 strain;
  strain << 0.2, shear, 0, shear, -0.07, 0, 0, 0, 0;
  const Eigen::SelfAdjointEigenSolver<Matrix3> axes(strain);
  const Matrix3 stretch = axes.eigenvectors() *
                          axes.eigenvalues().array().exp().matrix().asDiagonal() *
                          axes.eigenvectors().transpose();
  const Matrix3 map = rotationFromVector({0, 0, 0.8}).toRotationMatrix() * stretch;
  std::vector<model::Tile> now = start;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const Vector3 centre = 0.25 * (start[k].vertices[0] + start[k].vertices[1] +
                                   start[k].vertices[2] + start[k].vertices[3]);
    const double turn = std::sin(3.0 * static_cast<double>(k));
    const Quaternion own = rotationFromVector({0, 0, turn});
    for (Vector3& vertex : now[k].vertices) vertex = map * centre + own * (vertex - centre);
  }
  EXPECT_NEAR(*trajectory::poissonsRatio(start, now), 0.07 / 0.2, kTolerance);
  const std::vector<model::Tile> row(start.begin(), start.begin() + 2);
  EXPECT_FALSE(trajectory::poissonsRatio(row, row));  // centres on a line
}

model::Tile polygon(const std::vector<Vector3>& corners) {
  return {corners};
}

TEST(Shape, CountsOverlapsOfTilesOnce) {
  // A unit square and the same moved by (0.5, 0.25) overlap by 0.5 x 0.75. A third is separate, a
  // fourth lies within the first, clockwise.
  const model::Tile square = polygon({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  model::Tile moved = square, apart = square;
  for (Vector3& vertex : moved.vertices) vertex += Vector3(0.5, 0.25, 0);
  for (Vector3& vertex : apart.vertices) vertex += Vector3(5, 0, 0);
  const model::Tile within = polygon({{0.2, 0.2, 0}, {0.2, 0.4, 0}, {0.4, 0.2, 0}});
  EXPECT_NEAR(*trajectory::coveredArea({square, moved, apart, within}), 3 - 0.375, 1e-14);
  // A star of two triangles: 12 small triangles, of which each big one has 9.
  std::vector<model::Tile> star;
  for (const double first : {0.3, 0.3 + std::numbers::pi / 3}) {
    model::Tile& triangle = star.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const double angle = first + 2 * std::numbers::pi / 3 * k;
      triangle.vertices.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
  }
  const double whole = 0.75 * std::sqrt(3);
  EXPECT_NEAR(*trajectory::coveredArea(star), whole * 12 / 9, 1e-14);
  // Concave: two crosses, one moved along its bar by half a cell.
  const model::Tile cross = polygon({{1, 0, 0},
                                     {2, 0, 0},
                                     {2, 1, 0},
                                     {3, 1, 0},
                                     {3, 2, 0},
                                     {2, 2, 0},
                                     {2, 3, 0},
                                     {1, 3, 0},
                                     {1, 2, 0},
                                     {0, 2, 0},
                                     {0, 1, 0},
                                     {1, 1, 0}});
  model::Tile shifted = cross;
  for (Vector3& vertex : shifted.vertices) vertex.x() += 0.5;
  // The bars add half a cell, each of two arms half a cell.
  EXPECT_NEAR(*trajectory::coveredArea({cross, shifted}), 5 + 0.5 + 2 * 0.5, 1e-14);
}

// Second method: counting points of a fine grid, for random tiles in a heap.
TEST(Shape, AgreesWithCountsOnAGrid) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  std::vector<model::Tile> tiles;
  for (int i = 0; i < 12; ++i) {
    const Vector3 middle(anywhere(random), anywhere(random), 0);
    model::Tile& tile = tiles.emplace_back();
    const int corners = 3 + i % 4;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * k / corners + middle.x();
      tile.vertices.push_back(middle + 0.5 * Vector3(std::cos(angle), std::sin(angle), 0));
    }
  }
  const auto isIn = [](const model::Tile& tile, double x, double y) {
    for (std::size_t k = 0; k < tile.vertices.size(); ++k) {
      const Vector3 &from = tile.vertices[k], &to = tile.vertices[(k + 1) % tile.vertices.size()];
      if ((to.x() - from.x()) * (y - from.y()) < (to.y() - from.y()) * (x - from.x())) return false;
    }
    return true;
  };
  constexpr int kPoints = 800;
  long covered = 0;
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j) {
      const double x = -2 + 4 * (i + 0.5) / kPoints, y = -2 + 4 * (j + 0.5) / kPoints;
      covered += std::ranges::any_of(tiles, [&](const auto& tile) { return isIn(tile, x, y); });
    }
  }
  const double area = 16.0 * static_cast<double>(covered) / (kPoints * kPoints);
  EXPECT_NEAR(*trajectory::coveredArea(tiles) / area, 1, 1e-3);
}

TEST(Shape, IsUnknownInSpace) {
  std::vector<model::Tile> tiles = RotatingSquares(0.1).tiles;
  tiles[0].vertices[0].z() += 0.1;
  EXPECT_FALSE(trajectory::coveredArea(tiles));
}

/// The run of the squares from closed to an opening of `end`, radians, at an even pace in 1 s.
trajectory::Trajectory openingSquares(double end, int samples) {
  trajectory::Trajectory run;
  run.model = generate::makeTessellation(test::squares(kColumns, kRows, 0));
  run.model.target.reset();
  run.bricks = brick::makeBricks(run.model.tiles, run.brickRule);
  for (int k = 0; k < samples; ++k) {
    trajectory::Sample sample;
    sample.time = static_cast<double>(k) / (samples - 1);
    const double opening = end * sample.time;
    const std::vector<model::Tile> tiles =
        generate::tessellationTiles(test::squares(kColumns, kRows, 0), opening);
    for (std::size_t t = 0; t < tiles.size(); ++t) {
      const Vector3 side = tiles[t].vertices[1] - tiles[t].vertices[0];
      const Vector3 shut = run.model.tiles[t].vertices[1] - run.model.tiles[t].vertices[0];
      const double turn = std::atan2(shut.cross(side).z(), shut.dot(side));
      const Vector3 middle(0, 0, 0.5 * run.brickRule.thickness);
      sample.poses.push_back(
          {model::tileCentroid(tiles[t]) + middle, rotationFromVector({0, 0, turn})});
    }
    run.samples.push_back(sample);
  }
  return run;
}

const trajectory::Curve& curveNamed(const trajectory::RunCurves& curves,
                                    const std::string& column) {
  for (const trajectory::CurveGroup& group : curves.groups) {
    for (const trajectory::Curve& curve : group.curves) {
      if (curve.column == column) return curve;
    }
  }
  throw std::out_of_range(column);
}

class RunCurvesOfSquares : public testing::Test {
 protected:
  static constexpr double kEnd = 1.4;
  static constexpr int kSamples = 41;

  RunCurvesOfSquares() {
    test::writeTrajectory(openingSquares(kEnd, kSamples), folder_ / "trajectory.h5");
    curves_ = trajectory::curvesOf(trajectory::TrajectoryReader(folder_ / "trajectory.h5"));
  }

  double at(const char* column, int sample) const {
    return curveNamed(curves_, column).values.at(sample);
  }

  test::TemporaryFolder folder_;
  trajectory::RunCurves curves_;
};

TEST_F(RunCurvesOfSquares, AreThoseOfTheirClosedForms) {
  for (int k = 0; k < kSamples; ++k) {
    const double opening = kEnd * k / (kSamples - 1);
    const RotatingSquares squares(0.5 * opening);
    const double width = std::max(at("width_m", k), at("height_m", k));
    EXPECT_NEAR(width, kColumns * squares.cell(), kTolerance);
    EXPECT_NEAR(at("hull_area_m2", k), squares.hullArea(), kTolerance);
    EXPECT_NEAR(at("hull_perimeter_m", k), squares.hullPerimeter(), kTolerance);
    EXPECT_NEAR(at("covered_area_m2", k), kColumns * kRows, kTolerance);
    for (const trajectory::Curve& joint : curves_.joints) {
      EXPECT_NEAR(joint.values.at(k) * kDegree, opening, kTolerance);  // measured 1e-15
    }
    EXPECT_NEAR(at("radius_exact_m", k), at("radius_m", k), kTolerance);  // measured 1e-15
    EXPECT_LT(at("shape_error_m", k), kTolerance);                        // measured 5e-15
    EXPECT_LE(at("shape_error_mean_m", k), at("shape_error_m", k));
    EXPECT_NEAR(at("porosity", k), 1 - kColumns * kRows / squares.hullArea(), kTolerance);
    for (const char* column : {"opening_least_deg", "opening_mean_deg", "opening_largest_deg"}) {
      EXPECT_NEAR(at(column, k) * kDegree, opening, kTolerance);  // measured 1e-15
    }
    if (k > 0) {
      EXPECT_NEAR(at("poissons_ratio", k), -1, kTolerance);
    }
    if (k == 0) {
      EXPECT_TRUE(std::isnan(at("poissons_ratio", k)));
    }
  }
}

/// A tile that moved away by itself, in the middle of the sheet.
TEST_F(RunCurvesOfSquares, ShowDistancesFromTheExactMotion) {
  trajectory::Trajectory run = openingSquares(kEnd, kSamples);
  run.samples.back().poses[9].position.x() += 0.01;
  test::writeTrajectory(run, folder_ / "moved.h5");
  const trajectory::RunCurves moved =
      trajectory::curvesOf(trajectory::TrajectoryReader(folder_ / "moved.h5"));
  const double tiles = kColumns * kRows;
  // The best fit moves with the tile by its part of the sheet.
  EXPECT_NEAR(curveNamed(moved, "shape_error_m").values.back(), 0.01 * (1 - 1 / tiles), 1e-4);
  EXPECT_NEAR(curveNamed(moved, "shape_error_mean_m").values.back(), 0.02 / tiles, 2e-4);
}

TEST_F(RunCurvesOfSquares, HaveTheUnitOfTheModel) {
  trajectory::Trajectory run = openingSquares(kEnd, kSamples);
  run.model.unit = *findLengthUnit("mm");
  test::writeTrajectory(run, folder_ / "mm.h5");
  const trajectory::RunCurves inMillimetres =
      trajectory::curvesOf(trajectory::TrajectoryReader(folder_ / "mm.h5"));
  const auto value = [&](const char* column) {
    return curveNamed(inMillimetres, column).values.back();
  };
  EXPECT_DOUBLE_EQ(value("width_mm"), 1e3 * at("width_m", kSamples - 1));
  EXPECT_DOUBLE_EQ(value("hull_area_mm2"), 1e6 * at("hull_area_m2", kSamples - 1));
  EXPECT_EQ(value("porosity"), at("porosity", kSamples - 1));
  EXPECT_EQ(inMillimetres.groups[0].unit, "mm");
  EXPECT_EQ(inMillimetres.groups[1].unit, "mm²");
}

TEST_F(RunCurvesOfSquares, AreChannelsOfTheTrajectory) {
  const trajectory::Trajectory run = openingSquares(kEnd, kSamples);
  const std::filesystem::path path = folder_ / "curves.h5";
  trajectory::TrajectoryWriter writer(path, run, trajectory::makeCurveMeter(run));
  for (const trajectory::Sample& sample : run.samples) writer.append(sample);
  writer.finish(run);
  const trajectory::ArrayReader file(path);
  EXPECT_EQ(file.doubles("curves/width"), curveNamed(curves_, "width_m").values);
  EXPECT_EQ(file.doubles("curves/opening_mean"), curveNamed(curves_, "opening_mean_deg").values);
  EXPECT_EQ(file.textAttribute("curves/hull_area", "unit"), "m^2");
  EXPECT_EQ(file.textAttribute("curves/porosity", "description"), "1 - covered / hull");
  EXPECT_EQ(file.shape("curves/opening"), (trajectory::Shape{kSamples, run.model.joints.size()}));
  for (std::size_t j = 0; j < run.model.joints.size(); ++j) {
    EXPECT_EQ(file.row("curves/opening", 7).at(j), curves_.joints.at(j).values.at(7));
  }
  // A path has neither energies nor forces.
  EXPECT_FALSE(trajectory::TrajectoryReader(path).hasMechanics());
  EXPECT_FALSE(file.has("energy"));
  EXPECT_EQ(curves_.joints.size(), run.model.joints.size());
}

TEST(RunCurves, HaveEnergiesAndForces) {
  trajectory::Trajectory run = openingSquares(1, 2);
  const std::size_t joints = run.model.joints.size();
  for (trajectory::Sample& sample : run.samples) {
    trajectory::Mechanics& mechanics = sample.mechanics.emplace();
    mechanics.energies = {1, 2, 0, 10, 3, 1.5};
    mechanics.jointForces.assign(joints, Vector3(3, 4, 0));
    mechanics.jointForces[0] = {0, 0, 30};
    mechanics.isIndeterminate.assign(joints, false);
    mechanics.isIndeterminate[1] = true;
    mechanics.holds = {
        {trajectory::HoldKind::Pin, 0, -1, Vector3(0, 6, 8), Vector3::Zero(), Vector3::Zero()},
        {trajectory::HoldKind::Pin, 1, -1, Vector3(1, 0, 0), Vector3::Zero(), Vector3::Zero()},
        {trajectory::HoldKind::Contact, 0, 3, Vector3(2, 0, 0), Vector3(), Vector3()}};
  }
  const test::TemporaryFolder folder;
  test::writeTrajectory(run, folder / "trajectory.h5");
  const trajectory::RunCurves curves =
      trajectory::curvesOf(trajectory::TrajectoryReader(folder / "trajectory.h5"));
  const auto last = [&](const char* column) { return curveNamed(curves, column).values.back(); };
  EXPECT_EQ(last("kinetic_energy_J"), 1);
  EXPECT_EQ(last("spring_energy_J"), 2);
  EXPECT_EQ(last("work_J"), 10);
  EXPECT_EQ(last("damped_J"), 3);
  EXPECT_EQ(last("impacted_J"), 1.5);
  EXPECT_EQ(last("integrated_J"), 2.5);
  EXPECT_EQ(last("joint_force_largest_N"), 30);
  EXPECT_NEAR(last("joint_force_mean_N"), 5 + 25.0 / static_cast<double>(joints), 1e-14);
  EXPECT_EQ(last("joint_force_indeterminate_N"), 5);
  EXPECT_EQ(last("pin_force_N"), 10);
  EXPECT_TRUE(std::isnan(last("grip_force_N")));
  EXPECT_EQ(last("contact_force_N"), 2);
  // Openings first, then a force and its mark for each joint.
  ASSERT_EQ(curves.joints.size(), 3 * joints);
  EXPECT_EQ(curves.joints[joints + 2].column, "joint_force_1_N");
  EXPECT_EQ(curves.joints[joints + 2].values.back(), 5);
  EXPECT_EQ(curves.joints[joints + 3].column, "joint_force_1_indeterminate");
  EXPECT_EQ(curves.joints[joints + 3].values.back(), 1);
}

// A kinematic path has no energies, because its playback speed is arbitrary.
TEST_F(RunCurvesOfSquares, HaveNoKineticEnergyWithoutDynamics) {
  for (const double value : curveNamed(curves_, "kinetic_energy_J").values) {
    EXPECT_TRUE(std::isnan(value));
  }
}

TEST_F(RunCurvesOfSquares, AreStraightBetweenSamples) {
  const trajectory::RunCurves between = trajectory::curvesAt(curves_, {0, 0.0125, 0.025, 1});
  const trajectory::Curve width = curveNamed(between, "width_m");
  EXPECT_EQ(width.values[0], at("width_m", 0));
  EXPECT_NEAR(width.values[1], 0.5 * (at("width_m", 0) + at("width_m", 1)), 1e-14);
  EXPECT_EQ(width.values[3], at("width_m", kSamples - 1));
  EXPECT_TRUE(std::isnan(curveNamed(between, "target_error_m").values[1]));
  EXPECT_FALSE(between.groups[11].hasLine());
}

}  // namespace
}  // namespace kirireel
